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
from splinearm.compiled import fast_kernel

from .offset_check_kernel import FLAT, gap
from .offset_within_kernel import encloses, nearest

DEEPER = 1e-8
_STEP = 1e-6
_SURE = 1e-12
_ALONG = 1e-9
"""What lies along the result is no farther from it."""
SPANS = 64

SIDE, CORNER = 0.0, 1.0

Way = tuple[float, float, float, float, float, float]
"""A segment (0, ax, ay, ex, ey, turn: where it begins, its chord) or corner (1, x, y, nx, ny, turn:
its place, the normal before it)."""
Shape = tuple[float, float, float, float, float]
"""The length and the curvature of what runs beside a way, the first step over what is left and
enclosed, and the segments before the way and behind it."""
Scene = tuple[FloatArray, FloatArray, FloatArray, FloatArray, float, float, FloatArray, FloatArray]


@fast_kernel
def _at(way: Way, f: float, e: float) -> tuple[float, float]:
    """Give the point beside a way to its left at a share of it."""
    kind, ax, ay, ex, ey, turn = way
    if kind == CORNER:
        co, si = math.cos(f * turn), math.sin(f * turn)
        return ax + e * (co * ex - si * ey), ay + e * (si * ex + co * ey)
    c = math.sqrt(ex * ex + ey * ey)
    if turn == 0.0:
        return ax + f * ex - e * ey / c, ay + f * ey + e * ex / c
    # the chord up to there, and the normal
    grown = math.sin(0.5 * f * turn) / math.sin(0.5 * turn)
    co, si = math.cos(0.5 * (f - 1.0) * turn), math.sin(0.5 * (f - 1.0) * turn)
    px, py = ax + grown * (co * ex - si * ey), ay + grown * (si * ex + co * ey)
    co, si = math.cos((f - 0.5) * turn) / c, math.sin((f - 0.5) * turn) / c
    return px - e * (si * ex + co * ey), py + e * (co * ex - si * ey)


@fast_kernel
def _shares(
    way: Way, Q: FloatArray, i: int, R: FloatArray, r: int, d: float
) -> tuple[bool, float, float]:
    """Say whether a segment of the result lies along the way, and between which shares of it."""
    kind, ax, ay, ex, ey, turn = way
    ux, uy, vx, vy = R[r, 0] - ax, R[r, 1] - ay, R[r, 2] - ax, R[r, 3] - ay
    if kind == SIDE and turn == 0.0:
        c2 = ex * ex + ey * ey
        c = math.sqrt(c2)
        off = abs(ex * uy - ey * ux - d * c) + abs(ex * vy - ey * vx - d * c)
        low, high = (ux * ex + uy * ey) / c2, (vx * ex + vy * ey) / c2
        low, high = min(1.0, max(0.0, low)), min(1.0, max(0.0, high))
        return off <= _ALONG * c and R[r, 7] > FLAT and high > low, low, high
    if kind == SIDE and Q[i, 7] > FLAT:
        # nearly straight: by the places of three points beside it
        c2 = ex * ex + ey * ey
        low = min(1.0, max(0.0, (ux * ex + uy * ey) / c2))
        high = min(1.0, max(0.0, (vx * ex + vy * ey) / c2))
        along = high > low
        for k in range(3):
            x, y = _at(way, low + 0.5 * k * (high - low), d)
            along = along and gap(R, r, x, y) <= _ALONG
        return along, low, high
    # about one centre, in the same direction
    cx, cy, radius = ax, ay, d
    px, py = ex, ey
    if kind == SIDE:
        cx, cy, radius = Q[i, 5], Q[i, 6], Q[i, 7] - math.copysign(d, turn)
        px, py = ax - cx, ay - cy
        ux, uy, vx, vy = R[r, 0] - cx, R[r, 1] - cy, R[r, 2] - cx, R[r, 3] - cy
    if R[r, 4] * turn <= 0.0 or abs(R[r, 7] - radius) > 0.1 * radius:
        return False, 0.0, 0.0
    off = abs(math.sqrt(ux * ux + uy * uy) - radius) + abs(math.sqrt(vx * vx + vy * vy) - radius)
    if off > _ALONG or abs(R[r, 5] - cx) + abs(R[r, 6] - cy) > _ALONG / max(1e-3, abs(R[r, 4])):
        return False, 0.0, 0.0
    low = math.atan2(px * uy - py * ux, px * ux + py * uy) / turn
    high = low + math.atan2(ux * vy - uy * vx, ux * vx + uy * vy) / turn
    if low > 1.5:
        low, high = low - 2.0 * math.pi / abs(turn), high - 2.0 * math.pi / abs(turn)
    return high > max(0.0, low) and low < 1.0, max(0.0, low), min(1.0, high)


