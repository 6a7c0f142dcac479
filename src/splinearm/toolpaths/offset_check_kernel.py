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
from splinearm.compiled import bare_kernel, fast_kernel

FLAT = 100.0
"""Arcs of a larger radius are searched along the chord; parts are of about the size 1."""
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


@bare_kernel
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


@bare_kernel
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


@bare_kernel
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


@bare_kernel
def gap2(Q: FloatArray, i: int, x: float, y: float) -> float:
    """Give the square of how far a point is from a segment."""
    if Q[i, 7] <= FLAT:
        px, py = x - Q[i, 5], y - Q[i, 6]
        ux, uy = Q[i, 0] - Q[i, 5], Q[i, 1] - Q[i, 6]
        vx, vy = Q[i, 2] - Q[i, 5], Q[i, 3] - Q[i, 6]
        # beside the arc it is the difference of the radii: half of what `foot` takes
        a, b = ux * py - uy * px, px * vy - py * vx
        if a * Q[i, 4] >= 0.0 and b * Q[i, 4] >= 0.0:
            off: float = math.sqrt(px * px + py * py) - Q[i, 7]
            return off * off
        px, py, ux, uy = x - Q[i, 0], y - Q[i, 1], x - Q[i, 2], y - Q[i, 3]
        at_end: float = min(px * px + py * py, ux * ux + uy * uy)
        return at_end
    fx, fy = foot(Q, i, x, y)
    far2: float = (x - fx) ** 2 + (y - fy) ** 2
    return far2


@bare_kernel
def gap(Q: FloatArray, i: int, x: float, y: float) -> float:
    """Give how far a point is from a segment."""
    return math.sqrt(gap2(Q, i, x, y))


@bare_kernel
def height(Q: FloatArray, i: int) -> float:
    """Give how high the middle of a segment stands over its chord, as a share of that."""
    return 0.0 if Q[i, 7] == math.inf else 0.5 * math.tan(0.25 * Q[i, 4])


@bare_kernel
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


@bare_kernel
def beyond2(T: FloatArray, node: int, x: float, y: float) -> float:
    """Give the square of how far a point is from a box."""
    dx = max(T[node, 0] - x, 0.0, x - T[node, 2])
    dy = max(T[node, 1] - y, 0.0, y - T[node, 3])
    far2: float = dx * dx + dy * dy
    return far2


@bare_kernel
def spread(
    ends: tuple[float, float, float, float],
    arc: tuple[float, float, float],
    qx: float,
    qy: float,
) -> tuple[float, float]:
    """Give the least and the largest distance of a line or an arc from a point.

    Args:
        ends: Where it begins and ends.
        arc: Its centre and turn, at most half a one; 0: a line.
        qx: The point's
        qy: coordinates.
    """
    x, y, u, v = ends
    cx, cy, turn = arc
    first = math.sqrt((x - qx) ** 2 + (y - qy) ** 2)
    last = math.sqrt((u - qx) ** 2 + (v - qy) ** 2)
    least, most = min(first, last), max(first, last)
    if turn == 0.0:
        ex, ey = u - x, v - y
        c2 = ex * ex + ey * ey
        t = (qx - x) * ex + (qy - y) * ey
        if 0.0 < t < c2:
            least = abs((qx - x) * ey - (qy - y) * ex) / math.sqrt(c2)
        return least, most
    ax, ay, bx, by, wx, wy = x - cx, y - cy, u - cx, v - cy, qx - cx, qy - cy
    a, b = (ax * wy - ay * wx) * turn, (wx * by - wy * bx) * turn
    if (a >= 0.0 and b >= 0.0) or (a <= 0.0 and b <= 0.0):
        # the line through both centres meets the arc: on this side, on the other
        away, radius = math.sqrt(wx * wx + wy * wy), math.sqrt(ax * ax + ay * ay)
        if a >= 0.0 and b >= 0.0:
            least = min(least, abs(away - radius))
        if a <= 0.0 and b <= 0.0:
            most = max(most, away + radius)
    return least, most
