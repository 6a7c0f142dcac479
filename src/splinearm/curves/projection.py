"""The nearest place of a curve to a point, none nearer missed, and the parameter of a point."""

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .bernstein import binomials
from .bspline import BSpline


class Nearest(NamedTuple):
    """Places of a curve that are nearest to points."""

    u: FloatArray
    """Their parameters, shape (...)."""
    points: FloatArray
    """The places, shape (..., dim)."""
    distance: FloatArray
    """Their distances from the points, shape (...)."""


@dataclass(frozen=True, slots=True, eq=False)
class Projection:
    """A curve prepared for being asked which of its places is nearest."""

    curve: BSpline
    """The curve."""
    _ends: FloatArray = field(init=False, repr=False)
    _pieces: FloatArray = field(init=False, repr=False)
    _boxes: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        ends, pieces = self.curve.bezier()
        if not self.curve.is_rational:
            pieces = np.concatenate((pieces, np.ones((*pieces.shape[:2], 1))), axis=2)
        if self.curve.degree == 0:
            pieces = np.repeat(pieces, 2, axis=1)
        # only ratios of weights count, and those near 1 lose least
        pieces = np.ascontiguousarray(pieces / pieces[:, :, -1:].max(axis=1, keepdims=True))
        places = pieces[..., :-1] / pieces[..., -1:]
        boxes = np.ascontiguousarray(np.stack((places.min(axis=1), places.max(axis=1)), axis=1))
        for name, value in (("_ends", ends), ("_pieces", pieces), ("_boxes", boxes)):
            object.__setattr__(self, name, value)

    def nearest(self, points: ArrayInput) -> Nearest:
        """Give the nearest of all places to each point; of several equally near ones any.

        No place is nearer but for rounding.

        Args:
            points: Points, shape (..., dim).

        Raises:
            ValueError: If they are not finite or have another number of coordinates.
        """
        array = np.asarray(points, dtype=np.float64)
        dim = self.curve.dim
        if array.ndim == 0 or array.shape[-1] != dim or not np.isfinite(array).all():
            raise ValueError(f"points: want {dim} finite coordinates each, got {points!r}")
        flat = np.ascontiguousarray(array.reshape(-1, dim))
        out = np.empty((len(flat), 2 + dim))
        count = self._pieces.shape[1]
        _kernel()(self._pieces, self._ends, self._boxes, flat, _factors(count - 1), out)
        shape = array.shape[:-1]
        return Nearest(
            out[:, 0].reshape(shape), out[:, 2:].reshape(array.shape), out[:, 1].reshape(shape)
        )

    def invert(self, points: ArrayInput, tolerance: float) -> FloatArray:
        """Give the parameters of points on the curve, shape (...).

        Where the curve passes a point several times it is one of the parameters.

        Args:
            points: Points, shape (..., dim).
            tolerance: How far they may be off the curve.

        Raises:
            CurveError: If one is farther away.
            ValueError: If the tolerance is not at least 0, or the points are not finite.
        """
        if not tolerance >= 0.0:
            raise ValueError(f"tolerance: want 0 or more, got {tolerance}")
        found = self.nearest(points)
        away = np.ravel(found.distance)
        if (away > tolerance).any():
            worst = int(np.argmax(away))
            place = np.asarray(points, dtype=np.float64).reshape(-1, self.curve.dim)[worst]
            raise CurveError(
                f"{place.tolist()} is {away[worst]:.6g} off the curve, allowed {tolerance:.3g}; "
                f"nearest at {float(np.ravel(found.u)[worst]):.6g}",
                f"point {worst}" if away.size > 1 else "point",
            )
        return found.u


def nearest_point(curve: BSpline, points: ArrayInput) -> Nearest:
    """Give the nearest of all places of a curve to each point, shape (..., dim).

    For asking again and again make a ``Projection``.

    Raises:
        ValueError: If the points are not finite or have another number of coordinates.
    """
    return Projection(curve).nearest(points)


def invert(curve: BSpline, points: ArrayInput, tolerance: float) -> FloatArray:
    """Give the parameters of points on a curve, shape (...); those off it are refused.

    Raises:
        CurveError: If a point is farther away than the tolerance.
        ValueError: If the tolerance is not at least 0, or the points are not finite.
    """
    return Projection(curve).invert(points, tolerance)


@functools.cache
def _factors(degree: int) -> FloatArray:
    """Give what products of coefficients count in the product of two polynomials."""
    single, double = binomials(degree), binomials(2 * degree)
    i = np.arange(degree + 1)
    return np.ascontiguousarray(single[:, None] * single / double[i[:, None] + i])


@functools.cache
def _kernel() -> Callable[..., Any]:
    """Give the kernel, compiled for its arguments."""
    from splinearm.compiled import entry, inputs, outputs

    from . import projection_kernel

    return entry(projection_kernel.nearest_into, *inputs(3, 1, 3, 2, 2), *outputs(2))
