"""A job from its file to the end of its motion: plan, approach, follow, report."""

import logging
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from splinearm.backends import Station
from splinearm.config import Cell, Job, SavedMotion
from splinearm.control.follow import Loop, Outcome
from splinearm.control.guard import Guard, Tolerances
from splinearm.control.mcap_log import McapLog
from splinearm.control.record import Cycle, Recorder
from splinearm.control.report import LoopReport, TrackingReport, report_loop, report_tracking
from splinearm.control.stop import StopRequest
from splinearm.errors import ConfigError, CurveError, UnreachableError
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

    outcome: Outcome
    """Whether it ran to its end."""
    planned: PlannedJob
    """What was wanted."""
    recorder: Recorder
    """What happened, without the approach."""
    tracking: TrackingReport
    """How far off it was."""
    loop: LoopReport
    """How well the loop kept its time."""


def plan_job(job: Job, cell: Cell) -> PlannedJob:
    """Plan the motion of a job, within the share of the arm's limits that the job allows.

    Raises:
        UnreachableError: If a waypoint cannot be reached; its message begins with the file.
        ConfigError: If waypoints, arm and limits do not go together.
        TrajectoryError: If the motion cannot be made.
    """
    try:
        motion = plan(
            cell.arm,
            job.waypoints,
            job.q_start,
            limits=_limits(job, cell),
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


def _limits(job: Job, cell: Cell) -> MotionLimits:
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
        observe: Gets every cycle of the motion.
        announce: Gets one line whenever a person should know.

    Raises:
        SplinearmError: See ``Recorder`` and ``Loop.follow``.
    """
    cell, wanted = planned.cell, planned.plan
    say = announce if announce is not None else _log.info
    guard = Guard(cell.arm.limits, Tolerances())
    recorder = Recorder(cell.arm.joint_names, cell.arm.limits.kinds, csv)

    log = nullcontext(None) if mcap is None else McapLog(cell.arm.joint_names, mcap)

    def keep(cycle: Cycle) -> None:
        recorder(cycle)
        if isinstance(log, McapLog):
            log(cycle)
        if observe is not None:
            observe(cycle)

    period = 1.0 / planned.job.rate
    approach = Loop(
        driver=station.driver, clock=station.clock, guard=guard, period=period, announce=say
    )
    motion = Loop(
        driver=station.driver,
        clock=station.clock,
        guard=guard,
        period=period,
        observe=keep,
        announce=say,
    )
    with recorder, log, StopRequest() as stop:
        outcome = _approach(approach, wanted, cell, say, stop)
        if outcome is Outcome.FINISHED:
            outcome = motion.follow(wanted.trajectory, stop)
    return RunResult(
        outcome=outcome,
        planned=planned,
        recorder=recorder,
        tracking=report_tracking(cell.arm, wanted, recorder),
        loop=report_loop(recorder.cycles, period),
    )


def _approach(
    loop: Loop, wanted: Plan, cell: Cell, say: Callable[[str], object], stop: StopRequest
) -> Outcome:
    """Bring the arm to the start of the motion, slowly and announced."""
    held = loop.driver.goal
    away = np.abs(held - wanted.trajectory.q_start)
    if away.max() <= APPROACH_FROM:
        return Outcome.FINISHED
    limits = cell.arm.limits
    limits.check(held, tolerance=APPROACH_FROM)
    start = np.clip(held, limits.q_min, limits.q_max)  # by the rounding to ticks at the most
    way = plan_joint_move(limits.scaled(APPROACH_SHARE), start, wanted.trajectory.q_start)
    worst = int(np.argmax(away))
    say(
        f"the arm is not at the start (joint {limits.names[worst]!r} is off by "
        f"{away[worst] / DEG:.1f} deg): approaching in {way.duration:.1f} s"
    )
    return loop.follow(way, stop)
