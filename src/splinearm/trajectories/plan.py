"""Plans: from waypoints to a motion of the joints in time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.bspline import BSpline
from splinearm.curves.nearest import SpaceCurve
from splinearm.joints import JointLimits
from splinearm.kinematics.arm import Arm

from . import peak, place, stretch
from .joint_path import JointPath
from .law_choice import quickest_law
from .leg import Leg, spline_way, straight_path
from .limit import MotionLimits
from .peak import Binding as Binding
from .peak import LimitPeak as LimitPeak
from .place import Place, Start
from .resolve import Tolerance
from .section import Section
from .time_law import TimeLaw
from .tool_path import ToolPath
from .trajectory import JointTrajectory
from .waypoint import Move, Waypoint


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A motion and what it is to do."""

    trajectory: JointTrajectory
    """The motion of the joints."""
    tool_path: ToolPath
    """Where the tool shall go."""
    waypoint_times: FloatArray
    """When each waypoint is passed, or reached where the arm rests, shape (m,), s."""
    limits: MotionLimits | None = None
    """What the motion was planned within; None: only the limits of its joints are known."""

    def peaks(self) -> tuple[LimitPeak, ...]:
        """Give where each joint comes nearest to each of its limits."""
        return peak.peaks(self.trajectory, self.limits)

    def bindings(self) -> tuple[Binding, ...]:
        """Give which limit of joint or tool holds the motion back when."""
        return peak.bindings(self.trajectory, self.limits)


def plan(
    arm: Arm,
    waypoints: Sequence[Waypoint],
    q_start: ArrayInput,
    *,
    limits: JointLimits | MotionLimits | None = None,
    position_tolerance: float = 2e-5,
    closed: bool = False,
) -> Plan:
    """Plan the quickest motion through waypoints.

    The motion begins at rest at ``q_start`` and ends at rest. A run of B-spline moves is one C2
    curve from where the tool is through the waypoints of the run; a run of lines and arcs, or of
    joint moves, goes from place to place. The arm rests between runs of different moves, at corners
    without a blend, and where a waypoint asks for it. Waypoints that repeat the place before them
    are one with it.

    With ``closed`` the motion returns to where it began. If all moves are B-splines the curve is
    closed: the tool passes its start, where it begins and ends at rest, as smoothly as any
    waypoint. Otherwise a move of the last kind leads back. The way back has the speed of the last
    waypoint; on a closed curve that of a waypoint at the start, if there is one.

    A waypoint of joint positions asks in tool moves for the place where they carry the tool.
    Positions, velocities and accelerations of the joints stay within the limits at every moment,
    and so does the tool's speed where waypoints say one. If the limits have a jerk, acceleration
    never jumps and begins and ends at zero. Torques and accelerations of the tool are looked at if
    the limits are ``MotionLimits`` that say so.

    Args:
        arm: The arm.
        waypoints: At least one.
        q_start: Where the joints are, shape (n,), rad or m.
        limits: What the joints, or joints, torques and tool, may do; None: the arm's own limits
            of the joints.
        position_tolerance: How far the tool may be off its wanted way, m; its orientation by what
            moves a point 0.1 m away by as much.
        closed: Whether to return to the start.

    Raises:
        UnreachableError: If the arm cannot get to a waypoint or along the way to it.
        CurveError: If the waypoints make no such way.
        LimitError: If ``q_start`` or joint positions of a waypoint break a limit.
        ValueError: If an argument is wrong: runs that mix poses and positions, or limits of
            other joints.
    """
    every = MotionLimits.of(arm, limits)
    arm = replace(arm, limits=every.joints)
    q = _checked_start(arm, waypoints, q_start)
    if not 0.0 < position_tolerance < inf:
        raise ValueError(f"position_tolerance: want a length above 0, got {position_tolerance}")
    motion = _Motion(arm, every, q, Tolerance(position=position_tolerance))
    if closed and all(waypoint.move is Move.BSPLINE for waypoint in waypoints):
        motion.add_closed_figure(waypoints)
    else:
        motion.add_runs([*waypoints, _way_back(waypoints, q)] if closed else waypoints)
    return Plan(
        JointTrajectory(tuple(motion.sections), q, arm.limits),
        ToolPath(tuple(motion.curves), arm.fk(q)[:3, 3]),
        np.array([motion.times[i] for i in range(len(waypoints))]),
        every,
    )


