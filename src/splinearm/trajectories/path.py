"""Ways of the tool without time: where it goes and how it stands, by one parameter s.

s is nearly the way of the tool in m; where the tool turns more than it moves, it is that turn
times 0.1 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.corner import rounded_polyline
from splinearm.curves.interpolation import interpolate
from splinearm.curves.nearest import distance_to_curves
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion

from .orientation import RotationPolyline, interpolate_orientations
from .turning import OrientationCurve

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

    position: BSpline
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


def steps_between(places: ToolPlaces) -> FloatArray:
    """Give how much s each step from place to place takes, shape (m - 1,)."""
    moved: FloatArray = np.linalg.norm(np.diff(places.p, axis=0), axis=1)
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


def line_path(places: ToolPlaces, blends: FloatArray, names: Sequence[str]) -> CartesianPath:
    """Give the path of straight lines from place to place with rounded corners.

    Within a corner the tool stays nearer to it than its blend; it and its turn are C2.

    Args:
        places: The ends of the lines, no two neighbours the same, at least 2.
        blends: How near to each place rounding may begin, m, shape (m,), 0 at the ends; where it
            is 0 inside, the lines before and behind are in line.
        names: What messages call the places.

    Raises:
        CurveError: If blends overlap.
    """
    steps = steps_between(places)
    check_blends(steps, blends, names)
    s = np.concatenate(([0.0], np.cumsum(steps)))
    orientation: OrientationCurve | None = None
    if places.quats is not None:
        orientation = RotationPolyline(s, places.quats, blends)
    return CartesianPath(
        position=rounded_polyline(places.p, s, blends), orientation=orientation, waypoint_s=s
    )


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


def is_straight(places: ToolPlaces, tolerance: float = 1e-9) -> bool:
    """Tell whether three places are passed in a straight line at one rate of way and turn."""
    steps = steps_between(places)[:, None]
    slopes = np.diff(places.p, axis=0) / steps
    if np.abs(slopes[1] - slopes[0]).max() > tolerance:
        return False
    if places.quats is None:
        return True
    turns = quaternion.log(
        quaternion.multiply(quaternion.conjugate(places.quats[:-1]), places.quats[1:])
    )
    rates = turns / steps * TURN_ARM
    return bool(np.abs(rates[1] - rates[0]).max() <= tolerance)


def _with_first_again(places: ToolPlaces) -> ToolPlaces:
    quats = places.quats
    return ToolPlaces(
        np.vstack((places.p, places.p[:1])),
        None if quats is None else np.vstack((quats, quats[:1])),
    )
