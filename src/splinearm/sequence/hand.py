"""What the gripper does while a sequence lasts: it moves, holds, and is looked after."""

import time
from dataclasses import dataclass, replace

from splinearm.config import Job
from splinearm.config.piece import GripAction
from splinearm.control.cycle import Cycle
from splinearm.control.ending import Ending, ExitReason, Outcome
from splinearm.control.stopped import StoppedMotion
from splinearm.drivers.gripper import Gripper, GripState
from splinearm.errors import (
    BusError,
    BusTimeoutError,
    ConfigError,
    MotionError,
    PacketError,
)
from splinearm.stage import Stage
from splinearm.trajectories.trajectory import JointTrajectory

_GLANCE = 0.02
"""Time between two looks while the arm waits, s."""
_LOOKS = 100
"""How often it is looked at most whether something was lost."""
_PATIENCE = 10
"""How often in a row the arm may be silent while it waits."""

_FINISHED = Ending(outcome=Outcome.FINISHED, reason=ExitReason.SUCCESSFUL)
_STOPPED = Ending(outcome=Outcome.STOPPED, reason=ExitReason.GOAL_TOLERANCE_VIOLATED)


@dataclass(slots=True, eq=False)
class Hand:
    """The gripper of an arm on stage; without one only waits are kept, which is said once."""

    stage: Stage
    gripper: Gripper | None
    must_hold: bool = False
    """Whether it shall hold something from now on."""
    trouble: MotionError | None = None
    """What made it ask for a stop."""
    _silent: int = 0

    def prepare(self, job: Job, actions: list[GripAction]) -> None:
        """Refuse before anything moves what the gripper could not do.

        Raises:
            ConfigError: With the number that is too much for it.
            BusError: If its servo is not ready.
        """
        if not actions:
            return
        gripper = self.gripper
        if gripper is None:
            where = self.stage.station.where
            self.stage.say(f"{where}: no gripper moves here; its waits are kept")
            return
        for action in actions:
            try:
                gripper.check(action.percent, action.force)
            except ValueError as error:
                raise ConfigError(job.file, "force_percent", f"{gripper.name}: {error}") from error

    def act(self, action: GripAction) -> tuple[Ending, GripState | None]:
        """Let the gripper do something while the arm holds."""
        gripper, state = self.gripper, None
        self.must_hold = False
        try:
            if gripper is not None:
                gripper.send(action.percent, action.force)
                ending, state = self._await(gripper)
                if ending is not None:
                    return ending, state
                self.stage.say(f"{gripper.name}: {state.words}")
                if action.must_hold and not state.holding:
                    return _failed(f"{gripper.name} holds nothing: it {state.words}"), state
                self.must_hold = action.must_hold
            return self._rest(action.wait), state
        except BusError as error:
            return _failed(f"the arm, waiting for its gripper: {error}", error), state

    def watch(self, _: Cycle) -> None:
        """Look after the gripper in a cycle; where that says so ask for a stop."""
        try:
            self._look()
        except BusError as error:
            self._give_up(f"the gripper: {error}", error)

    def judged(self, ending: Ending, motion: JointTrajectory) -> Ending:
        """Give how a motion ended, with what the gripper had to say."""
        if ending.outcome is Outcome.FINISHED:
            self._make_sure()
        if self.trouble is None or ending.fault is not None:
            return ending
        fault, self.trouble = self.trouble, None
        stopped = ending.stopped or StoppedMotion(motion, motion.duration)
        fault.stopped = stopped
        return replace(
            ending,
            outcome=Outcome.FAILED,
            reason=ExitReason.PATH_TOLERANCE_VIOLATED,
            fault=fault,
            stopped=stopped,
        )

    def _make_sure(self) -> None:
        """Look, while the arm holds, whether the gripper has lost what it held."""
        try:
            for _ in range(_LOOKS):
                if self.gripper is None or not self.gripper.in_doubt:
                    return
                self._pass()
                self._look()
        except BusError as error:
            self._give_up(f"the gripper: {error}", error)

    def _look(self) -> None:
        lost = None if self.gripper is None else self.gripper.watch(time.monotonic())
        if lost is None:
            return
        self.stage.say(lost)
        if self.must_hold:
            self._give_up(lost)

    def _give_up(self, words: str, cause: Exception | None = None) -> None:
        if self.trouble is None:
            self.trouble = MotionError(words)
            self.trouble.__cause__ = cause
            self.stage.stop.request()

    def _await(self, gripper: Gripper) -> tuple[Ending | None, GripState]:
        """Wait until the gripper stands; give an ending if that was not to be."""
        begun = time.monotonic()
        while True:
            state = gripper.look()
            if self.stage.stop.requested:
                gripper.hold()
                return _STOPPED, state
            if gripper.settled:
                return None, state
            gripper.require_going(state, state.t - begun)
            self._pass()

    def _rest(self, duration: float) -> Ending:
        """Let the arm wait."""
        clock = self.stage.station.clock
        until = clock.now() + duration
        while clock.now() < until:
            if self.stage.stop.requested:
                return _STOPPED
            self._pass()
            self._look()
            if self.trouble is not None:
                fault, self.trouble = self.trouble, None
                return Ending(
                    outcome=Outcome.FAILED,
                    reason=ExitReason.PATH_TOLERANCE_VIOLATED,
                    fault=fault,
                )
        return _FINISHED

    def _pass(self) -> None:
        """Let a moment pass, and see that the arm still holds."""
        station = self.stage.station
        station.clock.wait_until(station.clock.now() + _GLANCE)
        try:
            station.driver.read()
        except (BusTimeoutError, PacketError):
            self._silent += 1
            if self._silent > _PATIENCE:
                raise
        else:
            self._silent = 0


def _failed(words: str, cause: Exception | None = None) -> Ending:
    fault = MotionError(words)
    fault.__cause__ = cause
    return Ending(outcome=Outcome.FAILED, reason=ExitReason.PATH_TOLERANCE_VIOLATED, fault=fault)
