"""Curves brought to one degree and one set of knots without changing them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

from . import knot
from .bspline import BSpline


class Sections(NamedTuple):
    """Curves over the same clamped knots."""

    knots: FloatArray
    """Knots, shape (m + degree + 1,)."""
    rows: FloatArray
    """Control points of each curve, shape (k, m, columns); homogeneous if one had weights."""
    degree: int
    """Degree."""
    is_rational: bool
    """Whether the last column is a weight."""


def make_compatible(curves: Sequence[BSpline]) -> Sections:
    """Give curves of one number of coordinates over common knots, by the domain of the first.

    Raises:
        ValueError: If there is none, or they have different numbers of coordinates.
    """
    if not curves:
        raise ValueError("curves: want at least one, got none")
    dims = {curve.dim for curve in curves}
    if len(dims) > 1:
        raise ValueError(f"curves: want as many coordinates of each, got {sorted(dims)}")
    start, end = curves[0].domain
    degree = max(curve.degree for curve in curves)
    rational = any(curve.is_rational for curve in curves)
    raised = [
        (curve if curve.domain == (start, end) else curve.over(start, end)).elevated(
            degree - curve.degree
        )
        for curve in curves
    ]
    values, counts = np.empty(0), np.empty(0, dtype=np.intp)
    for curve in raised:
        own, times = knot.inner_runs(curve.knots, degree)
        both = np.union1d(values, own)
        merged = np.zeros(both.size, dtype=np.intp)
        merged[np.searchsorted(both, values)] = counts
        at = np.searchsorted(both, own)
        merged[at] = np.maximum(merged[at], times)
        values, counts = both, merged
    knots = knot.clamped_knots(start, values, counts, end, degree)
    rows = [
        knot.over_knots(c.knots, c.homogeneous if rational else c.points, degree, knots)
        for c in raised
    ]
    return Sections(knots, np.array(rows), degree, rational)
