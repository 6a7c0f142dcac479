"""Splines and their offsets as lines and arcs, for controllers without splines."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.errors import ToolpathError

from .contour import Contour
from .offset import offset
from .piece import ArcPiece, LinePiece, Piece, SplinePiece
from .region import Region
from .spline_check import check_band
from .spline_source import Chain, Source, source_of
from .wire import Wire

_STRAIGHT = 1e-12
"""A bulge below this is a line: the arc over a chord is higher by less than half of this share."""


def curve_arcs(curve: BSpline, tolerance: float) -> Wire:
    """Give a curve as lines and arcs that go over into each other without corners.

    They are pairs of arcs (biarcs), each as long as the tolerance allows, which have place and
    direction in common with the curve where pairs meet. Nowhere is the curve farther from them
    than the tolerance, nor are they from it; that is proven by a bound.

    Args:
        curve: A curve in the plane, m.
        tolerance: How far from it, m.

    Raises:
        CurveError: If the curve stands still somewhere.
        ToolpathError: If it cannot be done with a number of arcs that can be.
        ValueError: If the curve is not in the plane or the tolerance not above 0.
    """
    return outline_arcs([SplinePiece(curve)], tolerance)


def outline_arcs(outline: Wire | Sequence[Piece], tolerance: float) -> Wire:
    """Give pieces with their splines as lines and arcs; see ``curve_arcs``.

    Args:
        outline: Pieces, each of which begins where the one before it ends. Lines and arcs stay.
        tolerance: How far from the splines, m.

    Raises:
        CurveError: If a spline stands still somewhere.
        ToolpathError: If it cannot be done with a number of arcs that can be.
        ValueError: If the tolerance is not above 0.
    """
    if not (tolerance > 0.0 and np.isfinite(tolerance)):
        raise ValueError(f"tolerance: want a length above zero, got {tolerance}")
    pieces = list(outline.pieces if isinstance(outline, Wire) else outline)
    if not pieces:
        raise ValueError("outline: want at least one piece")
    source = source_of([pieces], 0.0)
    found: list[Piece] = []
    for chain in source.chains:
        found += _arcs(source, chain, tolerance)
    size = source.unit * 1e-10
    closed = bool(np.abs(found[-1].end - found[0].start).max() <= size)
    if closed and len(found) > 1:
        found[-1] = found[-1].between(found[-1].start, found[0].start)
    return Wire(tuple(found), closed)


def offset_outline_arcs(
    outline: Wire | Sequence[Piece],
    distance: float,
    tolerance: float,
    *,
    islands: Iterable[Wire | Sequence[Piece]] = (),
) -> tuple[Region, ...]:
    """Give a closed outline of lines, arcs and splines grown or shrunk, as lines and arcs.

    Half of the tolerance goes into arcs in place of the splines, and these are offset exactly by
    the other half more: no point is nearer to the outline than the distance, and all are within the
    tolerance beyond it. That is proven by a bound once more from the result.

    Args:
        outline: Closed, as for ``offset_outline``.
        distance: How far, m; above 0 grown, below 0 shrunk.
        tolerance: How much farther than the distance the result may be, m.
        islands: Closed outlines inside of it, of what does not belong to it.

    Raises:
        ContourError: If an outline crosses itself.
        CurveError: If a spline stands still somewhere.
        GougeError: If the only result is nearer to the outline than the distance.
        OffsetError: If no result passes its check.
        ToolpathError: If it cannot be done with a number of arcs that can be.
        ValueError: If an outline is not closed, or a number cannot be.
    """
    outlines = [outline, *islands]
    wires = [outline_arcs(one, 0.49 * tolerance) for one in outlines]
    for wire in wires:
        if not wire.closed:
            raise ValueError("outline: want it closed")
    contours = [_contour(wire) for wire in wires]
    d = abs(distance) + 0.5 * tolerance
    found = offset(Region(contours[0], tuple(contours[1:])), d if distance > 0.0 else -d)
    given = [one.pieces if isinstance(one, Wire) else one for one in outlines]
    pieces = [p for region in found for contour in region.contours for p in contour.pieces()]
    check_band(source_of(given, d), pieces, abs(distance), tolerance)
    return found


def _contour(wire: Wire) -> Contour:
    return Contour.of_pieces(
        [p for p in wire.pieces if not isinstance(p, SplinePiece)], closed=True
    )


def _arcs(source: Source, chain: Chain, tolerance: float) -> list[LinePiece | ArcPiece]:
    """Give a chain as lines and arcs."""
    from .biarc_kernel import arcs_along

    piece = chain.piece
    if not isinstance(piece, SplinePiece):
        return [piece]
    limits = float(chain.first), float(chain.end)
    arcs = arcs_along(source.segments, limits, limits, tolerance / source.unit)
    if not len(arcs):
        raise ToolpathError(
            f"a spline that begins at {piece.start.tolist()} takes too many arcs for a "
            f"tolerance of {tolerance * 1e3:.3g} mm"
        )
    places = np.concatenate((source.placed(arcs[:, :2]), piece.end[None]))
    places[0] = piece.start
    return [
        _arc(a, b, bulge)
        for (a, b), bulge in zip(pairwise(places), arcs[:, 2].tolist(), strict=True)
    ]


def _arc(start: FloatArray, end: FloatArray, bulge: float) -> LinePiece | ArcPiece:
    if abs(bulge) < _STRAIGHT:
        return LinePiece(start, end)
    return ArcPiece.bulging(start, end, bulge)
