"""Offsets of splines, and of contours of lines, arcs and splines: trimmed, as splines."""

from collections.abc import Iterable, Sequence

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.feature import where_curvature_is
from splinearm.errors import GougeError, OffsetError

from .piece import Piece, SplinePiece
from .spline_check import check_band, check_complete
from .spline_path import track_pieces
from .spline_rough import UnclearError
from .spline_run import Outline, Track
from .spline_source import Source, source_of
from .wire import Wire, curve_of

_BANDS = ((0.02, 0.98), (0.04, 0.96), (0.1, 0.9), (0.02, 0.3), (0.02, 0.1))
"""Shares of the tolerance between which it is fitted, in turn until the check passes.

What is free at the edges is for the bounds; a narrow band is for parts that meet at small angles.
"""
_FINENESS = (0.1, 0.01, 1e-3)
"""Shares of the tolerance within which arcs show how the offset runs."""

_ROUNDING = 1e-10
"""Share of their size by which ends of pieces may differ that are one."""


def offset_spline(curve: BSpline, distance: float, tolerance: float) -> tuple[BSpline, ...]:
    """Give the ways beside a curve on which a cutter of that radius touches it and no more.

    The exact offset is ``r + d n``; parts of it that are nearer to the curve than the distance, in
    loops between cusps or where the curve comes back to itself, are left out. What remains is
    fitted by the fewest cubic pieces, and control points that these do without are taken out. The
    result is never nearer to any of the curve than the distance and lies within the tolerance
    beyond it, which is proven by a bound.

    Args:
        curve: A curve in the plane, polynomial or rational, m; a closed one is offset as such. Of
            one that crosses itself the way often cannot be proven.
        distance: How far, m; above 0 to the left of the curve, below 0 to its right.
        tolerance: How much farther than the distance it may be, m.

    Returns:
        Cubic B-splines with continuous derivatives, in the direction of the curve and in its order;
        of a line or an arc of a circle lines and exact arcs. Where a loop was left out or the curve
        has a corner, one ends and the next begins.

    Raises:
        CurveError: If the curve stands still somewhere.
        OffsetError: If no result passes its check.
        GougeError: If the only result is nearer to the curve than the distance.
        ValueError: If the curve is not in the plane or a number cannot be.
    """
    _check_numbers(distance, tolerance)
    wires = _offset_wires([[SplinePiece(curve)]], distance, tolerance, closed=curve.is_closed())
    return tuple(curve_of(piece) for wire in wires for piece in wire.pieces)


def offset_outline(
    outline: Wire | Sequence[Piece],
    distance: float,
    tolerance: float,
    *,
    islands: Iterable[Wire | Sequence[Piece]] = (),
) -> tuple[Wire, ...]:
    """Give a closed outline of lines, arcs and splines grown or shrunk by a distance.

    Grown: the edge of all points within the distance; shrunk: of all that are farther from the
    outline and inside of it. Loops are trimmed, regions split, join and vanish as they do. Lines
    stay lines and arcs arcs; splines become cubic splines with continuous derivatives; around
    corners go arcs. No point is nearer to the outline than the distance, and all are within the
    tolerance beyond it, which is proven by a bound.

    Args:
        outline: Closed: pieces each of which begins where the one before it ends. Which way it
            runs does not matter.
        distance: How far, m; above 0 grown, below 0 shrunk.
        tolerance: How much farther than the distance the result may be, m.
        islands: Closed outlines inside of it, of what does not belong to it.

    Returns:
        Closed wires. What they enclose lies to the left of them.

    Raises:
        CurveError: If a spline stands still somewhere.
        OffsetError: If an outline crosses itself or another, or no result passes its check.
        GougeError: If the only result is nearer to the outline than the distance.
        ValueError: If an outline is not closed, or a number cannot be.
    """
    _check_numbers(distance, tolerance)
    wires = [_left_of(outline, 1.0)] + [_left_of(island, -1.0) for island in islands]
    if distance == 0.0:
        return tuple(Wire(tuple(wire), closed=True) for wire in wires)
    if distance > 0.0:
        wires = [_reversed(wire) for wire in wires]
    found = _offset_wires(wires, abs(distance), tolerance, closed=True)
    if distance > 0.0:
        found = [Wire(tuple(_reversed(wire.pieces)), closed=True) for wire in found]
    return tuple(found)


