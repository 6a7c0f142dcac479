"""Offsets of splines and of outlines with splines."""

from math import hypot, pi, tau

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.conic import arc, line
from splinearm.curves.curvature import curvature
from splinearm.curves.projection import Projection
from splinearm.errors import CurveError, GougeError, OffsetError, ToolpathError
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.spline_offset import offset_outline, offset_spline
from splinearm.toolpaths.wire import Wire

GOUGE = 1e-12  # m: 1e-9 mm


def clamped(points, degree, weights=None):
    points = np.asarray(points, dtype=float)
    inner = np.linspace(0.0, 1.0, len(points) - degree + 1)[1:-1]
    knots = np.concatenate((np.zeros(degree + 1), inner, np.ones(degree + 1)))
    return BSpline(knots, points, degree, weights)


def ring(radius, count, degree=3, weights=None):
    """Give a closed spline around the origin, from its radius by the angle, in mm."""
    a = tau * np.arange(count) / count
    points = 1e-3 * radius(a)[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    return BSpline.closed(np.linspace(0.0, 1.0, count + 1), points, degree, weights)


def c_shape():
    a = np.linspace(0.5, tau - 0.5, 14)
    half = 18.0 + 4.5 * np.cos(np.linspace(0.0, 6.0 * pi, 14))
    way = np.stack((np.cos(a), np.sin(a)), axis=1)
    points = np.concatenate((way * (52.0 + half)[:, None], (way * (52.0 - half)[:, None])[::-1]))
    return BSpline.closed(np.linspace(0.0, 1.0, 29), 1e-3 * points, 3)


OUTLINES = {
    "peanut": lambda: ring(lambda a: 46.0 + 29.0 * np.cos(2.0 * a), 12),
    "star": lambda: ring(lambda a: 55.0 + 20.0 * np.cos(5.0 * a), 20),
    "cshape": c_shape,
    "wiggle": lambda: ring(lambda a: 62.0 + 11.0 * np.cos(9.0 * a), 36),
    "nurbs_blob": lambda: ring(
        lambda a: 60.0 + 12.0 * np.cos(3.0 * a + 0.3),
        9,
        weights=np.array([1.0, 2.5, 0.6, 1.0, 3.0, 0.7, 1.2, 2.0, 0.8]),
    ),
}
# outline, distance in mm, how many loops
CASES = [
    ("peanut", -8, 1), ("peanut", 8, 1), ("peanut", -22, 2), ("star", -6, 1), ("star", 12, 1),
    ("cshape", -12, 1), ("cshape", 10, 1), ("cshape", -18, 2), ("cshape", 23, 2),
    ("wiggle", -6, 1), ("wiggle", 6, 1), ("nurbs_blob", -10, 1), ("nurbs_blob", 10, 1),
]  # fmt: skip


HALVED = {"peanut": 344, "star": 620, "cshape": 564, "wiggle": 1116, "nurbs_blob": 312}
"""Biarcs of each outline within 1e-7 m if ranges of its parameter are halved until they fit."""


def samples(piece, count=60):
    """Give places of a piece, many in each of its spans."""
    if isinstance(piece, SplinePiece):
        ends = piece.curve.breaks
        u = ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, count)
        return piece.curve.at(u.ravel())
    t = np.linspace(0.0, 1.0, count)[:, None]
    if isinstance(piece, LinePiece):
        return piece.start * (1.0 - t) + piece.end * t
    c, s = np.cos(piece.turn * t), np.sin(piece.turn * t)
    x, y = piece.start - piece.centre
    return piece.centre + np.hstack((c * x - s * y, s * x + c * y))


def far_from(curve, points):
    """Give how far places are from a curve, by the curves' own projection."""
    return Projection(curve).nearest(points).distance


def check_between(curve, pieces, distance, tolerance, slack=GOUGE):
    for piece in pieces:
        away = far_from(curve, samples(piece))
        assert away.min() >= distance - slack
        assert away.max() <= distance + tolerance + slack


def control_points(wires):
    return sum(
        len(p.curve.points) if isinstance(p, SplinePiece) else 2 for w in wires for p in w.pieces
    )


S_CURVE = clamped([[0.0, 0.0], [1.0, 1.0], [0.6, -1.0], [1.6, 0.2]], 3)


@pytest.mark.parametrize("distance", [0.15, -0.15])
def test_the_offset_of_a_spline_lies_within_the_tolerance_beyond_the_distance(distance):
    (found,) = offset_spline(S_CURVE, distance, 1e-4)
    check_between(S_CURVE, [SplinePiece(found)], abs(distance), 1e-4)


