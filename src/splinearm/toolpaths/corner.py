"""How far corners between ways are rounded, so that the tool stays within their tolerance."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.curves.hermite import quintic_pieces

from .stroke import Strokes

FREE = 5e-4
"""How far corners may be cut where the program says "as far as it likes", m."""

DEVIATION = 3.0 / 16.0
"""A quintic rounding of half width h between lines is off the corner by 3/16 h |change of unit
direction| (by its middle: half of what the chord is off, less 5/16 of it)."""

_CURVED = 1.0 / 20.0
"""A kink of the curvature by k is off by less than about this times k h^2."""

_LOPSIDED = 3.0
"""So many times longer a rounding may be on one side of its corner than on the other."""

_SHRINK = 0.8
_MOST_ROUNDS = 40
_LOOKS = np.linspace(0.0, 1.0, 11)[1:-1]
_DENSE = np.linspace(0.0, 1.0, 25)

_BACK = 1.99
"""Directions that differ by more than this turn back: no rounding, a stop."""


def half_widths(
    strokes: Strokes, corners: IndexArray, tolerance: FloatArray, turn: FloatArray, kink: FloatArray
) -> FloatArray:
    """Give how far before and behind corners roundings begin and end, shape (k, 2), m; 0: a stop.

    Neither is more than half of its way, so that roundings never overlap, and those of short ways
    touch.

    Args:
        strokes: The ways.
        corners: Each between this way and the one before, shape (k,).
        tolerance: How far the tool may be off the corner's ways, shape (k,), m.
        turn: How much unit directions differ, shape (k,).
        kink: How much curvatures differ, shape (k,), 1/m.
    """
    lengths = strokes.lengths
    room = 0.5 * np.stack((lengths[corners - 1], lengths[corners]), axis=1)
    by_turn = tolerance / (DEVIATION * np.maximum(turn, 1e-12))
    by_kink = np.sqrt(tolerance / (_CURVED * np.maximum(kink, 1e-12)))
    widths: FloatArray = np.minimum(room, np.minimum(by_turn, by_kink)[:, None])
    # ways of very different length would make a rounding that is lopsided
    widths = np.minimum(widths, _LOPSIDED * widths.min(axis=1, keepdims=True))
    widths[turn > _BACK] = 0.0
    open_ones = np.flatnonzero(widths[:, 0] > 0.0)
    for _ in range(_MOST_ROUNDS):
        if open_ones.size == 0:
            return widths
        off = _off(strokes, corners[open_ones], widths[open_ones])
        open_ones = open_ones[off > tolerance[open_ones]]
        widths[open_ones] *= _SHRINK
    widths[open_ones] = 0.0
    return widths


def _off(strokes: Strokes, corners: IndexArray, widths: FloatArray) -> FloatArray:
    """Give how far roundings get from their ways, or corners from roundings, shape (k,), m."""
    at = strokes.edges[corners]
    before, behind = at - widths[:, 0], at + widths[:, 1]
    whole = behind - before
    starts, ends = strokes.jets(before, corners - 1), strokes.jets(behind, corners)
    powers = (whole[:, None] * _LOOKS)[:, :, None] ** np.arange(6)
    rounded = np.einsum("ksj,kjn->ksn", powers, quintic_pieces(whole, starts, ends))
    nearest: FloatArray = np.full(rounded.shape[:2], np.inf)
    for way, first, width in ((corners - 1, before, widths[:, 0]), (corners, at, widths[:, 1])):
        s = first[:, None] + width[:, None] * _DENSE
        p = strokes.jets(s.ravel(), np.repeat(way, len(_DENSE)))[0].reshape(*s.shape, 3)
        nearest = np.minimum(nearest, _away(rounded, p))
    corner = strokes.jets(at, corners)[0][:, None]
    worst: FloatArray = np.maximum(nearest.max(axis=1), _away(corner, rounded)[:, 0])
    return worst


def _away(points: FloatArray, chords: FloatArray) -> FloatArray:
    """Give how far points (k, m, 3) are from chords through places (k, c, 3), shape (k, m)."""
    base, step = chords[:, None, :-1], np.diff(chords, axis=1)[:, None]
    out = points[:, :, None] - base
    share = np.sum(out * step, axis=3) / np.maximum(np.sum(step * step, axis=3), 1e-300)
    foot = out - np.clip(share, 0.0, 1.0)[..., None] * step
    away: FloatArray = np.linalg.norm(foot, axis=3).min(axis=2)
    return away
