"""What every setpoint of a jogged arm must keep, looked at until the arm would rest again."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics.arm import Arm

from .hindrance import Broken

PAST = 3
"""Setpoints that were sent and that the next must continue."""
_ROUNDING = 1e-9
_SHARE = 0.999
"""Share of the limits of acceleration and jerk that is used: the guard counts on its own."""
_TOOL_SHARE = 0.997
"""Share of the tool's speed that is used: where joints turn quickly the tool is faster between two
setpoints than on the straight way from one to the other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Breach:
    """A bound that setpoints break, and the joint that does."""

    broken: Broken
    """Which bound."""
    joint: int = 0
    """Number of the joint."""
    upper: bool = False
    """Whether it goes beyond its upper side."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Bounds:
    """What setpoints must keep."""

    arm: Arm
    """The arm, with its limits."""
    speeds: FloatArray
    """How fast its joints may be in jogging, shape (n,), rad/s or m/s."""
    tool_speed: float
    """How fast the tool may be, m/s."""
    period: float
    """Time between setpoints, s."""

    def breach(self, rows: FloatArray) -> Breach | None:
        """Give the first bound that setpoints break, or None.

        Args:
            rows: The last three setpoints that were sent, then those to come, shape (m, n).
        """
        limits, dt = self.arm.limits, self.period
        for outside, upper in (
            (rows[PAST:] < limits.q_min - _ROUNDING, False),
            (rows[PAST:] > limits.q_max + _ROUNDING, True),
        ):
            if outside.any():
                joint = int(np.argmax(outside.any(axis=0)))
                return Breach(broken=Broken.POSITION, joint=joint, upper=upper)
        steps = np.diff(rows, axis=0)
        for broken, rates, limit in (
            (Broken.VELOCITY, steps[PAST - 1 :] / dt, self.speeds * (1.0 + _ROUNDING)),
            (Broken.ACCELERATION, np.diff(steps[1:], axis=0) / dt**2, _SHARE * limits.qdd_max),
            (Broken.JERK, np.diff(steps, n=2, axis=0) / dt**3, self._jerk),
        ):
            used = (np.abs(rates) / limit).max(axis=0)
            if used.max() > 1.0:
                return Breach(broken=broken, joint=int(np.argmax(used)))
        return Breach(broken=Broken.TOOL) if self.haste(rows) > 1.0 else None

    @property
    def _jerk(self) -> FloatArray:
        jerk = self.arm.limits.qddd_max
        return np.full(self.arm.n, np.inf) if jerk is None else _SHARE * jerk

    def haste(self, rows: FloatArray) -> float:
        """Give how fast the tool is at its fastest, as a share of what is used.

        Between two setpoints its mean speed counts, and at each what the Jacobian says.
        """
        q = rows[PAST - 1 :]
        p = self.arm.fk(q)[:, :3, 3]
        chords = np.diff(p, axis=0) / self.period
        qd = (q[2:] - q[:-2]) / (2.0 * self.period)
        at = (self.arm.jacobian(q[1:-1])[:, :3] @ qd[:, :, None])[:, :, 0]
        fastest = max(float((v * v).sum(axis=1).max()) for v in (chords, at))
        return float(np.sqrt(fastest)) / (_TOOL_SHARE * self.tool_speed)
