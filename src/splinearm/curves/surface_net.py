"""Surfaces from a net of control points: Bezier patches, and rings that close."""

from typing import Literal

import numpy as np

from splinearm.arrays import ArrayInput, frozen_array

from . import form
from .surface import Along, BSplineSurface


def bezier_surface(points: ArrayInput, weights: ArrayInput | None = None) -> BSplineSurface:
    """Give the Bezier patch of control points over the unit square; with weights a rational one.

    Args:
        points: Control points, shape (degree_u + 1, degree_v + 1, dim).
        weights: Weights, shape (degree_u + 1, degree_v + 1), or None.

    Raises:
        ValueError: If the numbers do not fit.
    """
    net = frozen_array(points, (None, None, None), "points")
    p, q = net.shape[0] - 1, net.shape[1] - 1
    shares = None if weights is None else frozen_array(weights, (p + 1, q + 1), "weights")
    knots = [np.repeat([0.0, 1.0], degree + 1) for degree in (p, q)]
    return BSplineSurface(knots[0], knots[1], net, p, q, shares)


def closed_surface(
    knots: tuple[ArrayInput, ArrayInput],
    points: ArrayInput,
    degrees: tuple[int, int],
    weights: ArrayInput | None = None,
    along: Literal["u", "v", "uv"] = "u",
) -> BSplineSurface:
    """Give the surface of a ring of control points, as ``BSpline.closed`` gives a curve.

    Args:
        knots: Those along u and along v; of a closed direction with m points the m + 1 of one
            turn, first to last.
        points: Control points, each once, shape (m, n, dim).
        degrees: Along u and along v.
        weights: Weights, shape (m, n), or None.
        along: Which direction is closed, or both.

    Raises:
        ValueError: If the numbers do not fit.
    """
    if along not in ("u", "v", "uv"):
        raise ValueError(f"along: want u, v or uv, got {along!r}")
    net = frozen_array(points, (None, None, None), "points")
    shares = None if weights is None else frozen_array(weights, net.shape[:2], "weights")
    given = [np.asarray(k, dtype=np.float64) for k in knots]
    for axis, name in enumerate("uv"):
        if name in along:
            m, degree = net.shape[axis], degrees[axis]
            turn = frozen_array(given[axis], (m + 1,), f"knots along {name}")
            given[axis] = form.wrapped_knots(turn, degree)
            around = np.arange(m + degree) % m
            net = net.take(around, axis=axis)
            shares = None if shares is None else shares.take(around, axis=axis)
    return BSplineSurface(given[0], given[1], net, degrees[0], degrees[1], shares)


def is_closed(surface: BSplineSurface, along: Along, tolerance: float = 1e-9) -> bool:
    """Tell whether a surface ends in one direction where it starts, within a share of its size.

    Raises:
        ValueError: If there is no such direction.
    """
    if along not in ("u", "v"):
        raise ValueError(f"along: want u or v, got {along!r}")
    turned = surface if along == "u" else surface.swapped()
    first, last = (turned.along_v(end) for end in turned.domain[0])
    v = np.linspace(*first.domain, 4 * len(first.points) + 1)
    size = float(np.ptp(surface.points.reshape(-1, surface.dim), axis=0).max())
    return bool(np.abs(first.at(v) - last.at(v)).max() <= tolerance * size)