@pytest.mark.kernel
def test_the_offset_begins_and_ends_beside_the_ends_and_in_their_direction():
    (found,) = offset_spline(S_CURVE, 0.15, 1e-2)
    for ours, theirs in zip(found.domain, S_CURVE.domain, strict=True):
        way = S_CURVE.at(theirs, 1) / hypot(*S_CURVE.at(theirs, 1))
        beside = S_CURVE.at(theirs) + 0.15 * np.array([-way[1], way[0]])
        assert np.abs(found.at(ours) - beside).max() <= 1e-2
        mine = found.at(ours, 1)
        assert mine / hypot(*mine) == pytest.approx(way, abs=1e-9)


def test_the_offset_is_a_cubic_with_a_continuous_derivative_and_few_points():
    (found,) = offset_spline(S_CURVE, 0.15, 1e-4)
    assert found.degree == 3
    assert len(found.points) <= 16
    for u in found.breaks[1:-1]:
        before, behind = found.split(u)
        assert before.at(u, 1) == pytest.approx(behind.at(u, 1), rel=1e-9)


def test_the_right_side_is_the_left_one_of_the_curve_run_backwards():
    (right,) = offset_spline(S_CURVE, -0.1, 1e-4)
    (left,) = offset_spline(S_CURVE.reversed(), 0.1, 1e-4)
    assert right.points == pytest.approx(left.points[::-1], abs=1e-12)


def test_a_finer_tolerance_takes_more_points_but_not_many():
    counts = [len(offset_spline(S_CURVE, 0.15, tol)[0].points) for tol in (1e-3, 1e-4, 1e-5, 1e-6)]
    assert counts == sorted(counts)
    # the error falls with the sixth power of the length of pieces: 1.47 times as many a decade,
    # and somewhat more as fewer points can be taken out of what is finer
    assert counts[-1] <= 4.0 * counts[0]


@pytest.mark.parametrize(("distance", "tolerance"), [(1e-6, 1e-4), (0.1, 1.0), (30.0, 1e-3)])
def test_distances_may_be_small_beside_the_tolerance_and_large_beside_the_curve(
    distance, tolerance
):
    for side in (1.0, -1.0):
        found = offset_spline(S_CURVE, side * distance, tolerance)
        check_between(S_CURVE, [SplinePiece(f) for f in found], distance, tolerance, slack=1e-13)


def test_no_distance_gives_the_curve_itself():
    (found,) = offset_spline(S_CURVE, 0.0, 1e-4)
    assert found.points == pytest.approx(S_CURVE.points)


@pytest.mark.kernel
def test_an_arc_stays_an_arc_and_a_line_a_line():
    (found,) = offset_spline(arc(0.05, 0.2, 2.0), 0.01, 1e-6)
    radii = np.hypot(*found.at(np.linspace(*found.domain, 50)).T)
    assert np.ptp(radii) < 1e-15
    assert 0.04 - 1e-6 <= radii[0] <= 0.04
    (straight,) = offset_spline(line([0.0, 0.0], [0.1, 0.0]).elevated(2), -0.02, 1e-6)
    assert straight.degree == 1
    assert straight.points[:, 1] == pytest.approx([-0.02, -0.02], abs=1e-6)


@pytest.mark.kernel
def test_a_loop_between_cusps_is_left_out():
    bow = clamped([[0.0, 0.0], [1.0, 0.0], [0.5, 1.2], [0.0, 0.0 + 1.2]], 3)
    tight = 1.3 / curvature(bow, np.linspace(0.0, 1.0, 1001)).max()
    found = offset_spline(bow, tight, 1e-4)
    assert len(found) == 2
    assert found[0].points[-1] == pytest.approx(found[1].points[0], abs=1e-12)
    check_between(bow, [SplinePiece(f) for f in found], tight, 1e-4)


@pytest.mark.kernel
def test_a_corner_is_gone_round_outside_and_cut_off_inside():
    knots = [0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0]
    bent = BSpline(knots, [[0.0, 0.0], [0.5, 0.1], [1.0, 0.0], [1.1, 0.5], [1.0, 1.0]], 2)
    outside = offset_spline(bent, -0.05, 1e-5)
    assert [curve.degree for curve in outside] == [3, 2, 3]
    inside = offset_spline(bent, 0.05, 1e-5)
    assert len(inside) == 2
    for found in (outside, inside):
        check_between(bent, [SplinePiece(f) for f in found], 0.05, 1e-5)


