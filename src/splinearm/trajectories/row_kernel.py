"""What joint velocities and accelerations allow on whole cells of a path, compiled.

On a cell q' is a polynomial of degree d with Bernstein coefficients S[0] ... S[d] (by the share of
the cell that is passed), and x, the square of ds/dt, is linear. So the acceleration

    q'(s) x'/2 + q''(s) x(s)

is of degree d too, and its coefficient m is, for a cell of length h,

    (((d - m) (S[m + 1] - S[m]) - S[m] / 2) x[i] + (m (S[m] - S[m - 1]) + S[m] / 2) x[i + 1]) / h

A polynomial is never beyond its Bernstein coefficients. As a line, |a x[i] + b x[i + 1]| <= 1 says
that x[i + 1] is within e = 1 / |b| of c x[i], where c = -a / b. Velocities become one cap at each
node: the straight x(s) below it, scaled down until all coefficients of q'(s)^2 x(s) are within.

Cells are worked on in blocks, so that the innermost loops run over neighbours in memory.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

BLOCK = 64
"""So many cells at a time."""

ROUNDING = 1e-12
"""Below this share of its other factor a factor of a row is rounding."""

_STEEPEST = 4.0
"""By so much a cap may differ between the ends of a cell."""

_STILL = 1e-14
"""Where the square of what a joint moves is below this share of its largest, it counts as this."""


@fast_kernel
def joint_rows_into(
    breaks: FloatArray,
    coefficients: FloatArray,
    s: FloatArray,
    most: FloatArray,
    cap: FloatArray,
    lines: FloatArray,
) -> None:
    """Write the caps at nodes and the lines of cells.

    Args:
        breaks: Ends of the path's pieces, shape (k + 1,).
        coefficients: Its Taylor coefficients, shape (k, degree + 1, n); degree at least 1.
        s: Nodes, rising, shape (m,); no cell reaches over a break.
        most: Highest velocities and accelerations, shape (2, n).
        cap: The largest x of each node is lowered here, shape (m,).
        lines: Centres c and half-widths e of each cell, shape (m - 1, 2, n * degree).
    """
    d, n = coefficients.shape[1] - 2, coefficients.shape[2]
    S = np.empty((n, d + 1, BLOCK))
    square = np.empty((2 * d + 1, BLOCK))
    y = np.empty((3, BLOCK))
    length = np.ones(BLOCK)
    binomial = _binomials(2 * d + 1)
    floor = _least_square(breaks, coefficients, most)
    piece = 0
    for start in range(0, s.shape[0] - 1, BLOCK):
        count = min(BLOCK, s.shape[0] - 1 - start)
        piece = _load(breaks, coefficients, s, start, count, piece, S, length)
        for j in range(n):
            _to_bernstein(binomial, S[j])
        _lower_caps(binomial, S, most[0], floor, (start, count), square, y, cap)
        for j in range(n):
            _write_lines(S[j], length, most[1, j], (start, count), j * (d + 1), cap, lines)


@fast_kernel
def _binomials(top: int) -> FloatArray:
    """Give Pascal's triangle."""
    triangle = np.zeros((top + 1, top + 1))
    for i in range(top + 1):
        triangle[i, 0] = 1.0
        for j in range(1, i + 1):
            triangle[i, j] = triangle[i - 1, j - 1] + triangle[i - 1, j]
    return triangle


@fast_kernel
def _least_square(breaks: FloatArray, coefficients: FloatArray, most: FloatArray) -> float:
    """Give the square of a velocity by s, in shares of the limit, that counts as standing still."""
    largest = 0.0
    for k in range(coefficients.shape[0]):
        h = breaks[k + 1] - breaks[k]
        for j in range(coefficients.shape[2]):
            moved, power = 0.0, 1.0
            for p in range(1, coefficients.shape[1]):
                moved += p * abs(coefficients[k, p, j]) * power
                power *= h
            largest = max(largest, moved / most[0, j])
    return _STILL * largest * largest


@fast_kernel
def _load(
    breaks: FloatArray,
    coefficients: FloatArray,
    s: FloatArray,
    start: int,
    count: int,
    piece: int,
    S: FloatArray,
    length: FloatArray,
) -> int:
    """Write the powers of q' on each cell of a block, in shares of the cell; give the last piece.

    A cell belongs to the piece that its middle lies in.
    """
    n, order, last = S.shape[0], S.shape[1], coefficients.shape[0] - 1
    at = np.zeros(BLOCK)
    for i in range(count):
        begin, end = s[start + i], s[start + i + 1]
        while piece < last and 0.5 * (begin + end) >= breaks[piece + 1]:
            piece += 1
        at[i], length[i] = begin - breaks[piece], end - begin
        for k in range(order):
            for j in range(n):
                S[j, k, i] = (k + 1) * coefficients[piece, k + 1, j]
    for i in range(count, BLOCK):
        for k in range(order):
            for j in range(n):
                S[j, k, i] = 1.0
    for j in range(n):
        # Taylor shift by repeated Horner steps
        for k in range(order - 1):
            for m in range(order - 2, k - 1, -1):
                for i in range(BLOCK):
                    S[j, m, i] += at[i] * S[j, m + 1, i]
        for k in range(1, order):
            for m in range(k, order):
                for i in range(BLOCK):
                    S[j, m, i] *= length[i]
    return piece


