"""Basis functions and the banded systems that they lead to, on bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel


@kernel
def basis_into(
    knots: FloatArray, spans: FloatArray, u: FloatArray, orders: FloatArray, out: FloatArray
) -> None:
    """Write a derivative of the basis functions alive at each parameter, (k, degree + 1)."""
    # Cox-de Boor recurrence (Piegl and Tiller, The NURBS Book, 2nd ed. 1997, eq. 2.5 and 2.7)
    degree = out.shape[1] - 1
    for i in range(u.shape[0]):
        span, order = int(spans[i]), int(orders[i])
        row = out[i]
        row[:] = 0.0
        if order > degree:
            continue
        row[0] = 1.0
        for d in range(1, degree + 1):
            carried = 0.0
            for j in range(d):
                low, high = knots[span + 1 - d + j], knots[span + 1 + j]
                share = row[j] / (high - low)
                if d > degree - order:
                    row[j] = carried - d * share
                    carried = d * share
                else:
                    row[j] = carried + (high - u[i]) * share
                    carried = (u[i] - low) * share
            row[d] = carried


@kernel
def eliminate(first: FloatArray, values: FloatArray, x: FloatArray) -> int:
    """Solve a banded system in place: ``x`` comes as right sides, shape (n, columns).

    Row i has ``values[i]`` from column ``first[i]`` on; no column may lie outside the matrix unless
    its entry is 0.

    Returns:
        0, or 1 if a pivot vanishes.
    """
    n, width = values.shape
    columns = x.shape[1]
    lower, upper = 0, 0
    for i in range(n):
        lower = max(lower, i - int(first[i]))
        upper = max(upper, int(first[i]) + width - 1 - i)
    # band[i, j] is the entry of row i in column i - lower + j
    band = np.zeros((n, lower + upper + 1))
    for i in range(n):
        largest = 0.0
        for j in range(width):
            band[i, int(first[i]) - i + lower + j] = values[i, j]
            largest = max(largest, abs(values[i, j]))
        # rows as large as each other: a pivot then is small only if it vanishes
        if not largest > 0.0:
            return 1
        for j in range(lower + upper + 1):
            band[i, j] /= largest
        for c in range(columns):
            x[i, c] /= largest
    for i in range(n):
        pivot = band[i, lower]
        if not abs(pivot) > 1e-14:
            return 1
        for k in range(1, min(lower, n - 1 - i) + 1):
            factor = band[i + k, lower - k] / pivot
            if factor != 0.0:
                for j in range(1, upper + 1):
                    band[i + k, lower - k + j] -= factor * band[i, lower + j]
                for c in range(columns):
                    x[i + k, c] -= factor * x[i, c]
    for i in range(n - 1, -1, -1):
        for k in range(1, min(upper, n - 1 - i) + 1):
            factor = band[i, lower + k]
            if factor != 0.0:
                for c in range(columns):
                    x[i, c] -= factor * x[i + k, c]
        inverse = 1.0 / band[i, lower]
        for c in range(columns):
            x[i, c] *= inverse
    return 0
