"""The loop: read, setpoint, guard, write, observe, each cycle, until the motion ends or is stopped.

Whatever goes wrong, the arm slows down along its path, then holds with torque; only then is the
error raised.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil

from splinearm.drivers.base import ArmDriver
from splinearm.errors import BusTimeoutError, PacketError
from splinearm.joints import JointState
from splinearm.trajectories.trajectory import JointTrajectory

from .clock import Clock
from .collector import collector_suspended
from .cycle import Cycle
from .ending import Ending
from .ending import Outcome as Outcome
from .guard import Guard
from .override import PaceRequest
from .run import Run
from .stop import StopRequest

_log = logging.getLogger(__name__)

_FEWEST = 3
_PATIENCE = 10
_BRIDGED = 0.02
"""So many cycles, or as many as take this time, s, the plan bridges if nothing else is said."""


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
    bridge: int | None = None
    """Cycles without feedback of a joint, or missed, that the plan may bridge; one more stops the
    arm. None: 3, or as many as take 20 ms."""
    observe: Callable[[Cycle], object] = _ignore
    """Gets every cycle after its setpoint was written; must not block. If it raises, the arm is
    stopped along its path."""
    announce: Callable[[str], object] = _log.info
    """Gets one line whenever the loop decides something a person should know."""

    def __post_init__(self) -> None:
        if not self.period > 0.0:
            raise ValueError(f"period: want a time above zero, got {self.period}")
        if self.bridge is not None and self.bridge < 0:
            raise ValueError(f"bridge: want 0 cycles or more, got {self.bridge}")

    @property
    def bridged(self) -> int:
        """How many cycles the plan bridges."""
        if self.bridge is not None:
            return self.bridge
        return max(_FEWEST, ceil(_BRIDGED / self.period - 1e-9))

    def follow(
        self,
        trajectory: JointTrajectory,
        stop: StopRequest | None = None,
        pace: PaceRequest | None = None,
    ) -> Outcome:
        """Carry out a motion; SIGINT, SIGTERM and SIGHUP stop the arm along its path.

        Args:
            trajectory: The motion; it starts where the arm stands, at rest.
            stop: Where another thread may ask for a stop; None: one of its own.
            pace: Where another thread may ask for another pace; None: it goes as planned.

        Raises:
            LimitError: Before anything moves, if the motion breaks a limit.
            StartError: Before anything moves, if the arm is elsewhere.
            BusError: Before anything moves, if the arm does not answer.
            MotionError: After the arm was stopped along its path, what made it stop; its
                ``stopped`` is the rest of the motion.
        """
        ending = self.carry_out(trajectory, stop, pace)
        if ending.fault is not None:
            raise ending.fault
        return ending.outcome

    def carry_out(
        self,
        trajectory: JointTrajectory,
        stop: StopRequest | None = None,
        pace: PaceRequest | None = None,
    ) -> Ending:
        """Carry out a motion as ``follow`` does, but give a fault that stopped it with its ending.

        Raises:
            LimitError: Before anything moves, and the other errors that ``follow`` raises then.
        """
        self.guard.admit(trajectory, self.period)
        self.guard.begin(trajectory, self._first_state(), self.driver.goal)
        trajectory.stop_from(0.5 * trajectory.duration)  # what stops need is known from here on
        with collector_suspended(), stop if stop is not None else StopRequest() as request:
            return Run(self, trajectory, request, pace).to_end()

    def _first_state(self) -> JointState:
        """Measure; an answer lost on a noisy line is asked for again."""
        for _ in range(max(self.bridged, _PATIENCE)):
            try:
                return self.driver.read()
            except (BusTimeoutError, PacketError):
                continue
        return self.driver.read()
