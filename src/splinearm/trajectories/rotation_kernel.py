"""Products of turns by polynomials, as cumulative B-splines are, sampled on bare arrays.

A curve comes as one array ``table``, shape (k + 1, width), so that a call passes few arguments.
Row i < k holds a piece: its start, the orientation before all turns (w x y z), then for each turn
its axis, its angle, and the share of it as a polynomial of u less the start: coefficients of
falling powers. Row k holds the end of the domain, the degree and the number of turns.

A state is ten numbers: quaternion, angular velocity and angular acceleration in the fixed frame.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel
from splinearm.kinematics.sine_kernel import sine_and_cosine

HEAD = 5
"""Numbers in a row before the first turn, and of a turn of degree 0."""

OUTSIDE = 1
MISFIT = 2


@fast_kernel
def piece_of(table: FloatArray, u: float) -> int:
    """Give the piece in which a parameter of the domain lies."""
    low, high = 0, table.shape[0] - 1
    while high - low > 1:
        middle = (low + high) >> 1
        if u >= table[middle, 0]:
            low = middle
        else:
            high = middle
    return low


@fast_kernel
def fill_state(table: FloatArray, piece: int, u: float, state: FloatArray) -> None:
    """Write the state at a parameter of a piece, shape (10,)."""
    # Sommer et al., Efficient derivative computation for cumulative B-splines on Lie groups, CVPR
    # 2020, eq. 7 to 9: from turn to turn the rates so far are written in the frame behind it
    last = table.shape[0] - 1
    degree, turns = int(table[last, 1]), int(table[last, 2])
    row = table[piece]
    x = u - row[0]
    w, qx, qy, qz = row[1], row[2], row[3], row[4]
    o0, o1, o2 = 0.0, 0.0, 0.0
    a0, a1, a2 = 0.0, 0.0, 0.0
    at = HEAD
    for _ in range(turns):
        n0, n1, n2, angle = row[at], row[at + 1], row[at + 2], row[at + 3]
        b, slope, bend = row[at + 4], 0.0, 0.0
        for i in range(at + 5, at + 5 + degree):
            bend = bend * x + slope
            slope = slope * x + b
            b = b * x + row[i]
        at += degree + HEAD
        slope *= angle
        bend *= 2.0 * angle
        s, c = sine_and_cosine(0.5 * angle * b)
        # v turned back by the angle is v - 2 s c n x v + 2 s^2 n x (n x v)
        c1, s2 = 2.0 * s * c, 2.0 * s * s
        m0, m1, m2 = n1 * o2 - n2 * o1, n2 * o0 - n0 * o2, n0 * o1 - n1 * o0
        o0 += s2 * (n1 * m2 - n2 * m1) - c1 * m0
        o1 += s2 * (n2 * m0 - n0 * m2) - c1 * m1
        o2 += s2 * (n0 * m1 - n1 * m0) - c1 * m2
        m0, m1, m2 = n1 * a2 - n2 * a1, n2 * a0 - n0 * a2, n0 * a1 - n1 * a0
        a0 += s2 * (n1 * m2 - n2 * m1) - c1 * m0 + slope * (o1 * n2 - o2 * n1) + bend * n0
        a1 += s2 * (n2 * m0 - n0 * m2) - c1 * m1 + slope * (o2 * n0 - o0 * n2) + bend * n1
        a2 += s2 * (n0 * m1 - n1 * m0) - c1 * m2 + slope * (o0 * n1 - o1 * n0) + bend * n2
        o0 += slope * n0
        o1 += slope * n1
        o2 += slope * n2
        x0, x1, x2 = s * n0, s * n1, s * n2
        w, qx, qy, qz = (
            w * c - qx * x0 - qy * x1 - qz * x2,
            w * x0 + qx * c + qy * x2 - qz * x1,
            w * x1 - qx * x2 + qy * c + qz * x0,
            w * x2 + qx * x1 - qy * x0 + qz * c,
        )
    length = 1.0 / math.sqrt(w * w + qx * qx + qy * qy + qz * qz)
    w, qx, qy, qz = w * length, qx * length, qy * length, qz * length
    state[0], state[1], state[2], state[3] = w, qx, qy, qz
    m0, m1, m2 = qy * o2 - qz * o1, qz * o0 - qx * o2, qx * o1 - qy * o0
    state[4] = o0 + 2.0 * (w * m0 + qy * m2 - qz * m1)
    state[5] = o1 + 2.0 * (w * m1 + qz * m0 - qx * m2)
    state[6] = o2 + 2.0 * (w * m2 + qx * m1 - qy * m0)
    m0, m1, m2 = qy * a2 - qz * a1, qz * a0 - qx * a2, qx * a1 - qy * a0
    state[7] = a0 + 2.0 * (w * m0 + qy * m2 - qz * m1)
    state[8] = a1 + 2.0 * (w * m1 + qz * m0 - qx * m2)
    state[9] = a2 + 2.0 * (w * m2 + qx * m1 - qy * m0)


@fast_kernel
def sample_one(table: FloatArray, u: float, state: FloatArray) -> int:
    """Write the state at one parameter, shape (10,).

    Returns:
        0, or what was wrong (OUTSIDE, MISFIT): then nothing was written.
    """
    if not (table[0, 0] <= u <= table[table.shape[0] - 1, 0]):
        return OUTSIDE
    if state.shape[0] != 10:
        return MISFIT
    fill_state(table, piece_of(table, u), u, state)
    return 0


@fast_kernel
def sample_many(
    table: FloatArray, us: FloatArray, quat: FloatArray, omega: FloatArray, alpha: FloatArray
) -> int:
    """Write states at many parameters, shapes (m,), (m, 4), (m, 3) and (m, 3).

    Returns:
        -1, or the first parameter outside the domain: then nothing behind it was written.
    """
    start, end = table[0, 0], table[table.shape[0] - 1, 0]
    piece, low, high = 0, table[0, 0], table[1, 0]
    state = np.empty(10)
    for m in range(us.shape[0]):
        u = us[m]
        # neighbours often lie in the same piece
        if not (low <= u < high):
            if not (start <= u <= end):
                return m
            piece = piece_of(table, u)
            low, high = table[piece, 0], table[piece + 1, 0]
        fill_state(table, piece, u, state)
        for i in range(4):
            quat[m, i] = state[i]
        for i in range(3):
            omega[m, i] = state[4 + i]
            alpha[m, i] = state[7 + i]
    return -1
