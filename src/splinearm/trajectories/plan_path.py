"""Plans of one given way of the tool."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import UnreachableError
from splinearm.joints import JointLimits
from splinearm.kinematics import ik
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.pose import Pose

from . import branch_choice, stretch, task
from .leg import Leg, ToolWay, joint_legs
from .limit import MotionLimits
from .path import CartesianPath
from .place import Place
from .plan import Plan
from .resolve import Tolerance
from .section import Section
from .tool_path import ToolPath
from .trajectory import JointTrajectory

_THERE = 1e-9
"""Nearer than this to the start of a way, in m and rad, a tool is there."""


def plan_path(
    arm: Arm,
    path: CartesianPath,
    q_start: ArrayInput,
    *,
    limits: JointLimits | MotionLimits | None = None,
    position_tolerance: float = 2e-5,
    speed: float | None = None,
) -> Plan:
    """Plan the quickest motion along a way of the tool, from rest to rest.

    If the tool is not at the start of the way, a joint move leads there first, to the nearest
    configuration that can follow the whole way; the arm rests between both. If it is, the arm
    follows in the configuration in which it stands, or says that it would have to start in another.

    Args:
        arm: The arm.
        path: Where the tool shall go.
        q_start: Where the joints are, shape (n,), rad or m.
        limits: What the joints, or joints, torques and tool, may do; None: the arm's own limits
            of the joints.
        position_tolerance: How far the tool may be off its way, m; its orientation by what moves a
            point 0.1 m away by as much.
        speed: Highest speed of the tool on the way, m/s; None: as fast as the limits allow.

    Returns:
        The plan; its ``waypoint_times`` are those of ``path.waypoint_s``.

    Raises:
        UnreachableError: If the arm cannot get to the way or along it.
        CurveError: If the way is not smooth.
        LimitError: If ``q_start`` breaks a limit.
        ValueError: If an argument is wrong.
    """
    every = MotionLimits.of(arm, limits)
    arm = replace(arm, limits=every.joints)
    q = frozen_array(q_start, (arm.n,), "q_start")
    arm.limits.check(q)
    if not 0.0 < position_tolerance < inf:
        raise ValueError(f"position_tolerance: want a length above 0, got {position_tolerance}")
    if speed is not None and not 0.0 < speed < inf:
        raise ValueError(f"speed: want a number above 0 m/s, got {speed}")
    way = ToolWay(path, _places(path, inf if speed is None else speed))
    legs = _legs(arm, way, q, Tolerance(position=position_tolerance))
    sections, times = _sections(arm, legs, every)
    return Plan(
        JointTrajectory(tuple(sections), q, arm.limits),
        ToolPath(tuple(leg.tool for leg in legs), arm.fk(q)[:3, 3]),
        times,
        every,
    )


def _places(path: CartesianPath, speed: float) -> list[Place]:
    """Give the places of a way, each a waypoint of its own number."""
    inner = [f"place {i} of the path" for i in range(1, len(path.waypoint_s) - 1)]
    names = ["the start of the path", *inner, "the end of the path"]
    return [Place(name=name, waypoints=(i,), speed=speed) for i, name in enumerate(names)]


def _legs(arm: Arm, way: ToolWay, q: FloatArray, tolerance: Tolerance) -> list[Leg]:
    """Give the leg along the way, after that of a joint move to its start where one is needed."""
    begin = way.path.state(np.array([way.path.domain[0]]))
    position, orientation = task.errors(task.misses(arm, q[None], begin))
    if position[0] <= _THERE and orientation[0] <= _THERE:
        return stretch.follow(arm, [way], q, tolerance)
    q_begin, leg = _approached(arm, way, q, tolerance)
    ends = [Place(name="the start", q=q), Place(name=way.places[0].name, q=q_begin)]
    return [*joint_legs(arm, ends), leg]


def _approached(
    arm: Arm, way: ToolWay, q: FloatArray, tolerance: Tolerance
) -> tuple[FloatArray, Leg]:
    """Give where the joints begin to follow the way, and the leg along it."""
    begin = way.path.state(np.array([way.path.domain[0]]))
    target = begin.p[0] if begin.quat is None else Pose(begin.p[0], begin.quat[0])
    try:
        nearest = ik.solve(arm, target, q)
    except UnreachableError as error:
        place = way.places[0].name
        misses = error.position_error, error.orientation_error
        raise UnreachableError(*misses, error.joint, error.reason, place) from error
    nearest = task.correct(arm, nearest[None], begin).q[0]
    try:
        return nearest, way.leg(arm, nearest, tolerance)
    except UnreachableError as error:
        choice = branch_choice.choose(arm, [way.path], q)
        if choice.q is None:
            raise branch_choice.explained(arm, error, choice) from error
        other = task.correct(arm, choice.q[None], begin).q[0]
        try:
            return other, way.leg(arm, other, tolerance)
        except UnreachableError:
            raise branch_choice.explained(arm, error, branch_choice.NONE) from error


def _sections(
    arm: Arm, legs: Sequence[Leg], limits: MotionLimits
) -> tuple[list[Section], FloatArray]:
    """Give the parts from rest to rest, and when the places of the last leg are passed."""
    sections: list[Section] = []
    begun = t = 0.0
    times = np.zeros(len(legs[-1].places))
    for leg in legs:
        begun = t
        for section, passed in leg.sections(arm, limits):
            for number, after in passed:
                times[number] = t + after
            sections.append(section)
            t += section.duration
    times[0] = begun
    return sections, times
