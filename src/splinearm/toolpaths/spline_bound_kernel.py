"""Distances between curves as polynomials that are bounded, compiled.

Curves are segments as in ``spline_jet_kernel``. With ``H = C(t) w(u) - R(u) W(t)``, the difference
of two of them times both weights, a distance is kept where the polynomial

    G(t, u) = |H|^2 - d^2 (W w)^2

is nowhere negative. Boxes of t and u are halved until each is clear, which it is where its parts
are too far apart for their sizes, or along a cubic u = f(t) near the feet: with v = u - f(t),

    G = g0(t) + g1(t) v + g2(t) v^2 + ... >= g0 - g1^2 / (4 b),    b <= g2 + g3 v + ...

All of these are polynomials of known degree N, and between its values at M Chebyshev points one
strays from them by no more than 1 / cos(pi N / (2 M)) (Ehlich and Zeller, Math. Z. 86 (1964) 41):
what is found at points holds in between.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

DENSE = 6
"""Points a degree."""
SPREAD = 1.0 / math.cos(0.5 * math.pi / DENSE)
"""How much farther than its values there a polynomial may go in between."""
BEYOND = 1.25
"""How far f may reach beyond its box."""
FEET = 4


@fast_kernel
def part_of(S: FloatArray, k: int, low: float, high: float, out: FloatArray) -> None:
    """Write the coefficients of a part of a segment, again from -1 to 1."""
    n = S.shape[1]
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    for j in range(n):
        for c in range(3):
            out[j, c] = S[k, j, c]
    for i in range(n - 1):
        for j in range(n - 2, i - 1, -1):
            for c in range(3):
                out[j, c] += middle * out[j + 1, c]
    grown = 1.0
    for j in range(n):
        for c in range(3):
            out[j, c] *= grown
        grown *= half


@fast_kernel
def sizes(a: FloatArray) -> tuple[float, float]:
    """Give how far place times weight and the weight of a part stray from the middle."""
    p, w = 0.0, 0.0
    for j in range(1, a.shape[0]):
        p += math.sqrt(a[j, 0] * a[j, 0] + a[j, 1] * a[j, 1])
        w += abs(a[j, 2])
    return p, w


@fast_kernel
def discs_of(S: FloatArray) -> FloatArray:
    """Give discs in which segments lie: centres and radii, shape (k, 3)."""
    found = np.empty((S.shape[0], 3))
    for k in range(S.shape[0]):
        w = S[k, 0, 2]
        x, y = S[k, 0, 0] / w, S[k, 0, 1] / w
        p, stray = 0.0, 0.0
        for j in range(1, S.shape[1]):
            p += math.hypot(S[k, j, 0] - x * S[k, j, 2], S[k, j, 1] - y * S[k, j, 2])
            stray += abs(S[k, j, 2])
        radius = p / (w - stray) if stray < w else math.inf
        found[k, 0], found[k, 1], found[k, 2] = x, y, radius * (1.0 + 1e-12) + 1e-14
    return found


@fast_kernel
def is_beyond(discs: FloatArray, k: int, x: float, y: float, reach: float) -> bool:
    """Say whether all of a segment's disc is farther from a point."""
    dx, dy, r = discs[k, 0] - x, discs[k, 1] - y, discs[k, 2] + reach
    beyond: bool = dx * dx + dy * dy > r * r
    return beyond


@fast_kernel
def coefficients(
    c: FloatArray, r: FloatArray, t: float, u: float, d: float
) -> tuple[float, float, float, float]:
    """Give the first four coefficients of G by powers of a step from u."""
    x, y, W = 0.0, 0.0, 0.0
    for j in range(c.shape[0] - 1, -1, -1):
        x, y, W = x * t + c[j, 0], y * t + c[j, 1], W * t + c[j, 2]
    px, py, w, qx, qy, v, zx, zy, z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ox, oy, o = 0.0, 0.0, 0.0
    for j in range(r.shape[0] - 1, -1, -1):
        ox, oy, o = ox * u + zx, oy * u + zy, o * u + z
        zx, zy, z = zx * u + qx, zy * u + qy, z * u + v
        qx, qy, v = qx * u + px, qy * u + py, v * u + w
        px, py, w = px * u + r[j, 0], py * u + r[j, 1], w * u + r[j, 2]
    hx, hy = x * w - px * W, y * w - py * W
    gx, gy = x * v - qx * W, y * v - qy * W
    fx, fy = x * z - zx * W, y * z - zy * W
    ex, ey = x * o - ox * W, y * o - oy * W
    s = d * d * W * W
    return (
        hx * hx + hy * hy - s * w * w,
        2.0 * (hx * gx + hy * gy - s * w * v),
        gx * gx + gy * gy + 2.0 * (hx * fx + hy * fy) - s * (v * v + 2.0 * w * z),
        2.0 * (gx * fx + gy * fy + hx * ex + hy * ey - s * (v * z + w * o)),
    )


