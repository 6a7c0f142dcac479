"""What of raw pieces is not certainly nearer to the part than d, compiled.

What goes here certainly goes; where what is left crosses is found elsewhere.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel, inner_kernel

from .arc_kernel import COLUMNS, at_share, box_of, disc_cuts, distance, set_piece
from .tree_kernel import Disc, is_clear, nearest

_LOOSE = 2e-11
"""What is nearer to the part by more than this certainly goes."""
_SPANS = 8
"""What is left of one piece may be in so many parts."""
_LOOKS = 12
_LEVEL = 1e-15
_FEW = 160
_SPECK = 1.5e-8
"""Where many pieces survive in a place of this size alone, all of them meet all others."""
_SIDE = 2.5e-12
"""And where that place is no wider than this for each of them, all their ends are snapped to one:
they are nearer to each other on its edge than 1e-11."""


@bare_kernel
def _without(spans: FloatArray, count: int, low: float, high: float) -> int:
    """Take the shares from low to high out of spans, and give how many there are then."""
    for k in range(count - 1, -1, -1):
        a, b = spans[k, 0], spans[k, 1]
        if low >= b or high <= a:
            continue
        if low <= a and high >= b:
            count -= 1
            spans[k, 0], spans[k, 1] = spans[count, 0], spans[count, 1]
        elif low <= a:
            spans[k, 0] = high
        elif high >= b:
            spans[k, 1] = low
        elif count < _SPANS:
            spans[k, 1] = low
            spans[count, 0], spans[count, 1] = high, b
            count += 1
    return count


@bare_kernel
def _hull(R: FloatArray, r: int, spans: FloatArray, count: int) -> tuple[float, float, float]:
    """Give a disc that all spans lie in."""
    low, high = 1.0, 0.0
    for k in range(count):
        low, high = min(low, spans[k, 0]), max(high, spans[k, 1])
    x, y = at_share(R, r, 0.5 * (low + high))
    c = math.sqrt((R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2)
    # half the way on the chord, by at most 1 / cos 45 deg longer on the arc
    return x, y, 0.7072 * (high - low) * c


@bare_kernel
def _without_disc(
    R: FloatArray, r: int, disc: tuple[float, float, float], spans: FloatArray, count: int
) -> int:
    """Take out of spans what lies in a disc, and give how many there are then."""
    x, y, radius = disc
    cuts, u, v = disc_cuts(R, r, x, y, radius)
    start = 0.0
    for k in range(cuts + 1):
        end = 1.0 if k == cuts else (u if k == 0 else v)
        # asked of each part's middle: where circles nearly touch, cuts are known badly
        px, py = at_share(R, r, 0.5 * (start + end))
        if (px - x) ** 2 + (py - y) ** 2 < radius * radius:
            count = _without(spans, count, start, end)
        start = end
    return count


@bare_kernel
def _without_side(
    R: FloatArray, r: int, side: tuple[FloatArray, int, float], spans: FloatArray, count: int
) -> int:
    """Take out of spans of a line what lies straight beside another line, nearer than so much."""
    P, i, reach = side
    ex, ey = P[i, 2] - P[i, 0], P[i, 3] - P[i, 1]
    c = math.sqrt(ex * ex + ey * ey)
    low, high = 0.0, 1.0
    for k in range(2):
        # how far beside it and along it; both change evenly
        nx, ny = (P[i, 5], P[i, 6]) if k == 0 else (ex / c, ey / c)
        least, most = (-reach, reach) if k == 0 else (0.0, c)
        a = nx * (R[r, 0] - P[i, 0]) + ny * (R[r, 1] - P[i, 1])
        b = nx * (R[r, 2] - P[i, 0]) + ny * (R[r, 3] - P[i, 1]) - a
        if b < 0.0:
            a, b, least, most = -a, -b, -most, -least
        if b < _LEVEL:
            if a < least or a + b > most:
                return count
            continue
        low, high = max(low, (least - a) / b), min(high, (most - a) / b)
    # each goes on beyond where it meets the other by more than what is snapped together
    beyond = _LOOSE / math.sqrt((R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2)
    low, high = low + beyond if low > 0.0 else low, high - beyond if high < 1.0 else high
    # along a side at just that distance it is not nearer
    a = P[i, 5] * (R[r, 0] - P[i, 0]) + P[i, 6] * (R[r, 1] - P[i, 1])
    b = P[i, 5] * (R[r, 2] - P[i, 0]) + P[i, 6] * (R[r, 3] - P[i, 1]) - a
    if min(abs(a + low * b), abs(a + high * b)) > reach - min(_LOOSE, 1e-3 * reach):
        return count
    return _without(spans, count, low, high) if low < high else count


@bare_kernel
def _without_near(
    R: FloatArray,
    r: int,
    spot: tuple[float, int, float],
    model: tuple[FloatArray, float],
    work: tuple[FloatArray, int],
) -> int:
    """Take out of spans what a near piece of the part certainly takes about a share."""
    u, near, far = spot
    P, reach = model
    spans, count = work
    x, y = at_share(R, r, u)
    for c in (0, 2):
        vx, vy = P[near, c], P[near, c + 1]
        if (x - vx) ** 2 + (y - vy) ** 2 < reach * reach:
            return _without_disc(R, r, (vx, vy, reach), spans, count)
    chord = math.sqrt((R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2)
    # the distance grows by no more than the way, which is at most 1.4143 times that on the chord
    step = (reach - far) / (1.4143 * chord)
    return _without(spans, count, u - step, u + step)


@fast_kernel
def surviving(
    P: FloatArray,
    T: FloatArray,
    loops: FloatArray,
    raw: tuple[FloatArray, FloatArray, FloatArray],
    d: float,
    heart: Disc,
) -> tuple[FloatArray, FloatArray]:
    """Give the raw pieces without what is certainly nearer to the part than d.

    Args:
        P: Pieces of the part.
        T: Their tree.
        loops: The first piece of each loop and n.
        raw: Raw pieces, the number of the line or arc of each, and the piece each comes from.
        d: How far they were moved.
        heart: A disc that no piece of the part reaches into.

    Returns:
        What survives, shape (m, 9), and the numbers of their lines and arcs.
    """
    R = raw[0]
    room = R.shape[0] + 64
    S, numbers = np.empty((room, COLUMNS)), np.empty(room)
    spans, stack = np.empty((_SPANS, 2)), np.empty((128, 2))
    part = (P, T, loops, heart)
    r, m = 0, 0
    while True:
        r, m = _survive(part, raw, d, r, (S, numbers, m), (spans, stack))
        if r == R.shape[0]:
            break
        wider, longer = np.empty((2 * S.shape[0], COLUMNS)), np.empty(2 * S.shape[0])
        wider[:m], longer[:m] = S[:m], numbers[:m]
        S, numbers = wider, longer
    if m > _FEW and _is_speck(S, m):
        m = 0
    return S[:m], numbers[:m]


@bare_kernel
def _is_speck(S: FloatArray, count: int) -> bool:
    """Say whether all pieces lie in so small a place that what they enclose is nothing."""
    low_x, low_y, high_x, high_y = math.inf, math.inf, -math.inf, -math.inf
    for i in range(count):
        x0, y0, x1, y1 = box_of(S, i)
        low_x, low_y = min(low_x, x0), min(low_y, y0)
        high_x, high_y = max(high_x, x1), max(high_y, y1)
    return max(high_x - low_x, high_y - low_y) < max(_SPECK, _SIDE * count)


@inner_kernel
def _off_corners(
    raw: tuple[FloatArray, int, int],
    loop: tuple[FloatArray, int, int],
    reaches: tuple[float, float],
    spans: FloatArray,
) -> int:
    """Take out of a raw piece what corners and neighbours take, and give how many spans are left.

    Args:
        raw: Raw pieces, the one of them, and the piece of the part that it comes from.
        loop: Pieces of the part, the first of its loop and one behind the last.
        reaches: The distance, and what is certainly nearer.
        spans: What is left, one span at first.
    """
    R, r, i = raw
    P, first, end = loop
    d, reach = reaches
    size = end - first
    count, step = 1, 1
    hx, hy, wide = _hull(R, r, spans, count)
    # corners along the contour, near ones first: where the part is finer than d these take
    # nearly all of what goes
    while count > 0 and 2 * step <= size + 1:
        for way in (-step, step):
            v = first + (i - first + way + size) % size
            if step == 1 and R[r, 4] == 0.0 and P[v, 4] == 0.0:
                # of the neighbours the sides themselves, by which most corners are trimmed
                count = _without_side(R, r, (P, v, d), spans, count)
                if count == 0:
                    return 0
                hx, hy, wide = _hull(R, r, spans, count)
            away2 = (P[v, 0] - hx) ** 2 + (P[v, 1] - hy) ** 2
            if away2 >= (reach + wide) ** 2:
                continue
            if wide < reach and away2 < (reach - wide) ** 2:
                return 0
            count = _without_disc(R, r, (P[v, 0], P[v, 1], reach), spans, count)
            if count == 0:
                return 0
            hx, hy, wide = _hull(R, r, spans, count)
        step += 1 if step < 4 else step // 2
    return count


@bare_kernel
def _survive(
    part: tuple[FloatArray, FloatArray, FloatArray, Disc],
    raw: tuple[FloatArray, FloatArray, FloatArray],
    d: float,
    r: int,
    kept: tuple[FloatArray, FloatArray, int],
    work: tuple[FloatArray, FloatArray],
) -> tuple[int, int]:
    """Write what survives of raw pieces from one on while there is room.

    Returns:
        The next raw piece, and how many pieces are written.
    """
    P, T, loops, heart = part
    R, curve, owner = raw
    S, numbers, m = kept
    spans, stack = work
    reach = d - min(_LOOSE, 1e-3 * d)
    # among few pieces it costs less to find where all of them meet
    probing = R.shape[0] > _FEW
    seen, loop = (math.inf, math.inf, -1), 0
    while r < R.shape[0] and m + _SPANS <= S.shape[0]:
        i = int(owner[r])
        while i >= loops[loop + 1]:
            loop += 1
        spans[0, 0], spans[0, 1] = 0.0, 1.0
        count = _off_corners(
            (R, r, i), (P, int(loops[loop]), int(loops[loop + 1])), (d, reach), spans
        )
        if probing:
            count, seen = _probed((R, r), (P, T, heart), reach, (spans, count, stack), seen)
        for k in range(count):
            ax, ay = at_share(R, r, spans[k, 0])
            bx, by = at_share(R, r, spans[k, 1])
            if spans[k, 0] <= 0.0:
                ax, ay = R[r, 0], R[r, 1]
            if spans[k, 1] >= 1.0:
                bx, by = R[r, 2], R[r, 3]
            set_piece(S, m, (ax, ay, bx, by), R[r, 4])
            numbers[m] = curve[r]
            m += 1
        r += 1
    return r, m


@inner_kernel
def _probed(
    raw: tuple[FloatArray, int],
    part: tuple[FloatArray, FloatArray, Disc],
    reach: float,
    work: tuple[FloatArray, int, FloatArray],
    seen: tuple[float, float, int],
) -> tuple[int, tuple[float, float, int]]:
    """Take out of spans what is near where they begin or end, until nothing is.

    Args:
        raw: Raw pieces, and the one of them.
        part: Pieces of the part, their tree, and a disc that none of them reaches into.
        reach: What is certainly nearer.
        work: What is left, how many spans, and room to search in.
        seen: The last place (x, y) that nothing is near, and the last piece that was near one.

    Returns:
        How many spans are left, and what was seen last.
    """
    R, r = raw
    P, T, heart = part
    spans, count, stack = work
    clear_x, clear_y, hint = seen
    k, looks = 0, 0
    while k < count:
        # what is left must begin and end where nothing is nearer
        taken = False
        for c in range(2):
            u = spans[k, c]
            x, y = (R[r, 2], R[r, 3]) if u == 1.0 else at_share(R, r, u)
            if x == clear_x and y == clear_y:
                continue  # the end of the piece before, which was looked at
            far, near = math.inf, hint
            if hint >= 0:
                far = distance(P, hint, x, y)
            if not far < reach and not is_clear(heart, x, y, reach):
                far, near = nearest(P, P.shape[0], T, (x, y), (reach, reach), stack)
            if near >= 0 and far < reach:
                hint = near
                count = _without_near(R, r, (u, near, far), (P, reach), (spans, count))
                taken = True
                break
            clear_x, clear_y = x, y
        looks += 1
        if not taken or looks > _LOOKS:
            k += 1
            looks = 0
    return count, (clear_x, clear_y, hint)
