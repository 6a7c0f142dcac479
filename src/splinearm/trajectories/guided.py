"""Plans of ways of the tool whose joint positions are nearly known beforehand."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.kinematics.arm import Arm

from . import task
from .joint_path import JointPath
from .law_choice import CELLS
from .leg import Leg, ToolWay
from .limit import MotionLimits
from .plan import Plan
from .resolve import Nodes, Tolerance, resolve_near
from .section import Section
from .time_law import TimeLaw
from .tool_path import ToolPath
from .trajectory import JointTrajectory

_MANY = 50
"""Of more ways than that each one's law is sought on fewer cells, ..."""

_FEW_CELLS = 40
"""... on so many: two and a half times as quick to find, and a hundredth slower to run."""


@dataclass(frozen=True, slots=True, eq=False)
class GuidedWay:
    """A smooth way of the tool from rest to rest, and about where the joints are on it."""

    way: ToolWay
    """The way; its places' waypoints are numbers of the whole motion."""
    near: Nodes
    """About where the joints are."""
    rest: float = 0.0
    """How long the arm rests before it, s."""


def plan_guided(
    arm: Arm,
    ways: Sequence[GuidedWay],
    limits: MotionLimits,
    *,
    position_tolerance: float = 2e-5,
    rest: float = 0.0,
    progress: Callable[[float], object] | None = None,
) -> Plan:
    """Plan the quickest motion along ways of the tool, one after the other, from rest to rest.

    Args:
        arm: The arm.
        ways: At least one, each beginning where the one before it ends.
        limits: What joints, torques and tool may do.
        position_tolerance: How far the tool may be off its way, m.
        rest: How long the arm rests at the end, s.
        progress: Gets the share that is done, now and then.

    Returns:
        The plan; its ``waypoint_times`` are those of the waypoints of the ways' places.

    Raises:
        UnreachableError: If the arm cannot follow.
        ValueError: If the tolerance is no length above zero.
    """
    if not 0.0 < position_tolerance < inf:
        raise ValueError(f"position_tolerance: want a length above 0, got {position_tolerance}")
    tolerance = Tolerance(position=position_tolerance)
    sections, curves, times = list[Section](), list[ToolWay](), dict[int, float]()
    q, t = _corrected_start(arm, ways[0]), 0.0
    q_start = q
    cells = CELLS if len(ways) <= _MANY else _FEW_CELLS
    whole = sum(len(guided.near.s) for guided in ways)
    done = 0
    for guided in ways:
        leg = _leg(arm, guided, q, tolerance)
        if guided.rest > 0.0:
            sections.append(_still(q, guided.rest))
            t += guided.rest
        for number in guided.way.places[0].waypoints:
            times[number] = t
        for section, passed in leg.sections(arm, limits, cells):
            for number, after in passed:
                times[number] = t + after
            sections.append(section)
            t += section.duration
        curves.append(guided.way)
        q = leg.q_goal
        done += len(guided.near.s)
        if progress is not None:
            progress(done / whole)
    if rest > 0.0:
        sections.append(_still(q, rest))
    return Plan(
        JointTrajectory(tuple(sections), q_start, arm.limits),
        ToolPath(tuple(way.path for way in curves), arm.fk(q_start)[:3, 3]),
        np.array([times[i] for i in sorted(times)]),
        limits,
    )


def _corrected_start(arm: Arm, guided: GuidedWay) -> FloatArray:
    """Give where the joints are at the start of the first way."""
    near = guided.near
    start: FloatArray = task.correct(arm, near.q[:1], guided.way.path.state(near.s[:1])).q[0]
    return start


def _leg(arm: Arm, guided: GuidedWay, q: FloatArray, tolerance: Tolerance) -> Leg:
    """Give the way of the joints, from where the way before has ended."""
    way = guided.way
    near = Nodes(guided.near.s, np.vstack((q[None], guided.near.q[1:])))
    joints = resolve_near(arm, way.path, near, tolerance, way.labels)
    return Leg(joints, way.path, way.path.waypoint_s, way.places)


def _still(q: FloatArray, time: float) -> Section:
    path = JointPath(BSpline(np.array([0.0, 1.0]), q[None], 0))
    return Section(path, TimeLaw(np.zeros(1), np.zeros(1)), time)
