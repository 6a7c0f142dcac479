"""Curves over other knots or of another degree without changing the curve, on bare arrays.

Nobody checks here. ``rows`` are control points of any number of columns, of rational curves
homogeneous; ``knots`` has shape (m + degree + 1,) for m of them.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from splinearm.arrays import FloatArray

from .basis import IndexArray


def over_knots(
    knots: FloatArray, rows: FloatArray, degree: int, new_knots: FloatArray
) -> FloatArray:
    """Give the control points over other knots, among them all that the curve needs.

    The domain of the new knots lies in the old one. Outer knots may be any.
    """
    out = np.empty((new_knots.size - degree - 1, rows.shape[1]))
    _kernels()[0](knots, rows, new_knots, out)
    return out


def refine(
    knots: FloatArray, rows: FloatArray, degree: int, us: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give knots and control points of the same curve with more knots in its domain."""
    new_knots = np.sort(np.concatenate((knots, us)), kind="stable")
    return new_knots, over_knots(knots, rows, degree, new_knots)


def runs(knots: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Give the different knots and how often each is there."""
    first = np.flatnonzero(np.concatenate(([True], knots[1:] > knots[:-1])))
    return knots[first], np.diff(first, append=knots.size)


def inner_runs(knots: FloatArray, degree: int) -> tuple[FloatArray, IndexArray]:
    """Give the different knots inside the domain and how often each is there."""
    start, end = knots[degree], knots[-degree - 1]
    low = int(knots.searchsorted(start, side="right"))
    high = int(knots.searchsorted(end, side="left"))
    return runs(knots[low:high]) if low < high else (np.empty(0), np.empty(0, dtype=np.intp))


def clamped_knots(
    start: float, values: FloatArray, counts: IndexArray | int, end: float, degree: int
) -> FloatArray:
    """Give clamped knots from start to end with inner values so many times each."""
    return np.concatenate(
        (np.full(degree + 1, start), np.repeat(values, counts), np.full(degree + 1, end))
    )


def trim(
    knots: FloatArray, rows: FloatArray, degree: int, start: float, end: float
) -> tuple[FloatArray, FloatArray]:
    """Give the part of a curve from ``start`` to ``end``, clamped at both."""
    low = int(knots.searchsorted(start, side="right"))
    high = int(knots.searchsorted(end, side="left"))
    new_knots = np.concatenate(
        (np.full(degree + 1, start), knots[low:high], np.full(degree + 1, end))
    )
    return new_knots, over_knots(knots, rows, degree, new_knots)


def bezier_points(
    knots: FloatArray, rows: FloatArray, degree: int
) -> tuple[FloatArray, FloatArray]:
    """Give the Bezier pieces of a curve.

    Returns:
        The k + 1 ends of the pieces, and control points of shape (k, degree + 1, columns).
    """
    values, counts = inner_runs(knots, degree)
    ends = np.concatenate((knots[degree : degree + 1], values, knots[-degree - 1 :][:1]))
    points = over_knots(knots, rows, degree, np.repeat(ends, degree + 1))
    pieces = points.reshape(-1, degree + 1, rows.shape[1])
    # neighbours share a point, to the last bit, wherever the curve is in one piece
    whole = np.flatnonzero(counts <= degree)
    pieces[whole + 1, 0] = pieces[whole, -1]
    return ends, pieces


def elevate(knots: FloatArray, rows: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """Give knots and control points of the same curve, one degree higher."""
    values, counts = runs(knots)
    raised = np.repeat(values, counts + 1)
    # as many outer knots as the new degree needs, none of them without width
    first = int(raised.searchsorted(knots[degree], side="right")) - degree - 2
    last = int(raised.searchsorted(knots[-degree - 1], side="left")) + degree + 2
    new_knots = raised[first:last]
    out = np.empty((new_knots.size - degree - 2, rows.shape[1]))
    _kernels()[1](knots, rows, new_knots, out)
    return new_knots, out


def remove(
    knots: FloatArray, rows: FloatArray, degree: int, u: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Take a knot inside the domain out once, with the least change of the control points.

    Returns:
        The other knots, their control points, and by how much the control points over the old
        knots changed, shape (m, columns).
    """
    last = int(knots.searchsorted(u, side="right")) - 1
    times = last + 1 - int(knots.searchsorted(u, side="left"))
    m = len(rows)
    out = np.empty((2 * m - 1, rows.shape[1]))
    _kernels()[2](knots, rows, np.array([degree, last, times], dtype=np.float64), out)
    return np.delete(knots, last), out[: m - 1], out[m - 1 :]


@functools.cache
def _kernels() -> tuple[Callable[..., Any], ...]:
    """Give the kernels, compiled for their arguments."""
    from splinearm.compiled import entry, inputs, outputs

    from . import blossom_kernel

    return (
        entry(blossom_kernel.over_knots, *inputs(1, 2, 1), *outputs(2)),
        entry(blossom_kernel.elevate, *inputs(1, 2, 1), *outputs(2)),
        entry(blossom_kernel.remove, *inputs(1, 2, 1), *outputs(2)),
    )
