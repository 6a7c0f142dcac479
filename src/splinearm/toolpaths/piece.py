"""The pieces of which drawings are made: lines, circular arcs and splines in the plane."""

from dataclasses import dataclass, replace
from math import atan2, cos, hypot, pi, sin

import numpy as np

from splinearm.arrays import FloatArray, frozen_array
from splinearm.curves.bspline import BSpline

_UNEVEN = 1e-6
"""Share of its radius by which the ends of an arc may differ in their distance to the centre."""


@dataclass(frozen=True, slots=True, eq=False)
class LinePiece:
    """A straight piece."""

    start: FloatArray
    """Where it begins, shape (2,), m."""
    end: FloatArray
    """Where it ends, shape (2,), m."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", frozen_array(self.start, (2,), "start"))
        object.__setattr__(self, "end", frozen_array(self.end, (2,), "end"))

    @property
    def length(self) -> float:
        """How long it is, m."""
        return hypot(*(self.end - self.start))

    @property
    def middle(self) -> FloatArray:
        """The point half-way, shape (2,), m."""
        return 0.5 * (self.start + self.end)

    def reversed(self) -> "LinePiece":
        """Give it from end to start."""
        return LinePiece(self.end, self.start)

    def between(self, start: FloatArray, end: FloatArray) -> "LinePiece":
        """Give it with its ends moved a little."""
        return LinePiece(start, end)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ArcPiece:
    """A circular arc; a full circle begins and ends in the same place."""

    start: FloatArray
    """Where it begins, shape (2,), m."""
    end: FloatArray
    """Where it ends, shape (2,), m."""
    centre: FloatArray
    """Its centre, shape (2,), m."""
    turn: float
    """How far it turns about the centre, rad; above 0 to the left, never more than a full turn."""

    def __post_init__(self) -> None:
        for name in ("start", "end", "centre"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (2,), name))
        if not 0.0 < abs(self.turn) <= 2.0 * pi:
            raise ValueError(f"turn: want an angle up to a full turn either way, got {self.turn}")
        first, last = hypot(*(self.start - self.centre)), hypot(*(self.end - self.centre))
        if not first > 0.0 or abs(first - last) > _UNEVEN * first:
            raise ValueError(
                f"centre: want it as far from start as from end, got {first:.9g} and {last:.9g} m"
            )

    @classmethod
    def about(cls, centre: FloatArray, radius: float, start: float, turn: float) -> "ArcPiece":
        """Give the arc of a circle from an angle on, rad against the x axis."""
        ends = [
            np.asarray(centre) + radius * np.array([cos(angle), sin(angle)])
            for angle in (start, start + turn)
        ]
        if abs(turn) >= 2.0 * pi:
            ends[1] = ends[0]
        return cls(start=ends[0], end=ends[1], centre=np.asarray(centre, dtype=float), turn=turn)

    @classmethod
    def bulging(cls, start: FloatArray, end: FloatArray, bulge: float) -> "ArcPiece":
        """Give the arc of a chord and the tangent of a quarter of its turn, as DXF has it."""
        turn = 4.0 * atan2(bulge, 1.0)
        way = np.asarray(end, dtype=float) - start
        # the centre stands over the middle of the chord by (1 - b^2) / 4b of its length
        off = (1.0 - bulge * bulge) / (4.0 * bulge)
        centre = 0.5 * (np.asarray(start) + end) + off * np.array([-way[1], way[0]])
        return cls(start=start, end=end, centre=centre, turn=turn)

    @property
    def radius(self) -> float:
        """Its radius, m."""
        return hypot(*(self.start - self.centre))

    @property
    def length(self) -> float:
        """How long it is, m."""
        return self.radius * abs(self.turn)

    @property
    def bulge(self) -> float:
        """The tangent of a quarter of its turn."""
        return float(np.tan(0.25 * self.turn))

    @property
    def middle(self) -> FloatArray:
        """The point half-way, shape (2,), m."""
        c, s = cos(0.5 * self.turn), sin(0.5 * self.turn)
        x, y = self.start - self.centre
        place: FloatArray = self.centre + np.array([c * x - s * y, s * x + c * y])
        return place

    def reversed(self) -> "ArcPiece":
        """Give it from end to start."""
        return replace(self, start=self.end, end=self.start, turn=-self.turn)

    def between(self, start: FloatArray, end: FloatArray) -> "ArcPiece":
        """Give it with its ends moved a little: the same turn over the new chord."""
        if abs(self.turn) >= 2.0 * pi:
            return replace(self, start=start, end=start, centre=self.centre + (start - self.start))
        return ArcPiece.bulging(start, end, self.bulge)


@dataclass(frozen=True, slots=True, eq=False)
class SplinePiece:
    """A piece that is a B-spline or a NURBS."""

    curve: BSpline
    """The curve, in the plane; it begins and ends in its outer control points."""

    def __post_init__(self) -> None:
        if self.curve.points.shape[1] != 2:
            raise ValueError(f"curve: want it in the plane, got {self.curve.points.shape[1]}-D")
        object.__setattr__(self, "curve", self.curve.clamped())

    @property
    def start(self) -> FloatArray:
        """Where it begins, shape (2,), m."""
        place: FloatArray = self.curve.points[0]
        return place

    @property
    def end(self) -> FloatArray:
        """Where it ends, shape (2,), m."""
        place: FloatArray = self.curve.points[-1]
        return place

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(self.curve.length())

    @property
    def middle(self) -> FloatArray:
        """The point in the middle of its domain, shape (2,), m."""
        first, last = self.curve.domain
        place: FloatArray = self.curve.at(0.5 * (first + last))
        return place

    def reversed(self) -> "SplinePiece":
        """Give it from end to start."""
        return SplinePiece(self.curve.reversed())

    def between(self, start: FloatArray, end: FloatArray) -> "SplinePiece":
        """Give it with its ends moved a little."""
        points = np.array(self.curve.points)
        points[0], points[-1] = start, end
        return SplinePiece(replace(self.curve, points=points))


Piece = LinePiece | ArcPiece | SplinePiece
"""What a drawing is made of."""


def is_full_circle(piece: Piece) -> bool:
    """Say whether a piece is a circle all the way round."""
    return isinstance(piece, ArcPiece) and abs(piece.turn) >= 2.0 * pi
