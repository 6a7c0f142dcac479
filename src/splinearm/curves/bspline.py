"""B-spline curves of any degree: polynomial or rational; clamped, unclamped or closed."""

import operator
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import basis, form, knot, quadrature, rational
from .sampler import Sampler, polynomial_table


@dataclass(frozen=True, slots=True, eq=False)
class BSpline:
    """A B-spline curve, defined on ``domain`` and nowhere else; with weights it is a NURBS.

    The domain goes from knot ``degree`` to the knot that has as many after it. With end knots
    of multiplicity degree + 1 the curve is clamped: it starts and ends in its outer points.
    """

    knots: FloatArray
    """Knots, shape (m + degree + 1,), never falling."""
    points: FloatArray
    """Control points, shape (m, dim)."""
    degree: int
    """Degree, a whole number of at least 0."""
    weights: FloatArray | None = None
    """Weights of the control points, shape (m,), each above 0; None: the curve is polynomial."""
    _rows: FloatArray = field(init=False, repr=False)
    """What the basis functions multiply: the points, of a rational curve the homogeneous ones."""

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
        weights = self.weights
        if weights is not None:
            weights = frozen_array(weights, (len(points),), "weights")
            if not (weights > 0.0).all():
                raise ValueError(f"weights: want each above 0, got {weights.tolist()}")
        object.__setattr__(self, "knots", knots)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "weights", weights)
        rows = points if weights is None else rational.homogeneous(points, weights)
        object.__setattr__(self, "_rows", rows)
        if self.domain[0] >= self.domain[1]:
            raise ValueError(f"knots: want a domain of some length, got {self.domain}")

    @classmethod
    def closed(
        cls, knots: ArrayInput, points: ArrayInput, degree: int, weights: ArrayInput | None = None
    ) -> Self:
        """Give the closed curve of a ring of control points.

        Args:
            knots: The m + 1 different or repeated knots of one turn, first to last.
            points: The ring, shape (m, dim).
            degree: Degree.
            weights: Weights of the ring, shape (m,), or None.

        Raises:
            ValueError: If the numbers do not fit.
        """
        ring = frozen_array(points, (None, None), "points")
        m = len(ring)
        turn = frozen_array(knots, (m + 1,), "knots")
        around = np.arange(m + degree) % m
        shares = None if weights is None else frozen_array(weights, (m,), "weights")[around]
        return cls(form.wrapped_knots(turn, degree), ring[around], degree, shares)

    @classmethod
    def from_homogeneous(cls, knots: ArrayInput, rows: ArrayInput, degree: int) -> Self:
        """Give the rational curve of homogeneous control points.

        Args:
            knots: Knots, shape (m + degree + 1,).
            rows: Points times weight, then the weight, shape (m, dim + 1).
            degree: Degree.

        Raises:
            ValueError: If the numbers do not fit, or a weight is not above 0.
        """
        array = frozen_array(rows, (None, None), "rows")
        if not (array[:, -1] > 0.0).all():
            raise ValueError(f"rows: want each weight above 0, got {array[:, -1].tolist()}")
        points = array[:, :-1] / array[:, -1:]
        return cls(np.asarray(knots, dtype=np.float64), points, degree, array[:, -1])

    def _like(self, knots: FloatArray, rows: FloatArray, degree: int) -> "BSpline":
        """Give a curve of the same kind from knots and rows that were computed from those here."""
        if self.weights is not None:
            rational.check_weights(rows)
            return BSpline.from_homogeneous(knots, rows, degree)
        # what was checked is not checked again: that would take longer than most changes
        curve = object.__new__(BSpline)
        for name, value in (("knots", knots), ("points", rows), ("_rows", rows)):
            value.flags.writeable = False
            object.__setattr__(curve, name, value)
        object.__setattr__(curve, "degree", degree)
        object.__setattr__(curve, "weights", None)
        return curve

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[self.degree]), float(self.knots[-self.degree - 1])

    @property
    def dim(self) -> int:
        """Number of coordinates."""
        return int(self.points.shape[1])

    @property
    def is_rational(self) -> bool:
        """Whether the curve has weights."""
        return self.weights is not None

    @property
    def homogeneous(self) -> FloatArray:
        """Control points times weight, then the weight, shape (m, dim + 1)."""
        if self.weights is not None:
            return self._rows
        return np.column_stack((self.points, np.ones(len(self.points))))

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
        if self.weights is not None:
            return self.jet(parameters, derivative)[..., derivative, :]
        if parameters.ndim == 0:
            return basis.evaluate_one(
                self.knots, self.points, self.degree, float(parameters), derivative
            )
        flat = parameters.ravel()
        values = basis.evaluate(self.knots, self.points, self.degree, flat, derivative)
        return values.reshape(*parameters.shape, self.dim)

    def jet(self, u: ArrayInput, order: int) -> FloatArray:
        """Give points of the curve and its derivatives at once, shape (..., order + 1, dim).

        Args:
            u: Parameters in the domain, shape (...).
            order: The highest derivative.

        Raises:
            CurveError: If a parameter lies outside the domain or is not a number.
            ValueError: If the order is negative.
        """
        if order < 0:
            raise ValueError(f"order: want 0 or more, got {order}")
        parameters = np.asarray(u, dtype=np.float64)
        self._check_inside(parameters)
        flat = parameters.ravel()
        rows = np.stack(
            [basis.evaluate(self.knots, self._rows, self.degree, flat, j) for j in range(order + 1)]
        )
        values = rows if self.weights is None else rational.quotient(rows)
        shape = (*parameters.shape, order + 1, self.dim)
        return np.moveaxis(values, 0, 1).reshape(shape)

    def sampler(self) -> Sampler:
        """Give what samples this curve quickly: in a control loop, or at many parameters."""
        weighted = self.is_rational
        return Sampler(polynomial_table(self.knots, self._rows, self.degree, rational=weighted))

    def derivative(self, times: int = 1) -> "BSpline":
        """Give the curve of the derivative, of lower degree (never below 0).

        That of a rational curve of degree p is one of degree 2 p.

        Raises:
            ValueError: If ``times`` is negative.
        """
        if times < 0:
            raise ValueError(f"times: want 0 or more, got {times}")
        if times == 0:
            return self
        if self.weights is not None:
            from .product import derivative_of

            return derivative_of(self).derivative(times - 1)
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
        knots, rows = self.knots, self._rows
        self._check_inside(new := frozen_array(us, (None,), "us"))
        knots, rows = knot.refine(self.knots, self._rows, self.degree, new)
        times = knots.searchsorted(new, side="right") - knots.searchsorted(new, side="left")
        if (times > self.degree).any():
            often = float(new[int(np.argmax(times > self.degree))])
            raise ValueError(f"us: knot {often} would be there more than {self.degree} times")
        if self.is_periodic:
            seam = form.seam_of(self.knots, self.degree) + int(np.isin(new, self.domain).sum())
            knots, rows = form.close(knots, rows, self.degree, seam=seam)
        return self._like(knots, rows, self.degree)

    def elevated(self, times: int = 1) -> "BSpline":
        """Give the same curve with a higher degree.

        Raises:
            ValueError: If ``times`` is negative.
        """
        if times < 0:
            raise ValueError(f"times: want 0 or more, got {times}")
        knots, rows, degree = self.knots, self._rows, self.degree
        for _ in range(times):
            knots, rows = knot.elevate(knots, rows, degree)
            degree += 1
        if times and self.is_periodic:
            knots, rows = form.close(
                knots, rows, degree, seam=form.seam_of(self.knots, self.degree) + times
            )
        return self._like(knots, rows, degree)

    def clamped(self) -> "BSpline":
        """Give the same curve with end knots that are there degree + 1 times."""
        return self._like(
            *knot.trim(self.knots, self._rows, self.degree, *self.domain), self.degree
        )

    def unclamped(self) -> "BSpline":
        """Give the same curve with outer knots that repeat the steps of the other end.

        Raises:
            CurveError: If a weight would not be above 0.
        """
        return self._like(*form.unclamp(self.knots, self._rows, self.degree), self.degree)

    def periodic(self, tolerance: float = 1e-12) -> "BSpline":
        """Give the same closed curve as one of a ring of points, as ``closed`` makes them.

        The knot at the seam is there as often as the smoothness of the curve asks for.

        Args:
            tolerance: How far points that belong together may be apart, of the largest.

        Raises:
            CurveError: If the curve does not end where it starts.
        """
        knots, rows = form.close(self.knots, self._rows, self.degree, tolerance)
        return self._like(knots, rows, self.degree)

    @property
    def is_periodic(self) -> bool:
        """Whether knots and points go on after the end as they began, but for rounding."""
        return form.is_ring(self.knots, self._rows, self.degree)

    def reversed(self) -> "BSpline":
        """Give the curve run through from its end to its start, over the same domain."""
        return BSpline(
            form.moved_knots(self.knots, self.degree, *self.domain[::-1])[::-1],
            self.points[::-1],
            self.degree,
            None if self.weights is None else self.weights[::-1],
        )

    def over(self, start: float, end: float) -> "BSpline":
        """Give the curve run through evenly faster or slower, with another domain.

        Raises:
            ValueError: If start and end do not rise or are not finite.
        """
        if not (start < end and np.isfinite((start, end)).all()):
            raise ValueError(f"over: want start below end, got {start} and {end}")
        knots = form.moved_knots(self.knots, self.degree, start, end)
        return BSpline(knots, self.points, self.degree, self.weights)

    def mapped(self, matrix: ArrayInput) -> "BSpline":
        """Give the curve under an affine or projective map.

        Args:
            matrix: Homogeneous matrix on column vectors, shape (dim + 1, dim + 1). Unless its last
                row is (0 ... 0, w) the curve becomes rational.

        Raises:
            CurveError: If the map sends a place between the control points to infinity.
            ValueError: If the matrix has another shape.
        """
        map_ = frozen_array(matrix, (self.dim + 1, self.dim + 1), "matrix")
        if map_[-1, :-1].any() or map_[-1, -1] == 0.0:
            mapped = rational.map_rows(self.homogeneous, map_)
            return BSpline.from_homogeneous(self.knots, mapped, self.degree)
        map_ = map_ / map_[-1, -1]
        points = self.points @ map_[:-1, :-1].T + map_[:-1, -1]
        return BSpline(self.knots, points, self.degree, self.weights)

    def bezier(self) -> tuple[FloatArray, FloatArray]:
        """Give the Bezier pieces: their k + 1 ends and points of shape (k, degree + 1, dim).

        Of a rational curve the points are homogeneous, with dim + 1 numbers.
        """
        return knot.bezier_points(self.knots, self._rows, self.degree)

    def part(self, start: float, end: float) -> "BSpline":
        """Give the clamped piece between two parameters; it keeps its parameters.

        Raises:
            CurveError: If one lies outside the domain.
            ValueError: If they do not rise.
        """
        self._check_inside(np.array([start, end]))
        if not start < end:
            raise ValueError(f"part: want start below end, got {start} and {end}")
        knots, rows = knot.trim(self.knots, self._rows, self.degree, start, end)
        return self._like(knots, rows, self.degree)

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

        It is exact to rounding, also near places where the curve hardly moves.

        Raises:
            CurveError: If one lies outside the domain.
        """
        given = zip((start, end), self.domain, strict=True)
        low, high = (own if want is None else want for want, own in given)
        self._check_inside(np.array([low, high]))
        if high < low:
            return -self.length(high, low)
        inner = self.breaks
        ends = np.concatenate(([low], inner[(inner > low) & (inner < high)], [high]))
        return quadrature.length(self, ends[:-1], ends[1:])

    def _check_inside(self, u: FloatArray) -> None:
        start, end = self.domain
        outside = ~((u >= start) & (u <= end))
        if outside.any():
            where = float(u.ravel()[int(np.argmax(outside.ravel()))])
            raise CurveError(f"defined from {start} to {end}, not at {where}", "B-spline")
