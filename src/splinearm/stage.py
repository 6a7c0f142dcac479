"""What a motion needs around it: a rate that is held, a way to stop, and who watches."""

import logging
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.backends import Station
from splinearm.config import Cell, Job
from splinearm.control.aside import Aside
from splinearm.control.clock import WallClock
from splinearm.control.cycle import Cycle
from splinearm.control.ending import Ending, ExitReason, Outcome
from splinearm.control.follow import Loop
from splinearm.control.forecast import forecast_stops
from splinearm.control.guard import Guard
from splinearm.control.mcap_log import McapLog
from splinearm.control.realtime import SPIN, Footing, real_time
from splinearm.control.record import Recorder
from splinearm.control.rehearsal import LASTS as REHEARSAL
from splinearm.control.rehearsal import RATES, UNSEEN_AMONG, UNSEEN_FIRST, WINDOWS, rehearse
from splinearm.control.stop import StopRequest
from splinearm.control.tolerance import Tolerances
from splinearm.errors import BusError, MotionError
from splinearm.trajectories.plan import plan_joint_move
from splinearm.trajectories.trajectory import JointTrajectory
from splinearm.units import DEG

_log = logging.getLogger(__name__)

APPROACH_SHARE = 0.3
"""Share of the speed limits that the way to the start takes."""

