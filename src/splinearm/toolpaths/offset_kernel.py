"""Every segment moved aside and what can be left of it, compiled.

All lengths are in units of the part (`offset` scales it), loops are closed, and the offset is to
the left. What a raw piece loses here is only what certainly goes: the crossings of what is left are
found elsewhere.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .arc_kernel import COLUMNS, at_share, disc_cuts, distance, set_piece
from .tree_kernel import nearest

ROUND, MITRE, CHAMFER = 0.0, 1.0, 2.0

_QUARTER = 0.5 * math.pi * (1.0 + 1e-9)
_STRAIGHT = 1e-13
"""An outer corner whose arc would be no farther than this from one point is that point."""
_LOOSE = 2e-11
"""What is nearer to the part by more than this certainly goes."""
_SPANS = 8
"""What is left of one piece may be in so many parts."""
_LOOKS = 12
_FEW = 160


@fast_kernel
def pieces_of(
    vertices: FloatArray, bulges: FloatArray, starts: FloatArray, tiny: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give closed loops as pieces of at most a quarter turn.

    Args:
        vertices: Where segments begin, loop after loop, shape (m, 2).
        bulges: Of each segment the tangent of a quarter of its turn, shape (m,).
        starts: The first vertex of each loop and m, shape (loops + 1,).
        tiny: A segment with a chord up to this is none.

    Returns:
        Pieces, shape (n, 9), the segment of each, shape (n,), and the first piece of each loop
        and n.
    """
    m = vertices.shape[0]
    room = 0
    for i in range(m):
        room += 1 + int(4.0 * abs(math.atan(bulges[i])) / (0.5 * math.pi))
    P, segment = np.empty((room, COLUMNS)), np.empty(room)
    loops = np.empty(starts.shape[0])
    n = 0
    for loop in range(starts.shape[0] - 1):
        first, end = int(starts[loop]), int(starts[loop + 1])
        loops[loop] = n
        ax, ay = vertices[first, 0], vertices[first, 1]
        for i in range(first, end):
            j = i + 1 if i + 1 < end else first
            bx, by, bulge = vertices[j, 0], vertices[j, 1], bulges[i]
            c = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            if c <= tiny:
                continue
            turn = 4.0 * math.atan(bulge)
            k = 4.0 * bulge / ((1.0 + bulge * bulge) * c)
            parts = max(1, math.ceil(abs(turn) / _QUARTER))
            cx, cy = 0.0, 0.0
            if parts > 1:
                # the centre stands over the middle of the chord
                h = 0.25 * (1.0 / bulge - bulge)
                cx, cy = 0.5 * (ax + bx) - h * (by - ay), 0.5 * (ay + by) + h * (bx - ax)
            rx, ry = ax - cx, ay - cy
            px, py = ax, ay
            for part in range(1, parts + 1):
                qx, qy = bx, by
                if part < parts:
                    co, si = math.cos(turn * part / parts), math.sin(turn * part / parts)
                    qx, qy = cx + co * rx - si * ry, cy + si * rx + co * ry
                set_piece(P, n, (px, py, qx, qy), k)
                segment[n] = i
                n += 1
                px, py = qx, qy
            ax, ay = bx, by
        if n > loops[loop]:
            # what was too short to be a segment: the loop is closed all the same
            s, e = int(loops[loop]), n - 1
            set_piece(P, e, (P[e, 0], P[e, 1], P[s, 0], P[s, 1]), P[e, 4])
    loops[starts.shape[0] - 1] = n
    return P[:n], segment[:n], loops


