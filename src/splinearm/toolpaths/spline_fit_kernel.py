"""The fewest cubic pieces within a band beside a chain, compiled.

A piece begins and ends parallel to the band, mostly at one of its two edges: there the deviation of
the best cubic from an offset has its extremes, as many of them as it has freedoms. Where the
deviation changes its sign it may do so in the middle. What is left of a piece are the lengths of
its two handles.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .spline_jet_kernel import foot, jet_at, moved

NODES = 16
"""A piece is looked at in so many places while it is fitted."""
PIECE = 6
"""Columns of a piece: from, to, share of the band there and there, handle there and there."""
EDGES = 3
"""Pieces begin and end at the near edge of the band, the far one, or in the middle."""
_LOOKS = 40
"""And in so many when it fits there."""
_ROUNDS = 12
_WEIGHTINGS = 12
_WELL = 0.98
"""A share of the band's half that is good enough not to fit on."""


@kernel
def piece_points(
    S: FloatArray, chain: tuple[float, float], piece: FloatArray, band: tuple[float, float]
) -> tuple[float, float, float, float, float, float, float, float]:
    """Give the control points of a piece."""
    lo, hi = chain
    ax, ay, ux, uy, _, _ = moved(S, lo, hi, piece[0], band[0] + piece[2] * (band[1] - band[0]))
    bx, by, vx, vy, _, _ = moved(S, lo, hi, piece[1], band[0] + piece[3] * (band[1] - band[0]))
    g, h = piece[4], piece[5]
    return ax, ay, ax + g * ux, ay + g * uy, bx - h * vx, by - h * vy, bx, by


@kernel
def fit(
    S: FloatArray,
    chain: tuple[float, float],
    piece: FloatArray,
    band: tuple[float, float],
    work: FloatArray,
) -> float:
    """Set the handles of a piece so that it strays least; give by how much from the band's middle.

    Args:
        S: Segments.
        chain: Where the chain begins and ends.
        piece: The piece, of which the last two numbers are written.
        band: Distances of the near and the far edge.
        work: Room, shape (NODES, 7).
    """
    lo, hi = chain
    a, b = piece[0], piece[1]
    width = band[1] - band[0]
    first, last = band[0] + piece[2] * width, band[0] + piece[3] * width
    ax, ay, ux, uy, ka, _ = moved(S, lo, hi, a, first)
    bx, by, vx, vy, kb, _ = moved(S, lo, hi, b, last)
    middle, enough = 0.5 * (band[0] + band[1]), 0.5 * (band[1] - band[0]) * _WELL
    if ka * first >= 1.0 or kb * last >= 1.0:
        return math.inf
    L = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    turn = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)
    # the cubic nearest to a circular arc (Goldapp, CAGD 8 (1991) 227)
    g = L / (3.0 * math.cos(0.25 * turn) ** 2)
    h = g
    for i in range(NODES):
        t = 0.5 - 0.5 * math.cos(math.pi * (i + 0.5) / NODES)
        work[i, 0], work[i, 1] = t, a + (b - a) * t
    best, least, most = math.inf, 0.02 * L, 1.5 * L
    dg, dh = 0.0, 0.0
    for _ in range(_ROUNDS):
        worst = 0.0
        for i in range(NODES):
            t = work[i, 0]
            r = 1.0 - t
            B0, B1, B2, B3 = r * r * r, 3.0 * r * r * t, 3.0 * r * t * t, t * t * t
            x = (B0 + B1) * ax + (B2 + B3) * bx + B1 * g * ux - B2 * h * vx
            y = (B0 + B1) * ay + (B2 + B3) * by + B1 * g * uy - B2 * h * vy
            U = foot(S, lo, hi, work[i, 1], x, y)
            work[i, 1] = U
            px, py, dx, dy, _, _ = jet_at(S, lo, hi, U)
            v = math.sqrt(dx * dx + dy * dy)
            nx, ny = -dy / v, dx / v
            e = (x - px) * nx + (y - py) * ny - middle
            work[i, 2], work[i, 3], work[i, 4] = (
                e,
                B1 * (ux * nx + uy * ny),
                -B2 * (vx * nx + vy * ny),
            )
            worst = max(worst, abs(e))
        if worst < best:
            gain = best - worst
            best, piece[4], piece[5] = worst, g, h
            if best <= enough or gain < 1e-3 * best:
                break
            dg, dh, hoped = _least_step(work)
            if hoped > 0.999 * worst:
                break
            shrink = min(1.0, 0.3 * L / max(abs(dg), abs(dh), 1e-300))
            dg, dh = shrink * dg, shrink * dh
        else:
            # too far for what was assumed to be straight
            dg, dh = 0.3 * dg, 0.3 * dh
        g = min(most, max(least, piece[4] + dg))
        h = min(most, max(least, piece[5] + dh))
    return best


