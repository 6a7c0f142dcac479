"""Every segment moved aside, and what joins them about corners, compiled.

All lengths are in units of the part (`offset` scales it), loops are closed, and the offset is to
the left.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .arc_kernel import COLUMNS, set_piece
from .offset_corner_kernel import HALVES, MITRE, ROUND, Corner, is_end, style_of

_QUARTER = 0.5 * math.pi * (1.0 + 1e-9)
_STRAIGHT = 1e-13
"""An outer corner whose arc would be no farther than this from one point is that point."""


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
    P: FloatArray, segment: FloatArray, loops: FloatArray, d: float, corner: Corner
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give every piece moved to its left, and what joins them about outer corners.

    Args:
        P: Pieces of the part.
        segment: The segment of each.
        loops: The first piece of each loop and n.
        d: How far, above 0.
        corner: How corners are joined and ends go.

    Returns:
        Raw pieces, shape (m, 9); of each a number that is the same along one line or arc, even for
        segments and odd for corners; and the piece of the part that it comes from.
    """
    n = P.shape[0]
    room = 4 * n + 2  # and two halves more at ends
    R = np.empty((room, COLUMNS))
    curve, owner = np.empty(room), np.empty(room)
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
        end = is_end(corner, segment[i], segment[j])
        style = style_of(corner, turn, end)
        parts, bend, reach = max(1, math.ceil(-turn / _QUARTER)), -1.0 / d, d
        edged = style != ROUND
        if edged:
            # lines along the offsets up to a mitre, or to a cut across at the distance itself
            parts, bend = 2 if style == MITRE else 3, 0.0
            reach = d / math.cos(0.5 * turn / (parts - 1.0))
        halves = end and corner[2] >= HALVES
        number = 2.0 * segment[i] + 1.0
        ax, ay = E[i, 2], E[i, 3]
        for part in range(1, parts + 1):
            bx, by = E[j, 0], E[j, 1]
            if part < parts:
                angle = turn * (part - 0.5) / (parts - 1.0) if edged else turn * part / parts
                co, si = math.cos(angle), math.sin(angle)
                bx = P[i, 2] + reach * (co * P[i, 7] - si * P[i, 8])
                by = P[i, 3] + reach * (si * P[i, 7] + co * P[i, 8])
            if halves and part == 2:
                # what goes around the end of a path belongs half to each of its sides
                if edged:
                    mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
                    set_piece(R, m, (ax, ay, mx, my), bend)
                    curve[m], owner[m] = number, i
                    m += 1
                    ax, ay = mx, my
                number += 0.5
            set_piece(R, m, (ax, ay, bx, by), bend)
            curve[m], owner[m] = number, i
            # the lines on from both ends of a line are one with it, those from an arc are not
            if edged and part == 1:
                curve[m] = 2.0 * segment[i] + (0.25 if P[i, 4] != 0.0 else 0.0)
            elif edged and part == parts:
                curve[m] = 2.0 * segment[j] + (0.125 if P[j, 4] != 0.0 else 0.0)
            m += 1
            ax, ay = bx, by
    return R[:m], curve[:m], owner[:m]
