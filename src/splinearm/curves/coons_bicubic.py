"""Surfaces between four boundary curves that leave each of them with a given slope."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import knot
from .bspline import BSpline
from .compatible import make_compatible
from .surface import BSplineSurface

_MEET = 1e-9
"""At corners, what belongs together may differ by this share of its size."""


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """A boundary of a surface and how the surface goes on from it; both polynomial."""

    curve: BSpline
    """The boundary, clamped or not, without jumps."""
    slope: BSpline
    """The derivative across it: by v along a curve of u, by u along a curve of v."""

    def __post_init__(self) -> None:
        for name in ("curve", "slope"):
            curve = getattr(self, name)
            if curve.is_rational or curve.degree == 0:
                raise ValueError(f"{name}: want a polynomial curve of degree 1 or more")
        if self.slope.dim != self.curve.dim or self.slope.domain != self.curve.domain:
            raise ValueError(
                f"slope: want {self.curve.dim} coordinates over {self.curve.domain}, got "
                f"{self.slope.dim} over {self.slope.domain}"
            )


def coons_bicubic(bottom: Side, top: Side, left: Side, right: Side) -> BSplineSurface:
    """Give the bicubically blended patch with four boundaries and the slopes across them.

    Its u is the parameter of bottom and top, its v that of left and right.

    Args:
        bottom: The side at the first v.
        top: The side at the last v.
        left: The side at the first u, from the start of the bottom to that of the top.
        right: The side at the last u, from the end of the bottom to that of the top.

    Raises:
        CurveError: If, at a corner, two sides differ in place, tangent or twist.
        ValueError: If opposite sides have different domains, or sides different numbers of
            coordinates.
    """
    for first, second, names in ((bottom, top, "bottom and top"), (left, right, "left and right")):
        if first.curve.domain != second.curve.domain:
            raise ValueError(
                f"domain: want the same of {names}, got {first.curve.domain} and "
                f"{second.curve.domain}"
            )
    if len({side.curve.dim for side in (bottom, top, left, right)}) > 1:
        raise ValueError("dim: want as many coordinates of each side")
    _check_corners(bottom, top, left, right)
    # Coons, Surfaces for computer-aided design of space forms, MIT 1967: both Hermite interpolants
    # together, less what they have in common, the first one's interpolant across the other way
    by_u = _between(bottom, top, left.curve.domain)
    by_v = _between(left, right, bottom.curve.domain).swapped()
    start, end = bottom.curve.domain
    first, last = (Side(by_u.along_v(u), _slope_across(by_u, last=u == end)) for u in (start, end))
    both = _between(first, last, (start, end)).swapped()
    return _total(by_u, by_v, both)


def _check_corners(bottom: Side, top: Side, left: Side, right: Side) -> None:
    """Refuse sides that do not agree where they meet."""
    size = max(float(np.ptp(side.curve.points, axis=0).max()) for side in (bottom, left, top))
    (u0, u1), (v0, v1) = bottom.curve.domain, left.curve.domain
    for along_u, v, low in ((bottom, v0, "bottom"), (top, v1, "top")):
        for along_v, u, side in ((left, u0, "left"), (right, u1, "right")):
            first = [(s.at(u), s.at(u, 1)) for s in (along_u.curve, along_u.slope)]
            second = [(s.at(v), s.at(v, 1)) for s in (along_v.curve, along_v.slope)]
            for what, a, b, i, j in (
                ("place", first[0][0], second[0][0], 0, 0),
                ("tangent along u", first[0][1], second[1][0], 1, 0),
                ("tangent along v", first[1][0], second[0][1], 0, 1),
                ("twist", first[1][1], second[1][1], 1, 1),
            ):
                allowed = _MEET * size / ((u1 - u0) ** i * (v1 - v0) ** j)
                if not np.linalg.norm(a - b) <= allowed:
                    raise CurveError(
                        f"the {low} and the {side} side differ in {what}: {a.tolist()} and "
                        f"{b.tolist()}",
                        "Coons patch",
                    )


def _between(first: Side, second: Side, across: tuple[float, float]) -> BSplineSurface:
    """Give the surface, cubic across, with two opposite sides, u along them."""
    common = make_compatible((first.curve, first.slope, second.curve, second.slope))
    start, slope, end, end_slope = common.rows
    third = (across[1] - across[0]) / 3.0
    net = np.stack((start, start + third * slope, end - third * end_slope, end), axis=1)
    return BSplineSurface(common.knots, np.repeat(across, 4), net, common.degree, 3)


def _slope_across(surface: BSplineSurface, *, last: bool) -> BSpline:
    """Give the derivative by u at the first or last u as a curve of v, of a clamped surface."""
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, eq. 3.9 and 3.10
    p, knots, net = surface.degree_u, surface.knots_u, surface.points
    at = len(net) - 2 if last else 0
    step: FloatArray = (net[at + 1] - net[at]) * (p / (knots[at + p + 1] - knots[at + 1]))
    return BSpline(surface.knots_v, step, surface.degree_v)


def _total(by_u: BSplineSurface, by_v: BSplineSurface, both: BSplineSurface) -> BSplineSurface:
    """Give the sum of the first two less the third, which has no inner knots."""
    p, q = max(by_u.degree_u, 3), max(by_v.degree_v, 3)
    raised = [s.elevated(p - s.degree_u, q - s.degree_v) for s in (by_u, by_v, both)]
    # each of the first two has inner knots in its own direction only
    us = np.repeat(*knot.inner_runs(raised[0].knots_u, p))
    vs = np.repeat(*knot.inner_runs(raised[1].knots_v, q))
    total = raised[0].with_knots(vs=vs).points + raised[1].with_knots(us=us).points
    total -= raised[2].with_knots(us, vs).points
    return BSplineSurface(raised[0].knots_u, raised[1].knots_v, total, p, q)