@fast_kernel
def raw_pieces(
    P: FloatArray, segment: FloatArray, loops: FloatArray, d: float, corner: tuple[float, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give every piece moved to its left, and what joins them about outer corners.

    Args:
        P: Pieces of the part.
        segment: The segment of each.
        loops: The first piece of each loop and n.
        d: How far, above 0.
        corner: How corners are joined, and the largest reach of a mitre as a multiple of d.

    Returns:
        Raw pieces, shape (m, 9); of each a number that is the same along one line or arc, even for
        segments and odd for corners; and the piece of the part that it comes from.
    """
    n = P.shape[0]
    style, limit = corner
    R = np.empty((4 * n, COLUMNS))
    curve, owner = np.empty(4 * n), np.empty(4 * n)
    follower = np.empty(n, np.int64)
    E = np.empty((n, 4))  # where the moved pieces begin and end
    turns = np.empty(n)  # how far the way turns at outer corners
    for loop in range(loops.shape[0] - 1):
        first, end = int(loops[loop]), int(loops[loop + 1])
        for i in range(first, end):
            j = i + 1 if i + 1 < end else first
            follower[i] = j
            ux, uy, vx, vy = P[i, 7], P[i, 8], P[j, 5], P[j, 6]
            x, y = P[i, 2], P[i, 3]
            cross, dot = ux * vy - uy * vx, ux * vx + uy * vy
            turns[i] = 0.0
            if dot > 0.0 and 0.125 * cross * cross * d <= _STRAIGHT:
                sx, sy = ux + vx, uy + vy
                s = d / math.sqrt(sx * sx + sy * sy)
                E[i, 2], E[i, 3], E[j, 0], E[j, 1] = x + s * sx, y + s * sy, x + s * sx, y + s * sy
                continue
            E[i, 2], E[i, 3], E[j, 0], E[j, 1] = x + d * ux, y + d * uy, x + d * vx, y + d * vy
            outer = cross < 0.0
            if dot < 0.0 and abs(cross) < 1e-9:
                # straight back, or a cusp: which side of it is outer the curvatures tell
                outer = P[i, 4] + P[j, 4] >= -1e-9 * abs(P[i, 4])
            if outer:
                turn = math.atan2(cross, dot)
                turns[i] = turn if turn < 0.0 else turn - 2.0 * math.pi
    m = 0
    for i in range(n):
        shrink = 1.0 - P[i, 4] * d
        if shrink > 1e-12:
            set_piece(R, m, (E[i, 0], E[i, 1], E[i, 2], E[i, 3]), P[i, 4] / shrink)
            curve[m], owner[m] = 2.0 * segment[i], i
            m += 1
        turn = turns[i]
        if turn == 0.0:
            continue
        j = follower[i]
        number = 2.0 * segment[i] + 1.0
        ax, ay = E[i, 2], E[i, 3]
        parts, bend, reach = max(1, math.ceil(-turn / _QUARTER)), -1.0 / d, d
        edged = style != ROUND and turn > -math.pi * (1.0 - 1e-9)
        if edged:
            # lines along the offsets up to a mitre, or to a cut across at the distance itself
            bend = 0.0
            parts = 2 if style == MITRE and limit * math.cos(0.5 * turn) >= 1.0 else 3
            reach = d / math.cos(0.5 * turn / (parts - 1.0))
        for part in range(1, parts + 1):
            bx, by = E[j, 0], E[j, 1]
            if part < parts:
                angle = turn * (part - 0.5) / (parts - 1.0) if edged else turn * part / parts
                co, si = math.cos(angle), math.sin(angle)
                bx = P[i, 2] + reach * (co * P[i, 7] - si * P[i, 8])
                by = P[i, 3] + reach * (si * P[i, 7] + co * P[i, 8])
            set_piece(R, m, (ax, ay, bx, by), bend)
            curve[m], owner[m] = number, i
            if edged and part == 1:
                curve[m] = 2.0 * segment[i]
            elif edged and part == parts:
                curve[m] = 2.0 * segment[j]
            m += 1
            ax, ay = bx, by
    return R[:m], curve[:m], owner[:m]


@fast_kernel
def corners_of(
    P: FloatArray, loops: FloatArray, d: float, corner: tuple[float, float]
) -> FloatArray:
    """Give the corners that reach farther than d, none if they are round.

    Returns:
        Rows of a corner's place, of the normals before and behind it, between which it lies, and of
        the normal of the cut across it, or zeros: what lies in it is less than d along each.
    """
    style, limit = corner
    C = np.empty((P.shape[0] if style != ROUND else 0, 8))
    m = 0
    for loop in range(loops.shape[0] - 1):
        first, end = int(loops[loop]), int(loops[loop + 1])
        for i in range(first, end if style != ROUND else first):
            j = i + 1 if i + 1 < end else first
            ux, uy, vx, vy = P[i, 7], P[i, 8], P[j, 5], P[j, 6]
            cross = ux * vy - uy * vx
            turn = math.atan2(cross, ux * vx + uy * vy)
            if not -math.pi * (1.0 - 1e-9) < turn < -1e-6:
                continue
            cut = 0.0 if style == MITRE and limit * math.cos(0.5 * turn) >= 1.0 else 1.0
            co, si = math.cos(0.5 * turn), math.sin(0.5 * turn)
            C[m, 0], C[m, 1], C[m, 2], C[m, 3], C[m, 4], C[m, 5] = P[i, 2], P[i, 3], ux, uy, vx, vy
            C[m, 6], C[m, 7] = cut * (co * ux - si * uy), cut * (si * ux + co * uy)
            m += 1
    return C[:m]


@fast_kernel
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


@fast_kernel
def _hull(R: FloatArray, r: int, spans: FloatArray, count: int) -> tuple[float, float, float]:
    """Give a disc that all spans lie in."""
    low, high = 1.0, 0.0
    for k in range(count):
        low, high = min(low, spans[k, 0]), max(high, spans[k, 1])
    x, y = at_share(R, r, 0.5 * (low + high))
    c = math.sqrt((R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2)
    # half the way on the chord, by at most 1 / cos 45 deg longer on the arc
    return x, y, 0.7072 * (high - low) * c


@fast_kernel
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


@fast_kernel
def _without_near(
    R: FloatArray,
    r: int,
    spot: tuple[float, int, float],
    model: tuple[FloatArray, int, float],
    work: tuple[FloatArray, int],
) -> int:
    """Take out of spans what a near piece of the part certainly takes about a share."""
    u, near, far = spot
    P, _, reach = model
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
) -> tuple[FloatArray, FloatArray]:
    """Give the raw pieces without what is certainly nearer to the part than d.

    Args:
        P: Pieces of the part.
        T: Their tree.
        loops: The first piece of each loop and n.
        raw: Raw pieces, the number of the line or arc of each, and the piece each comes from.
        d: How far they were moved.

    Returns:
        What survives, shape (m, 9), and the numbers of their lines and arcs.
    """
    R, curve, owner = raw
    n = P.shape[0]
    S, numbers = np.empty((R.shape[0] + 64, COLUMNS)), np.empty(R.shape[0] + 64)
    reach = d - min(_LOOSE, 1e-3 * d)
    spans, stack, clear = np.empty((_SPANS, 2)), np.empty((128, 2)), np.full(2, math.inf)
    # among few pieces it costs less to find where all of them meet
    probing = R.shape[0] > _FEW
    m, loop, hint = 0, 0, -1
    for r in range(R.shape[0]):
        i = int(owner[r])
        while i >= loops[loop + 1]:
            loop += 1
        first, end = int(loops[loop]), int(loops[loop + 1])
        size = end - first
        spans[0, 0], spans[0, 1] = 0.0, 1.0
        count, step = 1, 1
        hx, hy, wide = _hull(R, r, spans, count)
        # corners along the contour, near ones first: where the part is finer than d these take
        # nearly all of what goes
        while count > 0 and 2 * step <= size + 1:
            for way in (-step, step):
                v = first + (i - first + way + size) % size
                away2 = (P[v, 0] - hx) ** 2 + (P[v, 1] - hy) ** 2
                if away2 >= (reach + wide) ** 2:
                    continue
                if wide < reach and away2 < (reach - wide) ** 2:
                    count = 0
                    break
                count = _without_disc(R, r, (P[v, 0], P[v, 1], reach), spans, count)
                if count == 0:
                    break
                hx, hy, wide = _hull(R, r, spans, count)
            step += 1 if step < 4 else step // 2
        k = 0 if probing else count
        looks = 0
        while k < count:
            # what is left must begin and end where nothing is nearer
            taken = False
            for c in range(2):
                u = spans[k, c]
                x, y = (R[r, 2], R[r, 3]) if u == 1.0 else at_share(R, r, u)
                if x == clear[0] and y == clear[1]:
                    continue  # the end of the piece before, which was looked at
                far = math.inf
                if hint >= 0:
                    far = distance(P, hint, x, y)
                near = hint
                if not far < reach:
                    far, near = nearest(P, n, T, (x, y), (reach, reach), stack)
                if near >= 0 and far < reach:
                    hint = near
                    count = _without_near(R, r, (u, near, far), (P, n, reach), (spans, count))
                    taken = True
                    break
                clear[0], clear[1] = x, y
            looks += 1
            if not taken or looks > _LOOKS:
                k += 1
                looks = 0
        if m + count > S.shape[0]:
            wider, longer = np.empty((2 * S.shape[0], COLUMNS)), np.empty(2 * S.shape[0])
            for q in range(m):
                for c in range(COLUMNS):
                    wider[q, c] = S[q, c]
                longer[q] = numbers[q]
            S, numbers = wider, longer
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
    return S[:m], numbers[:m]
