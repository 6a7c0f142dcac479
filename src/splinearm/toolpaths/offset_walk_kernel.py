"""Whether an offset is all there is, proven along every segment of the part, compiled.

Every region that is left has a boundary, and every point of that lies straight beside a point of a
segment or around a corner, at the distance d, with nothing of the part nearer. So each segment and
each corner is walked through at a distance that is larger by `DEEPER`, where what is left is
surely left: all of the way must lie along the result, or be nearer than that to another segment,
which is shown by bounds of the distance between the places that are looked at. A region is missed
only if none of its sides is longer than `_STEP`.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel, inner_kernel

from .offset_check_kernel import FLAT, gap, spread
from .offset_within_kernel import encloses, nearest

DEEPER = 1e-8
_STEP = 1e-6
_OPEN = 2.5
"""Parts of arcs that turn farther, rad, have no triangle about them that is of use."""
_SURE = 1e-12
_ALONG = 1e-9
"""What lies along the result is no farther from it."""
SPANS = 64

SIDE, ARC, FLAT_ARC, CORNER = 0.0, 1.0, 2.0, 3.0

Way = tuple[float, float, float, float, float, float]
"""What runs beside a segment or about a corner: a line (0, x, y, ex, ey, 0: where it begins, its
chord), an arc (1 or 3, cx, cy, px, py, turn: its centre, from there to where it begins), or beside
one that is nearly straight (2, ax, ay, ex, ey, turn: where the segment begins, its chord)."""
Shape = tuple[float, float, float, float, float]
"""The length and the curvature of what runs beside a way, the first step over what is left and
enclosed, and the segments before the way and behind it."""
Stretch = tuple[float, float, float, float, float, float]
"""A part of a way: the shares it covers, where it begins and where it ends."""
Scene = tuple[FloatArray, FloatArray, FloatArray, FloatArray, float, float, FloatArray, FloatArray]


@bare_kernel
def _at(way: Way, f: float, e: float) -> tuple[float, float]:
    """Give the point of a way at a share of it; ``e`` is how far it is beside the part."""
    kind, ax, ay, ex, ey, turn = way
    if kind == SIDE:
        return ax + f * ex, ay + f * ey
    if kind != FLAT_ARC:
        co, si = math.cos(f * turn), math.sin(f * turn)
        return ax + co * ex - si * ey, ay + si * ex + co * ey
    c = math.sqrt(ex * ex + ey * ey)
    # the chord up to there, and the normal
    grown = math.sin(0.5 * f * turn) / math.sin(0.5 * turn)
    co, si = math.cos(0.5 * (f - 1.0) * turn), math.sin(0.5 * (f - 1.0) * turn)
    px, py = ax + grown * (co * ex - si * ey), ay + grown * (si * ex + co * ey)
    co, si = math.cos((f - 0.5) * turn) / c, math.sin((f - 0.5) * turn) / c
    return px - e * (si * ex + co * ey), py + e * (co * ex - si * ey)


@bare_kernel
def _beside(Q: FloatArray, i: int, e: float) -> Way:
    """Give the way beside a segment to its left."""
    ax, ay, turn = Q[i, 0], Q[i, 1], Q[i, 4]
    ex, ey = Q[i, 2] - ax, Q[i, 3] - ay
    if turn == 0.0:
        c = math.sqrt(ex * ex + ey * ey)
        return SIDE, ax - e * ey / c, ay + e * ex / c, ex, ey, 0.0
    if Q[i, 7] > FLAT:
        return FLAT_ARC, ax, ay, ex, ey, turn
    grown = 1.0 - math.copysign(e, turn) / Q[i, 7]
    return ARC, Q[i, 5], Q[i, 6], grown * (ax - Q[i, 5]), grown * (ay - Q[i, 6]), turn


@bare_kernel
def _shares(
    way: Way, Q: FloatArray, i: int, R: FloatArray, r: int, d: float
) -> tuple[bool, float, float]:
    """Say whether a segment of the result lies along the way, and between which shares of it."""
    kind, cx, cy, px, py, turn = way
    if kind in (SIDE, FLAT_ARC):
        ax, ay = Q[i, 0], Q[i, 1]
        ex, ey = Q[i, 2] - ax, Q[i, 3] - ay
        ux, uy, vx, vy = R[r, 0] - ax, R[r, 1] - ay, R[r, 2] - ax, R[r, 3] - ay
        c2 = ex * ex + ey * ey
        low = min(1.0, max(0.0, (ux * ex + uy * ey) / c2))
        high = min(1.0, max(0.0, (vx * ex + vy * ey) / c2))
        if kind == SIDE:
            c = math.sqrt(c2)
            off = abs(ex * uy - ey * ux - d * c) + abs(ex * vy - ey * vx - d * c)
            return off <= _ALONG * c and R[r, 7] > FLAT and high > low, low, high
        # nearly straight: by the places of three points beside it
        along = high > low
        for k in range(3):
            x, y = _at(way, low + 0.5 * k * (high - low), d)
            along = along and gap(R, r, x, y) <= _ALONG
        return along, low, high
    # about one centre, in the same direction
    radius = d if kind == CORNER else Q[i, 7] - math.copysign(d, turn)
    if R[r, 4] * turn <= 0.0 or abs(R[r, 7] - radius) > 0.1 * radius:
        return False, 0.0, 0.0
    ux, uy, vx, vy = R[r, 0] - cx, R[r, 1] - cy, R[r, 2] - cx, R[r, 3] - cy
    off = abs(math.sqrt(ux * ux + uy * uy) - radius) + abs(math.sqrt(vx * vx + vy * vy) - radius)
    if off > _ALONG or abs(R[r, 5] - cx) + abs(R[r, 6] - cy) > _ALONG / max(1e-3, abs(R[r, 4])):
        return False, 0.0, 0.0
    low = math.atan2(px * uy - py * ux, px * ux + py * uy) / turn
    high = low + math.atan2(ux * vy - uy * vx, ux * vx + uy * vy) / turn
    if low > 1.5:
        low, high = low - 2.0 * math.pi / abs(turn), high - 2.0 * math.pi / abs(turn)
    return high > max(0.0, low) and low < 1.0, max(0.0, low), min(1.0, high)


@bare_kernel
def _out_of_discs(way: Way, f: float, Q: FloatArray, i: int, e: float) -> float:
    """Give the share up to which the way about a corner lies nearer to one end of a segment."""
    _, vx, vy, nx, ny, turn = way
    x, y = _at(way, f, e)
    reach, ahead = e - _SURE, 0.0
    for c in (0, 2):
        wx, wy = Q[i, c] - vx, Q[i, c + 1] - vy
        away2 = wx * wx + wy * wy
        if (x - Q[i, c]) ** 2 + (y - Q[i, c + 1]) ** 2 < reach * reach and away2 > 0.0:
            # two circles of nearly one radius: up to so far about the direction to the other
            away = math.sqrt(away2)
            wide = math.acos(min(1.0, 0.5 * away / e + _SURE / away))
            to = math.atan2(nx * wy - ny * wx, nx * wx + ny * wy)
            if f * turn < to - wide:
                to -= 2.0 * math.pi
            ahead = max(ahead, (to - wide) / turn)
    return ahead


@bare_kernel
def _bent(way: Way, part: Stretch) -> tuple[float, float]:
    """Give where the tangents at both ends of a part of an arc meet: with them a triangle about it.

    Of a line that is its end.
    """
    kind, cx, cy, _, _, turn = way
    f, g, x, y, u, v = part[0], part[1], part[2], part[3], part[4], part[5]
    if kind == SIDE:
        return u, v
    # the sum of both arms, as long as the arm over the cosine of half the turn
    mx, my = 0.5 * (x + u) - cx, 0.5 * (y + v) - cy
    co = math.cos(0.5 * (g - f) * turn)
    return cx + mx / (co * co), cy + my / (co * co)


@bare_kernel
def _within(Q: FloatArray, i: int, x: float, y: float) -> bool:
    """Say whether a point lies between the radii to both ends of an arc, but for rounding."""
    qx, qy = x - Q[i, 5], y - Q[i, 6]
    ux, uy, vx, vy = Q[i, 0] - Q[i, 5], Q[i, 1] - Q[i, 6], Q[i, 2] - Q[i, 5], Q[i, 3] - Q[i, 6]
    a, b = (ux * qy - uy * qx), (qx * vy - qy * vx)
    if Q[i, 4] < 0.0:
        a, b = -a, -b
    off = -0.1 * _SURE * Q[i, 7]
    between: bool = a >= off and b >= off
    return between


@bare_kernel
def _beneath(way: Way, part: Stretch, shape: Shape, Q: FloatArray, i: int, e: float) -> bool:
    """Say whether all of a part of a way is shown to be nearer to a segment than e."""
    reach = e - 2.0 * _SURE
    far = max(gap(Q, i, part[2], part[3]), gap(Q, i, part[4], part[5]))
    if far >= reach:
        return False
    if way[0] == FLAT_ARC or FLAT < Q[i, 7] < math.inf:
        # on the inner side of an arc the distance bends down by no more than this
        droop, inner = shape[1], Q[i, 7] - e
        if Q[i, 7] < math.inf:
            droop += 1.0 / inner if inner > 0.5 * e else math.inf
        sag = 0.125 * droop * ((part[1] - part[0]) * shape[0]) ** 2 if droop > 0.0 else 0.0
        return far + sag < reach
    if way[0] == SIDE and Q[i, 7] == math.inf:
        return True  # what is nearer to a line than e is convex
    if way[0] != SIDE and (part[1] - part[0]) * abs(way[5]) > _OPEN:
        return False
    tx, ty = _bent(way, part)
    if Q[i, 7] == math.inf:
        return gap(Q, i, tx, ty) < reach
    return _beneath_arc(way, part, (tx, ty), Q, i, reach)


@bare_kernel
def _beneath_arc(
    way: Way, part: Stretch, top: tuple[float, float], Q: FloatArray, i: int, reach: float
) -> bool:
    """Say the same of an arc, with the third corner of a triangle about the part."""
    x, y, u, v = part[2], part[3], part[4], part[5]
    ends, arc = (x, y, u, v), (way[1], way[2], way[5])
    for c in (0, 2):
        if spread(ends, arc, Q[i, c], Q[i, c + 1])[1] < reach:
            return True
    # what lies between two radii is convex; there it is the distance from the centre that counts
    if not (_within(Q, i, x, y) and _within(Q, i, u, v) and _within(Q, i, top[0], top[1])):
        return False
    least, most = spread(ends, arc, Q[i, 5], Q[i, 6])
    beneath: bool = Q[i, 7] - reach < least and most < Q[i, 7] + reach
    return beneath


@inner_kernel
def _left_over(
    way: Way,
    ends: tuple[float, float],
    shape: Shape,
    scene: Scene,
    hint: int,
) -> tuple[bool, float, float, int]:
    """Say whether a stretch of a way holds something that is left but not enclosed, and where.

    Args:
        way: The way.
        ends: The shares between which the stretch lies.
        shape: See `Shape`.
        scene: Segments of the part and their tree, those of the result and theirs, how far beside
            the way, 1 if what the loops do not enclose is left, and room to work in.
        hint: A segment that may be nearer.

    Returns:
        Whether, and where; and the segment that was nearer last.
    """
    Q, T, R, TR, e, outward, room, _ = scene
    f, last = ends
    length, _, leap, before, behind = shape
    reach = e - _SURE
    px, py = _at(way, f, e)
    qx, qy = _at(way, last, e)
    whole = (f, last, px, py, qx, qy)
    # where the result ends it is the neighbour that is nearer, mostly
    beside = int(behind if last == 1.0 else before)
    if _beneath(way, whole, shape, Q, beside, e):
        return False, px, py, beside
    if hint >= 0 and _beneath(way, whole, shape, Q, hint, e):
        return False, px, py, hint
    x, y = _at(way, 0.5 * (f + last), e)
    near, hint = nearest(Q, T, (x, y), (reach, 0.02 * e), room)
    if hint >= 0 and (
        near + 0.5 * (last - f) * length < reach or _beneath(way, whole, shape, Q, hint, e)
    ):
        return False, x, y, hint
    while f < last:
        near = gap(Q, hint, px, py) if hint >= 0 else math.inf
        if not near < reach:
            near, hint = nearest(Q, T, (px, py), (reach, 0.02 * e), room)
        if hint < 0:
            # surely left
            if encloses(R, TR, px, py, room) == (outward > 0.0) and (
                encloses(Q, T, px, py, room) != (outward > 0.0)
            ):
                return True, px, py, hint
            f += leap / length
            px, py = _at(way, f, e)
            leap *= 2.0
            continue
        leap = shape[2]
        if way[0] == CORNER:
            ahead = _out_of_discs(way, f, Q, hint, e)
            if ahead >= last:
                return False, px, py, hint
            if ahead > f + 1e-3 * (last - f):
                f = ahead
                px, py = _at(way, f, e)
                continue
        step, h = (reach - near) / length, last - f
        x, y = qx, qy
        while h > step and not _beneath(way, (f, f + h, px, py, x, y), shape, Q, hint, e):
            h *= 0.5
            x, y = _at(way, f + h, e)
        if h < max(step, _STEP / length):
            h = max(step, _STEP / length)
            x, y = _at(way, f + h, e)
        if h < 0.25 * (last - f):
            hint = -1
        f += h
        px, py = x, y
    return False, px, py, hint


@inner_kernel
def _walked(
    way: Way,
    shape: Shape,
    near: tuple[FloatArray, FloatArray, FloatArray, int, float],
    scene: Scene,
    hint: int,
) -> tuple[bool, float, float, int]:
    """Say whether a way has something beside it that is left but does not lie along the result.

    Args:
        way: The way.
        shape: As `_left_over` takes it.
        near: Pairs of segments that come near each other as lists by those of the part: the pairs,
            the first of each segment, the next of each, the segment, and the distance.
        scene: As `_left_over` takes it.
        hint: A segment that may be nearer.
    """
    pairs, head, after, i, d = near
    Q, R = scene[0], scene[2]
    spans, count = scene[7], 0
    p = int(head[i])
    while p >= 0 and count < SPANS:
        r = int(pairs[p, 1])
        p = int(after[p])
        along, low, high = _shares(way, Q, i, R, r, d)
        if along:
            k = count
            while k > 0 and spans[k - 1, 0] > low:
                spans[k, 0], spans[k, 1] = spans[k - 1, 0], spans[k - 1, 1]
                k -= 1
            spans[k, 0], spans[k, 1] = low, high
            count += 1
    slack = _STEP / shape[0]
    f = 0.0
    for k in range(count + 1):
        end = spans[k, 0] - slack if k < count else 1.0
        if f < end:
            lost, x, y, hint = _left_over(way, (f, end), shape, scene, hint)
            if lost:
                return True, x, y, hint
        if k < count:
            f = max(f, spans[k, 1] + slack)
    return False, 0.0, 0.0, hint


@fast_kernel
def missing(
    pairs: FloatArray, count: int, firsts: FloatArray, scene: Scene, reaches: tuple[float, float]
) -> tuple[bool, float, float]:
    """Say whether a region is missing, and where."""
    head, after = np.empty(scene[0].shape[0]), np.empty(count)
    return _missing((pairs, count, head, after), firsts, scene, reaches)


@bare_kernel
def _missing(
    lists: tuple[FloatArray, int, FloatArray, FloatArray],
    firsts: FloatArray,
    scene: Scene,
    reaches: tuple[float, float],
) -> tuple[bool, float, float]:
    pairs, count, head, after = lists
    Q, e = scene[0], scene[4]
    d, reach = reaches
    for i in range(Q.shape[0]):
        head[i] = -1.0
    for p in range(count if reach == 1.0 else 0):
        i = int(pairs[p, 0])
        after[p], head[i] = head[i], p
    hint = -1
    for loop in range(firsts.shape[0] - 1):
        first, end = int(firsts[loop]), int(firsts[loop + 1])
        for i in range(first, end):
            j = i + 1 if i + 1 < end else first
            before = i - 1 if i > first else end - 1
            ex, ey = Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1]
            gx, gy = Q[j, 2] - Q[j, 0], Q[j, 3] - Q[j, 1]
            c, g = math.sqrt(ex * ex + ey * ey), math.sqrt(gx * gx + gy * gy)
            k = math.copysign(1.0 / Q[i, 7], Q[i, 4])
            near = (pairs, head, after, i, d)
            # from the direction at the end of one to that at the start of the next
            s, t = (
                math.copysign(0.5 * c / Q[i, 7], Q[i, 4]),
                math.copysign(0.5 * g / Q[j, 7], Q[j, 4]),
            )
            co, si = math.sqrt(max(0.0, 1.0 - s * s)) / c, s / c
            ux, uy = co * ex - si * ey, si * ex + co * ey
            co, si = math.sqrt(max(0.0, 1.0 - t * t)) / g, t / g
            vx, vy = co * gx + si * gy, co * gy - si * gx
            turn = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)
            if turn > math.pi * (1.0 - 1e-9):
                turn -= 2.0 * math.pi
            for around in range(2):
                # beside the segment, and around the corner behind it
                if around == 0:
                    if k * e >= 1.0:
                        continue
                    way = _beside(Q, i, e)
                    length = (abs(Q[i, 4]) * Q[i, 7] if k != 0.0 else c) * (1.0 - k * e)
                    leap = _STEP if reach == 1.0 else max(_STEP, 0.125 * length)
                    shape = (length, abs(k) / (1.0 - k * e), leap, before, j)
                else:
                    length = -turn * e
                    if length <= _STEP:
                        continue
                    way = (CORNER, Q[i, 2], Q[i, 3], -e * uy, e * ux, turn)
                    leap = _STEP if reach == 1.0 else max(_STEP, 0.125 * length)
                    shape = (length, 1.0 / e, leap, i, j)
                lost, x, y, hint = _walked(way, shape, near, scene, hint)
                if lost:
                    return True, x, y
    return False, 0.0, 0.0
