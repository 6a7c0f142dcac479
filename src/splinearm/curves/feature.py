"""Places where something happens on a curve: cusps, inflections, extrema of curvature.

They are roots of polynomials on the Bezier pieces, found by ``find_roots``, which misses none.
"""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import bernstein
from .basis import IndexArray
from .bernstein import EPS, Bounded
from .bspline import BSpline
from .root import BoolArray, Roots, find_roots
from .velocity import velocity_of

_ASIDE = 1e-9
"""How far beside a root, as a share of the piece, its sign before and behind is looked at."""

_JUMP = 1e-9
"""Curvatures that differ by less than this share where pieces meet are the same."""


class Places(NamedTuple):
    """Where something holds on a curve."""

    u: FloatArray
    """Single places, in order, shape (k,)."""
    stretches: FloatArray
    """Pieces on which it holds everywhere, from and to, shape (j, 2)."""


class _Terms(NamedTuple):
    """What curvature is made of: |N| w^2 / |V|^3 in the scale of each piece."""

    ends: FloatArray
    V: list[Bounded]
    w: Bounded
    N: list[Bounded]
    """V x V', one number in the plane, else the coordinates in space."""
    D: Bounded
    """V . V"""
    scale: FloatArray
    """Curvature here is that of the curve times this, shape (k,)."""
    closed: bool
    """Whether the last piece meets the first one, in place and direction."""


def cusps(curve: BSpline) -> Places:
    """Give where a curve stands still for a moment, and pieces on which it does not move at all.

    A place counts where the velocity is 0 within 1e-12 of its largest on the piece.

    Raises:
        ValueError: If the degree is 0.
    """
    if curve.degree == 0:
        raise ValueError("curve: want degree 1 or more, got 0")
    velocity = velocity_of(curve)
    size, _ = _sizes(velocity.V)
    parts = [
        Bounded(velocity.V[:, :, d] / size[:, None], velocity.error / size)
        for d in range(curve.dim)
    ]
    return _places(velocity.ends, find_roots(*parts))


def inflections(curve: BSpline) -> Places:
    """Give where a curve changes the side to which it turns, in space where it has no curvature.

    In the plane the curvature changes its sign there, through 0 or in a jump where pieces meet.
    Straight pieces are given as stretches. An end of the curve counts if its curvature is 0; a
    closed curve has no end, only a seam, which is given as its start.

    Raises:
        ValueError: If the curve is not one of degree 1 or more with two or three coordinates.
    """
    terms = _terms(curve)
    if curve.dim == 3:
        return _places(terms.ends, _but_cusps(find_roots(*terms.N), terms))
    return _changes(terms, terms.N[0], np.zeros(len(terms.scale)))


def curvature_extrema(curve: BSpline) -> Places:
    """Give where the curvature (in the plane with its sign) is at a maximum or minimum.

    Where pieces meet, a place counts if the curvature rises before and falls behind it, or jumps
    against the way it went. Pieces of constant curvature are given as stretches. An end of the
    curve counts if the curvature is level there; a closed curve has no end, only a seam, which is
    given as its start.

    Raises:
        ValueError: If the curve is not one of degree 1 or more with two or three coordinates.
    """
    terms = _terms(curve)
    w, D = terms.w, terms.D
    if curve.dim == 2:
        N = terms.N[0]
        # (N w^2 D^(-3/2))' = w D^(-5/2) ((N' w + 2 N w') D - 3/2 N w D')
        slope = (N.derivative() * w + (N * w.derivative()).times(2.0)) * D
        slope = slope - (N * w * D.derivative()).times(1.5)
    else:
        Q = _dot(terms.N)
        # of the square Q w^4 / D^3, whose derivative is w^3 / D^4 times
        slope = (Q.derivative() * w + (Q * w.derivative()).times(4.0)) * D
        slope = slope - (Q * w * D.derivative()).times(3.0)
    return _changes(terms, slope, _jumps(terms))


def where_curvature_is(curve: BSpline, value: float) -> Places:
    """Give where the curvature has a value, 1/m; in the plane positive means a turn to the left.

    A place where pieces meet counts if the curvature jumps past the value.

    Args:
        curve: The curve.
        value: The curvature; in space not below 0.

    Raises:
        ValueError: If the curve is not one of degree 1 or more with two or three coordinates, or
            the value is not finite.
    """
    terms = _terms(curve)
    if not np.isfinite(value) or (curve.dim == 3 and value < 0.0):
        raise ValueError(f"value: want a curvature that can be, got {value}")
    if value == 0.0 and curve.dim == 2:
        found, sides = find_roots(terms.N[0]), terms.N[0]
        return _places(terms.ends, _but_cusps(found, terms), _crossed(sides, terms))
    fourth = terms.w * terms.w
    fourth = fourth * fourth
    wanted = (terms.D * terms.D * terms.D).times((value * terms.scale) ** 2)
    f = _dot(terms.N) * fourth - wanted
    found = find_roots(f)
    if curve.dim == 3:
        return _places(terms.ends, _but_cusps(found, terms), _crossed(f, terms))
    # the square has roots for both signs of the curvature
    sign = 1.0 if value > 0.0 else -1.0
    N = terms.N[0].times(sign)
    right = bernstein.values(N.c[found.piece], found.t) > 0.0
    whole = bernstein.values(N.c[found.everywhere], np.full(len(found.everywhere), 0.5)) > 0.0
    kept = Roots(found.piece[right], found.low[right], found.high[right], found.everywhere[whole])
    # below the value is also what turns to the other side
    ends = np.where(N.c[:, [0, -1]] > N.error[:, None], f.c[:, [0, -1]], -np.inf)
    sides = Bounded(ends, f.error)
    return _places(terms.ends, _but_cusps(kept, terms), _crossed(sides, terms))


def _terms(curve: BSpline) -> _Terms:
    if curve.degree == 0 or curve.dim not in (2, 3):
        raise ValueError(
            f"curve: want degree 1 or more and 2 or 3 coordinates, got {curve.degree} and "
            f"{curve.dim}"
        )
    velocity = velocity_of(curve)
    size, still = _sizes(velocity.V)
    if still.all():
        raise CurveError("all of it is one point: it has no curvature", "feature")
    weight = velocity.W.max(axis=1)
    V = [
        Bounded(velocity.V[:, :, d] / size[:, None], velocity.error / size)
        for d in range(curve.dim)
    ]
    degree = velocity.W.shape[1]
    w = Bounded(velocity.W / weight[:, None], np.full(len(weight), 4.0 * degree * EPS))
    A = [part.derivative() for part in V]
    if curve.dim == 2:
        N = [V[0] * A[1] - V[1] * A[0]]
    else:
        N = [V[i] * A[j] - V[j] * A[i] for i, j in ((1, 2), (2, 0), (0, 1))]
    way = velocity.V[0, 0], velocity.V[-1, -1]
    lengths = [float(np.linalg.norm(v)) for v in way]
    closed = curve.is_closed() and way[0] @ way[1] > (1.0 - _JUMP) * lengths[0] * lengths[1]
    return _Terms(velocity.ends, V, w, N, _dot(V), size / weight**2, bool(closed))


