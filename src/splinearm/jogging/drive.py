"""The loop of a jogged arm: read, wish, setpoint, guard, write, in each cycle, until it shall end.

Whatever goes wrong, the arm brakes along the way that was looked at before, then holds.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil
from typing import TYPE_CHECKING

from splinearm.control.clock import Clock
from splinearm.control.guard import Guard
from splinearm.control.hearing import Hearing
from splinearm.drivers.base import ArmDriver
from splinearm.errors import (
    BusError,
    LimitError,
    MotionError,
    ServoError,
    StaleFeedbackError,
)
from splinearm.joints import JointSetpoint, JointState

from .hindrance import Hindrance
from .stopway import Stopway
from .wish import Desk, Wish

if TYPE_CHECKING:
    from splinearm.drivers.gripper import Gripper

_log = logging.getLogger(__name__)

_FEWEST, _BRIDGED = 3, 0.02
"""So many cycles, or as many as take this time, s, are bridged."""
_SETTLED = 0.1
"""After a pause of so long, s, an arm stands where it was last sent."""
_TRIES = 5
"""After so many cycles in which a step gets nowhere it is given up."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class JogState:
    """What a jogged arm does in a cycle."""

    setpoint: JointSetpoint
    """What was sent; its time runs from the begin of the jogging."""
    state: JointState | None
    """What was measured before; None if no full answer came."""
    moving: bool
    """Whether the arm moves or is about to."""
    stepping: bool
    """Whether a step is under way."""
    hindrance: Hindrance | None
    """What keeps it from doing what is wished."""


