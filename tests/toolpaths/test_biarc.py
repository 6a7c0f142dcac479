"""Splines and offsets as lines and arcs."""

from math import hypot, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.projection import Projection
from splinearm.errors import ToolpathError
from splinearm.toolpaths.biarc import curve_arcs, offset_outline_arcs, outline_arcs
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece


def clamped(points, degree=3):
    inner = np.linspace(0.0, 1.0, len(points) - degree + 1)[1:-1]
    knots = np.concatenate((np.zeros(degree + 1), inner, np.ones(degree + 1)))
    return BSpline(knots, points, degree)


def blob(weights=None):
    a = tau * np.arange(9) / 9
    r = 0.06 + 0.012 * np.cos(3.0 * a + 0.3)
    points = r[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    return BSpline.closed(np.linspace(0.0, 1.0, 10), points, 3, weights)


def contour(wire):
    return Contour.of_pieces(wire.pieces, closed=wire.closed)


def direction(piece, *, end):
    way = piece.end - piece.start
    if isinstance(piece, ArcPiece):
        arm = (piece.end if end else piece.start) - piece.centre
        way = np.sign(piece.turn) * np.array([-arm[1], arm[0]])
    return way / hypot(*way)


def check_near(curve, wire, tolerance):
    ours = contour(wire)
    u = np.linspace(*curve.domain, 4000)
    assert ours.distance(curve.at(u)).max() <= tolerance
    places = ours.flattened(1e-3 * tolerance)[::7]
    assert Projection(curve).nearest(places).distance.max() <= 1.001 * tolerance


S_CURVE = clamped([[0.0, 0.0], [1.0, 1.0], [0.6, -1.0], [1.6, 0.2]])


@pytest.mark.kernel
@pytest.mark.parametrize("curve", [S_CURVE, blob(), blob(np.linspace(0.5, 2.0, 9))])
def test_arcs_are_near_the_curve_and_the_curve_near_the_arcs(curve):
    check_near(curve, curve_arcs(curve, 1e-4), 1e-4)


@pytest.mark.kernel
def test_arcs_go_over_into_each_other_without_corners():
    wire = curve_arcs(S_CURVE, 1e-4)
    for a, b in zip(wire.pieces, wire.pieces[1:], strict=False):
        assert a.end == pytest.approx(b.start, abs=1e-15)
        assert direction(a, end=True) == pytest.approx(direction(b, end=False), abs=1e-7)


@pytest.mark.kernel
def test_a_tenth_of_the_tolerance_takes_about_twice_as_many_arcs():
    counts = [len(curve_arcs(S_CURVE, tolerance).pieces) for tolerance in (1e-3, 1e-4, 1e-5)]
    # the miss falls with the third power of the length
    assert counts[1] <= 2.5 * counts[0]
    assert counts[2] <= 2.5 * counts[1]


@pytest.mark.kernel
def test_lines_and_arcs_stay_and_a_straight_spline_becomes_a_line():
    pieces = [
        LinePiece([0.0, 0.0], [1.0, 0.0]),
        SplinePiece(clamped([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]])),
    ]
    wire = outline_arcs(pieces, 1e-4)
    assert [type(p) for p in wire.pieces] == [LinePiece, LinePiece]
    assert not wire.closed


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=9),
    st.integers(-3, 3),
    st.sampled_from([1e-3, 1e-4]),
)
def test_any_curve_of_any_size_is_followed(across, power, tolerance):
    scale = 10.0**power
    points = np.stack((np.arange(len(across)), np.array(across)), axis=1) * scale
    curve = clamped(points)
    check_near(curve, curve_arcs(curve, tolerance * scale), tolerance * scale)


@pytest.mark.parametrize("distance", [0.01, -0.01])
def test_an_outline_is_offset_as_arcs_without_a_gouge(distance):
    curve = blob()
    (region,) = offset_outline_arcs([SplinePiece(curve)], distance, 1e-5)
    places = region.outer.flattened(1e-8)[::5]
    away = Projection(curve).nearest(places).distance
    # chords of the arcs may lie 1e-8 m to one side
    assert away.min() >= abs(distance) - 1.1e-8
    assert away.max() <= abs(distance) + 1e-5 + 1.1e-8
    exact = np.pi * 0.06**2
    assert (region.area > exact) == (distance > 0.0)


def test_islands_are_offset_with_their_outline():
    hole = BSpline.closed(np.linspace(0.0, 1.0, 10), blob().points[:9] * 0.3, 3)
    (region,) = offset_outline_arcs(
        [SplinePiece(blob())], -0.005, 1e-5, islands=[[SplinePiece(hole)]]
    )
    assert len(region.islands) == 1


@pytest.mark.kernel
def test_wrong_arguments_say_what_came():
    with pytest.raises(ValueError, match="tolerance: want a length above zero"):
        curve_arcs(S_CURVE, -1.0)
    with pytest.raises(ValueError, match="want it closed"):
        offset_outline_arcs([SplinePiece(S_CURVE)], 0.1, 1e-3)
    with pytest.raises(ToolpathError, match="too many arcs"):
        curve_arcs(S_CURVE, 1e-17)
