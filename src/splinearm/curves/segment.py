"""Lines, circular arcs and helices between two places in space, exactly, by the share travelled."""

from dataclasses import dataclass, replace
from math import pi
from typing import Protocol

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

_ROUND = 1e-6
"""Share of the radius, and m for none, by which both ends of an arc may differ in radius."""

_STRAIGHT = 1e-9
"""Three points make no circle if they are in line but for this share of their distance."""


class Segment(Protocol):
    """A way from one place to another at an even rate."""

    @property
    def length(self) -> float:
        """How long it is, m."""
        ...

    def at(self, x: FloatArray, derivative: int = 0) -> FloatArray:
        """Give places, or a derivative by the share, at shares from 0 to 1, shape (m, 3)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A straight way."""

    start: FloatArray
    """Where it begins, shape (3,), m."""
    end: FloatArray
    """Where it ends, shape (3,), m."""

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(np.linalg.norm(self.end - self.start))

    def at(self, x: FloatArray, derivative: int = 0) -> FloatArray:
        """Give places, or a derivative by the share, at shares from 0 to 1, shape (m, 3)."""
        way = self.end - self.start
        if derivative == 0:
            return self.start + x[:, None] * way
        return np.tile(way if derivative == 1 else np.zeros(3), (len(x), 1))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Arc:
    """A way about an axis at an even distance from it: a circular arc, or with a rise a helix."""

    centre: FloatArray
    """The point of the axis level with the start, shape (3,), m."""
    outward: FloatArray
    """From there to the start, shape (3,), m."""
    onward: FloatArray
    """The direction in which it leaves, at right angles to both, of the same length, m."""
    rise: FloatArray
    """Way along the axis from start to end, shape (3,), m; zero: a circular arc."""
    angle: float
    """How far it turns about the axis, rad, above zero."""

    @classmethod
    def through(cls, start: ArrayInput, via: ArrayInput, end: ArrayInput) -> "Arc":
        """Give the circular arc from one point through another to a third.

        Args:
            start: Where it begins, shape (3,), m.
            via: A point on the way, shape (3,), m.
            end: Where it ends, shape (3,), m.

        Raises:
            CurveError: If the three are in line or two of them are the same.
        """
        first, middle, last = (
            frozen_array(p, (3,), name)
            for p, name in ((start, "start"), (via, "via"), (end, "end"))
        )
        a, b = middle - first, last - first
        normal = np.cross(a, b)
        size = float(normal @ normal)
        if size <= (_STRAIGHT * float(a @ a + b @ b)) ** 2:
            raise CurveError("three points in line make no arc; move the one in the middle", "arc")
        # the circumcentre of a triangle, e.g. Coxeter, Introduction to Geometry, 1969, 1.5
        outward = -np.cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * size)
        centre = first - outward
        normal /= np.sqrt(size)
        onward = np.cross(normal, outward)
        arm = last - centre
        angle = float(np.arctan2(arm @ onward, arm @ outward)) % (2.0 * pi)
        return cls(centre=centre, outward=outward, onward=onward, rise=np.zeros(3), angle=angle)

    @classmethod
    def about(
        cls,
        start: ArrayInput,
        end: ArrayInput,
        centre: ArrayInput,
        normal: ArrayInput,
        turns: int = 0,
    ) -> "Arc":
        """Give the arc or helix about an axis, by the right hand, to the first passing of the end.

        If start and end are at the same place of the circle it is a full turn.

        Args:
            start: Where it begins, shape (3,), m.
            end: Where it ends, shape (3,), m; as far from the axis as the start.
            centre: A point of the axis, shape (3,), m.
            normal: Its direction, shape (3,), of any length above 0.
            turns: Full turns besides.

        Raises:
            CurveError: If start and end differ in their distance from the axis, or lie on it.
            ValueError: If the normal has no length or turns is negative.
        """
        first, last, origin = (
            frozen_array(p, (3,), name)
            for p, name in ((start, "start"), (end, "end"), (centre, "centre"))
        )
        axis = np.array(frozen_array(normal, (3,), "normal"))
        size = float(np.linalg.norm(axis))
        if size <= 0.0:
            raise ValueError(f"normal: want a direction, got {axis.tolist()}")
        if turns < 0:
            raise ValueError(f"turns: want 0 or more, got {turns}; turn the normal about instead")
        axis /= size
        outward, arm = (p - origin - axis * (axis @ (p - origin)) for p in (first, last))
        radius, other = float(np.linalg.norm(outward)), float(np.linalg.norm(arm))
        if radius <= _ROUND * np.abs(first - origin).max() or abs(radius - other) > _ROUND * radius:
            raise CurveError(
                f"it begins {radius * 1e3:.6g} mm from its axis and ends {other * 1e3:.6g} mm from "
                "it; both must be the same and above 0",
                "arc",
            )
        onward = np.cross(axis, outward)
        angle = float(np.arctan2(arm @ onward, arm @ outward)) % (2.0 * pi)
        if angle <= _ROUND:
            angle += 2.0 * pi
        arc = cls(
            centre=first - outward,
            outward=outward,
            onward=onward,
            rise=axis * (axis @ (last - first)),
            angle=angle + 2.0 * pi * turns,
        )
        # what is left of rounding in the given points is spread over the way
        return replace(arc, rise=arc.rise + (last - arc.at(np.ones(1))[0]))

    @property
    def radius(self) -> float:
        """Distance from the axis, m."""
        return float(np.linalg.norm(self.outward))

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(np.hypot(self.radius * self.angle, np.linalg.norm(self.rise)))

    def at(self, x: FloatArray, derivative: int = 0) -> FloatArray:
        """Give places, or a derivative by the share, at shares from 0 to 1, shape (m, 3)."""
        phase = (self.angle * x + 0.5 * pi * derivative)[:, None]
        scale = self.angle**derivative
        turned: FloatArray = scale * (np.cos(phase) * self.outward + np.sin(phase) * self.onward)
        if derivative == 0:
            turned = turned + self.centre + x[:, None] * self.rise
        elif derivative == 1:
            turned = turned + self.rise
        return turned
