"""A motion as one curve by time, within a tolerance."""

from typing import TYPE_CHECKING

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.hermite import cubic_spline, cubic_values
from splinearm.errors import CurveError

if TYPE_CHECKING:
    from .trajectory import JointTrajectory

_SHARES = 4
"""Into so many parts each smooth stretch of the motion is cut at first."""

_EVEN = 100
"""So many stretches of equal time are cut out of the motion besides."""

_DOUBLINGS = 5
"""How often these are halved if they are too long."""


def fit(trajectory: "JointTrajectory", tolerance: float) -> BSpline:
    """Give the joints as a cubic B-spline of the time, C1, with long pieces.

    Each piece has the motion's positions and velocities at its ends and reaches as far as the
    tolerance allows at the places that are looked at: eight in every smooth stretch of the motion.

    Args:
        trajectory: The motion.
        tolerance: How far a joint may be off, rad or m.

    Raises:
        CurveError: If the motion takes no time, or rounding is above the tolerance.
        ValueError: If the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance: want a number above 0, got {tolerance}")
    if trajectory.duration <= 0.0:
        raise CurveError("it takes no time, so it is no curve by time", "motion")
    even = np.linspace(0.0, trajectory.duration, _EVEN + 1)
    nodes = np.union1d(trajectory.nodes(), even)
    for doubling in range(_DOUBLINGS + 1):
        t = _between(nodes, _SHARES << doubling)
        t[-1] = np.nextafter(t[-1], 0.0)  # the end as it is reached, not as it is held
        q, qd, _ = trajectory.sample(t)
        t[-1] = nodes[-1]
        q[-1] = trajectory.q_goal
        chosen = _long_pieces(t, q, qd, tolerance)
        if chosen is not None:
            return cubic_spline(t[chosen], q[chosen], qd[chosen])
    raise CurveError(f"no cubic by time stays within {tolerance:g}; allow more", "motion")


def _between(nodes: FloatArray, count: int) -> FloatArray:
    """Give the nodes and ``count`` - 1 times between each two."""
    share = np.arange(count) / count
    inner = nodes[:-1, None] + np.diff(nodes)[:, None] * share
    return np.append(inner.ravel(), nodes[-1])


def _long_pieces(
    t: FloatArray, q: FloatArray, qd: FloatArray, tolerance: float
) -> IndexArray | None:
    """Give which times end pieces, each two or more steps long; None if one would be too long."""
    chosen, begin, last = [0], 0, len(t) - 1
    reach = 2
    while begin < last:
        if not _fits(t, q, qd, (begin, min(begin + 2, last)), tolerance):
            return None
        # as far again as the piece before, then further, then back by halves
        while begin + reach < last and _fits(t, q, qd, (begin, begin + reach), tolerance):
            reach *= 2
        low, high = 2, min(reach, last - begin)
        if _fits(t, q, qd, (begin, begin + high), tolerance):
            low = high
        while high - low > 1:
            middle = (low + high) // 2
            if _fits(t, q, qd, (begin, begin + middle), tolerance):
                low = middle
            else:
                high = middle
        begin = min(begin + low, last)
        reach = max(low, 2)
        chosen.append(begin)
    return np.array(chosen)


def _fits(
    t: FloatArray, q: FloatArray, qd: FloatArray, piece: tuple[int, int], tolerance: float
) -> bool:
    """Tell whether a cubic with the values and rates of its ends is near all values between."""
    i, j = piece
    ends = np.array([i, j])
    values = cubic_values(t[ends], q[ends], qd[ends], t[i + 1 : j])
    return bool((np.abs(values - q[i + 1 : j]) <= tolerance).all())