@kernel
def _least_step(work: FloatArray) -> tuple[float, float, float]:
    """Give the step of both handles after which the largest deviation is least, and that."""
    # Lawson 1961: least squares, weighted anew by what is left (Rice and Usow, Math. Comp. 22)
    for i in range(NODES):
        work[i, 5] = 1.0 / NODES
    best, bg, bh = math.inf, 0.0, 0.0
    for _ in range(_WEIGHTINGS):
        A, B, C, P, Q = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(NODES):
            w, e, j, k = work[i, 5], work[i, 2], work[i, 3], work[i, 4]
            A += w * j * j
            B += w * j * k
            C += w * k * k
            P -= w * j * e
            Q -= w * k * e
        small = 1e-10 * (A + C) + 1e-300
        A, C = A + small, C + small
        det = A * C - B * B
        dg, dh = (P * C - Q * B) / det, (A * Q - B * P) / det
        worst, total = 0.0, 0.0
        for i in range(NODES):
            left = abs(work[i, 2] + work[i, 3] * dg + work[i, 4] * dh)
            work[i, 6] = left
            worst = max(worst, left)
            total += work[i, 5] * left
        if worst < best:
            best, bg, bh = worst, dg, dh
        if total <= 0.0:
            break
        for i in range(NODES):
            work[i, 5] *= work[i, 6] / total
    return bg, bh, best


@kernel
def fits(
    S: FloatArray,
    chain: tuple[float, float],
    piece: FloatArray,
    band: tuple[float, float],
    work: FloatArray,
) -> float:
    """Set the handles of a piece, see ``fit``; give 1 or less if it keeps within the band."""
    half = 0.5 * (band[1] - band[0]) * (1.0 + 1e-6)
    worst = fit(S, chain, piece, band, work)
    if worst > half:
        return worst / half
    lo, hi = chain
    middle, U = 0.5 * (band[0] + band[1]), piece[0]
    ax, ay, bx, by, cx, cy, dx, dy = piece_points(S, chain, piece, band)
    for i in range(1, _LOOKS):
        t = i / _LOOKS
        r = 1.0 - t
        A, B, C, D = r * r * r, 3.0 * r * r * t, 3.0 * r * t * t, t * t * t
        x, y = A * ax + B * bx + C * cx + D * dx, A * ay + B * by + C * cy + D * dy
        U = foot(S, lo, hi, U + (piece[1] - piece[0]) / _LOOKS, x, y)
        px, py, ux, uy, _, _ = jet_at(S, lo, hi, U)
        v = math.sqrt(ux * ux + uy * uy)
        worst = max(worst, abs(((y - py) * ux - (x - px) * uy) / v - middle))
        if worst > half:
            break
    return worst / half


