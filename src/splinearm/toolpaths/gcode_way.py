"""Lines, arcs and splines that NC programs cut.

Source: LinuxCNC, "G-Codes": G1, G2 and G3 (centre and radius formats, full turns), G5 to G5.3.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import hypot, inf, pi, sqrt
from typing import TypedDict

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline

from .action import ArcFeed, Feed, SplineFeed
from .gcode_line import Line
from .gcode_modal import Code
from .gcode_state import MM, OFFSET_LETTERS, State

_MOST_TURNS = 10_000
_SPIRAL_LIMIT = 0.5 * MM
_SPIRAL_SHARE = 1e-3
_SPIRAL_FREE = 5e-3 * MM
"""An arc's ends may differ in their distance from its centre by 0.005 mm, or by a thousandth of it
up to 0.5 mm, as in LinuxCNC."""

Target = Callable[[Line], FloatArray]
"""Gives where the axis words of a line lead, shape (3,), m."""


class _Cut(TypedDict):
    line: int
    feed: float | None
    time: float | None
    blend: float | None
    side: int
    radius: float


@dataclass(slots=True, eq=False)
class Way:
    """Makes the ways that cut."""

    state: State
    """The machine."""
    _handle: FloatArray | None = None
    """Where the second control point of the last cubic was from its end, if that was the last."""

    def go(self, line: Line, code: Code, target: Target) -> list[Feed | ArcFeed | SplineFeed]:
        """Give the way of a line and let the tool be at its end.

        Raises:
            GcodeError: If it is not described well.
        """
        handle, self._handle = self._handle, None
        match code:
            case 10:
                end = target(line)
                way: Feed | ArcFeed | SplineFeed = Feed(
                    start=self.state.position, end=end, **self.cut(line)
                )
                if (end == self.state.position).all():
                    return []
            case 20 | 30:
                way = self._arc(line, target, clockwise=code == 20)
            case 50:
                way = self._cubic(line, target, handle)
            case _:
                way = self._quadratic(line, target)
        self.state.position = way.end
        return [way]

    def cut(self, line: Line) -> _Cut:
        """Give what all cutting ways of a line have in common."""
        modes = self.state.modes
        feed: float | None = self.state.cutting_speed
        time = None
        if modes.feed_mode == 93:
            per_second = line.take("f")
            if per_second is None or modes.feed <= 0.0:
                raise line.refuse("F", "is missing: in inverse time (G93) every way wants its own")
            feed, time = None, 1.0 / modes.feed
        elif not feed:
            what = "F" if not modes.feed else "S"
            raise line.refuse(what, "is missing: this way has no feed; write one before it")
        return _Cut(
            line=line.number,
            feed=feed,
            time=time,
            blend=modes.blend,
            side=modes.side,
            radius=modes.radius,
        )

    def _arc(self, line: Line, target: Target, *, clockwise: bool) -> ArcFeed:
        state = self.state
        axis = state.modes.axis
        a, b = (axis + 1) % 3, (axis + 2) % 3
        named = set(line.axes) & {a, b}
        start, end = state.position, target(line)
        radius = line.take("r")
        ways = {i: line.take(OFFSET_LETTERS[i]) for i in (a, b)}
        turns = line.whole("p", 1) if "p" in line.values else 1
        if turns > _MOST_TURNS:
            raise line.refuse(line.texts["p"], f"at most {_MOST_TURNS} turns")
        if radius is not None:
            if any(way is not None for way in ways.values()):
                raise line.refuse("R", "an arc has a radius or a centre, not both")
            if not named:
                raise line.refuse(
                    "R", "an arc by its radius wants an end that it does not begin in"
                )
            centre = self._by_radius(
                line, start, end, radius * state.modes.unit, clockwise=clockwise
            )
        else:
            if all(way is None for way in ways.values()):
                letters = " or ".join(OFFSET_LETTERS[i].upper() for i in sorted((a, b)))
                raise line.refuse("", f"the arc has no centre ({letters}) and no radius (R)")
            centre = self._by_ways(line, start, ways)
        self._check_spiral(line, start, end, centre)
        arms = [(p - centre)[[a, b]] for p in (start, end)]
        angle = (np.arctan2(arms[1][1], arms[1][0]) - np.arctan2(arms[0][1], arms[0][0])) % (2 * pi)
        if clockwise:
            angle -= 2.0 * pi
        same = hypot(*(end - start)[[a, b]]) <= 1e-9 * hypot(*arms[0])
        if same or angle == 0.0:
            angle = -2.0 * pi if clockwise else 2.0 * pi
        angle += (turns - 1) * (-2.0 * pi if clockwise else 2.0 * pi)
        return ArcFeed(
            start=start, end=end, centre=centre, axis=axis, turn=float(angle), **self.cut(line)
        )

    def _by_ways(self, line: Line, start: FloatArray, ways: dict[int, float | None]) -> FloatArray:
        modes, centre = self.state.modes, start.copy()
        for axis, way in ways.items():
            if modes.arc_absolute:
                if way is None:
                    letter = OFFSET_LETTERS[axis].upper()
                    raise line.refuse(letter, "is missing: with G90.1 a centre has both words")
                centre[axis] = way * modes.unit + self.state.offset[axis]
            elif way is not None:
                centre[axis] += way * modes.unit
        return centre

    def _by_radius(
        self, line: Line, start: FloatArray, end: FloatArray, radius: float, *, clockwise: bool
    ) -> FloatArray:
        axis = self.state.modes.axis
        a, b = (axis + 1) % 3, (axis + 2) % 3
        way = (end - start)[[a, b]]
        half = 0.5 * hypot(*way)
        if half == 0.0:
            raise line.refuse(line.texts["r"], "an arc by its radius must not end where it begins")
        if half > abs(radius) * (1.0 + _SPIRAL_SHARE):
            raise line.refuse(
                line.texts["r"],
                f"the ends are {2e3 * half:.6g} mm apart, more than two radii "
                f"({2e3 * abs(radius):.6g} mm)",
            )
        height = sqrt(max(radius * radius - half * half, 0.0))
        # the centre is left of the way for a short arc to the left or a long one to the right
        left = (radius > 0.0) != clockwise
        across = np.array([-way[1], way[0]]) / (2.0 * half)
        centre = start.copy()
        centre[[a, b]] += 0.5 * way + (height if left else -height) * across
        return centre

    def _check_spiral(
        self, line: Line, start: FloatArray, end: FloatArray, centre: FloatArray
    ) -> None:
        axis = self.state.modes.axis
        plane = [(axis + 1) % 3, (axis + 2) % 3]
        first, last = (hypot(*(p - centre)[plane]) for p in (start, end))
        if first <= 1e-9:
            raise line.refuse("", "the arc has no radius: its centre is where it begins")
        off = abs(first - last)
        if off > _SPIRAL_LIMIT or (off > _SPIRAL_FREE and off > _SPIRAL_SHARE * first):
            raise line.refuse(
                "",
                f"the arc begins {1e3 * first:.6g} mm from its centre and ends "
                f"{1e3 * last:.6g} mm from it",
            )

    def _cubic(self, line: Line, target: Target, handle: FloatArray | None) -> SplineFeed:
        """Give the cubic of G5: I J from its start, P Q from its end to the control points."""
        self._require_plane(line, "G5")
        unit, start, end = self.state.modes.unit, self.state.position, target(line)
        i, j = line.take("i"), line.take("j")
        if (i is None) != (j is None):
            raise line.refuse("G5", "wants both I and J or neither")
        if i is not None and j is not None:
            first = np.array([i * unit, j * unit, 0.0])
        elif handle is not None:
            first = -handle
        else:
            raise line.refuse("G5", "wants I and J: no G5 is right before it")
        p, q = (line.required(letter, "G5 wants P and Q") for letter in "pq")
        self._handle = np.array([p * unit, q * unit, 0.0])
        points = np.array([start, start + first, end + self._handle, end])
        return self.spline(line, points, None, 3)

    def _quadratic(self, line: Line, target: Target) -> SplineFeed:
        """Give the quadratic of G5.1: I J from its start to the control point."""
        self._require_plane(line, "G5.1")
        unit, start, end = self.state.modes.unit, self.state.position, target(line)
        i, j = line.take("i"), line.take("j")
        if not (i or j):
            raise line.refuse("G5.1", "wants I or J, the way to its control point")
        middle = start + np.array([(i or 0.0) * unit, (j or 0.0) * unit, 0.0])
        return self.spline(line, np.array([start, middle, end]), None, 2)

    def _require_plane(self, line: Line, code: str) -> None:
        if self.state.modes.axis != 2:
            raise line.refuse(code, "works in the plane G17 only")
        if 2 in line.axes:
            raise line.refuse(line.texts["z"], f"{code} stays in its plane")

    def spline(
        self, line: Line, points: FloatArray, weights: FloatArray | None, degree: int
    ) -> SplineFeed:
        """Give the way along the clamped B-spline with even knots, as LinuxCNC has it.

        Raises:
            GcodeError: If it is none.
        """
        inner = np.arange(1, len(points) - degree, dtype=np.float64)
        last = float(len(points) - degree)
        knots = np.concatenate((np.zeros(degree + 1), inner, np.full(degree + 1, last)))
        try:
            curve = BSpline(knots, points, degree, weights)
        except ValueError as error:
            raise line.refuse("", f"is no curve: {error}") from error
        return SplineFeed(start=points[0], end=points[-1], curve=curve, **self.cut(line))


@dataclass(slots=True, eq=False)
class NurbsWay:
    """The control points between G5.2 and G5.3."""

    line: int
    """Where it began."""
    order: int
    """The order of the curve: its degree and one."""
    points: list[FloatArray] = field(default_factory=list)
    """Control points, the first where the tool is."""
    weights: list[float] = field(default_factory=list)
    """Their weights."""

    @classmethod
    def begin(cls, line: Line, state: State) -> "NurbsWay":
        """Begin at a line with G5.2; its P is the weight of the place where the tool is.

        Raises:
            GcodeError: If the order is none.
        """
        if state.modes.axis != 2:
            raise line.refuse("G5.2", "works in the plane G17 only")
        order = line.whole("l", 3) if "l" in line.values else 3
        way = cls(line.number, order, [state.position.copy()], [1.0])
        if not line.axes:
            way.weights[0] = cls._weight(line)
        return way

    def add(self, line: Line, target: Target) -> None:
        """Take the control point of a line.

        Raises:
            GcodeError: If it leaves the plane or its weight is not above 0.
        """
        if 2 in line.axes:
            raise line.refuse(line.texts["z"], "G5.2 stays in its plane")
        if line.axes:
            self.points.append(target(line))
            self.weights.append(self._weight(line))
        line.drop("l")

    @staticmethod
    def _weight(line: Line) -> float:
        weight = line.take("p")
        if weight is None:
            return 1.0
        if not 0.0 < weight < inf:
            raise line.refuse(line.texts["p"], f"want a weight above 0, got {weight:g}")
        return weight

    def finish(self, line: Line, way: Way) -> SplineFeed:
        """Give the curve and let the tool be at its end.

        Raises:
            GcodeError: If there are too few points.
        """
        if len(self.points) < self.order:
            raise line.refuse(
                "G5.3",
                f"a curve of order {self.order} wants {self.order} control points, got "
                f"{len(self.points)}",
            )
        weights = np.array(self.weights)
        spline = way.spline(line, np.array(self.points), weights, self.order - 1)
        way.state.position = spline.end
        return spline