@dataclass(slots=True, eq=False, kw_only=True)
class Drive:
    """One jogging under way."""

    driver: ArmDriver
    """The arm, entered."""
    clock: Clock
    """Its time."""
    guard: Guard
    """What every setpoint must pass."""
    stopway: Stopway
    """The setpoints to come."""
    desk: Desk
    """Where wishes lie."""
    period: float
    """Time between setpoints, s."""
    announce: Callable[[str], object]
    """Gets a line whenever a person should know."""
    gripper: "Gripper | None" = None
    """The arm's gripper."""
    grip: float | None = None
    """How far it shall open, percent; None: nothing is wished."""
    fault: MotionError | None = None
    """What ended the jogging."""
    _hearing: Hearing = field(init=False)
    _wish: Wish | None = None
    _until: float = 0.0
    _left: float = 0.0
    _stuck: int = 0
    _cut_off: bool = False

    def __post_init__(self) -> None:
        self._hearing = Hearing(self.driver, self.guard.limits.names, self.announce)

    @property
    def bridged(self) -> int:
        """How many cycles are bridged."""
        return max(_FEWEST, ceil(_BRIDGED / self.period - 1e-9))

    def to_end(self, ends: Callable[[], bool], tell: Callable[[JogState], object]) -> None:
        """Turn the loop until somebody wishes an end or a fault makes one, and the arm rests."""
        due = self.clock.now()
        while True:
            # what was missed is not made up for: then the arm is slower than planned, never faster
            due = max(due + self.period, self.clock.now())
            lateness = self.clock.wait_until(due)
            self._mind(lateness)
            state = self._read()
            over = self.fault is not None or ends()
            hindrance = None if over else self._move(due + lateness)
            setpoint = self.stopway.next()
            if not self._cut_off:
                self._write(setpoint)
            if self._cut_off:
                break
            self._judge(setpoint, state)
            moving = not self.stopway.rests
            now = JogState(
                setpoint=setpoint,
                state=state,
                moving=moving,
                stepping=self._wish is not None and self._wish.step,
                hindrance=hindrance,
            )
            self._tell(now, tell)
            if over and not moving:
                break
            if not moving:
                self._see_to_gripper()
        self._hold()

    def _mind(self, lateness: float) -> None:
        """Brake after a pause of this computer; end if the servos have stopped meanwhile.

        An arm that stands by now stays there: to brake along its way it would have to jump to the
        speed that it had.
        """
        if lateness <= self.bridged * self.period or self.stopway.rests:
            return
        if getattr(self.driver, "halted", False):
            self._fail(self._stale(lateness))
            self._cut_off = True
            return
        stands = lateness >= _SETTLED
        if stands:
            self.stopway.stand()
            self.guard = Guard(self.guard.limits, self.guard.tolerances)
        if stands or self._wish is not None:
            self._wish = None
            self.desk.brake()
            now = "stands" if stands else "brakes"
            self.announce(f"this computer was busy for {lateness * 1e3:.0f} ms: the arm {now}")

    def _read(self) -> JointState | None:
        try:
            state = self._hearing.read()
        except ServoError as error:
            self._fail(_caused(MotionError(str(error)), error))
            return None
        if self._hearing.lost > self.bridged:
            self._fail(self._stale(self._hearing.lost * self.period))
        return state

    def _stale(self, age: float) -> StaleFeedbackError:
        trouble = self._hearing.trouble
        cause = "the computer was busy; close other programs" if trouble is None else str(trouble)
        fault = StaleFeedbackError(age, self.bridged * self.period, cause)
        fault.__cause__ = trouble
        return fault

    def _move(self, now: float) -> Hindrance | None:
        """Let the setpoints to come be as is wished, as far as they can."""
        brake, fresh = self.desk.take()
        if brake:
            self._wish = None
        if fresh is not None:
            self._wish, self._until, self._left = fresh, now + fresh.lasts, fresh.lasts
        wish = self._wish
        if wish is None or (not wish.step and now > self._until):
            self._wish = None
            return None
        part = min(self.period, self._left) if wish.step else self.period
        if wish.frame is None:
            share, hindrance = self.stopway.move_joints(wish.rates * part)
        else:
            share, hindrance = self.stopway.move_tool(wish.rates * part, wish.frame)
        if wish.step:
            self._left -= share * part
            self._stuck = self._stuck + 1 if share == 0.0 and self.stopway.rests else 0
            if self._left <= 1e-9 or self._stuck > _TRIES:
                self._wish = None
        return hindrance

    def _judge(self, setpoint: JointSetpoint, state: JointState | None) -> None:
        """Brake if the arm does not follow."""
        known = state if state is not None else self._hearing.heard(setpoint)
        if known is None or self.fault is not None:
            return
        try:
            self.guard.follows(setpoint, known, setpoint.t)
        except MotionError as error:
            self._fail(error)

    def _write(self, setpoint: JointSetpoint) -> None:
        try:
            self.guard.check(setpoint, self.period)
            self.driver.write(setpoint)
        except LimitError as error:
            self._fail(_caused(MotionError(str(error)), error))
            self._cut_off = True
        except BusError as error:
            # no word reaches the arm any more: what it does now is up to its own watchdog
            self._fail(_out_of_reach(error))
            self._cut_off = True

    def _tell(self, now: JogState, tell: Callable[[JogState], object]) -> None:
        try:
            tell(now)
        except Exception as error:  # noqa: BLE001 - whatever it is, the arm brakes
            self._fail(_caused(MotionError(f"who observes the jogging failed: {error!r}"), error))

    def _see_to_gripper(self) -> None:
        """Open or close the gripper while the arm rests, and look after it."""
        gripper = self.gripper
        if gripper is None:
            return
        try:
            if self.grip is not None:
                percent, self.grip = self.grip, None
                gripper.send(percent)
            if gripper.ready:
                lost = gripper.watch(self.clock.now())
                if lost is not None:
                    self.announce(lost)
        except BusError as error:
            self.announce(str(error))

    def _hold(self) -> None:
        try:
            self.driver.hold()
        except BusError as error:
            _log.warning("the arm could not be told to hold: %s", error)
            self._fail(_out_of_reach(error))

    def _fail(self, fault: MotionError) -> None:
        """Keep the first fault; the arm brakes from here on."""
        if self.fault is None:
            self.fault = fault
            self.announce(f"{fault}: the arm brakes and holds")


def _caused(fault: MotionError, error: Exception) -> MotionError:
    fault.__cause__ = error
    return fault


def _out_of_reach(error: BusError) -> MotionError:
    return _caused(MotionError(f"the arm can no longer be told where to go: {error}"), error)
