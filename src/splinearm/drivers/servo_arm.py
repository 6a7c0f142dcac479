"""An arm made of servos on a bus."""

import logging
import time
from collections.abc import Collection, Mapping, Sequence
from math import inf
from types import TracebackType
from typing import Self, Unpack

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import BusError, BusTimeoutError, SplinearmError
from splinearm.joints import JointLimits, JointSetpoint, JointState

from .arm_line import ArmLine, scale_of, whereabouts
from .arm_option import ArmManner, ArmOptions, known_angles
from .asking import read_torque
from .bus import PingReply, ServoBus
from .chain import ServoChain
from .crew import Crew
from .dialect import protocols_of
from .health import HealthReading
from .lead import GoalLead
from .recover import Fault, find_faults, recover_servos, restore
from .scaling import IntArray, operating_mode
from .servo_stats import LastSeen, ServoStats
from .stance import take_stance
from .startup import (
    call_roll,
    check_health,
    check_settings,
    let_all_answer,
    require_calibration,
    warn_of_promises,
    write_ram_settings,
)
from .torque import await_rest, switch_off, switch_on
from .watchdog import Watchdog, warn_of_offsets

_log = logging.getLogger(__name__)

_SLACK = 1e-6  # rad: rounding on the way from a plan to here


class ServoArm:
    """An arm of servos, used in a with-block.

    Entering checks the servos against the arm's file and switches the torque on with each goal
    where the servo stands. Leaving, also by an exception, holds and closes the bus; it never takes
    the torque away. The bus belongs to the arm from its construction on.

    While setpoints flow the servos' own watchdog is armed: if this program dies or the cable is
    pulled, they stop. Servos that have stopped themselves, or come back after their power or the
    port was gone, are taken up again by ``recover`` and ``reconnect``, without a jump.

    Args:
        chain: The servos.
        joint_names: The joints, base to tool.
        limits: What these joints may do.
        bus: The bus they hang on, open.
        options: The fields of ``ArmManner``: ``watchdog``, ``hold_tolerance``, ``near``,
            ``feedforward``.

    Raises:
        ValueError: If chain, joints and limits do not fit together, or a servo cannot be a joint.
    """

    def __init__(
        self,
        chain: ServoChain,
        joint_names: Sequence[str],
        limits: JointLimits,
        bus: ServoBus,
        **options: Unpack[ArmOptions],
    ) -> None:
        manner = ArmManner(**options)
        if tuple(joint_names) != limits.names:
            raise ValueError(f"limits: want those of {tuple(joint_names)}, got {limits.names}")
        self._crew = Crew.of(chain, joint_names)
        for servo in self._crew.everyone:
            operating_mode(servo)
        self._limits = limits
        self._near = known_angles(manner.near, limits.n)
        self._bus = bus
        bus.speak(protocols_of(chain))
        self._hold_tolerance = manner.hold_tolerance
        self._lead = GoalLead(limits, manner.feedforward)
        self._watchdog = Watchdog(bus, self._crew.everyone, manner.watchdog)
        self._roll: Mapping[int, PingReply] = {}
        self._line: ArmLine | None = None
        self._on = False
        self._missed_since = inf

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
        return self._require_line().exchange.stats

    @property
    def last_seen(self) -> LastSeen:
        """The last that each joint said, also when ``read`` raised because of another."""
        return self._require_line().exchange.last_seen

    @property
    def goal(self) -> FloatArray:
        """Where the servos were last told to be, shape (n,), rad; the arm hangs a little below.

        A motion that starts here, not where the arm was measured, starts without a jerk.
        """
        return self._require_line().goal.copy()

    @property
    def health(self) -> Mapping[int, HealthReading]:
        """By id how each servo fares: temperature, supply, current or load."""
        return self._require_line().health.readings

    @property
    def halted(self) -> bool:
        """Whether nothing was sent for so long that servos may have stopped by themselves."""
        return self._watchdog.lapsed

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
            ServoError: If it reports a hardware error or has lost its torque; see ``recover``.
            HealthError: If a servo is too hot, badly fed or overloaded to go on; it still holds.
                That is raised once, and again after the next ``hold`` if it is still so.
        """
        line = self._require_line()
        asked = time.monotonic()
        self._watchdog.feed(asked)
        try:
            state = line.exchange.read()
        except BusTimeoutError as error:
            line.health.suspect(error.servo_id)
            self._missed_since = min(self._missed_since, asked)
            raise
        if self._missed_since < inf:
            missed_since, self._missed_since = self._missed_since, inf
            self._watchdog.require_going(missed_since)
        effort = np.where(np.isnan(state.current), line.exchange.load, state.current)
        line.health.look(state.t, effort, torque=self._on)
        return state

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
        line.scale.to_ticks(setpoint.q[line.joint_index])
        goal = self._lead.goal(setpoint)
        ticks = self._lead.ticks(goal, line.scale, line.joint_index)
        current = self._lead.current(setpoint)
        if self._watchdog.lapsed:
            self._watchdog.revive()
        self._send(line, ticks, setpoint.q, current)
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
        stopped = self._watchdog.revive()
        line.health.remind()
        if not self._on:
            self._switch_on()
            line.health.begin_anew()
            return
        self._settle(line, stopped)

    def recover(self, near: ArrayInput | None = None) -> tuple[Fault, ...]:
        """Bring back servos that have stopped themselves or have lost their torque; hold.

        Only those are rebooted that have latched a hardware error; each gets its settings, its goal
        is where it stands, then its torque comes on. The others go on holding. Support the arm: a
        joint without torque sinks until then.

        Args:
            near: As for the arm: only joints of more than one turn need it, after their power was
                gone.

        Returns:
            The hardware errors that were latched.

        Raises:
            ServoError: Before anything is rebooted, if a servo is still too hot or badly fed, or
                its encoder has failed; after it, if a servo is as ill as before or which turn its
                joint is in cannot be told. It says what helps; then recover again.
            BusError: If a servo does not answer; see ``reconnect``.
        """
        line, crew = self._require_line(), self._crew
        self._watchdog.disarm()
        torque = read_torque(self._bus, crew.everyone)
        ill = {fault.servo.servo_id for fault in find_faults(self._bus, crew.everyone)}
        known = whereabouts(
            self._bus, crew, line.scale, near, {i for i, on in torque.items() if on} | ill
        )
        faults = recover_servos(self._bus, crew.everyone, line.health.limits)
        self._take_up(line, known)
        return faults

    def reconnect(self, port: str | None = None, near: ArrayInput | None = None) -> None:
        """Take up the arm again after its port, or servos, were gone; hold.

        Opens the port again, calls the roll and checks the servos as on entering. Servos that have
        lost their torque get their settings; their goals, and those of servos that were stopped by
        their watchdog, are where they stand.

        Args:
            port: Where the arm is now; None: where it was.
            near: As for the arm: only joints of more than one turn need it, after their power was
                gone.

        Raises:
            PortError: If the port is not there.
            BusTimeoutError: If a servo is still missing.
            ServoError: If a servo is not as the file says, has latched a hardware error (see
                ``recover``), or which turn its joint is in cannot be told.
        """
        line, everyone = self._require_line(), self._crew.everyone
        self._bus.reopen(port)
        let_all_answer(self._bus, everyone)
        self._roll = call_roll(self._bus, everyone)
        check_settings(self._bus, everyone)
        stopped = self._watchdog.stopped()
        self._watchdog.disarm()
        check_health(self._bus, everyone)
        torque = read_torque(self._bus, everyone)
        known = whereabouts(
            self._bus, self._crew, line.scale, near, {i for i, on in torque.items() if on}
        )
        self._take_up(line, known, stopped)

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
        warn_of_offsets(crew.everyone)
        warn_of_promises(crew.everyone)
        stopped = self._watchdog.stopped()
        self._watchdog.disarm()
        write_ram_settings(bus, crew.everyone, crew.led)
        self._switch_on(self._near, stopped)

    def _take_up(self, line: ArmLine, near: FloatArray, stopped: Collection[int] = ()) -> None:
        """Give servos without torque their settings and, unless the arm is released, torque."""
        crew = self._crew
        torque = read_torque(self._bus, crew.everyone)
        dark = [servo for servo in crew.everyone if not torque[servo.servo_id]]
        restore(self._bus, crew.with_coupled(dark), crew.led)
        line.exchange.lay_out([servo.servo_id for servo in dark])
        if self._on:
            self._switch_on(near, stopped)
            if dark:
                await_rest(self._bus, crew.leaders)
            self._settle(line)
        line.health.begin_anew()

    def _switch_on(self, near: FloatArray | None = None, stopped: Collection[int] = ()) -> None:
        """Switch the torque on where the arm stands."""
        crew = self._crew
        stance = take_stance(
            self._bus, crew, self._limits, self._hold_tolerance, near=near, stopped=stopped
        )
        scale = scale_of(crew, stance)
        line = self._line
        if line is None:
            line = ArmLine.connect(self._bus, crew, self._roll, scale, self._lead)
        line.exchange.scale = scale
        stance = switch_on(self._bus, crew, stance)
        held = scale.first(self.n).to_q([stance.goals[s.servo_id] for s in crew.leaders])
        line.goal = self._lead.setpoint_at(held)
        self._line, self._on = line, True

    def _settle(self, line: ArmLine, stopped: Collection[int] = ()) -> None:
        """Keep the goals of joints that are near them; the others stay where they stand.

        Those stay there too whose servos, by id, were stopped on their way.
        """
        asked = time.monotonic()
        try:
            line.exchange.read()
        except BusError as error:
            _log.warning("holding: %s", error)
        seen = line.exchange.last_seen
        heard = seen.t >= asked
        halted = heard & [servo.servo_id in stopped for servo in self._crew.leaders]
        strayed = heard & ~halted & (np.abs(seen.q - line.goal) > self._hold_tolerance)
        q = np.where(halted, seen.q, line.goal)
        resting = self._lead.resting(q)
        goal = self._lead.goal(resting)
        if strayed.any():
            goal = np.where(strayed, seen.q, goal)
            q = self._lead.setpoint_at(goal)
        ticks = line.scale.to_nearest_ticks(goal[line.joint_index])
        self._send(line, ticks, q, self._lead.current(resting))

    def _send(
        self, line: ArmLine, ticks: IntArray, q: FloatArray, current: FloatArray | None
    ) -> None:
        """Send goals and remember them."""
        line.exchange.write(ticks, None, None if current is None else current[line.joint_index])
        self._watchdog.feed()
        line.goal = q

    def _require_line(self) -> ArmLine:
        """Give what moves the arm; refuse an arm that was not entered."""
        if self._line is None:
            raise RuntimeError("use the arm in a with-block: it is not connected yet")
        return self._line
