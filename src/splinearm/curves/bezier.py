"""Bezier curves, polynomial and rational."""

from dataclasses import dataclass, field
from math import comb
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import bernstein, knot, rational
from .bspline import BSpline


@dataclass(frozen=True, slots=True, eq=False)
class Bezier:
    """A Bezier curve by a parameter u from 0 to 1; with weights a rational one."""

    points: FloatArray
    """Control points, shape (degree + 1, dim)."""
    weights: FloatArray | None = None
    """Weights of the control points, shape (degree + 1,), each above 0; None: polynomial."""
    _rows: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        points = frozen_array(self.points, (None, None), "points")
        if not points.size:
            raise ValueError(f"points: want at least one, got shape {points.shape}")
        weights = self.weights
        if weights is not None:
            weights = frozen_array(weights, (len(points),), "weights")
            if not (weights > 0.0).all():
                raise ValueError(f"weights: want each above 0, got {weights.tolist()}")
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "weights", weights)
        rows = points if weights is None else rational.homogeneous(points, weights)
        object.__setattr__(self, "_rows", rows)

    @classmethod
    def from_power(cls, coefficients: ArrayInput) -> Self:
        """Give the curve that is the sum of ``coefficients[j] * u ** j``, shape (degree + 1, dim).

        Raises:
            ValueError: If the numbers are not of that shape.
        """
        # Farouki and Rajan, On the numerical condition of polynomials in Bernstein form, CAGD 4
        # (1987) eq. 3
        c = frozen_array(coefficients, (None, None), "coefficients")
        n = len(c) - 1
        table = [[comb(i, j) / comb(n, j) for j in range(n + 1)] for i in range(n + 1)]
        return cls(np.array(table) @ c)

    @property
    def degree(self) -> int:
        """Degree: one less than the number of control points."""
        return len(self.points) - 1

    @property
    def dim(self) -> int:
        """Number of coordinates."""
        return int(self.points.shape[1])

    def at(self, u: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give points of the curve, or of one of its derivatives, shape (..., dim).

        Args:
            u: Parameters from 0 to 1, shape (...).
            derivative: Which derivative; 0 is the curve.

        Raises:
            CurveError: If a parameter lies outside.
            ValueError: If the derivative is negative.
        """
        if derivative < 0:
            raise ValueError(f"derivative: want 0 or more, got {derivative}")
        parameters = np.asarray(u, dtype=np.float64)
        _check_inside(parameters)
        flat = parameters.ravel()
        first = 0 if self.weights is not None else derivative
        jets = [_derived(self._rows, order, flat) for order in range(first, derivative + 1)]
        values = jets[-1] if self.weights is None else rational.quotient(np.stack(jets))[-1]
        return values.reshape(*parameters.shape, self.dim)

    def split(self, u: float) -> "tuple[Bezier, Bezier]":
        """Give the pieces before and after a parameter, each by its own parameter from 0 to 1.

        Raises:
            CurveError: If the parameter does not lie from 0 to 1.
        """
        _check_inside(np.asarray(u, dtype=np.float64))
        local = self._rows
        first, last = [local[0]], [local[-1]]
        while len(local) > 1:
            local = local[:-1] * (1.0 - u) + local[1:] * u
            first.append(local[0])
            last.append(local[-1])
        return self._like(np.array(first)), self._like(np.array(last[::-1]))

    def part(self, start: float, end: float) -> "Bezier":
        """Give the piece between two parameters, by its own parameter from 0 to 1.

        Raises:
            CurveError: If one does not lie from 0 to 1.
            ValueError: If they do not rise.
        """
        if not start < end:
            raise ValueError(f"part: want start below end, got {start} and {end}")
        _check_inside(np.array([start, end]))
        knots, p = self._knots(), self.degree
        ends = np.repeat([start, end], p + 1)
        return self._like(knot.over_knots(knots, self._rows, p, ends))

    def elevated(self, times: int = 1) -> "Bezier":
        """Give the same curve with more control points.

        Raises:
            ValueError: If ``times`` is negative.
        """
        if times < 0:
            raise ValueError(f"times: want 0 or more, got {times}")
        return self._like(bernstein.multiply(self._rows.T, np.ones(times + 1)).T)

    def reduced(self, tolerance: float) -> "tuple[Bezier, float]":
        """Give a curve with one control point less, and a distance that it is never farther away.

        Raises:
            CurveError: If the curve would move by more than the tolerance.
            ValueError: If the degree is below 2 or the tolerance is not at least 0.
        """
        from .removal import reduce_degree

        curve, error = reduce_degree(self.to_bspline(), tolerance)
        return Bezier(curve.points, curve.weights), error

    def derivative(self) -> "Bezier":
        """Give the derivative as a curve: of a rational one of degree p one of degree 2 p."""
        if self.degree == 0:
            return Bezier(np.zeros_like(self.points))
        if self.weights is None:
            return Bezier(np.diff(self.points, axis=0) * self.degree)
        curve = self.to_bspline().derivative()
        return Bezier(curve.points, curve.weights)

    def reversed(self) -> "Bezier":
        """Give the curve run through from its end to its start."""
        return self._like(self._rows[::-1])

    def power(self) -> FloatArray:
        """Give the coefficients of 1, u, u^2 ..., shape (degree + 1, dim).

        Of a rational curve those of the homogeneous curve, shape (degree + 1, dim + 1). High
        degrees lose digits in this form.
        """
        coefficients, local = [self._rows[0]], self._rows
        for j in range(1, self.degree + 1):
            local = np.diff(local, axis=0)
            coefficients.append(comb(self.degree, j) * local[0])
        return np.array(coefficients)

    def to_bspline(self, start: float = 0.0, end: float = 1.0) -> BSpline:
        """Give the same curve as a clamped B-spline over another domain.

        Raises:
            ValueError: If start and end do not rise.
        """
        knots = np.repeat([float(start), float(end)], self.degree + 1)
        return BSpline(knots, self.points, self.degree, self.weights)

    def _knots(self) -> FloatArray:
        return np.repeat([0.0, 1.0], self.degree + 1)

    def _like(self, rows: FloatArray) -> "Bezier":
        if self.weights is None:
            return Bezier(rows)
        return Bezier(rows[:, :-1] / rows[:, -1:], rows[:, -1])


def bezier_curves(curve: BSpline) -> list[Bezier]:
    """Give the Bezier curves that a B-spline consists of, from its start to its end."""
    _, pieces = curve.bezier()
    if curve.is_rational:
        return [Bezier(rows[:, :-1] / rows[:, -1:], rows[:, -1]) for rows in pieces]
    return [Bezier(rows) for rows in pieces]


def _derived(rows: FloatArray, order: int, u: FloatArray) -> FloatArray:
    """Give a derivative at many parameters by de Casteljau, shape (k, columns)."""
    degree = len(rows) - 1
    if order > degree:
        return np.zeros((u.size, rows.shape[1]))
    factor = 1.0
    for j in range(order):
        rows = np.diff(rows, axis=0)
        factor *= degree - j
    local = np.repeat(factor * rows[:, None], u.size, axis=1)
    share = u[:, None]
    while len(local) > 1:
        local = local[:-1] * (1.0 - share) + local[1:] * share
    value: FloatArray = local[0]
    return value


def _check_inside(u: FloatArray) -> None:
    outside = ~((u >= 0.0) & (u <= 1.0))
    if outside.any():
        where = float(u.ravel()[int(np.argmax(outside.ravel()))])
        raise CurveError(f"defined from 0 to 1, not at {where}", "Bezier curve")
