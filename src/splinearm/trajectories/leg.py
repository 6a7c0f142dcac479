"""Legs of a plan: smooth ways of joints and tool that begin and end at rest."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.corner import rounded_polyline
from splinearm.curves.nearest import SpaceCurve
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.kinematics.arm import Arm

from .constraint import SpeedCap
from .joint_path import JointPath
from .law_choice import CELLS, quickest_law
from .limit import MotionLimits
from .path import (
    CartesianPath,
    check_blends,
    course_path,
    is_smooth,
    spline_path,
    steps_between,
    turning_along,
)
from .place import Place, segments_between, tool_places
from .reach import PathLabels
from .resolve import Tolerance, resolve
from .section import Section
from .tool_path import CarriedPath

_LOOKS = 65
_HALVINGS = 40


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A smooth way that begins and ends at rest."""

    joints: JointPath
    """The way of the joints."""
    tool: SpaceCurve
    """The wanted way of the tool, by the same parameter."""
    s: FloatArray
    """The parameter of each place, shape (m,)."""
    places: Sequence[Place]
    """The places, the leg's start first."""

    @property
    def q_goal(self) -> FloatArray:
        """Where the joints end, shape (n,)."""
        end: FloatArray = self.joints.at(float(self.s[-1]))[0]
        return end

    def sections(
        self, arm: Arm, limits: MotionLimits, cells: int = CELLS
    ) -> list[tuple[Section, list[tuple[int, float]]]]:
        """Give the parts from rest to rest, and when in each a waypoint is passed, s.

        Args:
            arm: The arm.
            limits: What joints, torques and tool may do.
            cells: On about how many cells a smooth law is sought.
        """
        inner = range(1, len(self.places) - 1)
        rests = [0, *(i for i in inner if self.places[i].stops), len(self.places) - 1]
        cap = self._cap(arm, limits.tool_speed)
        parts = []
        for begin, end in pairwise(rests):
            span = (float(self.s[begin]), float(self.s[end]))
            law = quickest_law(self.joints, limits, span, cap, cells)
            passed = [
                (number, law.time_at(float(self.s[i])))
                for i in range(begin + 1, end + 1)
                for number in self.places[i].waypoints
            ]
            parts.append((Section(self.joints, law, self.places[end].dwell, cap), passed))
        return parts

    def _cap(self, arm: Arm, most: float | None) -> SpeedCap | None:
        speeds = np.array([place.speed for place in self.places[1:]])
        speeds = np.minimum(speeds, np.inf if most is None else most)
        if np.isinf(speeds).all():
            return None
        return SpeedCap(edges=self.s, speeds=speeds, rate=partial(_tool_rate, arm, self.joints))


@dataclass(frozen=True, slots=True, eq=False)
class ToolWay:
    """A smooth way of the tool through places, before joints carry it there."""

    path: CartesianPath
    """The way."""
    places: Sequence[Place]
    """The places, the start first; on a closed curve the start again as the last."""

    @property
    def labels(self) -> PathLabels:
        """What messages call its places."""
        return PathLabels([place.name for place in self.places])

    def leg(self, arm: Arm, q_start: FloatArray, tolerance: Tolerance) -> Leg:
        """Give the leg on which the arm follows the way from joint positions at its start, (n,).

        Raises:
            KinematicsError: If the arm cannot follow.
        """
        joints = resolve(arm, self.path, q_start, tolerance, self.labels)
        return Leg(joints, self.path, self.path.waypoint_s, self.places)


def spline_way(
    arm: Arm,
    places: Sequence[Place],
    q_start: FloatArray,
    closing: Place | None = None,
    *,
    tangent: bool = False,
) -> ToolWay:
    """Give the way of a B-spline through places, the start first.

    Args:
        arm: The arm.
        places: At least two places.
        q_start: Where the joints are at the first, shape (n,).
        closing: What is asked for at the end of a closed curve, which is the first place again;
            None: the curve is open.
        tangent: Whether the tool turns with its way, from how the joints hold it at the start.
    """
    path = spline_path(tool_places(places), closed=closing is not None)
    path = turning_along(path, _held(arm, q_start)) if tangent else path
    return ToolWay(path, [*places, closing] if closing is not None else list(places))


