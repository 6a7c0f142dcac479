"""Motions of the joints from state to state, of constant jerk from phase to phase."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from math import inf
from typing import Any

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import LimitError
from splinearm.joints import JointKind, JointLimits, JointSetpoint


@cache
def _kernels() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Give the kernels that sample and that tell the range, compiled for their arguments."""
    from splinearm.compiled import entry, inputs, outputs

    from . import profile_kernel

    return (
        entry(profile_kernel.sample_into, *inputs(3, 1), *outputs(3)),
        entry(profile_kernel.range_into, *inputs(3), *outputs(2)),
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PositionRange:
    """How far each joint goes in a motion, exactly."""

    q_low: FloatArray
    """Lowest position, shape (n,), rad or m."""
    t_low: FloatArray
    """When it is first reached, shape (n,), s."""
    q_high: FloatArray
    """Highest position, shape (n,), rad or m."""
    t_high: FloatArray
    """When it is first reached, shape (n,), s."""


@dataclass(frozen=True, slots=True, eq=False)
class JointProfile:
    """A motion of the joints from one state to another, phase by phase in closed form.

    ``point_to_point`` and ``through`` make them. Where the limits hold one of jerk, position,
    velocity and acceleration are continuous; where they do not, the acceleration jumps.
    """

    limits: JointLimits
    """What the joints may do."""
    phases: FloatArray
    """Time, position, velocity, acceleration and jerk at the begin of each phase of each joint,
    shape (n, m, 5). The last one begins where the motion ends and stands for its end."""
    duration: float = field(init=False)
    """How long the motion takes, s."""

    def __post_init__(self) -> None:
        phases = frozen_array(self.phases, (self.limits.n, None, 5), "phases")
        times = phases[:, :, 0]
        falls = times[:, 1:] < times[:, :-1]
        if phases.shape[1] == 0 or times[:, 0].any() or falls.any():
            raise ValueError("phases: want times that begin at 0 and do not fall")
        if (times[:, -1] != times[0, -1]).any():
            raise ValueError("phases: want joints that all end at the same time")
        object.__setattr__(self, "phases", phases)
        object.__setattr__(self, "duration", float(times[0, -1]))

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.limits.n

    @property
    def q_start(self) -> FloatArray:
        """Where it starts, shape (n,), rad or m."""
        return self.phases[:, 0, 1]

    @property
    def q_goal(self) -> FloatArray:
        """Where it ends, shape (n,), rad or m."""
        return self.phases[:, -1, 1]

    def at(self, t: float) -> JointSetpoint:
        """Give the setpoint at a time.

        Before the start and after the end the motion holds its ends: velocity and acceleration are
        zero there.

        Args:
            t: Time since the start, s.

        Raises:
            ValueError: If t is not a finite number.
        """
        if not -inf < t < inf:
            raise ValueError(f"t: want a finite time, got {t}")
        q, qd, qdd, _ = self._values(np.array([float(t)]))
        return JointSetpoint(t=t, q=q[0], qd=qd[0], qdd=qdd[0])

    def sample(self, ts: ArrayInput) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give position, velocity and acceleration at many times, each of shape (m, n).

        Args:
            ts: Times, shape (m,), s; as for ``at``.

        Raises:
            ValueError: If a time is not a finite number.
        """
        q, qd, qdd, _ = self._values(frozen_array(ts, (None,), "ts"))
        return q, qd, qdd

    def jerk(self, ts: ArrayInput) -> FloatArray:
        """Give the jerk at many times, shape (m, n), rad/s3 or m/s3; where it jumps, from ahead.

        Args:
            ts: Times, shape (m,), s; as for ``at``.

        Raises:
            ValueError: If a time is not a finite number.
        """
        qddd: FloatArray = self._values(frozen_array(ts, (None,), "ts"))[3]
        return qddd

    def nodes(self) -> FloatArray:
        """Give the times between which the motion is smooth, rising, from 0 to the duration."""
        return np.unique(self.phases[:, :, 0])

    def position_range(self) -> PositionRange:
        """Give the lowest and highest position of each joint and when it is there."""
        out = np.empty((self.n, 4))
        _kernels()[1](self.phases, out)
        low, t_low, high, t_high = (frozen_array(column, (self.n,), "range") for column in out.T)
        return PositionRange(q_low=low, t_low=t_low, q_high=high, t_high=t_high)

    def check_positions(self, tolerance: float = 1e-9) -> None:
        """Pass a motion that stays within the position limits all the way.

        Args:
            tolerance: How far beyond a limit rounding may carry a joint, rad or m.

        Raises:
            LimitError: With the joint, how far it goes, its limit and when.
        """
        out = np.empty((self.n, 4))
        _kernels()[1](self.phases, out)
        limits = self.limits
        for column, limit, beyond in (
            (0, limits.q_min, limits.q_min - out[:, 0]),
            (2, limits.q_max, out[:, 2] - limits.q_max),
        ):
            if (beyond > tolerance).any():
                i = int(np.argmax(beyond))
                raise LimitError(
                    limits.names[i],
                    "position",
                    float(out[i, column]),
                    float(limit[i]),
                    float(out[i, column + 1]),
                    linear=limits.kinds[i] is JointKind.PRISMATIC,
                )

    def scaled(self, share: float) -> "JointProfile":
        """Give the same motion at ``share`` of its speed.

        Raises:
            ValueError: If the share is not above 0 and at most 1.
        """
        if not 0.0 < share <= 1.0:
            raise ValueError(f"share: want above 0 and at most 1, got {share}")
        factors = [1.0 / share, 1.0, share, share**2, share**3]
        return JointProfile(self.limits, self.phases * factors)

    def reversed(self) -> "JointProfile":
        """Give the motion backwards in time."""
        phases = np.empty_like(self.phases)
        phases[:, :, 0] = self.duration - self.phases[:, ::-1, 0]
        phases[:, :, 1:4] = self.phases[:, ::-1, 1:4] * [1.0, -1.0, 1.0]
        # a phase now begins where it ended: the jerk is that of the one before, and so is the
        # acceleration where it jumps
        ends = self.phases[:, :-1, 3] + self.phases[:, :-1, 4] * np.diff(self.phases[:, :, 0])
        phases[:, :-1, 3] = ends[:, ::-1]
        phases[:, :-1, 4] = -self.phases[:, -2::-1, 4]
        phases[:, -1, 4] = 0.0
        return JointProfile(self.limits, phases)

    def _values(self, ts: FloatArray) -> FloatArray:
        """Give position, velocity, acceleration and jerk, shape (4, m, n)."""
        out = np.empty((4, len(ts), self.n))
        _kernels()[0](self.phases, np.minimum(np.maximum(ts, 0.0), self.duration), out)
        out[1:, (ts < 0.0) | (ts > self.duration)] = 0.0
        return out
