"""Motion whose acceleration grows evenly with the way: f'' = c f + a."""

from math import cos, cosh, sin, sinh, sqrt

_SMALL = 1e-2
"""Within this of zero c t^2 is small enough for a few terms of a series."""


def circular(c: float, t: float) -> tuple[float, float, float]:
    """Give the even, the odd and the next even solution of f'' = c f: cosh, sinh, (cosh - 1) / c.

    They begin with 1, t and t^2 / 2 and are right to rounding for every c, whose cosines and sines
    are circular where it is below zero. Starting with speed v and acceleration a, f' is
    v cosh + a sinh, and f is v sinh + a (cosh - 1) / c.
    """
    z = c * t * t
    if -_SMALL < z < _SMALL:
        even = 1.0 + z * (1 / 2 + z * (1 / 24 + z * (1 / 720 + z * (1 / 40320))))
        odd = 1.0 + z * (1 / 6 + z * (1 / 120 + z * (1 / 5040 + z * (1 / 362880))))
        next_even = 1 / 2 + z * (1 / 24 + z * (1 / 720 + z * (1 / 40320 + z * (1 / 3628800))))
        return even, t * odd, t * t * next_even
    k = sqrt(abs(c))
    if c > 0.0:
        half = sinh(0.5 * k * t) / k
        return cosh(k * t), sinh(k * t) / k, 2.0 * half * half
    half = sin(0.5 * k * t) / k
    return cos(k * t), sin(k * t) / k, 2.0 * half * half
