"""From a job of pieces to steps that are all planned, before anything moves."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.config import Cell, Job, SavedMotion
from splinearm.config.piece import GripAction, Piece
from splinearm.errors import ConfigError, SplinearmError
from splinearm.runner import PlannedJob, limits_of, plan_job
from splinearm.stage import slow_way
from splinearm.trajectories.plan import Plan
from splinearm.trajectories.taught import TaughtMotion, plan_taught
from splinearm.trajectories.tool_path import carried_tool_path
from splinearm.trajectories.trajectory import JointTrajectory

from .step import PlannedSequence, Step, StepKind

_SAME = 1e-9
"""Places nearer than this are one, rad or m; so are times, s."""
_AT_REST = 1e-6
"""Slower than this share of its limit a joint rests."""


def is_sequence(job: Job) -> bool:
    """Tell whether a job is more than one motion."""
    return bool(job.pieces or job.grips or job.times != 1)


def plan_sequence(job: Job, cell: Cell) -> PlannedSequence:
    """Plan all steps of a job of pieces, or of any job with waypoints.

    Args:
        job: The job.
        cell: Its arm.

    Raises:
        UnreachableError: If a waypoint cannot be reached.
        ConfigError: With the piece, if it, job and arm do not go together.
        TrajectoryError: If a motion cannot be made.
    """
    if job.program is not None:
        raise ConfigError(job.file, "toolpath", "is no sequence; machining carries it out")
    if job.pieces:
        wanted = [step for i in range(len(job.pieces)) for step in _of_piece(job, cell, i)]
    else:
        wanted = _of_waypoints(_plain(job), job.grips, cell, job.title)
    steps: list[Step] = []
    here = job.q_start
    for step in wanted:
        if step.planned is not None:
            motion = step.planned.plan.trajectory
            if _differ(here, motion.q_start):
                steps.append(_way(job, cell, here, motion.q_start, f"to {step.name}"))
            here = motion.q_goal
        steps.append(step)
    back = None
    if job.times != 1 and _differ(here, job.q_start):
        back = _way(job, cell, here, job.q_start, "back to the begin")
    return PlannedSequence(job=job, cell=cell, steps=tuple(steps), back=back)


def _of_piece(job: Job, cell: Cell, number: int) -> list[Step]:
    """Give the steps of a piece, as often as it is to be done."""
    piece = job.pieces[number]
    try:
        once = _once(job, cell, piece)
    except ConfigError:
        raise
    except (SplinearmError, ValueError) as error:
        where = f"piece[{number}]"
        raise ConfigError(job.file, where, f"{error} (in {piece.name!r})") from error
    if piece.times == 1:
        return once
    steps: list[Step] = []
    for k in range(piece.times):
        turn = [replace(step, name=f"{step.name} ({k + 1} of {piece.times})") for step in once]
        steps += turn if k == 0 else _begun(job, cell, once, turn)
    return steps


def _begun(job: Job, cell: Cell, before: Sequence[Step], turn: Sequence[Step]) -> list[Step]:
    """Give a repetition, with the way to its begin if it ends elsewhere."""
    motions = [step.planned.plan.trajectory for step in before if step.planned is not None]
    if not motions or not _differ(motions[-1].q_goal, motions[0].q_start):
        return list(turn)
    way = _way(job, cell, motions[-1].q_goal, motions[0].q_start, f"to {turn[0].name}")
    return [way, *turn]


def _once(job: Job, cell: Cell, piece: Piece) -> list[Step]:
    content = piece.content
    if isinstance(content, GripAction):
        return [Step(name=piece.name, kind=StepKind.GRIPPER, grip=content)]
    if isinstance(content, TaughtMotion):
        plan = plan_taught(content, cell.arm, limits_of(job, cell), timing=job.timing or "recorded")
        return [_motion(job, cell, plan, piece.name)]
    if isinstance(content, SavedMotion):
        return [_motion(job, cell, _saved(content, job, cell), piece.name)]
    share = content.limits_share * job.limits_share
    inner = replace(_plain(content), limits_share=share)
    return _of_waypoints(inner, content.grips, cell, piece.name)


def _saved(saved: SavedMotion, job: Job, cell: Cell) -> Plan:
    """Give the plan of a saved motion, slower by the share of the limits that the job allows."""
    trajectory = saved.trajectory
    if job.limits_share < 1.0:
        trajectory = trajectory.scaled(job.limits_share)
    return Plan(trajectory, carried_tool_path(cell.arm, trajectory), np.empty(0))


def _of_waypoints(job: Job, grips: Mapping[int, GripAction], cell: Cell, name: str) -> list[Step]:
    """Give the motion of a job with waypoints, cut where the gripper does something."""
    plan = plan_job(job, cell).plan
    if not grips:
        return [_motion(job, cell, plan, name)]
    steps: list[Step] = []
    rest: JointTrajectory | None = plan.trajectory
    gone = 0.0
    for number in sorted(grips):
        t = float(plan.waypoint_times[number])
        place = job.waypoints[number].name or f"waypoint {number + 1}"
        if rest is not None and t - gone > _SAME:
            first, rest = _cut(rest, t - gone, job, number)
            gone = t
            steps.append(_motion(job, cell, replace(plan, trajectory=first), f"to {place}"))
        grip = grips[number]
        steps.append(Step(name=f"{grip.words} at {place}", kind=StepKind.GRIPPER, grip=grip))
    if rest is not None and rest.duration > _SAME:
        last = job.waypoints[-1].name or f"waypoint {len(job.waypoints)}"
        steps.append(_motion(job, cell, replace(plan, trajectory=rest), f"to {last}"))
    return steps


def _cut(
    motion: JointTrajectory, t: float, job: Job, waypoint: int
) -> tuple[JointTrajectory, JointTrajectory | None]:
    """Cut a motion where it rests."""
    if t >= motion.duration - _SAME:
        return motion, None
    if (np.abs(motion.at(t).qd) > _AT_REST * motion.limits.qd_max).any():
        raise ConfigError(
            job.file,
            f"waypoint[{waypoint}].gripper",
            "the arm does not rest there: a closed curve is passed without a stop; take closed out",
        )
    for k, start in enumerate(motion.starts):
        if abs(start - t) <= _SAME:
            after = motion.sections[k:]
            return (
                JointTrajectory(motion.sections[:k], motion.q_start, motion.limits),
                JointTrajectory(after, after[0].q_start, motion.limits),
            )
    return motion.split(t)


def _plain(job: Job) -> Job:
    """Give the motion of a job as a job of its own."""
    return replace(job, grips=MappingProxyType({}), pieces=(), times=1)


def _motion(job: Job, cell: Cell, plan: Plan, name: str) -> Step:
    planned = PlannedJob(replace(_plain(job), title=name), cell, plan)
    return Step(name=name, kind=StepKind.MOTION, planned=planned)


def _way(job: Job, cell: Cell, q_start: FloatArray, q_goal: FloatArray, name: str) -> Step:
    """Give the slow way between places."""
    trajectory = slow_way(cell, q_start, q_goal)
    plan = Plan(trajectory, carried_tool_path(cell.arm, trajectory), np.empty(0))
    return replace(_motion(job, cell, plan, name), kind=StepKind.TRANSITION)


def _differ(a: FloatArray, b: FloatArray) -> bool:
    return bool((np.abs(a - b) > _SAME).any())


def steps_of(planned: PlannedSequence) -> Iterator[tuple[Step, JointTrajectory]]:
    """Give each motion of a sequence once."""
    known: set[int] = set()
    for step in planned.every_step:
        if step.planned is None:
            continue
        trajectory = step.planned.plan.trajectory
        if id(trajectory) not in known:
            known.add(id(trajectory))
            yield step, trajectory
