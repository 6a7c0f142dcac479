"""Control points that splines do without."""

from math import tau

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.piece import SplinePiece
from splinearm.toolpaths.spline_check import check_band
from splinearm.toolpaths.spline_offset import offset_outline, offset_spline
from splinearm.toolpaths.spline_path import track_pieces
from splinearm.toolpaths.spline_run import Run, Track
from splinearm.toolpaths.spline_source import source_of

POINTS = [[0, 0], [0.6, 1.2], [1.5, 1.0], [2.2, -0.5], [3.1, -0.2], [3.6, 1.0], [4.6, 0.6]]
KNOTS = [0.0, 0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0]
WAVE = BSpline(KNOTS, POINTS, 3)
BOW = BSpline([0.0] * 4 + [1.0] * 4, [[0.0, 0.0], [1.0, 1.0], [0.6, -1.0], [1.6, 0.2]], 3)


def ring(count, weights=None):
    a = tau * np.arange(count) / count
    radius = 0.046 + 0.029 * np.cos(2.0 * a)
    points = radius[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    return BSpline.closed(np.linspace(0.0, 1.0, count + 1), points, 3, weights)


def pieces_of(curve, *, thin, tolerance):
    source = source_of([[SplinePiece(curve)]], 0.1)
    lo, hi = source.limits(0)
    near, far = 0.1 / source.unit, (0.1 + tolerance) / source.unit
    ends = [source.beside(0, place, near)[:2] for place in (lo, hi)]
    track = Track((Run(0, False, lo, hi, ends[0], ends[1]),), False)
    found = track_pieces(source, track, (near, far), free_ends=True, thin=thin)
    return source, found


@pytest.mark.kernel
def test_thinned_splines_have_fewer_points_and_stay_in_the_band():
    source, (full,) = pieces_of(BOW, thin=False, tolerance=1e-3)
    _, (thin,) = pieces_of(BOW, thin=True, tolerance=1e-3)
    assert len(thin.curve.points) < len(full.curve.points)
    # the bounds need some room at the edges
    check_band(source, [thin], 0.1 - 4e-5, 1e-3 + 8e-5)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5])
def test_ends_keep_their_direction_and_lie_across_the_ends_of_the_curve(tolerance):
    _, (thin,) = pieces_of(WAVE, thin=True, tolerance=tolerance)
    for u in (0.0, 1.0):
        way, mine = WAVE.at(u, 1), thin.curve.at(u, 1)
        assert mine / np.hypot(*mine) == pytest.approx(way / np.hypot(*way), abs=1e-9)
        gap = thin.curve.at(u) - WAVE.at(u)
        assert abs(gap @ way) / np.hypot(*way) < 1e-12


@pytest.mark.parametrize("distance", [-0.008, 0.008])
def test_a_closed_outline_goes_over_its_seam_without_a_corner(distance):
    ((piece,),) = (w.pieces for w in offset_outline([SplinePiece(ring(12))], distance, 1e-7))
    a, b = piece.curve.at(1.0, 1), piece.curve.at(0.0, 1)
    assert a / np.hypot(*a) == pytest.approx(b / np.hypot(*b), abs=1e-9)


@pytest.mark.parametrize(("distance", "most"), [(-0.008, 57), (0.008, 57)])
def test_a_closed_outline_takes_a_sixth_of_its_biarcs(distance, most):
    # 344 if parameter ranges are halved until a biarc is within the tolerance
    wires = offset_outline([SplinePiece(ring(12))], distance, 1e-7)
    assert sum(len(piece.curve.points) for wire in wires for piece in wire.pieces) <= most


def test_knots_stay_apart_and_in_order():
    (found,) = offset_spline(WAVE, 0.1, 1e-4)
    assert np.diff(found.breaks).min() > 1e-6
    assert (np.diff(found.knots) >= 0.0).all()
