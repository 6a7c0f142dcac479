"""Pieces as segments, and the nearest place on them."""

from itertools import pairwise
from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.conic import arc, circle
from splinearm.curves.projection import Projection
from splinearm.errors import CurveError
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.spline_source import exact_form, source_of

SEVEN = [[0, 0], [0.6, 1.2], [1.5, 1.0], [2.2, -0.5], [3.1, -0.2], [3.6, 1.0], [4.6, 0.6]]
KNOTS = [0, 0, 0, 0, 0.2, 0.5, 0.7, 1, 1, 1, 1]
CURVE = BSpline(KNOTS, SEVEN, 3)
WEIGHTED = BSpline(KNOTS, SEVEN, 3, [1.0, 2.0, 0.5, 1.0, 3.0, 1.0, 0.7])


@pytest.mark.kernel
@pytest.mark.parametrize("curve", [CURVE, WEIGHTED], ids=["polynomial", "rational"])
def test_segments_give_the_points_and_derivatives_of_their_curve(curve):
    from splinearm.toolpaths.spline_jet_kernel import jet

    source = source_of([[SplinePiece(curve)]], 0.1)
    ends = curve.breaks
    for k, (a, b) in enumerate(pairwise(ends)):
        for s in (-1.0, -0.3, 0.8):
            found = np.array(jet(source.segments, k, s)).reshape(3, 2)
            half = 0.5 * (b - a)
            wanted = curve.jet(0.5 * (a + b) + half * s, 2)
            assert source.placed(found[0]) == pytest.approx(wanted[0], abs=1e-13)
            assert source.unit * found[1] == pytest.approx(half * wanted[1], rel=1e-12)
            assert source.unit * found[2] == pytest.approx(
                half**2 * wanted[2], rel=1e-11, abs=1e-13
            )


def test_places_of_a_chain_go_with_its_parameters():
    chain = source_of([[SplinePiece(CURVE)]], 0.1).chains[0]
    assert chain.places(np.array([0.0, 0.1, 0.2, 0.6, 1.0])) == pytest.approx([0, 0.5, 1, 2.5, 4])


def test_a_piece_splits_at_its_corners():
    bent = BSpline(
        [0, 0, 0, 0.5, 0.5, 1, 1, 1], [[0, 0], [0.5, 0.1], [1, 0], [1.1, 0.5], [1, 1]], 2
    )
    source = source_of([[SplinePiece(bent), LinePiece([1.0, 1.0], [0.0, 0.0])]], 0.1)
    assert [chain.end - chain.first for chain in source.chains] == [1, 1, 1]
    assert source.loops == ((0, 3),)


@pytest.mark.parametrize("turn", [0.4, -2.0, 4.0, -6.0])
def test_a_rational_arc_is_an_arc(turn):
    start = 0.3
    curve = arc(0.05, *sorted((start, start + turn)))
    if turn < 0.0:
        curve = curve.reversed()
    found = exact_form(curve.elevated())
    assert isinstance(found, ArcPiece)
    assert found.turn == pytest.approx(turn)
    assert found.centre == pytest.approx([0.0, 0.0], abs=1e-14)


def test_a_rational_circle_is_a_circle():
    found = exact_form(circle(0.05))
    assert isinstance(found, ArcPiece)
    assert found.turn == 2.0 * pi


def test_what_is_nearly_an_arc_or_a_line_stays_a_spline():
    almost = circle(0.05)
    points = np.array(almost.points)
    points[1] *= 1.0 + 1e-8
    assert isinstance(exact_form(BSpline(almost.knots, points, 2, almost.weights)), SplinePiece)
    bent = BSpline([0, 0, 0, 1, 1, 1], [[0.0, 0.0], [0.5, 1e-8], [1.0, 0.0]], 2)
    assert isinstance(exact_form(bent), SplinePiece)


def test_a_line_that_goes_back_is_no_line():
    back = BSpline([0, 0, 0, 0, 1, 1, 1, 1], [[0, 0], [1, 0], [-0.5, 0], [0.7, 0]], 3)
    with pytest.raises(CurveError, match="stands still"):
        source_of([[SplinePiece(back)]], 0.1)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.floats(-0.5, 5.0), st.floats(-1.0, 1.5))
def test_the_nearest_place_is_the_one_that_the_curves_find(x, y):
    from splinearm.toolpaths.spline_jet_kernel import nearest_place

    source = source_of([[SplinePiece(CURVE)]], 0.1)
    px, py = ((np.array([x, y]) - source.origin) / source.unit).tolist()
    _, away = nearest_place(source.segments, 0.0, 4.0, px, py, 16)
    wanted = float(Projection(CURVE).nearest(np.array([x, y])).distance)
    assert source.unit * away == pytest.approx(wanted, abs=1e-12)


@pytest.mark.kernel
def test_crossing_offsets_are_polished_to_rounding():
    from splinearm.toolpaths.spline_jet_kernel import meet

    first, second = LinePiece([0.0, 0.0], [1.0, 0.0]), LinePiece([1.0, 0.0], [1.0, 1.0])
    source = source_of([[first, second]], 0.1)
    d = 0.1 / source.unit
    ways = np.array([0.0, 1.0, 0.7, 0.0]), np.array([1.0, 2.0, 1.3, 0.0])
    a, b, x, y, gap = meet(source.segments, *ways, d)
    assert (a, b) == pytest.approx((0.9, 1.1), abs=1e-14)
    assert source.placed(np.array([x, y])) == pytest.approx([0.9, 0.1], abs=1e-14)
    assert gap < 1e-15
    # and about a corner: the circle around its end and the second line's offset
    corner = np.array([*source.corner(0), 2.8, 1.0])
    _, _, x, y, gap = meet(source.segments, corner, ways[1], d)
    assert hypot(*(source.placed(np.array([x, y])) - [1.0, 0.0])) == pytest.approx(0.1, abs=1e-9)
    assert gap < 1e-9