def _sizes(V: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Give the largest number of each piece, 1 where all are 0, and where that is so."""
    size = np.abs(V).max(axis=(1, 2))
    still = size == 0.0
    return np.where(still, 1.0, size), still


def _dot(parts: list[Bounded]) -> Bounded:
    total = parts[0] * parts[0]
    for part in parts[1:]:
        total = total + part * part
    return total


def _but_cusps(roots: Roots, terms: _Terms) -> Roots:
    """Give the roots but for those that are cusps, where curvature is not defined."""
    halts = find_roots(*terms.V)
    kept = np.ones(len(roots.piece), dtype=np.bool)
    for piece, t in zip(halts.piece, halts.t, strict=True):
        at = (roots.low - _ASIDE <= t) & (t <= roots.high + _ASIDE)
        kept &= ~((roots.piece == piece) & at)
    whole = np.setdiff1d(roots.everywhere, halts.everywhere)
    return Roots(roots.piece[kept], roots.low[kept], roots.high[kept], whole)


def _changes(terms: _Terms, f: Bounded, jumps: FloatArray) -> Places:
    """Give where f changes its sign, or where pieces meet and f and the jump there differ."""
    roots = _but_cusps(find_roots(f), terms)
    aside = _ASIDE + 2.0 * (roots.high - roots.low)
    before, behind = roots.low - aside, roots.high + aside
    inner = (before > 0.0) & (behind < 1.0)
    left = _signs(f, roots.piece, np.clip(before, 0.0, 1.0))
    right = _signs(f, roots.piece, np.clip(behind, 0.0, 1.0))
    count = len(f.c)
    at_end = ((before <= 0.0) & (roots.piece == 0)) | ((behind >= 1.0) & (roots.piece == count - 1))
    kept = (inner & (left * right <= 0.0)) | (at_end & (not terms.closed))
    found = Roots(roots.piece[kept], roots.low[kept], roots.high[kept], roots.everywhere)
    # where pieces meet: what f is just before and behind, if it is 0 there itself
    pieces = np.arange(count)
    first = _signs(f, pieces, np.full(count, 0.0))
    last = _signs(f, pieces, np.full(count, 1.0))
    for touched, signs, place in ((before <= 0.0, first, behind), (behind >= 1.0, last, before)):
        signs[roots.piece[touched]] = _signs(f, roots.piece[touched], np.clip(place[touched], 0, 1))
    triple = np.stack((last, jumps, np.roll(first, -1)))
    crossed = (triple.max(axis=0) > 0.0) & (triple.min(axis=0) < 0.0)
    return _places(terms.ends, found, _joints(crossed, terms))


def _signs(f: Bounded, piece: IndexArray, t: FloatArray) -> FloatArray:
    """Give the signs of f at places, 0 where rounding hides them."""
    value = bernstein.values(f.c[piece], t)
    return np.where(np.abs(value) > f.error[piece], np.sign(value), 0.0)


def _crossed(sides: Bounded, terms: _Terms) -> IndexArray:
    """Give the pieces at whose start the sign is not that of the end of the piece before."""
    sign = np.where(np.abs(sides.c) > sides.error[:, None], np.sign(sides.c), 0.0)
    return _joints(sign[:, -1] * np.roll(sign[:, 0], -1) < 0.0, terms)


def _joints(at_end: BoolArray, terms: _Terms) -> IndexArray:
    """Give the pieces behind those at whose end something is so, of a closed curve around."""
    behind = np.flatnonzero(at_end) + 1
    return behind % len(at_end) if terms.closed else behind[behind < len(at_end)]


def _jumps(terms: _Terms) -> FloatArray:
    """Give the sign of the jump of curvature from the end of each piece to the next, around."""
    size = np.sqrt(np.maximum(_dot(terms.N).c, 0.0)) if len(terms.N) > 1 else terms.N[0].c
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = [
            size[:, i] * terms.w.c[:, i] ** 2 / terms.D.c[:, i] ** 1.5 / terms.scale
            for i in (0, -1)
        ]
    before, behind = bend[1], np.roll(bend[0], -1)
    jump = behind - before
    scale = np.maximum(np.abs(before), np.abs(behind))
    # not a number at a cusp between pieces
    return np.where(np.abs(jump) > _JUMP * scale, np.sign(jump), 0.0)


def _places(ends: FloatArray, roots: Roots, joints: IndexArray | None = None) -> Places:
    """Give places by the curve's parameter: one where two pieces meet in it."""
    width = np.diff(ends)
    at = ends[roots.piece] + roots.t * width[roots.piece]
    slack = (roots.high - roots.low + 4.0 * EPS) * width[roots.piece]
    if joints is not None:
        at = np.append(at, ends[joints])
        slack = np.append(slack, np.zeros(len(joints)))
    order = np.argsort(at, kind="stable")
    u: list[float] = []
    widest = 0.0
    for value, room in zip(at[order], slack[order], strict=True):
        if u and value - u[-1] <= max(widest, room) + 1e-13 * (ends[-1] - ends[0]):
            widest = max(widest, room)
            continue
        u.append(float(value))
        widest = room
    stretches = np.stack((ends[roots.everywhere], ends[roots.everywhere + 1]), axis=1)
    return Places(np.array(u), stretches)
