"""A job from its file to the end of its motion: plan, approach, follow, report, resume."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from splinearm.backends import Station
from splinearm.config import Cell, Job, SavedMotion
from splinearm.control.cycle import Cycle
from splinearm.control.document import run_document
from splinearm.control.ending import Ending, Outcome
from splinearm.control.forecast import StopForecast, forecast_stops
from splinearm.control.realtime import Footing
from splinearm.control.record import Recorder
from splinearm.control.report import LoopReport, TrackingReport, report_loop, report_tracking
from splinearm.control.servo_count import ServoCounter
from splinearm.control.stopped import StoppedMotion
from splinearm.errors import ConfigError, CurveError, UnreachableError
from splinearm.kinematics.dynamics import Dynamics
from splinearm.stage import Audience, on_stage
from splinearm.stage import tolerances_of as tolerances_of
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.plan import Plan, plan
from splinearm.trajectories.tool_path import carried_tool_path


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
    if job.pieces:
        raise ConfigError(job.file, "piece", "is a job of pieces, each with a plan; run it instead")
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
    _require_plain(planned.job)
    forecast = forecast_of(planned)
    audience = Audience(csv=csv, mcap=mcap, observe=observe)
    if announce is not None:
        audience = replace(audience, announce=announce)
    with on_stage(planned.job, planned.cell, station, audience) as stage:
        stage.say(forecast.words)
        ending = stage.approach(planned.plan.trajectory.q_start)
        counter = ServoCounter(station.driver, planned.cell.chain)
        if ending.outcome is Outcome.FINISHED:
            motion = stage.watched(stage.rows, *stage.watchers)
            ending = motion.carry_out(planned.plan.trajectory, stage.stop)
        else:
            ending = not_begun(ending, planned.plan)
    return RunResult(
        ending=ending,
        planned=planned,
        recorder=stage.rows,
        tracking=report_tracking(planned.cell.arm, planned.plan, stage.rows),
        loop=report_loop(stage.rows.cycles, stage.period, counter.counts()),
        forecast=forecast,
        footing=stage.footing,
    )


def _require_plain(job: Job) -> None:
    """Refuse a job of which a motion is not all."""
    if job.grips or job.times != 1:
        what = "waypoint" if job.grips else "motion.times"
        raise ConfigError(
            job.file, what, "is more than one motion; carry it out as splinearm.sequence does"
        )


def forecast_of(planned: PlannedJob) -> StopForecast:
    """Say how long and how far stops of a motion take, before it begins."""
    arm = planned.cell.arm
    return forecast_stops(planned.plan.trajectory, lambda q: arm.fk(q)[:, :3, 3])


def not_begun(ending: Ending, wanted: Plan) -> Ending:
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
