"""Quadratic B-splines, and the symmetric matrices with five diagonals they lead to, compiled."""

from math import inf

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel


@kernel
def local_maps(h: FloatArray, first: float, last: float, out: FloatArray) -> None:
    """Write y of each cell by its three coefficients, shape (m, 3, 3); cells of lengths ``h``.

    An outer coefficient that hangs on its neighbour is ``first`` (``last``) times that; where that
    is 0 it stands for itself.
    """
    m = h.size
    for i in range(m):
        left = h[i] + (h[i - 1] if i > 0 else 0.0)
        right = h[i] + (h[i + 1] if i < m - 1 else 0.0)
        a, b = h[i] / left, h[i] / right
        out[i, 0, 0], out[i, 0, 1], out[i, 0, 2] = a, 1.0 - a, 0.0
        out[i, 1, 0], out[i, 1, 1], out[i, 1, 2] = -a, a, 0.0
        out[i, 2, 0], out[i, 2, 1], out[i, 2, 2] = a, -a - b, b
    for r in range(3):
        if first > 0.0:
            out[0, r, 1] += first * out[0, r, 0]
            out[0, r, 0] = 0.0
        if last > 0.0:
            out[m - 1, r, 1] += last * out[m - 1, r, 2]
            out[m - 1, r, 2] = 0.0


@kernel
def states(maps: FloatArray, d: FloatArray, out: FloatArray) -> None:
    """Write y of each cell, shape (m, 3), for coefficients or changes of them."""
    for i in range(maps.shape[0]):
        for r in range(3):
            a, b, c = maps[i, r, 0], maps[i, r, 1], maps[i, r, 2]
            out[i, r] = a * d[i] + b * d[i + 1] + c * d[i + 2]


@kernel
def factor(D: FloatArray, E: FloatArray, F: FloatArray) -> bool:
    """Factor the symmetric matrix with diagonals D, E, F in place; tell whether it is positive."""
    n = D.size
    for i in range(n):
        if i >= 1:
            D[i] -= E[i - 1] * E[i - 1] * D[i - 1]
        if i >= 2:
            D[i] -= F[i - 2] * F[i - 2] * D[i - 2]
        if not 0.0 < D[i] < inf:
            return False
        if i < n - 1:
            if i >= 1:
                E[i] -= E[i - 1] * F[i - 1] * D[i - 1]
            E[i] /= D[i]
        if i < n - 2:
            F[i] /= D[i]
    return True


@kernel
def substitute(D: FloatArray, E: FloatArray, F: FloatArray, b: FloatArray) -> None:
    """Solve with the factored matrix in place."""
    n = D.size
    for i in range(n):
        if i >= 1:
            b[i] -= E[i - 1] * b[i - 1]
        if i >= 2:
            b[i] -= F[i - 2] * b[i - 2]
    for i in range(n - 1, -1, -1):
        b[i] /= D[i]
        if i < n - 1:
            b[i] -= E[i] * b[i + 1]
        if i < n - 2:
            b[i] -= F[i] * b[i + 2]


@kernel
def hold(band: FloatArray, at: int) -> None:
    """Take a coefficient out of Newton's equations: it stays."""
    n = band.shape[1]
    band[0, at], band[3, at], band[4, at] = 1.0, 0.0, 0.0
    for j in range(1, 3):
        if at + j < n:
            band[j, at] = 0.0
        if at - j >= 0:
            band[j, at - j] = 0.0
