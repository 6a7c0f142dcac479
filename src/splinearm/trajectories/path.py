"""Ways of the tool without time: where it goes and how it stands, by one parameter s.

s is nearly the way of the tool in m; where the tool turns more than it moves, it is that turn
times 0.1 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.curves.course import Course, goes_on
from splinearm.curves.interpolation import interpolate
from splinearm.curves.nearest import distance_to_curves
from splinearm.curves.segment import Segment
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion

from .orientation import RotationPolyline, interpolate_orientations
from .transport import TransportedOrientation
from .turning import OrientationCurve, SpaceJet

TURN_ARM = 0.1
"""How many metres of way a turn of 1 rad counts as."""

_CRUMB = 1e-9
"""Breaks nearer to each other than this share of a path are one."""


class ToolPlaces(NamedTuple):
    """Places that a tool path passes: positions, and orientations unless they are free."""

    p: FloatArray
    """Positions, shape (m, 3), m."""
    quats: FloatArray | None
    """Unit quaternions, shape (m, 4), or None."""


class ToolState(NamedTuple):
    """Where the tool is along a path, and how that changes with s."""

    p: FloatArray
    """Positions, shape (m, 3), m."""
    quat: FloatArray | None
    """Orientations, shape (m, 4), or None where free."""
    slope: FloatArray
    """First derivative by s: linear, and unless free angular, shape (m, 6) or (m, 3)."""
    bend: FloatArray
    """Second derivative by s, of the same shape."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class CartesianPath:
    """A C2 way of the tool."""

    position: SpaceJet
    """Where the tool is, m in base."""
    orientation: OrientationCurve | None
    """How it stands, or None if that is free."""
    waypoint_s: FloatArray
    """The parameter of each place that the path was made for, shape (m,)."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last s."""
        return self.position.domain

    @property
    def breaks(self) -> FloatArray:
        """Where the path is no more than C2, and its ends."""
        breaks = self.position.breaks
        if self.orientation is None:
            return breaks
        turning = self.orientation.breaks
        together = np.union1d(breaks, turning)
        # rounding may have moved apart what is one
        crumb = _CRUMB * (breaks[-1] - breaks[0])
        inner = together[(together > breaks[0] + crumb) & (together < breaks[-1] - crumb)]
        inner = inner[np.diff(inner, prepend=breaks[0]) > crumb]
        return np.concatenate((breaks[:1], inner, breaks[-1:]))

    def state(self, s: ArrayInput) -> ToolState:
        """Give the tool's place and its first two derivatives at s, shape (m,).

        Raises:
            CurveError: If an s lies outside the domain.
        """
        s = np.asarray(s, dtype=np.float64)
        p, slope, bend = (self.position.at(s, order) for order in (0, 1, 2))
        if self.orientation is None:
            return ToolState(p, None, slope, bend)
        turning = self.orientation.at(s)
        return ToolState(
            p, turning.quat, np.hstack((slope, turning.omega)), np.hstack((bend, turning.alpha))
        )

    def at(self, s: float) -> tuple[FloatArray, FloatArray | None]:
        """Give the tool's position, shape (3,), m, and orientation, shape (4,) or None.

        Raises:
            CurveError: If s lies outside the domain.
        """
        state = self.state(np.array([s]))
        return state.p[0], None if state.quat is None else state.quat[0]

    def places(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give positions and their derivatives by s, each of shape (m, 3)."""
        return self.position.at(s), self.position.at(s, 1)

    def distance(self, points: ArrayInput) -> FloatArray:
        """Give the distance of points, shape (m, 3), to the nearest place of the path, (m,), m."""
        return distance_to_curves([self], points)


def steps_between(places: ToolPlaces, segments: Sequence[Segment] | None = None) -> FloatArray:
    """Give how much s each step from place to place takes, shape (m - 1,).

    Args:
        places: The places.
        segments: The ways between them; None: straight ones.
    """
    moved: FloatArray = np.linalg.norm(np.diff(places.p, axis=0), axis=1)
    if segments is not None:
        moved = np.array([segment.length for segment in segments])
    if places.quats is None:
        return moved
    turned = quaternion.angle_between(places.quats[:-1], places.quats[1:])
    steps: FloatArray = np.maximum(moved, TURN_ARM * turned)
    return steps


def spline_path(places: ToolPlaces, *, closed: bool = False) -> CartesianPath:
    """Give the cubic B-spline path through places, no two neighbours of which are the same.

    Args:
        places: Where it passes, at least 2.
        closed: Whether it returns to the first place as smoothly as it passes the others.
    """
    around = _with_first_again(places) if closed else places
    s = np.concatenate(([0.0], np.cumsum(steps_between(around))))
    return CartesianPath(
        position=interpolate(places.p, parameters=s, ends="closed" if closed else "natural"),
        orientation=None
        if places.quats is None
        else interpolate_orientations(s, places.quats, closed=closed),
        waypoint_s=s,
    )


def course_path(
    places: ToolPlaces, segments: Sequence[Segment], blends: FloatArray, names: Sequence[str]
) -> CartesianPath:
    """Give the path along segments from place to place with rounded corners.

    Within a corner the tool stays nearer to it than its blend; it and its turn are C2.

    Args:
        places: The ends of the segments, at least 2.
        segments: The ways between them.
        blends: How near to each place rounding may begin, m, shape (m,), 0 at the ends; where it
            is 0 inside, the segment behind goes on as the one before ends.
        names: What messages call the places.

    Raises:
        CurveError: If blends overlap, or are too large for how much the way bends there.
    """
    steps = steps_between(places, segments)
    check_blends(steps, blends, names)
    s = np.concatenate(([0.0], np.cumsum(steps)))
    course = Course(segments, s, blends)
    for i in np.flatnonzero(blends).tolist():
        if course.farthest_from_corner(i) > blends[i] * (1.0 + 1e-9):
            raise CurveError(
                f"a blend of {blends[i] * 1e3:.4g} mm is too large for how much the way bends "
                "there; make it smaller",
                names[i],
            )
    orientation: OrientationCurve | None = None
    if places.quats is not None:
        orientation = RotationPolyline(s, places.quats, blends)
    return CartesianPath(position=course, orientation=orientation, waypoint_s=s)


def turning_along(path: CartesianPath, quat_start: FloatArray) -> CartesianPath:
    """Give the same way with a tool that turns with its direction and does not spin about it.

    Raises:
        CurveError: If the way has no direction somewhere.
    """
    return replace(path, orientation=TransportedOrientation(path.position, quat_start))


def check_blends(steps: FloatArray, blends: FloatArray, names: Sequence[str]) -> None:
    """Refuse corners that do not find room on the ways between them.

    Raises:
        CurveError: Naming the two places.
    """
    needed = blends[:-1] + blends[1:]
    over = needed > steps * (1.0 + 1e-12)
    if over.any():
        i = int(np.argmax(over))
        raise CurveError(
            f"blends of {blends[i] * 1e3:.4g} mm and {blends[i + 1] * 1e3:.4g} mm overlap on the "
            f"{steps[i] * 1e3:.4g} mm between them; make them smaller",
            f"{names[i]} and {names[i + 1]}",
        )


def is_smooth(places: ToolPlaces, segments: Sequence[Segment], tolerance: float = 1e-9) -> bool:
    """Tell whether the place between two segments is no corner, neither of way nor of turn.

    Args:
        places: Start, middle and end.
        segments: The two ways between them.
        tolerance: Largest difference of the rates of turn, rad by 0.1 m.
    """
    steps = steps_between(places, segments)
    if not goes_on(segments[0], segments[1], (float(steps[0]), float(steps[1]))):
        return False
    if places.quats is None:
        return True
    turns = quaternion.log(
        quaternion.multiply(quaternion.conjugate(places.quats[:-1]), places.quats[1:])
    )
    rates = turns / steps[:, None] * TURN_ARM
    return bool(np.abs(rates[1] - rates[0]).max() <= tolerance)


def _with_first_again(places: ToolPlaces) -> ToolPlaces:
    quats = places.quats
    return ToolPlaces(
        np.vstack((places.p, places.p[:1])),
        None if quats is None else np.vstack((quats, quats[:1])),
    )
