"""Chains as arcs: the longest pairs of arcs within a tolerance, compiled.

Two arcs lead from a place to another, with the direction of the chain at both, and join smoothly.
How far a segment strays from a circle is a polynomial, so that what is found at Chebyshev points
bounds it in between, see ``spline_bound_kernel``.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .spline_bound_kernel import DENSE, SPREAD
from .spline_jet_kernel import jet_at

ARC = 5
"""Columns of an arc: where it begins, its bulge, from and to which place of the chain."""
_SPARSE = 9
_SHORT = 1e-9
"""Of a segment, a share so small that rounding hides how arcs lie along it."""


@fast_kernel
def biarc(
    S: FloatArray, chain: tuple[float, float], a: float, b: float, arcs: FloatArray
) -> tuple[float, float, float, float]:
    """Write the two arcs from one place to another; give where the second ends and T there."""
    lo, hi = chain
    ax, ay, ux, uy, _, _ = jet_at(S, lo, hi, a)
    bx, by, vx, vy, _, _ = jet_at(S, lo, hi, b)
    u, v = math.sqrt(ux * ux + uy * uy), math.sqrt(vx * vx + vy * vy)
    ux, uy, vx, vy = ux / u, uy / u, vx / v, vy / v
    wx, wy, sx, sy = bx - ax, by - ay, ux + vx, uy + vy
    w2, ws, turn = wx * wx + wy * wy, wx * sx + wy * sy, 1.0 - ux * vx - uy * vy
    # Bolton, Biarc curves, CAD 7 (1975) 89, with arms of equal length
    h = w2 / (ws + math.sqrt(max(0.0, ws * ws + 2.0 * turn * w2)))
    jx, jy = 0.5 * (ax + bx + h * (ux - vx)), 0.5 * (ay + by + h * (uy - vy))
    tx, ty = wx - h * sx, wy - h * sy
    t = math.sqrt(tx * tx + ty * ty)
    tx, ty = tx / t, ty / t
    # the place beside the joint, on the line across it
    U = 0.5 * (a + b)
    for _ in range(20):
        px, py, dx, dy, _, _ = jet_at(S, lo, hi, U)
        step = 0.5 * ((jx - px) * tx + (jy - py) * ty) / (dx * tx + dy * ty)
        U = min(b, max(a, U + step))
        if abs(step) < 1e-13:
            break
    arcs[0, 0], arcs[0, 1], arcs[0, 2] = ax, ay, _bulge(ux, uy, jx - ax, jy - ay)
    arcs[1, 0], arcs[1, 1], arcs[1, 2] = jx, jy, _bulge(tx, ty, bx - jx, by - jy)
    arcs[0, 3], arcs[0, 4], arcs[1, 3], arcs[1, 4] = a, U, U, b
    return bx, by, tx, ty


@fast_kernel
def _bulge(tx: float, ty: float, ex: float, ey: float) -> float:
    """Give the bulge of an arc from its direction at its start and its chord."""
    return (tx * ey - ty * ex) / (math.sqrt(ex * ex + ey * ey) + tx * ex + ty * ey)


@fast_kernel
def strays(
    S: FloatArray, chain: tuple[float, float], arc: FloatArray, end: tuple[float, float], looks: int
) -> float:
    """Give how far a chain strays from an arc, at so many points a segment.

    Args:
        S: Segments.
        chain: Where the chain begins and ends.
        arc: The arc, shape (5,).
        end: Where it ends.
        looks: Points a segment; 0: as many as it takes for a bound.
    """
    lo, hi = chain
    ax, ay, bulge = arc[0], arc[1], arc[2]
    ex, ey = end[0] - ax, end[1] - ay
    c = math.sqrt(ex * ex + ey * ey)
    ex, ey = ex / c, ey / c
    grown = 1.0 + bulge * bulge
    k = 4.0 * bulge / (grown * c)
    co, si = (1.0 - bulge * bulge) / grown, 2.0 * bulge / grown
    # the direction at the start is the chord turned back by half of the turn
    nx, ny = -(ey * co - ex * si), ex * co + ey * si
    worst = 0.0
    degree = 2 * (S.shape[1] - 1)
    first, last = int(arc[3]), math.ceil(arc[4])
    for seg in range(first, max(first + 1, last)):
        low, high = max(arc[3], float(seg)), min(arc[4], seg + 1.0)
        if high <= low:
            continue
        rational = False
        for j in range(1, S.shape[1]):
            rational = rational or S[seg, j, 2] != 0.0
        count = looks or DENSE * degree
        most, heaviest, lightest = 0.0, 0.0, math.inf
        for i in range(count):
            s = 0.5 * (low + high) + 0.5 * (high - low) * math.cos(math.pi * (i + 0.5) / count)
            x, y, _, _, _, _ = jet_at(S, max(lo, float(seg)), min(hi, seg + 1.0), s)
            qx, qy = x - ax, y - ay
            g = abs(nx * qx + ny * qy - 0.5 * k * (qx * qx + qy * qy))
            if rational:
                w = _weight(S, seg, 2.0 * (s - seg) - 1.0)
                heaviest, lightest = max(heaviest, w), min(lightest, w)
                g *= w * w
            most = max(most, g)
        if looks == 0:
            most *= SPREAD
            if rational:
                # the weight is a polynomial too
                half = 0.5 * SPREAD * (heaviest - lightest)
                lightest = 0.5 * (heaviest + lightest) - half
        if rational:
            most /= lightest * lightest if lightest > 0.0 else 1e-300
        worst = max(worst, most)
    return 2.0 * worst / (1.0 + math.sqrt(max(0.0, 1.0 - 2.0 * abs(k) * worst)))


@fast_kernel
def _weight(S: FloatArray, k: int, s: float) -> float:
    w = 0.0
    for j in range(S.shape[1] - 1, -1, -1):
        w = w * s + S[k, j, 2]
    return w


@fast_kernel
def _misses(
    S: FloatArray,
    chain: tuple[float, float],
    run: tuple[float, float],
    arcs: FloatArray,
    looks: int,
) -> float:
    """Give how far two arcs between places stray from the chain."""
    bx, by, _, _ = biarc(S, chain, run[0], run[1], arcs)
    if abs(arcs[0, 2]) > 0.5 or abs(arcs[1, 2]) > 0.5 or not arcs[0, 3] < arcs[0, 4] < arcs[1, 4]:
        return math.inf
    return max(
        strays(S, chain, arcs[0], (arcs[1, 0], arcs[1, 1]), looks),
        strays(S, chain, arcs[1], (bx, by), looks),
    )


@fast_kernel
def arcs_along(
    S: FloatArray, chain: tuple[float, float], run: tuple[float, float], tolerance: float
) -> FloatArray:
    """Give the longest arcs, one after the other, that are proven to be within a tolerance.

    Args:
        S: Segments.
        chain: Where the chain begins and ends.
        run: From where to where.
        tolerance: How far from the chain.

    Returns:
        The arcs, shape (m, 5); m = 0: it needs too many.
    """
    found = np.empty((64, ARC))
    arcs = np.empty((2, ARC))
    count, a, step = 0, run[0], 0.25 * (run[1] - run[0])
    while a < run[1]:
        low, high, b = a, math.inf, min(run[1], a + step)
        looks = _SPARSE
        for _ in range(80):
            if b - a < _SHORT:
                break
            miss = _misses(S, chain, (a, b), arcs, looks)
            if miss <= tolerance and looks:
                looks = 0
                miss = _misses(S, chain, (a, b), arcs, looks)
            if miss <= tolerance:
                low = b
                if b >= run[1]:
                    break
                b = min(run[1], a + 1.5 * (b - a)) if high == math.inf else 0.5 * (low + high)
            else:
                high = b
                if low > a:
                    b = 0.5 * (low + high)
                else:
                    # the miss of a pair of arcs grows as the cube of its length
                    b = a + (b - a) * max(0.25, min(0.9, (tolerance / miss) ** (1.0 / 3.0)))
            looks = _SPARSE
            if low > a and high - low < 0.02 * (low - a):
                break
        if low <= a or count > 200_000:
            return np.empty((0, ARC))
        _misses(S, chain, (a, low), arcs, _SPARSE)
        if count + 2 > found.shape[0]:
            found = np.concatenate((found, np.empty_like(found)))
        for i in range(2):
            for c in range(ARC):
                found[count + i, c] = arcs[i, c]
        count += 2
        step = 1.05 * (low - a)
        a = low
    return found[:count].copy()
