"""Where a swivel places the elbow, and what the joints around it are then.

Used by module swivel_kernel, which says what the swivel is. Points and axes are in the frames of
module gauge: S is on the first axis, E the origin of the frame behind the third joint, W that of
the frame behind the fifth; ``P`` holds the rows of the arm and ``B`` the pose of the last frame.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .subproblem_kernel import circle, turn

_STRAIGHT = 1e-10
_NEAR = 1e-4
_FLAT = 1e-9
"""Below this share of its size the way to the elbow, or to the first axis, has no direction."""


@kernel
def three_turns(M: FloatArray, P: FloatArray, first: int, seed: FloatArray, out: FloatArray) -> int:
    """Solve M = Rz Rx Rz Rx Rz: rows of cosines and sines in ``out`` (2, 6), and their number.

    The two constant turns are those of rows ``first`` and ``first`` + 1 of ``P``.
    """
    ca, sa, cb, sb = P[first, 2], P[first, 3], P[first + 1, 2], P[first + 1, 3]
    across = math.sqrt(M[0, 2] * M[0, 2] + M[1, 2] * M[1, 2])
    cy = (ca * cb - M[2, 2]) / (sa * sb)
    if ca == 0.0 and cb == 0.0:
        sy = across
        short = 1.0 / math.sqrt(cy * cy + sy * sy)
        cy, sy = cy * short, sy * short
    else:
        room = (1.0 - cy) * (1.0 + cy)
        if room < -1e-9:
            return 0
        sy = math.sqrt(room) if room > 1e-16 else 0.0
        cy = min(max(cy, -1.0), 1.0)
    n = 1 if (across <= _STRAIGHT or sy == 0.0) else 2
    for i in range(n):
        if i:
            sy = -sy
        gx, gy = sy * sb, -ca * cy * sb - sa * cb
        hx, hy = sy * sa, cb * cy * sa + sb * ca
        cx, sx = math.cos(seed[first]), math.sin(seed[first])
        if across > _STRAIGHT:
            cx, sx = turn(gx, gy, M[0, 2], M[1, 2], 1.0, seed[first])
        if across > _NEAR:
            cz, sz = turn(M[2, 0], M[2, 1], hx, hy, 1.0, seed[first + 2])
        else:
            # what is left for the last of them: Rx(-b) Rz(-y) Rx(-a) Rz(-x) M
            x, y, z = cx * M[0, 0] + sx * M[1, 0], cx * M[1, 0] - sx * M[0, 0], M[2, 0]
            y, z = ca * y + sa * z, ca * z - sa * y
            x, y = cy * x + sy * y, cy * y - sy * x
            cz, sz = turn(1.0, 0.0, x, cb * y + sb * z, 1.0, seed[first + 2])
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4], out[i, 5] = cx, sx, cy, sy, cz, sz
    return n


@kernel
def wrist(P: FloatArray, B: FloatArray, x: float, v: FloatArray, axis: FloatArray) -> None:
    """Give the way from S to W in ``v`` and the sixth axis in ``axis``, the last joint being x."""
    c, s = math.cos(x), math.sin(x)
    a, d, ca, sa = P[5, 0], P[5, 1], P[5, 2], P[5, 3]
    wx, wy, wz = -c * a - s * sa * d, s * a - c * sa * d, -ca * d
    nx, ny = s * sa, c * sa
    for i in range(3):
        v[i] = B[i, 3] + B[i, 0] * wx + B[i, 1] * wy + B[i, 2] * wz
        axis[i] = B[i, 0] * nx + B[i, 1] * ny + B[i, 2] * ca
    v[2] -= P[0, 1]


@kernel
def elbows(P: FloatArray, v: FloatArray, roots: FloatArray, seed: float) -> int:
    """Give cosine and sine of the fourth joint in rows of ``roots`` (2, 2), and their number."""
    a2, d2, ca2, sa2 = P[2, 0], P[2, 1], P[2, 2], P[2, 3]
    wx, wy, wz = P[3, 0], -P[3, 3] * P[4, 1], P[3, 1] + P[3, 2] * P[4, 1]
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    fixed = a2 * a2 + d2 * d2 + wx * wx + wy * wy + wz * wz
    size = math.sqrt(fixed)
    n, roots[0, 0], roots[0, 1], roots[1, 0], roots[1, 1] = circle(
        (a2 * wx + sa2 * d2 * wy) / size,
        (sa2 * d2 * wx - a2 * wy) / size,
        (0.5 * (square - fixed) - ca2 * d2 * wz) / size,
        size,
        seed,
    )
    return n


@kernel
def _triad(n: FloatArray, e: FloatArray, X: FloatArray) -> bool:
    """Put a right-handed frame along n and towards e in columns of ``X``, if there is one."""
    nn = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    size = math.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    if not nn > 0.0:
        return False
    along = (n[0] * e[0] + n[1] * e[1] + n[2] * e[2]) / nn
    total = 0.0
    for i in range(3):
        X[i, 0] = n[i] / nn
        X[i, 1] = e[i] - along * X[i, 0]
        total += X[i, 1] * X[i, 1]
    length = math.sqrt(total)
    if not length > _FLAT * size:
        return False
    for i in range(3):
        X[i, 1] /= length
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        X[i, 2] = X[j, 0] * X[k, 1] - X[k, 0] * X[j, 1]
    return True


@kernel
def upper(
    P: FloatArray, v: FloatArray, swivel: float, c: float, s: float, R: FloatArray, X: FloatArray
) -> bool:
    """Give the turn ``R`` (3, 3) that the first three joints make; ``X`` (3, 3, 3) is room.

    ``c`` and ``s`` are those of the fourth joint. False where the swivel has no meaning.
    """
    wx, wy, wz = P[3, 0], -P[3, 3] * P[4, 1], P[3, 1] + P[3, 2] * P[4, 1]
    x, y = c * wx - s * wy, s * wx + c * wy
    n, e = X[2, 0], X[2, 1]
    e[0], e[1], e[2] = P[2, 0], 0.0, P[2, 1]
    n[0] = P[2, 0] + x
    n[1] = P[2, 2] * y - P[2, 3] * wz
    n[2] = P[2, 1] + P[2, 3] * y + P[2, 2] * wz
    if not _triad(n, e, X[0]):
        return False
    e[0], e[1], e[2] = 0.0, 0.0, 1.0
    if not _triad(v, e, X[1]):
        return False
    cp, sp = math.cos(swivel), math.sin(swivel)
    for i in range(3):
        one, two = X[1, i, 1], X[1, i, 2]
        X[1, i, 1], X[1, i, 2] = cp * one + sp * two, cp * two - sp * one
    for i in range(3):
        for j in range(3):
            R[i, j] = X[1, i, 0] * X[0, j, 0] + X[1, i, 1] * X[0, j, 1] + X[1, i, 2] * X[0, j, 2]
    return True


@kernel
def lower(P: FloatArray, R: FloatArray, c: float, s: float, F: FloatArray) -> None:
    """Give the frame ``F`` (3, 3) that the fifth joint turns: R Rx Rz(fourth) Rx."""
    ca2, sa2, ca3, sa3 = P[2, 2], P[2, 3], P[3, 2], P[3, 3]
    for i in range(3):
        x, y, z = R[i, 0], ca2 * R[i, 1] + sa2 * R[i, 2], ca2 * R[i, 2] - sa2 * R[i, 1]
        x, y = c * x + s * y, c * y - s * x
        F[i, 0], F[i, 1], F[i, 2] = x, ca3 * y + sa3 * z, ca3 * z - sa3 * y


@kernel
def angle_miss(
    P: FloatArray, B: FloatArray, swivel: float, x: float, k: int, room: FloatArray
) -> float:
    """Give by how much elbow k misses the angle of the fifth to the sixth axis; NaN: no elbow."""
    v, axis, roots = room[0, 0], room[0, 1], room[1, :2, :2]
    wrist(P, B, x, v, axis)
    if elbows(P, v, roots, 0.0) < 2:
        return math.nan
    c, s = roots[k, 0], roots[k, 1]
    if not upper(P, v, swivel, c, s, room[2], room[3:6]):
        return math.nan
    lower(P, room[2], c, s, room[6])
    F = room[6]
    miss: float = F[0, 2] * axis[0] + F[1, 2] * axis[1] + F[2, 2] * axis[2] - P[4, 2]
    return miss


@kernel
def two_turns(P: FloatArray, M: FloatArray, x: float, seed: FloatArray, out: FloatArray) -> int:
    """Solve M = Rz Rx Rz Rx Rz(x) for the first two turns."""
    sa, cb, sb = P[4, 3], P[5, 2], P[5, 3]
    c, s = math.cos(x), math.sin(x)
    # M Rz(-x) Rx(-b): its third column is the sixth axis, its third row tells the sixth joint
    zx = sb * (s * M[0, 0] + c * M[0, 1]) + cb * M[0, 2]
    zy = sb * (s * M[1, 0] + c * M[1, 1]) + cb * M[1, 2]
    c4, s4 = turn(0.0, -sa, zx, zy, 1.0, seed[4])
    px = c * M[2, 0] - s * M[2, 1]
    py = cb * (s * M[2, 0] + c * M[2, 1]) - sb * M[2, 2]
    # third row of Rz Rx(a) Rz(y): (sa sin y, sa cos y, ca)
    c5, s5 = turn(sa, 0.0, py, px, 1.0, seed[5])
    out[0, 0], out[0, 1], out[0, 2], out[0, 3], out[0, 4], out[0, 5] = c4, s4, c5, s5, c, s
    return 1
