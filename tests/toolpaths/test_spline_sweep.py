"""Offsets of many random outlines of splines, at all distances and tolerances."""

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.curves.projection import Projection
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.spline_offset import offset_outline

GOUGE = 1e-12


def outline(rng):
    """Give a closed outline: a spline, a NURBS, or a spline and the chord between its ends."""
    count, degree, kind = (int(rng.integers(a, b)) for a, b in ((6, 24), (2, 5), (0, 3)))
    a = 2.0 * np.pi * np.arange(count) / count
    radius = 0.06 * (1.0 + rng.uniform(0.1, 0.5) * rng.uniform(-1.0, 1.0, count))
    points = radius[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    weights = rng.uniform(0.5, 2.0, count) if kind == 1 else None
    curve = BSpline.closed(np.linspace(0.0, 1.0, count + 1), points, degree, weights)
    if kind < 2:
        return [SplinePiece(curve)]
    part = SplinePiece(curve.part(0.05, 0.6))
    return [part, LinePiece(part.end, part.start)]


def samples(piece):
    if isinstance(piece, SplinePiece):
        ends = piece.curve.breaks
        u = ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, 40)
        return piece.curve.at(u.ravel())
    t = np.linspace(0.0, 1.0, 40)[:, None]
    if isinstance(piece, LinePiece):
        return piece.start * (1.0 - t) + piece.end * t
    (x, y), turn = piece.start - piece.centre, piece.turn * t
    c, s = np.cos(turn), np.sin(turn)
    return piece.centre + np.hstack((c * x - s * y, s * x + c * y))


def away(piece, places):
    if isinstance(piece, SplinePiece):
        return Projection(piece.curve).nearest(places).distance
    return Contour.of_pieces([piece], closed=False).distance(places)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(160))
def test_no_outline_is_gouged_or_left_by_more_than_the_tolerance(seed):
    rng = np.random.default_rng(seed)
    pieces = outline(rng)
    distance = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-3.5, -1.6))
    tolerance = float(10.0 ** rng.uniform(-7.0, -4.5))
    for wire in offset_outline(pieces, distance, tolerance):
        for k, piece in enumerate(wire.pieces):
            assert isinstance(piece, LinePiece | ArcPiece | SplinePiece)
            assert (piece.start == wire.pieces[k - 1].end).all()
            places = samples(piece)
            near = np.min([away(each, places) for each in pieces], axis=0)
            assert near.min() >= abs(distance) - GOUGE
            assert near.max() <= abs(distance) + tolerance + GOUGE
