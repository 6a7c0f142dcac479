"""How far contours are from each other by other formulas than offsets are made by, compiled.

A segment here is a row ``ax ay bx by turn cx cy r``: where it begins and ends, how far it turns (at
most half a turn), and centre and radius; of a line the radius is infinite. Distances are taken
between points that lie on the segments, wherever rounding puts the centre of an arc that is nearly
straight. What is searched is in a tree of boxes over segments in their order: node 1 is the root,
node j has the children 2 j and 2 j + 1, the last half of the nodes are runs of a few segments.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

FLAT = 100.0
"""Arcs of a larger radius are searched along the chord; parts are of about the size 1."""
_STRAIGHT = 1e5
"""Arcs of a larger radius cross where their chords do."""

_SAME = 1e-9
_ROUNDING = 1e-13
RUN = 4


@fast_kernel
def segments_of(vertices: FloatArray, bulges: FloatArray, starts: FloatArray) -> FloatArray:
    """Give closed loops as rows of segments, arcs over half a turn in two."""
    return loops_of_segments(vertices, bulges, starts)[0]


@fast_kernel
def loops_of_segments(
    vertices: FloatArray, bulges: FloatArray, starts: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give closed loops as rows of segments, and the first of each loop and how many there are."""
    m = vertices.shape[0]
    Q = np.empty((2 * m, 8))
    firsts = np.zeros(starts.shape[0])
    n = 0
    for loop in range(starts.shape[0] - 1):
        first, end = int(starts[loop]), int(starts[loop + 1])
        firsts[loop] = n
        for i in range(first, end):
            j = i + 1 if i + 1 < end else first
            ax, ay, bx, by = vertices[i, 0], vertices[i, 1], vertices[j, 0], vertices[j, 1]
            if ax == bx and ay == by:
                continue
            bulge = bulges[i]
            if abs(bulge) <= 1.0 + 1e-12:
                _set(Q, n, (ax, ay, bx, by), bulge)
                n += 1
                continue
            # the middle of the arc stands over that of the chord by half bulge times chord; of half
            # the turn the bulge is tan(t / 8) where it was tan(t / 4)
            mx = 0.5 * (ax + bx) + 0.5 * bulge * (by - ay)
            my = 0.5 * (ay + by) - 0.5 * bulge * (bx - ax)
            half = bulge / (1.0 + math.sqrt(1.0 + bulge * bulge))
            _set(Q, n, (ax, ay, mx, my), half)
            _set(Q, n + 1, (mx, my, bx, by), half)
            n += 2
    firsts[starts.shape[0] - 1] = n
    return Q[:n], firsts


@fast_kernel
def _set(Q: FloatArray, n: int, ends: tuple[float, float, float, float], bulge: float) -> None:
    """Write a segment."""
    ax, ay, bx, by = ends
    Q[n, 0], Q[n, 1], Q[n, 2], Q[n, 3] = ax, ay, bx, by
    Q[n, 4], Q[n, 5], Q[n, 6], Q[n, 7] = 0.0, 0.0, 0.0, math.inf
    if bulge != 0.0:
        h = 0.25 * (1.0 - bulge * bulge) / bulge
        c = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        Q[n, 4] = 4.0 * math.atan(bulge)
        Q[n, 5], Q[n, 6] = 0.5 * (ax + bx) - h * (by - ay), 0.5 * (ay + by) + h * (bx - ax)
        Q[n, 7] = 0.25 * c * (1.0 + bulge * bulge) / abs(bulge)


@fast_kernel
def foot(Q: FloatArray, i: int, x: float, y: float) -> tuple[float, float]:
    """Give the point of a segment that is nearest to a point."""
    ax, ay, bx, by, turn = Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3], Q[i, 4]
    ex, ey = bx - ax, by - ay
    c2 = ex * ex + ey * ey
    if Q[i, 7] == math.inf:
        t = max(0.0, min(1.0, ((x - ax) * ex + (y - ay) * ey) / c2))
        return ax + t * ex, ay + t * ey
    if Q[i, 7] > FLAT:
        return _flat_foot(Q, i, x, y, c2)
    cx, cy = Q[i, 5], Q[i, 6]
    px, py = x - cx, y - cy
    ux, uy = ax - cx, ay - cy
    vx, vy = bx - cx, by - cy
    # of half a turn at most, it is what lies to the inner side of both radii
    sign = 1.0 if turn > 0.0 else -1.0
    if sign * (ux * py - uy * px) < 0.0 or sign * (px * vy - py * vx) < 0.0:
        da, db = (x - ax) ** 2 + (y - ay) ** 2, (x - bx) ** 2 + (y - by) ** 2
        return (ax, ay) if da <= db else (bx, by)
    away = math.sqrt(px * px + py * py)
    if away == 0.0:
        return ax, ay
    return cx + Q[i, 7] / away * px, cy + Q[i, 7] / away * py


