"""Surfaces fitted to places that are known for every u and v, within a tolerance."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import banded, basis, knot
from .basis import IndexArray
from .surface import BSplineSurface

Places = Callable[[FloatArray, FloatArray], FloatArray]
"""Gives the places of each u with each v: (k,), (l,) to (k, l, dim)."""

_MOST_SPANS = 600
_MOST_ROUNDS = 20
_LOOKS = np.array([0.21, 0.5, 0.79])


class _Direction(NamedTuple):
    """One direction of a fit: its knots, and where places are taken and looked at."""

    knots: FloatArray
    taken: FloatArray
    looked: FloatArray


def fitted(
    places: Places,
    knots: tuple[FloatArray, FloatArray],
    tolerance: float,
    degree: int = 3,
) -> tuple[BSplineSurface, float]:
    """Give the surface through places at as many u and v as it takes.

    Args:
        places: What gives the places.
        knots: Clamped knots along u and along v to begin with, for the degree: those at which the
            places are not smooth, so often that the surface need not be smoother.
        tolerance: How far the surface may be from a place at the same u and v.
        degree: Degree both ways.

    Returns:
        The surface, and how far it is away at most where it was looked at, in between those u and
        v that it was made from.

    Raises:
        CurveError: If more than 600 spans in a direction would be needed.
    """
    along = [knots[0], knots[1]]
    for _ in range(_MOST_ROUNDS):
        u, v = (_direction(k, degree) for k in along)
        if max(u.looked.size, v.looked.size) > _LOOKS.size * _MOST_SPANS:
            break
        surface = _interpolated(places(u.taken, v.taken), u, v, degree)
        # along lines on which places were taken in one direction, the error is that of the other
        off_u = _off(places, surface, u.looked, v.taken).max(axis=1)
        off_v = _off(places, surface, u.taken, v.looked).max(axis=0)
        if max(off_u.max(), off_v.max()) <= tolerance / 3.0:
            off = float(_off(places, surface, u.looked, v.looked).max())
            off = max(off, float(off_u.max()), float(off_v.max()))
            if off <= tolerance:
                return surface, off
        allowed = min(tolerance / 3.0, float(max(off_u.max(), off_v.max())) * 0.999)
        along = [_halved(k, e, allowed) for k, e in zip(along, (off_u, off_v), strict=True)]
    raise CurveError(
        f"{tolerance:.3g} cannot be reached with {_MOST_SPANS} spans in a direction", "surface fit"
    )


def first_knots(knots: FloatArray, degree: int, new_degree: int, lost: int) -> FloatArray:
    """Give clamped knots of another degree for what has so many derivatives less than a curve."""
    values, counts = knot.inner_runs(knots, degree)
    smooth = degree - counts - lost
    times = np.clip(new_degree - smooth, 1, new_degree)
    return knot.clamped_knots(
        knots[degree], values, times.astype(np.intp), knots[-degree - 1], new_degree
    )


def _direction(knots: FloatArray, degree: int) -> _Direction:
    # the means of knots suit interpolation (de Boor, A Practical Guide to Splines, 1978, ch. XIII)
    means = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree).mean(axis=1)
    breaks = np.unique(knots)
    looked = breaks[:-1, None] + np.diff(breaks)[:, None] * _LOOKS
    return _Direction(knots, np.clip(means, knots[0], knots[-1]), looked.ravel())


def _interpolated(values: FloatArray, u: _Direction, v: _Direction, degree: int) -> BSplineSurface:
    m, n, dim = values.shape
    half = _solved(u, degree, values.reshape(m, -1)).reshape(m, n, dim)
    other = _solved(v, degree, half.swapaxes(0, 1).reshape(n, -1)).reshape(n, m, dim)
    return BSplineSurface(u.knots, v.knots, other.swapaxes(0, 1), degree, degree)


def _solved(along: _Direction, degree: int, values: FloatArray) -> FloatArray:
    spans: IndexArray = basis.find_spans(along.knots, degree, along.taken)
    rows = basis.basis_values(along.knots, degree, spans, along.taken)
    return banded.solve(spans - degree, rows, values)


def _off(places: Places, surface: BSplineSurface, u: FloatArray, v: FloatArray) -> FloatArray:
    """Give how far places are from the surface, shape (k, l)."""
    gap = surface.grid(u, v)[:, :, 0, 0] - places(u, v)
    distances: FloatArray = np.sqrt(np.sum(gap * gap, axis=-1))
    return distances


def _halved(knots: FloatArray, off: FloatArray, allowed: float) -> FloatArray:
    """Give knots with those spans halved in which something is off by more than allowed."""
    breaks = np.unique(knots)
    rough = off.reshape(-1, _LOOKS.size).max(axis=1) > allowed
    middles = 0.5 * (breaks[:-1] + breaks[1:])[rough]
    return np.sort(np.concatenate((knots, middles)))
