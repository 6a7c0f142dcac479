"""Surfaces at a distance from another, along its normals."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .surface import BSplineSurface
from .surface_fit import first_knots, fitted
from .surface_normal import check_space, normal, places, refuse, tangents
from .surface_shape import Curvatures, curvatures


@dataclass(frozen=True, slots=True, eq=False)
class OffsetSurface:
    """The exact surface at a distance from another: each place moved along its normal."""

    surface: BSplineSurface
    """The surface in space that is moved."""
    distance: float
    """How far along its normals, m; below 0 against them."""

    def __post_init__(self) -> None:
        check_space(self.surface)
        if not np.isfinite(self.distance):
            raise ValueError(f"distance: want a finite number, got {self.distance}")

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """First and last u, first and last v."""
        return self.surface.domain

    def at(self, u: ArrayInput, v: ArrayInput) -> FloatArray:
        """Give points, shape (..., 3).

        Args:
            u: First parameters, shape (...).
            v: Second parameters, shape (...).

        Raises:
            CurveError: If a place lies outside the domain, or the surface has no normal there.
        """
        return self.surface.at(u, v) + self.distance * normal(self.surface, u, v)

    def normal(self, u: ArrayInput, v: ArrayInput) -> FloatArray:
        """Give unit normals, shape (..., 3): those of the surface that was moved.

        Raises:
            CurveError: If a place lies outside the domain, or the surface has no normal there.
        """
        return normal(self.surface, u, v)

    def curvatures(self, u: ArrayInput, v: ArrayInput) -> Curvatures:
        """Give the principal curvatures and their directions.

        Raises:
            CurveError: If a place lies outside the domain, the surface is degenerate there, or the
                distance reaches its centre of curvature: beyond, the offset has turned over.
        """
        # do Carmo, Differential Geometry of Curves and Surfaces, 1976, sec. 3-5, exercise 11: lines
        # of curvature stay, their radii change by the distance
        found = curvatures(self.surface, u, v)
        shrink = 1.0 - self.distance * found.values
        us, vs = places(u, v)
        refuse(shrink.min(axis=-1) <= 0.0, us, vs, self._reach_of(shrink))
        # who moves by one parameter moves farther by the same share on the offset
        return Curvatures(
            found.values / shrink, found.directions, found.parameters / shrink[..., None]
        )

    def to_bspline(self, tolerance: float, degree: int = 5) -> tuple[BSplineSurface, float]:
        """Give a B-spline near the offset.

        Args:
            tolerance: How far it may be from it, at the same u and v, m.
            degree: Degree of the B-spline both ways, at least 2.

        Returns:
            The B-spline, and how far it is away at most where the two were compared: at nine
            places of each of its patches, none of which it was made from.

        Raises:
            CurveError: If the surface has an edge or no normal somewhere, the distance reaches
                a centre of curvature, or the tolerance cannot be reached.
            ValueError: If the tolerance is not above 0 or the degree is below 2.
        """
        if not tolerance > 0.0:
            raise ValueError(f"tolerance: want it above 0, got {tolerance}")
        if degree < 2:
            raise ValueError(f"degree: want at least 2, got {degree}")
        surface = self.surface
        _check_edges(surface)
        _check_edges(surface.swapped(), "v")
        knots = (
            first_knots(surface.knots_u, surface.degree_u, degree, 1),
            first_knots(surface.knots_v, surface.degree_v, degree, 1),
        )
        return fitted(self._places, knots, tolerance, degree)

    def _places(self, us: FloatArray, vs: FloatArray) -> FloatArray:
        u, v = (x.ravel() for x in np.broadcast_arrays(us[:, None], vs[None]))
        whole = ~tangents(self.surface, u, v).degenerate
        # a degenerate place has a normal or is refused, but no curvature
        self.curvatures(u[whole], v[whole])
        return self.at(u, v).reshape(us.size, vs.size, 3)

    def _reach_of(self, shrink: FloatArray) -> str:
        return (
            f"an offset by {self.distance:.6g} m reaches the centre of curvature "
            f"(1 - distance * curvature = {shrink.min(initial=1.0):.3g})"
        )


def _check_edges(surface: BSplineSurface, along: str = "u") -> None:
    """Refuse a surface whose normal jumps at a knot along u."""
    p = surface.degree_u
    values, counts = np.unique(surface.knots_u, return_counts=True)
    start, end = surface.domain[0]
    sharp = (counts >= p) & (values > start) & (values < end)
    v = np.unique(np.concatenate([np.linspace(*surface.domain[1], 65), surface.breaks[1]]))
    for value in values[sharp].tolist():
        before, behind = surface.split("u", value)
        sides = [tangents(half, np.full(v.size, value), v) for half in (before, behind)]
        whole = ~(sides[0].degenerate | sides[1].degenerate)
        across = [side.across[whole] for side in sides]
        units = [n / np.linalg.norm(n, axis=1, keepdims=True) for n in across]
        turn = np.linalg.norm(units[0] - units[1], axis=1)
        if (turn > 1e-9).any():
            raise CurveError("it has an edge: offset the parts beside it", f"{along} = {value:.9g}")
