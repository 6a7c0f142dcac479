"""Arms that a hand can lead: their weight is carried, and where they are left they stay.

The arm goes on being told positions. Its goal trails the joint by a small slack, as if dry friction
held it: a hand that pushes harder than that moves the joint, and where it lets go the goal stands
still and the servo holds. What the arm weighs is in the lead of its feed-forward; the slack takes
what that does not know. Nothing is switched on the way in or out, so nothing can drop:

- a change to current control (mode 0) needs the torque off, and an arm without brakes falls;
- in it nothing holds a position: an arm whose weight is known to 5 % drifts away by tens of degrees
  in seconds, and what a tripped watchdog leaves of the current the manual does not say. Here the
  servos stay at their last goal.

Servos in current-based position mode (5) under a ``ForceLimited`` feed-forward give way within a
cycle as well; others by their goal alone, which does with every servo.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Self, TypeAlias

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import BusError, StaleFeedbackError
from splinearm.joints import JointLimits, JointSetpoint, JointState
from splinearm.units import DEG

from .base import ArmDriver
from .feedforward import ServoFeedforward
from .feedforward_drive import JointDrive

_log = logging.getLogger(__name__)

Haste: TypeAlias = Callable[[FloatArray, FloatArray], float]
"""How fast an arm is, of joint positions and speeds, as a share of what is allowed."""

_LEAST_SLACK = 0.3 * DEG
"""Some ticks of an encoder: with less the goal would follow its noise, rad."""

_SMOOTH = 0.2
"""Share of a cycle's speed in the mean that counts: goals go tick by tick."""

_UNKNOWN_SLACK = 1.0 * DEG
"""Slack of a joint whose stiffness is not known, rad."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GuidingFeel:
    """How an arm feels in the hand."""

    breakaway: float = 0.06
    """Torque that moves a joint, as a share of what its servos can give."""
    speed: float = 0.5
    """Highest speed of the goals, as a share of the joints' limits."""
    ease: float = 0.5
    """Share of the drag of the turning motors that is made up for: 0 is tough, 1 glides."""
    haste: Haste | None = None
    """Asked of the goals, which go no faster than makes it 1: a hand that is faster feels the
    servos resist. It must grow in proportion to the speeds. None: only joints count."""

    def __post_init__(self) -> None:
        for name in ("breakaway", "speed"):
            value = getattr(self, name)
            if not 0.0 < value <= 1.0:
                raise ValueError(f"{name}: want above 0 and at most 1, got {value}")
        if not 0.0 <= self.ease <= 1.0:
            raise ValueError(f"ease: want 0 to 1, got {self.ease}")


class GravityCompensation:
    """Leads an arm by hand, cycle by cycle, within a with-block; leaving holds it.

    Args:
        arm: The arm, entered; its feed-forward must know its weight.
        feedforward: That feed-forward; of a ``ForceLimited`` what it limits.
        limits: What the joints may do: a joint that is pushed beyond comes back as by a spring.
        feel: How it feels in the hand.
        period: Time between cycles, s.
        bridge: Cycles without feedback in which the goals stay; one more ends it.

    Raises:
        ValueError: If the arm, its feed-forward and its limits do not go together, the feed-forward
            does not know the weight, or a number is none that makes sense.
    """

    def __init__(
        self,
        arm: ArmDriver,
        feedforward: ServoFeedforward,
        limits: JointLimits,
        feel: GuidingFeel | None = None,
        *,
        period: float = 0.01,
        bridge: int = 3,
    ) -> None:
        if not arm.n == limits.n == len(feedforward.drives):
            raise ValueError(
                f"arm: want as many joints as limits and drives, got {arm.n}, {limits.n} and "
                f"{len(feedforward.drives)}"
            )
        if not feedforward.knows_weight:
            raise ValueError("feedforward: want one that knows the arm's torques, got none")
        if not period > 0.0:
            raise ValueError(f"period: want a time above zero, got {period}")
        if bridge < 0:
            raise ValueError(f"bridge: want 0 cycles or more, got {bridge}")
        feel = GuidingFeel() if feel is None else feel
        self._arm = arm
        self._limits = limits
        self._period = period
        self._haste = feel.haste
        self._bridge = bridge
        self._slack = np.array([_slack(drive, feel.breakaway) for drive in feedforward.drives])
        self._step = limits.qd_max * feel.speed * period
        self._speed = np.zeros(limits.n)
        self._ease = feel.ease
        self._t = 0.0
        self._lost = 0
        self._goal = arm.goal

    @property
    def slack(self) -> FloatArray:
        """How far a joint is from its goal when a hand begins to move it, shape (n,), rad."""
        return self._slack.copy()

    @property
    def goal(self) -> FloatArray:
        """Where the arm stays if it is let go, shape (n,), rad."""
        return self._goal.copy()

    def __enter__(self) -> Self:
        """Begin where the arm is held: nothing moves."""
        self._goal = np.clip(self._arm.goal, self._limits.q_min, self._limits.q_max)
        self._t, self._lost = 0.0, 0
        self._speed = np.zeros(self._limits.n)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Hold where the goal is."""
        try:
            self._arm.hold()
        except BusError as trouble:
            if error is None:
                raise
            _log.error("the arm could not be told to hold: %s", trouble)

    def step(self) -> JointState | None:
        """Let one cycle go by: read, let the goal follow, write.

        Returns:
            What was read; None if a joint did not answer and the goals stay.

        Raises:
            StaleFeedbackError: If that lasted; the arm stays at its last goal.
            PortError: If the port is gone.
        """
        self._t += self._period
        state = self._read()
        if state is None:
            self._speed = np.zeros_like(self._speed)
        else:
            self._follow(state)
        qd = self._ease * self._speed
        self._arm.write(JointSetpoint(t=self._t, q=self._goal, qd=qd, qdd=np.zeros_like(qd)))
        return state

    def _read(self) -> JointState | None:
        try:
            state = self._arm.read()
        except BusError as error:
            self._lost += 1
            if self._lost > self._bridge:
                age, limit = self._lost * self._period, self._bridge * self._period
                raise StaleFeedbackError(age, limit, str(error)) from error
            return None
        self._lost = 0
        return state

    def _follow(self, state: JointState) -> None:
        """Let the goal trail the joints by no more than the slack."""
        wanted = np.clip(self._goal, state.q - self._slack, state.q + self._slack)
        step = np.clip(wanted - self._goal, -self._step, self._step)
        if self._haste is not None:
            step = step / max(1.0, self._haste(self._goal, step / self._period))
        before = self._goal
        self._goal = np.clip(before + step, self._limits.q_min, self._limits.q_max)
        self._speed += _SMOOTH * ((self._goal - before) / self._period - self._speed)


def _slack(drive: JointDrive, breakaway: float) -> float:
    """Give how far behind its goal a joint is when its servos pull at the breakaway torque."""
    known = _UNKNOWN_SLACK if drive.why_not else breakaway * drive.reach
    return max(known, _LEAST_SLACK)