@fast_kernel
def _flat_foot(Q: FloatArray, i: int, x: float, y: float, c2: float) -> tuple[float, float]:
    """Give the point of a nearly straight arc that is nearest to a point of the neighbourhood."""
    ax, ay, turn = Q[i, 0], Q[i, 1], Q[i, 4]
    ex, ey = Q[i, 2] - ax, Q[i, 3] - ay
    f = max(0.0, min(1.0, ((x - ax) * ex + (y - ay) * ey) / c2))
    px, py = ax, ay
    for _ in range(5):
        # the chord up to there, and the tangent; its curvature is at most 1 / 100 of the size
        grown = math.sin(0.5 * f * turn) / math.sin(0.5 * turn)
        bend = 0.5 * (f - 1.0) * turn
        co, si = math.cos(bend), math.sin(bend)
        px, py = ax + grown * (co * ex - si * ey), ay + grown * (si * ex + co * ey)
        bend = (f - 0.5) * turn
        co, si = math.cos(bend), math.sin(bend)
        step = ((x - px) * (co * ex - si * ey) + (y - py) * (si * ex + co * ey)) / c2
        f = max(0.0, min(1.0, f + step))
    if f == 0.0:
        return ax, ay
    if f == 1.0:
        return Q[i, 2], Q[i, 3]
    return px, py


@fast_kernel
def _gap2(Q: FloatArray, i: int, x: float, y: float) -> float:
    """Give the square of how far a point is from a segment."""
    fx, fy = foot(Q, i, x, y)
    far2: float = (x - fx) ** 2 + (y - fy) ** 2
    return far2


@fast_kernel
def gap(Q: FloatArray, i: int, x: float, y: float) -> float:
    """Give how far a point is from a segment."""
    return math.sqrt(_gap2(Q, i, x, y))


@fast_kernel
def nearest_of(R: FloatArray, r: int, Q: FloatArray, i: int) -> tuple[float, float, float]:
    """Give the least distance of two segments that do not meet, and where on the first it is."""
    # it is at an end of either, or where they have one normal: on a line through a centre
    bx, by = R[r, 0], R[r, 1]
    best = _gap2(Q, i, bx, by)
    far2 = _gap2(Q, i, R[r, 2], R[r, 3])
    if far2 < best:
        best, bx, by = far2, R[r, 2], R[r, 3]
    for end in (0, 2):
        x, y = foot(R, r, Q[i, end], Q[i, end + 1])
        far2 = (x - Q[i, end]) ** 2 + (y - Q[i, end + 1]) ** 2
        if far2 < best:
            best, bx, by = far2, x, y
    if Q[i, 7] < math.inf:
        x, y = foot(R, r, Q[i, 5], Q[i, 6])
        far2 = _gap2(Q, i, x, y)
        if far2 < best:
            best, bx, by = far2, x, y
        if R[r, 7] < math.inf:
            # the other of the two points on the line through both centres
            x, y = foot(R, r, 2.0 * R[r, 5] - Q[i, 5], 2.0 * R[r, 6] - Q[i, 6])
            far2 = _gap2(Q, i, x, y)
            if far2 < best:
                best, bx, by = far2, x, y
    elif R[r, 7] < math.inf:
        # the point of the arc farthest along the line's normal, to the side of the line
        ex, ey = Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1]
        c = math.sqrt(ex * ex + ey * ey)
        side = (R[r, 5] - Q[i, 0]) * ey - (R[r, 6] - Q[i, 1]) * ex
        step = math.copysign(R[r, 7] / c, -side)
        x, y = foot(R, r, R[r, 5] + step * ey, R[r, 6] - step * ex)
        far2 = _gap2(Q, i, x, y)
        if far2 < best:
            best, bx, by = far2, x, y
    return math.sqrt(best), bx, by


@fast_kernel
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


@fast_kernel
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


@fast_kernel
def height(Q: FloatArray, i: int) -> float:
    """Give how high the middle of a segment stands over its chord, as a share of that."""
    return 0.0 if Q[i, 7] == math.inf else 0.5 * math.tan(0.25 * Q[i, 4])


