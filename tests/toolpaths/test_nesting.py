"""What closed wires enclose, and where the circles are."""

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.errors import ContourError
from splinearm.toolpaths.chain import chain
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.nesting import circles, contour_of, nested
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.wire import Wire

pytestmark = pytest.mark.kernel


def wire(contour):
    return Wire(contour.pieces(), closed=True)


def square(x, y, size):
    return wire(Contour.rectangle([x, y], [size, size]))


def blob(centre, size):
    """Give a closed spline about a place."""
    angle = np.arange(11) * 2 * np.pi / 8
    points = np.stack((np.cos(angle), np.sin(angle)), axis=1) * size + centre
    knots = np.arange(15.0)
    return Wire((SplinePiece(BSpline(knots, points, 3).clamped()),), closed=True)


def test_openings_lie_in_their_outlines_and_parts_in_openings():
    wires = [square(2, 2, 6), square(0, 0, 10), square(3, 3, 1), square(5, 5, 1), square(20, 0, 3)]
    # drawn the other way round is the same
    wires[0] = wire(contour_of(wires[0], 1.0).reversed())
    found = nested(wires, 1e-3)
    assert found.slack == 0.0
    areas = sorted(region.area for region in found.regions)
    assert areas == pytest.approx([1.0, 1.0, 9.0, 100.0 - 36.0])
    assert all(region.outer.area > 0 for region in found.regions)
    assert all(i.area < 0 for region in found.regions for i in region.islands)


def test_crossing_wires_are_refused_with_the_place():
    with pytest.raises(ContourError, match="wires 1 and 2 cross") as caught:
        nested([square(0, 0, 2), square(1, 1, 2)], 1e-3)
    assert sorted(caught.value.where) == pytest.approx([1.0, 2.0])
    eight = Contour.polyline([[0, 0], [2, 2], [2, 0], [0, 2]])
    with pytest.raises(ContourError, match="wire 1 crosses itself") as caught:
        nested([wire(eight)], 1e-3)
    assert caught.value.where == pytest.approx((1.0, 1.0))


def test_outlines_along_each_other_are_neighbours_unless_they_part_to_the_other_side():
    one = square(0, 0, 1)
    assert len(nested([one, square(1, 0, 1)], 1e-4).regions) == 2
    # along the edge before it leads into the square, and again behind
    over = [[2, 0.1], [2, 0.9], [1, 0.9], [1, 0.8], [0.5, 0.5], [1, 0.3], [1, 0.1]]
    with pytest.raises(ContourError, match="wires 1 and 2 cross") as caught:
        nested([one, wire(Contour.polyline(over))], 1e-4)
    assert caught.value.where[0] == pytest.approx(1.0)


def test_open_wires_and_none_enclose_nothing():
    line = Wire((LinePiece(np.zeros(2), np.ones(2)),), closed=False)
    for wires in ([], [line]):
        with pytest.raises(ValueError, match="wires"):
            nested(wires, 1e-3)


def test_splines_become_arcs_within_half_of_the_tolerance():
    spline = blob([0.05, 0.05], 0.02)
    found = nested([square(0, 0, 0.1), spline], 1e-5)
    assert found.slack == 5e-6
    (region,) = found.regions
    (island,) = region.islands
    curve = spline.pieces[0].curve
    first, last = curve.domain
    assert island.distance(curve.at(np.linspace(first, last, 500))).max() <= 5e-6
    assert len(island.bulges) < 120


def test_circles_are_found_whole_and_in_parts():
    whole = Wire((ArcPiece.about(np.array([1.0, 2.0]), 0.5, 0.3, 2 * np.pi),), closed=True)
    halves = wire(Contour.circle([3.0, 4.0], 0.25))
    slot = wire(Contour.rectangle([0.0, 0.0], [3.0, 1.0], 0.5))
    middles, diameters = circles([square(0, 0, 1), halves, slot, whole])
    np.testing.assert_allclose(middles, [[3.0, 4.0], [1.0, 2.0]])
    np.testing.assert_allclose(diameters, [0.5, 1.0])
    assert circles([])[0].shape == (0, 2)


def test_what_a_drawing_chains_can_be_nested():
    pieces = [p for w in (square(0, 0, 2), square(0.5, 0.5, 1)) for p in w.pieces]
    (region,) = nested(chain(pieces[::-1], 1e-6).wires, 1e-3).regions
    assert region.area == pytest.approx(3.0)
