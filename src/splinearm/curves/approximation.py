"""B-splines with few control points, nowhere farther than a tolerance from what is given."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from .bspline import BSpline
from .cell import halves
from .fit import FitEnds, parameters_of
from .interpolation import Parameters
from .knot_search import Search

_SAMPLES = 16
"""Samples of each piece of a curve that are taken at first."""

_FEWEST = 201
_ROUNDS = 12
_CLOSER = 0.02
"""By what share samples are to be nearer than the tolerance, more each round."""

_HALVINGS = 40


def approximate(
    points: ArrayInput,
    tolerance: float,
    *,
    degree: int = 3,
    parameters: Parameters | ArrayInput = "chord",
    ends: FitEnds = "kept",
    geometric: bool = False,
) -> tuple[BSpline, float]:
    """Give a B-spline with few control points within a tolerance of each point at its parameter.

    Knots are put in where it is too far away, then placed anew by how much each place needs
    them, then taken out for as long as it stays near enough.

    Args:
        points: Points, shape (k, dim); of a closed curve each once.
        tolerance: How far the curve may be from a point, in the unit of the points, above 0.
        degree: Degree, at least 1.
        parameters: How to choose the parameters, or the parameters themselves, rising, shape
            (k,), of a closed curve (k + 1,).
        ends: What holds at the ends.
        geometric: Whether the parameters may move along the curve, so that what counts is the
            distance of a point to its nearest place nearby.

    Returns:
        The curve, and how far it is from the point that it misses most.

    Raises:
        CurveError: If two neighbours are the same point, or rounding is larger than the tolerance.
        ValueError: If the tolerance is not above 0, or the other numbers do not fit.
    """
    _check_tolerance(tolerance)
    array = frozen_array(points, (None, None), "points")
    if ends not in ("kept", "free", "closed"):
        raise ValueError(f"ends: want kept, free or closed, got {ends!r}")
    u = parameters_of(array, parameters, closed=ends == "closed", degree=degree)
    if (np.diff(u) <= 0.0).any():
        raise ValueError(f"parameters: want them rising, got {u.tolist()}")
    search = Search(
        points=array, u=u, degree=degree, ends=ends, tolerance=tolerance, geometric=geometric
    )
    found = search.fewest(_least_knots(u, degree, ends))
    miss = np.linalg.norm(found.curve.at(found.u[: len(array)]) - array, axis=1)
    return found.curve, float(miss.max())


def approximate_curve(
    curve: BSpline | Callable[[FloatArray], ArrayInput],
    tolerance: float,
    *,
    degree: int = 3,
    domain: tuple[float, float] | None = None,
) -> tuple[BSpline, float]:
    """Give a polynomial B-spline with few control points within a tolerance of a curve everywhere.

    It keeps the parameter of the curve. Of a ``BSpline`` the distance is proved; of a function it
    is looked at in four times as many places as were used.

    Args:
        curve: A B-spline, also a rational one, or a function from parameters of shape (k,) to
            points of shape (k, dim).
        tolerance: How far both may be apart at a parameter, above 0.
        degree: Degree, at least 1.
        domain: First and last parameter of a function.

    Returns:
        The curve, and a distance that both are never apart, of a function the largest seen.

    Raises:
        CurveError: If the tolerance is not met: it is near rounding, or the curve jumps.
        ValueError: If the tolerance is not above 0, or a function comes without a domain.
    """
    _check_tolerance(tolerance)
    source = _source(curve, domain)
    ring = source.closed and degree % 2 == 1
    u = source.u
    for rounds in range(1, _ROUNDS):
        points = frozen_array(source.at(u), (len(u), None), "curve")
        search = Search(
            points=points[:-1] if ring else points,
            u=u,
            degree=degree,
            ends="closed" if ring else "kept",
            tolerance=tolerance * (1.0 - _CLOSER * rounds),
            geometric=False,
        )
        start = _least_knots(u, degree, "closed" if ring else "kept")
        found = search.fewest(
            np.sort(np.concatenate((start, source.corners(degree)))), evenly=not source.rough.size
        ).curve
        between = _subdivided(u)
        gap = np.linalg.norm(found.at(between) - source.at(between), axis=1)
        if gap.max() <= tolerance:
            error, where = float(gap.max()), np.empty(0)
            if isinstance(curve, BSpline):
                error, where = _farthest(curve, found, tolerance)
            if not where.size:
                return found, error
            u = np.union1d(u, where)
        u = np.union1d(u, between[gap > tolerance * (1.0 - _CLOSER * rounds)])
    raise CurveError(f"cannot be met within {tolerance}", "approximation")


class _Source(NamedTuple):
    """A curve that is to be approximated."""

    at: Callable[[FloatArray], FloatArray]
    u: FloatArray
    rough: FloatArray
    closed: bool

    def corners(self, degree: int) -> FloatArray:
        return np.repeat(self.rough, degree)


def _source(
    curve: BSpline | Callable[[FloatArray], ArrayInput], domain: tuple[float, float] | None
) -> _Source:
    if isinstance(curve, BSpline):
        if domain is not None:
            raise ValueError("domain: a B-spline has its own; take a part of it")
        breaks = curve.breaks
        values, counts = np.unique(curve.knots, return_counts=True)
        inside = (values > breaks[0]) & (values < breaks[-1])
        if (counts[inside] > curve.degree).any():
            raise CurveError("the curve jumps: split it first", "approximation")
        rough = values[inside & (counts >= curve.degree)]
        many = max(_SAMPLES, -(-_FEWEST // (len(breaks) - 1)))
        at = (breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(many) / many).ravel()
        # a polyline bends at every knot: there it is no ring whose bends could go
        closed = curve.is_periodic and not rough.size
        return _Source(curve.at, np.unique(np.append(at, breaks[-1])), rough, closed)
    if domain is None or not domain[0] < domain[1]:
        raise ValueError(f"domain: want first and last parameter of the function, got {domain}")
    function = curve

    def at_all(u: FloatArray) -> FloatArray:
        return np.asarray(function(u), dtype=np.float64)

    return _Source(at_all, np.linspace(*domain, _FEWEST), np.empty(0), closed=False)


def _farthest(f: BSpline, g: BSpline, tolerance: float) -> tuple[float, FloatArray]:
    """Give a distance that is nowhere exceeded, and where one above the tolerance was seen."""
    from .product import add

    gap = add(f, BSpline(g.knots, -g.points, g.degree))
    ends, rows = gap.bezier()
    low, high = ends[:-1], ends[1:]
    largest = 0.0
    for _ in range(_HALVINGS):
        places = rows[..., :-1] / rows[..., -1:] if gap.is_rational else rows
        far = np.sqrt((places * places).sum(axis=2))
        at_ends = np.maximum(far[:, 0], far[:, -1])
        if (at_ends > tolerance).any():
            return float(at_ends.max()), 0.5 * (low + high)[at_ends > tolerance]
        settled = far.max(axis=1) <= np.maximum(tolerance, 1.001 * at_ends)
        largest = max(largest, float(far[settled].max(initial=0.0)))
        if settled.all():
            break
        rows, low, high = rows[~settled], low[~settled], high[~settled]
        rows = np.concatenate(halves(rows))
        middle = 0.5 * (low + high)
        low, high = np.concatenate((low, middle)), np.concatenate((middle, high))
    else:
        return largest, 0.5 * (low + high)
    return largest, np.empty(0)


def _subdivided(u: FloatArray) -> FloatArray:
    """Give parameters with three more in each step."""
    steps = u[:-1, None] + np.diff(u)[:, None] * np.array([0.0, 0.25, 0.5, 0.75])
    return np.append(steps.ravel(), u[-1])


def _least_knots(u: FloatArray, degree: int, ends: FitEnds) -> FloatArray:
    """Give the fewest inner knots that a curve needs: none, in a ring some."""
    if ends != "closed":
        return np.empty(0)
    at = np.linspace(0, len(u) - 1, degree + 2)[1:-1]
    return np.interp(at, np.arange(len(u)), u)


def _check_tolerance(tolerance: float) -> None:
    if not (tolerance > 0.0 and np.isfinite(tolerance)):
        raise ValueError(f"tolerance: want it above 0, got {tolerance}")
