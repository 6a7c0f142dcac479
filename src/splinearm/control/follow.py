"""The loop: read, setpoint, guard, write, observe, each cycle, until the motion ends or is stopped.

Whatever goes wrong, the arm slows down along its path, then holds with torque; only then is the
error raised.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from splinearm.drivers.base import ArmDriver
from splinearm.errors import BusError, LimitError, MotionError, StaleFeedbackError
from splinearm.joints import JointSetpoint, JointState
from splinearm.trajectories.pace import PacedMotion
from splinearm.trajectories.trajectory import JointTrajectory

from .clock import Clock
from .collector import collector_suspended
from .guard import Guard
from .override import PaceRequest
from .record import Cycle
from .stop import StopRequest

_log = logging.getLogger(__name__)


class Outcome(Enum):
    """How a motion ended that had no fault."""

    FINISHED = "finished"
    """The arm is where the motion ends."""

    STOPPED = "stopped"
    """A stop was asked for; the arm holds on its path."""


def _ignore(_: object) -> None:
    """Observe nothing."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Loop:
    """An arm, its clock and its guard: all that it takes to follow a motion."""

    driver: ArmDriver
    """The arm, entered."""
    clock: Clock
    """The arm's time; ``JointState.t`` is on it."""
    guard: Guard
    """What every motion and setpoint must pass."""
    period: float = 0.01
    """Time between setpoints, s."""
    bridge: int = 3
    """Cycles without feedback, or missed, that the plan may bridge; one more stops the arm."""
    observe: Callable[[Cycle], object] = _ignore
    """Gets every cycle after its setpoint was written; must not block."""
    announce: Callable[[str], object] = _log.info
    """Gets one line whenever the loop decides something a person should know."""

    def __post_init__(self) -> None:
        if not self.period > 0.0:
            raise ValueError(f"period: want a time above zero, got {self.period}")
        if self.bridge < 0:
            raise ValueError(f"bridge: want 0 cycles or more, got {self.bridge}")

    def follow(
        self,
        trajectory: JointTrajectory,
        stop: StopRequest | None = None,
        pace: PaceRequest | None = None,
    ) -> Outcome:
        """Carry out a motion; SIGINT and SIGTERM stop the arm along its path.

        Args:
            trajectory: The motion; it starts where the arm stands, at rest.
            stop: Where another thread may ask for a stop; None: one of its own.
            pace: Where another thread may ask for another pace; None: it goes as planned.

        Raises:
            LimitError: Before anything moves, if the motion breaks a limit.
            StartError: Before anything moves, if the arm is elsewhere.
            BusError: Before anything moves, if the arm does not answer.
            MotionError: After the arm was stopped along its path, what made it stop.
        """
        self.guard.admit(trajectory, self.period)
        self.guard.begin(trajectory, self.driver.read(), self.driver.goal)
        with collector_suspended(), stop if stop is not None else StopRequest() as request:
            return _Run(self, trajectory, request, pace).to_end()


class _Paced:
    """A motion at a pace that is asked for while it runs."""

    def __init__(self, motion: PacedMotion, request: PaceRequest) -> None:
        self.motion = motion
        self.request = request
        self.cycle = 0

    def at_cycle(self, index: int) -> JointSetpoint:
        """Give the setpoint of a cycle, which is not before the last one."""
        while self.cycle < index:
            self.motion.ask(self.request.pace)
            self.motion.step()
            self.cycle += 1
        return self.motion.setpoint()


