"""Sine and cosine written out, so that a loop over many angles becomes vector instructions."""

import math

import numpy as np

from splinearm.compiled import fast_kernel

LARGEST = 1e5
"""Largest angle, rad, that `sincos` takes: beyond it the argument reduction loses digits."""

# pi / 2 in three parts; a multiple of the first two by any whole number below 2**20 is exact
# (Cody and Waite, Software Manual for the Elementary Functions, 1980)
_HALF_PI_1 = 1.5707963267341256
_HALF_PI_2 = 6.077100506303966e-11
_HALF_PI_3 = 2.0222662487959506e-21


@fast_kernel
def sincos(x: float) -> tuple[float, float]:
    """Give sine and cosine of an angle of at most `LARGEST`, each to within 3e-16.

    The polynomials are those of fdlibm (Sun Microsystems, 1993, k_sin.c and k_cos.c).
    """
    k = np.floor(x * 0.6366197723675814 + 0.5)
    r = ((x - k * _HALF_PI_1) - k * _HALF_PI_2) - k * _HALF_PI_3
    z = r * r
    s = 2.75573137070700676789e-06 + z * (
        -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10
    )
    s = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * s)
    s = r + r * z * (-1.66666666666666324348e-01 + z * s)
    c = -2.75573143513906633035e-07 + z * (
        2.08757232129817482790e-09 - z * 1.13596475577881948265e-11
    )
    c = 4.16666666666666019037e-02 + z * (
        -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * c)
    )
    c = 1.0 - (0.5 * z - z * z * c)
    half = np.floor(k * 0.5)
    odd = k - 2.0 * half > 0.5
    turned = half - 2.0 * np.floor(half * 0.5) > 0.5
    sine = c if odd else s
    cosine = -s if odd else c
    return (-sine if turned else sine), (-cosine if turned else cosine)


@fast_kernel
def sine_and_cosine(x: float) -> tuple[float, float]:
    """Give sine and cosine of any angle: `sincos` where that is exact, which is faster."""
    if abs(x) < LARGEST:
        return sincos(x)
    return math.sin(x), math.cos(x)