def _cusps(source: Source, distance: float) -> list[FloatArray]:
    """Give the places of each chain where its offset to the left turns back."""
    found = []
    for chain in source.chains:
        us = np.empty(0)
        if isinstance(chain.piece, SplinePiece):
            us = where_curvature_is(chain.piece.curve, 1.0 / distance).u
        found.append(chain.places(us))
    return found


def _check_numbers(distance: float, tolerance: float) -> None:
    if not np.isfinite(distance):
        raise ValueError(f"distance: want a finite length, got {distance}")
    if not (tolerance > 0.0 and np.isfinite(tolerance)):
        raise ValueError(f"tolerance: want a length above zero, got {tolerance}")


def _reversed(pieces: Sequence[Piece]) -> list[Piece]:
    return [piece.reversed() for piece in reversed(pieces)]


def _left_of(outline: Wire | Sequence[Piece], side: float) -> list[Piece]:
    """Give the pieces of an outline running to the left (1) or to the right (-1)."""
    pieces = list(outline.pieces if isinstance(outline, Wire) else outline)
    if not pieces:
        raise ValueError("outline: want at least one piece")
    size = max(float(np.abs(piece.middle - piece.start).max()) for piece in pieces)
    for k, piece in enumerate(pieces):
        if np.abs(pieces[k - 1].end - piece.start).max() > _ROUNDING * size:
            raise ValueError(
                f"outline: piece {k} begins at {piece.start.tolist()}, "
                f"and the one before it ends at {pieces[k - 1].end.tolist()}"
            )
    return pieces if side * Wire(tuple(pieces), closed=True).area > 0.0 else _reversed(pieces)


def _offset_wires(
    wires: Sequence[Sequence[Piece]], distance: float, tolerance: float, *, closed: bool
) -> list[Wire]:
    """Give the checked offset, to the left if the distance is above 0."""
    d = abs(distance)
    if d == 0.0:
        return [Wire(tuple(wire), closed=closed) for wire in wires]
    if distance < 0.0:
        wires = [_reversed(wire) for wire in wires]
    source = source_of(wires, d)
    failure: OffsetError | GougeError | None = None
    for shares in _BANDS:
        for fineness in _FINENESS:
            try:
                found = _attempt(source, (d, tolerance), shares, fineness, closed=closed)
            except UnclearError as error:
                x, y = source.placed(np.asarray(error.where)).tolist()
                failure = failure or OffsetError(distance, error.what, (x, y))
            except (OffsetError, GougeError) as error:
                failure = error
            else:
                if distance > 0.0:
                    return found
                return [Wire(tuple(_reversed(w.pieces)), w.closed) for w in reversed(found)]
    raise failure or OffsetError(distance, "not tried", (0.0, 0.0))


def _attempt(
    source: Source,
    wanted: tuple[float, float],
    shares: tuple[float, float],
    fineness: float,
    *,
    closed: bool,
) -> list[Wire]:
    """Give the offset to the left by a distance and within a tolerance, if it passes its check."""
    d, tolerance = wanted
    near, far = (d + share * tolerance for share in shares)
    band = near / source.unit, far / source.unit
    outline = Outline(source, band, _cusps(source, 0.5 * (near + far)), closed=closed)
    tracks = outline.tracks(fineness * tolerance / source.unit)
    try:
        return _checked(source, tracks, wanted, band, thin=True)
    except (OffsetError, GougeError):
        return _checked(source, tracks, wanted, band, thin=False)


def _checked(
    source: Source,
    tracks: Sequence[Track],
    wanted: tuple[float, float],
    band: tuple[float, float],
    *,
    thin: bool,
) -> list[Wire]:
    """Give tracks as wires, if they pass their check."""
    found = [
        Wire(tuple(track_pieces(source, track, band, free_ends=True, thin=thin)), track.closed)
        for track in tracks
    ]
    pieces = [piece for wire in found for piece in wire.pieces]
    check_band(source, pieces, *wanted)
    check_complete(source, pieces, *wanted)
    return found
