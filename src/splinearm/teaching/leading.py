"""An arm in the hand: carried by its servos where they can, else without torque."""

from collections.abc import Callable

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.backends import Station, require_chain
from splinearm.config import Cell
from splinearm.control.realtime import real_time
from splinearm.control.stop import StopRequest
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusError, ConfigError, PortError, StaleFeedbackError
from splinearm.guiding import guide
from splinearm.joints import JointState

from .recording import Recording

_SILENCE = 0.5
"""Without a reading for so long, recording ends, s."""

_LATE = 1.2
"""A reading later than so many periods stands for those that were lost before it."""

Observe = Callable[[JointState | None], object]
"""Gets what was read in a cycle; None: nothing was."""


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
    limp: Callable[[], bool] | None = None,
    stop: StopRequest | None = None,
    rate: float = 100.0,
) -> FloatArray:
    """Let a hand lead an open arm until ``stop``, Ctrl-C or SIGTERM; then hold it.

    Args:
        station: The arm, open with its feed-forward.
        cell: What it is.
        observe: Gets every cycle, in the loop: it must be quick.
        limp: Without it servos carry the arm. With it they do not: whenever it gives True they have
            no torque and **a hand must support the arm**; else they hold it where it is.
        stop: Where somebody may ask for an end.
        rate: Cycles a second, Hz.

    Returns:
        Where the arm is held in the end, shape (n,), rad.

    Raises:
        ConfigError: If the arm is no arm of servos, or is to be carried and cannot be.
        StaleFeedbackError: If it did not answer any more; it holds.
        BusError: If it cannot be held.
    """
    if not isinstance(station.driver, ServoArm):
        raise ConfigError(cell.file, "", "only an arm of servos can be led by hand; name its port")
    if limp is None:
        bridge = max(round(_SILENCE * rate), 3)
        return guide(station, cell, stop=stop, rate=rate, observe=observe, bridge=bridge)
    return _lead_limp(station, observe, limp, stop, rate)


def _lead_limp(
    station: Station,
    observe: Observe,
    limp: Callable[[], bool],
    stop: StopRequest | None,
    rate: float,
) -> FloatArray:
    """Switch the torque off and on as it is wished; in the end, however it comes, hold."""
    driver, clock, period = station.driver, station.clock, 1.0 / rate
    is_limp, lost = False, 0
    with stop if stop is not None else StopRequest() as request, real_time():
        try:
            due = clock.now()
            while not request.requested:
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
                if limp() is not is_limp:
                    is_limp = not is_limp
                    driver.release() if is_limp else driver.hold()
        finally:
            if is_limp:
                driver.hold()
    return driver.goal


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

    lead(station, cell, keep, limp=None if carried else lambda: True, stop=stop, rate=rate)
    return tape.recording(cell.arm.joint_names, rate)
