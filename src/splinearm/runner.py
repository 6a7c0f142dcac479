"""A job from its file to the end of its motion: plan, approach, follow, report, resume."""

import logging
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from splinearm.backends import Station
from splinearm.config import Cell, Job, SavedMotion
from splinearm.control.aside import Aside
from splinearm.control.clock import WallClock
from splinearm.control.cycle import Cycle
from splinearm.control.document import run_document
from splinearm.control.ending import Ending, ExitReason, Outcome
from splinearm.control.follow import Loop
from splinearm.control.forecast import StopForecast, forecast_stops
from splinearm.control.guard import Guard
from splinearm.control.mcap_log import McapLog
from splinearm.control.realtime import SPIN, Footing, real_time
from splinearm.control.record import Recorder
from splinearm.control.rehearsal import LASTS as REHEARSAL
from splinearm.control.rehearsal import RATES, UNSEEN_AMONG, UNSEEN_FIRST, WINDOWS, rehearse
from splinearm.control.report import LoopReport, TrackingReport, report_loop, report_tracking
from splinearm.control.servo_count import ServoCounter
from splinearm.control.stop import StopRequest
from splinearm.control.stopped import StoppedMotion
from splinearm.control.tolerance import Tolerances
from splinearm.errors import BusError, ConfigError, CurveError, MotionError, UnreachableError
from splinearm.kinematics.dynamics import Dynamics
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.plan import Plan, plan, plan_joint_move
from splinearm.trajectories.tool_path import carried_tool_path
from splinearm.units import DEG

_log = logging.getLogger(__name__)

APPROACH_SHARE = 0.3
"""Share of the speed limits that the way to the start takes."""

APPROACH_FROM = 0.2 * DEG
"""Nearer than this to its start an arm needs no approach, rad (m for a sliding joint)."""


