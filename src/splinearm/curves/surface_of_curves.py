"""Surfaces that curves or straight lines draw exactly: extruded, ruled, translated, revolved.

On each of them u is the parameter of the (first) curve.
"""

from math import pi

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import conic
from .bspline import BSpline
from .compatible import make_compatible
from .surface import BSplineSurface

_RULED_KNOTS = np.array([0.0, 0.0, 1.0, 1.0])


def extruded(curve: BSpline, vector: ArrayInput) -> BSplineSurface:
    """Give the surface of a curve moved along a vector, v from 0 to 1.

    Args:
        curve: The curve.
        vector: How far it moves, shape (dim,).

    Raises:
        ValueError: If the vector is zero or has another number of coordinates.
    """
    way = frozen_array(vector, (curve.dim,), "vector")
    if not way.any():
        raise ValueError(f"vector: want one of some length, got {way.tolist()}")
    points = np.stack((curve.points, curve.points + way), axis=1)
    weights = None if curve.weights is None else np.repeat(curve.weights[:, None], 2, axis=1)
    return BSplineSurface(curve.knots, _RULED_KNOTS, points, curve.degree, 1, weights)


def ruled(first: BSpline, second: BSpline) -> BSplineSurface:
    """Give the surface of straight lines between places of two curves, v from 0 to 1.

    Places at the same share of both domains are joined.

    Args:
        first: The curve at v = 0, whose parameter is u.
        second: The curve at v = 1.

    Raises:
        ValueError: If the curves have different numbers of coordinates.
    """
    sections = make_compatible((first, second))
    rows = np.moveaxis(sections.rows, 0, 1)
    return surface_of(
        (sections.knots, _RULED_KNOTS), rows, (sections.degree, 1), rational=sections.is_rational
    )


def translated(profile: BSpline, path: BSpline) -> BSplineSurface:
    """Give the surface of all sums of a place of one curve and a place of another.

    It is the profile moved along the path without turning, as far as the path is from the origin;
    v is the parameter of the path.

    Raises:
        ValueError: If the curves have different numbers of coordinates.
    """
    if profile.dim != path.dim:
        raise ValueError(
            f"path: want as many coordinates as of the profile, {profile.dim}, got {path.dim}"
        )
    points = profile.points[:, None] + path.points[None]
    weights = None
    if profile.is_rational or path.is_rational:
        weights = profile.homogeneous[:, None, -1] * path.homogeneous[None, :, -1]
    return BSplineSurface(profile.knots, path.knots, points, profile.degree, path.degree, weights)


def revolved(
    profile: BSpline, origin: ArrayInput, axis: ArrayInput, angle: float = 2.0 * pi
) -> BSplineSurface:
    """Give the surface of a curve turned about an axis; each of its circles is one.

    v goes from 0 to 1, not evenly in the angle, in pieces of a quarter turn at most.

    Args:
        profile: The curve in space, at v = 0.
        origin: A point of the axis, shape (3,), m.
        axis: Its direction, which it is turned about as a right-hand screw, of any length,
            shape (3,).
        angle: How far, rad; backwards if negative.

    Raises:
        CurveError: If the whole curve lies on the axis.
        ValueError: If the curve is not in space, the axis is zero, or the angle is 0 or more than
            one turn.
    """
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, sec. 8.5: each control point turns on its own
    # circle, whose homogeneous points are linear in the point's distance from the axis
    if profile.dim != 3:
        raise ValueError(f"profile: want 3 coordinates, got {profile.dim}")
    foot = frozen_array(origin, (3,), "origin")
    way = frozen_array(axis, (3,), "axis")
    if not way.any():
        raise ValueError(f"axis: want a direction, got {way.tolist()}")
    n = way / np.abs(way).max()
    n = n / np.linalg.norm(n)
    circle = conic.arc(1.0, 0.0, angle)
    rows = circle.homogeneous
    along = (profile.points - foot) @ n
    centres = foot + along[:, None] * n
    x = profile.points - centres
    size = float(np.abs(profile.points - foot).max())
    distance = np.linalg.norm(x, axis=1)
    # what is on the axis but for rounding is on it, so that poles are one point
    x[distance <= 1e-15 * size] = 0.0
    if not x.any():
        raise CurveError("the whole profile lies on the axis", "revolved surface")
    turned = rows[:, 0, None] * x[:, None] + rows[:, 1, None] * np.cross(n, x)[:, None]
    shares = np.repeat(profile.homogeneous[:, -1:], len(rows), axis=1) * rows[:, -1]
    points = centres[:, None] + turned / rows[:, -1:]
    return BSplineSurface(profile.knots, circle.knots, points, profile.degree, 2, shares)


def surface_of(
    knots: tuple[FloatArray, FloatArray],
    rows: FloatArray,
    degrees: tuple[int, int],
    *,
    rational: bool,
) -> BSplineSurface:
    """Give the surface of control points, homogeneous ones if it is rational.

    Raises:
        CurveError: If a weight is not above 0.
    """
    if not rational:
        return BSplineSurface(*knots, rows, *degrees)
    if not (rows[..., -1] > 0.0).all():
        raise CurveError(f"a weight would become {rows[..., -1].min():.3g}, not above 0", "surface")
    return BSplineSurface.from_homogeneous(knots, rows, degrees)
