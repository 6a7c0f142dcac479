"""The way back of a joint that starts outside of its limits.

Units are those of ``extremal_kernel``: the limits of acceleration and jerk are 1, ``top`` is that
of velocity. A start is inside if acceleration and velocity are, and the velocity stays inside when
the acceleration is taken to zero at once. From outside, the jerk is full until the limit that is
broken holds again, and not longer than the limit on the other side can still be kept.
"""

import math

from splinearm.compiled import kernel


@kernel
def brake_of(v: float, a: float, top: float) -> tuple[float, float, float]:
    """Give (t0, jerk, t1): so long with this jerk, then so long with none; zeros where inside."""
    at_rest = v + 0.5 * a * abs(a)
    if a > 1.0:
        t0, t1 = _ease(v, a, top)
        return t0, -1.0, t1
    if a < -1.0:
        t0, t1 = _ease(-v, -a, top)
        return t0, 1.0, t1
    if (v > top and v - 0.5 * a * a > -top) or (a > 0.0 and at_rest > top):
        t0, t1 = _fall(v, a, top)
        return t0, -1.0, t1
    if (v < -top and v + 0.5 * a * a < top) or (a < 0.0 and at_rest < -top):
        t0, t1 = _fall(-v, -a, top)
        return t0, 1.0, t1
    return 0.0, 0.0, 0.0


@kernel
def _ease(v: float, a: float, top: float) -> tuple[float, float]:
    """Take an acceleration above its limit back to it, and on until the velocity is inside."""
    if v + 0.5 * a * a > top:
        return _fall(v, a, top)
    t0 = a - 1.0
    v += 0.5 * (a * a - 1.0)
    if v < -top:
        return t0, max(min(-top - v, top - 0.5 - v), 0.0)
    return t0, 0.0


@kernel
def _fall(v: float, a: float, top: float) -> tuple[float, float]:
    """Take a velocity that is, or comes, above its limit back to it."""
    inside = a + math.sqrt(max(a * a + 2.0 * (v - top), 0.0))
    last = a + math.sqrt(max(0.5 * a * a + v + top, 0.0))
    t0 = min(inside, last)
    if t0 <= a + 1.0:
        return t0, 0.0
    t0 = a + 1.0
    v += a * t0 - 0.5 * t0 * t0
    return t0, max(min(v - top, v + top - 0.5), 0.0)