@fast_kernel
def _to_bernstein(binomial: FloatArray, P: FloatArray) -> None:
    """Turn the powers of polynomials, shape (d + 1, BLOCK), into Bernstein coefficients."""
    # Farouki, The Bernstein polynomial basis: a centennial retrospective, 2012, section 3.2, as
    # repeated sums
    d = P.shape[0] - 1
    for k in range(1, d + 1):
        scale = 1.0 / binomial[d, k]
        for i in range(BLOCK):
            P[k, i] *= scale
    for k in range(1, d + 1):
        for m in range(d, k - 1, -1):
            for i in range(BLOCK):
                P[m, i] += P[m - 1, i]


@fast_kernel
def _lower_caps(
    binomial: FloatArray,
    S: FloatArray,
    qd_max: FloatArray,
    floor: float,
    cells: tuple[int, int],
    square: FloatArray,
    y: FloatArray,
    cap: FloatArray,
) -> None:
    """Lower the caps of the nodes of a block of cells to what velocities allow."""
    n, d = S.shape[0], S.shape[1] - 1
    first, last, worst = y[0], y[1], y[2]
    first[:], last[:], worst[:] = floor, floor, 0.0
    for j in range(n):
        scale = 1.0 / (qd_max[j] * qd_max[j])
        for i in range(BLOCK):
            a, b = scale * S[j, 0, i] * S[j, 0, i], scale * S[j, d, i] * S[j, d, i]
            # not max(): what it does with NaN keeps loops from running over several cells at once
            first[i] = a if a > first[i] else first[i]  # noqa: FURB136
            last[i] = b if b > last[i] else last[i]  # noqa: FURB136
    for i in range(BLOCK):
        a, b = 1.0 / first[i], 1.0 / last[i]
        first[i], last[i] = min(a, _STEEPEST * b), min(b, _STEEPEST * a)
    top = 2 * d + 1
    for j in range(n):
        scale = 1.0 / (qd_max[j] * qd_max[j])
        square[:] = 0.0
        for k in range(d + 1):
            for m in range(k, d + 1):
                share = scale * binomial[d, k] * binomial[d, m] / binomial[2 * d, k + m]
                if m > k:
                    share *= 2.0
                for i in range(BLOCK):
                    square[k + m, i] += share * S[j, k, i] * S[j, m, i]
        for k in range(top + 1):
            before, behind = max(k - 1, 0), min(k, 2 * d)
            left, right = (top - k) / top, k / top
            for i in range(BLOCK):
                use = left * square[behind, i] * first[i] + right * square[before, i] * last[i]
                worst[i] = use if use > worst[i] else worst[i]  # noqa: FURB136
    start, count = cells
    for i in range(count):
        scale = 1.0 / max(1.0, worst[i])
        cap[start + i] = min(cap[start + i], first[i] * scale)
        cap[start + i + 1] = min(cap[start + i + 1], last[i] * scale)


@fast_kernel
def _write_lines(
    S: FloatArray,
    length: FloatArray,
    qdd_max: float,
    cells: tuple[int, int],
    slot: int,
    cap: FloatArray,
    lines: FloatArray,
) -> None:
    """Write the lines of one joint's acceleration on a block of cells."""
    d = S.shape[0] - 1
    start, count = cells
    for m in range(d + 1):
        before, behind = max(m - 1, 0), min(m + 1, d)
        for i in range(count):
            a = (d - m) * (S[behind, i] - S[m, i]) - 0.5 * S[m, i]
            b = m * (S[m, i] - S[before, i]) + 0.5 * S[m, i]
            if abs(b) > ROUNDING * abs(a):
                scale = 1.0 / b
                lines[start + i, 0, slot + m] = -a * scale
                lines[start + i, 1, slot + m] = abs(scale) * length[i] * qdd_max
                continue
            # it hardly knows of x[i + 1]; as a line it would be all rounding
            lines[start + i, 0, slot + m] = 0.0
            lines[start + i, 1, slot + m] = math.inf
            if a != 0.0:
                cap[start + i] = min(cap[start + i], length[i] * qdd_max / abs(a))
