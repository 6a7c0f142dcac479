"""The angle of a direction, written out, so that loops over it become vector code."""

import math

from splinearm.compiled import kernel

_HALF = 0.5 * math.pi
_QUARTER = 0.25 * math.pi
_QUARTER_REST = 3.061616997868383e-17
"""What pi / 4 lacks as a double."""


@kernel
def arctan2(y: float, x: float) -> float:
    """Give the angle of the direction (x, y), rad; it must have a length.

    S. Moshier, Cephes mathematical library 2.8, 2000, atan.c: the ratio of two polynomials up to
    0.66, beyond it by the angle from 45 degrees.
    """
    ax, ay = abs(x), abs(y)
    low, high = min(ax, ay), max(ax, ay)
    steep = low > 0.66 * high
    top = low - high if steep else low
    bottom = low + high if steep else high
    r = top / bottom
    z = r * r
    p = -8.750608600031904122785e-1 * z - 1.615753718733365076637e1
    p = p * z - 7.500855792314704667340e1
    p = p * z - 1.228866684490136173410e2
    p = p * z - 6.485021904942025371773e1
    q = z + 2.485846490142306297962e1
    q = q * z + 1.650270098316988542046e2
    q = q * z + 4.328810604912902668951e2
    q = q * z + 4.853903996359136964868e2
    q = q * z + 1.945506571482613964425e2
    angle = r * (z * p / q) + r
    angle = _QUARTER + (angle + _QUARTER_REST) if steep else angle
    angle = _HALF - angle if ay > ax else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle
