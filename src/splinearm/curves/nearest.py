"""Distances of points to curves in space."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from .basis import IndexArray

_SAGITTA = 1e-7
"""How far chords may be off the curve that they stand for, m."""

_MOST_CHORDS = 20_000
_BLOCK = 16
_MOST_PAIRS = 2_000_000
_STEPS = 12
_SAME = 1e-15


class SpaceCurve(Protocol):
    """A curve in space with a parameter."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        ...

    @property
    def breaks(self) -> FloatArray:
        """Ends of the smooth pieces."""
        ...

    def places(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give points and their derivatives by the parameter, each of shape (m, 3)."""
        ...


class Chords(NamedTuple):
    """Straight pieces that stand for a curve."""

    s: FloatArray
    """Parameters of their ends, shape (k + 1,)."""
    p: FloatArray
    """Their ends, shape (k + 1, 3), m."""


def chords_of(curve: SpaceCurve) -> Chords:
    """Give chords that are nowhere much farther from the curve than a tenth of a micrometre."""
    breaks = curve.breaks
    counts = np.full(len(breaks) - 1, 8)
    for _ in range(2):
        s = _subdivide(breaks, counts)
        middles = 0.5 * (s[:-1] + s[1:])
        p = curve.places(s)[0]
        off = np.linalg.norm(curve.places(middles)[0] - 0.5 * (p[:-1] + p[1:]), axis=1)
        worst = np.maximum.reduceat(off, np.concatenate(([0], np.cumsum(counts)[:-1])))
        wanted = np.ceil(counts * np.sqrt(worst / _SAGITTA) * 1.2)
        share = min(1.0, _MOST_CHORDS / float(np.maximum(wanted, 8).sum()))
        counts = np.maximum(8, (wanted * share).astype(np.intp))
    s = _subdivide(breaks, counts)
    return Chords(s, curve.places(s)[0])


def _subdivide(breaks: FloatArray, counts: FloatArray) -> FloatArray:
    pieces = [
        np.linspace(a, b, count + 1)[:-1]
        for a, b, count in zip(breaks[:-1], breaks[1:], counts, strict=True)
    ]
    return np.concatenate((*pieces, breaks[-1:]))


def distance_to_curves(
    curves: Sequence[SpaceCurve],
    points: ArrayInput,
    chords: Sequence[Chords] | None = None,
) -> FloatArray:
    """Give the distance of each point to the nearest of all places of the curves, shape (m,), m.

    Args:
        curves: The curves, at least one.
        points: The points, shape (m, 3), m.
        chords: What ``chords_of`` gives for each curve, if it is known.
    """
    array = np.asarray(points, dtype=np.float64)
    best = np.full(len(array), np.inf)
    for i, curve in enumerate(curves):
        pieces = chords_of(curve) if chords is None else chords[i]
        k = _nearest_chords(pieces, array)
        last = len(pieces.s) - 1
        low, high = pieces.s[np.maximum(k - 1, 0)], pieces.s[np.minimum(k + 2, last)]
        best = np.minimum(best, _walk_to_feet(curve, array, low, high))
    return best


def _nearest_chords(chords: Chords, points: FloatArray) -> IndexArray:
    """Give the chord that is nearest to each point, shape (m,)."""
    first, step = chords.p[:-1], np.diff(chords.p, axis=0)
    square = np.maximum(np.sum(step * step, axis=1), 1e-300)
    # blocks of chords in spheres: only blocks whose sphere may hold the nearest place are looked at
    starts = np.arange(0, len(first), _BLOCK)
    ends = np.minimum(starts + _BLOCK, len(first))
    centres = 0.5 * (chords.p[starts] + chords.p[ends])
    index = np.minimum(starts[:, None] + np.arange(_BLOCK + 1), ends[:, None])
    radii = np.linalg.norm(chords.p[index] - centres[:, None], axis=2).max(axis=1)
    nearest = np.empty(len(points), dtype=np.intp)
    chunk = max(1, _MOST_PAIRS // len(starts))
    for begin in range(0, len(points), chunk):
        some = points[begin : begin + chunk]
        # |p - c|^2 = |p|^2 - 2 p c + |c|^2, quick but for rounding near 0
        square_away = np.sum(some**2, axis=1)[:, None] - 2.0 * some @ centres.T
        square_away += np.sum(centres**2, axis=1)
        away = np.sqrt(np.maximum(square_away, 0.0))
        reach = (away + radii).min(axis=1, keepdims=True) + _SAGITTA
        who, block = np.nonzero(away - radii <= reach)
        chord = np.minimum(starts[block, None] + np.arange(_BLOCK), len(first) - 1)
        to_point = some[who, None] - first[chord]
        share = np.clip(np.sum(to_point * step[chord], axis=2) / square[chord], 0.0, 1.0)
        gap = np.linalg.norm(to_point - share[..., None] * step[chord], axis=2)
        rows, pick = np.arange(len(who)), np.argmin(gap, axis=1)
        order = np.lexsort((gap[rows, pick], who))
        winners = order[np.unique(who[order], return_index=True)[1]]
        nearest[begin + who[winners]] = chord[rows, pick][winners]
    return nearest


def _walk_to_feet(
    curve: SpaceCurve, points: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Give the distances of points to the feet of their perpendiculars between two parameters."""
    best = np.full(len(points), np.inf)

    def pull(s: FloatArray) -> FloatArray:
        nonlocal best
        p, slope = curve.places(s)
        gap = points - p
        best = np.minimum(best, np.linalg.norm(gap, axis=1))
        onward: FloatArray = np.sum(gap * slope, axis=1)
        return onward

    # false position with the Illinois rule (Dowell and Jarratt, BIT 11 (1971) 168): the foot is
    # where the way to the point no longer pulls along the curve
    at_low, at_high = pull(low), pull(high)
    was_onward = np.full(len(points), -1)
    for _ in range(_STEPS):
        fall = at_low - at_high
        share = np.where(fall > 0.0, at_low / np.where(fall > 0.0, fall, 1.0), 0.5)
        s = np.clip(low + share * (high - low), low, high)
        here = pull(s)
        onward = here > 0.0
        again = np.where(onward == was_onward, 0.5, 1.0)
        at_low = np.where(onward, here, np.where(at_low > 0.0, again * at_low, at_low))
        at_high = np.where(onward, np.where(at_high < 0.0, again * at_high, at_high), here)
        low, high = np.where(onward, s, low), np.where(onward, high, s)
        was_onward = onward.astype(np.intp)
        if (high - low).max(initial=0.0) <= _SAME:
            break
    return best
