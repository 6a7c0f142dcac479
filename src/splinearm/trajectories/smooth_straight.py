"""The quickest law from rest to rest where speed, acceleration and jerk of s are bounded."""

from math import cbrt, sqrt

import numpy as np

from .smooth_law import SmoothLaw


def double_s(start: float, end: float, speed: float, acceleration: float, jerk: float) -> SmoothLaw:
    """Give the optimum: seven cells of constant jerk, or fewer.

    Args:
        start: First s.
        end: Last s, above the first.
        speed: Highest ds/dt.
        acceleration: Highest magnitude of d2s/dt2.
        jerk: Highest magnitude of d3s/dt3.
    """
    # Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008),
    # section 3.4, for ends at rest: the jerk lasts tj at a time, speeding up ta, cruising tv
    way = end - start
    tj = min(acceleration / jerk, sqrt(speed / jerk))
    ta = tj + speed / min(acceleration, jerk * tj)
    tv = way / speed - ta
    if tv < 0.0:
        tv = 0.0
        tj = min(acceleration / jerk, cbrt(0.5 * way / jerk))
        top = min(acceleration, jerk * tj)
        ta = 0.5 * (tj + sqrt(tj * tj + 4.0 * way / top))
    steady = max(ta - 2.0 * tj, 0.0)
    if steady < 1e-14 * ta:
        steady = 0.0
    law = SmoothLaw.of_jerks(
        start,
        jerk * np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0]),
        np.array([tj, steady, tj, tv, tj, steady, tj]),
    )
    return exact_end(law, end)


def exact_end(law: SmoothLaw, end: float) -> SmoothLaw:
    """Give the law with the end that rounding has moved put right: at rest at ``end``."""
    s, speed, acceleration = law.s.copy(), law.speed.copy(), law.acceleration.copy()
    s[-1], speed[-1], acceleration[-1] = end, 0.0, 0.0
    return SmoothLaw(
        s=s,
        t=law.t,
        speed=speed,
        acceleration=acceleration,
        jerks=law.jerks,
        growth=law.growth,
    )
