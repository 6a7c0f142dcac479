"""What the rows of a speed profile leave of their bounds, and how that changes with it, compiled.

y of a cell is as in ``smooth_kernel``: x is y (1, 2z, z^2) at a share z of it.
"""

from math import sqrt

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel


@kernel
def fill_constant(G: FloatArray, caps: FloatArray, A: FloatArray) -> None:
    """Write the slopes of all slacks that do not depend on where one is."""
    m, K = G.shape[0], G.shape[1]
    for i in range(m):
        for k in range(K):
            for c in range(3):
                A[i, 2 * k, c], A[i, 2 * k + 1, c] = -G[i, k, c], G[i, k, c]
        for j in range(3):
            z, scale = 0.5 * j, -1.0 / caps[i, j]
            A[i, 2 * K + j, 0] = scale
            A[i, 2 * K + j, 1] = 2.0 * z * scale
            A[i, 2 * K + j, 2] = z * z * scale


@kernel
def _measure_placed(
    T: FloatArray, S: FloatArray, y: FloatArray, A: FloatArray, V: FloatArray
) -> None:
    """Write the same of what is asked at places within a cell."""
    rows = T.shape[0]
    for k in range(rows):
        e1, e2 = 2.0 * T[k, 5], T[k, 5] * T[k, 5]
        root = sqrt(y[0] + e1 * y[1] + e2 * y[2])
        slope = 0.5 * T[k, 3] / root
        A[k, 0], A[k, 1], A[k, 2] = -T[k, 0] - slope, -T[k, 1] - e1 * slope, -T[k, 2] - e2 * slope
        V[k] = T[k, 4] - T[k, 0] * y[0] - T[k, 1] * y[1] - T[k, 2] * y[2] - T[k, 3] * root
    for k in range(S.shape[0]):
        first = S[k, 0] * y[0] + S[k, 1] * y[1] + S[k, 2] * y[2]
        second = S[k, 3] * y[0] + S[k, 4] * y[1] + S[k, 5] * y[2]
        for c in range(3):
            A[rows + k, c] = -first * S[k, c] - second * S[k, 3 + c]
        V[rows + k] = 0.5 * (1.0 - first * first - second * second)


@kernel
def measure(
    G: FloatArray,
    R: FloatArray,
    caps: FloatArray,
    T: FloatArray,
    S: FloatArray,
    Y: FloatArray,
    A: FloatArray,
    V: FloatArray,
) -> None:
    """Write what each row leaves of its bound to ``V`` and how that changes to ``A``."""
    m, K = G.shape[0], G.shape[1]
    for i in range(m):
        x, u, c = Y[i, 0], Y[i, 1], Y[i, 2]
        end = x + 2.0 * u + c
        left, right = R[i, 1] / sqrt(x), R[i, 2] / sqrt(end)
        for k in range(K):
            p, q, r = G[i, k, 0], G[i, k, 1], G[i, k, 2]
            value = p * x + q * u + r * c
            bound = R[i, 0]
            if 2 * k >= K and 4 * k < 3 * K:
                bound = left
                slope = -0.5 * left / x
                A[i, 2 * k, 0], A[i, 2 * k + 1, 0] = slope - p, slope + p
            elif 4 * k >= 3 * K:
                bound = right
                slope = -0.5 * right / end
                A[i, 2 * k, 0], A[i, 2 * k + 1, 0] = slope - p, slope + p
                A[i, 2 * k, 1], A[i, 2 * k + 1, 1] = 2.0 * slope - q, 2.0 * slope + q
                A[i, 2 * k, 2], A[i, 2 * k + 1, 2] = slope - r, slope + r
            V[i, 2 * k], V[i, 2 * k + 1] = bound - value, bound + value
        V[i, 2 * K] = 1.0 - x / caps[i, 0]
        V[i, 2 * K + 1] = 1.0 - (x + u + 0.25 * c) / caps[i, 1]
        V[i, 2 * K + 2] = 1.0 - end / caps[i, 2]
        _measure_placed(T[i], S[i], Y[i], A[i, 2 * K + 3 :], V[i, 2 * K + 3 :])
