"""How far contours are from each other by other formulas than offsets are made by, compiled.

A segment here is a row ``ax ay bx by turn cx cy r``: where it begins and ends, how far it turns (at
most half a turn), and centre and radius; of a line the radius is infinite. Distances are taken
between points that lie on the segments, wherever rounding puts the centre of an arc that is nearly
straight.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

_FLAT = 100.0
"""Arcs of a larger radius are searched along the chord; parts are of about the size 1."""
_STRAIGHT = 1e5
"""Arcs of a larger radius cross where their chords do."""
_SAME = 1e-9
_RUN = 8
_RUNS = 8


@fast_kernel
def segments_of(vertices: FloatArray, bulges: FloatArray, starts: FloatArray) -> FloatArray:
    """Give closed loops as rows of segments, arcs over half a turn in two."""
    m = vertices.shape[0]
    Q = np.empty((2 * m, 8))
    n = 0
    for loop in range(starts.shape[0] - 1):
        first, end = int(starts[loop]), int(starts[loop + 1])
        for i in range(first, end):
            j = i + 1 if i + 1 < end else first
            ax, ay, bx, by = vertices[i, 0], vertices[i, 1], vertices[j, 0], vertices[j, 1]
            if ax == bx and ay == by:
                continue
            turn = 4.0 * math.atan(bulges[i])
            parts = 2 if abs(turn) > math.pi * (1.0 + 1e-12) else 1
            for part in range(parts):
                px, py, qx, qy = ax, ay, bx, by
                if parts == 2:
                    # the middle of the arc stands over that of the chord by half bulge times chord
                    mx = 0.5 * (ax + bx) + 0.5 * bulges[i] * (by - ay)
                    my = 0.5 * (ay + by) - 0.5 * bulges[i] * (bx - ax)
                    px, py = (ax, ay) if part == 0 else (mx, my)
                    qx, qy = (mx, my) if part == 0 else (bx, by)
                _set(Q, n, (px, py, qx, qy), turn / parts)
                n += 1
    return Q[:n]


@fast_kernel
def _set(Q: FloatArray, n: int, ends: tuple[float, float, float, float], turn: float) -> None:
    """Write a segment."""
    ax, ay, bx, by = ends
    Q[n, 0], Q[n, 1], Q[n, 2], Q[n, 3], Q[n, 4] = ax, ay, bx, by, turn
    Q[n, 5], Q[n, 6], Q[n, 7] = 0.0, 0.0, math.inf
    if turn != 0.0:
        h = 0.5 / math.tan(0.5 * turn)
        Q[n, 5], Q[n, 6] = 0.5 * (ax + bx) - h * (by - ay), 0.5 * (ay + by) + h * (bx - ax)
        Q[n, 7] = 0.5 * math.hypot(bx - ax, by - ay) / abs(math.sin(0.5 * turn))


@fast_kernel
def _foot(Q: FloatArray, i: int, x: float, y: float) -> tuple[float, float]:
    """Give the point of a segment that is nearest to a point."""
    ax, ay, bx, by, turn = Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3], Q[i, 4]
    ex, ey = bx - ax, by - ay
    c2 = ex * ex + ey * ey
    if Q[i, 7] == math.inf:
        t = max(0.0, min(1.0, ((x - ax) * ex + (y - ay) * ey) / c2))
        return ax + t * ex, ay + t * ey
    if Q[i, 7] > _FLAT:
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
def _gap(Q: FloatArray, i: int, x: float, y: float) -> float:
    """Give how far a point is from a segment."""
    fx, fy = _foot(Q, i, x, y)
    far: float = math.sqrt((x - fx) ** 2 + (y - fy) ** 2)
    return far


@fast_kernel
def _least(R: FloatArray, r: int, Q: FloatArray, i: int, best: float) -> tuple[float, float, float]:
    """Give the least distance of two segments if below a bound, and where on the first it is."""
    bx, by = 0.5 * (R[r, 0] + R[r, 2]), 0.5 * (R[r, 1] + R[r, 3])
    # the least is at an end of either, or where they have one normal: on a line through a centre
    for k in range(6):
        if k == 0:
            x, y = R[r, 0], R[r, 1]
        elif k == 1:
            x, y = R[r, 2], R[r, 3]
        elif k == 2:
            x, y = _foot(R, r, Q[i, 0], Q[i, 1])
        elif k == 3:
            x, y = _foot(R, r, Q[i, 2], Q[i, 3])
        elif k == 4:
            if Q[i, 7] == math.inf:
                if R[r, 7] == math.inf:
                    continue
                # the point of the arc farthest along the line's normal, to the side of the line
                ex, ey = Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1]
                c = math.hypot(ex, ey)
                side = (R[r, 5] - Q[i, 0]) * ey - (R[r, 6] - Q[i, 1]) * ex
                step = -R[r, 7] if side > 0.0 else R[r, 7]
                x, y = _foot(R, r, R[r, 5] + step * ey / c, R[r, 6] - step * ex / c)
            else:
                x, y = _foot(R, r, Q[i, 5], Q[i, 6])
        else:
            if R[r, 7] == math.inf or Q[i, 7] == math.inf:
                continue
            # the other of the two points on the line through both centres
            x, y = _foot(R, r, 2.0 * R[r, 5] - Q[i, 5], 2.0 * R[r, 6] - Q[i, 6])
        far = _gap(Q, i, x, y)
        if far < best:
            best, bx, by = far, x, y
    return best, bx, by


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
def _meet(R: FloatArray, r: int, Q: FloatArray, i: int, same: float) -> bool:
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
        if _gap(R, r, x, y) <= same and _gap(Q, i, x, y) <= same:
            return True
    return False


@fast_kernel
def _box(Q: FloatArray, i: int) -> tuple[float, float, float, float]:
    """Give a box about a segment."""
    ax, ay, bx, by = Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3]
    # the arc is no farther from its chord than its height, which is the chord times the bulge / 2
    h = 0.5 * math.hypot(bx - ax, by - ay) * abs(math.tan(0.25 * Q[i, 4]))
    x0, x1, y0, y1 = min(ax, bx), max(ax, bx), min(ay, by), max(ay, by)
    if h == 0.0:
        return x0, y0, x1, y1
    # of a half turn at most, each end leaves at most at a right angle: it stays in this box
    return x0 - h, y0 - h, x1 + h, y1 + h


@fast_kernel
def _boxes(Q: FloatArray, size: int) -> FloatArray:
    """Give the boxes about runs of so many segments."""
    count = (Q.shape[0] + size - 1) // size
    B = np.empty((count, 4))
    for b in range(count):
        x0, y0, x1, y1 = math.inf, math.inf, -math.inf, -math.inf
        for i in range(b * size, min(Q.shape[0], b * size + size)):
            u0, v0, u1, v1 = _box(Q, i)
            x0, y0, x1, y1 = min(x0, u0), min(y0, v0), max(x1, u1), max(y1, v1)
        B[b, 0], B[b, 1], B[b, 2], B[b, 3] = x0, y0, x1, y1
    return B


@fast_kernel
def _apart(B: FloatArray, b: int, box: tuple[float, float, float, float], reach: float) -> bool:
    """Say whether two boxes are farther from each other than a reach."""
    dx = max(B[b, 0] - box[2], 0.0, box[0] - B[b, 2])
    dy = max(B[b, 1] - box[3], 0.0, box[1] - B[b, 3])
    farther: bool = dx * dx + dy * dy > reach * reach
    return farther


@fast_kernel
def _inside(Q: FloatArray, x: float, y: float) -> bool:
    """Say whether closed segments go around a point."""
    # by crossings of the ray to larger x: with the chord, and with the arc where the point lies
    # between both, which is where it is in the disc and on the arc's side of the chord
    odd = False
    for i in range(Q.shape[0]):
        ax, ay, bx, by = Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3]
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            odd = not odd
        if Q[i, 7] < math.inf:
            side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
            if side * Q[i, 4] < 0.0:
                px, py = x - Q[i, 5], y - Q[i, 6]
                within = px * px + py * py < Q[i, 7] * Q[i, 7]
                if Q[i, 7] > _FLAT:
                    fx, fy = _foot(Q, i, x, y)
                    within = abs(side) < abs((bx - ax) * (fy - ay) - (by - ay) * (fx - ax))
                if within:
                    odd = not odd
    return odd


@fast_kernel
def lost(
    R: FloatArray, Q: FloatArray, reaches: tuple[float, float], probes: int, outward: bool
) -> tuple[bool, float, float]:
    """Look whether a result is all there is: give False, or True and a place that it misses.

    Points just farther from the part than its corners reach, beside its segments and to their left,
    must lie inside of the result (outward: outside of what its loops enclose), and points just
    nearer than the distance must not.
    """
    coarse, fine = _boxes(Q, _RUN * _RUNS), _boxes(Q, _RUN)
    n = Q.shape[0]
    step = max(1, n // probes)
    for i in range(0, n, step):
        ex, ey = Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1]
        c = math.hypot(ex, ey)
        h = 0.5 * math.tan(0.25 * Q[i, 4])
        mx = 0.5 * (Q[i, 0] + Q[i, 2]) + h * ey
        my = 0.5 * (Q[i, 1] + Q[i, 3]) - h * ex
        for wanted in (True, False):
            d = reaches[1] if wanted else reaches[0]
            beyond = (1.0 + 1e-6) * d if wanted else (1.0 - 1e-6) * d
            x, y = mx - beyond * ey / c, my + beyond * ex / c
            far = math.inf
            for b in range(coarse.shape[0]):
                if _apart(coarse, b, (x, y, x, y), d):
                    continue
                for f in range(b * _RUNS, min(fine.shape[0], b * _RUNS + _RUNS)):
                    if not _apart(fine, f, (x, y, x, y), d):
                        for k in range(f * _RUN, min(n, f * _RUN + _RUN)):
                            far = min(far, _gap(Q, k, x, y))
            clear = far > d * (1.0 + 1e-7) if wanted else far < d * (1.0 - 1e-7)
            if clear and (_inside(R, x, y) != outward) != wanted:
                return True, x, y
    return False, 0.0, 0.0


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
    coarse, fine, single = _boxes(Q, _RUN * _RUNS), _boxes(Q, _RUN), _boxes(Q, 1)
    n = Q.shape[0]
    least, most = math.inf, 0.0
    reach = d + slack
    ends = np.empty(2)
    for r in range(R.shape[0]):
        box = _box(R, r)
        chord = math.sqrt((R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2)
        # the middle of the arc stands over that of the chord
        h = 0.5 * math.tan(0.25 * R[r, 4])
        mx = 0.5 * (R[r, 0] + R[r, 2]) + h * (R[r, 3] - R[r, 1])
        my = 0.5 * (R[r, 1] + R[r, 3]) - h * (R[r, 2] - R[r, 0])
        ends[0], ends[1] = math.inf, math.inf
        for b in range(coarse.shape[0]):
            if _apart(coarse, b, box, reach):
                continue
            for f in range(b * _RUNS, min(fine.shape[0], b * _RUNS + _RUNS)):
                if _apart(fine, f, box, reach):
                    continue
                for i in range(f * _RUN, min(n, f * _RUN + _RUN)):
                    if _apart(single, i, box, reach):
                        continue
                    if ends[0] > d:  # else it is near enough
                        ends[0] = min(ends[0], _gap(Q, i, R[r, 0], R[r, 1]))
                    far = _gap(Q, i, mx, my)
                    ends[1] = min(ends[1], far)
                    if far - 0.7072 * chord >= least:
                        continue  # nowhere on it nearer than elsewhere
                    near, x, y = _least(R, r, Q, i, least)
                    if near < least:
                        least, found[1], found[2] = near, x, y
                    if far < 0.7072 * chord and _meet(R, r, Q, i, min(_SAME, 1e-3 * d)):
                        least, found[1], found[2] = 0.0, mx, my
        for k in range(2):
            if ends[k] > most:
                most = ends[k]
                found[4], found[5] = (R[r, 0], R[r, 1]) if k == 0 else (mx, my)
    found[0], found[3] = least, most
