"""An arm made of servos on a bus."""

import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Self

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import BusError, SplinearmError
from splinearm.joints import JointLimits, JointSetpoint, JointState
from splinearm.units import DEG

from .bus import PingReply, ServoBus
from .chain import ServoChain
from .crew import Crew
from .cyclic import GroupWrite
from .feedback import Feedback, LastSeen, ServoStats, feedback_address
from .scaling import IntArray, JointScale, operating_mode
from .stance import switch_off, switch_on, take_stance
from .startup import (
    call_roll,
    check_health,
    check_settings,
    let_all_answer,
    require_calibration,
    write_ram_settings,
)
from .watchdog import Watchdog

_log = logging.getLogger(__name__)

_SLACK = 1e-6  # rad: rounding on the way from a plan to here


@dataclass(slots=True, eq=False, kw_only=True)
class _Line:
    """What moves an arm that was entered."""

    feedback: Feedback
    goals: GroupWrite
    joint_index: list[int]
    scale: JointScale
    goal: FloatArray


class ServoArm:
    """An arm of servos, used in a with-block.

    Entering checks the servos against the arm's file and switches the torque on with each goal
    where the servo stands. Leaving, also by an exception, holds and closes the bus; it never takes
    the torque away. The bus belongs to the arm from its construction on.

    While setpoints flow the servos' own watchdog is armed: if this program dies or the cable is
    pulled, they stop.

    Args:
        chain: The servos.
        joint_names: The joints, base to tool.
        limits: What these joints may do.
        bus: The bus they hang on, open.
        watchdog: Silence after which the servos stop by themselves, s, in steps of 20 ms;
            None: they do not.
        hold_tolerance: How far from its goal a joint may be for ``hold`` to keep that goal, rad.
            With the gains of the factory an arm hangs 1 to 3 degrees below its goals.

    Raises:
        ValueError: If chain, joints and limits do not fit together, or a servo cannot be a joint.
    """

    def __init__(
        self,
        chain: ServoChain,
        joint_names: Sequence[str],
        limits: JointLimits,
        bus: ServoBus,
        *,
        watchdog: float | None = 0.1,
        hold_tolerance: float = 6.0 * DEG,
    ) -> None:
        if tuple(joint_names) != limits.names:
            raise ValueError(f"limits: want those of {tuple(joint_names)}, got {limits.names}")
        if not hold_tolerance > 0.0:
            raise ValueError(f"hold_tolerance: want above zero, got {hold_tolerance}")
        if chain.protocol != 2.0:
            raise ValueError(f"chain: want servos of protocol 2.0, got {chain.protocol}")
        self._crew = Crew.of(chain, joint_names)
        for servo in self._crew.everyone:
            feedback_address(servo.servo_model)
            operating_mode(servo)
        self._limits = limits
        self._bus = bus
        self._hold_tolerance = hold_tolerance
        self._watchdog = Watchdog(bus, self._crew.everyone, watchdog)
        self._silence = watchdog
        self._roll: Mapping[int, PingReply] = {}
        self._line: _Line | None = None
        self._on = False

    @property
    def n(self) -> int:
        """Number of joints."""
        return self._limits.n

    @property
    def roll(self) -> Mapping[int, PingReply]:
        """By id what the servos said of themselves when the arm was entered."""
        return self._roll

    @property
    def stats(self) -> Mapping[int, ServoStats]:
        """By id of each leader how it has answered so far."""
        return self._require_line().feedback.stats

    @property
    def last_seen(self) -> LastSeen:
        """The last that each joint said, also when ``read`` raised because of another."""
        return self._require_line().feedback.last_seen

    @property
    def goal(self) -> FloatArray:
        """Where the servos were last told to be, shape (n,), rad; the arm hangs a little below.

        A motion that starts here, not where the arm was measured, starts without a jerk.
        """
        return self._require_line().goal.copy()

    @property
    def watchdog_trips(self) -> int:
        """How many servos their watchdog has stopped, and were set going again."""
        return self._watchdog.trips

    def __enter__(self) -> Self:
        try:
            self._commission()
        except BaseException:
            self._bus.close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if self._on:
                self.hold()
        except SplinearmError as trouble:
            if error is None:
                raise
            _log.error("the arm could not be told to hold: %s", trouble)
        finally:
            self._bus.close()

    def read(self) -> JointState:
        """Measure the joints.

        Returns:
            Their state, at a time on ``time.monotonic``; of a joint with shadows the leader's.

        Raises:
            BusTimeoutError: If a servo does not answer; what the others said is in ``last_seen``.
            PacketError: If its answer is damaged.
            ServoError: If it reports a hardware error.
        """
        line = self._require_line()
        try:
            return line.feedback.read()
        finally:
            self._watchdog.feed()

    def write(self, setpoint: JointSetpoint) -> None:
        """Send the position of a setpoint; it is valid until the next.

        Raises:
            ValueError: If it is not for this many joints.
            LimitError: If it is outside the limits of the joints or of the servos.
            PortError: If the port is gone.
        """
        line = self._require_line()
        if setpoint.q.shape != (self.n,):
            raise ValueError(f"setpoint: want {self.n} joints, got {setpoint.q.shape}")
        if not self._on:
            raise RuntimeError("the torque is off since release(); hold() switches it on again")
        self._limits.check(setpoint.q, t=setpoint.t, tolerance=_SLACK)
        ticks = line.scale.to_ticks(setpoint.q[line.joint_index])
        if self._watchdog.lapsed:
            self._watchdog.revive()
        self._send(line, ticks, setpoint.q)
        if not self._watchdog.armed:
            self._watchdog.arm()

    def hold(self) -> None:
        """Stay where the arm stands, with torque.

        A joint near its last goal keeps that goal, so that holding again and again does not let the
        arm sink; a joint that is far from it, as after a collision, stays where it is. After
        ``release`` this switches the torque on again.

        Raises:
            PortError: If the port is gone.
            BusError: After ``release``, if a servo does not answer.
        """
        line = self._require_line()
        self._watchdog.disarm()
        if not self._on:
            self._switch_on()
            return
        asked = time.monotonic()
        try:
            line.feedback.read()
        except BusError as error:
            _log.warning("holding: %s", error)
        seen = line.feedback.last_seen
        strayed = (seen.t >= asked) & (np.abs(seen.q - line.goal) > self._hold_tolerance)
        q = np.where(strayed, seen.q, line.goal)
        self._send(line, line.scale.to_nearest_ticks(q[line.joint_index]), q)

    def release(self) -> None:
        """Switch the torque off, also of shadows. An arm without brakes falls.

        Raises:
            BusError: The first that occurred, after every servo was told.
        """
        self._require_line()
        self._on = False
        self._watchdog.disarm()
        switch_off(self._bus, self._crew)

    def _commission(self) -> None:
        """Check the servos and switch them on."""
        bus, crew = self._bus, self._crew
        require_calibration(crew.leaders)
        let_all_answer(bus, crew.everyone)
        self._roll = call_roll(bus, crew.everyone)
        check_settings(bus, crew.everyone)
        check_health(bus, crew.everyone)
        self._watchdog = Watchdog(bus, crew.everyone, self._silence)
        self._watchdog.disarm()
        write_ram_settings(bus, crew.everyone)
        self._switch_on()

    def _switch_on(self) -> None:
        """Switch the torque on where the arm stands."""
        crew = self._crew
        stance = take_stance(self._bus, crew, self._limits, self._hold_tolerance)
        switch_on(self._bus, crew, stance)
        servos = [
            replace(servo, zero_ticks=int(zero))
            for servo, zero in zip(crew.targets, stance.zero_ticks, strict=True)
        ]
        scale = replace(
            JointScale.of(servos), ticks_min=stance.ticks_min, ticks_max=stance.ticks_max
        )
        of_leaders = JointScale.of(servos[: self.n])
        goal = of_leaders.to_q([stance.goals[servo.servo_id] for servo in crew.leaders])
        if self._line is None:
            self._line = self._connect(scale, of_leaders, goal)
        else:
            self._line.scale, self._line.goal = scale, goal
            self._line.feedback.scale = of_leaders
        self._on = True

    def _connect(self, scale: JointScale, of_leaders: JointScale, goal: FloatArray) -> "_Line":
        """Prepare what is sent and read in every cycle."""
        crew = self._crew
        fast = all(
            servo.servo_model.has_fast_read(self._roll[servo.servo_id].firmware)
            for servo in crew.leaders
        )
        targets = [(s.servo_id, s.servo_model.table["Goal Position"]) for s in crew.targets]
        return _Line(
            feedback=Feedback(self._bus, crew.leaders, of_leaders, fast=fast),
            goals=GroupWrite(targets),
            joint_index=crew.joint_index,
            scale=scale,
            goal=goal,
        )

    def _send(self, line: "_Line", ticks: IntArray, q: FloatArray) -> None:
        """Send goals and remember them."""
        self._bus.sync_write(line.goals, ticks.tolist())
        self._watchdog.feed()
        line.goal = q

    def _require_line(self) -> "_Line":
        """Give what moves the arm; refuse an arm that was not entered."""
        if self._line is None:
            raise RuntimeError("use the arm in a with-block: it is not connected yet")
        return self._line
