"""How near and how far the segments of a result are from the part, compiled.

Distances are exact: between segments as rows of ``offset_check_kernel``.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel, inner_kernel

from .offset_check_kernel import (
    RUN,
    beyond2,
    foot,
    gap,
    gap2,
    height,
    middle,
    spread,
    tree_about,
)

_STRAIGHT = 1e5
"""Arcs of a larger radius cross where their chords do."""
_ROUND = 10.0
"""The places of larger circles are not known well enough to compare circles instead of arcs."""
_SAME = 1e-9
_ALONG = 2e-9
"""What lies along a segment has its middle no farther from it than d and this."""
_SQUARE = 1e-3
_ROUNDING = 1e-13


@bare_kernel
def _least2(R: FloatArray, r: int, Q: FloatArray, i: int) -> float:
    """Give the square of the least distance of two segments that do not meet."""
    # it is at an end of either, or where they have one normal: on a line through a centre
    best = min(gap2(Q, i, R[r, 0], R[r, 1]), gap2(Q, i, R[r, 2], R[r, 3]))
    best = min(best, gap2(R, r, Q[i, 0], Q[i, 1]), gap2(R, r, Q[i, 2], Q[i, 3]))
    if Q[i, 7] < math.inf or R[r, 7] < math.inf:
        x, y, count = _level_with(R, r, Q, i, 0)
        best = min(best, gap2(Q, i, x, y))
        if count == 2:
            x, y, _ = _level_with(R, r, Q, i, 1)
            best = min(best, gap2(Q, i, x, y))
    return best


@bare_kernel
def _level_with(
    R: FloatArray, r: int, Q: FloatArray, i: int, which: int
) -> tuple[float, float, int]:
    """Give a point of the first segment where both have one normal, if it is within both.

    Of two arcs there are two; it says how many.
    """
    if Q[i, 7] < math.inf:
        if which == 0:
            x, y = foot(R, r, Q[i, 5], Q[i, 6])
        else:
            # the other of the two points on the line through both centres
            x, y = foot(R, r, 2.0 * R[r, 5] - Q[i, 5], 2.0 * R[r, 6] - Q[i, 6])
        return x, y, 2 if R[r, 7] < math.inf else 1
    # the point of the arc farthest along the line's normal, to the side of the line
    ex, ey = Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1]
    c = math.sqrt(ex * ex + ey * ey)
    side = (R[r, 5] - Q[i, 0]) * ey - (R[r, 6] - Q[i, 1]) * ex
    step = math.copysign(R[r, 7] / c, -side)
    x, y = foot(R, r, R[r, 5] + step * ey, R[r, 6] - step * ex)
    return x, y, 1


@bare_kernel
def nearest_of(R: FloatArray, r: int, Q: FloatArray, i: int) -> tuple[float, float, float]:
    """Give the least distance of two segments that do not meet, and where on the first it is."""
    best, bx, by = gap2(Q, i, R[r, 0], R[r, 1]), R[r, 0], R[r, 1]
    far2 = gap2(Q, i, R[r, 2], R[r, 3])
    if far2 < best:
        best, bx, by = far2, R[r, 2], R[r, 3]
    for end in (0, 2):
        x, y = foot(R, r, Q[i, end], Q[i, end + 1])
        far2 = (x - Q[i, end]) ** 2 + (y - Q[i, end + 1]) ** 2
        if far2 < best:
            best, bx, by = far2, x, y
    if Q[i, 7] < math.inf or R[r, 7] < math.inf:
        for which in range(2):
            x, y, count = _level_with(R, r, Q, i, which)
            far2 = gap2(Q, i, x, y)
            if far2 < best:
                best, bx, by = far2, x, y
            if count == 1:
                break
    return math.sqrt(best), bx, by


@bare_kernel
def _crosses(R: FloatArray, r: int, Q: FloatArray, i: int) -> bool:
    """Say whether two chords cross."""
    ex, ey = R[r, 2] - R[r, 0], R[r, 3] - R[r, 1]
    fx, fy = Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1]
    a = ex * (Q[i, 1] - R[r, 1]) - ey * (Q[i, 0] - R[r, 0])
    b = ex * (Q[i, 3] - R[r, 1]) - ey * (Q[i, 2] - R[r, 0])
    c = fx * (R[r, 1] - Q[i, 1]) - fy * (R[r, 0] - Q[i, 0])
    d = fx * (R[r, 3] - Q[i, 1]) - fy * (R[r, 2] - Q[i, 0])
    both: bool = a * b < 0.0 and c * d < 0.0
    return both


@bare_kernel
def meet(R: FloatArray, r: int, Q: FloatArray, i: int, same: float) -> bool:
    """Say whether two segments have a point in common."""
    if Q[i, 7] < R[r, 7]:
        R, r, Q, i = Q, i, R, r
    if R[r, 7] > _STRAIGHT:
        return _crosses(R, r, Q, i)
    cx, cy, s = R[r, 5], R[r, 6], R[r, 7]
    if Q[i, 7] > _STRAIGHT:
        ex, ey = Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1]
        c = math.hypot(ex, ey)
        ex /= c
        ey /= c
        off = (cx - Q[i, 0]) * ey - (cy - Q[i, 1]) * ex
        ox, oy = cx - off * ey, cy + off * ex
        nx, ny = ey, -ex
    else:
        nx, ny = Q[i, 5] - cx, Q[i, 6] - cy
        c = math.hypot(nx, ny)
        if c <= same:
            return False
        nx /= c
        ny /= c
        off = 0.5 * (c + (s - Q[i, 7]) * (s + Q[i, 7]) / c)
        ox, oy = cx + off * nx, cy + off * ny
    if abs(off) >= s:
        return False
    half = math.sqrt((s - off) * (s + off))
    for sign in (-1.0, 1.0):
        x, y = ox - sign * half * ny, oy + sign * half * nx
        if gap(R, r, x, y) <= same and gap(Q, i, x, y) <= same:
            return True
    return False


@bare_kernel
def _bound(
    Q: FloatArray,
    i: int,
    spot: tuple[float, float],
    run: tuple[float, float, float],
    sag: float,
) -> float:
    """Give what a segment is at least away from another.

    Args:
        Q: Segments.
        i: The one of them.
        spot: The middle of the other.
        run: The direction of its chord, and how far its ends are from its middle.
        sag: How far it is from its chord at most.
    """
    ax, ay = Q[i, 0], Q[i, 1]
    ex, ey = Q[i, 2] - ax, Q[i, 3] - ay
    px, py = spot[0] - ax, spot[1] - ay
    c2 = ex * ex + ey * ey
    t = max(0.0, min(1.0, (px * ex + py * ey) / c2))
    px -= t * ex
    py -= t * ey
    far = math.sqrt(px * px + py * py)
    # along a line the distance from the chord is convex: it lies over its tangent
    least = far - abs(px * run[0] + py * run[1]) / max(far, 1e-300) * run[2] - 2.0 * sag
    # an arc of half a turn at most is no farther from its chord than that
    bound: float = max(least, far - run[2]) - 0.25 * c2 / Q[i, 7]
    return bound


@bare_kernel
def _known(Q: FloatArray, i: int) -> bool:
    """Say whether a segment is a line or an arc whose centre is known well."""
    known: bool = Q[i, 7] <= _ROUND or Q[i, 7] == math.inf
    return known


@bare_kernel
def _apart(R: FloatArray, r: int, Q: FloatArray, i: int) -> float:
    """Give how far a segment is at least from the circle of another, or the line, or below 0."""
    x, y, u, v = R[r, 0], R[r, 1], R[r, 2], R[r, 3]
    if Q[i, 7] < math.inf:
        least, most = spread((x, y, u, v), (R[r, 5], R[r, 6], R[r, 4]), Q[i, 5], Q[i, 6])
        beside: float = max(least - Q[i, 7], Q[i, 7] - most)
        return beside
    ax, ay = Q[i, 0], Q[i, 1]
    ex, ey = Q[i, 2] - ax, Q[i, 3] - ay
    c = math.sqrt(ex * ex + ey * ey)
    nx, ny = -ey / c, ex / c
    first, last = nx * (x - ax) + ny * (y - ay), nx * (u - ax) + ny * (v - ay)
    low, high = min(first, last), max(first, last)
    if R[r, 7] < math.inf:
        px, py, qx, qy = x - R[r, 5], y - R[r, 6], u - R[r, 5], v - R[r, 6]
        a, b = (px * ny - py * nx) * R[r, 4], (nx * qy - ny * qx) * R[r, 4]
        middle = nx * (R[r, 5] - ax) + ny * (R[r, 6] - ay)
        if a >= 0.0 and b >= 0.0:
            high = max(high, middle + R[r, 7])
        if a <= 0.0 and b <= 0.0:
            low = min(low, middle - R[r, 7])
    off: float = max(low, -high)
    return off


@fast_kernel
def measured(R: FloatArray, Q: FloatArray, d: float, slack: float, found: FloatArray) -> None:
    """Write how near and how far the segments of a result are from the part.

    Args:
        R: Segments of the result.
        Q: Segments of the part.
        d: The distance they should have.
        slack: What is looked for beyond it.
        found: The least distance anywhere and where (x, y); the largest distance of an end or a
            middle and where (x, y); infinite if beyond d and the slack. Shape (6,).
    """
    touching(R, Q, tree_about(Q), (d, slack), found)


@fast_kernel
def touching(
    R: FloatArray, Q: FloatArray, T: FloatArray, reach: tuple[float, float], found: FloatArray
) -> tuple[FloatArray, int]:
    """Measure as `measured` does, and give which segments lie along each other, middles at least.

    Returns:
        Rows (segment of the part, segment of the result), and how many there are.
    """
    n = Q.shape[0]
    pairs = np.empty((4 * R.shape[0] + n, 2))
    stack = np.empty(128)
    found[0], found[3] = math.inf, 0.0
    r, count = 0, 0
    while True:
        r, count = _touch_all(R, r, (Q, T), reach, found, (pairs, count, stack))
        if r == R.shape[0]:
            return pairs, count
        wider = np.empty((2 * pairs.shape[0], 2))
        wider[:count] = pairs[:count]
        pairs = wider


@bare_kernel
def _is_square(
    Q: FloatArray, i: int, spot: tuple[float, float], way: tuple[float, float], far: float
) -> bool:
    """Say whether the way to the nearest place of a segment is about square to a direction."""
    x, y = foot(Q, i, spot[0], spot[1])
    return abs((x - spot[0]) * way[0] + (y - spot[1]) * way[1]) <= _SQUARE * far


@bare_kernel
def _touch_all(
    R: FloatArray,
    r: int,
    part: tuple[FloatArray, FloatArray],
    reach: tuple[float, float],
    found: FloatArray,
    work: tuple[FloatArray, int, FloatArray],
) -> tuple[int, int]:
    """Measure segments from one on while there is room, and give the next and how many pairs."""
    pairs, count, stack = work
    while r < R.shape[0] and count + part[0].shape[0] <= pairs.shape[0]:
        count = _touch(R, r, part, reach, found, (pairs, count, stack))
        r += 1
    return r, count


@inner_kernel
def _touch(
    R: FloatArray,
    r: int,
    part: tuple[FloatArray, FloatArray],
    reach: tuple[float, float],
    found: FloatArray,
    work: tuple[FloatArray, int, FloatArray],
) -> int:
    """Measure one segment of the result, and give how many pairs there are then."""
    Q, T = part
    d, slack = reach
    pairs, count, stack = work
    leaves = T.shape[0] // 2
    mx, my = middle(R, r)
    chord2 = (R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2
    # of half a turn at most, nothing on it is farther from its middle than its ends
    h = height(R, r)
    half = math.sqrt(chord2 * (0.25 + h * h))
    sag, chord = abs(h) * math.sqrt(chord2), math.sqrt(chord2)
    wx, wy = (R[r, 2] - R[r, 0]) / chord, (R[r, 3] - R[r, 1]) / chord
    wide = (d + slack + half) ** 2
    at_start, at_middle = math.inf, math.inf
    stack[0], top = 1.0, 1
    while top > 0:
        top -= 1
        node = int(stack[top])
        if beyond2(T, node, mx, my) > wide:
            continue
        if node < leaves:
            stack[top], stack[top + 1] = 2.0 * node, 2.0 * node + 1.0
            top += 2
            continue
        first = (node - leaves) * RUN
        for i in range(first, min(Q.shape[0], first + RUN)):
            bound = _bound(Q, i, (mx, my), (wx, wy, half), sag)
            if bound > d + slack:
                continue
            far = gap(Q, i, mx, my)
            at_middle = min(at_middle, far)
            if at_start > d + _ROUNDING:  # else it is near enough
                at_start = min(at_start, gap(Q, i, R[r, 0], R[r, 1]))
            if bound < d - _ROUNDING and _known(Q, i) and _known(R, r):
                bound = max(bound, _apart(R, r, Q, i))
            if bound >= d - _ROUNDING:
                found[0] = min(found[0], bound)
            elif _least2(R, r, Q, i) < found[0] ** 2:
                found[0], found[1], found[2] = nearest_of(R, r, Q, i)
            if far < half and meet(R, r, Q, i, min(_SAME, 1e-3 * d)):
                found[0], found[1], found[2] = 0.0, mx, my
            if far <= d + _ALONG and _is_square(Q, i, (mx, my), (wx, wy), far):
                pairs[count, 0], pairs[count, 1] = i, r
                count += 1
    if at_start > found[3]:
        found[3], found[4], found[5] = at_start, R[r, 0], R[r, 1]
    if at_middle > found[3]:
        found[3], found[4], found[5] = at_middle, mx, my
    return count
