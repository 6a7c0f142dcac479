"""Plane curves as rows of polynomials, and the nearest place on them, compiled.

A segment is an array (n + 1, 3): coefficients of 1, s, s^2 ... for s from -1 to 1, of x and y times
the weight and of the weight. Segments that follow each other smoothly are a chain, and a place on
it is the number U of its segment and, behind the point, the share of it that is passed.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

Jet = tuple[float, float, float, float, float, float]

_STEPS = 24


@kernel
def jet(S: FloatArray, k: int, s: float) -> Jet:
    """Give a point of a segment, and the first and second derivative by s."""
    x, y, w, dx, dy, dw, ex, ey, ew = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(S.shape[1] - 1, -1, -1):
        ex, ey, ew = ex * s + dx, ey * s + dy, ew * s + dw
        dx, dy, dw = dx * s + x, dy * s + y, dw * s + w
        x, y, w = x * s + S[k, j, 0], y * s + S[k, j, 1], w * s + S[k, j, 2]
    ex, ey, ew = 2.0 * ex, 2.0 * ey, 2.0 * ew
    if w != 1.0 or dw != 0.0 or ew != 0.0:
        # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, eq. 4.8
        x, y = x / w, y / w
        dx, dy = (dx - dw * x) / w, (dy - dw * y) / w
        ex = (ex - 2.0 * dw * dx - ew * x) / w
        ey = (ey - 2.0 * dw * dy - ew * y) / w
    return x, y, dx, dy, ex, ey


@kernel
def jet_at(S: FloatArray, lo: float, hi: float, U: float) -> Jet:
    """Give point and derivatives by s at a place of the chain from lo to hi."""
    k = int(U)
    if k >= hi:
        k = int(hi) - 1
    if k < lo:
        k = int(lo)
    return jet(S, k, 2.0 * (U - k) - 1.0)


@kernel
def moved(S: FloatArray, lo: float, hi: float, U: float, d: float) -> Jet:
    """Give the point beside a place, d to its left; the unit tangent; the curvature; the speed."""
    x, y, dx, dy, ex, ey = jet_at(S, lo, hi, U)
    v = math.sqrt(dx * dx + dy * dy)
    tx, ty = dx / v, dy / v
    return x - d * ty, y + d * tx, tx, ty, (dx * ey - dy * ex) / (v * v * v), v


@kernel
def foot(S: FloatArray, lo: float, hi: float, U: float, x: float, y: float) -> float:
    """Give the place of a chain nearest to a point, sought from a place by Newton's method."""
    for _ in range(_STEPS):
        px, py, dx, dy, ex, ey = jet_at(S, lo, hi, U)
        qx, qy = x - px, y - py
        d2 = dx * dx + dy * dy
        slope = d2 - qx * ex - qy * ey
        if slope < 0.05 * d2:
            slope = d2
        step = 0.5 * (qx * dx + qy * dy) / slope
        before = U
        U = min(hi, max(lo, U + max(-0.5, min(0.5, step))))
        if abs(U - before) <= 1e-14 * hi + 1e-15:
            break
    return U


@kernel
def nearest_place(
    S: FloatArray, lo: float, hi: float, x: float, y: float, looks: int
) -> tuple[float, float]:
    """Give the place of a chain nearest to a point, from so many looks a segment, and how far."""
    best, U = math.inf, lo
    count = looks * int(hi - lo)
    for i in range(count + 1):
        at = lo + i / looks
        px, py, _, _, _, _ = jet_at(S, lo, hi, at)
        away = (x - px) ** 2 + (y - py) ** 2
        if away < best:
            best, U = away, at
    U = foot(S, lo, hi, U, x, y)
    px, py, _, _, _, _ = jet_at(S, lo, hi, U)
    away = (x - px) ** 2 + (y - py) ** 2
    return U, math.sqrt(away)


@kernel
def meet(
    S: FloatArray, first: FloatArray, second: FloatArray, d: float
) -> tuple[float, float, float, float, float]:
    """Polish where the offsets of two chains cross: their places, the point and the gap left.

    Args:
        S: Segments.
        first: Where the first chain begins and ends, where it is left (about), and 0; or, of a
            circle about a point, its centre, the direction of the point on it, rad, and 1.
        second: The same of the other.
        d: How far to the left the offset is.
    """
    a, b = first[2], second[2]
    ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0
    for _ in range(40):
        ax, ay, ux, uy = _beside(S, first, a, d)
        bx, by, vx, vy = _beside(S, second, b, d)
        gx, gy = bx - ax, by - ay
        cross = ux * vy - uy * vx
        if cross == 0.0 or math.sqrt(gx * gx + gy * gy) < 1e-16:
            break
        da, db = (gx * vy - gy * vx) / cross, (gx * uy - gy * ux) / cross
        shrink = min(1.0, 0.3 / max(abs(da), abs(db), 1e-300))
        a, b = a + shrink * da, b + shrink * db
        if first[3] == 0.0:
            a = min(first[1], max(first[0], a))
        if second[3] == 0.0:
            b = min(second[1], max(second[0], b))
        if abs(da) + abs(db) < 1e-15:
            break
    return a, b, 0.5 * (ax + bx), 0.5 * (ay + by), math.sqrt((ax - bx) ** 2 + (ay - by) ** 2)


@kernel
def _beside(
    S: FloatArray, way: FloatArray, a: float, d: float
) -> tuple[float, float, float, float]:
    """Give a point of an offset and its derivative."""
    if way[3] != 0.0:
        c, s = math.cos(a), math.sin(a)
        return way[0] + d * c, way[1] + d * s, -d * s, d * c
    x, y, tx, ty, k, v = moved(S, way[0], way[1], a, d)
    speed = 2.0 * v * (1.0 - k * d)
    return x, y, speed * tx, speed * ty
