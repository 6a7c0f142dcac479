"""What is asked of contours as pieces, compiled: what they go around, and where they cross."""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .arc_kernel import at_share, box_of, circles_meet, distance, share
from .tree_kernel import RUN, nearest, overlapping, tree_of


@bare_kernel
def windings(P: FloatArray, points: FloatArray, found: FloatArray) -> None:
    """Write how often pieces that close go around points, to the left counted positive."""
    for m in range(points.shape[0]):
        x, y = points[m, 0], points[m, 1]
        total = 0
        for i in range(P.shape[0]):
            ax, ay, bx, by, k = P[i, 0], P[i, 1], P[i, 2], P[i, 3], P[i, 4]
            ex, ey, qx, qy = bx - ax, by - ay, x - ax, y - ay
            side = ex * qy - ey * qx
            # the chord, as a polygon has it
            if ay <= y:
                if by > y and side > 0.0:
                    total += 1
            elif by <= y and side < 0.0:
                total -= 1
            # and what lies between the chord and its arc
            if k != 0.0:
                g = P[i, 5] * qx + P[i, 6] * qy - 0.5 * k * (qx * qx + qy * qy)
                # a point on the chord counts to the side that the polygon has it on
                right = side < 0.0 or (side == 0.0 and (by > ay or (by == ay and ex < 0.0)))
                if k > 0.0 and g > 0.0 and right:
                    total += 1
                elif k < 0.0 and g < 0.0 and not right:
                    total -= 1
        found[m] = total


@fast_kernel
def distances(P: FloatArray, points: FloatArray, found: FloatArray) -> None:
    """Write how far points are from the nearest piece."""
    T = tree_of(P, P.shape[0], 0.0)
    stack = np.empty((128, 2))
    for m in range(points.shape[0]):
        point = (points[m, 0], points[m, 1])
        found[m], _ = nearest(P, P.shape[0], T, point, (math.inf, 0.0), stack)


@fast_kernel
def first_crossing(P: FloatArray, loops: FloatArray, tiny: float) -> tuple[int, int, float, float]:
    """Give the first two pieces that cross, and where; -1: none do.

    Pieces that touch do not cross, nor do contours that touch in a corner of both.
    """
    n = P.shape[0]
    T = tree_of(P, n, tiny)
    runs = np.empty(T.shape[0] + 128)
    follower = np.arange(1, n + 1)
    for loop in range(loops.shape[0] - 1):
        if loops[loop + 1] > loops[loop]:
            follower[int(loops[loop + 1]) - 1] = int(loops[loop])
    for i in range(n):
        box = box_of(P, i)
        count = overlapping(T, box, 0, runs)
        for r in range(count):
            first = int(runs[r]) * RUN
            for j in range(first, min(n, first + RUN)):
                if j == i:
                    continue
                # a corner that lies on a piece, with the ways to and from it on two sides
                x, y = P[j, 2], P[j, 3]
                if _well_inside(P, i, x, y, tiny) and distance(P, i, x, y) <= tiny:
                    before = _side(P, i, j, 1.0 - 1e-3)
                    behind = _side(P, i, follower[j], 1e-3)
                    if before * behind < 0.0 and min(abs(before), abs(behind)) > tiny:
                        return i, j, x, y
                if j < i:
                    continue
                # a corner on a corner
                off = max(abs(P[i, 2] - x), abs(P[i, 3] - y))
                if off <= tiny and _corners_cross(P, (i, follower[i], j, follower[j]), tiny):
                    return i, j, x, y
                found, ux, uy, vx, vy = circles_meet(P, i, P, j)
                for k in range(found):
                    x, y = (ux, uy) if k == 0 else (vx, vy)
                    if _well_inside(P, i, x, y, tiny) and _well_inside(P, j, x, y, tiny):
                        # their normals there; where these are one, the pieces touch
                        mx, my = _normal(P, i, x, y)
                        nx, ny = _normal(P, j, x, y)
                        if abs(mx * ny - my * nx) > 1e-7:
                            return i, j, x, y
    return -1, -1, 0.0, 0.0


