"""Arms of four and five joints whose tool shall merely be somewhere, or point somewhere.

A position leaves the pitch open, and of five joints the roll: both keep the seed's value, the pitch
as far as the arm reaches with it. Rows of results are as in module parallel_kernel.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .hobby_kernel import ahead, planar, point_of, size_of
from .parallel_kernel import turn_to_reach


@kernel
def placed(
    P: FloatArray,
    five: bool,
    p: FloatArray,
    tool: FloatArray,
    seed: FloatArray,
    out: FloatArray,
    tolerance: float,
) -> int:
    """Give the branches that meet the point ``p`` alone."""
    ca0, sa0 = P[0, 2], P[0, 3]
    c4, s4 = (math.cos(seed[4]), math.sin(seed[4])) if five else (1.0, 0.0)
    bx, by, bz = point_of(P, five, c4, s4, tool[0, 3], tool[1, 3], tool[2, 3])
    n0, c0, s0, c0b, s0b = ahead(P, p[0], p[1], p[2], bz, size_of(P), seed[0])
    found = 0
    for i in range(n0):
        if i:
            c0, s0 = c0b, s0b
        ty, tz = c0 * p[1] - s0 * p[0], p[2] - P[0, 1]
        vx, vy = c0 * p[0] + s0 * p[1] - P[0, 0], ca0 * ty + sa0 * tz
        pitch = seed[1] + seed[2] + seed[3]
        pitch = turn_to_reach(vx, vy, bx, by, P[1, 0], P[2, 0], pitch)
        found = planar(
            P, c0, s0, math.cos(pitch), math.sin(pitch), c4, s4, p[0], p[1], p[2], bx, by, bz,
            seed, out, found, 4.0 * i, tolerance,
        )  # fmt: skip
    return found