def plan_joint_move(
    limits: JointLimits, q_start: ArrayInput, q_goal: ArrayInput
) -> JointTrajectory:
    """Plan the quickest straight motion in joint space, from rest to rest.

    All joints begin and end together.

    Args:
        limits: What the joints may do.
        q_start: Where they are, shape (n,), rad or m.
        q_goal: Where they shall be, shape (n,).

    Raises:
        LimitError: If one of these is beyond a limit of position.
        ValueError: If shapes or numbers are wrong.
    """
    start = frozen_array(q_start, (limits.n,), "q_start")
    goal = frozen_array(q_goal, (limits.n,), "q_goal")
    limits.check(start)
    limits.check(goal)
    if (start == goal).all():
        return JointTrajectory((), start, limits)
    path = straight_path(start, goal)
    return JointTrajectory((Section(path, quickest_law(path, limits)),), start, limits)


class _Motion:
    """A motion as it grows, leg by leg."""

    def __init__(self, arm: Arm, limits: MotionLimits, q: FloatArray, tolerance: Tolerance) -> None:
        self.arm = arm
        self.limits = limits
        self.q = q
        self.tolerance = tolerance
        self.t = 0.0
        self.sections: list[Section] = []
        self.curves: list[SpaceCurve] = []
        self.times: dict[int, float] = {}

    def add_runs(self, waypoints: Sequence[Waypoint]) -> None:
        """Add all runs of equal moves."""
        here = Start(self.q, "the start")
        for places, legs in stretch.run_legs(self.arm, waypoints, here, self.tolerance):
            self._rest(places[0])
            for leg in legs:
                self._add(leg)

    def add_closed_figure(self, waypoints: Sequence[Waypoint]) -> None:
        """Add one closed curve through the start and all waypoints."""
        numbers = range(len(waypoints))
        places = place.tool_run(self.arm, waypoints, numbers, Start(self.q, "the start"))
        first = places[0]
        self._rest(first)
        if len(places) == 1:
            return
        if places[-1].is_same(first):
            closing = places.pop()
        else:
            speed = first.speed if first.waypoints else places[-1].speed
            closing = replace(first, name="the start", waypoints=(), speed=speed, dwell=0.0)
        way = spline_way(self.arm, places, self.q, closing)
        self._add(stretch.follow(self.arm, [way], self.q, self.tolerance)[0])

    def _rest(self, at: Place) -> None:
        """Pass the waypoints that are where the arm already rests."""
        for number in at.waypoints:
            self.times[number] = self.t
        if at.dwell > 0.0:
            still = JointPath(BSpline(np.array([0.0, 1.0]), self.q[None], 0))
            self._append(Section(still, TimeLaw(np.zeros(1), np.zeros(1)), at.dwell))

    def _add(self, leg: Leg) -> None:
        for section, passed in leg.sections(self.arm, self.limits):
            for number, t in passed:
                self.times[number] = self.t + t
            self._append(section)
        self.curves.append(leg.tool)
        self.q = leg.q_goal

    def _append(self, section: Section) -> None:
        self.sections.append(section)
        self.t += section.duration


def _way_back(waypoints: Sequence[Waypoint], q: FloatArray) -> Waypoint:
    last = waypoints[-1]
    move = Move.LINE if last.move is Move.ARC else last.move
    return Waypoint(q=q, move=move, speed=last.speed, name="the start")


def _checked_start(arm: Arm, waypoints: Sequence[Waypoint], q_start: ArrayInput) -> FloatArray:
    """Give the start after looking at all joint positions that were given."""
    if len(waypoints) == 0:
        raise ValueError("waypoints: want at least one, got none")
    q = frozen_array(q_start, (arm.n,), "q_start")
    arm.limits.check(q)
    for i, waypoint in enumerate(waypoints):
        if waypoint.q is None:
            continue
        if waypoint.q.shape != (arm.n,):
            raise ValueError(
                f"{place.name_of(i, waypoint)}: want {arm.n} joint positions, got {waypoint.q.size}"
            )
        arm.limits.check(waypoint.q)
    return q
