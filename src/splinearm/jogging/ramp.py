"""How a wish becomes a motion: by and by, with bounded acceleration and jerk, in a fixed time."""

from dataclasses import dataclass
from math import ceil
from typing import Self

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits

_SHORTEST = 0.15
"""Velocity takes at least this time to come and to go, s: below, gearboxes feel it."""
_SOFT = 0.5
"""Acceleration takes this share of that time to come and to go, where jerk has no limit."""
_FULL = 0.9
"""Share of the limits that a motion from rest to its full speed uses."""
COMMITTED = 2
"""Setpoints that no later wish changes: the next one and, for its derivatives, that after it."""
_AFTER = 3
"""Setpoints at rest in the end, so that the end of the last acceleration is looked at as well."""


@dataclass(frozen=True, slots=True, eq=False)
class Ramp:
    """Two moving averages, one after the other: what is wished in a cycle comes through them.

    Velocities are means of what was wished, so that they are never beyond it; acceleration changes
    at a bounded rate; and ``duration`` after the last wish the arm rests (Biagiotti and Melchiorri,
    Trajectory Planning for Automatic Machines and Robots, 2008, section 4.5).
    """

    period: float
    """Time between setpoints, s."""
    weights: FloatArray
    """Of a way that is wished in one cycle the share that is gone at each setpoint to come, shape
    (m,), from 0 to 1."""

    @classmethod
    def of(cls, limits: JointLimits, speeds: FloatArray, period: float) -> Self:
        """Give the ramp in which joints come from rest to some speeds, within their limits.

        Args:
            limits: What the joints may do.
            speeds: The speeds, shape (n,), rad/s or m/s.
            period: Time between setpoints, s.
        """
        rise = max(_SHORTEST, float((speeds / (_FULL * limits.qdd_max)).max()))
        bend = _SOFT * rise
        if limits.qddd_max is not None:
            bend = max(bend, float((speeds / (_FULL * limits.qddd_max * rise)).max()))
        long, short = (max(1, ceil(time / period - 1e-9)) for time in (rise, bend))
        shares = np.convolve(np.full(long, 1.0 / long), np.full(short, 1.0 / short))
        whole = np.cumsum(shares)
        whole[-1] = 1.0
        return cls(period, np.concatenate((np.zeros(COMMITTED), whole, np.ones(_AFTER))))

    @property
    def duration(self) -> float:
        """Within what time the arm rests after the last cycle with a wish, s."""
        return (self.weights.size - _AFTER) * self.period
