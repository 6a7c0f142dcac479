"""Wires of lines, arcs and splines, measured as they are drawn."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.toolpaths.chain import chain
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.shape import ellipse_piece
from splinearm.toolpaths.wire import Wire


def ellipse(a=0.03, b=0.01, centre=(0.2, -0.1), turn=2.0 * pi):
    return Wire(
        (ellipse_piece(np.array(centre), np.array([a, 0.0]), np.array([0.0, b]), 0.0, turn),), True
    )


def blob(seed, count=9):
    """A closed B-spline outline through places around the origin."""
    rng = np.random.default_rng(seed)
    angles = np.linspace(0.0, 2.0 * pi, count, endpoint=False)
    radii = rng.uniform(0.6, 1.4, count)
    places = np.stack((radii * np.cos(angles), radii * np.sin(angles)), axis=1)
    curve = interpolate(np.vstack((places, places[:1])))
    return Wire((SplinePiece(curve),), True)


def flattened(wire, count=4000):
    """Places along a wire of one spline."""
    curve = wire.pieces[0].curve
    return curve.at(np.linspace(*curve.domain, count + 1))[:-1]


@pytest.mark.kernel
def test_an_ellipse_is_measured_as_the_formulas_say():
    wire = ellipse()
    assert wire.area == pytest.approx(pi * 0.03 * 0.01, rel=1e-14)
    assert wire.reversed().area == pytest.approx(-wire.area, rel=1e-14)
    assert wire.bounds == pytest.approx((0.17, -0.11, 0.23, -0.09), abs=1e-15)
    assert wire.distance([[0.25, -0.1], [0.2, -0.1], [0.2, -0.08]]) == pytest.approx(
        [0.02, 0.01, 0.01], abs=1e-14
    )
    assert wire.contains([[0.2, -0.1], [0.2299, -0.1], [0.2301, -0.1], [0.0, 0.0]]).tolist() == [
        True,
        True,
        False,
        False,
    ]


@pytest.mark.kernel
def test_lines_and_arcs_are_measured_like_their_contour():
    contour = Contour.rectangle([0.1, 0.2], [0.15, 0.24], 0.008)
    wire = Wire(contour.pieces(), True)
    rng = np.random.default_rng(3)
    points = rng.uniform([0.09, 0.19], [0.16, 0.25], (100, 2))
    assert wire.area == pytest.approx(contour.area, rel=1e-13)
    assert wire.length == pytest.approx(contour.length, rel=1e-14)
    assert wire.bounds == pytest.approx(contour.bounds, abs=1e-15)
    np.testing.assert_allclose(wire.distance(points), np.abs(contour.distance(points)), atol=1e-13)
    assert (wire.contains(points) == contour.contains(points)).all()


def test_a_full_circle_is_one_piece_either_way():
    arc = ArcPiece.about(np.array([1.0, 2.0]), 0.5, 0.3, 2.0 * pi)
    for piece, sign in ((arc, 1.0), (arc.reversed(), -1.0)):
        wire = Wire((piece,), True)
        assert wire.area == pytest.approx(sign * pi * 0.25, rel=1e-14)
        assert wire.bounds == pytest.approx((0.5, 1.5, 1.5, 2.5), abs=1e-14)
        assert wire.contains([[1.0, 2.0], [1.6, 2.0]]).tolist() == [True, False]


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_splines_are_measured_like_many_short_lines(seed):
    wire = blob(seed)
    line = Contour.polyline(flattened(wire))
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.5, 1.5, (60, 2))
    clear = np.abs(line.distance(points)) > 1e-4
    assert wire.area == pytest.approx(line.area, rel=1e-5)
    assert (wire.contains(points) == line.contains(points))[clear].all()
    np.testing.assert_allclose(wire.distance(points), np.abs(line.distance(points)), atol=2e-6)
    assert np.subtract(wire.bounds, line.bounds) == pytest.approx(np.zeros(4), abs=2e-6)


def test_a_polynomial_spline_has_the_area_of_its_integral():
    # y = x (1 - x) over the unit interval, back along the axis: 1/6 to the right of it
    curve = BSpline([0, 0, 0, 1, 1, 1], [[0.0, 0.0], [0.5, 0.5], [1.0, 0.0]], 2)
    base = LinePiece(np.array([1.0, 0.0]), np.array([0.0, 0.0]))
    wire = Wire((SplinePiece(curve), base), True)
    assert wire.area == pytest.approx(-1.0 / 6.0, rel=1e-15)
    far = np.array([1e4, -1e4])
    moved = BSpline(curve.knots, curve.points + far, 2)
    back = LinePiece(base.start + far, base.end + far)
    assert Wire((SplinePiece(moved), back), True).area == pytest.approx(-1.0 / 6.0, rel=1e-11)


def test_an_open_wire_encloses_nothing_but_is_measured():
    wire = chain([LinePiece(np.zeros(2), np.array([0.03, 0.04]))], 1e-6).wires[0]
    assert wire.length == pytest.approx(0.05)
    assert wire.distance([[0.0, 0.05]]) == pytest.approx([0.03])
    assert wire.bounds == (0.0, 0.0, 0.03, 0.04)
    with pytest.raises(ValueError, match="area: want a closed wire"):
        _ = wire.area
    with pytest.raises(ValueError, match="contains: want a closed wire"):
        wire.contains([[0.0, 0.0]])
