"""Corners that are not round, and ends of paths: what they take besides the distance, compiled.

A corner that is mitred or cut across takes a kite: what lies between the normals before and behind
it and is less than the distance along each of them, and along that of the cut. An end that is
square is a corner that turns straight back and is cut across.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .arc_kernel import COLUMNS, set_piece
from .tree_kernel import RUN, overlapping, tree_of

ROUND, MITRE, CHAMFER = 0.0, 1.0, 2.0
SQUARE, HALVES = 1.0, 2.0
"""How ends go: 0 round, 1 square; by 2 more if what goes around them is in two halves."""

Corner = tuple[float, float, float, float]
"""How corners are joined, the largest reach of a mitre as a multiple of the distance, how ends go,
and the last segment of a path that goes there and back, -1 if there are no ends."""

BACK = -math.pi * (1.0 - 1e-9)
"""What turns farther turns straight back."""
_TURN = 1e-6
_KITE = 12


@bare_kernel
def is_end(corner: Corner, segment: float, following: float) -> bool:
    """Say whether a path ends between two segments."""
    last = corner[3]
    return (segment <= last) != (following <= last)


@bare_kernel
def style_of(corner: Corner, turn: float, end: bool) -> float:
    """Say how a corner that turns so far to the right is joined."""
    if end:
        return CHAMFER if corner[2] % HALVES == SQUARE else ROUND
    if corner[0] == ROUND or turn <= BACK:
        return ROUND
    mitred = corner[0] == MITRE and corner[1] * math.cos(0.5 * turn) >= 1.0
    return MITRE if mitred else CHAMFER


@fast_kernel
def kites_of(
    P: FloatArray, segment: FloatArray, loops: FloatArray, d: float, corner: Corner
) -> tuple[FloatArray, FloatArray]:
    """Give the corners that reach farther than d, none if they are round, and their tree.

    Args:
        P: Pieces of the part.
        segment: The segment of each.
        loops: The first piece of each loop and how many there are.
        d: The distance.
        corner: See `Corner`.

    Returns:
        Rows of a corner's place, of the normals before and behind it, between which it lies, of
        the normal of the cut across it, or zeros, and of the box about it.
    """
    edged = corner[0] != ROUND or corner[2] % HALVES == SQUARE
    K = np.empty((P.shape[0] if edged else 0, _KITE))
    m = 0
    for loop in range(loops.shape[0] - 1):
        first, end = int(loops[loop]), int(loops[loop + 1])
        for i in range(first, end if edged else first):
            j = i + 1 if i + 1 < end else first
            ux, uy, vx, vy = P[i, 7], P[i, 8], P[j, 5], P[j, 6]
            turn = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)
            ends = is_end(corner, segment[i], segment[j])
            if ends:
                turn = -math.pi
            if turn >= -_TURN:
                continue
            style = style_of(corner, turn, ends)
            if style == ROUND:
                continue
            co, si = math.cos(0.5 * turn), math.sin(0.5 * turn)
            mx, my = co * ux - si * uy, si * ux + co * uy
            cut = 0.0 if style == MITRE else 1.0
            K[m, 0], K[m, 1], K[m, 2], K[m, 3], K[m, 4], K[m, 5] = P[i, 2], P[i, 3], ux, uy, vx, vy
            K[m, 6], K[m, 7] = cut * mx, cut * my
            # none of it is farther along the middle than the tip, nor beside it
            reach = d / math.cos(0.5 * turn) if style == MITRE else d / math.cos(0.25 * turn)
            K[m, 8], K[m, 9] = P[i, 2] - reach, P[i, 3] - reach
            K[m, 10], K[m, 11] = P[i, 2] + reach, P[i, 3] + reach
            m += 1
    boxes = np.empty((m, COLUMNS))
    for c in range(m):
        set_piece(boxes, c, (K[c, 8], K[c, 9], K[c, 10], K[c, 11]), 0.0)
    return K[:m], tree_of(boxes, m, 0.0)


@bare_kernel
def in_kites(
    K: FloatArray, T: FloatArray, spot: tuple[float, float], d: float, runs: FloatArray
) -> float:
    """Give by how much a place lies in a corner that is not round, at most; 0: in none."""
    x, y = spot
    deepest = 0.0
    count = overlapping(T, (x, y, x, y), 0, runs)
    for k in range(count):
        first = int(runs[k]) * RUN
        for c in range(first, min(K.shape[0], first + RUN)):
            wx, wy = x - K[c, 0], y - K[c, 1]
            if K[c, 2] * wy - K[c, 3] * wx < 0.0 and wx * K[c, 5] - wy * K[c, 4] < 0.0:
                along = max(K[c, 2] * wx + K[c, 3] * wy, K[c, 4] * wx + K[c, 5] * wy)
                along = max(along, K[c, 6] * wx + K[c, 7] * wy)
                deepest = max(deepest, d - along)
    return deepest


@bare_kernel
def goes_around(P: FloatArray, T: FloatArray, spot: tuple[float, float], runs: FloatArray) -> bool:
    """Say whether closed pieces go around a place that none of them is near."""
    x, y = spot
    total = 0
    count = overlapping(T, (x, y, math.inf, y), 0, runs)
    for r in range(count):
        first = int(runs[r]) * RUN
        for i in range(first, min(P.shape[0], first + RUN)):
            ax, ay, bx, by, k = P[i, 0], P[i, 1], P[i, 2], P[i, 3], P[i, 4]
            ex, ey, qx, qy = bx - ax, by - ay, x - ax, y - ay
            side = ex * qy - ey * qx
            # the chord, and what lies between it and its arc
            if (ay <= y < by and side > 0.0) or (by <= y < ay and side < 0.0):
                total += 1 if by > ay else -1
            if k * side < 0.0:
                g = P[i, 5] * qx + P[i, 6] * qy - 0.5 * k * (qx * qx + qy * qy)
                if k * g > 0.0:
                    total += 1 if k > 0.0 else -1
    return total != 0