def course_ways(
    arm: Arm, places: Sequence[Place], q_start: FloatArray, *, tangent: bool = False
) -> list[ToolWay]:
    """Give the ways of lines and arcs: a new one where the tool must stop at a corner.

    Args:
        arm: The arm.
        places: At least two places, the start first.
        q_start: Where the joints are at the first, shape (n,).
        tangent: Whether the tool turns with its way, from how the joints hold it at the start.

    Raises:
        CurveError: If blends overlap or an arc cannot be made.
    """
    ways: list[ToolWay] = []
    segments = segments_between(places)
    check_blends(
        steps_between(tool_places(places), segments),
        np.array([place.blend for place in places]),
        [p.name for p in places],
    )
    corners = [
        i
        for i in range(1, len(places) - 1)
        if places[i].blend <= 0.0
        and not is_smooth(tool_places(places[i - 1 : i + 2]), segments[i - 1 : i + 1])
    ]
    bounds = [0, *corners, len(places) - 1]
    held = _held(arm, q_start)
    for begin, end in pairwise(bounds):
        some = places[begin : end + 1]
        blends = np.array([place.blend for place in some])
        names = [place.name for place in some]
        path = course_path(tool_places(some), segments[begin:end], blends, names)
        if tangent:
            path = turning_along(path, held)
            quat = path.at(path.domain[1])[1]
            held = held if quat is None else quat
        ways.append(ToolWay(path, some))
    return ways


def joint_legs(arm: Arm, places: Sequence[Place]) -> list[Leg]:
    """Give the legs of straight joint moves: a new one at each place without a blend.

    Raises:
        CurveError: If blends overlap.
    """
    legs = []
    stops = [i for i in range(1, len(places) - 1) if places[i].blend <= 0.0]
    bounds = [0, *stops, len(places) - 1]
    for begin, end in pairwise(bounds):
        some = places[begin : end + 1]
        corners = np.array([place.q for place in some], dtype=np.float64)
        u = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))))
        joints = JointPath(_joint_curve(arm, some, corners, u))
        legs.append(Leg(joints, CarriedPath(arm, joints), u, some))
    return legs


def straight_path(q_start: FloatArray, q_goal: FloatArray) -> JointPath:
    """Give the straight way from joint positions to different ones, by a parameter 0 to 1."""
    return JointPath(BSpline(np.array([0.0, 0.0, 1.0, 1.0]), np.array([q_start, q_goal]), 1))


def _held(arm: Arm, q: FloatArray) -> FloatArray:
    """Give how the joints hold the tool, shape (4,)."""
    return quaternion.from_matrix(arm.fk(q)[:3, :3])


def _joint_curve(arm: Arm, places: Sequence[Place], corners: FloatArray, u: FloatArray) -> BSpline:
    """Give straight ways with rounded corners in joint space."""
    if len(places) == 2:
        return BSpline(np.array([u[0], u[0], u[1], u[1]]), corners, 1)
    widths = np.zeros(len(places))
    for i in range(1, len(places) - 1):
        widths[i] = min(_room(arm, corners, u, i, step, places[i].blend) for step in (-1, 1))
    over = widths[:-1] + widths[1:] > np.diff(u) * (1.0 + 1e-12)
    if over.any():
        i = int(np.argmax(over))
        raise CurveError(
            "their blends overlap on the way between them; make them smaller",
            f"{places[i].name} and {places[i + 1].name}",
        )
    for _ in range(_HALVINGS):
        curve = rounded_polyline(corners, u, widths)
        too_far = [
            i
            for i in range(1, len(places) - 1)
            if _farthest(arm, curve, corners[i], u[i], widths[i]) > places[i].blend
        ]
        if not too_far:
            return curve
        widths[too_far] *= 0.9
    raise CurveError("no rounding stays within its blend", "joint moves")


def _room(arm: Arm, corners: FloatArray, u: FloatArray, i: int, step: int, blend: float) -> float:
    """Give how far from corner i, in u, the tool is nearer to it than the blend all the way."""
    way = abs(float(u[i + step] - u[i]))
    T = arm.fk(corners[i])

    def away(shares: FloatArray) -> FloatArray:
        q = corners[i] + shares[:, None] * (corners[i + step] - corners[i])
        gap: FloatArray = np.linalg.norm(arm.fk(q)[:, :3, 3] - T[:3, 3], axis=1)
        return gap

    shares = np.linspace(0.0, 1.0, _LOOKS)
    beyond = away(shares) > blend
    if not beyond.any():
        return way
    first = int(np.argmax(beyond))
    low, high = shares[first - 1], shares[first]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if away(np.array([middle]))[0] > blend:
            high = middle
        else:
            low = middle
    return float(low) * way


def _farthest(arm: Arm, curve: BSpline, corner: FloatArray, u: float, width: float) -> float:
    """Give how far the tool gets from a corner while it is rounded, m."""
    q = curve.at(np.linspace(u - width, u + width, _LOOKS))
    gap = np.linalg.norm(arm.fk(q)[:, :3, 3] - arm.fk(corner)[:3, 3], axis=1)
    # the ends of the rounding lie at the blend itself, but for rounding
    return float(gap.max()) * (1.0 - 1e-9)


def _tool_rate(arm: Arm, joints: JointPath, s: FloatArray) -> FloatArray:
    """Give the tool's speed by s, shape (m,)."""
    q, slope, _ = joints.sample(s)
    J = arm.jacobian(q)[:, :3]
    rate: FloatArray = np.linalg.norm(np.einsum("mij,mj->mi", J, slope), axis=1)
    return rate
