"""What is nearest to a point, and whether it is enclosed, asked of segments in a tree, compiled."""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel

from .offset_check_kernel import FLAT, RUN, beyond2, foot, gap


@bare_kernel
def nearest(
    Q: FloatArray,
    T: FloatArray,
    point: tuple[float, float],
    bounds: tuple[float, float],
    stack: FloatArray,
) -> tuple[float, int]:
    """Give the least distance below a bound, to so much, and to which segment; -1: to none."""
    x, y = point
    (best, loose), found = bounds, -1
    leaves = T.shape[0] // 2
    stack[0, 0], stack[0, 1], top = 1.0, beyond2(T, 1, x, y), 1
    while top > 0:
        top -= 1
        limit = max(0.0, best - loose) if found >= 0 else best
        if stack[top, 1] >= limit * limit:
            continue
        node = int(stack[top, 0])
        if node >= leaves:
            first = (node - leaves) * RUN
            for i in range(first, min(Q.shape[0], first + RUN)):
                far = gap(Q, i, x, y)
                if far < best:
                    best, found = far, i
            continue
        left = 2 * node
        dl, dr = beyond2(T, left, x, y), beyond2(T, left + 1, x, y)
        swap = 1 if dl < dr else 0
        # the nearer child on top
        stack[top, 0], stack[top, 1] = left + swap, (dr if swap == 1 else dl)
        stack[top + 1, 0], stack[top + 1, 1] = left + 1 - swap, (dl if swap == 1 else dr)
        top += 2
    return best, found


@bare_kernel
def _side(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Give to which side of a chord a point lies, the same for the chord run the other way."""
    sign = 1.0
    if bx < ax or (bx == ax and by < ay):
        ax, ay, bx, by, sign = bx, by, ax, ay, -1.0
    side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
    if side == 0.0:
        # of points on it those count as above and to the right
        side = ay - by if ay != by else bx - ax
    return sign * side


@bare_kernel
def encloses(Q: FloatArray, T: FloatArray, x: float, y: float, room: FloatArray) -> bool:
    """Say whether closed segments go around a point."""
    # by crossings of the ray to larger x: with the chord, and with the arc where the point lies
    # between both, which is where it is in the disc and on the arc's side of the chord
    odd = False
    leaves = T.shape[0] // 2
    room[0, 0], top = 1.0, 1
    while top > 0:
        top -= 1
        node = int(room[top, 0])
        if y < T[node, 1] or y > T[node, 3] or x > T[node, 2]:
            continue
        if node < leaves:
            room[top, 0], room[top + 1, 0] = 2.0 * node, 2.0 * node + 1.0
            top += 2
            continue
        first = (node - leaves) * RUN
        for i in range(first, min(Q.shape[0], first + RUN)):
            ax, ay, bx, by = Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3]
            side = _side(ax, ay, bx, by, x, y)
            if (ay > y) != (by > y) and (side > 0.0) == (by > ay):
                odd = not odd
            if Q[i, 7] < math.inf and side * Q[i, 4] < 0.0:
                px, py = x - Q[i, 5], y - Q[i, 6]
                within = px * px + py * py < Q[i, 7] * Q[i, 7]
                if Q[i, 7] > FLAT:
                    # the arc itself is farther from the chord
                    fx, fy = foot(Q, i, x, y)
                    height = (bx - ax) * (fy - ay) - (by - ay) * (fx - ax)
                    within = abs(side) < abs(height)
                if within:
                    odd = not odd
    return odd
