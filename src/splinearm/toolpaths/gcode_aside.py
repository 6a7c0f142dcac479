"""A contour with its ways in and out moved aside by the radius of a tool.

What a program runs through with G41 or G42 is often a closed contour and, besides, short ways on
which the tool comes to it and leaves it. Those are no part of the workpiece: they are moved aside
each by itself, and must only stay clear of it.
"""

from itertools import pairwise
from math import hypot

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GougeError

from .contour import Contour
from .offset import offset_path
from .piece import ArcPiece, LinePiece

_Piece = LinePiece | ArcPiece
_SAME = 1e-9
_NEAR = 1e-6
_LOOKS = 257


def moved_aside(path: Contour, distance: float) -> Contour:
    """Give the way of a tool beside an open path.

    Args:
        path: The path, with ways in and out if it closes in between.
        distance: How far, m; above 0 to the left, below 0 to the right.

    Raises:
        GougeError: If the tool does not fit along it or cuts it on its ways in and out.
    """
    lead_in, loop, lead_out = _closed_part(path)
    if loop is None:
        return _only(offset_path(path, distance), path, distance)
    beside = _only(offset_path(loop, distance), loop, distance)
    corner = loop.vertices[0]
    first, last = loop.pieces()[0], loop.pieces()[-1]
    begin, end = (
        corner + distance * _left(piece, at_end=at_end)
        for piece, at_end in ((first, False), (last, True))
    )
    pieces = _opened(beside, begin, end, corner)
    ahead = [_aside(piece, distance) for piece in lead_in]
    behind = [_aside(piece, distance) for piece in lead_out]
    chain = [*ahead, *pieces, *behind]
    joined = _joined(chain)
    _require_clear([*ahead, *behind], loop, abs(distance))
    return Contour.of_pieces(joined, closed=False)


def _only(found: tuple[Contour, ...], path: Contour, distance: float) -> Contour:
    if len(found) == 1:
        return found[0]
    x, y = (found[0].vertices[-1] if found else path.vertices[0]).tolist()
    remedy = "the tool does not fit along the whole contour; take a smaller one"
    raise GougeError((x, y), abs(distance), remedy)


def _closed_part(path: Contour) -> tuple[list[_Piece], Contour | None, list[_Piece]]:
    """Give the pieces before the closed part of a path, that, and the pieces behind it."""
    pieces = list(path.pieces())
    places = [pieces[0].start, *(piece.end for piece in pieces)]
    for i in range(len(places)):
        for j in range(len(places) - 1, i + 1, -1):
            if hypot(*(places[i] - places[j])) <= _SAME:
                loop = Contour.of_pieces(pieces[i:j], closed=True)
                return pieces[:i], loop, pieces[j:]
    crossing = _crossing(pieces[0], pieces[-1]) if len(pieces) > 2 else None
    if crossing is None:
        return [], None, []
    first, last = pieces[0], pieces[-1]
    inner = [LinePiece(crossing, first.end), *pieces[1:-1], LinePiece(last.start, crossing)]
    ahead, behind = LinePiece(first.start, crossing), LinePiece(crossing, last.end)
    return [ahead], Contour.of_pieces(inner, closed=True), [behind]


def _crossing(first: _Piece, last: _Piece) -> FloatArray | None:
    """Give where two lines cross, if they do."""
    if not (isinstance(first, LinePiece) and isinstance(last, LinePiece)):
        return None
    a, b = first.end - first.start, last.end - last.start
    size = float(a[0] * b[1] - a[1] * b[0])
    if abs(size) <= 1e-12 * hypot(*a) * hypot(*b):
        return None
    way = last.start - first.start
    t = float(way[0] * b[1] - way[1] * b[0]) / size
    u = float(way[0] * a[1] - way[1] * a[0]) / size
    inside = 0.0 < t < 1.0 and 0.0 < u < 1.0
    place: FloatArray = first.start + t * a
    return place if inside else None


