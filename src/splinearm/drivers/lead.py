"""Goals that are ahead of their setpoints, so that the joints are where the setpoints say."""

import logging

import numpy as np

from splinearm.arrays import FloatArray, frozen_array
from splinearm.errors import LimitError
from splinearm.joints import JointLimits, JointSetpoint
from splinearm.units import DEG

from .base import Feedforward
from .scaling import IntArray, JointScale

_log = logging.getLogger(__name__)

_FARTHEST = 45.0 * DEG
"""No joint needs a goal that far ahead, rad: who asks for it is wrong about the servo."""
_FADING = 5.0 * DEG
"""How fast a goal that is not quite the setpoint's becomes so, rad/s."""
_LONGEST = 0.1
_ITERATIONS = 8
"""Each makes the error smaller by the share that the lead changes with the angle: some percent."""


class GoalLead:
    """A feed-forward, asked and checked; without one goals are where the setpoints are.

    Args:
        limits: What the joints may do, for their names.
        feedforward: What is to be added, or None.
    """

    def __init__(self, limits: JointLimits, feedforward: Feedforward | None) -> None:
        self._names = limits.names
        self._limits = limits
        self._ahead = feedforward
        self._residue = np.zeros(limits.n)
        self._last_t = 0.0
        self._told: set[str] = set()

    def goal(self, setpoint: JointSetpoint) -> FloatArray:
        """Give where the servos shall be told to go, shape (n,), rad.

        Raises:
            ValueError: If the feed-forward gives no finite number for each joint.
            LimitError: If it wants a goal 45 deg or more from the setpoint, with the joint.
        """
        if self._ahead is None:
            return setpoint.q
        lead = frozen_array(self._ahead.lead(setpoint), setpoint.q.shape, "lead")
        far = np.abs(lead) > _FARTHEST
        if far.any():
            i = int(np.argmax(far))
            goal, reach = float(setpoint.q[i] + lead[i]), float(np.copysign(_FARTHEST, lead[i]))
            where = float(setpoint.q[i]) + reach
            raise LimitError(self._names[i], "position", goal, where, setpoint.t)
        self._fade(setpoint.t)
        led: FloatArray = setpoint.q + lead + self._residue
        return led

    def current(self, setpoint: JointSetpoint) -> FloatArray | None:
        """Give the Goal Current of each joint, shape (n,), A; None: it is left as it is.

        Raises:
            ValueError: If the feed-forward gives no finite number for each joint.
        """
        current = None if self._ahead is None else self._ahead.current(setpoint)
        return None if current is None else frozen_array(current, setpoint.q.shape, "current")

    def resting(self, q: FloatArray) -> JointSetpoint:
        """Give the setpoint of joints that rest at q, shape (n,), rad."""
        rest = np.zeros_like(q)
        return JointSetpoint(t=0.0, q=q, qd=rest, qdd=rest)

    def setpoint_at(self, goal: FloatArray) -> FloatArray:
        """Give the q of which, at rest, ``goal`` is the goal; shapes (n,), rad.

        A motion that starts there does not jump by the lead. Where a joint rests so near to its
        limit that its q would lie beyond, q is the limit; what is missing then is added to its
        goals, less and less.
        """
        self._residue = np.zeros_like(goal)
        if self._ahead is None:
            return goal
        q = goal
        for _ in range(_ITERATIONS):
            q = q - (self.goal(self.resting(q)) - goal)
        low = np.minimum(self._limits.q_min, goal)
        high = np.maximum(self._limits.q_max, goal)
        q = np.clip(q, low, high)
        self._residue = goal - self.goal(self.resting(q))
        return q

    def _fade(self, t: float) -> None:
        """Let what is missing from a setpoint's goal grow less with the time of the motion."""
        if self._residue.any():
            passed = min(max(t - self._last_t, 0.0), _LONGEST)
            less = np.minimum(np.abs(self._residue), _FADING * passed)
            self._residue = self._residue - np.copysign(less, self._residue)
        self._last_t = t

    def ticks(self, goal: FloatArray, scale: JointScale, joint_index: list[int]) -> IntArray:
        """Give the ticks of goals, at the end of what a servo takes if they lie beyond it.

        That is told once a joint: from there on the joint hangs behind, as it would without a lead.
        """
        wanted = goal[joint_index]
        ticks = scale.to_nearest_ticks(wanted)
        if self._ahead is not None:
            short = np.abs(scale.to_q(ticks) - wanted) * scale.pulses_per_rad > 1.5
            for i in np.flatnonzero(short):
                self._tell(scale.names[i], float(wanted[i] - scale.to_q(ticks)[i]))
        return ticks

    def _tell(self, joint: str, beyond: float) -> None:
        if joint not in self._told:
            self._told.add(joint)
            _log.warning(
                "joint %r: its feed-forward wants a goal %.2f deg beyond the last that the servo "
                "takes; there the joint hangs behind by that angle",
                joint,
                abs(beyond) / DEG,
            )