APPROACH_FROM = 0.2 * DEG
"""Nearer than this to its start an arm needs no approach, rad (m for a sliding joint)."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Stage:
    """An arm and all that its motions need, while they last."""

    station: Station
    """The arm, open."""
    cell: Cell
    """What its file says."""
    stop: StopRequest
    """Where a stop is asked for."""
    say: Callable[[str], object]
    """Gets one line whenever a person should know; returns at once."""
    loop: Loop
    """What follows a motion."""
    footing: Footing | None
    """What the system permitted; None for an arm whose time is its own."""
    rows: Recorder
    """Keeps every cycle, and writes it to a CSV file if there shall be one."""
    watchers: tuple[Callable[[Cycle], object], ...] = field(default=())
    """Get every cycle besides."""
    later: Callable[[Callable[[Any], object]], Callable[[Any], None]]
    """Gives a function that leaves a call of another for the thread beside the loop."""

    @property
    def period(self) -> float:
        """Time between setpoints, s."""
        return self.loop.period

    def watched(self, *watchers: Callable[[Cycle], object]) -> Loop:
        """Give a loop whose every cycle goes to these, in their order."""
        return replace(self.loop, observe=lambda cycle: [one(cycle) for one in watchers])

    def approach(self, q: FloatArray) -> Ending:
        """Bring the arm to where a motion starts, slowly and announced."""
        return _approach(self.loop, q, self.cell, self.stop)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Audience:
    """Who and what is told of every cycle."""

    csv: Path | None = None
    """Where it is written; must not be there yet."""
    mcap: Path | None = None
    """Where it is written for Foxglove and PlotJuggler, likewise."""
    observe: Callable[[Cycle], object] | None = None
    """Gets it, a little later, in a thread beside the loop."""
    announce: Callable[[str], object] = _log.info
    """Gets one line whenever a person should know, in that thread."""


@contextmanager
def on_stage(job: Job, cell: Cell, station: Station, audience: Audience) -> Iterator[Stage]:
    """Make all ready that the motions of a job need; Ctrl-C asks for a stop from here on.

    Args:
        job: The job.
        cell: Its arm.
        station: The arm, open.
        audience: Who is told.

    Raises:
        SplinearmError: If a file cannot be written, or this computer holds no rate that makes
            sense; in the end, what failed in that thread.
    """
    names, kinds = cell.arm.joint_names, cell.arm.limits.kinds
    with ExitStack() as stack:
        rows = stack.enter_context(Recorder(names, kinds, audience.csv))
        watchers: list[Callable[[Cycle], object]] = []
        if audience.mcap is not None:
            watchers.append(stack.enter_context(McapLog(names, audience.mcap)))
        aside = stack.enter_context(Aside())
        stop = stack.enter_context(StopRequest())
        footing = stack.enter_context(_footing(station))
        if footing is not None and footing.fifo:
            aside.hurry()
        say = aside.later(audience.announce)
        if audience.observe is not None:
            watchers.append(aside.later(audience.observe))
        loop = Loop(
            driver=station.driver,
            clock=station.clock,
            guard=Guard(cell.arm.limits, tolerances_of(job, cell)),
            period=_period(job, station, footing, say),
            announce=say,
        )
        yield Stage(
            station=station,
            cell=cell,
            stop=stop,
            say=say,
            loop=loop,
            footing=footing,
            rows=rows,
            watchers=tuple(watchers),
            later=aside.later,
        )
    if aside.trouble is not None:
        raise aside.trouble


def tolerances_of(job: Job, cell: Cell) -> Tolerances:
    """Give how far the arm may be off: as the job says, else as usual."""
    return replace(Tolerances.usual(cell.arm.limits.kinds), **job.tolerances)


@contextmanager
def _footing(station: Station) -> Iterator[Footing | None]:
    """Let an arm that lives by the wall clock have its setpoints on time, as far as permitted."""
    clock = station.clock
    if not isinstance(clock, WallClock):
        yield None
        return
    with real_time() as footing:
        clock.spin = SPIN if footing.fifo else 0.0
        try:
            yield footing
        finally:
            clock.spin = 0.0


def _period(
    job: Job, station: Station, footing: Footing | None, say: Callable[[str], object]
) -> float:
    """Give the time between setpoints: of the job, or the shortest that can be held.

    Raises:
        MotionError: If none can be held that makes sense.
    """
    period = 1.0 / job.rate
    if footing is None:
        return period

    def read() -> None:
        with suppress(BusError):
            station.driver.read()

    windows = 1 if footing.fifo else WINDOWS
    tried = rehearse(station.clock, min(period, 1.0 / RATES[-1]), read, REHEARSAL, windows)
    rate = tried.rate(job.rate, UNSEEN_FIRST if footing.fifo else UNSEEN_AMONG)
    late = f"up to {tried.lateness.max() * 1e3:.1f} ms late when the arm rests"
    if rate is None:
        raise MotionError(
            f"this computer cannot hold {RATES[-1]} setpoints a second ({late}, "
            f"{np.median(tried.busy) * 1e3:.1f} ms for a reading); close other programs; "
            f"{footing.words}"
        )
    if not footing.fifo:
        say(f"{late}; {footing.words}")
    if rate < job.rate:
        say(
            f"going at {rate:g} setpoints a second, not {job.rate:g}: {late}, a reading takes "
            f"{np.median(tried.busy) * 1e3:.2f} ms; the path stays the same"
        )
    return 1.0 / rate


def _approach(loop: Loop, q: FloatArray, cell: Cell, stop: StopRequest) -> Ending:
    """Bring the arm to a place, slowly and announced."""
    held = loop.driver.goal
    away = np.abs(held - q)
    if away.max() <= APPROACH_FROM:
        return Ending(outcome=Outcome.FINISHED, reason=ExitReason.SUCCESSFUL)
    limits = cell.arm.limits
    limits.check(held, tolerance=APPROACH_FROM)
    start = np.clip(held, limits.q_min, limits.q_max)  # by the rounding to ticks at the most
    way = slow_way(cell, start, q)
    worst = int(np.argmax(away))
    loop.announce(
        f"the arm is not at the start (joint {limits.names[worst]!r} is off by "
        f"{away[worst] / DEG:.1f} deg): approaching in {way.duration:.1f} s; "
        f"{forecast_stops(way, lambda q: cell.arm.fk(q)[:, :3, 3]).words}"
    )
    return loop.carry_out(way, stop)


def slow_way(cell: Cell, q_start: FloatArray, q_goal: FloatArray) -> JointTrajectory:
    """Give the slow way from one place to another, of joints that begin and end together."""
    return plan_joint_move(cell.arm.limits.scaled(APPROACH_SHARE), q_start, q_goal)
