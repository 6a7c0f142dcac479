"""What joints do on the cells of a speed profile, compiled: rows for the solver, and looks at it.

Path and time are measured in shares of themselves: derivatives of q by the share of the way, and
limits in the unit of time that goes with it.
"""

from math import inf, sqrt

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

_NEAR = 0.8
"""Share of a limit from which on it matters how high a top is."""

_CUBIC = 0.4
"""Share of the third difference by which a parabola may be off: 1 / (9 sqrt 3) and more."""


@kernel
def _derivatives(
    breaks: FloatArray, coefficients: FloatArray, piece: int, s: float, out: FloatArray
) -> None:
    """Write the first three derivatives of q by s on a piece, shape (3, n or more)."""
    x = s - breaks[piece]
    degree, n = coefficients.shape[1] - 1, coefficients.shape[2]
    for c in range(n):
        q1, q2, q3 = 0.0, 0.0, 0.0
        for j in range(degree, 0, -1):
            a = coefficients[piece, j, c] * j
            q1 = q1 * x + a
            if j > 1:
                a *= j - 1.0
                q2 = q2 * x + a
            if j > 2:
                q3 = q3 * x + a * (j - 2.0)
        out[0, c], out[1, c], out[2, c] = q1, q2, q3


@kernel
def _slopes(
    breaks: FloatArray, coefficients: FloatArray, piece: int, s: float, out: FloatArray
) -> None:
    """Write derivatives by the share of the way; the way itself is the last column."""
    _derivatives(breaks, coefficients, piece, s, out)
    if out.shape[1] > coefficients.shape[2]:
        c = coefficients.shape[2]
        out[0, c], out[1, c], out[2, c] = 1.0, 0.0, 0.0


@kernel
def rows_into(
    breaks: FloatArray,
    coefficients: FloatArray,
    pieces: FloatArray,
    s: FloatArray,
    inverse: FloatArray,
    scale: FloatArray,
    G: FloatArray,
    caps: FloatArray,
) -> None:
    """Write the rows of all cells: acceleration half-way and at the end, jerk at both ends.

    Args:
        breaks: Ends of the path's pieces.
        coefficients: Of their polynomials, shape (k, degree + 1, n).
        pieces: To which piece each of m cells belongs.
        s: Nodes, by the share of the way, shape (m + 1,).
        inverse: 1 / limits of velocity, acceleration and jerk, shape (3, n), or (3, n + 1) if the
            way itself has limits too.
        scale: By which each cell's jerk rows are multiplied, at its two ends, shape (m, 2).
        G: Becomes the rows, shape (m, 4 n, 3).
        caps: Becomes the highest x by velocities, at shares 0, 1/2 and 1, shape (m, 3).
    """
    m, n = pieces.size, inverse.shape[1]
    D = np.empty((3, n))
    for i in range(m):
        h = s[i + 1] - s[i]
        for j in range(3):
            z = 0.5 * j
            at = s[i] + z * (s[i + 1] - s[i])
            _slopes(breaks, coefficients, int(pieces[i]), at, D)
            fastest = 0.0
            for c in range(n):
                fastest = max(fastest, abs(D[0, c]) * inverse[0, c])
                b, a = D[1, c] * inverse[1, c], D[0, c] * inverse[1, c] / h
                if j > 0:
                    row = G[i, (j - 1) * n + c]
                    row[0], row[1], row[2] = b, 2.0 * z * b + a, z * z * b + z * a
                if j != 1:
                    f = scale[i, j // 2] * inverse[2, c]
                    third, b, a = D[2, c] * f, 3.0 * D[1, c] * f / h, D[0, c] * f / (h * h)
                    row = G[i, (2 + j // 2) * n + c]
                    row[0], row[1] = third, 2.0 * z * third + b
                    row[2] = z * z * third + z * b + a
            caps[i, j] = inf if fastest == 0.0 else 1.0 / (fastest * fastest)


@kernel
def use_into(
    breaks: FloatArray,
    coefficients: FloatArray,
    pieces: FloatArray,
    s: FloatArray,
    inverse: FloatArray,
    Y: FloatArray,
    chosen: FloatArray,
    parts: float,
    out: FloatArray,
) -> None:
    """Write how much of x, acceleration and jerk limits each cell uses, shape (m, 4).

    Each is looked at in ``parts`` + 1 places of the cell, and at the top of the parabola through
    three neighbours. The last column is by how much tops that are near a limit may be misjudged.
    Cells whose ``chosen`` is not 1 are left out.
    """
    m, n = pieces.size, inverse.shape[1]
    D = np.empty((3, n))
    before, middle, now = np.zeros((3, n)), np.zeros((3, n)), np.zeros((3, n))
    bends, highest = np.zeros((3, n)), np.zeros((3, n))
    for i in range(m):
        if chosen[i] != 1.0:
            continue
        h = s[i + 1] - s[i]
        out[i, :] = 0.0
        highest[:, :] = 0.0
        for p in range(int(parts) + 1):
            z = p / parts
            at = s[i] + z * (s[i + 1] - s[i])
            _slopes(breaks, coefficients, int(pieces[i]), at, D)
            x = max(Y[i, 0] + 2.0 * z * Y[i, 1] + z * z * Y[i, 2], 0.0)
            v, u, c2 = sqrt(x), (Y[i, 1] + z * Y[i, 2]) / h, Y[i, 2] / (h * h)
            for c in range(n):
                now[0, c] = (D[0, c] * inverse[0, c]) ** 2 * x
                now[1, c] = (D[0, c] * u + D[1, c] * x) * inverse[1, c]
                now[2, c] = v * (D[0, c] * c2 + 3.0 * D[1, c] * u + D[2, c] * x) * inverse[2, c]
            for k in range(3):
                for c in range(n):
                    top = abs(now[k, c])
                    highest[k, c] = max(highest[k, c], top)
                    if p > 1:
                        # the parabola through three neighbours, where its top lies between them
                        bend = before[k, c] - 2.0 * middle[k, c] + now[k, c]
                        if p > 2 and highest[k, c] > _NEAR:
                            out[i, 3] = max(out[i, 3], _CUBIC * abs(bend - bends[k, c]))
                        bends[k, c] = bend
                        tilt = 0.5 * (now[k, c] - before[k, c])
                        if bend * middle[k, c] < 0.0 and abs(tilt) < abs(bend):
                            top = max(top, abs(middle[k, c] - 0.5 * tilt * tilt / bend))
                    out[i, k] = max(out[i, k], top)
                    before[k, c] = middle[k, c]
                    middle[k, c] = now[k, c]
