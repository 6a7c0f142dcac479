"""Knots put into B-splines without changing the curve, on bare arrays that nobody checks."""

import numpy as np

from splinearm.arrays import FloatArray


def insert_knot(
    knots: FloatArray, points: FloatArray, degree: int, u: float
) -> tuple[FloatArray, FloatArray]:
    """Give knots and control points of the same curve with a knot ``u`` more."""
    # Boehm, Inserting new knots into B-spline curves, Computer-Aided Design 12 (1980) 199
    span = int(np.searchsorted(knots, u, side="right")) - 1
    multiplicity = span + 1 - int(np.searchsorted(knots, u, side="left"))
    first, last = span - degree + 1, span - multiplicity + 1
    low = knots[first:last]
    share = ((u - low) / (knots[first + degree : last + degree] - low))[:, None]
    mixed = points[first - 1 : last - 1] * (1.0 - share) + points[first:last] * share
    return (
        np.insert(knots, span + 1, u),
        np.concatenate((points[:first], mixed, points[last - 1 :])),
    )


def raise_multiplicity(
    knots: FloatArray, points: FloatArray, degree: int, u: float, multiplicity: int
) -> tuple[FloatArray, FloatArray]:
    """Give the same curve with ``u`` at least ``multiplicity`` times (at most degree) a knot."""
    have = int(np.count_nonzero(knots == u))
    for _ in range(multiplicity - have):
        knots, points = insert_knot(knots, points, degree, u)
    return knots, points


def trim(
    knots: FloatArray, points: FloatArray, degree: int, start: float, end: float
) -> tuple[FloatArray, FloatArray]:
    """Give the part of a curve from ``start`` to ``end``, clamped at both."""
    for u in (start, end):
        knots, points = raise_multiplicity(knots, points, degree, u, degree)
    # the last of the equal start knots, and the first of the equal end knots
    first = int(np.searchsorted(knots, start, side="right")) - 1
    last = int(np.searchsorted(knots, end, side="left"))
    inner = knots[first + 1 : last]
    clamped = np.concatenate((np.full(degree + 1, start), inner, np.full(degree + 1, end)))
    return clamped, points[first - degree : last]


def bezier_points(
    knots: FloatArray, points: FloatArray, degree: int
) -> tuple[FloatArray, FloatArray]:
    """Give the Bezier pieces of a curve.

    Returns:
        The k + 1 ends of the pieces, and control points of shape (k, degree + 1, dim).
    """
    ends = np.unique(knots[degree : knots.size - degree])
    if degree == 0:
        spans = np.searchsorted(knots, ends[:-1], side="right") - 1
        return ends, points[spans][:, None]
    for u in ends:
        knots, points = raise_multiplicity(knots, points, degree, float(u), degree)
    spans = np.searchsorted(knots, ends[:-1], side="right") - 1
    return ends, points[spans[:, None] + np.arange(-degree, 1)]