@fast_kernel
def foot_of(c: FloatArray, r: FloatArray, t: float, u: float, d: float) -> float:
    """Give where along u G is least, about."""
    for _ in range(12):
        _, slope, bend, _ = coefficients(c, r, t, u, d)
        if bend <= 0.0:
            return math.copysign(9.0, -slope)
        step = 0.5 * slope / bend
        u = max(-3.0, min(3.0, u - step))
        if abs(step) < 1e-9:
            break
    return u


@fast_kernel
def feet(c: FloatArray, r: FloatArray, d: float, f: FloatArray) -> float:
    """Write the cubic through the feet at four points of t; give how far it reaches from 0."""
    u = 0.0
    v = np.empty(FEET)
    for i in range(FEET):
        u = foot_of(c, r, math.cos(math.pi * (i + 0.5) / FEET), u, d)
        v[i] = u
    reach = 0.0
    T = np.zeros(FEET)
    for k in range(FEET):
        for i in range(FEET):
            T[k] += v[i] * math.cos(math.pi * k * (i + 0.5) / FEET) * (0.5 if k else 0.25)
        reach += abs(T[k])
    # from the polynomials of Chebyshev to powers
    f[0], f[1], f[2], f[3] = T[0] - T[2], T[1] - 3.0 * T[3], 2.0 * T[2], 4.0 * T[3]
    return reach


@fast_kernel
def tail(c: FloatArray, r: FloatArray, d: float, reach: float) -> float:
    """Give what later coefficients of G may take from the one of the square, within a reach."""
    n = r.shape[0]
    cp, cw = sizes(c)
    W = c[0, 2] + cw
    total, outer = 0.0, 1.0
    # of H and of the weight times d W: how large their coefficients can be about any u
    H, V = np.zeros(n), np.zeros(n)
    for i in range(n):
        p, w = math.sqrt(r[i, 0] * r[i, 0] + r[i, 1] * r[i, 1]), abs(r[i, 2])
        grown = 1.0
        for j in range(i, -1, -1):
            # i over j, times a power of what lies beyond
            H[j] += grown * (p * W + w * cp)
            V[j] += grown * w * d * W
            grown *= BEYOND * j / (i - j + 1.0)
    for k in range(4, 2 * n - 1):
        outer = reach ** (k - 2)
        for i in range(max(0, k - n + 1), min(n, k + 1)):
            total += outer * (H[i] * H[k - i] + V[i] * V[k - i])
    return total


@fast_kernel
def along(
    c: FloatArray,
    r: FloatArray,
    f: FloatArray,
    d: float,
    degree: int,
    nodes: FloatArray,
    g: FloatArray,
) -> None:
    """Write the least and the most of the coefficients of G along f, bounded, shape (4, 2)."""
    count = DENSE * degree
    for k in range(4):
        g[k, 0], g[k, 1] = math.inf, -math.inf
    for i in range(count):
        t = nodes[i]
        a0, a1, a2, a3 = coefficients(c, r, t, ((f[3] * t + f[2]) * t + f[1]) * t + f[0], d)
        g[0, 0], g[0, 1] = min(g[0, 0], a0), max(g[0, 1], a0)
        g[1, 0], g[1, 1] = min(g[1, 0], a1), max(g[1, 1], a1)
        g[2, 0], g[2, 1] = min(g[2, 0], a2), max(g[2, 1], a2)
        g[3, 0], g[3, 1] = min(g[3, 0], a3), max(g[3, 1], a3)
    for k in range(4):
        middle, half = 0.5 * (g[k, 0] + g[k, 1]), 0.5 * SPREAD * (g[k, 1] - g[k, 0])
        g[k, 0], g[k, 1] = middle - half, middle + half


@fast_kernel
def nodes_of(degree: int) -> FloatArray:
    """Give the Chebyshev points for a polynomial of a degree."""
    count = DENSE * degree
    found = np.empty(count)
    for i in range(count):
        found[i] = math.cos(math.pi * (i + 0.5) / count)
    return found
