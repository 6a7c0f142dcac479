"""B-splines on bare arrays: de Boor's recurrence for curves and for basis functions.

Nothing is checked here. A parameter beyond the domain would be extrapolated: callers refuse it.
``knots`` has shape (m + degree + 1,) for m points; parameters have shape (k,). At a knot where a
curve is not smooth, values come from the right, at the end of the domain from the left.
"""

import functools
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

IndexArray = npt.NDArray[np.intp]
"""An array of indices."""


def find_spans(knots: FloatArray, degree: int, u: FloatArray) -> IndexArray:
    """Give for each parameter the index k, shape (k,), with knots[k] <= u < knots[k + 1]."""
    last = np.searchsorted(knots, knots[-degree - 1], side="left") - 1
    spans: IndexArray = np.minimum(np.searchsorted(knots, u, side="right") - 1, last)
    return spans


def evaluate(
    knots: FloatArray, points: FloatArray, degree: int, u: FloatArray, derivative: int = 0
) -> FloatArray:
    """Give a derivative (0: the value) of a curve at many parameters, shape (k, dim).

    Args:
        knots: Knots, shape (m + degree + 1,).
        points: Control points, shape (m, dim).
        degree: Degree.
        u: Parameters in the domain, shape (k,).
        derivative: Which derivative.
    """
    # de Boor, On calculating with B-splines, J. Approx. Theory 6 (1972) 50: differences of points
    # take derivatives, one degree a step; convex combinations then lead to the value
    if derivative > degree:
        return np.zeros((u.size, points.shape[1]))
    spans = find_spans(knots, degree, u)
    local = points[spans[:, None] + np.arange(-degree, 1)]
    for d in range(degree, 0, -1):
        low = knots[spans[:, None] + np.arange(1 - d, 1)]
        high = knots[spans[:, None] + np.arange(1, d + 1)]
        if d > degree - derivative:
            local = np.diff(local, axis=1) * (d / (high - low))[:, :, None]
        else:
            share = ((u[:, None] - low) / (high - low))[:, :, None]
            local = local[:, :-1] * (1.0 - share) + local[:, 1:] * share
    values: FloatArray = local[:, 0]
    return values


def evaluate_one(
    knots: FloatArray, points: FloatArray, degree: int, u: float, derivative: int = 0
) -> FloatArray:
    """Give the same as ``evaluate`` at one parameter, shape (dim,), sooner."""
    if derivative > degree:
        return np.zeros(points.shape[1])
    last = int(knots.searchsorted(knots[-degree - 1], side="left")) - 1
    span = min(int(knots.searchsorted(u, side="right")) - 1, last)
    local = points[span - degree : span + 1]
    for d in range(degree, 0, -1):
        low = knots[span + 1 - d : span + 1]
        width = knots[span + 1 : span + 1 + d] - low
        if d > degree - derivative:
            local = (local[1:] - local[:-1]) * (d / width)[:, None]
        else:
            share = ((u - low) / width)[:, None]
            local = local[:-1] * (1.0 - share) + local[1:] * share
    value: FloatArray = local[0]
    return value.copy() if degree == 0 else value


def basis_values(
    knots: FloatArray,
    degree: int,
    spans: IndexArray,
    u: FloatArray,
    derivative: int | FloatArray = 0,
) -> FloatArray:
    """Give a derivative of the degree + 1 basis functions alive at each u, shape (k, degree + 1).

    Column j belongs to control point ``spans - degree + j``. ``derivative`` is one for all, or
    that of each parameter, shape (k,).
    """
    orders = np.broadcast_to(np.asarray(derivative, dtype=np.float64), u.shape)
    values = np.empty((u.size, degree + 1))
    _kernel()(
        knots,
        spans.astype(np.float64),
        np.ascontiguousarray(u, dtype=np.float64),
        np.ascontiguousarray(orders),
        values,
    )
    return values


@functools.cache
def _kernel() -> Callable[..., None]:
    """Give what computes basis functions, compiled for its arguments."""
    from splinearm.compiled import entry, inputs, outputs

    from . import collocation_kernel

    return entry(collocation_kernel.basis_into, *inputs(1, 1, 1, 1), *outputs(2))


def derivative_points(
    knots: FloatArray, points: FloatArray, degree: int
) -> tuple[FloatArray, FloatArray]:
    """Give knots and control points of the derivative curve, one degree lower (degree >= 1)."""
    # Piegl and Tiller, eq. 3.4; where the original jumps a point of the derivative has no width
    width = knots[degree + 1 : -1] - knots[1 : -degree - 1]
    alive = width > 0.0
    slopes = np.diff(points, axis=0)[alive] * (degree / width[alive])[:, None]
    return np.append(knots[1:-1][: len(alive)][alive], knots[len(alive) + 1 : -1]), slopes


def taylor_pieces(
    knots: FloatArray, points: FloatArray, degree: int
) -> tuple[FloatArray, FloatArray]:
    """Give a curve as polynomials between its different knots.

    Returns:
        The k + 1 ends of the pieces, and coefficients of shape (k, degree + 1, dim): on piece i
        the curve is the sum of ``coefficients[i, j] * (u - ends[i]) ** j``.
    """
    ends = np.unique(knots[degree : knots.size - degree])
    coefficients = np.empty((ends.size - 1, degree + 1, points.shape[1]))
    factorial = 1.0
    for j in range(degree + 1):
        factorial *= max(j, 1)
        coefficients[:, j] = evaluate(knots, points, degree, ends[:-1], j) / factorial
    return ends, coefficients
