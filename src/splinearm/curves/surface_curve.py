"""Curves that lie on a surface: images of curves in its plane of parameters."""

import math
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .bspline import BSpline
from .surface import BSplineSurface

_ON_EDGE = 1e-12
"""By this share of the domain a curve may leave it by rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceCurve:
    """The image on a surface of a curve in its plane of parameters.

    Where the curve runs on or across a knot at which the surface is not smooth, derivatives are
    those of the side of larger parameters.
    """

    surface: BSplineSurface
    """The surface."""
    plane_curve: BSpline
    """A curve with coordinates u and v, inside the domain of the surface."""

    def __post_init__(self) -> None:
        if self.plane_curve.dim != 2:
            raise ValueError(f"plane_curve: want coordinates u and v, got {self.plane_curve.dim}")

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return self.plane_curve.domain

    @property
    def dim(self) -> int:
        """Number of coordinates."""
        return self.surface.dim

    def at(self, t: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give points of the curve, or of one of its derivatives, shape (..., dim).

        Args:
            t: Parameters in the domain, shape (...).
            derivative: Which derivative by the parameter; 0 is the curve.

        Raises:
            CurveError: If a parameter lies outside the domain, or its place outside the surface.
            ValueError: If the derivative is negative.
        """
        return self.jet(t, derivative)[..., derivative, :]

    def jet(self, t: ArrayInput, order: int) -> FloatArray:
        """Give points of the curve and its derivatives at once, shape (..., order + 1, dim).

        Raises:
            CurveError: If a parameter lies outside the domain, or its place outside the surface.
            ValueError: If the order is negative.
        """
        parameters = np.asarray(t, dtype=np.float64)
        path = np.moveaxis(self.plane_curve.jet(parameters.ravel(), order), 1, 0)
        place = _inside(self.surface, path[0], parameters.ravel())
        factorials = np.array([math.factorial(k) for k in range(order + 1)], dtype=np.float64)
        steps = path / factorials[:, None, None]
        jets = self.surface.jet(place[:, 0], place[:, 1], order)
        series = jets / (factorials[:, None] * factorials)[..., None]
        # Faa di Bruno's formula as Taylor series put into one another: the sum of s_ij du^i dv^j
        total = np.zeros((order + 1, len(place), self.dim))
        by_u = _one(order, len(place))
        for i in range(order + 1):
            both = by_u
            for j in range(order + 1 - i):
                total += both[..., None] * series[:, i, j]
                both = _times_step(both, steps[..., 1])
            by_u = _times_step(by_u, steps[..., 0])
        values = total * factorials[:, None, None]
        return np.moveaxis(values, 0, 1).reshape(*parameters.shape, order + 1, self.dim)


def _inside(surface: BSplineSurface, uv: FloatArray, t: FloatArray) -> FloatArray:
    """Give places, those that left the domain by rounding brought back."""
    low, high = np.array(surface.domain).T
    back = np.clip(uv, low, high)
    off = (np.abs(uv - back) > _ON_EDGE * (high - low)).any(axis=1)
    if off.any():
        k = int(np.argmax(off))
        raise CurveError(
            f"the surface has no place at u = {uv[k, 0]}, v = {uv[k, 1]}", f"curve at {t[k]}"
        )
    return back


def _one(order: int, count: int) -> FloatArray:
    series = np.zeros((order + 1, count))
    series[0] = 1.0
    return series


def _times_step(series: FloatArray, step: FloatArray) -> FloatArray:
    """Give the product of a series with one that has no constant term, cut after its length."""
    product = np.zeros_like(series)
    for k in range(1, len(series)):
        for i in range(1, k + 1):
            product[k] += step[i] * series[k - i]
    return product
