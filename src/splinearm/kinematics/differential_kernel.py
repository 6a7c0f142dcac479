"""How the Jacobian changes and what volume it spans, compiled, at one joint vector.

Functions answer whether they have: False where the arrays do not fit the arm or a number is not
finite, and what they wrote is then not to be used.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel
from splinearm.direct import MODEL, WRITE, answer, matrix, vector

from .dynamics_kernel import cross
from .forward_kernel import jacobian_into

_SINGULAR = 1e-6
"""Share of the largest extent of a volume below which its gradient wants singular values."""


@fast_kernel
def rate_into(O: FloatArray, q: FloatArray, qd: FloatArray, D: FloatArray) -> bool:
    """Write the time derivative of the Jacobian in base, shape (6, n)."""
    # the sum over joints of what `differential.hessian` gives: those up to a column turn it, those
    # after it move the tool point
    n = O.shape[0] - 1
    if qd.shape[0] != n or not jacobian_into(O, q, D):
        return False
    vx, vy, vz = 0.0, 0.0, 0.0
    for k in range(n):
        if not abs(qd[k]) < math.inf:
            return False
        vx, vy, vz = vx + D[0, k] * qd[k], vy + D[1, k] * qd[k], vz + D[2, k] * qd[k]
    wx, wy, wz = 0.0, 0.0, 0.0
    for k in range(n):
        x, y, z, a, b, c = D[0, k], D[1, k], D[2, k], D[3, k], D[4, k], D[5, k]
        D[3, k], D[4, k], D[5, k] = cross(wx, wy, wz, a, b, c)
        wx, wy, wz = wx + a * qd[k], wy + b * qd[k], wz + c * qd[k]
        vx, vy, vz = vx - x * qd[k], vy - y * qd[k], vz - z * qd[k]
        tx, ty, tz = cross(wx, wy, wz, x, y, z)
        mx, my, mz = cross(a, b, c, vx, vy, vz)
        D[0, k], D[1, k], D[2, k] = tx + mx, ty + my, tz + mz
    return True


@fast_kernel
def volume_into(
    O: FloatArray, q: FloatArray, rows: FloatArray, volume: FloatArray, gradient: FloatArray
) -> bool:
    """Write the product of the singular values of rows of the Jacobian, and its slopes.

    Args:
        O: The arm, packed.
        q: Joint positions, (n,).
        rows: First row, and the row after the last.
        volume: The product, (1,).
        gradient: Its derivative by each joint, (n,); or (0,) where that is not wanted. Close to a
            singularity the answer to a wanted one is False.
    """
    n = O.shape[0] - 1
    J = np.empty((6, n))
    if not jacobian_into(O, q, J):
        return False
    first, last = int(rows[0]), int(rows[1])
    wide = n >= last - first
    M = J[first:last].T.copy() if wide else J[first:last].copy()
    size = M.shape[1]
    R = np.zeros((size, size))
    orthogonalize(M, R)
    product, least, most = 1.0, math.inf, 0.0
    for i in range(size):
        product *= R[i, i]
        least, most = min(least, R[i, i]), max(most, R[i, i])
    volume[0] = product
    if gradient.shape[0] == 0:
        return True
    if gradient.shape[0] != n or not least > _SINGULAR * most:
        return False
    # d log det = tr(J+ dJ); the rows of J+, or its columns, are those of Q times R^-T
    for i in range(M.shape[0]):
        for k in range(size - 1, -1, -1):
            for j in range(k + 1, size):
                M[i, k] -= R[k, j] * M[i, j]
            M[i, k] /= R[k, k]
    _add_slopes(J, M if wide else M.T.copy(), first, last, product, gradient)
    return True


@fast_kernel
def _add_slopes(
    J: FloatArray,
    P: FloatArray,
    first: int,
    last: int,
    volume: float,
    gradient: FloatArray,
) -> None:
    """Write the volume times the trace of P = J+ and the derivative of J by each joint."""
    n = J.shape[1]
    for j in range(n):
        total = 0.0
        for k in range(n):
            a, b = min(j, k), max(j, k)
            ax, ay, az = J[3, a], J[4, a], J[5, a]
            if first == 0:
                x, y, z = cross(ax, ay, az, J[0, b], J[1, b], J[2, b])
                total += P[k, 0] * x + P[k, 1] * y + P[k, 2] * z
            if last == 6 and j < k:
                x, y, z = cross(ax, ay, az, J[3, b], J[4, b], J[5, b])
                at = 3 - first
                total += P[k, at] * x + P[k, at + 1] * y + P[k, at + 2] * z
        gradient[j] = volume * total


@fast_kernel
def orthogonalize(M: FloatArray, R: FloatArray) -> None:
    """Turn the columns of M into orthonormal ones, in place, and write the triangle R."""
    # Gram and Schmidt, each column twice, which is enough: Giraud, Langou and Rozloznik, The loss
    # of orthogonality in the Gram-Schmidt orthogonalization process, 2005
    m, size = M.shape
    for k in range(size):
        for _ in range(2):
            for j in range(k):
                part = 0.0
                for i in range(m):
                    part += M[i, j] * M[i, k]
                R[j, k] += part
                for i in range(m):
                    M[i, k] -= part * M[i, j]
        square = 0.0
        for i in range(m):
            square += M[i, k] * M[i, k]
        R[k, k] = math.sqrt(square)
        for i in range(m):
            M[i, k] = M[i, k] / R[k, k] if R[k, k] > 0.0 else 0.0


def rate_call(model: int, arguments: int, count: int) -> int:
    """Do as `rate_into` does with (q, qd, D), for the arm it is bound to; see `direct.bind`."""
    given = model, arguments
    return answer(
        count == 3
        and rate_into(
            matrix(given, MODEL), vector(given, 0), vector(given, 1), matrix(given, 2, WRITE)
        )
    )


def volume_call(model: int, arguments: int, count: int) -> int:
    """Do as `volume_into` does with (q, rows, volume, gradient), for the arm it is bound to."""
    given = model, arguments
    return answer(
        count == 4
        and volume_into(
            matrix(given, MODEL),
            vector(given, 0),
            vector(given, 1),
            vector(given, 2, WRITE),
            vector(given, 3, WRITE),
        )
    )
