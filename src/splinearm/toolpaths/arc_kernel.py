"""Lines and arcs of at most a quarter turn as rows of numbers, compiled.

A piece is a row ``ax ay bx by k nax nay nbx nby``: where it begins and ends, its curvature
(positive: it turns left) and the unit normals to its left at both ends. A line is an arc whose
curvature is 0; no formula divides by a curvature alone, so that arcs that are nearly straight are
as exact as any other. The circle of a piece is where

    g(x) = n . q - k/2 |q|^2 = 0    with q = x - a;

g is positive to the left of the piece. A quarter turn is short enough for the share u of the chord
at the foot of a point to grow along the whole piece.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel

COLUMNS = 9

_PARALLEL = 1e-14


@bare_kernel
def set_piece(P: FloatArray, i: int, ends: tuple[float, float, float, float], k: float) -> None:
    """Write a piece from its ends and its curvature."""
    ax, ay, bx, by = ends
    ex, ey = bx - ax, by - ay
    c = math.sqrt(ex * ex + ey * ey)
    P[i, 0], P[i, 1], P[i, 2], P[i, 3], P[i, 4] = ax, ay, bx, by, k
    if c > 0.0:
        ex /= c
        ey /= c
    # half the turn lies between the chord and the tangents at both ends
    s = max(-1.0, min(1.0, 0.5 * k * c))
    co = math.sqrt(1.0 - s * s)
    P[i, 5], P[i, 6] = -(ey * co - ex * s), ex * co + ey * s
    P[i, 7], P[i, 8] = -(ey * co + ex * s), ex * co - ey * s


@bare_kernel
def distance(P: FloatArray, i: int, x: float, y: float) -> float:
    """Give how far a point is from a piece."""
    qx, qy = x - P[i, 0], y - P[i, 1]
    ahead = qx * P[i, 6] - qy * P[i, 5]
    if ahead <= 0.0:
        return math.sqrt(qx * qx + qy * qy)
    rx, ry = x - P[i, 2], y - P[i, 3]
    if rx * P[i, 8] - ry * P[i, 7] >= 0.0:
        return math.sqrt(rx * rx + ry * ry)
    k = P[i, 4]
    g = qx * P[i, 5] + qy * P[i, 6] - 0.5 * k * (qx * qx + qy * qy)
    # (1 - w) / k with w = sqrt(1 - 2 k g), the distance from the centre in radii, without its
    # cancellation where the arc is nearly straight, nor that of w near the centre
    wx, wy = k * qx - P[i, 5], k * qy - P[i, 6]
    far: float = abs(2.0 * g / (1.0 + math.sqrt(wx * wx + wy * wy)))
    return far


@bare_kernel
def share(P: FloatArray, i: int, x: float, y: float) -> float:
    """Give the share of the chord at the foot of a point."""
    ex, ey = P[i, 2] - P[i, 0], P[i, 3] - P[i, 1]
    c2 = ex * ex + ey * ey
    if c2 <= 0.0:
        return 0.0
    u: float = ((x - P[i, 0]) * ex + (y - P[i, 1]) * ey) / c2
    return u


@bare_kernel
def at_share(P: FloatArray, i: int, u: float) -> tuple[float, float]:
    """Give the point of a piece over a share of its chord."""
    ax, ay = P[i, 0], P[i, 1]
    ex, ey = P[i, 2] - ax, P[i, 3] - ay
    px, py = u * ex, u * ey
    k = P[i, 4]
    if k == 0.0:
        return ax + px, ay + py
    c = math.sqrt(ex * ex + ey * ey)
    if c <= 0.0:
        return ax, ay
    lx, ly = -ey / c, ex / c
    # g(a + p + w l) = 0 for the height w over the chord, by the root that is near 0
    b = P[i, 5] * lx + P[i, 6] * ly
    g = P[i, 5] * px + P[i, 6] * py - 0.5 * k * (px * px + py * py)
    w = -2.0 * g / (b + math.sqrt(max(0.0, b * b + 2.0 * k * g)))
    return ax + px + w * lx, ay + py + w * ly


@bare_kernel
def box_of(P: FloatArray, i: int) -> tuple[float, float, float, float]:
    """Give the box about a piece: least x and y, largest x and y."""
    ax, ay, bx, by, k = P[i, 0], P[i, 1], P[i, 2], P[i, 3], P[i, 4]
    x0, x1 = min(ax, bx), max(ax, bx)
    y0, y1 = min(ay, by), max(ay, by)
    if k != 0.0:
        # the tangents at both ends meet in the third corner of a triangle about the arc
        ex, ey = bx - ax, by - ay
        c2 = ex * ex + ey * ey
        s = 0.5 * k * math.sqrt(c2)
        h = 0.5 * s / math.sqrt(max(0.25, 1.0 - s * s))
        mx, my = 0.5 * (ax + bx) + h * ey, 0.5 * (ay + by) - h * ex
        x0, x1, y0, y1 = min(x0, mx), max(x1, mx), min(y0, my), max(y1, my)
    return x0, y0, x1, y1


@bare_kernel
def circles_meet(
    P: FloatArray, i: int, Q: FloatArray, j: int
) -> tuple[int, float, float, float, float]:
    """Give where the circles (or lines) of two pieces meet: how often, and the points."""
    if abs(P[i, 4]) < abs(Q[j, 4]):
        P, i, Q, j = Q, j, P, i
    ox, oy, k1, k2 = P[i, 0], P[i, 1], P[i, 4], Q[j, 4]
    nx, ny = P[i, 5], P[i, 6]
    ex, ey = Q[j, 0] - ox, Q[j, 1] - oy
    mx, my = Q[j, 5] + k2 * ex, Q[j, 6] + k2 * ey
    c = -(Q[j, 5] * ex + Q[j, 6] * ey) - 0.5 * k2 * (ex * ex + ey * ey)
    # of both equations the one without squares: the line through both points
    r = k2 / k1 if k1 != 0.0 else 0.0
    gx, gy = mx - r * nx, my - r * ny
    g2 = gx * gx + gy * gy
    if g2 < _PARALLEL * _PARALLEL:
        return 0, 0.0, 0.0, 0.0, 0.0
    x0, y0 = -c * gx / g2, -c * gy / g2
    g = math.sqrt(g2)
    wx, wy = -gy / g, gx / g
    b = nx * wx + ny * wy
    f = nx * x0 + ny * y0 - 0.5 * k1 * (x0 * x0 + y0 * y0)
    root = b * b + 2.0 * k1 * f
    if root < 0.0:
        return 0, 0.0, 0.0, 0.0, 0.0
    q = b + math.copysign(math.sqrt(root), b)
    if abs(q) < _PARALLEL:
        return 0, 0.0, 0.0, 0.0, 0.0
    s = -2.0 * f / q
    ux, uy = x0 + s * wx, y0 + s * wy
    if k1 == 0.0:
        return 1, ox + ux, oy + uy, 0.0, 0.0
    s = q / k1
    return 2, ox + ux, oy + uy, ox + x0 + s * wx, oy + y0 + s * wy


@bare_kernel
def disc_cuts(P: FloatArray, i: int, x: float, y: float, radius: float) -> tuple[int, float, float]:
    """Give where the edge of a disc cuts a piece: how often, and the shares, rising."""
    ax, ay, k = P[i, 0], P[i, 1], P[i, 4]
    wx, wy = x - ax, y - ay
    gx, gy = P[i, 5] - k * wx, P[i, 6] - k * wy
    g2 = gx * gx + gy * gy
    if g2 <= _PARALLEL * _PARALLEL:
        return 0, 0.0, 0.0
    g = math.sqrt(g2)
    off = (gx * wx + gy * wy + 0.5 * k * (wx * wx + wy * wy - radius * radius)) / g
    half = radius * radius - off * off
    if half <= 0.0:
        return 0, 0.0, 0.0
    half = math.sqrt(half)
    mx, my = wx - off * gx / g, wy - off * gy / g
    count, first, second = 0, 0.0, 0.0
    for sign in (-1.0, 1.0):
        px, py = mx - sign * half * gy / g, my + sign * half * gx / g
        # ahead of the normal at the start and behind the one at the end
        if px * P[i, 6] - py * P[i, 5] >= 0.0:
            sx, sy = px + ax - P[i, 2], py + ay - P[i, 3]
            if sx * P[i, 8] - sy * P[i, 7] <= 0.0:
                u = share(P, i, px + ax, py + ay)
                if count == 0:
                    first = u
                else:
                    second = u
                count += 1
    if count == 2 and second < first:
        first, second = second, first
    return count, first, second
