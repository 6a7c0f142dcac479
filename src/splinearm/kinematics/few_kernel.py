"""All branches of arms of four and five joints for targets of which a part is free.

An arm comes as one array ``G``, shape (n + 7, 6), as in module six_kernel.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .hobby_kernel import level, pitched, pointed, whole
from .reach_kernel import placed
from .subproblem_kernel import product, wrap

NOTHING = 0
YAW = 1
ROLL = 2
YAW_AND_ROLL = 3
ORIENTATION = 4


@kernel
def solve(
    G: FloatArray, T: FloatArray, seed: FloatArray, free: int, axis: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Give branches, shape (m, n), rad, and what they are, shape (m,), of a pose T_base_tool.

    ``axis`` is the tool's pointing axis in the tool frame.
    """
    n = len(seed)
    five = n == 5
    P, back, last = G[:n], G[n : n + 3], G[n + 3 : n + 6]
    A, B, tool = np.empty((3, 4)), np.empty((3, 4)), np.empty((3, 4))
    product(back, T, A)
    product(A, last, B)
    for i in range(3):
        for j in range(3):
            tool[i, j] = last[j, i]
        tool[i, 3] = -(last[0, i] * last[0, 3] + last[1, i] * last[1, 3] + last[2, i] * last[2, 3])
    angles = np.zeros(5)
    for k in range(n):
        angles[k] = G[k, 4] + G[k, 5] * seed[k]
    work = np.zeros((16, 14))
    p, up = np.empty(3), np.empty(3)
    for i in range(3):
        p[i], up[i] = A[i, 3], B[2, i]
    if free == NOTHING:
        found = whole(P, five, B, angles, work, tolerance)
    elif free == YAW:
        found = level(P, five, p, up, tool, angles, work, tolerance)
    elif free == ROLL:
        found = pointed(P, p, B, tool, angles, work, tolerance)
    elif free == ORIENTATION:
        found = placed(P, five, p, tool, angles, work, tolerance)
    else:
        along = np.empty(3)
        for i in range(3):
            along[i] = tool[i, 0] * axis[0] + tool[i, 1] * axis[1] + tool[i, 2] * axis[2]
        pitch = A[2, 0] * axis[0] + A[2, 1] * axis[1] + A[2, 2] * axis[2]
        found = pitched(P, five, p, pitch, along, tool, angles, work, tolerance)
    q, code = np.empty((found, n)), np.empty(found)
    m = 0
    for i in range(found):
        row = work[i]
        if row[13] != 0.0:
            continue
        for k in range(n):
            q[m, k] = wrap(G[k, 5] * (math.atan2(row[2 * k + 1], row[2 * k]) - G[k, 4]))
        code[m] = row[12]
        m += 1
    return q[:m], code[:m]