@st.composite
def open_curves(draw):
    degree = draw(st.integers(2, 4))
    count = draw(st.integers(degree + 1, 10))
    number = st.floats(-1.0, 1.0)
    across = np.array(draw(st.lists(number, min_size=count, max_size=count)))
    along = np.array(draw(st.lists(number, min_size=count, max_size=count)))
    weights = None
    if draw(st.booleans()):
        some = st.floats(0.5, 2.0)
        weights = np.array(draw(st.lists(some, min_size=count, max_size=count)))
    scale = 10.0 ** draw(st.integers(-3, 3))
    points = np.stack((np.arange(count) + 0.3 * along, 1.5 * across), axis=1) / count * scale
    return clamped(points, degree, weights), scale


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(open_curves(), st.floats(0.01, 0.2), st.booleans(), st.sampled_from([1e-3, 1e-4, 1e-5]))
def test_no_curve_of_any_size_is_gouged_and_its_offset_is_where_it_should_be(
    drawn, distance, left, tolerance
):
    curve, scale = drawn
    d, tol = distance * scale, tolerance * scale
    found = offset_spline(curve, d if left else -d, tol)
    check_between(curve, [SplinePiece(f) for f in found], d, tol, slack=1e-12 * scale)


@st.composite
def closed_curves(draw):
    count = draw(st.integers(6, 11))
    shares = st.floats(-1.0, 1.0)
    bumps = np.array(draw(st.lists(shares, min_size=count, max_size=count)))
    degree = draw(st.integers(2, 4))
    a = tau * np.arange(count) / count
    points = (0.07 * (1.0 + 0.4 * bumps))[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    return BSpline.closed(np.linspace(0.0, 1.0, count + 1), points, degree)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(closed_curves(), st.floats(-0.02, 0.02))
def test_outlines_grow_and_shrink_without_a_gouge(curve, distance):
    assume(abs(distance) > 1e-4)
    given_area = abs(Wire((SplinePiece(curve),), closed=True).area)
    wires = offset_outline([SplinePiece(curve)], distance, 1e-6)
    for wire in wires:
        assert wire.closed
        check_between(curve, wire.pieces, abs(distance), 1e-6)
    area = sum(wire.area for wire in wires)
    assert (area > given_area) == (distance > 0.0)


@pytest.mark.parametrize(("name", "distance", "loops"), CASES)
def test_closed_splines_keep_the_right_loops(name, distance, loops):
    curve = OUTLINES[name]()
    wires = offset_outline([SplinePiece(curve)], 1e-3 * distance, 1e-5)
    assert len(wires) == loops
    for wire in wires:
        check_between(curve, wire.pieces, abs(distance) * 1e-3, 1e-5)
        for k, piece in enumerate(wire.pieces):
            assert (piece.start == wire.pieces[k - 1].end).all()


@pytest.mark.parametrize("tolerance", [1e-7, 1e-8])
@pytest.mark.parametrize(("name", "distance", "loops"), CASES)
def test_closed_splines_keep_the_right_loops_at_fine_tolerances(name, distance, loops, tolerance):
    curve = OUTLINES[name]()
    wires = offset_outline([SplinePiece(curve)], 1e-3 * distance, tolerance)
    assert len(wires) == loops
    for wire in wires:
        check_between(curve, wire.pieces, abs(distance) * 1e-3, tolerance)
    if tolerance == 1e-7:
        assert control_points(wires) <= HALVED[name] / 6


def test_what_an_outline_encloses_is_on_its_left_and_a_closed_opening_becomes_a_hole():
    wires = offset_outline([SplinePiece(c_shape())], 0.023, 1e-5)
    areas = sorted(wire.area for wire in wires)
    assert areas[0] < 0.0 < areas[1]


def test_the_direction_and_the_seam_of_an_outline_do_not_matter():
    curve = OUTLINES["star"]()
    wire = [SplinePiece(curve)]
    first, second = curve.split(0.37)
    ways = [wire, [wire[0].reversed()], [SplinePiece(second), SplinePiece(first)]]
    areas = [offset_outline(way, -0.006, 1e-6)[0].area for way in ways]
    length = wire[0].length
    assert areas == pytest.approx([areas[0]] * 3, abs=length * 1e-6)


def test_a_convex_outline_grows_by_its_length_and_a_circle():
    # Steiner's formula: A + L d + pi d^2
    round_one = ring(lambda a: 60.0 + 3.0 * np.cos(2.0 * a), 12)
    (wire,) = offset_outline([SplinePiece(round_one)], 0.01, 1e-8)
    length = round_one.length()
    exact = Wire((SplinePiece(round_one),), closed=True).area + 0.01 * length + pi * 1e-4
    assert wire.area == pytest.approx(exact, abs=1e-8 * (length + 0.07))


def test_what_is_left_of_nothing_is_nothing():
    assert offset_outline([SplinePiece(OUTLINES["peanut"]())], -0.04, 1e-5) == ()


def plate():
    """Give a plate with a wavy top: two lines, an arc and a spline, m."""
    top = clamped([[0.1, 0.04], [0.075, 0.07], [0.05, 0.01], [0.025, 0.07], [0.0, 0.04]], 3)
    corner = ArcPiece.about(np.array([0.09, 0.01]), 0.01, -0.5 * pi, 0.5 * pi)
    return (
        LinePiece([0.0, 0.0], corner.start),
        corner,
        LinePiece(corner.end, [0.1, 0.04]),
        SplinePiece(top),
        LinePiece([0.0, 0.04], [0.0, 0.0]),
    )


@pytest.mark.parametrize("distance", [0.005, -0.005])
def test_lines_stay_lines_and_arcs_arcs_beside_splines(distance):
    pieces = plate()
    (wire,) = offset_outline(Wire(pieces, closed=True), distance, 1e-6)
    kinds = [type(piece) for piece in wire.pieces]
    assert kinds.count(LinePiece) == 3
    assert SplinePiece in kinds
    arcs = [piece for piece in wire.pieces if isinstance(piece, ArcPiece)]
    assert any(a.centre == pytest.approx([0.09, 0.01]) for a in arcs)
    near = np.min([_away(piece, wire) for piece in pieces], axis=0)
    assert near.min() >= abs(distance) - GOUGE
    assert near.max() <= abs(distance) + 1e-6 + GOUGE


def _away(piece, wire):
    places = np.concatenate([samples(p) for p in wire.pieces])
    if isinstance(piece, SplinePiece):
        return far_from(piece.curve, places)
    return Contour.of_pieces([piece], closed=False).distance(places)


def test_an_island_grows_into_what_is_left_of_its_part():
    part = ring(lambda a: 60.0 + 0.0 * a, 12)
    island = ring(lambda a: 20.0 + 2.0 * np.cos(3.0 * a), 12)
    wires = offset_outline([SplinePiece(part)], -0.005, 1e-6, islands=[[SplinePiece(island)]])
    areas = [wire.area for wire in wires]
    assert sorted(np.sign(areas)) == [-1.0, 1.0]
    assert -min(areas) > abs(Wire((SplinePiece(island),), closed=True).area)
    for wire, curve in zip(wires, (part, island), strict=True):
        check_between(curve, wire.pieces, 0.005, 1e-6)


def test_an_outline_of_many_splines_that_join_smoothly_takes_no_more_points_than_one():
    curve = OUTLINES["star"]()
    pieces = [SplinePiece(part) for part in curve.split(0.37)]
    pieces = [SplinePiece(p) for one in pieces for p in one.curve.split(np.mean(one.curve.domain))]
    one, many = (offset_outline(way, 0.012, 1e-6) for way in ([SplinePiece(curve)], pieces))
    assert [len(wire.pieces) for wire in one] == [len(wire.pieces) for wire in many] == [5]
    # which start it has of a way to fewer points is chance
    assert abs(control_points(one) - control_points(many)) <= 5
    for wire in many:
        check_between(curve, wire.pieces, 0.012, 1e-6)


def test_wrong_arguments_say_what_came():
    with pytest.raises(ValueError, match="tolerance: want a length above zero, got 0"):
        offset_spline(S_CURVE, 0.1, 0.0)
    with pytest.raises(ValueError, match="distance: want a finite length, got inf"):
        offset_spline(S_CURVE, float("inf"), 1e-4)
    with pytest.raises(ValueError, match="in the plane"):
        offset_spline(BSpline([0, 0, 1, 1], [[0, 0, 0], [1, 1, 1]], 1), 0.1, 1e-4)
    with pytest.raises(ValueError, match="outline: piece 0 begins at"):
        offset_outline([SplinePiece(S_CURVE)], 0.1, 1e-4)
    with pytest.raises(ValueError, match="at least one piece"):
        offset_outline([], 0.1, 1e-4)


def test_a_curve_that_stands_still_is_refused():
    still = clamped([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 3)
    with pytest.raises(CurveError, match="stands still"):
        offset_spline(still, 0.1, 1e-4)


def test_an_outline_that_crosses_itself_is_refused_with_the_place():
    eight = ring(lambda a: 50.0 + 0.0 * a, 12)
    points = np.array(eight.points[:12])
    points[:, 1] *= np.sign(points[:, 0])
    crossed = BSpline.closed(np.linspace(0.0, 1.0, 13), points, 3)
    with pytest.raises(OffsetError, match="crosses itself at"):
        offset_outline([SplinePiece(crossed)], 0.002, 1e-5)


@pytest.mark.kernel
def test_what_cannot_be_proven_is_an_error_and_no_result():
    # finer than the rounding of numbers
    with pytest.raises(ToolpathError):
        offset_spline(S_CURVE, 0.15, 1e-16)
    assert issubclass(GougeError, ToolpathError)
    assert issubclass(OffsetError, ToolpathError)
