"""Equations of second degree in the plane: what they are, and where they meet lines.

Every decision compares numbers of one dimension, so that the equation may be multiplied by
anything and be in any unit of length. A tolerance says which share of its terms a sum may be to
count as zero.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, hypot, pi, sqrt
from typing import NamedTuple, Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import bernstein
from .bspline import BSpline
from .conic_form import ConicForm, ConicKind

TOLERANCE = 1e-13
"""What counts as zero, as a share of the terms it is the sum of."""


class LineMeeting(NamedTuple):
    """Where a conic and a line meet."""

    points: FloatArray
    """The points, along the line, shape (k, 2)."""
    touches: bool
    """Whether the one point is a double one: the line is a tangent, or meets where lines cross."""
    contained: bool
    """Whether the whole line belongs to the conic; there are no points then."""


@dataclass(frozen=True, slots=True, eq=False)
class ConicEquation:
    """The points with a x^2 + b x y + c y^2 + d x + e y + f = 0."""

    coefficients: FloatArray
    """The numbers a, b, c, d, e, f, shape (6,), not all 0; any multiple means the same."""

    def __post_init__(self) -> None:
        numbers = frozen_array(self.coefficients, (6,), "coefficients")
        if not numbers.any():
            raise ValueError("coefficients: want some other than 0: every point fulfils 0 = 0")
        object.__setattr__(self, "coefficients", numbers)

    @classmethod
    def through(cls, points: ArrayInput, tolerance: float = TOLERANCE) -> Self:
        """Give the conic through five points, shape (5, 2).

        Raises:
            CurveError: If there are several: two points are the same, or four lie on a line.
        """
        array = frozen_array(points, (5, 2), "points")
        centre = array.mean(axis=0)
        size = float(np.abs(array - centre).max())
        if size == 0.0:
            raise CurveError("all five points are the same", "conic")
        x, y = ((array - centre) / size).T
        rows = np.stack((x * x, x * y, y * y, x, y, np.ones(5)), axis=1)
        _, singular, basis = np.linalg.svd(rows)
        if singular[-1] <= tolerance * singular[0]:
            raise CurveError(
                "several conics go through the five points: two are the same or four on a line",
                "conic",
            )
        return cls(_moved(basis[-1], centre, size))

    @classmethod
    def of(cls, curve: BSpline, tolerance: float = 1e-9) -> Self:
        """Give the equation that all points of a curve of degree 2 in the plane fulfil.

        Args:
            curve: The curve, polynomial or rational; all its pieces must be of one conic.
            tolerance: By how much of the curve's size other pieces may be off the first one.

        Raises:
            CurveError: If it is of another degree, straight, or of several conics.
        """
        if curve.degree != 2 or curve.dim != 2:
            raise CurveError(
                f"want degree 2 and 2 coordinates, got {curve.degree} and {curve.dim}", "conic"
            )
        centre = curve.points.mean(axis=0)
        size = float(np.abs(curve.points - centre).max())
        rows = curve.homogeneous.copy()
        rows[:, :2] = (curve.points - centre) / size * rows[:, 2:]
        ends, pieces = bernstein.bezier_pieces(curve.knots, rows, 2)
        largest = int(np.argmax(np.abs(np.linalg.det(pieces))))
        h0, h1, h2 = pieces[largest] / np.abs(pieces[largest]).max()
        # X = B0 h0 + B1 h1 + B2 h2 with B1^2 = 4 B0 B2, and Bi = X (hj x hk) / det
        n0, n1, n2 = np.cross(h1, h2), np.cross(h2, h0), np.cross(h0, h1)
        if abs(float(h0 @ n0)) <= TOLERANCE:
            raise CurveError("the curve is straight: a line has no equation of its own", "conic")
        M = np.outer(n1, n1) - 2.0 * (np.outer(n0, n2) + np.outer(n2, n0))
        found = np.array([M[0, 0], 2 * M[0, 1], M[1, 1], 2 * M[0, 2], 2 * M[1, 2], M[2, 2]])
        equation = cls(_moved(found / np.abs(found).max(), centre, size))
        u = (ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, 5)).ravel()
        points = curve.at(u)
        slope = np.linalg.norm(equation.gradient(points), axis=-1)
        off = np.abs(equation.value(points)) > tolerance * size * slope
        if off.any():
            where = float(u[int(np.argmax(off))])
            raise CurveError(f"its pieces are of several conics, as at u = {where}", "conic")
        return equation

    def value(self, points: ArrayInput) -> FloatArray:
        """Give the left side of the equation at points, (..., 2) to (...)."""
        a, b, c, d, e, f = self.coefficients
        xy = np.asarray(points, dtype=np.float64)
        x, y = xy[..., 0], xy[..., 1]
        left: FloatArray = (a * x + b * y + d) * x + (c * y + e) * y + f
        return left

    def gradient(self, points: ArrayInput) -> FloatArray:
        """Give the gradient of the left side at points, (..., 2) to (..., 2)."""
        a, b, c, d, e, _ = self.coefficients
        xy = np.asarray(points, dtype=np.float64)
        x, y = xy[..., 0], xy[..., 1]
        return np.stack((2.0 * a * x + b * y + d, b * x + 2.0 * c * y + e), axis=-1)

    def form(self, tolerance: float = TOLERANCE) -> ConicForm:
        """Give what the conic is: kind, centre, axes.

        Args:
            tolerance: Which share of its terms a sum may be to count as zero. It decides between
                an ellipse and a parabola (the smaller eigenvalue of the quadratic part beside the
                larger), a circle and an ellipse, a conic and its degenerate case.
        """
        a, b, c, d, e, f = (float(x) for x in self.coefficients / np.abs(self.coefficients).max())
        if a == b == c == 0.0:
            return _line(d, e, f)
        # eigenvalues of the quadratic part: the larger one first, the smaller from their product,
        # which does not suffer from cancellation of the sum
        spread = hypot(0.5 * (a - c), 0.5 * b)
        large = 0.5 * (a + c) + (spread if a + c >= 0.0 else -spread)
        small = (a * c - 0.25 * b * b) / large
        even = spread <= tolerance * abs(large)
        # the direction of the smaller: along an ellipse, across the gap of lines
        angle = 0.0 if even else 0.5 * atan2(b, a - c) + (0.5 * pi if a + c >= 0.0 else 0.0)
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        g = 0.5 * np.array([d, e])
        g_along, g_across = float(g @ along), float(g @ across)
        if abs(small) <= tolerance * abs(large):
            axes = along, across
            return _parabolic(large, (g_along, g_across), f, axes, tolerance)
        x, y = -g_along / small, -g_across / large
        terms = abs(f), abs(g_along * x), abs(g_across * y)
        rest = f + g_along * x + g_across * y
        if abs(rest) <= tolerance * sum(terms):
            rest = 0.0
        return _central(x * along + y * across, angle, (small, large), rest, even=even)

    def meet_line(
        self, point: ArrayInput, direction: ArrayInput, tolerance: float = TOLERANCE
    ) -> LineMeeting:
        """Give where the conic meets a line.

        Args:
            point: A point of the line, shape (2,).
            direction: Its direction, of any length but 0, shape (2,).
            tolerance: Which share of its terms a sum may be to count as zero: then the line
                touches, or meets once only, or lies on the conic.
        """
        p, way = frozen_array(point, (2,), "point"), frozen_array(direction, (2,), "direction")
        if not way.any():
            raise ValueError("direction: want one other than 0, got [0.0, 0.0]")
        way = way / np.abs(way).max()
        way /= np.linalg.norm(way)
        a, b, c, _, _, _ = self.coefficients
        bends = a * way[0] ** 2, b * way[0] * way[1], c * way[1] ** 2
        if abs(sum(bends)) <= tolerance * sum(map(abs, bends)):
            return self._meet_once(p, way, tolerance)
        bend = float(sum(bends))
        # halfway between both points the equation, along the line, is at its extreme
        middle = p - way * (float(self.gradient(p) @ way) / (2.0 * bend))
        left = float(self.value(middle))
        if abs(left) <= tolerance * self._size(middle):
            return LineMeeting(middle[None], touches=True, contained=False)
        if left / bend > 0.0:
            return LineMeeting(np.empty((0, 2)), touches=False, contained=False)
        half = sqrt(-left / bend)
        points = np.array([middle - half * way, middle + half * way])
        return LineMeeting(points, touches=False, contained=False)

    def _meet_once(self, p: FloatArray, way: FloatArray, tolerance: float) -> LineMeeting:
        """Give where the equation is linear along the line: it meets once, never or always."""
        left, slope = float(self.value(p)), float(self.gradient(p) @ way)
        if abs(slope) > tolerance * float(self._slopes(p) @ np.abs(way)):
            points = (p - way * (left / slope))[None]
            return LineMeeting(points, touches=False, contained=False)
        inside = abs(left) <= tolerance * self._size(p)
        return LineMeeting(np.empty((0, 2)), touches=False, contained=inside)

    def polar(self, point: ArrayInput) -> FloatArray:
        """Give the polar of a point, of a point of the conic its tangent, shape (3,).

        The line is l x + m y + n = 0 with l^2 + m^2 = 1.

        Raises:
            CurveError: If it has none: the point is the centre, or where lines cross.
        """
        p = frozen_array(point, (2,), "point")
        l, m = self.gradient(p)
        size = hypot(float(l), float(m))
        if size <= TOLERANCE * float(self._slopes(p).max()):
            raise CurveError(f"the point {p.tolist()} has no tangent or polar", "conic")
        d, e, f = self.coefficients[3:]
        return np.array([l, m, d * p[0] + e * p[1] + 2.0 * f]) / size

    def tangents_from(self, point: ArrayInput, tolerance: float = TOLERANCE) -> FloatArray:
        """Give the points where tangents from a point touch the conic, shape (k, 2).

        None from inside; from a point of the conic that point itself.

        Raises:
            CurveError: If the point has no polar.
        """
        l, m, n = self.polar(point)
        p = frozen_array(point, (2,), "point")
        # the place of the polar nearest to the point, which may be far from the origin
        foot = p - (l * p[0] + m * p[1] + n) * np.array([l, m])
        return self.meet_line(foot, (-m, l), tolerance).points

    def _slopes(self, p: FloatArray) -> FloatArray:
        """Give the sums of the sizes of the terms of both parts of the gradient."""
        a, b, c, d, e, _ = np.abs(self.coefficients)
        x, y = np.abs(p)
        return np.array([2.0 * a * x + b * y + d, b * x + 2.0 * c * y + e])

    def _size(self, p: FloatArray) -> float:
        """Give the sum of the sizes of the terms at a point."""
        x, y = np.abs(p)
        return float(np.abs(self.coefficients) @ np.array([x * x, x * y, y * y, x, y, 1.0]))


def _moved(coefficients: FloatArray, centre: FloatArray, size: float) -> FloatArray:
    """Give the equation in x of one in (x - centre) / size, times size^2."""
    a, b, c, d, e, f = coefficients
    x, y = centre
    d, e, f = d * size, e * size, f * size * size
    return np.array(
        [
            a,
            b,
            c,
            d - 2.0 * a * x - b * y,
            e - b * x - 2.0 * c * y,
            f + (a * x + b * y - d) * x + (c * y - e) * y,
        ]
    )


def _line(d: float, e: float, f: float) -> ConicForm:
    if d == e == 0.0:
        return _nothing()
    size = hypot(d, e)
    point = np.array([-d, -e]) / size * (f / size)
    return _form(ConicKind.LINE, point, atan2(d, -e))


def _nothing() -> ConicForm:
    return _form(ConicKind.NOTHING, np.zeros(2), 0.0)


def _form(
    kind: ConicKind, centre: FloatArray, turn: float, sizes: Sequence[float] = (0.0, 0.0)
) -> ConicForm:
    """Give a form with its turn in (-pi / 2, pi / 2], of a parabola in (-pi, pi]."""
    period = 2.0 * pi if kind is ConicKind.PARABOLA else pi
    turn -= period * np.ceil(turn / period - 0.5)
    a, b = sizes
    return ConicForm(kind=kind, centre=centre + 0.0, turn=float(turn), a=float(a), b=float(b))


def _central(
    centre: FloatArray,
    angle: float,
    eigenvalues: tuple[float, float],
    rest: float,
    *,
    even: bool,
) -> ConicForm:
    """Give the form of small x^2 + large y^2 + rest = 0 about the centre."""
    small, large = eigenvalues
    around = small * large > 0.0
    if around and rest * large > 0.0:
        return _nothing()
    if rest == 0.0 and around:
        return _form(ConicKind.POINT, centre, 0.0)
    if rest == 0.0:
        sizes = sqrt(abs(large)), sqrt(abs(small))
        top = hypot(*sizes)
        return _form(ConicKind.CROSSING_LINES, centre, angle, (sizes[0] / top, sizes[1] / top))
    sizes = sqrt(abs(rest / small)), sqrt(abs(rest / large))
    if around and even:
        radius = sqrt(sizes[0] * sizes[1])
        return _form(ConicKind.CIRCLE, centre, 0.0, (radius, radius))
    if not around and rest * small > 0.0:
        # its vertices lie on the other axis
        angle, sizes = angle + 0.5 * pi, sizes[::-1]
    return _form(ConicKind.ELLIPSE if around else ConicKind.HYPERBOLA, centre, angle, sizes)


def _parabolic(
    large: float,
    g: tuple[float, float],
    f: float,
    axes: tuple[FloatArray, FloatArray],
    tolerance: float,
) -> ConicForm:
    """Give the form of large y^2 + 2 g x + 2 g y + f = 0 along two axes."""
    along, across = axes
    g_along, g_across = g
    y = -g_across / large
    angle = atan2(float(along[1]), float(along[0]))
    if abs(g_along) > tolerance * hypot(g_along, g_across, sqrt(abs(large * f))):
        # the vertex: large (y - y0)^2 = -2 g (x - x0)
        x = -(f + g_across * y) / (2.0 * g_along)
        focal = -0.5 * g_along / large
        turn = angle if focal > 0.0 else angle + pi
        vertex = x * along + y * across
        return _form(ConicKind.PARABOLA, vertex, turn, (abs(focal), 0.0))
    square, free = g_across * g_across, large * f
    gap = square - free
    centre = y * across
    if abs(gap) <= tolerance * (square + abs(free)):
        return _form(ConicKind.DOUBLE_LINE, centre, angle)
    if gap < 0.0:
        return _nothing()
    return _form(ConicKind.PARALLEL_LINES, centre, angle, (0.0, sqrt(gap) / abs(large)))
