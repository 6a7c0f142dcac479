"""Six turning joints of any kind as one matrix that is singular where a joint meets the pose.

M. Raghavan and B. Roth, Inverse kinematics of the general 6R manipulator, ASME Journal of
Mechanical Design 115, 1993: the axis and the place of a frame give fourteen equations in which
three joints stand on one side and two on the other; the two are eliminated linearly, and half the
angle of two of the three is taken for its tangent. Angles are written as sums of a given shift and
what is looked for, so that no half angle runs away in all poses of an arm.

The chain is a loop: constants ``K`` (6, 3, 4) stand behind the turns of the joints, the last one
being the inverse of the pose, and any joint may be left out, which is the way (``drop``, ``far``,
``which``, ``other``): the joint that is left out; 1 where the three joints come first behind it,
else 0; the one of the three whose values are looked for; and another of them, whose powers fill up
the matrix. An arm of special structure has its determinant zero throughout along some of the 72
ways, but not along all.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .eigenvalue_kernel import triangulate
from .subproblem_kernel import inverse, product

EQUATIONS = 14
SIZE = 12
"""Rows and columns of the matrix."""
_THIRD = 2.0 * math.pi / 3.0
_ROOT = 1.0 / math.sqrt(3.0)


@kernel
def turned(angle: float, K: FloatArray, out: FloatArray) -> None:
    """Give Rz(angle) K."""
    c, s = math.cos(angle), math.sin(angle)
    for j in range(4):
        x, y = K[0, j], K[1, j]
        out[0, j], out[1, j], out[2, j] = c * x - s * y, s * x + c * y, K[2, j]


@kernel
def fourteen(T: FloatArray, out: FloatArray) -> None:
    """Give what the place p and the axis l of a frame say: p, l, pp, pl, p x l, pp l - 2 pl p."""
    px, py, pz, lx, ly, lz = T[0, 3], T[1, 3], T[2, 3], T[0, 2], T[1, 2], T[2, 2]
    pp, pl = px * px + py * py + pz * pz, px * lx + py * ly + pz * lz
    out[0], out[1], out[2], out[3], out[4], out[5] = px, py, pz, lx, ly, lz
    out[6], out[7] = pp, pl
    out[8], out[9], out[10] = py * lz - pz * ly, pz * lx - px * lz, px * ly - py * lx
    out[11] = pp * lx - 2.0 * pl * px
    out[12] = pp * ly - 2.0 * pl * py
    out[13] = pp * lz - 2.0 * pl * pz


@kernel
def joint_of(way: FloatArray, k: int) -> int:
    """Give the joint that stands ``k`` places behind the one that is left out."""
    return (int(way[0]) + 1 + k) % 6


@kernel
def three_joints(
    K: FloatArray, way: FloatArray, t0: float, t1: float, t2: float, out: FloatArray
) -> None:
    """Give the fourteen of the side of three joints."""
    X, Y, Z = np.empty((3, 4)), np.empty((3, 4)), np.empty((3, 4))
    first = 0 if way[1] != 0.0 else 2
    turned(t0, K[joint_of(way, first)], X)
    turned(t1, K[joint_of(way, first + 1)], Y)
    product(X, Y, Z)
    turned(t2, K[joint_of(way, first + 2)], X)
    product(Z, X, Y)
    if way[1] != 0.0:
        inverse(Y, X)
        inverse(K[int(way[0])], Z)
        product(X, Z, Y)
    fourteen(Y, out)


@kernel
def two_joints(K: FloatArray, way: FloatArray, t0: float, t1: float, out: FloatArray) -> None:
    """Give the fourteen of the side of two joints."""
    X, Y, Z = np.empty((3, 4)), np.empty((3, 4)), np.empty((3, 4))
    first = 3 if way[1] != 0.0 else 0
    turned(t0, K[joint_of(way, first)], X)
    turned(t1, K[joint_of(way, first + 1)], Y)
    product(X, Y, Z)
    if way[1] == 0.0:
        inverse(Z, X)
        inverse(K[int(way[0])], Y)
        product(X, Y, Z)
    fourteen(Z, out)


@kernel
def _harmonics(V: FloatArray) -> None:
    """Put 1, cos and sin parts in place of values at no turn, a third and two thirds of one."""
    for i in range(V.shape[1]):
        a, b, c = V[0, i], V[1, i], V[2, i]
        V[0, i] = (a + b + c) / 3.0
        V[1, i] = (2.0 * a - b - c) / 3.0
        V[2, i] = (b - c) * _ROOT


@kernel
def _powers(V: FloatArray) -> None:
    """Put powers of the half angle's tangent in place of 1, cos and sin parts."""
    for i in range(V.shape[1]):
        a, b, c = V[0, i], V[1, i], V[2, i]
        V[0, i], V[1, i], V[2, i] = a + b, 2.0 * c, a - b


