"""The general base of a spherical wrist: a quartic in the third joint.

D. Pieper, 1968; here as a trigonometric polynomial of second degree, whose roots are those of a
quartic on the unit circle of the complex plane.
"""

import cmath
import math
from typing import TypeAlias

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .subproblem_kernel import turn

ComplexArray: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]

_OFF_CIRCLE = 1e-4
_STEPS = 8
_TURNS = 60
_SAME = 1e-7


@kernel
def trig_roots(f0: float, a1: float, b1: float, a2: float, b2: float, out: FloatArray) -> int:
    """Give the angles where f0 + a1 cos + b1 sin + a2 cos(2 x) + b2 sin(2 x) is zero, at most 4."""
    top = max(abs(f0), abs(a1), abs(b1), abs(a2), abs(b2))
    if top == 0.0:
        return 0
    # times z^2, with z = exp(i x): a quartic that reads the same from both ends
    poly = np.empty(5, dtype=np.complex128)
    poly[0] = 0.5 * complex(a2, -b2)
    poly[1] = 0.5 * complex(a1, -b1)
    poly[2] = f0
    poly[3] = 0.5 * complex(a1, b1)
    poly[4] = 0.5 * complex(a2, b2)
    # the roots of a quartic whose ends vanish lie elsewhere than on the circle
    start = 0
    while start < 2 and abs(poly[start]) < 1e-13 * top:
        start += 1
    if start == 2:
        return 0
    roots, found = np.empty(4, dtype=np.complex128), 0
    for i in range(_roots(poly, start, roots)):
        z = roots[i]
        if abs(abs(z) - 1.0) > _OFF_CIRCLE:
            continue
        x = cmath.phase(z)
        for _ in range(_STEPS):
            value = f0 + a1 * math.cos(x) + b1 * math.sin(x)
            value += a2 * math.cos(2.0 * x) + b2 * math.sin(2.0 * x)
            slope = b1 * math.cos(x) - a1 * math.sin(x)
            slope += 2.0 * (b2 * math.cos(2.0 * x) - a2 * math.sin(2.0 * x))
            if abs(slope) < 1e-9 * top or abs(value) > abs(slope):
                break
            x -= value / slope
        new = True
        for k in range(found):
            if abs(math.sin(0.5 * (x - out[k]))) < _SAME:
                new = False
        if new:
            out[found] = x
            found += 1
    return found


@kernel
def _roots(poly: ComplexArray, start: int, roots: ComplexArray) -> int:
    """Give all roots of a complex polynomial at once, its powers falling; and their number.

    E. Durand, 1960, and I. Kerner, 1966, with O. Aberth's step, 1973.
    """
    degree = 4 - 2 * start
    for i in range(degree):
        # on no symmetry of roots that lie on the circle or in pairs across it
        roots[i] = 1.1 * cmath.exp(complex(0.0, 2.0 * math.pi * i / degree + 0.4))
    for _ in range(_TURNS):
        most = 0.0
        for i in range(degree):
            z = roots[i]
            value, slope = poly[start], 0.0 * poly[start]
            for k in range(start + 1, start + degree + 1):
                slope = slope * z + value
                value = value * z + poly[k]
            if value == 0.0:
                continue
            others = 0.0 * value
            for j in range(degree):
                if j != i and roots[j] != z:
                    others += 1.0 / (z - roots[j])
            bottom = slope - value * others
            if bottom == 0.0:
                continue
            step = value / bottom
            roots[i] = z - step
            most = max(most, abs(step) / (1.0 + abs(z)))
        if most < 1e-15:
            break
    return degree


@kernel
def pieper(
    P: FloatArray,
    wx: float,
    wy: float,
    wz: float,
    T: FloatArray,
    seed: FloatArray,
    out: FloatArray,
) -> int:
    """Put the point w that the third joint turns on the origin of ``T``: rows of three joints."""
    a0, d0, ca0, sa0 = P[0, 0], P[0, 1], P[0, 2], P[0, 3]
    a1, d1, ca1, sa1 = P[1, 0], P[1, 1], P[1, 2], P[1, 3]
    ux, uy, uz = T[0, 3], T[1, 3], T[2, 3] - d0
    r2 = ux * ux + uy * uy + uz * uz
    size = abs(a0) + abs(a1) + abs(d1) + math.sqrt(wx * wx + wy * wy) + abs(wz)
    # x = (a1, 0, d1) + Rx(alpha1) Rz(2) w: its square and its height are linear in cos and sin
    h0, hc, hs = d1 + ca1 * wz, sa1 * wy, sa1 * wx
    e0 = a1 * a1 + d1 * d1 + wx * wx + wy * wy + wz * wz + 2.0 * d1 * ca1 * wz
    ec, es = 2.0 * (a1 * wx + d1 * sa1 * wy), 2.0 * (d1 * sa1 * wx - a1 * wy)
    # in the frame before joint 1, v = Rz(1) x: its x from the distance, its y from the height
    k0, kc, ks = (r2 - a0 * a0 - e0) / (2.0 * a0), -ec / (2.0 * a0), -es / (2.0 * a0)
    l0, lc, ls = (uz - ca0 * h0) / sa0, -ca0 * hc / sa0, -ca0 * hs / sa0
    # k^2 + l^2 + h^2 = x^2, in harmonics
    f0 = k0 * k0 + l0 * l0 + h0 * h0 - e0
    f0 += 0.5 * (kc * kc + lc * lc + hc * hc + ks * ks + ls * ls + hs * hs)
    f1c = 2.0 * (k0 * kc + l0 * lc + h0 * hc) - ec
    f1s = 2.0 * (k0 * ks + l0 * ls + h0 * hs) - es
    f2c = 0.5 * (kc * kc + lc * lc + hc * hc - ks * ks - ls * ls - hs * hs)
    f2s = kc * ks + lc * ls + hc * hs
    roots = np.empty(4)
    n = trig_roots(f0, f1c, f1s, f2c, f2s, roots)
    for i in range(n):
        c2, s2 = math.cos(roots[i]), math.sin(roots[i])
        zx, zy = c2 * wx - s2 * wy, s2 * wx + c2 * wy
        x, y, z = a1 + zx, ca1 * zy - sa1 * wz, d1 + sa1 * zy + ca1 * wz
        vx, vy = k0 + kc * c2 + ks * s2, l0 + lc * c2 + ls * s2
        c1, s1 = turn(x, y, vx, vy, size, seed[1])
        vx, vy = c1 * x - s1 * y, s1 * x + c1 * y
        c0, s0 = turn(a0 + vx, ca0 * vy - sa0 * z, ux, uy, size, seed[0])
        row = out[i]
        row[0], row[1], row[2], row[3], row[4], row[5] = c0, s0, c1, s1, c2, s2
        row[12] = 2 * i
    return n