@kernel
def _longest(
    S: FloatArray,
    chain: tuple[float, float],
    piece: FloatArray,
    band: tuple[float, float],
    limits: tuple[float, float],
    work: FloatArray,
) -> bool:
    """Set the end of a piece as far on as it fits, at most to limits[0], first to limits[1]."""
    a, end = piece[0], limits[0]
    low, high = a, math.inf
    g, h = 0.0, 0.0
    u = min(end, limits[1])
    if end - a < 1.5 * (u - a):
        u = end
    for _ in range(60):
        piece[1] = u
        e = fits(S, chain, piece, band, work)
        if e <= 1.0:
            low, g, h = u, piece[4], piece[5]
            if u >= end:
                break
            u = min(end, a + 1.4 * (u - a)) if high == math.inf else 0.5 * (low + high)
        else:
            high = u
            if low > a:
                u = 0.5 * (low + high)
            else:
                u = a + (u - a) * max(0.3, min(0.85, e ** (-1.0 / 6.0)))
                if u - a < 1e-7:
                    return False
        if low > a and high - low < 0.008 * (low - a):
            break
    piece[1], piece[4], piece[5] = low, g, h
    return bool(low > a)


@kernel
def _share(edge: int) -> float:
    """Give where in the band an edge is: 0 near, 1 far, 2 in the middle."""
    return 0.5 if edge == 2 else float(edge)


@kernel
def fewest(
    S: FloatArray,
    chain: tuple[float, float],
    run: tuple[float, float],
    band: tuple[float, float],
    edges: tuple[int, int],
) -> FloatArray:
    """Give the fewest pieces from one place of a chain to another, shape (m, 6); m = 0: none fit.

    Args:
        S: Segments.
        chain: Where the chain begins and ends.
        run: From where to where.
        band: Distances of the near and the far edge.
        edges: At which edge it begins and ends: 0 near, 1 far, 2 in the middle, -1 any of them.
    """
    table, before = np.empty((64, EDGES, PIECE)), np.zeros((64, EDGES), np.int64)
    reach, work = np.empty(EDGES), np.empty((NODES, 7))
    from_ = np.full(EDGES, run[0])
    for edge in range(EDGES):
        if edges[0] >= 0 and edge != edges[0]:
            from_[edge] = -math.inf
    usual, last, count = 0.25 * (run[1] - run[0]), -1, 0
    while last < 0:
        if count == table.shape[0]:
            table = np.concatenate((table, np.empty_like(table)))
            before = np.concatenate((before, np.zeros_like(before)))
        for edge in range(EDGES):
            reach[edge] = -math.inf
            for start in range(EDGES):
                if from_[start] == -math.inf:
                    continue
                # where it must not end it leaves room for one piece more
                wrong = edges[1] >= 0 and edge != edges[1]
                limit = run[1] - (0.04 * (run[1] - from_[start]) if wrong else 0.0)
                trial = np.array([from_[start], 0.0, _share(start), _share(edge), 0.0, 0.0])
                if _farther(S, chain, trial, band, (limit, reach[edge], usual), work):
                    reach[edge], before[count, edge] = trial[1], start
                    for c in range(PIECE):
                        table[count, edge, c] = trial[c]
            if reach[edge] >= run[1]:
                last = edge
        ahead = reach.max() - from_.max()
        if not ahead > 0.0:
            return np.empty((0, PIECE))
        usual = max(1e-4, 0.9 * ahead)
        for edge in range(EDGES):
            from_[edge] = reach[edge]
        count += 1
    found = np.empty((count, PIECE))
    for i in range(count - 1, -1, -1):
        for c in range(PIECE):
            found[i, c] = table[i, last, c]
        last = before[i, last]
    return found


@kernel
def _farther(
    S: FloatArray,
    chain: tuple[float, float],
    trial: FloatArray,
    band: tuple[float, float],
    marks: tuple[float, float, float],
    work: FloatArray,
) -> bool:
    """Set the end of a piece as far on as it fits, if that is beyond what was reached so far."""
    limit, reached, usual = marks
    guess = trial[0] + usual
    if reached > trial[0]:
        trial[1] = min(limit, reached + 0.004 * usual)
        if trial[1] <= reached:
            return False
        if fits(S, chain, trial, band, work) > 1.0:
            return False
        guess = trial[1]
    return _longest(S, chain, trial, band, (limit, guess), work)
