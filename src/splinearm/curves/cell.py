"""Pairs of pieces of two curves that may meet, halved until each meeting is known, bare arrays.

Pieces are homogeneous Bezier points, shape (k, degree + 1, dim + 1). A pair is left out only where
the hulls of its points are farther apart than the tolerance.
"""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from .basis import IndexArray
from .root import BoolArray

_MOST_PAIRS = 400_000
_MOST_LEVELS = 60
_CHUNK = 2_000_000
_STEPS = 12
_ROUNDING = 1e-14
_NEAR = 1e-3
_TURN = np.cos(np.deg2rad(80.0))
"""A piece whose directions are all within this of one does not meet itself."""


class Pairs(NamedTuple):
    """Pairs of pieces, each with the ends of its parameters."""

    a: FloatArray
    """Pieces of one curve, shape (k, degree + 1, dim + 1)."""
    b: FloatArray
    """Pieces of the other."""
    u: FloatArray
    """Their first and last parameters, shape (k, 2)."""
    v: FloatArray
    """Those of the other, shape (k, 2)."""

    def take(self, which: BoolArray | IndexArray) -> "Pairs":
        """Give some of the pairs."""
        return Pairs(self.a[which], self.b[which], self.u[which], self.v[which])


class Candidates(NamedTuple):
    """What is left of pairs: places where two curves cross, and pieces all along within reach."""

    places: FloatArray
    """Parameters of both, shape (k, 2)."""
    cells: FloatArray
    """First and last parameter of one, then of the other curve, shape (j, 4)."""


def places_of(rows: FloatArray) -> FloatArray:
    """Give the control points of pieces, shape (k, degree + 1, dim)."""
    points: FloatArray = rows[..., :-1] / rows[..., -1:]
    return points