@kernel
def two_parts(
    K: FloatArray, way: FloatArray, shifts: FloatArray, R: FloatArray, Q: FloatArray
) -> None:
    """Give the side of two joints: ``R`` (3, 3, 14) its parts, ``Q`` (14, 8) all but the first."""
    first = 3 if way[1] != 0.0 else 0
    t0, t1 = shifts[joint_of(way, first)], shifts[joint_of(way, first + 1)]
    for i in range(3):
        for j in range(3):
            two_joints(K, way, t0 + i * _THIRD, t1 + j * _THIRD, R[i, j])
        _harmonics(R[i])
    _harmonics(R.reshape(3, 42))
    flat = R.reshape(9, EQUATIONS)
    for i in range(8):
        for k in range(EQUATIONS):
            Q[k, i] = flat[i + 1, k]


@kernel
def pencil(
    K: FloatArray,
    way: FloatArray,
    shifts: FloatArray,
    M: FloatArray,
    R: FloatArray,
    Q: FloatArray,
    N: FloatArray,
    order: FloatArray,
) -> None:
    """Give M (3, 12, 12): M[0] + M[1] x + M[2] x^2 is singular at an answer's half angle's tangent.

    Also what the side of two joints is: ``R`` as in ``two_parts``, its triangle in ``Q`` (14, 8)
    with columns in ``order``, and the reflections ``N`` (14, 14).
    """
    two_parts(K, way, shifts, R, Q)
    triangulate(Q, N, order)
    first = 0 if way[1] != 0.0 else 2
    t = np.empty(3)
    for k in range(3):
        t[k] = shifts[joint_of(way, first + k)]
    values, E = np.empty(EQUATIONS), np.empty((3, 3, 3, 6))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                three_joints(
                    K, way, t[0] + i * _THIRD, t[1] + j * _THIRD, t[2] + k * _THIRD, values
                )
                for e in range(6):
                    total = 0.0
                    for r in range(EQUATIONS):
                        total += N[r, 8 + e] * (values[r] - R[0, 0, r])
                    E[i, j, k, e] = total
            _harmonics(E[i, j])
            _powers(E[i, j])
        _harmonics(E[i].reshape(3, 18))
        _powers(E[i].reshape(3, 18))
    _harmonics(E.reshape(3, 54))
    _powers(E.reshape(3, 54))
    _fill(E, int(way[2]), int(way[3]), M)


@kernel
def _fill(E: FloatArray, which: int, other: int, M: FloatArray) -> None:
    """Put the six equations in rows 0 to 5, and times one tangent in rows 6 to 11, of about 1."""
    M[:] = 0.0
    at = np.empty(3, dtype=np.int64)
    for x in range(3):
        for y in range(3):
            for z in range(3):
                at[which], at[other], at[3 - which - other] = x, y, z
                for e in range(6):
                    value = E[at[0], at[1], at[2], e]
                    M[x, e, 3 * y + z] = value
                    M[x, 6 + e, 3 * y + 3 + z] = value
    for e in range(SIZE):
        size = 1e-300
        for x in range(3):
            for k in range(SIZE):
                size = max(size, abs(M[x, e, k]))
        for x in range(3):
            for k in range(SIZE):
                M[x, e, k] /= size
