"""An arm moved by wishes as they come: from keys, a gamepad, a program."""

import logging
import threading
from collections.abc import Callable
from contextlib import nullcontext, suppress
from types import TracebackType
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.backends import Station
from splinearm.config import Cell
from splinearm.control.clock import WallClock
from splinearm.control.guard import Guard
from splinearm.control.realtime import real_time
from splinearm.control.rehearsal import rehearse
from splinearm.control.stop import StopRequest
from splinearm.control.tolerance import Tolerances
from splinearm.errors import BusError, ConfigError, MotionError
from splinearm.guiding import TOOL_SPEED
from splinearm.joints import JointKind
from splinearm.kinematics.arm import Frame
from splinearm.units import DEG

from .bound import Bounds
from .drive import Drive, JogState
from .ramp import Ramp
from .stopway import Stopway
from .wish import Desk, Wish

_log = logging.getLogger(__name__)

JOINT_SPEED = 60.0 * DEG
"""No joint turns faster in jogging, rad/s, nor at more than half of what it may."""
_SHARE = 0.5
_NEAR = 0.2 * DEG
"""So far beyond a limit rounding to ticks may hold a joint, rad (m)."""
_REHEARSED = 0.1
"""For how long readings are tried in the begin, s."""
LASTS = 0.2
"""How long a wish counts if nothing else is said, s."""


