"""One motion under way: what happens in each cycle, and what ends it."""

import logging
import time
from typing import TYPE_CHECKING

import numpy as np

from splinearm.errors import BusError, LimitError, MotionError, ServoError, StaleFeedbackError
from splinearm.joints import JointSetpoint, JointState
from splinearm.trajectories.trajectory import JointTrajectory

from .course import Course
from .cycle import Cycle
from .ending import Ending, ExitReason, Outcome, reason_of
from .forecast import joint_travel
from .hearing import Hearing
from .keeping import RateKeeper
from .override import PaceRequest
from .stop import StopRequest

if TYPE_CHECKING:
    from .follow import Loop

_log = logging.getLogger(__name__)


class Run:
    """One motion under way.

    Args:
        loop: What it takes to follow it.
        trajectory: The motion, admitted; the arm stands at its begin.
        stop: Where a stop is asked for.
        pace: Where another pace is asked for, or None.
    """

    def __init__(
        self,
        loop: "Loop",
        trajectory: JointTrajectory,
        stop: StopRequest,
        pace: PaceRequest | None = None,
    ) -> None:
        self.loop = loop
        self.stop = stop
        self.course = Course(trajectory, loop.period, pace)
        self.keeper = RateKeeper(loop.period)
        self.hearing = Hearing(loop.driver, loop.guard.limits.names, loop.announce)
        self.fault: MotionError | None = None
        self.reason = ExitReason.SUCCESSFUL
        self.cut_off = False
        self.index = 0
        self.last_t = 0.0
        self.written_index: int | None = None

    def to_end(self) -> Ending:
        """Turn the loop until the arm rests."""
        self.loop.announce(f"motion of {self.course.motion.duration:.2f} s begins")
        begun = self.loop.clock.now()
        while True:
            lateness = self.loop.clock.wait_until(begun + self.index * self.loop.period)
            setpoint, state = self._cycle(lateness)
            if self.cut_off or (self.course.ended(self.index) and self._may_end(setpoint, state)):
                break
            self.index += self.keeper.stride
        if not self.cut_off:
            self._hold()
        return self._ending()

    @property
    def stopping(self) -> bool:
        """Whether the motion is being stopped on its path."""
        return self.course.stopped is not None

    def _ending(self) -> Ending:
        if self.fault is None and not self.stopping:
            return Ending(outcome=Outcome.FINISHED, reason=ExitReason.SUCCESSFUL)
        stopped = self.course.cut(self.last_t)
        if self.fault is not None:
            self.fault.stopped = stopped
            return Ending(
                outcome=Outcome.FAILED, reason=self.reason, fault=self.fault, stopped=stopped
            )
        reason = ExitReason.GOAL_TOLERANCE_VIOLATED
        return Ending(outcome=Outcome.STOPPED, reason=reason, stopped=stopped)

    def _cycle(self, lateness: float) -> tuple[JointSetpoint, JointState | None]:
        woke = time.perf_counter()
        stride = self.keeper.stride
        self._catch_up(lateness)
        if self.cut_off:
            return self.course.setpoint(self.index), None
        state = self._read()
        self._judge(self.course.setpoint(self.index), state)
        setpoint = self.course.setpoint(self.index)  # of the stop, once it has begun
        self._write(setpoint)
        self._observe(
            Cycle(
                index=self.index,
                t=self.index * self.loop.period,
                lateness=lateness,
                setpoint=setpoint,
                state=state,
                busy=time.perf_counter() - woke,
                stride=stride,
            )
        )
        return setpoint, state

    def _catch_up(self, lateness: float) -> None:
        """Skip the cycles that have passed; the arm gets the newest point, never a stale one.

        After too long a pause the newest point may be far: then the motion goes on from the last
        one, and stops.
        """
        missed = int(lateness / (self.keeper.stride * self.loop.period))
        if missed == 0:
            return
        self.index += missed * self.keeper.stride
        if missed > self.loop.bridged:
            onward = self.loop.bridged if self.stopping else 1
            t = self.last_t + onward * self.loop.period
            self.course.anchor(self.index, min(t, self.course.motion.duration))
            if getattr(self.loop.driver, "halted", False):
                self._give_in(self._stale(lateness))
            else:
                self._stop(self._stale(lateness))
        else:
            self._keep_rate(lateness)

    def _keep_rate(self, lateness: float) -> None:
        """Choose a lower rate if this computer was late too often of late."""
        worst = self.keeper.note(self.index * self.loop.period, lateness)
        if worst is not None:
            self.loop.announce(
                f"this computer wakes up to {worst * 1e3:.1f} ms late: going on at "
                f"{self.keeper.rate:.0f} setpoints a second; the path stays the same"
            )

    def _give_in(self, fault: MotionError) -> None:
        """End after a pause in which the servos have stopped by themselves: hold where they are.

        They would have to jump to the speed of the motion to be slowed down along its path.
        """
        self._fail(fault)
        self.loop.announce(f"{fault}: the servos have stopped by themselves")
        self._hold()
        self.cut_off = True

    def _read(self) -> JointState | None:
        try:
            state = self.hearing.read()
        except ServoError as error:
            fault = MotionError(str(error))
            fault.__cause__ = error
            self._stop(fault)
            return None
        if self.hearing.lost > self.loop.bridged:
            self._stop(self._stale(self.hearing.lost * self.loop.period))
        return state

    def _stale(self, age: float) -> StaleFeedbackError:
        """Give the fault of having heard nothing: of a servo, or of this computer."""
        trouble = self.hearing.trouble
        cause = "the computer was busy; close other programs or choose a lower rate"
        if trouble is not None:
            cause = str(trouble)
        fault = StaleFeedbackError(age, self.loop.bridged * self.loop.period, cause)
        fault.__cause__ = trouble
        return fault

    def _judge(self, setpoint: JointSetpoint, state: JointState | None) -> None:
        """Stop if asked, or if the arm does not follow."""
        if self.stop.requested:
            self._stop(None)
        if self.stopping:
            return
        known = state if state is not None else self.hearing.heard(setpoint)
        if known is None:
            return
        try:
            self.loop.guard.follows(setpoint, known, self.course.t(self.index))
        except MotionError as error:
            self._stop(error)

    def _write(self, setpoint: JointSetpoint) -> None:
        since = 0 if self.written_index is None else self.index - self.written_index
        try:
            self.loop.guard.check(setpoint, since * self.loop.period)
            self.loop.driver.write(setpoint)
        except LimitError as error:
            self._fail(_caused(MotionError(str(error)), error))
            self._hold()
            self.cut_off = True
        except BusError as error:
            # no word reaches the arm any more: what it does now is up to its own watchdog
            self._fail(_out_of_reach(error))
            self.cut_off = True
        else:
            self.last_t = self.course.t(self.index)
            self.written_index = self.index

    def _observe(self, cycle: Cycle) -> None:
        try:
            self.loop.observe(cycle)
        except Exception as error:  # noqa: BLE001 - whatever it is, the arm stops on its path
            self._stop(_caused(MotionError(f"who observes the loop failed: {error!r}"), error))

    def _hold(self) -> None:
        """Hold; an arm that cannot be told to is a fault, unless there is one already."""
        try:
            self.loop.driver.hold()
        except BusError as error:
            _log.warning("the arm could not be told to hold: %s", error)
            self._fail(_out_of_reach(error))

    def _fail(self, fault: MotionError, *, at_goal: bool = False) -> None:
        """Keep the first fault."""
        if self.fault is None:
            self.fault = fault
            self.reason = reason_of(fault, at_goal=at_goal)

    def _stop(self, fault: MotionError | None) -> None:
        """Let the motion end along its path, once."""
        if self.stopping:
            return
        if fault is not None:
            self._fail(fault)
        self.course.stop(self.index)
        why = "stop asked for" if fault is None else str(fault)
        motion = self.course.motion
        self.loop.announce(
            f"{why}: stopping along the path in {motion.duration:.2f} s, {joint_travel(motion)}"
        )

    def _may_end(self, setpoint: JointSetpoint, state: JointState | None) -> bool:
        """Tell whether the loop may end: stopped, arrived, or out of patience."""
        guard = self.loop.guard
        if self.stopping:
            return True
        if state is not None and guard.arrived(setpoint, state):
            return True
        t = self.course.t(self.index)
        over = t - self.course.motion.duration
        if state is None:
            return over >= float(np.max(guard.tolerances.settle))
        try:
            guard.require_arrival(setpoint, state, t, over)
        except MotionError as error:
            self._fail(error, at_goal=True)
            return True
        return False


def _caused(fault: MotionError, error: Exception) -> MotionError:
    fault.__cause__ = error
    return fault


def _out_of_reach(error: BusError) -> MotionError:
    """Give the fault of an arm that no word reaches any more."""
    return _caused(MotionError(f"the arm can no longer be told where to go: {error}"), error)
