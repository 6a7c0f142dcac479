"""B-spline curves of any degree: clamped, unclamped or closed."""

import operator
from dataclasses import dataclass
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import basis, knot

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)

_LENGTH_ACCURACY = 1e-15
_MOST_HALVINGS = 40


@dataclass(frozen=True, slots=True, eq=False)
class BSpline:
    """A polynomial B-spline curve, defined on ``domain`` and nowhere else.

    The domain goes from knot ``degree`` to the knot that has as many after it. With end knots
    of multiplicity degree + 1 the curve is clamped: it starts and ends in its outer points.
    """

    knots: FloatArray
    """Knots, shape (m + degree + 1,), never falling."""
    points: FloatArray
    """Control points, shape (m, dim)."""
    degree: int
    """Degree, a whole number of at least 0."""

    def __post_init__(self) -> None:
        if operator.index(self.degree) < 0:
            raise ValueError(f"degree: want a whole number of at least 0, got {self.degree!r}")
        points = frozen_array(self.points, (None, None), "points")
        if points.shape[0] <= self.degree or points.shape[1] == 0:
            raise ValueError(
                f"points: want at least {self.degree + 1} of at least one coordinate for degree "
                f"{self.degree}, got shape {points.shape}"
            )
        knots = frozen_array(self.knots, (len(points) + self.degree + 1,), "knots")
        if (np.diff(knots) < 0.0).any():
            raise ValueError(f"knots: want them never falling, got {knots.tolist()}")
        if (knots[self.degree + 1 :] <= knots[: -self.degree - 1]).any():
            raise ValueError(
                f"knots: want none more than {self.degree + 1} times for degree {self.degree}, "
                f"got {knots.tolist()}"
            )
        object.__setattr__(self, "knots", knots)
        object.__setattr__(self, "points", points)
        if self.domain[0] >= self.domain[1]:
            raise ValueError(f"knots: want a domain of some length, got {self.domain}")

    @classmethod
    def closed(cls, knots: ArrayInput, points: ArrayInput, degree: int) -> Self:
        """Give the closed curve of a ring of control points.

        Args:
            knots: The m + 1 different or repeated knots of one turn, first to last.
            points: The ring, shape (m, dim).
            degree: Degree.

        Raises:
            ValueError: If the numbers do not fit.
        """
        ring = frozen_array(points, (None, None), "points")
        m = len(ring)
        turn = frozen_array(knots, (m + 1,), "knots")
        steps = np.diff(turn)[np.arange(-degree, m + degree) % m]
        unrolled = turn[0] + np.concatenate(([0.0], np.cumsum(steps))) - steps[:degree].sum()
        unrolled[degree : degree + m + 1] = turn
        return cls(unrolled, ring[np.arange(m + degree) % m], degree)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[self.degree]), float(self.knots[-self.degree - 1])

    @property
    def dim(self) -> int:
        """Number of coordinates."""
        return int(self.points.shape[1])

    @property
    def breaks(self) -> FloatArray:
        """The different knots of the domain: the ends of the polynomial pieces."""
        return np.unique(self.knots[self.degree : self.knots.size - self.degree])

    def at(self, u: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give points of the curve, or of one of its derivatives, shape (..., dim).

        Args:
            u: Parameters in the domain, shape (...).
            derivative: Which derivative by the parameter; 0 is the curve.

        Raises:
            CurveError: If a parameter lies outside the domain or is not a number.
            ValueError: If the derivative is negative.
        """
        if derivative < 0:
            raise ValueError(f"derivative: want 0 or more, got {derivative}")
        parameters = np.asarray(u, dtype=np.float64)
        self._check_inside(parameters)
        if parameters.ndim == 0:
            return basis.evaluate_one(
                self.knots, self.points, self.degree, float(parameters), derivative
            )
        values = basis.evaluate(
            self.knots, self.points, self.degree, parameters.ravel(), derivative
        )
        return values.reshape(*parameters.shape, self.dim)

    def derivative(self, times: int = 1) -> "BSpline":
        """Give the curve of the derivative, of lower degree (never below 0).

        Raises:
            ValueError: If ``times`` is negative.
        """
        if times < 0:
            raise ValueError(f"times: want 0 or more, got {times}")
        knots, points, degree = self.knots, self.points, self.degree
        for _ in range(times):
            if degree == 0:
                return BSpline(knots, np.zeros_like(points), 0)
            knots, points = basis.derivative_points(knots, points, degree)
            degree -= 1
        return BSpline(knots, points, degree)

    def with_knots(self, us: ArrayInput) -> "BSpline":
        """Give the same curve with more knots inside its domain.

        Args:
            us: The knots to insert, shape (k,); one named twice is inserted twice.

        Raises:
            CurveError: If one lies outside the domain.
            ValueError: If one would be there more than ``degree`` times.
        """
        knots, points = self.knots, self.points
        new = frozen_array(us, (None,), "us")
        self._check_inside(new)
        for u in new:
            if np.count_nonzero(knots == u) >= self.degree:
                raise ValueError(f"us: knot {u} would be there more than {self.degree} times")
            knots, points = knot.insert_knot(knots, points, self.degree, float(u))
        return BSpline(knots, points, self.degree)

    def bezier(self) -> tuple[FloatArray, FloatArray]:
        """Give the Bezier pieces: their k + 1 ends and points of shape (k, degree + 1, dim)."""
        return knot.bezier_points(self.knots, self.points, self.degree)

    def part(self, start: float, end: float) -> "BSpline":
        """Give the clamped piece between two parameters; it keeps its parameters.

        Raises:
            CurveError: If one lies outside the domain.
            ValueError: If they do not rise.
        """
        self._check_inside(np.array([start, end]))
        if not start < end:
            raise ValueError(f"part: want start below end, got {start} and {end}")
        if self.degree == 0:
            inner = self.knots[(self.knots > start) & (self.knots < end)]
            knots = np.concatenate(([start], inner, [end]))
            spans = basis.find_spans(self.knots, 0, knots[:-1])
            return BSpline(knots, self.points[spans], 0)
        knots, points = knot.trim(self.knots, self.points, self.degree, start, end)
        return BSpline(knots, points, self.degree)

    def split(self, u: float) -> "tuple[BSpline, BSpline]":
        """Give the clamped pieces before and after a parameter inside the domain.

        Raises:
            CurveError: If it does not lie strictly inside.
        """
        start, end = self.domain
        if not start < u < end:
            raise CurveError(f"can be split between {start} and {end} only, not at {u}", "B-spline")
        return self.part(start, u), self.part(u, end)

    def is_closed(self, derivatives: int = 0, tolerance: float = 1e-9) -> bool:
        """Tell whether the curve ends as it starts, with so many of its derivatives."""
        ends = np.array(self.domain)
        for order in range(derivatives + 1):
            first, last = self.at(ends, order)
            if np.abs(last - first).max() > tolerance * max(1.0, float(np.abs(first).max())):
                return False
        return True

    def length(self, start: float | None = None, end: float | None = None) -> float:
        """Give the arc length between two parameters, by default of the whole curve.

        Gauss quadrature of each piece, halved where that changes it: exact to rounding, also near
        places where the curve hardly moves.

        Raises:
            CurveError: If one lies outside the domain.
        """
        low, high = self.domain
        low, high = low if start is None else start, high if end is None else end
        self._check_inside(np.array([low, high]))
        if high < low:
            return -self.length(high, low)
        inner = self.breaks
        ends = np.concatenate(([low], inner[(inner > low) & (inner < high)], [high]))
        return _quadrature(self, ends[:-1], ends[1:])

    def _check_inside(self, u: FloatArray) -> None:
        start, end = self.domain
        outside = ~((u >= start) & (u <= end))
        if outside.any():
            where = float(u.ravel()[int(np.argmax(outside.ravel()))])
            raise CurveError(f"defined from {start} to {end}, not at {where}", "B-spline")


def _quadrature(curve: BSpline, starts: FloatArray, ends: FloatArray) -> float:
    """Give the arc length over pieces, each halved until its length no longer changes."""
    total = 0.0
    lengths = _gauss_lengths(curve, starts, ends)
    accuracy = _LENGTH_ACCURACY * float(lengths.sum())
    for _ in range(_MOST_HALVINGS):
        middles = 0.5 * (starts + ends)
        first, last = _gauss_lengths(curve, starts, middles), _gauss_lengths(curve, middles, ends)
        rough = np.abs(first + last - lengths) > accuracy
        total += float((first + last)[~rough].sum())
        starts, ends = (
            np.append(starts, middles)[np.tile(rough, 2)],
            np.append(middles, ends)[np.tile(rough, 2)],
        )
        lengths = np.append(first, last)[np.tile(rough, 2)]
        if not rough.any():
            break
    return total + float(lengths.sum())


def _gauss_lengths(curve: BSpline, starts: FloatArray, ends: FloatArray) -> FloatArray:
    half = 0.5 * (ends - starts)[:, None]
    u = np.minimum(starts[:, None] + half * (1.0 + _NODES), ends[:, None])
    speed = np.linalg.norm(curve.at(u, 1), axis=-1)
    lengths: FloatArray = np.sum(speed * _WEIGHTS * half, axis=1)
    return lengths
