"""Least squares with rows of few entries side by side, by orthogonal rotations, on bare arrays.

Unknowns go around in a ring if there is a border: then the last ``border`` of them are kept apart,
so that a row has its entries near one place of the others and anywhere among those. The triangle R
has a row for each unknown: ``width`` numbers from the diagonal on, then its numbers in the border.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel


@kernel
def _rotate(
    triangle: FloatArray, right: FloatArray, index: FloatArray, x: FloatArray, y: FloatArray
) -> int:
    """Rotate a row x (right side y) into R at unknown ``index[0]``; give the last entry of x."""
    c, high, width = int(index[0]), int(index[1]), int(index[2])
    m = triangle.shape[0]
    border = triangle.shape[1] - width
    n = m - border
    at = 0 if c < n else width + c - n
    pivot, entry = triangle[c, at], x[c]
    size = math.sqrt(pivot * pivot + entry * entry)
    cosine, sine = pivot / size, entry / size
    triangle[c, at] = size
    for j in range(at + 1, triangle.shape[1]):
        column = c + j if j < width else n + j - width
        if j < width and column >= n:
            continue
        old, new = triangle[c, j], x[column]
        if old != 0.0 and j < width and column > high:
            high = column
        triangle[c, j] = cosine * old + sine * new
        x[column] = cosine * new - sine * old
    for d in range(right.shape[1]):
        old, new = right[c, d], y[d]
        right[c, d] = cosine * old + sine * new
        y[d] = cosine * new - sine * old
    x[c] = 0.0
    return high


@kernel
def factor(
    first: FloatArray,
    rows: FloatArray,
    values: FloatArray,
    triangle: FloatArray,
    right: FloatArray,
) -> int:
    """Write R and the turned right sides of a least squares problem; both come as zeros.

    Args:
        first: Column of each row's first entry, shape (k,); best never falling.
        rows: Entries of each row, side by side, shape (k, width). Columns that are none of the
            unknowns are left out, in a ring they wrap around.
        values: Right sides, shape (k, dim).
        triangle: R, shape (m, width + border).
        right: Shape (m, dim).

    Returns:
        -1, or an unknown that the rows do not determine.
    """
    m, width, dim = triangle.shape[0], rows.shape[1], values.shape[1]
    border = triangle.shape[1] - width
    n = m - border
    x, y, size, index = np.zeros(m), np.zeros(dim), np.zeros(m), np.zeros(3)
    index[2] = width
    for i in range(rows.shape[0]):
        low, high = n, -1
        for j in range(width):
            c = int(first[i]) + j
            if border > 0:
                c %= m
            elif c < 0 or c >= m:
                continue
            x[c] += rows[i, j]
            size[c] += rows[i, j] * rows[i, j]
            if c < n:
                low, high = min(low, c), max(high, c)
        for d in range(dim):
            y[d] = values[i, d]
        c = low
        while c <= high:
            if x[c] != 0.0:
                index[0], index[1] = c, high
                high = _rotate(triangle, right, index, x, y)
            c += 1
        for c in range(n, m):
            if x[c] != 0.0:
                index[0], index[1] = c, high
                _rotate(triangle, right, index, x, y)
    for c in range(m):
        at = 0 if c < n else width + c - n
        if not abs(triangle[c, at]) > 1e-13 * math.sqrt(size[c]):
            return c
    return -1


@kernel
def substitute(triangle: FloatArray, index: FloatArray, right: FloatArray) -> None:
    """Solve R x = right in place; index[0] is the width."""
    m, width = triangle.shape[0], int(index[0])
    n = m - (triangle.shape[1] - width)
    for i in range(m - 1, -1, -1):
        at = 0 if i < n else width + i - n
        for j in range(at + 1, triangle.shape[1]):
            column = i + j if j < width else n + j - width
            if j < width and column >= n:
                continue
            for d in range(right.shape[1]):
                right[i, d] -= triangle[i, j] * right[column, d]
        for d in range(right.shape[1]):
            right[i, d] /= triangle[i, at]


@kernel
def _entry(inverse: FloatArray, i: int, j: int, width: int) -> float:
    """Give an entry of a symmetric matrix that is stored as R is."""
    m = inverse.shape[0]
    n = m - (inverse.shape[1] - width)
    low, high = min(i, j), max(i, j)
    value: float = inverse[low, width + high - n] if high >= n else inverse[low, high - low]
    return value


@kernel
def leverages(
    first: FloatArray, rows: FloatArray, triangle: FloatArray, inverse: FloatArray, out: FloatArray
) -> None:
    """Write how much each row decides about its own fit: x' (R'R)^-1 x; ``inverse`` is as R."""
    # entries of an inverse where R has entries follow from one another: Takahashi, Fagan and
    # Chin, Formation of a sparse bus impedance matrix, Proc. 8th PICA Conf. (1973) 63
    m, width = triangle.shape[0], rows.shape[1]
    border = triangle.shape[1] - width
    n = m - border
    columns = np.empty(triangle.shape[1], dtype=np.int64)
    for i in range(m - 1, -1, -1):
        at = 0 if i < n else width + i - n
        count = 0
        for j in range(at + 1, triangle.shape[1]):
            if j >= width or i + j < n:
                columns[count] = j
                count += 1
        pivot = triangle[i, at]
        own = 1.0 / pivot
        for a in range(count):
            j = columns[a]
            column = i + j if j < width else n + j - width
            total = 0.0
            for b in range(count):
                k = columns[b]
                other = i + k if k < width else n + k - width
                total += triangle[i, k] * _entry(inverse, other, column, width)
            inverse[i, j] = -total / pivot
            own -= triangle[i, j] * inverse[i, j]
        inverse[i, at] = own / pivot
    for i in range(rows.shape[0]):
        total = 0.0
        for a in range(width):
            for b in range(width):
                c, d = int(first[i]) + a, int(first[i]) + b
                if border > 0:
                    c, d = c % m, d % m
                elif min(c, d) < 0 or max(c, d) >= m:
                    continue
                total += rows[i, a] * rows[i, b] * _entry(inverse, c, d, width)
        out[i] = total
