"""An arm in the hand: carried by its servos where they can, else without torque."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.backends import Station, require_chain
from splinearm.config import Cell
from splinearm.control.clock import Clock
from splinearm.control.realtime import real_time
from splinearm.control.stop import StopRequest
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusError, ConfigError, MotionError, PortError, StaleFeedbackError
from splinearm.guiding import guide
from splinearm.joints import JointState

from .recording import Recording

_SILENCE = 0.5
"""Without a reading for so long, recording ends, s."""

_PATIENCE, _GLANCE = 20.0, 0.2
"""For how long, and how often, it is tried to take hold of an arm without torque, s: a person may
have to move a joint back first."""

_LATE = 1.2
"""A reading later than so many periods stands for those that were lost before it."""

Observe = Callable[[JointState | None], object]
"""Gets what was read in a cycle; None: nothing was."""


def _ignore(words: str) -> None:
    """Say nothing."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Limp:
    """How an arm is led that its servos do not carry."""

    wished: Callable[[], bool]
    """Whenever it gives True the arm has no torque and **a hand must support it**; else it holds
    where it is."""
    announce: Callable[[str], object] = _ignore
    """Gets a line when the arm cannot be held yet, and when it is."""


def is_carried(station: Station, cell: Cell) -> bool:
    """Tell whether the servos of an open arm carry its weight in the hand, unless told otherwise.

    They do if the arm's file says what it weighs and most of them measure their current: those give
    way easily. Others give way by their goals alone, and are stiffer.
    """
    ahead = station.feedforward
    leaders = require_chain(cell).leaders_of(cell.arm.joint_names)
    measure = sum(servo.servo_model.has_current for servo in leaders)
    return 2 * measure > len(leaders) and ahead is not None and ahead.knows_weight


def lead(
    station: Station,
    cell: Cell,
    observe: Observe,
    *,
    limp: Limp | None = None,
    stop: StopRequest | None = None,
    rate: float = 100.0,
) -> FloatArray:
    """Let a hand lead an open arm until ``stop``, Ctrl-C or SIGTERM; then hold it.

    Args:
        station: The arm, open with its feed-forward.
        cell: What it is.
        observe: Gets every cycle, in the loop: it must be quick.
        limp: Without it servos carry the arm; with it a hand must, whenever it is wished.
        stop: Where somebody may ask for an end.
        rate: Cycles a second, Hz.

    Returns:
        Where the arm is held in the end, shape (n,), rad.

    Raises:
        ConfigError: If the arm is no arm of servos, or is to be carried and cannot be.
        StaleFeedbackError: If it did not answer any more; it holds.
        MotionError: If an arm without torque cannot be held: a hand must go on supporting it.
        BusError: If the port is gone, or a servo is ill.
    """
    if not isinstance(station.driver, ServoArm):
        raise ConfigError(cell.file, "", "only an arm of servos can be led by hand; name its port")
    if limp is None:
        bridge = max(round(_SILENCE * rate), 3)
        return guide(station, cell, stop=stop, rate=rate, observe=observe, bridge=bridge)
    return _lead_limp(station.driver, station.clock, observe, limp, stop or StopRequest(), rate)


def _lead_limp(
    driver: ServoArm,
    clock: Clock,
    observe: Observe,
    limp: Limp,
    stop: StopRequest,
    rate: float,
) -> FloatArray:
    """Switch the torque off and on as it is wished; in the end, however it comes, hold."""
    period, is_limp, lost = 1.0 / rate, False, 0
    with stop, real_time():
        try:
            due = clock.now()
            while not stop.requested:
                due = max(due + period, clock.now())  # what was missed is not made up for
                clock.wait_until(due)
                try:
                    state = driver.read()
                    lost = 0
                except PortError:
                    raise
                except BusError as error:
                    state, lost = None, lost + 1
                    if lost * period > _SILENCE:
                        raise StaleFeedbackError(lost * period, _SILENCE, str(error)) from error
                observe(state)
                wished = limp.wished()
                if wished and not is_limp:
                    is_limp = True
                    driver.release()
                elif is_limp and not wished:
                    _take_hold(driver, clock, limp.announce)
                    is_limp = False
        finally:
            if is_limp:
                _take_hold(driver, clock, limp.announce)
    return driver.goal


def _take_hold(driver: ServoArm, clock: Clock, announce: Callable[[str], object]) -> None:
    """Switch the torque on; where that cannot be done say so, and try again for a while.

    Raises:
        MotionError: If it cannot be done.
    """
    until, troubled = clock.now() + _PATIENCE, False
    while True:
        try:
            driver.hold()
        except BusError as error:
            words = f"the arm is NOT HELD: keep supporting it; {error}"
            if clock.now() >= until or isinstance(error, PortError):
                raise MotionError(words) from error
            if not troubled:
                announce(words)
            troubled = True
            clock.wait_until(clock.now() + _GLANCE)
        else:
            if troubled:
                announce("the arm is held")
            return


class Tape:
    """What was read since a recording began."""

    def __init__(self) -> None:
        self._t: list[float] = []
        self._q: list[FloatArray] = []

    def __len__(self) -> int:
        return len(self._t)

    @property
    def duration(self) -> float:
        """How long it is by now, s."""
        return self._t[-1] - self._t[0] if self._t else 0.0

    def keep(self, state: JointState) -> None:
        """Keep a reading."""
        if not self._t or state.t > self._t[-1]:
            self._t.append(state.t)
            self._q.append(state.q)

    def recording(self, names: tuple[str, ...], rate: float) -> Recording:
        """Give it as a recording; readings that should have come between others are counted."""
        n, times = len(names), np.array(self._t, dtype=np.float64)
        return Recording(
            names=names,
            t=times,
            q=np.array(self._q, dtype=np.float64).reshape(-1, n),
            lost=int(np.maximum(np.round(np.diff(times) * rate - _LATE), 0.0).sum()),
        )


def record(
    station: Station,
    cell: Cell,
    *,
    carried: bool | None = None,
    supported: bool = False,
    stop: StopRequest | None = None,
    rate: float = 100.0,
) -> Recording:
    """Record while a hand leads the arm, until ``stop``, Ctrl-C or SIGTERM; then hold it.

    Args:
        station: The arm, open with its feed-forward.
        cell: What it is.
        carried: Whether its servos carry it; None: if ``is_carried`` says so.
        supported: That a hand supports the arm: its torque is then switched off where its servos
            cannot carry it.
        stop: Where another thread may ask for an end.
        rate: Samples a second, Hz.

    Raises:
        ConfigError: If servos do not carry the arm and nobody said that it is supported.
        StaleFeedbackError: If it did not answer any more; it holds.
    """
    carried = is_carried(station, cell) if carried is None else carried
    if not carried and not supported:
        raise ConfigError(
            cell.file,
            "",
            "its servos do not carry it in the hand; support it and say so (supported=True), then "
            "their torque goes off",
        )
    tape = Tape()

    def keep(state: JointState | None) -> None:
        if state is not None:
            tape.keep(state)

    limp = None if carried else Limp(wished=lambda: True)
    lead(station, cell, keep, limp=limp, stop=stop, rate=rate)
    return tape.recording(cell.arm.joint_names, rate)
