"""What a conic is: its kind, and its place, size and shape."""

from dataclasses import dataclass
from enum import StrEnum
from math import cos, hypot, pi, sin

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import conic
from .bspline import BSpline
from .plane import Plane


class ConicKind(StrEnum):
    """What the points of an equation of second degree are."""

    CIRCLE = "circle"
    ELLIPSE = "ellipse"
    PARABOLA = "parabola"
    HYPERBOLA = "hyperbola"
    POINT = "point"
    CROSSING_LINES = "crossing lines"
    PARALLEL_LINES = "parallel lines"
    DOUBLE_LINE = "double line"
    LINE = "line"
    NOTHING = "nothing"


_CLOSED = (ConicKind.CIRCLE, ConicKind.ELLIPSE)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ConicForm:
    """A conic in the axes in which its equation is shortest.

    Seen from ``centre``, with x turned by ``turn``, it is: for circle and ellipse
    x^2 / a^2 + y^2 / b^2 = 1 with a >= b; for the hyperbola x^2 / a^2 - y^2 / b^2 = 1; for the
    parabola y^2 = 4 a x; for crossing lines x^2 / a^2 = y^2 / b^2 with a^2 + b^2 = 1; for parallel
    lines y^2 = b^2; for one line y = 0. What does not occur is 0; of nothing all is 0.
    """

    kind: ConicKind
    """What it is."""
    centre: FloatArray
    """Centre, of a parabola its vertex, of a line some point of it, shape (2,)."""
    turn: float
    """Angle from the x axis to the conic's own, rad."""
    a: float
    """Half axis along x, of a parabola the distance from its vertex to its focus."""
    b: float
    """Half axis along y, of parallel lines half their distance."""

    @property
    def plane(self) -> Plane:
        """The plane of two coordinates in which the conic's own axes are x and y."""
        return Plane.turned(self.centre, self.turn)

    @property
    def eccentricity(self) -> float:
        """0 for a circle, below 1 for an ellipse, 1 for a parabola, above 1 for a hyperbola.

        Raises:
            CurveError: If the conic is degenerate.
        """
        if self.kind in _CLOSED:
            return float(np.sqrt((1.0 - self.b / self.a) * (1.0 + self.b / self.a)))
        if self.kind is ConicKind.PARABOLA:
            return 1.0
        if self.kind is ConicKind.HYPERBOLA:
            return hypot(1.0, self.b / self.a)
        raise CurveError(f"has no eccentricity: {self.kind}", "conic")

    @property
    def foci(self) -> FloatArray:
        """The foci, shape (2, 2), of a circle and a parabola one, shape (1, 2).

        Raises:
            CurveError: If the conic is degenerate.
        """
        distance = self.a * self.eccentricity
        if self.kind in (ConicKind.CIRCLE, ConicKind.PARABOLA):
            distances = [distance if self.kind is ConicKind.PARABOLA else 0.0]
        else:
            distances = [distance, -distance]
        return self.plane.points([[x, 0.0] for x in distances])

    @property
    def lines(self) -> FloatArray:
        """The straight lines it consists of, a point and a unit direction each, shape (k, 2, 2).

        Of a hyperbola they are the asymptotes; otherwise k is 0, 1 or 2.
        """
        x, y = (
            np.array([cos(self.turn), sin(self.turn)]),
            np.array([-sin(self.turn), cos(self.turn)]),
        )
        if self.kind in (ConicKind.CROSSING_LINES, ConicKind.HYPERBOLA):
            along, across = self.a * x, self.b * y
            ways = np.array([along + across, along - across]) / hypot(self.a, self.b)
            return np.stack((np.tile(self.centre, (2, 1)), ways), axis=1)
        if self.kind is ConicKind.PARALLEL_LINES:
            away = self.b * y
            return np.array([[self.centre + away, x], [self.centre - away, x]])
        if self.kind in (ConicKind.DOUBLE_LINE, ConicKind.LINE):
            return np.array([[self.centre, x]])
        return np.empty((0, 2, 2))

    def curve(self, start: float = 0.0, end: float = 2.0 * pi, branch: int = 1) -> BSpline:
        """Give the conic, or the piece of it between two parameters v, as an exact B-spline.

        Args:
            start: First v: of circle and ellipse (a cos v, b sin v); of the parabola
                (a v^2, 2 a v); of the hyperbola (a cosh v, b sinh v); of a line the way from its
                centre, in the unit of the coordinates.
            end: Last v; by default 2 pi, with which circles and ellipses are whole.
            branch: Which branch of a hyperbola, or which of two lines: 1 or -1.

        Raises:
            CurveError: If it is nothing or a point.
            ValueError: If the piece has no length, or the branch is neither.
        """
        if branch not in (1, -1):
            raise ValueError(f"branch: want 1 or -1, got {branch}")
        if self.kind in _CLOSED:
            return conic.elliptic_arc((self.a, self.b), start, end, self.plane)
        if self.kind is ConicKind.PARABOLA:
            return conic.parabola(self.a, start, end, self.plane)
        if self.kind is ConicKind.HYPERBOLA:
            turn = self.turn if branch == 1 else self.turn + pi
            plane = Plane.turned(self.centre, turn)
            return conic.hyperbola((self.a, self.b), start, end, plane)
        lines = self.lines
        if not len(lines):
            raise CurveError(f"there is no curve: {self.kind}", "conic")
        point, direction = lines[0 if branch == 1 else -1]
        return conic.line(point + start * direction, point + end * direction)