class _Run:
    """One motion under way."""

    def __init__(
        self,
        loop: Loop,
        trajectory: JointTrajectory,
        stop: StopRequest,
        pace: PaceRequest | None = None,
    ) -> None:
        self.loop = loop
        self.motion = trajectory
        self.stop = stop
        # while there is one, it says where the motion is; a stop is a motion of its own
        self.paced: _Paced | None = None
        if pace is not None and trajectory.duration > 0.0:
            self.paced = _Paced(PacedMotion(trajectory, loop.period), pace)
        self.fault: MotionError | None = None
        self.stopping = False
        self.lost = 0
        self.trouble: BusError | None = None
        self.index = 0
        # the motion's time is anchor_t at cycle anchor_index and runs with the cycles from there
        self.anchor_index = 0
        self.anchor_t = 0.0
        self.last_t = 0.0
        self.begun = loop.clock.now()
        self.written_index: int | None = None

    def to_end(self) -> Outcome:
        """Turn the loop until the arm rests."""
        self.loop.announce(f"motion of {self.motion.duration:.2f} s begins")
        while True:
            lateness = self.loop.clock.wait_until(self.begun + self.index * self.loop.period)
            setpoint, state = self._cycle(lateness)
            if self.motion_t >= self.motion.duration and self._at_rest(setpoint, state):
                break
            self.index += 1
        self._hold()
        if self.fault is not None:
            raise self.fault
        return Outcome.STOPPED if self.stopping else Outcome.FINISHED

    @property
    def motion_t(self) -> float:
        """Time along the motion in this cycle, s."""
        if self.paced is not None:
            return self.paced.motion.motion_t
        return (self.index - self.anchor_index) * self.loop.period + self.anchor_t

    def _setpoint(self) -> JointSetpoint:
        if self.paced is not None:
            setpoint = self.paced.at_cycle(self.index)
            if not self.paced.motion.finished:
                return setpoint
            self.paced = None
            self._anchor(self.motion.duration)
        return self.motion.at(min(self.motion_t, self.motion.duration))

    def _cycle(self, lateness: float) -> tuple[JointSetpoint, JointState | None]:
        woke = time.perf_counter()
        self._catch_up(lateness)
        state = self._read()
        self._judge(self._setpoint(), state)
        setpoint = self._setpoint()  # of the stop, once it has begun
        self._write(setpoint)
        cycle = Cycle(
            index=self.index,
            t=self.index * self.loop.period,
            lateness=lateness,
            setpoint=setpoint,
            state=state,
            busy=time.perf_counter() - woke,
        )
        self.loop.observe(cycle)
        return setpoint, state

    def _catch_up(self, lateness: float) -> None:
        """Skip the cycles that have passed; the arm gets the newest point, never a stale one.

        After too long a pause the newest point may be far: then the motion goes on from the last
        one, and stops.
        """
        missed = int(lateness / self.loop.period)
        if missed == 0:
            return
        self.index += missed
        if missed > self.loop.bridge:
            self._anchor(min(self.last_t + self.loop.period, self.motion.duration))
            self._stop(self._stale(lateness))

    def _read(self) -> JointState | None:
        try:
            state = self.loop.driver.read()
        except BusError as error:
            self.lost += 1
            self.trouble = error
            if self.lost > self.loop.bridge:
                self._stop(self._stale(self.lost * self.loop.period))
            return None
        self.lost = 0
        self.trouble = None
        return state

    def _stale(self, age: float) -> StaleFeedbackError:
        """Give the fault of having heard nothing: of a servo, or of this computer."""
        cause = "the computer was busy; close other programs or choose a lower rate"
        if self.trouble is not None:
            cause = str(self.trouble)
        fault = StaleFeedbackError(age, self.loop.bridge * self.loop.period, cause)
        fault.__cause__ = self.trouble
        return fault

    def _judge(self, setpoint: JointSetpoint, state: JointState | None) -> None:
        """Stop if asked, or if the arm does not follow."""
        if self.stop.requested:
            self._stop(None)
        if state is None or self.stopping:
            return
        try:
            self.loop.guard.follows(setpoint, state, self.motion_t)
        except MotionError as error:
            self._stop(error)

    def _write(self, setpoint: JointSetpoint) -> None:
        since = 0 if self.written_index is None else self.index - self.written_index
        try:
            self.loop.guard.check(setpoint, since * self.loop.period)
            self.loop.driver.write(setpoint)
        except LimitError as error:
            self._hold()
            raise MotionError(str(error)) from error
        except BusError as error:
            # no word reaches the arm any more: what it does now is up to its own watchdog
            raise _cut_off(error) from error
        self.last_t = self.motion_t
        self.written_index = self.index

    def _hold(self) -> None:
        """Hold; an arm that cannot be told to is a fault, unless there is one already."""
        try:
            self.loop.driver.hold()
        except BusError as error:
            _log.warning("the arm could not be told to hold: %s", error)
            if self.fault is None:
                self.fault = _cut_off(error)

    def _anchor(self, t: float) -> None:
        self.anchor_index, self.anchor_t = self.index, t

    def _stop(self, fault: MotionError | None) -> None:
        """Let the motion end along its path, once."""
        if self.stopping:
            return
        self.stopping = True
        self.fault = fault
        if self.paced is not None:
            self.motion, self.paced = self.paced.motion.stop(), None
        else:
            self.motion = self.motion.stop_from(min(self.motion_t, self.motion.duration))
        self._anchor(0.0)
        why = "stop asked for" if fault is None else str(fault)
        self.loop.announce(f"{why}: stopping along the path in {self.motion.duration:.2f} s")

    def _at_rest(self, setpoint: JointSetpoint, state: JointState | None) -> bool:
        """Tell whether the loop may end: stopped, arrived, or out of patience."""
        guard = self.loop.guard
        if self.stopping:
            return True
        if state is not None and guard.arrived(setpoint, state):
            return True
        if self.motion_t - self.motion.duration < guard.tolerances.settle:
            return False
        try:
            if state is not None:
                guard.require_arrival(setpoint, state, self.motion_t)
        except MotionError as error:
            self.fault = error
        return True


def _cut_off(error: BusError) -> MotionError:
    """Give the fault of an arm that no word reaches any more."""
    fault = MotionError(f"the arm can no longer be told where to go: {error}")
    fault.__cause__ = error
    return fault
