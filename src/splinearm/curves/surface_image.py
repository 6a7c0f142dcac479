"""The image on a surface of a curve in its plane of parameters, exactly, as a B-spline."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import knot, rational
from .basis import IndexArray
from .bernstein import EPS, Bounded, multiply
from .bspline import BSpline
from .root import find_roots
from .surface import BSplineSurface

_SAME = 1e-12
"""Cuts that are no farther apart than this share of the domain are one."""

_ON_EDGE = 1e-12
"""By this share of the domain a curve may leave it by rounding."""


def image_on_surface(surface: BSplineSurface, plane_curve: BSpline) -> BSpline:
    """Give the image of a curve of u and v, of the degree of the curve times both of the surface.

    A straight line on a bicubic surface becomes a curve of degree 6, a cubic one of degree 18;
    ``SurfaceCurve`` has the same places and derivatives without any such curve. The parameter
    stays; the image is cut where the curve crosses from one patch into the next.

    Args:
        surface: The surface.
        plane_curve: A curve with coordinates u and v, of degree 1 or more and without jumps.

    Raises:
        CurveError: If the curve leaves the domain of the surface, or jumps.
        ValueError: If the curve has not two coordinates or degree 0.
    """
    if plane_curve.dim != 2 or plane_curve.degree == 0:
        raise ValueError(
            f"plane_curve: want coordinates u and v and a degree of at least 1, got "
            f"{plane_curve.dim} coordinates and degree {plane_curve.degree}"
        )
    values, counts = knot.inner_runs(plane_curve.knots, plane_curve.degree)
    if (counts > plane_curve.degree).any():
        where = values[int(np.argmax(counts > plane_curve.degree))]
        raise CurveError("the curve jumps there", f"u = {where:.9g}")
    ends, pieces = _cut(surface, plane_curve)
    pick = _patches_of(surface, plane_curve, ends)
    weighted = surface.is_rational or plane_curve.is_rational
    nets, low, high = _nets(surface, pick, homogeneous=weighted)
    images = _composed(nets, pieces, (low, high))
    # neighbours share their point to the last bit
    images[:-1, -1] = images[1:, 0]
    degree = images.shape[1] - 1
    rows = np.concatenate((images[0], images[1:, 1:].reshape(-1, images.shape[2])))
    knots = knot.clamped_knots(ends[0], ends[1:-1], degree, ends[-1], degree)
    if not weighted:
        return BSpline(knots, rows, degree)
    rational.check_weights(rows)
    return BSpline.from_homogeneous(knots, rows, degree)


def _cut(surface: BSplineSurface, curve: BSpline) -> tuple[FloatArray, FloatArray]:
    """Give the ends and homogeneous points of pieces that lie on one patch each."""
    rows, p = curve.homogeneous, curve.degree
    ends, pieces = knot.bezier_points(curve.knots, rows, p)
    found = [ends]
    for axis, breaks in enumerate(surface.breaks):
        for value in breaks.tolist():
            gap = pieces[:, :, axis] - value * pieces[:, :, 2]
            size = np.abs(pieces[:, :, axis]).max(axis=1) + abs(value) * pieces[:, :, 2].max(axis=1)
            roots = find_roots(Bounded(gap, 8.0 * EPS * size))
            width = np.diff(ends)[roots.piece]
            found.append(ends[roots.piece] + roots.t * width)
    cuts = np.sort(np.concatenate(found[1:]))
    apart = _SAME * (ends[-1] - ends[0])
    near = ends[np.clip(np.searchsorted(ends, cuts), 1, len(ends) - 1) - np.array([[1], [0]])]
    cuts = cuts[(np.abs(near - cuts) > apart).all(axis=0)]
    cuts = cuts[np.concatenate(([True], np.diff(cuts) > apart))] if cuts.size else cuts
    ends = np.sort(np.concatenate((ends, cuts)))
    cut = knot.over_knots(curve.knots, rows, p, np.repeat(ends, p + 1))
    return ends, cut.reshape(-1, p + 1, 3)


def _patches_of(
    surface: BSplineSurface, curve: BSpline, ends: FloatArray
) -> tuple[IndexArray, ...]:
    """Give along u and along v the patch that each piece lies on."""
    middles = 0.5 * (ends[:-1] + ends[1:])
    places = curve.at(middles)
    found = []
    for axis, breaks in enumerate(surface.breaks):
        x = places[:, axis]
        room = _ON_EDGE * (breaks[-1] - breaks[0])
        outside = (x < breaks[0] - room) | (x > breaks[-1] + room)
        if outside.any():
            k = int(np.argmax(outside))
            u, v = places[k].tolist()
            raise CurveError(
                f"the surface has no place at u = {u}, v = {v}", f"curve at {middles[k]}"
            )
        found.append(np.clip(np.searchsorted(breaks, x, side="right") - 1, 0, len(breaks) - 2))
    return tuple(found)


def _nets(
    surface: BSplineSurface,
    pick: tuple[IndexArray, ...],
    *,
    homogeneous: bool,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give control points of patches and their first and last corner, shape (k, 2)."""
    ends_u, ends_v, patches = surface.bezier()
    nets = patches[pick[0], pick[1]]
    if homogeneous and not surface.is_rational:
        nets = np.concatenate((nets, np.ones((*nets.shape[:-1], 1))), axis=-1)
    low = np.stack((ends_u[pick[0]], ends_v[pick[1]]), axis=-1)
    high = np.stack((ends_u[pick[0] + 1], ends_v[pick[1] + 1]), axis=-1)
    return nets, low, high


def _composed(
    nets: FloatArray, pieces: FloatArray, corners: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Give the control points of patches at places that are polynomials, (k, degree + 1, ...)."""
    # de Casteljau's steps with polynomials for shares: DeRose, Composing Bezier simplexes, ACM
    # Transactions on Graphics 7 (1988) 198
    local = nets[..., None]
    weight = pieces[:, :, 2]
    for axis in (0, 1):
        low, high = (corner[:, axis, None] for corner in corners)
        far = (pieces[:, :, axis] - low * weight) / (high - low)
        near = (high * weight - pieces[:, :, axis]) / (high - low)
        near, far = (x[:, None, None, None] for x in (near, far))
        local = local if axis == 0 else local.swapaxes(1, 2)
        while local.shape[1] > 1:
            local = multiply(local[:, :-1], near) + multiply(local[:, 1:], far)
    return np.ascontiguousarray(local[:, 0, 0].swapaxes(1, 2))
