"""Shapes that files describe in ways of their own, as pieces: ellipses, chains with bulges."""

from collections.abc import Sequence
from math import cos, hypot, isfinite, pi, sin

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.conic import elliptic_arc

from .piece import ArcPiece, LinePiece, Piece, SplinePiece

_ROUND = 1e-9
"""Share of its size by which an ellipse may differ from a circle and still be one."""

_STRAIGHT = 1e-12
"""A bulge below this is a line: the arc would differ from it by less than rounding."""


def ellipse_piece(
    centre: FloatArray, major: FloatArray, minor: FloatArray, first: float, turn: float
) -> Piece:
    """Give the arc ``centre + major cos v + minor sin v``, a circular one as such.

    Args:
        centre: Centre, shape (2,), m.
        major: Any two
        minor: conjugate half diameters, shape (2,), m.
        first: Where v begins, rad.
        turn: How far v goes, rad, either way, at most a full turn.
    """
    a, b = hypot(*major), hypot(*minor)
    if abs(a - b) <= _ROUND * a and abs(float(major @ minor)) <= _ROUND * a * b:
        ends = [centre + major * cos(v) + minor * sin(v) for v in (first, first + turn)]
        if abs(turn) >= 2.0 * pi:
            ends[1] = ends[0]
        handed = 1.0 if major[0] * minor[1] > major[1] * minor[0] else -1.0
        return ArcPiece(start=ends[0], end=ends[1], centre=centre, turn=handed * turn)
    map_ = np.eye(3)
    map_[:2] = np.column_stack((major, minor, centre))
    return SplinePiece(elliptic_arc((1.0, 1.0), first, first + turn).mapped(map_))


def bulging_chain(places: FloatArray, bulges: Sequence[float], *, closed: bool) -> list[Piece]:
    """Give lines and arcs through places; the bulge of each is of the way to the next."""
    count = len(places) if closed else len(places) - 1
    pieces: list[Piece] = []
    for i in range(count):
        start, end = places[i], places[(i + 1) % len(places)]
        if not isfinite(bulges[i]):
            raise ValueError(f"the bulge of vertex {i + 1} is {bulges[i]}")
        if (start == end).all():
            continue
        straight = abs(bulges[i]) < _STRAIGHT
        pieces.append(
            LinePiece(start, end) if straight else ArcPiece.bulging(start, end, bulges[i])
        )
    return pieces
