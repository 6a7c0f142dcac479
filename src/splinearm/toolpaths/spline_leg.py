"""Ways with splines, and the arcs beside them along which lengths are counted and ramps go."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.errors import ToolpathError

from .contour import Contour
from .piece import ArcPiece, LinePiece, Piece, SplinePiece
from .spline_source import source_of
from .stretch import place_on, stretch

BESIDE = 0.01
"""Share of the tolerance of a way within which arcs are beside its splines."""
_TINY = 1e-9
"""Share of its length below which nothing is left of a piece."""
_SLIVER = 1e-3
"""Ways are not begun nearer to where two pieces meet than this share of one, but there."""
_ROUNDS = 4
"""Steps of Newton's method from about the place of a spline."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A piece of a way, and lines and arcs beside it."""

    piece: Piece
    """The piece."""
    path: Contour
    """The lines and arcs, open, from its start to its end."""
    us: FloatArray
    """Parameters of the spline at the corners of these; of others nothing."""

    def between(self, begin: float, end: float) -> tuple[Piece, ...]:
        """Give the part between two places, by the length along the path, m."""
        if not isinstance(self.piece, SplinePiece):
            return stretch(self.path, begin, end).pieces()
        curve = self.piece.curve
        u, v = (self._beside(curve, along) for along in (begin, end))
        return (SplinePiece(curve.part(u, v)),)

    def _beside(self, curve: BSpline, along: float) -> float:
        """Give the parameter of a spline beside a place on the path."""
        marks = np.concatenate(([0.0], np.cumsum(self.path.lengths)))
        first, last = curve.domain
        u = float(np.interp(along, marks, self.us))
        place, _ = place_on(self.path, min(max(along, 0.0), float(marks[-1])))
        for _ in range(_ROUNDS):
            at, way = curve.jet(u, 1)
            u = min(max(u + float((place - at) @ way / (way @ way)), first), last)
        return u


def legs_of(pieces: Sequence[Piece], tolerance: float) -> tuple[Leg, ...]:
    """Give pieces with arcs beside their splines, which stray from these by no more than that, m.

    Raises:
        ToolpathError: If a spline takes too many arcs.
    """
    return tuple(
        _beside(piece, tolerance)
        if isinstance(piece, SplinePiece)
        else Leg(piece, Contour.of_pieces([piece], closed=False), np.empty(0))
        for piece in pieces
    )


def path_of(legs: Sequence[Leg]) -> Contour:
    """Give the lines and arcs beside legs one after the other, open."""
    corners = [leg.path.vertices[:-1] for leg in legs]
    vertices = np.concatenate((*corners, legs[-1].path.vertices[-1:]))
    return Contour.made(vertices, np.concatenate([leg.path.bulges for leg in legs]), closed=False)


def pieces_between(legs: Sequence[Leg], begin: float, end: float) -> tuple[Piece, ...]:
    """Give the pieces from one place to another, by the length along the path, m.

    Splines are cut exactly.
    """
    found: list[Piece] = []
    at = 0.0
    for leg in legs:
        size = leg.path.length
        first, last = max(0.0, begin - at), min(size, end - at)
        if last - first > _TINY * size:
            whole = first <= _TINY * size and last >= (1.0 - _TINY) * size
            found += [leg.piece] if whole else leg.between(first, last)
        at += size
    return tuple(found)


def begun_legs(legs: Sequence[Leg], along: float, tolerance: float) -> tuple[Leg, ...]:
    """Give legs that go around begun elsewhere; splines are cut exactly.

    Args:
        legs: The legs, of which the last ends where the first begins.
        along: Where they shall begin, by the length along their path, m; not exactly, where two
            pieces meet nearby.
        tolerance: How far the arcs beside what is cut may be from it, m.
    """
    ends = np.cumsum([leg.path.length for leg in legs])
    k = min(int(np.searchsorted(ends, along)), len(legs) - 1)
    leg, size = legs[k], legs[k].path.length
    share = 1.0 - (float(ends[k]) - along) / size
    if not _SLIVER < share < 1.0 - _SLIVER:
        k += share > _SLIVER
        return (*legs[k:], *legs[:k])
    before, behind = _cut(leg, share * size)
    return (*legs_of(behind, tolerance), *legs[k + 1 :], *legs[:k], *legs_of(before, tolerance))


def _cut(leg: Leg, along: float) -> tuple[list[Piece], list[Piece]]:
    """Give what is before and what is behind a place of a leg, by the length along its path, m."""
    before, behind = list(leg.between(0.0, along)), list(leg.between(along, leg.path.length))
    spot = before[-1].end
    before[0] = _from_to(before[0], leg.piece.start, before[0].end)
    behind[0] = _from_to(behind[0], spot, behind[0].end)
    behind[-1] = _from_to(behind[-1], behind[-1].start, leg.piece.end)
    return before, behind


def _from_to(piece: Piece, start: FloatArray, end: FloatArray) -> Piece:
    """Give a piece with exactly these ends."""
    same = (piece.start == start).all() and (piece.end == end).all()
    return piece if same else piece.between(start, end)


def begun_well(pieces: Sequence[Piece]) -> list[Piece]:
    """Give closed pieces begun in the middle of their longest line, else of their longest piece.

    One spline that goes all the way round begins where it does.
    """
    if len(pieces) == 1 and isinstance(pieces[0], SplinePiece):
        return list(pieces)
    lines = [k for k, piece in enumerate(pieces) if isinstance(piece, LinePiece)]
    k = max(lines or range(len(pieces)), key=lambda i: pieces[i].length)
    first, last = _halves(pieces[k])
    return [last, *pieces[k + 1 :], *pieces[:k], first]


def _halves(piece: Piece) -> tuple[Piece, Piece]:
    middle = piece.middle
    match piece:
        case LinePiece():
            return LinePiece(piece.start, middle), LinePiece(middle, piece.end)
        case ArcPiece():
            half = 0.5 * piece.turn
            ends = (piece.start, middle), (middle, piece.end)
            first, last = (
                ArcPiece(start=a, end=b, centre=piece.centre, turn=half) for a, b in ends
            )
            return first, last
        case _:
            curves = piece.curve.split(float(np.mean(piece.curve.domain)))
            before, behind = (SplinePiece(curve) for curve in curves)
            return before, behind.between(before.end, piece.end)


def _beside(piece: SplinePiece, tolerance: float) -> Leg:
    """Give a spline with arcs beside it."""
    from .biarc_kernel import arcs_along

    source = source_of([[piece]], 0.0)
    exact = source.chains[0].piece
    if not isinstance(exact, SplinePiece):
        return Leg(exact, Contour.of_pieces([exact], closed=False), np.empty(0))
    limits = 0.0, float(len(source.segments))
    arcs = arcs_along(source.segments, limits, limits, tolerance / source.unit)
    if not len(arcs):
        raise ToolpathError(
            f"a spline that begins at {piece.start.tolist()} takes too many arcs for a "
            f"tolerance of {tolerance * 1e3:.3g} mm"
        )
    vertices = np.concatenate((source.placed(arcs[:, :2]), piece.end[None]))
    vertices[0] = piece.start
    places = np.append(arcs[:, 3], limits[1])
    breaks = piece.curve.breaks
    k = np.minimum(places.astype(int), len(breaks) - 2)
    us = breaks[k] + (places - k) * (breaks[k + 1] - breaks[k])
    return Leg(piece, Contour.made(vertices, np.array(arcs[:, 2]), closed=False), us)
