"""Curves with fewer knots or of a lower degree, and how far they are from what they were."""

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import banded, basis, deviation, form, knot, rational
from .bspline import BSpline


def remove_knots(curve: BSpline, us: ArrayInput, tolerance: float) -> tuple[BSpline, float]:
    """Give the curve without some knots, and a distance that it is never farther from before.

    Each knot is taken out with the least change of control points that there is.

    Args:
        curve: The curve.
        us: The knots to take out, shape (k,), inside the domain or the seam of a ring of points;
            one named twice is taken out twice.
        tolerance: How far the curve may move, in the unit of its points.

    Raises:
        CurveError: If the curve would move farther, or a knot is not there as often.
        ValueError: If the tolerance is not at least 0.
    """
    if not tolerance >= 0.0:
        raise ValueError(f"tolerance: want 0 or more, got {tolerance}")
    knots, rows, degree = curve.knots, _rows_of(curve), curve.degree
    ring = curve.is_periodic
    total = 0.0
    for value in frozen_array(us, (None,), "us"):
        u = float(value)
        inside = curve.domain[0] < u < curve.domain[1] or (ring and u in curve.domain)
        times = np.count_nonzero(knots == u)
        if not inside or times == 0:
            raise CurveError("no such knot inside the curve", f"knot {u:.6g}")
        if times > degree:
            raise CurveError("the curve jumps there: split it and join the ends", f"knot {u:.6g}")
        if ring:
            knots, rows, error = _remove_from_ring(
                knots, rows, degree, u, weighted=curve.is_rational
            )
        else:
            left, points, change = knot.remove(knots, rows, degree, u)
            error = deviation.bound(rows, rows + change, rational=curve.is_rational)
            knots, rows = left, points
        if curve.is_rational:
            rational.check_weights(rows)
        total += error
        if not total <= tolerance:
            raise CurveError(
                f"without it the curve would move by up to {total:.3g}, allowed {tolerance:.3g}",
                f"knot {u:.6g}",
            )
    return _curve_of(curve, knots, rows, degree), total


def reduce_degree(curve: BSpline, tolerance: float) -> tuple[BSpline, float]:
    """Give a clamped curve of one degree less, and a distance that it is never farther from before.

    What has this degree is found exactly; else the new curve meets the old one at its ends and at
    as many places as it has control points. Each inner knot is there once less, but stays.

    Args:
        curve: The curve, of degree 2 or more, without jumps; it may be closed.
        tolerance: How far the curve may move, in the unit of its points.

    Raises:
        CurveError: If the curve would move farther, or jumps.
        ValueError: If the degree is below 2 or the tolerance is not at least 0.
    """
    if not tolerance >= 0.0:
        raise ValueError(f"tolerance: want 0 or more, got {tolerance}")
    if curve.degree < 2:
        raise ValueError(f"degree: want at least 2, got {curve.degree}")
    degree = curve.degree - 1
    values, counts = knot.inner_runs(curve.knots, curve.degree)
    if (counts > curve.degree).any():
        raise CurveError("a curve that jumps: split it first", "degree reduction")
    start, end = curve.domain
    knots = knot.clamped_knots(start, values, np.maximum(counts - 1, 1), end, degree)
    # the means of knots suit interpolation (de Boor, A Practical Guide to Splines, 1978, ch. XIII)
    means = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree).mean(axis=1)
    means = np.clip(means, start, end)
    spans = basis.find_spans(knots, degree, means)
    wanted = basis.evaluate(curve.knots, _rows_of(curve), curve.degree, means)
    table = basis.basis_values(knots, degree, spans, means)
    rows = banded.solve(spans - degree, table, wanted)
    # both curves over the knots that both need
    raised, lifted = knot.elevate(knots, rows, degree)
    common = knot.clamped_knots(start, values, np.maximum(counts, 2), end, curve.degree)
    error = deviation.bound(
        knot.over_knots(curve.knots, _rows_of(curve), curve.degree, common),
        knot.over_knots(raised, lifted, curve.degree, common),
        rational=curve.is_rational,
    )
    if curve.is_rational:
        rational.check_weights(rows)
    if not error <= tolerance:
        raise CurveError(
            f"the curve would move by up to {error:.3g}, allowed {tolerance:.3g}",
            "degree reduction",
        )
    return _curve_of(curve, knots, rows, degree), error


def _remove_from_ring(
    knots: FloatArray, rows: FloatArray, degree: int, u: float, *, weighted: bool
) -> tuple[FloatArray, FloatArray, float]:
    """Take a knot out of a closed curve, seen from the other side of the ring."""
    knots, rows = form.close(knots, rows, degree, seam=int((knots == knots[degree]).sum()))
    m = len(rows) - degree
    turn = knots[degree : degree + m + 1]
    period = turn[-1] - turn[0]
    at = int(turn.searchsorted(turn[-1] if u == turn[0] else u, side="left"))
    if at == m:
        raise CurveError("the seam of a ring needs a knot", f"knot {u:.6g}")
    if m < 2 * degree + 2:
        raise CurveError(f"a ring of {m} points has none to spare", f"knot {u:.6g}")
    # knots and points go on for ever around the ring: look at a window with the knot in its middle
    first = at - m // 2 - degree
    turns, place = np.divmod(np.arange(first - 1, first + m + 2 * degree), m)
    window = turn[place + 1] + period * turns
    points = rows[(first + degree + np.arange(m + degree)) % m]
    _, left, change = knot.remove(window, points, degree, float(window[at - first]))
    error = deviation.bound(points, points + change, rational=weighted)
    ring = np.empty((m - 1, rows.shape[1]))
    kept = np.arange(degree, degree + m - 1)
    ring[(kept + first + degree) % (m - 1)] = left[kept]
    fewer = np.delete(turn, at)
    return (
        form.wrapped_knots(fewer, degree),
        ring[np.arange(m - 1 + degree) % (m - 1)],
        error,
    )


def _rows_of(curve: BSpline) -> FloatArray:
    return curve.homogeneous if curve.is_rational else curve.points


def _curve_of(like: BSpline, knots: FloatArray, rows: FloatArray, degree: int) -> BSpline:
    if like.is_rational:
        return BSpline.from_homogeneous(knots, rows, degree)
    return BSpline(knots, rows, degree)
