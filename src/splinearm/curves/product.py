"""Exact sums, products and derivatives of curves, as curves."""

from collections.abc import Callable

import numpy as np

from splinearm.arrays import FloatArray

from . import bernstein, knot
from .basis import IndexArray
from .bspline import BSpline

Pieces = FloatArray
"""Bernstein coefficients of the pieces of a curve, shape (k, columns, degree + 1)."""


def add(f: BSpline, g: BSpline) -> BSpline:
    """Give the curve f + g, clamped.

    Args:
        f: A curve.
        g: One of as many coordinates over the same domain.

    Raises:
        ValueError: If domains or coordinates differ.
    """
    _check_equal(f, g)
    if f.weights is not None or g.weights is not None:
        return _combined(
            f, g, lambda a, b, v, w: bernstein.multiply(a, w) + bernstein.multiply(b, v)
        )
    degree = max(f.degree, g.degree)
    f, g = f.elevated(degree - f.degree).clamped(), g.elevated(degree - g.degree).clamped()
    values, counts = _common_runs(f, g, 0, 0)
    knots = knot.clamped_knots(f.domain[0], values, counts, f.domain[1], degree)
    rows = [knot.over_knots(h.knots, h.points, degree, knots) for h in (f, g)]
    return BSpline(knots, rows[0] + rows[1], degree)


def multiply(f: BSpline, g: BSpline) -> BSpline:
    """Give the curve of the products of coordinates, clamped.

    Args:
        f: A curve of one coordinate, which multiplies each of the other, or of as many.
        g: A curve over the same domain.

    Raises:
        ValueError: If domains differ, or coordinates do not fit.
    """
    if f.dim != 1:
        _check_equal(f, g)
    return _combined(f, g, lambda a, b, _v, _w: bernstein.multiply(a, b))


def dot(f: BSpline, g: BSpline) -> BSpline:
    """Give the scalar product of two curves as a curve of one coordinate, clamped.

    Raises:
        ValueError: If domains or coordinates differ.
    """
    _check_equal(f, g)
    return _combined(f, g, lambda a, b, _v, _w: bernstein.multiply(a, b).sum(axis=1, keepdims=True))


def cross(f: BSpline, g: BSpline) -> BSpline:
    """Give the vector product of two curves in space, in the plane its one coordinate; clamped.

    Raises:
        ValueError: If domains differ or coordinates are not 2 or 3 each.
    """
    _check_equal(f, g)
    if f.dim not in (2, 3):
        raise ValueError(f"dim: want 2 or 3 coordinates for a vector product, got {f.dim}")
    pairs = ((0, 1),) if f.dim == 2 else ((1, 2), (2, 0), (0, 1))

    def turned(a: Pieces, b: Pieces, _v: Pieces, _w: Pieces) -> Pieces:
        first, second = [i for i, _ in pairs], [j for _, j in pairs]
        return bernstein.multiply(a[:, first], b[:, second]) - bernstein.multiply(
            a[:, second], b[:, first]
        )

    return _combined(f, g, turned)


def squared_speed(curve: BSpline) -> BSpline:
    """Give |C'|^2 as a curve of one coordinate, clamped."""
    velocity = derivative_of(curve)
    return dot(velocity, velocity)


def derivative_of(curve: BSpline) -> BSpline:
    """Give the derivative as a curve; of a rational one of degree p it has degree 2 p."""
    p = curve.degree
    if curve.weights is None or p == 0:
        return BSpline(curve.knots, curve.points, p).derivative()
    ends, rows = _pieces(curve, np.empty(0))
    a, w = rows[:, :-1], rows[:, -1:]
    # (A / w)' = (A' w - A w') / w^2, its numerator one degree lower (Piegl and Tiller, The NURBS
    # Book, 2nd ed. 1997, eq. 4.7)
    width = np.diff(ends)[:, None, None]
    slope = bernstein.multiply(bernstein.differentiate(a), w)
    slope -= bernstein.multiply(a, bernstein.differentiate(w))
    raised = bernstein.multiply(slope / width, np.ones(2))
    coefficients = np.concatenate((raised, bernstein.multiply(w, w)), axis=1)
    _, counts = knot.inner_runs(curve.knots, p)
    return _joined(ends, coefficients, counts + p + 1, is_rational=True)


def _combined(
    f: BSpline, g: BSpline, combine: Callable[[Pieces, Pieces, Pieces, Pieces], Pieces]
) -> BSpline:
    """Give a curve whose pieces are a product of those of two curves."""
    if f.domain != g.domain:
        raise ValueError(f"domain: want the same of both curves, got {f.domain} and {g.domain}")
    values, counts = _common_runs(f, g, g.degree, f.degree)
    ends, a = _pieces(f, values)
    _, b = _pieces(g, values)
    v = a[:, -1:] if f.is_rational else np.ones((len(a), 1, f.degree + 1))
    w = b[:, -1:] if g.is_rational else np.ones((len(b), 1, g.degree + 1))
    top = combine(a[:, : f.dim], b[:, : g.dim], v, w)
    if not (f.is_rational or g.is_rational):
        return _joined(ends, top, counts, is_rational=False)
    coefficients = np.concatenate((top, bernstein.multiply(v, w)), axis=1)
    return _joined(ends, coefficients, counts, is_rational=True)


def _joined(
    ends: FloatArray, coefficients: Pieces, counts: IndexArray, *, is_rational: bool
) -> BSpline:
    """Give the curve of pieces that are known to be as smooth as the counts of its knots say."""
    degree = coefficients.shape[2] - 1
    knots = knot.clamped_knots(
        ends[0], ends[1:-1], np.minimum(counts, degree + 1), ends[-1], degree
    )
    rows = np.ascontiguousarray(coefficients.swapaxes(1, 2)).reshape(-1, coefficients.shape[1])
    points = knot.over_knots(np.repeat(ends, degree + 1), rows, degree, knots)
    if is_rational:
        return BSpline.from_homogeneous(knots, points, degree)
    return BSpline(knots, points, degree)


def _pieces(curve: BSpline, more: FloatArray) -> tuple[FloatArray, Pieces]:
    """Give the ends and coefficients of the pieces between a curve's knots and more knots."""
    values, _ = knot.inner_runs(curve.knots, curve.degree)
    ends = np.concatenate((curve.domain[:1], np.union1d(values, more), curve.domain[1:]))
    p = curve.degree
    rows = curve.homogeneous if curve.is_rational else curve.points
    points = knot.over_knots(curve.knots, rows, p, np.repeat(ends, p + 1))
    return ends, points.reshape(-1, p + 1, rows.shape[1]).swapaxes(1, 2)


def _common_runs(f: BSpline, g: BSpline, more_f: int, more_g: int) -> tuple[FloatArray, IndexArray]:
    """Give the inner knots of two curves and how often a combination needs them."""
    found = [knot.inner_runs(h.knots, h.degree) for h in (f, g)]
    values = np.union1d(found[0][0], found[1][0])
    counts = np.zeros(values.size, dtype=np.intp)
    for (own, times), more in zip(found, (more_f, more_g), strict=True):
        at = np.searchsorted(values, own)
        counts[at] = np.maximum(counts[at], times + more)
    return values, counts


def _check_equal(f: BSpline, g: BSpline) -> None:
    if f.domain != g.domain:
        raise ValueError(f"domain: want the same of both curves, got {f.domain} and {g.domain}")
    if f.dim != g.dim:
        raise ValueError(f"dim: want as many coordinates of both, got {f.dim} and {g.dim}")