def _left(piece: _Piece, *, at_end: bool) -> FloatArray:
    """Give the unit vector to the left of a piece at one of its ends."""
    if isinstance(piece, LinePiece):
        way = piece.end - piece.start
        return np.array([-way[1], way[0]]) / hypot(*way)
    arm = (piece.end if at_end else piece.start) - piece.centre
    inward: FloatArray = -arm / hypot(*arm)
    return inward if piece.turn > 0.0 else -inward


def _aside(piece: _Piece, distance: float) -> _Piece:
    """Give a piece moved aside by itself."""
    start = piece.start + distance * _left(piece, at_end=False)
    end = piece.end + distance * _left(piece, at_end=True)
    if isinstance(piece, LinePiece):
        return LinePiece(start, end)
    inward = distance if piece.turn > 0.0 else -distance
    if inward >= piece.radius * (1.0 - _NEAR):
        x, y = piece.middle.tolist()
        remedy = f"make that arc larger than the tool ({abs(distance) * 1e3:g} mm)"
        raise GougeError((x, y), inward - piece.radius, remedy)
    return ArcPiece(start=start, end=end, centre=piece.centre, turn=piece.turn)


def _opened(
    beside: Contour, begin: FloatArray, end: FloatArray, corner: FloatArray
) -> list[_Piece]:
    """Give the closed way of a tool from where it begins beside the corner to where it ends."""
    reach = hypot(*(begin - corner))
    gaps = np.hypot(*(beside.vertices - begin).T)
    vertex = int(np.argmin(gaps))
    if gaps[vertex] > _NEAR * reach:  # an inner corner: begin where both sides meet
        vertex = int(np.argmin(np.hypot(*(beside.vertices - corner).T)))
        return list(beside.starting_at(vertex).pieces())
    pieces = list(beside.starting_at(vertex).pieces())
    around = pieces[-1]
    if hypot(*(begin - end)) > _NEAR * reach and hypot(*(around.start - end)) <= _NEAR * reach:
        pieces.pop()  # the arc around the corner, which no way in or out goes along
    return pieces


def _joined(pieces: list[_Piece]) -> list[_Piece]:
    """Join pieces whose ends differ by rounding; lines close what gapes."""
    joined = [pieces[0]]
    for after in pieces[1:]:
        before = joined[-1]
        gap = hypot(*(after.start - before.end))
        if gap > _NEAR:
            joined.append(LinePiece(before.end, after.start))
            joined.append(after)
        else:
            joined.append(after.between(before.end, after.end) if gap > 0.0 else after)
            _merge_last_lines(joined)
    return joined


def _merge_last_lines(pieces: list[_Piece]) -> None:
    """Make one line of the last two pieces if they are lines that go straight on."""
    before, after = pieces[-2:]
    if isinstance(before, LinePiece) and isinstance(after, LinePiece):
        a, b = before.end - before.start, after.end - after.start
        bend, along = float(a[0] * b[1] - a[1] * b[0]), float(a @ b)
        if along > 0.0 and abs(bend) <= _SAME * along:
            pieces[-2:] = [LinePiece(before.start, after.end)]


def _require_clear(pieces: list[_Piece], loop: Contour, radius: float) -> None:
    """Refuse ways in and out on which the tool cuts the contour."""
    for piece in pieces:
        places = Contour.of_pieces([piece], closed=False).flattened(1e-3 * radius)
        steps = np.linspace(0.0, 1.0, _LOOKS)[:, None]
        dense = np.vstack([a + steps * (b - a) for a, b in pairwise(places)])
        gaps = loop.distance(dense) - radius
        worst = int(np.argmin(gaps))
        if gaps[worst] < -2e-3 * radius:
            x, y = dense[worst].tolist()
            remedy = "come to the contour, and leave it, on the side of the tool"
            raise GougeError((x, y), float(-gaps[worst]), remedy)
