"""Outer knots of B-splines: unclamped and ring-like forms of the same curve, on bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import knot


def moved_knots(knots: FloatArray, degree: int, start: float, end: float) -> FloatArray:
    """Give the knots over another domain, whose ends are met exactly; it may fall."""
    first, last = knots[degree], knots[-degree - 1]
    moved: FloatArray = start + (knots - first) * ((end - start) / (last - first))
    moved[knots == first] = start
    moved[knots == last] = end
    return moved


def wrapped_knots(turn: FloatArray, degree: int) -> FloatArray:
    """Give the knots of one turn with ``degree`` more on both sides, as if it went on and on."""
    m = turn.size - 1
    steps = np.diff(turn)
    # from the ends outwards: equal knots stay equal
    before = turn[0] - np.cumsum(steps[np.arange(-1, -degree - 1, -1) % m])
    behind = turn[-1] + np.cumsum(steps[np.arange(degree) % m])
    return np.concatenate((before[::-1], turn, behind))


def unclamp(knots: FloatArray, rows: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """Give the same curve with outer knots that repeat the steps of the other end."""
    turn = _turn(knots, degree, 1)
    new_knots = wrapped_knots(turn, degree)
    return new_knots, knot.over_knots(knots, rows, degree, new_knots)


def close(
    knots: FloatArray, rows: FloatArray, degree: int, tolerance: float = 1e-12, *, seam: int = 1
) -> tuple[FloatArray, FloatArray]:
    """Give the same curve as one of a ring of points, as smooth at the seam as it is.

    Args:
        knots: Knots.
        rows: Control points.
        degree: Degree, at least 1.
        tolerance: How far points that belong together may be apart, of the largest.
        seam: How often at least the knot at the seam is there.

    Raises:
        CurveError: If the curve does not end where it starts.
    """
    size = np.abs(rows).max()
    gap = np.inf
    for times in range(min(seam, degree), degree + 1):
        turn = _turn(knots, degree, times)
        new_knots = wrapped_knots(turn, degree)
        points = knot.over_knots(knots, rows, degree, new_knots)
        m = len(points) - degree
        # the last points belong to functions that begin where the curve ends
        gap = _gap(points[: len(points) - times + 1], m)
        if gap <= tolerance * size:
            return new_knots, points[np.arange(m + degree) % m]
    raise CurveError(f"not closed: its ends are {gap:.3g} apart", "B-spline")


def seam_of(knots: FloatArray, degree: int) -> int:
    """Give how often the last knot of the domain is there."""
    return int(np.count_nonzero(knots == knots[-degree - 1]))


def is_ring(knots: FloatArray, rows: FloatArray, degree: int) -> bool:
    """Tell whether knots and points go on after the end as they began, but for rounding."""
    m = len(rows) - degree
    close = 1e-12 * np.abs(rows).max()
    if degree == 0 or m < 1 or not (np.abs(rows[m] - rows[0]) <= close).all():
        return False
    turn = knots[degree : degree + m + 1]
    apart = np.abs(wrapped_knots(turn, degree) - knots).max()
    away = 1e-12 * max(abs(turn[0]), abs(turn[-1]), turn[-1] - turn[0])
    return bool(apart <= away and _gap(rows, m) <= close)


def _turn(knots: FloatArray, degree: int, times: int) -> FloatArray:
    """Give the knots of the domain, its start once and its end so many times."""
    start, end = knots[degree], knots[-degree - 1]
    inner = knots[(knots > start) & (knots < end)]
    return np.concatenate(([start], inner, np.full(times, end)))


def _gap(rows: FloatArray, m: int) -> float:
    """Give by how much rows miss those m before them."""
    return float(np.abs(rows[m:] - rows[np.arange(len(rows) - m) % m]).max(initial=0.0))