@fast_kernel
def first_shared(P: FloatArray, loops: FloatArray, tiny: float) -> tuple[int, int, float, float]:
    """Give the first two pieces of different loops that lie along each other, and where; or -1."""
    T = tree_of(P, P.shape[0], tiny)
    runs = np.empty(T.shape[0] + 128)
    for loop in range(loops.shape[0] - 1):
        end = int(loops[loop + 1])
        for i in range(int(loops[loop]), end):
            count = overlapping(T, box_of(P, i), end, runs)
            for r in range(count):
                first = int(runs[r]) * RUN
                for j in range(max(first, end), min(P.shape[0], first + RUN)):
                    along, x, y = shared(P, i, j, tiny)
                    if along:
                        return i, j, x, y
    return -1, -1, 0.0, 0.0


@bare_kernel
def shared(P: FloatArray, i: int, j: int, tiny: float) -> tuple[bool, float, float]:
    """Say whether two pieces have more than points in common, and give the middle of that."""
    found, ux, uy, vx, vy, wide = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    for c in (0, 2):
        for on, of in ((i, j), (j, i)):
            x, y = P[of, c], P[of, c + 1]
            if distance(P, on, x, y) > tiny:
                continue
            if found == 0:
                ux, uy = x, y
            elif max(abs(x - ux), abs(y - uy)) > wide:
                vx, vy, wide = x, y, max(abs(x - ux), abs(y - uy))
            found += 1
    if wide <= 100.0 * tiny:
        return False, 0.0, 0.0
    # between both places on the one piece
    x, y = at_share(P, i, 0.5 * (share(P, i, ux, uy) + share(P, i, vx, vy)))
    return distance(P, j, x, y) <= tiny, x, y


@bare_kernel
def _heading(P: FloatArray, i: int, h: float, back: bool) -> float:
    """Give the direction to the place of a piece that is so far from its start, or its end."""
    bend = math.asin(max(-1.0, min(1.0, 0.5 * P[i, 4] * h)))
    if back:
        return math.atan2(P[i, 7], -P[i, 8]) - bend
    return math.atan2(-P[i, 5], P[i, 6]) + bend


@bare_kernel
def _corners_cross(P: FloatArray, ways: tuple[int, int, int, int], tiny: float) -> bool:
    """Say whether two ways through one corner cross there, which ways along each other do not.

    Args:
        P: Pieces.
        ways: Those that lead to the corner and from it, of one way and of the other.
        tiny: What is nothing.
    """
    h = math.inf
    for i in ways:
        h = min(h, math.sqrt((P[i, 2] - P[i, 0]) ** 2 + (P[i, 3] - P[i, 1]) ** 2))
    if h <= tiny:
        return False
    first = _heading(P, ways[0], h, True)
    wide = (_heading(P, ways[1], h, False) - first) % (2.0 * math.pi)
    one = (_heading(P, ways[2], h, True) - first) % (2.0 * math.pi)
    other = (_heading(P, ways[3], h, False) - first) % (2.0 * math.pi)
    level = 4.0 * tiny / h + 1e-12
    for angle in (one, other):
        if min(angle, abs(angle - wide), 2.0 * math.pi - angle) <= level:
            return False
    return (one < wide) != (other < wide)


@bare_kernel
def _normal(P: FloatArray, i: int, x: float, y: float) -> tuple[float, float]:
    """Give the normal to the left of a piece in one of its points."""
    return P[i, 5] - P[i, 4] * (x - P[i, 0]), P[i, 6] - P[i, 4] * (y - P[i, 1])


@bare_kernel
def _side(P: FloatArray, i: int, j: int, u: float) -> float:
    """Give how far to the left of a piece another is at a share of it."""
    x, y = at_share(P, j, u)
    qx, qy = x - P[i, 0], y - P[i, 1]
    g: float = P[i, 5] * qx + P[i, 6] * qy - 0.5 * P[i, 4] * (qx * qx + qy * qy)
    return g


@bare_kernel
def _well_inside(P: FloatArray, i: int, x: float, y: float, tiny: float) -> bool:
    """Say whether a point near a piece is not at its ends nor beyond."""
    qx, qy, rx, ry = x - P[i, 0], y - P[i, 1], x - P[i, 2], y - P[i, 3]
    ahead: float = qx * P[i, 6] - qy * P[i, 5]
    behind: float = rx * P[i, 8] - ry * P[i, 7]
    return ahead > tiny and behind < -tiny