@dataclass(frozen=True, slots=True, eq=False)
class PlannedJob:
    """A job whose motion is known."""

    job: Job
    """What the file says."""
    cell: Cell
    """The arm of the job."""
    plan: Plan
    """The motion."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RunResult:
    """A job that was carried out, or stopped."""

    ending: Ending
    """Whether it ran to its end, and if not, why and what remains."""
    planned: PlannedJob
    """What was wanted."""
    recorder: Recorder
    """What happened, without the approach."""
    tracking: TrackingReport
    """How far off it was."""
    loop: LoopReport
    """How well the loop kept its time."""
    forecast: StopForecast
    """How long and how far stops take, as was known before it began."""
    footing: Footing | None
    """What the system permitted; None for an arm whose time is its own."""

    @property
    def outcome(self) -> Outcome:
        """Whether it ran to its end."""
        return self.ending.outcome

    def document(self) -> dict[str, Any]:
        """Give the run as values that JSON knows."""
        tracking = self.tracking if self.recorder.cycles else None
        return run_document(self.ending, self.loop, tracking, self.forecast, self.footing)


def plan_job(job: Job, cell: Cell) -> PlannedJob:
    """Plan the motion of a job, within the share of the arm's limits that the job allows.

    Raises:
        UnreachableError: If a waypoint cannot be reached; its message begins with the file.
        ConfigError: If waypoints, arm and limits do not go together.
        TrajectoryError: If the motion cannot be made.
    """
    if job.program is not None:
        raise ConfigError(job.file, "toolpath", "has no waypoints to plan; run it instead")
    try:
        motion = plan(
            cell.arm,
            job.waypoints,
            job.q_start,
            limits=limits_of(job, cell),
            position_tolerance=job.position_tolerance,
            closed=job.closed,
        )
    except UnreachableError as error:
        raise UnreachableError(
            error.position_error,
            error.orientation_error,
            error.joint,
            error.reason,
            what=f"{job.file}: {error.what}",
        ) from error
    except CurveError as error:
        raise CurveError(str(error), f"{job.file}") from error
    except ValueError as error:
        # what the files say is right by itself, but does not go together
        raise ConfigError(job.file, "", str(error)) from error
    return PlannedJob(job, cell, motion)


def limits_of(job: Job, cell: Cell) -> MotionLimits:
    """Give what a job lets its arm do."""
    joints = cell.arm.limits.scaled(job.limits_share)
    if job.jerk_time is not None:
        joints = joints.with_jerk_time(job.jerk_time)
    dynamics = None
    if job.torque_share is not None:
        if joints.torque_max is None:
            raise ValueError("torque_percent: the arm's file says no torques (max_torque_nm)")
        joints = replace(joints, torque_max=joints.torque_max * job.torque_share)
        dynamics = Dynamics(cell.arm)
    return MotionLimits(
        joints=joints,
        dynamics=dynamics,
        arm=cell.arm,
        tool_acceleration=job.tool_acceleration,
    )


def plan_motion(saved: SavedMotion, cell: Cell, file: Path, rate: float = 100.0) -> PlannedJob:
    """Give a saved motion as a job whose plan is that motion.

    Args:
        saved: The motion.
        cell: The arm that shall move.
        file: Where the motion was read, for messages.
        rate: Setpoints a second, Hz.

    Raises:
        ConfigError: If the motion is for other joints.
    """
    trajectory = saved.trajectory
    if trajectory.limits.names != cell.arm.limits.names:
        raise ConfigError(
            file,
            "joints",
            f"is for {', '.join(trajectory.limits.names)}; the arm has "
            f"{', '.join(cell.arm.limits.names)}",
        )
    job = Job(
        name=file.stem,
        title=f"motion {file.name}",
        file=file,
        arm=cell.file,
        q_start=trajectory.q_start,
        waypoints=(),
        closed=False,
        limits_share=1.0,
        rate=rate,
        position_tolerance=0.0,
    )
    tool_path = carried_tool_path(cell.arm, trajectory)
    return PlannedJob(job, cell, Plan(trajectory, tool_path, np.empty(0)))


def run_job(
    planned: PlannedJob,
    station: Station,
    *,
    csv: Path | None = None,
    mcap: Path | None = None,
    observe: Callable[[Cycle], object] | None = None,
    announce: Callable[[str], object] | None = None,
) -> RunResult:
    """Carry out a job on an open arm; Ctrl-C slows it down along its path and holds.

    Args:
        planned: The job and its motion.
        station: The arm, open.
        csv: Where every cycle of the motion is written; must not be there yet.
        mcap: Where it is written for Foxglove and PlotJuggler, likewise.
        observe: Gets every cycle of the motion, a little later, in a thread beside the loop.
        announce: Gets one line whenever a person should know, in that thread.

    Raises:
        SplinearmError: See ``Recorder`` and ``Loop.follow``.
    """
    result = carry_out_job(planned, station, csv=csv, mcap=mcap, observe=observe, announce=announce)
    if result.ending.fault is not None:
        raise result.ending.fault
    return result


def carry_out_job(
    planned: PlannedJob,
    station: Station,
    *,
    csv: Path | None = None,
    mcap: Path | None = None,
    observe: Callable[[Cycle], object] | None = None,
    announce: Callable[[str], object] | None = None,
) -> RunResult:
    """Carry out a job as ``run_job`` does, but give a fault that stopped it with its result.

    Raises:
        SplinearmError: If the arm cannot move at all; see ``Recorder`` and ``Loop.follow``.
    """
    cell, wanted = planned.cell, planned.plan
    names = cell.arm.joint_names
    forecast = forecast_stops(wanted.trajectory, lambda q: cell.arm.fk(q)[:, :3, 3])
    with ExitStack() as stack:
        recorder = stack.enter_context(Recorder(names, cell.arm.limits.kinds, csv))
        keep: list[Callable[[Cycle], object]] = [recorder]
        if mcap is not None:
            keep.append(stack.enter_context(McapLog(names, mcap)))
        aside = stack.enter_context(Aside())
        stop = stack.enter_context(StopRequest())
        footing = stack.enter_context(_footing(station))
        if footing is not None and footing.fifo:
            aside.hurry()
        say = aside.later(announce if announce is not None else _log.info)
        if observe is not None:
            keep.append(aside.later(observe))
        period = _period(planned.job, station, footing, say)
        say(forecast.words)
        loop = Loop(
            driver=station.driver,
            clock=station.clock,
            guard=Guard(cell.arm.limits, tolerances_of(planned.job, cell)),
            period=period,
            announce=say,
        )
        ending = _approach(loop, wanted, cell, stop)
        counter = ServoCounter(station.driver, cell.chain)
        if ending.outcome is Outcome.FINISHED:
            motion = replace(loop, observe=lambda cycle: [one(cycle) for one in keep])
            ending = motion.carry_out(wanted.trajectory, stop)
        else:
            ending = _not_begun(ending, wanted)
    if aside.trouble is not None:
        raise aside.trouble
    return RunResult(
        ending=ending,
        planned=planned,
        recorder=recorder,
        tracking=report_tracking(cell.arm, wanted, recorder),
        loop=report_loop(recorder.cycles, period, counter.counts()),
        forecast=forecast,
        footing=footing,
    )


def _not_begun(ending: Ending, wanted: Plan) -> Ending:
    """Give the ending of a motion whose approach ended so: all of it remains."""
    stopped = StoppedMotion(wanted.trajectory, 0.0)
    if ending.fault is not None:
        ending.fault.stopped = stopped
    return replace(ending, stopped=stopped)


def resume(
    result: RunResult,
    station: Station,
    *,
    csv: Path | None = None,
    mcap: Path | None = None,
    observe: Callable[[Cycle], object] | None = None,
    announce: Callable[[str], object] | None = None,
) -> RunResult:
    """Carry out what remains of a job that was stopped, from where it rests on its path.

    An arm that is elsewhere by now approaches that place first. What stopped it must be over: see
    ``ServoArm.recover`` and ``ServoArm.reconnect``.

    Args:
        result: What the stopped run gave.
        station: The arm.
        csv: As for ``run_job``; a file of its own. So are the others.
        mcap: As for ``run_job``.
        observe: As for ``run_job``.
        announce: As for ``run_job``.

    Raises:
        ValueError: If that run was finished.
        SplinearmError: As for ``carry_out_job``.
    """
    if result.ending.stopped is None:
        raise ValueError("result: that motion was finished, nothing of it remains")
    rest = result.ending.stopped.remaining()
    planned = replace(result.planned, plan=replace(result.planned.plan, trajectory=rest))
    return carry_out_job(planned, station, csv=csv, mcap=mcap, observe=observe, announce=announce)


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


def _approach(loop: Loop, wanted: Plan, cell: Cell, stop: StopRequest) -> Ending:
    """Bring the arm to the start of the motion, slowly and announced."""
    held = loop.driver.goal
    away = np.abs(held - wanted.trajectory.q_start)
    if away.max() <= APPROACH_FROM:
        return Ending(outcome=Outcome.FINISHED, reason=ExitReason.SUCCESSFUL)
    limits = cell.arm.limits
    limits.check(held, tolerance=APPROACH_FROM)
    start = np.clip(held, limits.q_min, limits.q_max)  # by the rounding to ticks at the most
    way = plan_joint_move(limits.scaled(APPROACH_SHARE), start, wanted.trajectory.q_start)
    worst = int(np.argmax(away))
    loop.announce(
        f"the arm is not at the start (joint {limits.names[worst]!r} is off by "
        f"{away[worst] / DEG:.1f} deg): approaching in {way.duration:.1f} s; "
        f"{forecast_stops(way, lambda q: cell.arm.fk(q)[:, :3, 3]).words}"
    )
    return loop.carry_out(way, stop)