def halves(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give both halves of each piece, by de Casteljau."""
    first, last = [rows[:, 0]], [rows[:, -1]]
    while rows.shape[1] > 1:
        rows = 0.5 * (rows[:, :-1] + rows[:, 1:])
        first.append(rows[:, 0])
        last.append(rows[:, -1])
    return np.stack(first, axis=1), np.stack(last[::-1], axis=1)


def pair_up(a: FloatArray, b: FloatArray, u: FloatArray, v: FloatArray, tolerance: float) -> Pairs:
    """Give all pairs of pieces whose boxes are no farther apart than the tolerance."""
    low_a, high_a = places_of(a).min(axis=1), places_of(a).max(axis=1)
    low_b, high_b = places_of(b).min(axis=1), places_of(b).max(axis=1)
    found: list[IndexArray] = []
    step = max(1, _CHUNK // max(len(b), 1))
    for start in range(0, len(a), step):
        part = slice(start, start + step)
        near = (low_a[part, None] <= high_b + tolerance) & (low_b <= high_a[part, None] + tolerance)
        i, j = np.nonzero(near.all(axis=2))
        found.append(np.stack((i + start, j)))
    i, j = np.concatenate(found, axis=1)
    return Pairs(a[i], b[j], u[i], v[j])


def monotone(rows: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the pieces cut so that none turns by much, but for those at cusps."""
    done_rows, done_u = [], []
    for _ in range(_MOST_LEVELS - 10):
        narrow = _cones(rows)[1] >= _TURN
        done_rows.append(rows[narrow])
        done_u.append(u[narrow])
        rows, u = rows[~narrow], u[~narrow]
        if not len(rows):
            break
        (first, before), (last, behind) = _sides(rows, u)
        rows, u = np.concatenate((first, last)), np.concatenate((before, behind))
    all_u = np.concatenate((*done_u, u))
    order = np.argsort(all_u[:, 0], kind="stable")
    return np.concatenate((*done_rows, rows))[order], all_u[order]


def meet(pairs: Pairs, tolerance: float, seam: tuple[float, float] | None = None) -> Candidates:
    """Give where pairs of pieces meet.

    Args:
        pairs: The pairs.
        tolerance: How far places that count as one may be apart.
        seam: None for two curves. For one curve with itself its first and last parameter if it
            is closed, else two numbers that are no parameters: neighbours then do not meet where
            one goes on as the other.

    Raises:
        CurveError: If curves run side by side so near that too many pairs are left.
    """
    places, cells = [np.empty((0, 2))], [np.empty((0, 4))]
    for level in range(_MOST_LEVELS):
        pairs = pairs.take(_may_meet(pairs, tolerance))
        joined = _joined(pairs, seam, tolerance)
        if joined.any():
            pairs = pairs.take(~(joined & _go_on(pairs)))
            joined = _joined(pairs, seam, tolerance)
        if not len(pairs.u):
            break
        crossing = _cross(pairs)
        apart, at, inside = _approach(pairs, crossing)
        met, near = apart <= tolerance, np.zeros(len(pairs.u), dtype=np.bool)
        places.append(at[met & inside & ~joined[crossing]])
        # the one meeting of neighbours in different directions is where they are joined
        found = near.copy()
        found[crossing] = (met & inside) | joined[crossing]
        near[crossing] = met
        along = ~found & (near | _within(pairs, 2.0 * tolerance) | (level == _MOST_LEVELS - 1))
        boxes = np.concatenate((pairs.u, pairs.v), axis=1)
        # of pieces that approach each other at an angle only what is around the nearest places
        boxes[crossing[met]] = _around(boxes[crossing[met]], at[met])
        cells.append(boxes[along])
        pairs = _halved(pairs.take(~found & ~along))
        if len(pairs.u) > _MOST_PAIRS:
            raise CurveError(
                f"the curves run side by side: more than {_MOST_PAIRS} pairs of pieces are within "
                f"{tolerance:.3g}; take a larger tolerance",
                f"u = {pairs.u[0, 0]:.6g}",
            )
    return Candidates(np.concatenate(places), np.concatenate(cells))


def _chords(points: FloatArray) -> FloatArray:
    """Give unit vectors from start to end of pieces, 0 for those that end where they start."""
    way = points[:, -1] - points[:, 0]
    size = np.linalg.norm(way, axis=1, keepdims=True)
    return np.asarray(np.divide(way, size, out=np.zeros_like(way), where=size > 0.0))


def _may_meet(pairs: Pairs, tolerance: float) -> BoolArray:
    """Tell which hulls are not seen to be apart along any of some directions."""
    a, b = places_of(pairs.a), places_of(pairs.b)
    apart = np.maximum(b.min(axis=1) - a.max(axis=1), a.min(axis=1) - b.max(axis=1)).max(axis=1)
    near: BoolArray = apart <= tolerance
    which = np.flatnonzero(near)
    a, b = a[which], b[which]
    way = b.mean(axis=1) - a.mean(axis=1)
    chord_a, chord_b = _chords(a), _chords(b)
    beside_a, beside_b = _without(way, chord_a), _without(way, chord_b)
    other = _chords(np.stack((np.zeros_like(way), _without(chord_b, chord_a)), axis=1))
    for axis in (way, beside_a, beside_b, _without(beside_a, other)):
        size = np.linalg.norm(axis, axis=1)
        along = np.divide(axis, size[:, None], out=np.zeros_like(axis), where=size[:, None] > 0.0)
        # of all the same direction first: it points from a to b
        gap = np.einsum("kjd,kd->kj", b - a[:, :1], along).min(axis=1)
        gap -= np.einsum("kjd,kd->kj", a - a[:, :1], along).max(axis=1)
        near[which[gap > tolerance]] = False
    return near


def _without(vectors: FloatArray, units: FloatArray) -> FloatArray:
    """Give vectors without what they have along unit vectors."""
    return np.asarray(vectors - (vectors * units).sum(axis=1, keepdims=True) * units)


def _cones(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give a unit vector for each piece and the cosine of the largest angle of its directions."""
    # the derivative of a Bezier curve, also of a rational one, points between the differences of
    # its control points (Floater, Derivatives of rational Bezier curves, CAGD 9 (1992) 161)
    way = np.diff(places_of(rows), axis=1)
    size = np.linalg.norm(way, axis=2, keepdims=True)
    unit = np.divide(way, size, out=np.zeros_like(way), where=size > 0.0)
    middle = unit.sum(axis=1)
    length = np.linalg.norm(middle, axis=1, keepdims=True)
    axis = np.divide(middle, length, out=np.zeros_like(middle), where=length > 0.0)
    cosine = np.einsum("kjd,kd->kj", unit, axis)
    cosine[size[..., 0] == 0.0] = 1.0
    # a piece that is a point has no direction, but nothing to meet twice either
    return axis, cosine.min(axis=1)


def _cross(pairs: Pairs) -> IndexArray:
    """Give the pairs that have no direction in common, and so meet once at most."""
    # Sederberg and Meyers, Loop detection in surface patch intersections, CAGD 5 (1988) 161
    (one, low), (two, other) = _cones(pairs.a), _cones(pairs.b)
    between = np.arccos(np.clip(np.abs((one * two).sum(axis=1)), 0.0, 1.0))
    narrow = (low > 0.0) & (other > 0.0)
    wide = np.arccos(np.clip(low, 0.0, 1.0)) + np.arccos(np.clip(other, 0.0, 1.0))
    return np.flatnonzero(narrow & (between > wide * (1.0 + 1e-9) + 1e-7))


def _jets(rows: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give places and derivatives of pieces, each at its own t from 0 to 1."""
    share, degree = t[:, None, None], rows.shape[1] - 1
    for _ in range(degree - 1):
        rows = rows[:, :-1] * (1.0 - share) + rows[:, 1:] * share
    value = rows[:, 0] * (1.0 - t[:, None]) + rows[:, -1] * t[:, None]
    slope = degree * (rows[:, -1] - rows[:, 0])
    w = value[:, -1:]
    point = value[:, :-1] / w
    return point, (slope[:, :-1] - point * slope[:, -1:]) / w


def _approach(pairs: Pairs, which: IndexArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Give how near pieces come, the parameters there, and whether both go on beyond.

    Where they meet but for rounding they need not go on.
    """
    a, b, u, v = pairs.take(which)
    s, t = np.full(len(u), 0.5), np.full(len(u), 0.5)
    for _ in range(_STEPS if len(u) else 0):
        (p, da), (q, db) = _jets(a, s), _jets(b, t)
        gap = q - p
        aa, bb, ab = ((x * y).sum(axis=1) for x, y in ((da, da), (db, db), (da, db)))
        ga, gb = (gap * da).sum(axis=1), (gap * db).sum(axis=1)
        free = aa * bb - ab * ab
        with np.errstate(divide="ignore", invalid="ignore"):
            # Gauss and Newton, kept on both pieces
            s_new = np.clip(s + np.nan_to_num((bb * ga - ab * gb) / free), 0.0, 1.0)
            t_new = np.clip(t + np.nan_to_num((ab * (s_new - s) - gb) / bb), 0.0, 1.0)
            s_new = np.clip(s + np.nan_to_num((ab * (t_new - t) + ga) / aa), 0.0, 1.0)
        moved = max(np.abs(s_new - s).max(), np.abs(t_new - t).max())
        s, t = s_new, t_new
        if moved <= 1e-16:
            break
    at = np.stack((_between(u, s), _between(v, t)), axis=1)
    if not len(u):
        return np.empty(0), at, np.empty(0, dtype=np.bool)
    p, q = _jets(a, s)[0], _jets(b, t)[0]
    apart = np.linalg.norm(p - q, axis=1)
    inside = (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0)
    size = np.maximum(np.abs(places_of(a)).max(axis=(1, 2)), np.abs(places_of(b)).max(axis=(1, 2)))
    # in the plane what crosses meets; in space it may pass by
    met = apart <= _ROUNDING * size
    return apart, at, met | (inside & (p.shape[1] > 2))


def _around(boxes: FloatArray, at: FloatArray) -> FloatArray:
    """Give the part of boxes, first and last u and v, that is near places in them."""
    u, v = boxes[:, :2], boxes[:, 2:]
    near = [
        np.clip(x[:, None] + _NEAR * np.diff(ends, axis=1) * [-1.0, 1.0], ends[:, :1], ends[:, 1:])
        for x, ends in ((at[:, 0], u), (at[:, 1], v))
    ]
    return np.concatenate(near, axis=1)


def _between(ends: FloatArray, share: FloatArray) -> FloatArray:
    inside: FloatArray = ends[:, 0] + share * (ends[:, 1] - ends[:, 0])
    return np.where(share == 1.0, ends[:, 1], inside)


def _within(pairs: Pairs, reach: float) -> BoolArray:
    """Tell which pairs lie within a reach of the straight line along the first."""
    a, b = places_of(pairs.a), places_of(pairs.b)
    chord = _chords(a)
    every = np.concatenate((a, b), axis=1) - a[:, :1]
    along = np.einsum("kjd,kd->kj", every, chord)
    aside = np.linalg.norm(every - along[..., None] * chord[:, None], axis=2)
    inside: BoolArray = aside.max(axis=1) <= reach
    return inside


def _joined(pairs: Pairs, seam: tuple[float, float] | None, tolerance: float) -> BoolArray:
    """Tell which pairs of one curve are neighbours on it, and it does not jump between them."""
    if seam is None:
        return np.zeros(len(pairs.u), dtype=np.bool)
    a, b = places_of(pairs.a), places_of(pairs.b)
    joined = np.zeros(len(pairs.u), dtype=np.bool)
    around = (pairs.u[:, 0] == seam[0]) & (pairs.v[:, 1] == seam[1])
    for meet_in_u, end, start in (
        (pairs.u[:, 1] == pairs.v[:, 0], a[:, -1], b[:, 0]),
        (around, b[:, -1], a[:, 0]),
    ):
        joined |= meet_in_u & (np.linalg.norm(end - start, axis=1) <= tolerance)
    return joined


def _go_on(pairs: Pairs) -> BoolArray:
    """Tell which pairs together turn so little that they meet where they are joined alone."""
    (one, low), (two, other) = _cones(pairs.a), _cones(pairs.b)
    angle = np.arccos(np.clip((one * two).sum(axis=1), -1.0, 1.0))
    wide = np.arccos(np.clip(low, -1.0, 1.0)), np.arccos(np.clip(other, -1.0, 1.0))
    # a cone around both
    both = 0.5 * (angle + wide[0] + wide[1])
    narrow: BoolArray = np.maximum(both, np.maximum(*wide)) < 0.5 * np.pi * (1.0 - 1e-9)
    return narrow


def _halved(pairs: Pairs) -> Pairs:
    """Give the pairs of halves; of pieces of very different size only the larger is halved."""
    size_a, size_b = (np.ptp(places_of(x), axis=1).max(axis=1) for x in (pairs.a, pairs.b))
    cut = size_a >= 0.5 * size_b
    rest, some = pairs.take(~cut), pairs.take(cut)
    pairs = _put_together(
        rest, *(Pairs(rows, some.b, u, some.v) for rows, u in _sides(some.a, some.u))
    )
    also = size_b >= 0.5 * size_a
    cut = np.concatenate((also[~cut], also[cut], also[cut]))
    rest, some = pairs.take(~cut), pairs.take(cut)
    return _put_together(
        rest, *(Pairs(some.a, rows, some.u, v) for rows, v in _sides(some.b, some.v))
    )


def _sides(rows: FloatArray, ends: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Give both halves of pieces with their first and last parameters."""
    middle = ends.mean(axis=1)
    before, behind = (ends[:, 0], middle), (middle, ends[:, 1])
    return [
        (half, np.stack(side, axis=1))
        for half, side in zip(halves(rows), (before, behind), strict=True)
    ]


def _put_together(*parts: Pairs) -> Pairs:
    return Pairs(*(np.concatenate(x) for x in zip(*parts, strict=True)))


def turns_little(rows: FloatArray) -> BoolArray:
    """Tell which pieces turn so little that they do not meet themselves."""
    narrow: BoolArray = _cones(rows)[1] >= _TURN
    return narrow