class Jogger:
    """Moves an open arm as is wished, in a thread of its own, while its with-block lasts.

    A wish counts for a short time; who wants the arm to go on repeats it, at any rate and from any
    thread. When no new one comes, when the block is left and after any fault the arm brakes along
    its way within ``stop_time`` and holds with torque. Every setpoint keeps the limits of position,
    velocity, acceleration and jerk, and the tool does at most 250 mm/s, however the joints move.

    A gamepad, read with whatever library::

        with open_arm(cell, port) as station, Jogger(station, cell) as jogger:
            while not pad.button("start"):
                x, y, z = (0.1 * axis for axis in pad.axes[:3])  # m/s
                jogger.tool([x, y, z, 0.0, 0.0, 0.0], "tool")
                time.sleep(0.05)
                if jogger.state.hindrance:
                    print(jogger.state.hindrance.words)

    Args:
        station: The arm, open.
        cell: What it is.
        rate: Setpoints a second, Hz; fewer where a reading takes longer.
        stop: Where an end may be asked for; None: one of its own.
        observe: Gets every ``JogState``, in the loop: it must be quick.
        announce: Gets a line whenever a person should know, in the loop: likewise.

    Raises:
        ConfigError: If the arm is held outside its limits.
    """

    def __init__(
        self,
        station: Station,
        cell: Cell,
        *,
        rate: float = 100.0,
        stop: StopRequest | None = None,
        observe: Callable[[JogState], object] | None = None,
        announce: Callable[[str], object] = _log.info,
    ) -> None:
        if not 1.0 <= rate <= 2000.0:
            raise ValueError(f"rate: want 1 to 2000 setpoints a second, got {rate:g}")
        arm = cell.arm.compiled()
        period = _period(station, 1.0 / rate, announce)
        limits, driver = arm.limits, station.driver
        self.speeds = top_speeds(cell)
        """How fast the joints may be, shape (n,), rad/s or m/s."""
        ramp = Ramp.of(limits, self.speeds, period)
        bounds = Bounds(arm=arm, speeds=self.speeds, tool_speed=TOOL_SPEED, period=period)
        q = _within(cell, driver.goal)
        self.stop_time = ramp.duration
        """Within what time the setpoints rest once nothing more is wished, s."""
        self._n = arm.n
        self._station = station
        self._desk = Desk()
        self._stop = StopRequest() if stop is None else stop
        self._observe = observe
        self._stopway = Stopway(bounds, ramp, q)
        self._drive = Drive(
            driver=driver,
            clock=station.clock,
            guard=Guard(limits, Tolerances.usual(limits.kinds)),
            stopway=self._stopway,
            desk=self._desk,
            period=period,
            announce=announce,
            gripper=station.gripper,
        )
        self._state: JogState | None = None
        self._begun = threading.Event()
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run_aside, name="jogger", daemon=True)

    @property
    def state(self) -> JogState:
        """What the arm did in the last cycle.

        Raises:
            RuntimeError: Before the first one.
        """
        if self._state is None:
            raise RuntimeError("use the jogger in a with-block: nothing was sent yet")
        return self._state

    @property
    def ends(self) -> bool:
        """Whether it brakes for good or holds already, by a wish or a fault."""
        over = self._begun.is_set() and not self._thread.is_alive()
        return over or self._stop.requested or self.fault is not None

    @property
    def fault(self) -> MotionError | None:
        """What ended it, if it was a fault."""
        return self._drive.fault

    @property
    def has_gripper(self) -> bool:
        """Whether there is a gripper that moves."""
        return self._station.gripper is not None

    def joints(self, qd: ArrayInput, lasts: float = LASTS) -> None:
        """Wish that the joints move.

        Args:
            qd: Their speeds, shape (n,), rad/s or m/s. Where a joint, or the tool by them, would
                be too fast, all are slower.
            lasts: For how long, s, if no other wish comes.
        """
        self._lay(qd, self._n, None, lasts)

    def tool(self, twist: ArrayInput, frame: Frame = "base", lasts: float = LASTS) -> None:
        """Wish that the tool moves, straight and without turning unless that is wished.

        Args:
            twist: Its velocity, m/s, and its angular velocity about its own point, rad/s, shape
                (6,).
            frame: Along whose axes: "base" or "tool".
            lasts: For how long, s, if no other wish comes.
        """
        self._lay(twist, 6, _frame(frame), lasts)

    def step_joints(self, way: ArrayInput, duration: float) -> None:
        """Wish that the joints go a way, shape (n,), rad or m, in about a time, s.

        They go all of it unless a limit, another wish or ``brake`` ends it.
        """
        self._lay_step(way, self._n, None, duration)

    def step_tool(self, way: ArrayInput, duration: float, frame: Frame = "base") -> None:
        """Wish that the tool goes a way: translation, m, and turn, rad, shape (6,)."""
        self._lay_step(way, 6, _frame(frame), duration)

    def grip(self, percent: float) -> None:
        """Wish that the gripper opens so far, percent, as soon as the arm rests.

        Raises:
            ConfigError: If the arm has none that moves.
            ValueError: If it is not 0 to 100.
        """
        if not self.has_gripper:
            raise ConfigError("gripper", "", f"{self._station.where}: no gripper that moves")
        if not 0.0 <= percent <= 100.0:
            raise ValueError(f"percent: want 0 (closed) to 100 (open), got {percent}")
        self._desk.brake()
        self._drive.grip = percent

    def brake(self) -> None:
        """Wish that the arm brakes now; what was wished before is forgotten."""
        self._desk.brake()

    def end(self) -> None:
        """Wish that the arm brakes and holds for good."""
        self._stop.request()

    def run(self) -> FloatArray:
        """Jog in this thread, without a with-block, until an end is asked for.

        In the main thread Ctrl-C, SIGTERM and SIGHUP ask for one.

        Returns:
            Where the arm is held, shape (n,), rad or m.

        Raises:
            MotionError: After the arm was braked and holds: what went wrong.
        """
        clock = self._station.clock
        with real_time() if isinstance(clock, WallClock) else nullcontext(), self._stop as stop:
            self._drive.to_end(lambda: stop.requested, self._tell)
        if self._drive.fault is not None:
            raise self._drive.fault
        return self._station.driver.goal

    def __enter__(self) -> Self:
        self._thread.start()
        self._begun.wait()
        if self._error is not None and self._state is None:
            raise self._error
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Brake, hold, and raise what went wrong meanwhile."""
        self._stop.request()
        self._thread.join()
        if self._error is not None and error is None:
            raise self._error

    def _run_aside(self) -> None:
        try:
            self.run()
        except BaseException as error:  # noqa: BLE001 - it is raised where the block is left
            self._error = error
        finally:
            self._begun.set()

    def _tell(self, state: JogState) -> None:
        self._state = state
        if not self._begun.is_set():
            self._begun.set()
        if self._observe is not None:
            self._observe(state)

    def _lay(self, rates: ArrayInput, size: int, frame: Frame | None, lasts: float) -> None:
        if not 0.0 < lasts <= 10.0:
            raise ValueError(f"lasts: want above 0 and at most 10 s, got {lasts}")
        name = "qd" if frame is None else "twist"
        rates = frozen_array(rates, (size,), name)
        self._desk.lay(Wish(rates=rates, frame=frame, lasts=lasts))

    def _lay_step(self, way: ArrayInput, size: int, frame: Frame | None, duration: float) -> None:
        if not 0.0 < duration < np.inf:
            raise ValueError(f"duration: want a time above 0 s, got {duration}")
        rates = frozen_array(way, (size,), "way") / duration
        self._desk.lay(Wish(rates=rates, frame=frame, lasts=duration, step=True))


def _period(station: Station, wanted: float, announce: Callable[[str], object]) -> float:
    """Give the time between setpoints, s: as wanted, or as long as a reading takes."""
    if not isinstance(station.clock, WallClock):
        return wanted

    def read() -> None:
        with suppress(BusError):
            station.driver.read()

    tried = rehearse(station.clock, wanted, read, _REHEARSED)
    # wakings that are late only make the arm slower, so they do not count
    period = max(wanted, tried.shortest_period(0.0))
    if period > wanted:
        announce(
            f"{1.0 / period:.0f} setpoints a second, not {1.0 / wanted:g}: "
            f"a reading takes {np.median(tried.busy) * 1e3:.1f} ms"
        )
    return period


def top_speeds(cell: Cell) -> FloatArray:
    """Give how fast the joints of an arm may be in jogging, shape (n,), rad/s or m/s."""
    limits = cell.arm.limits
    slides = np.array([kind is JointKind.PRISMATIC for kind in limits.kinds])
    most: FloatArray = np.minimum(_SHARE * limits.qd_max, np.where(slides, TOOL_SPEED, JOINT_SPEED))
    return most


def _within(cell: Cell, held: FloatArray) -> FloatArray:
    """Give where an arm is held, within its limits but for rounding to ticks."""
    limits = cell.arm.limits
    q: FloatArray = np.clip(held, limits.q_min, limits.q_max)
    worst = int(np.argmax(np.abs(q - held)))
    if abs(q[worst] - held[worst]) > _NEAR:
        at, limit = (cell.to_file_units(values)[worst] for values in (held, q))
        raise ConfigError(
            cell.file,
            f"joint {limits.names[worst]}",
            f"the arm stands at {at:.1f} there, beyond the limit {limit:.1f}: switch it off and "
            "bring it back by hand, or calibrate it",
        )
    return q


def _frame(frame: str) -> Frame:
    if frame == "base":
        return "base"
    if frame == "tool":
        return "tool"
    raise ValueError(f"frame: want 'base' or 'tool', got {frame!r}")