@fast_kernel
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


@fast_kernel
def _beneath(
    way: Way,
    ends: tuple[float, float],
    shape: Shape,
    part: tuple[FloatArray, float],
    i: int,
) -> bool:
    """Say whether both ends of a stretch show that all of it is nearer to a segment than e."""
    Q, e = part
    length, droop, _, _, _ = shape
    x, y = _at(way, ends[0], e)
    u, v = _at(way, ends[1], e)
    far = max(gap(Q, i, x, y), gap(Q, i, u, v))
    if Q[i, 7] < math.inf:
        # on the inner side of an arc the distance bends down by no more than this
        inner = Q[i, 7] - e
        droop += 1.0 / inner if inner > 0.5 * e else math.inf
    # the distance from a line is convex along a line
    sag = 0.125 * droop * ((ends[1] - ends[0]) * length) ** 2 if droop > 0.0 else 0.0
    return far + sag < e - _SURE


@fast_kernel
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
    x, y = _at(way, 0.5 * (f + last), e)
    half = 0.5 * (last - f) * length
    if hint >= 0 and gap(Q, hint, x, y) + half < reach:
        return False, x, y, hint
    # where the result ends it is the neighbour that is nearer, mostly
    beside = int(behind if last == 1.0 else before)
    if _beneath(way, ends, shape, (Q, e), beside):
        return False, x, y, beside
    near, hint = nearest(Q, T, (x, y), (reach, 0.02 * e), room)
    if hint >= 0 and near + half < reach:
        return False, x, y, hint
    while f < last:
        x, y = _at(way, f, e)
        near = gap(Q, hint, x, y) if hint >= 0 else math.inf
        if not near < reach:
            near, hint = nearest(Q, T, (x, y), (reach, 0.02 * e), room)
        if hint < 0:
            # surely left
            if encloses(R, TR, x, y) == (outward > 0.0) and encloses(Q, T, x, y) != (outward > 0.0):
                return True, x, y, hint
            f += leap / length
            leap *= 2.0
            continue
        leap = shape[2]
        if way[0] == CORNER:
            ahead = _out_of_discs(way, f, Q, hint, e)
            if ahead >= last:
                return False, x, y, hint
            if ahead > f + 1e-3 * (last - f):
                f = ahead
                continue
        step, h = (reach - near) / length, last - f
        while h > step and not _beneath(way, (f, f + h), shape, (Q, e), hint):
            h *= 0.5
        h = max(h, step, _STEP / length)
        if h < 0.25 * (last - f):
            hint = -1
        f += h
    return False, x, y, hint


@fast_kernel
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
    Q, e = scene[0], scene[4]
    d, reach = reaches
    n = Q.shape[0]
    head, after = np.full(n, -1.0), np.empty(count)
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
            if k * e < 1.0:
                length = (abs(Q[i, 4]) * Q[i, 7] if k != 0.0 else c) * (1.0 - k * e)
                leap = _STEP if reach == 1.0 else max(_STEP, 0.125 * length)
                shape = (length, abs(k) / (1.0 - k * e), leap, before, j)
                lost, x, y, hint = _walked(
                    (SIDE, Q[i, 0], Q[i, 1], ex, ey, Q[i, 4]), shape, near, scene, hint
                )
                if lost:
                    return True, x, y
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
            if turn * e < -_STEP:
                leap = _STEP if reach == 1.0 else max(_STEP, -0.125 * turn * e)
                shape = (-turn * e, 1.0 / e, leap, i, j)
                lost, x, y, hint = _walked(
                    (CORNER, Q[i, 2], Q[i, 3], -uy, ux, turn), shape, near, scene, hint
                )
                if lost:
                    return True, x, y
    return False, 0.0, 0.0
