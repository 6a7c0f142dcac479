"""What closed wires of a drawing enclose: outlines with the openings that lie in them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ContourError

from .biarc import outline_arcs
from .contour import Contour, joined
from .piece import ArcPiece, SplinePiece, is_full_circle
from .region import Region
from .stretch import amid_longest
from .wire import Wire

_TINY = 1e-10
"""Segments that meet nearer to their ends than this share of the size do not cross there."""
_SHARE = 0.49
"""Share of the tolerance that goes into arcs in place of splines; ways keep off by the rest."""


@dataclass(frozen=True, slots=True, eq=False)
class Nested:
    """Regions of a drawing."""

    regions: tuple[Region, ...]
    """What outlines enclose, without their openings; what lies in an opening is one of its own."""
    wires: tuple[tuple[Wire, ...], ...]
    """Of each region the wires that it was made of: its outline, then its openings."""
    slack: float
    """How far the drawing's splines may be beside the regions' arcs, m; 0: there are none."""


def nested(wires: Sequence[Wire], tolerance: float) -> Nested:
    """Give the regions that closed wires enclose, by how they lie in each other.

    Splines become arcs within half of the tolerance. Ways that keep off by the slack besides are
    never nearer to the splines than they should be, and at most the tolerance farther.

    Args:
        wires: Closed wires, in any direction and order.
        tolerance: How far ways may be beside what they should be because of splines, m.

    Raises:
        ContourError: With the place, if two wires cross or one crosses itself.
        ToolpathError: If a spline cannot be done.
        ValueError: If a wire is open or there is none.
    """
    if not wires:
        raise ValueError("wires: want at least one")
    if not all(wire.closed for wire in wires):
        raise ValueError("wires: want them closed; an open one encloses nothing")
    contours = [contour_of(wire, tolerance) for wire in wires]
    _require_apart(contours)
    curved = any(isinstance(piece, SplinePiece) for wire in wires for piece in wire.pieces)
    found = _members(contours)
    regions = tuple(_region([contours[i] for i in one]) for one in found)
    made_of = tuple(tuple(wires[i] for i in one) for one in found)
    return Nested(regions, made_of, 0.5 * tolerance if curved else 0.0)


def contour_of(wire: Wire, tolerance: float) -> Contour:
    """Give a wire as lines and arcs, splines within half of a tolerance."""
    if any(isinstance(piece, SplinePiece) for piece in wire.pieces):
        wire = outline_arcs(wire, _SHARE * tolerance)
    pieces = [piece for piece in wire.pieces if not isinstance(piece, SplinePiece)]
    return Contour.of_pieces(pieces, closed=wire.closed)


def circles(wires: Sequence[Wire]) -> tuple[FloatArray, FloatArray]:
    """Give middles, shape (k, 2), and diameters, shape (k,), of the wires that are circles, m."""
    found: list[tuple[FloatArray, float]] = []
    for wire in wires:
        arcs = [piece for piece in wire.pieces if isinstance(piece, ArcPiece)]
        if not wire.closed or len(arcs) != len(wire.pieces):
            continue
        first = arcs[0]
        one = is_full_circle(first) or all(
            float(np.abs(arc.centre - first.centre).max()) <= 1e-9 * first.radius
            and abs(arc.radius - first.radius) <= 1e-9 * first.radius
            for arc in arcs
        )
        if one:
            found.append((first.centre, 2.0 * first.radius))
    middles = np.array([middle for middle, _ in found]).reshape(-1, 2)
    return middles, np.array([diameter for _, diameter in found])


def _require_apart(contours: Sequence[Contour]) -> None:
    """Refuse contours that cross."""
    from .contour_along_kernel import first_crossing_along
    from .contour_kernel import first_crossing
    from .offset_kernel import pieces_of

    vertices, bulges, starts = joined(contours)
    size = float(np.ptp(vertices, axis=0).max())
    P, segment, loops = pieces_of(vertices, bulges, starts, 0.0)
    i, j, x, y = first_crossing(P, loops, _TINY * size)
    if i < 0:
        i, j, x, y = first_crossing_along(P, loops, _TINY * size)
    if i < 0:
        return
    marks = list(pairwise(starts.tolist()))
    one, two = (next(n for n, (a, b) in enumerate(marks) if a <= segment[k] < b) for k in (i, j))
    what = (
        f"wire {one + 1} crosses itself" if one == two else f"wires {one + 1} and {two + 1} cross"
    )
    raise ContourError(what, (x, y))


def _members(contours: Sequence[Contour]) -> list[list[int]]:
    """Give of each region its outline and openings.

    Contours in an even number of others are outlines, the others openings.
    """
    spots = np.array([amid_longest(contour) for contour in contours])
    within = np.array([contour.contains(spots) for contour in contours])
    np.fill_diagonal(within, val=False)
    depth = within.sum(axis=0)
    outlines = [k for k in range(len(contours)) if depth[k] % 2 == 0]
    return [[k, *np.flatnonzero(within[k] & (depth == depth[k] + 1)).tolist()] for k in outlines]


def _region(contours: Sequence[Contour]) -> Region:
    """Give the region of an outline and its openings."""
    outer, *inner = contours
    outer = outer if outer.area > 0.0 else outer.reversed()
    return Region.made(outer, tuple(i if i.area < 0.0 else i.reversed() for i in inner))
