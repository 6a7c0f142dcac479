"""Ways to choose parameters that look at more than distances, on bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray

from . import basis, knot

_FLAT = 1e-12
"""Directions in which points spread by less than this share of the most are none."""


def foley_steps(points: FloatArray, *, closed: bool) -> FloatArray:
    """Give steps of the parameter: distances, longer where the way turns, shape (m - 1,).

    Args:
        points: Points, neighbours apart, shape (m, dim); of a closed curve the first again at the
            end.
        closed: Whether the curve turns at the first point as well.
    """
    # Foley and Nielson, Knot selection for parametric spline interpolation, in: Mathematical
    # Methods in Computer Aided Geometric Design, 1989, 261
    way = np.diff(points, axis=0)
    d = np.linalg.norm(way, axis=1)
    unit = way / d[:, None]
    turn = 2.0 * np.arctan2(
        np.linalg.norm(unit - np.roll(unit, -1, axis=0), axis=1),
        np.linalg.norm(unit + np.roll(unit, -1, axis=0), axis=1),
    )
    turn = np.minimum(turn, 0.5 * np.pi)
    behind = np.roll(d, -1)
    # what the turn at the end of each step adds to it and to the following one
    at_end = 1.5 * turn * behind / (d + behind)
    at_start = np.roll(1.5 * turn * d / (d + behind), 1)
    if not closed:
        at_end[-1] = at_start[0] = 0.0
    steps: FloatArray = d * (1.0 + at_end + at_start)
    return steps


def affine_metric(points: FloatArray) -> FloatArray:
    """Give points mapped so that no affine map of them changes their distances, (m, rank)."""
    # Nielson, Coordinate free scattered data interpolation, in: Topics in Multivariate
    # Approximation, 1987, 175: distances in the metric of the inverse of their covariance
    centred = points - points.mean(axis=0)
    left, spread, _ = np.linalg.svd(centred, full_matrices=False)
    rank = int((spread > _FLAT * spread[0]).sum()) if spread.size else 0
    mapped: FloatArray = left[:, : max(rank, 1)] * np.sqrt(len(points))
    return mapped


def universal(count: int, degree: int) -> FloatArray:
    """Give parameters where the basis functions of even clamped knots are largest, (count,)."""
    # Lim, A universal parametrization in B-spline curve and surface interpolation, CAGD 16
    # (1999) 407
    degree = min(degree, count - 1)
    spans = count - degree
    inner = np.arange(1.0, spans)
    knots = knot.clamped_knots(0.0, inner, 1, float(spans), degree)
    low, high = knots[1 : count - 1].copy(), knots[degree + 1 : -2][: count - 2].copy()
    # the derivative of each function falls through 0 once in its support
    number = np.arange(1, count - 1)
    for _ in range(60):
        middle = 0.5 * (low + high)
        spans_at = basis.find_spans(knots, degree, middle)
        rows = basis.basis_values(knots, degree, spans_at, middle, 1)
        column = np.clip(number - spans_at + degree, 0, degree)
        rising = rows[np.arange(len(number)), column] > 0.0
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    return np.concatenate(([0.0], 0.5 * (low + high), [float(spans)]))
