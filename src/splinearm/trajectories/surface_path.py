"""Ways of a tool that faces the surface over which it goes."""

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves import surface_normal
from splinearm.curves.meeting import meet_plane
from splinearm.curves.surface_curve import SurfaceCurve
from splinearm.errors import CurveError

from .facing import CarriedFacing, GuidedWay, NormalJet, TravelFacing, unit_jet
from .path import CartesianPath
from .turning import OrientationCurve, inside

_CRUMB = 1e-9
"""Breaks nearer to each other than this share of a way are one."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


class Heading(Enum):
    """Where the x axis points of a tool whose z axis faces a surface."""

    TRAVEL = "travel"
    """Along the direction of travel."""

    FREE = "free"
    """Where it did at the start, carried on without a spin about the normal
    (rotation-minimising)."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceWay:
    """A curve on a surface with the normals along it, by nearly its length."""

    curve: SurfaceCurve
    """The curve on the surface."""
    breaks: FloatArray = field(init=False)
    """Where curve or surface are joined from pieces, and the ends, shape (k,)."""

    def __post_init__(self) -> None:
        surface_normal.check_space(self.curve.surface)
        plane = self.curve.plane_curve
        start, end = plane.domain
        found = [plane.breaks]
        for axis, knots in enumerate(self.curve.surface.breaks):
            for knot in knots[1:-1]:
                place, across = np.zeros(2), np.zeros(2)
                place[axis], across[axis] = knot, 1.0
                met = meet_plane(plane, place, across)
                found += [met.u, met.stretches.ravel()]
        breaks = np.unique(np.clip(np.concatenate(found), start, end))
        far = np.diff(breaks, prepend=-np.inf) > _CRUMB * (end - start)
        breaks = np.append(breaks[far & (breaks < end - _CRUMB * (end - start))], end)
        breaks.flags.writeable = False
        object.__setattr__(self, "breaks", breaks)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return self.curve.domain

    def at(self, u: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give places, or a derivative by the parameter, at parameters of shape (m,), (m, 3).

        Raises:
            CurveError: If a parameter lies outside the domain.
        """
        return self.curve.at(u, derivative)

    def normals(self, u: ArrayInput) -> NormalJet:
        """Give unit normals and their derivatives by the parameter at parameters, shape (m,).

        Raises:
            CurveError: If a parameter lies outside the domain, or the surface is degenerate there.
        """
        u = inside(u, self.domain)
        surface = self.curve.surface
        steps = self.curve.plane_curve.jet(u, 2)
        low, high = np.array(surface.domain).T
        place = np.clip(steps[:, 0], low, high)
        flat = surface_normal.tangents(surface, place[:, 0], place[:, 1]).degenerate
        if flat.any():
            k = int(np.argmax(flat))
            raise CurveError(
                f"the surface is degenerate at u = {place[k, 0]:.9g}, v = {place[k, 1]:.9g} and "
                "gives no frame to stand on",
                f"s = {u[k]:g}",
            )
        jets = surface.jet(place[:, 0], place[:, 1], 3)
        a, da, dda = _along(jets, steps, 1, 0)
        b, db, ddb = _along(jets, steps, 0, 1)
        return NormalJet(
            *unit_jet(
                np.cross(a, b),
                np.cross(da, b) + np.cross(a, db),
                np.cross(dda, b) + 2.0 * np.cross(da, db) + np.cross(a, ddb),
            )
        )


def surface_path(
    curve: SurfaceCurve | GuidedWay,
    *,
    outward: bool = False,
    heading: Heading = Heading.TRAVEL,
    x_start: ArrayInput | None = None,
) -> CartesianPath:
    """Give the way of a tool along a curve on a surface, which it faces all the way.

    Its z axis lies in the normal, its rates are exact. The orientation is C2 where the surface is
    C3 across its knots and, if the tool heads along its travel, the curve is too; elsewhere its
    angular acceleration jumps, and the joints of a plan go C2 through that within the tolerance.

    Args:
        curve: The curve on the surface, which comes back by a parameter from 0 to its length; or
            any way that knows its normals, by its own parameter.
        outward: Whether z points along the normals, (derivative by u) x (derivative by v), as a
            tool does that works from inside; otherwise it points against them, into the surface.
        heading: Where the x axis points.
        x_start: With ``Heading.FREE``: where it points at the start, as nearly as facing allows, in
            base, shape (3,); None: along the direction of travel.

    Raises:
        CurveError: If the surface is degenerate somewhere on the way or has an edge there, or the
            way has a corner or no direction; it names the place.
        ValueError: If ``x_start`` points along the normal, or is given for another heading.
    """
    if x_start is not None and heading is not Heading.FREE:
        raise ValueError(f"x_start: is for {Heading.FREE} only, not for {heading}")
    way = _by_length(curve) if isinstance(curve, SurfaceCurve) else curve
    sign = 1.0 if outward else -1.0
    orientation: OrientationCurve
    if heading is Heading.TRAVEL:
        orientation = TravelFacing(way, sign)
    else:
        start = way.at(np.array([way.domain[0]]), 1)[0] if x_start is None else x_start
        orientation = CarriedFacing(way, sign, frozen_array(start, (3,), "x_start"))
    return CartesianPath(position=way, orientation=orientation, waypoint_s=np.array(way.domain))


def _by_length(curve: SurfaceCurve) -> SurfaceWay:
    """Give a curve from parameter 0 to its length; between them it need not be even."""
    way = SurfaceWay(curve)
    half = 0.5 * np.diff(way.breaks)[:, None]
    u = (0.5 * (way.breaks[1:] + way.breaks[:-1]))[:, None] + half * _NODES
    rates = np.linalg.norm(way.at(u.ravel(), 1), axis=1).reshape(u.shape)
    length = float((half * rates * _WEIGHTS).sum())
    if not length > 0.0:
        raise CurveError("the curve on it stays where it is", "surface")
    return SurfaceWay(SurfaceCurve(curve.surface, curve.plane_curve.over(0.0, length)))


def _along(
    jets: FloatArray, steps: FloatArray, i: int, j: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give a partial derivative of a surface along a curve, with its first two derivatives."""
    du, dv = steps[:, 1, :1], steps[:, 1, 1:]
    ddu, ddv = steps[:, 2, :1], steps[:, 2, 1:]
    by_u, by_v = jets[:, i + 1, j], jets[:, i, j + 1]
    slope = by_u * du + by_v * dv
    bend = by_u * ddu + by_v * ddv + jets[:, i + 2, j] * du * du
    bend = bend + 2.0 * jets[:, i + 1, j + 1] * du * dv + jets[:, i, j + 2] * dv * dv
    return jets[:, i, j], slope, bend