@fast_kernel
def middle(Q: FloatArray, i: int) -> tuple[float, float]:
    """Give the middle of a segment."""
    h = height(Q, i)
    x = 0.5 * (Q[i, 0] + Q[i, 2]) + h * (Q[i, 3] - Q[i, 1])
    y = 0.5 * (Q[i, 1] + Q[i, 3]) - h * (Q[i, 2] - Q[i, 0])
    return x, y


@fast_kernel
def tree_about(Q: FloatArray) -> FloatArray:
    """Give the tree of boxes about segments."""
    leaves = 1
    while leaves * RUN < Q.shape[0]:
        leaves *= 2
    T = np.empty((2 * leaves, 4))
    for leaf in range(leaves):
        x0, y0, x1, y1 = math.inf, math.inf, -math.inf, -math.inf
        for i in range(leaf * RUN, min(Q.shape[0], leaf * RUN + RUN)):
            ax, ay, bx, by = Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3]
            # the arc is no farther from its chord than its height; of half a turn at most, each
            # end leaves at most at a right angle
            h = 0.0
            if Q[i, 7] < math.inf:
                h = abs(height(Q, i)) * math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            x0, x1 = min(x0, min(ax, bx) - h), max(x1, max(ax, bx) + h)
            y0, y1 = min(y0, min(ay, by) - h), max(y1, max(ay, by) + h)
        T[leaves + leaf, 0], T[leaves + leaf, 1] = x0, y0
        T[leaves + leaf, 2], T[leaves + leaf, 3] = x1, y1
    for node in range(leaves - 1, 0, -1):
        left, right = 2 * node, 2 * node + 1
        T[node, 0], T[node, 1] = min(T[left, 0], T[right, 0]), min(T[left, 1], T[right, 1])
        T[node, 2], T[node, 3] = max(T[left, 2], T[right, 2]), max(T[left, 3], T[right, 3])
    return T


@fast_kernel
def beyond2(T: FloatArray, node: int, x: float, y: float) -> float:
    """Give the square of how far a point is from a box."""
    dx = max(T[node, 0] - x, 0.0, x - T[node, 2])
    dy = max(T[node, 1] - y, 0.0, y - T[node, 3])
    far2: float = dx * dx + dy * dy
    return far2


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


@fast_kernel
def touching(
    R: FloatArray, Q: FloatArray, T: FloatArray, reach: tuple[float, float], found: FloatArray
) -> tuple[FloatArray, int]:
    """Measure as `measured` does, and give which segments lie along each other, middles at least.

    Returns:
        Rows (segment of the part, segment of the result), and how many there are.
    """
    d, slack = reach
    pairs = np.empty((4 * R.shape[0] + 16, 2))
    leaves, count = T.shape[0] // 2, 0
    stack = np.empty(128, np.int64)
    least, most = math.inf, 0.0
    for r in range(R.shape[0]):
        mx, my = middle(R, r)
        chord2 = (R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2
        # of half a turn at most, nothing on it is farther from its middle than its ends
        h = height(R, r)
        half = math.sqrt(chord2 * (0.25 + h * h))
        sag, chord = abs(h) * math.sqrt(chord2), math.sqrt(chord2)
        wx, wy = (R[r, 2] - R[r, 0]) / chord, (R[r, 3] - R[r, 1]) / chord
        wide = (d + slack + half) ** 2
        at_start, at_middle = math.inf, math.inf
        stack[0], top = 1, 1
        while top > 0:
            top -= 1
            node = stack[top]
            if beyond2(T, node, mx, my) > wide:
                continue
            if node < leaves:
                stack[top], stack[top + 1] = 2 * node, 2 * node + 1
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
                if bound >= d - _ROUNDING:
                    least = min(least, bound)
                else:
                    near, x, y = nearest_of(R, r, Q, i)
                    if near < least:
                        least, found[1], found[2] = near, x, y
                if far < half and meet(R, r, Q, i, min(_SAME, 1e-3 * d)):
                    least, found[1], found[2] = 0.0, mx, my
                if far <= d + slack:
                    if count == pairs.shape[0]:
                        wider = np.empty((2 * count, 2))
                        wider[:count] = pairs
                        pairs = wider
                    pairs[count, 0], pairs[count, 1] = i, r
                    count += 1
        if at_start > most:
            most, found[4], found[5] = at_start, R[r, 0], R[r, 1]
        if at_middle > most:
            most, found[4], found[5] = at_middle, mx, my
    found[0], found[3] = least, most
    return pairs, count
