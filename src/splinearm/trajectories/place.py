"""Waypoints turned into places: one kind of place a run, no two neighbours the same."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from math import inf
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.segment import Arc, Line, Segment
from splinearm.errors import CurveError, UnreachableError
from splinearm.kinematics import ik, quaternion
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.pose import Pose

from .path import ToolPlaces
from .waypoint import ArcAbout, ArcThrough, Facing, Move, Waypoint

_SAME_POSITION = 1e-9
"""Nearer than this, in m, two positions are one."""

_SAME_ANGLE = 1e-9
"""Nearer than this, in rad, two orientations are one, and two positions of a joint."""

_FULL = 6
"""An arm of fewer joints cannot turn its tool as it likes."""


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where a run begins."""

    q: FloatArray
    """Joint positions, shape (n,)."""
    name: str
    """What messages call it."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Place:
    """Where a run goes through, and what waypoints ask for there."""

    name: str
    """What messages call it."""
    p: FloatArray | None = None
    """Position of the tool, shape (3,), m; None in joint moves."""
    quat: FloatArray | None = None
    """Orientation of the tool, shape (4,); None where it is free and in joint moves."""
    q: FloatArray | None = None
    """Joint positions, shape (n,), in joint moves."""
    arc: ArcThrough | ArcAbout | None = None
    """The arc that leads here; None: another way does."""
    waypoints: tuple[int, ...] = ()
    """The waypoints that are this place."""
    speed: float = inf
    """Highest speed of the tool on the way here, m/s."""
    blend: float = 0.0
    """How near the tool may begin to round the corner, m."""
    stops: bool = False
    """Whether the arm rests here."""
    dwell: float = 0.0
    """How long, s."""

    def is_same(self, other: "Place") -> bool:
        """Tell whether no motion leads from one to the other, which follows."""
        if other.arc is not None:
            return False
        if self.q is not None and other.q is not None:
            return bool(np.abs(self.q - other.q).max() <= _SAME_ANGLE)
        if self.p is None or other.p is None:
            return False
        if np.abs(self.p - other.p).max() > _SAME_POSITION:
            return False
        if self.quat is None or other.quat is None:
            return True
        return bool(quaternion.angle_between(self.quat, other.quat) <= _SAME_ANGLE)

    def merged(self, other: "Place") -> "Place":
        """Give this place with what another that is the same asks for as well."""
        return replace(
            self,
            name=self.name if self.waypoints else other.name,
            waypoints=self.waypoints + other.waypoints,
            speed=self.speed if self.waypoints else other.speed,
            blend=min(self.blend, other.blend) if self.waypoints else other.blend,
            stops=self.stops or other.stops,
            dwell=self.dwell + other.dwell,
        )


def name_of(index: int, waypoint: Waypoint) -> str:
    """Give what messages call a waypoint, counting from 1."""
    return f"waypoint {index + 1}" + (f" {waypoint.name!r}" if waypoint.name else "")


class Run(NamedTuple):
    """Waypoints that follow each other by the same kind of move; lines and arcs are one kind."""

    move: Move
    """The move; of lines and arcs LINE."""
    tangent: bool
    """Whether the tool turns with its way."""
    numbers: list[int]
    """The waypoints."""


def runs_of(waypoints: Sequence[Waypoint]) -> list[Run]:
    """Give the runs of equal moves."""

    def kind(i: int) -> tuple[Move, bool]:
        move = waypoints[i].move
        straight = Move.LINE if move is Move.ARC else move
        return straight, waypoints[i].facing is Facing.TANGENT

    groups = groupby(range(len(waypoints)), key=kind)
    return [Run(move, tangent, list(numbers)) for (move, tangent), numbers in groups]


def tool_run(
    arm: Arm, waypoints: Sequence[Waypoint], numbers: Sequence[int], start: Start
) -> list[Place]:
    """Give the places of a run of tool moves, the start first.

    Args:
        arm: The arm.
        waypoints: All waypoints.
        numbers: Those of the run.
        start: Where it begins.

    Raises:
        ValueError: If some waypoints give a pose and others only a position.
    """
    free = _is_orientation_free(arm, waypoints, numbers)
    places = [replace(_carried_place(arm, start.q, free=free), name=start.name)]
    for i in numbers:
        waypoint = waypoints[i]
        if waypoint.q is not None:
            place = _carried_place(arm, waypoint.q, free=free)
        elif waypoint.pose is not None:
            place = Place(name="", p=waypoint.pose.p, quat=waypoint.pose.quat)
        elif waypoint.facing is Facing.KEPT:
            place = Place(name="", p=waypoint.position, quat=places[-1].quat)
        else:
            place = Place(name="", p=waypoint.position)
        places.append(_asking(place, i, waypoint))
    return merge(places)


def joint_run(
    arm: Arm,
    waypoints: Sequence[Waypoint],
    numbers: Sequence[int],
    start: Start,
    q_goal: FloatArray | None = None,
) -> list[Place]:
    """Give the places of a run of joint moves, the start first.

    Args:
        arm: The arm.
        waypoints: All waypoints.
        numbers: Those of the run.
        start: Where it begins.
        q_goal: Joint positions, shape (n,), that bring the tool to the last waypoint; None: those
            that the waypoint gives, or the nearest.

    Raises:
        UnreachableError: If no joint positions bring the tool to a waypoint.
    """
    places = [Place(name=start.name, q=start.q)]
    q = start.q
    for i in numbers:
        waypoint = waypoints[i]
        target = waypoint.pose if waypoint.pose is not None else waypoint.position
        if q_goal is not None and i == numbers[-1]:
            q = q_goal
        elif waypoint.q is not None:
            q = waypoint.q
        elif target is not None:
            q = _reach(arm, target, q, name_of(i, waypoint))
        places.append(_asking(Place(name="", q=q), i, waypoint))
    return merge(places)


def merge(places: Sequence[Place]) -> list[Place]:
    """Make one of neighbours that are the same place.

    Raises:
        CurveError: If one has a blend and no corner to round, at an end or where the arm rests.
    """
    merged = [places[0]]
    for place in places[1:]:
        if merged[-1].is_same(place):
            merged[-1] = merged[-1].merged(place)
        else:
            merged.append(place)
    for i, place in enumerate(merged):
        if place.blend > 0.0 and (place.stops or i in (0, len(merged) - 1)):
            raise CurveError(
                f"a blend of {place.blend * 1e3:.4g} mm, but the arm rests there, as it does where "
                "one kind of move ends; take the blend out",
                place.name,
            )
    return merged


def tool_places(places: Sequence[Place]) -> ToolPlaces:
    """Give the places of a tool run as arrays."""
    p = np.array([place.p for place in places], dtype=np.float64)
    if places[0].quat is None:
        return ToolPlaces(p, None)
    return ToolPlaces(p, np.array([place.quat for place in places], dtype=np.float64))


def segments_between(places: Sequence[Place]) -> list[Segment]:
    """Give the ways of the tool from place to place: lines, and arcs where a place names one.

    Raises:
        CurveError: If an arc cannot be made, with the place that it leads to.
    """
    return [_segment(start, end) for start, end in pairwise(places)]


def _segment(start: Place, end: Place) -> Segment:
    first, last = np.asarray(start.p), np.asarray(end.p)
    try:
        if isinstance(end.arc, ArcThrough):
            return Arc.through(first, end.arc.via, last)
        if isinstance(end.arc, ArcAbout):
            return Arc.about(first, last, end.arc.centre, end.arc.normal, end.arc.turns)
    except CurveError as error:
        raise CurveError(f"no arc leads there: {error.what}", end.name) from error
    return Line(first, last)


def _asking(place: Place, i: int, waypoint: Waypoint) -> Place:
    return replace(
        place,
        name=name_of(i, waypoint),
        arc=waypoint.arc,
        waypoints=(i,),
        speed=inf if waypoint.speed is None else waypoint.speed,
        blend=waypoint.blend,
        stops=waypoint.stops,
        dwell=waypoint.dwell,
    )


def _carried_place(arm: Arm, q: FloatArray, *, free: bool) -> Place:
    """Give where the joints carry the tool."""
    T = arm.fk(q)
    quat = None if free else quaternion.from_matrix(T[:3, :3])
    return Place(name="", p=T[:3, 3], quat=quat)


def _is_orientation_free(arm: Arm, waypoints: Sequence[Waypoint], numbers: Sequence[int]) -> bool:
    """Tell whether a run gives positions only."""
    kept = [i for i in numbers if waypoints[i].facing is Facing.KEPT]
    poses = [i for i in numbers if waypoints[i].pose is not None] + kept
    positions = [i for i in numbers if waypoints[i].position is not None and i not in kept]
    if poses and positions:
        raise ValueError(
            f"{name_of(poses[0], waypoints[poses[0]])} gives a pose or keeps it and "
            f"{name_of(positions[0], waypoints[positions[0]])} a position only; "
            "in one run of tool moves give the orientation everywhere or nowhere"
        )
    return not poses and (bool(positions) or arm.n < _FULL)


def _reach(arm: Arm, target: Pose | FloatArray, q: FloatArray, name: str) -> FloatArray:
    try:
        return ik.solve(arm, target, q)
    except UnreachableError as error:
        raise UnreachableError(
            error.position_error, error.orientation_error, error.joint, error.reason, name
        ) from error
