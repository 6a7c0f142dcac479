"""Contours: made in every way, measured exactly, asked about points."""

from math import pi, sqrt, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.errors import ContourError
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.piece import ArcPiece, LinePiece
from splinearm.toolpaths.region import Region

pytestmark = pytest.mark.kernel

LENS = Contour(np.array([[-1.0, 0.0], [1.0, 0.0]]), np.array([tan(pi / 8), tan(pi / 8)]))


def wavy(seed, n=12, size=1.0):
    """A closed contour about the origin, every second segment an arc."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n
    radius = size * rng.uniform(0.7, 1.3, n)
    bulges = np.where(np.arange(n) % 2, 0.0, rng.uniform(-0.2, 0.2, n))
    return Contour(np.stack((radius * np.cos(angle), radius * np.sin(angle)), 1), bulges)


def test_a_circle_has_the_area_length_and_bounds_of_one():
    circle = Contour.circle([3.0, -1.0], 2.0)
    assert circle.area == pytest.approx(4.0 * pi, rel=1e-15)
    assert circle.length == pytest.approx(4.0 * pi, rel=1e-15)
    assert circle.bounds == pytest.approx((1.0, -3.0, 5.0, 1.0), abs=1e-14)
    assert Contour.circle([0, 0], 2.0, clockwise=True).area == pytest.approx(-4.0 * pi)


def test_a_lens_of_two_quarter_arcs_is_measured_exactly():
    # of the unit chord sqrt 2 r: each circular segment has r^2 (pi/4 - 1/2), with r = sqrt 2
    assert LENS.area == pytest.approx(2.0 * 2.0 * (pi / 4.0 - 0.5), rel=1e-14)
    assert LENS.length == pytest.approx(2.0 * sqrt(2.0) * pi / 2.0, rel=1e-14)
    height = sqrt(2.0) - 1.0
    assert LENS.bounds == pytest.approx((-1.0, -height, 1.0, height), abs=1e-15)


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.5])
def test_a_rounded_rectangle_misses_four_corners(radius):
    shape = Contour.rectangle([1.0, 2.0], [3.0, 1.0], radius)
    assert shape.area == pytest.approx(3.0 - (4.0 - pi) * radius**2, rel=1e-14)
    assert shape.bounds == pytest.approx((1.0, 2.0, 4.0, 3.0))
    assert (shape.lengths > 0.0).all()


@pytest.mark.parametrize("seed", range(4))
def test_area_length_and_bounds_are_those_of_many_chords(seed):
    shape = wavy(seed)
    points = shape.flattened(1e-7)
    after = np.roll(points, -1, axis=0)
    area = 0.5 * float((points[:, 0] * after[:, 1] - points[:, 1] * after[:, 0]).sum())
    assert shape.area == pytest.approx(area, abs=1e-6)
    assert shape.length == pytest.approx(np.hypot(*(after - points).T).sum(), abs=1e-5)
    low, high = points.min(axis=0), points.max(axis=0)
    assert shape.bounds == pytest.approx((*low, *high), abs=2e-7)


@pytest.mark.parametrize("seed", range(4))
def test_points_inside_and_distances_are_those_of_many_chords(seed):
    shapely = pytest.importorskip("shapely", reason="shapely is not installed")
    shape = wavy(seed)
    polygon = shapely.Polygon(shape.flattened(1e-7))
    points = np.random.default_rng(seed).uniform(-1.5, 1.5, (300, 2))
    theirs = shapely.points(points)
    far = shapely.distance(shapely.boundary(polygon), theirs)
    assert shape.distance(points) == pytest.approx(far, abs=2e-7)
    clear = far > 1e-6
    assert (shape.contains(points) == shapely.contains(polygon, theirs))[clear].all()


def test_points_on_chords_are_told_apart_from_points_beside_them():
    # the chords of these quarter arcs pass through the points asked
    circle = Contour.circle([0.0, 0.0], 1.0)
    grid = np.array([[x, y] for x in (-0.5, 0.0, 0.5) for y in (-0.5, 0.0, 0.5)])
    assert circle.contains(grid).all()
    turned = circle.transformed(angle=pi / 4)
    assert turned.contains(grid).all()
    assert not turned.contains(3.0 * grid[grid.any(axis=1)]).any()


@pytest.mark.property
@given(
    scale=st.sampled_from([1e-6, 0.5, 3.0, 1e6]),
    angle=st.floats(-7.0, 7.0),
    mirrored=st.booleans(),
    seed=st.integers(0, 20),
)
def test_a_similarity_scales_area_and_length_alone(scale, angle, mirrored, seed):
    shape = wavy(seed)
    moved = shape.transformed(scale=scale, angle=angle, shift=(scale, -scale), mirrored=mirrored)
    sign = -1.0 if mirrored else 1.0
    assert moved.area == pytest.approx(sign * scale**2 * shape.area, rel=1e-12)
    assert moved.length == pytest.approx(scale * shape.length, rel=1e-12)
    assert moved.reversed().area == pytest.approx(-moved.area, rel=1e-12)


def test_pieces_and_contours_turn_into_each_other():
    shape = Contour.rectangle([0.0, 0.0], [3.0, 2.0], 0.5)
    again = Contour.of_pieces(shape.pieces())
    assert again.closed
    assert np.allclose(again.vertices, shape.vertices)
    assert np.allclose(again.bulges, shape.bulges)
    whole = ArcPiece.about(np.array([0.0, 0.0]), 1.0, 0.3, 2.0 * pi)
    assert Contour.of_pieces([whole]).area == pytest.approx(pi)
    way = [LinePiece(np.array([0.0, 0.0]), np.array([1.0, 0.0]))]
    assert not Contour.of_pieces(way).closed


def test_an_open_contour_knows_its_distance_and_nothing_of_an_inside():
    bow = Contour(
        np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]]), np.array([1.0, 0.0]), closed=False
    )
    assert bow.length == pytest.approx(pi + 1.0)
    assert bow.bounds == pytest.approx((0.0, -1.0, 2.0, 1.0))
    # the way back from end to start is no part of it
    assert bow.distance([[1.0, 0.5], [1.0, -2.0]]) == pytest.approx([1.0, 1.0])
    back = bow.reversed()
    assert np.array_equal(back.vertices, bow.vertices[::-1])
    assert back.bulges.tolist() == [0.0, -1.0]
    for ask in (lambda: bow.area, lambda: bow.contains([0.0, 0.0]), lambda: bow.starting_at(1)):
        with pytest.raises(ValueError, match="open contour"):
            ask()


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Contour.polyline([[0, 0]]), "at least 2"),
        (lambda: Contour.polyline([[0, 0], [0, 0], [0, 0]]), "all of them"),
        (lambda: Contour(np.zeros((3, 2)), np.zeros(2)), "want 3"),
        (lambda: Contour.polyline([[0, 0], [np.nan, 1], [1, 1]]), "vertices|points"),
        (lambda: Contour.circle([0, 0], 0.0), "radius"),
        (lambda: Contour.rectangle([0, 0], [1, -1]), "size"),
        (lambda: Contour.rectangle([0, 0], [1, 1], 0.6), "radius: want 0 to 0.5"),
        (lambda: Contour.of_pieces([]), "at least one"),
        (lambda: LENS.transformed(scale=0.0), "scale"),
        (lambda: LENS.flattened(0.0), "tolerance"),
        (lambda: LENS.contains([1.0, 2.0, 3.0]), "shape"),
    ],
)
def test_what_cannot_be_a_contour_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_a_gap_between_pieces_is_refused_with_its_place():
    a = LinePiece(np.array([0.0, 0.0]), np.array([1.0, 0.0]))
    b = LinePiece(np.array([1.0, 0.1]), np.array([0.0, 0.0]))
    with pytest.raises(ValueError, match=r"number 1 begins 0.1 m"):
        Contour.of_pieces([a, b])


def test_a_region_is_what_its_islands_leave():
    region = Region(
        Contour.rectangle([0, 0], [4, 4]).reversed(),
        (Contour.circle([1, 1], 0.5), Contour.circle([3, 3], 0.5)),
    )
    assert region.area == pytest.approx(16.0 - pi / 2)
    assert region.outer.area > 0.0 > region.islands[0].area
    inside = region.contains([[1, 1], [2, 2], [5, 5]])
    assert inside.tolist() == [False, True, False]
    assert region.distance([2.0, 1.0]) == pytest.approx(0.5)
    assert region.transformed(scale=2.0, mirrored=True).area == pytest.approx(4.0 * region.area)
    assert region.length == pytest.approx(16.0 + 2.0 * pi)


def test_crossings_are_reported_with_coordinates():
    bow_tie = Contour.polyline([[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]])
    with pytest.raises(ContourError, match=r"segment . of the outer contour crosses") as caught:
        Region(bow_tie)
    assert caught.value.where == pytest.approx((1.0, 1.0))
    square = Contour.rectangle([0, 0], [4, 4])
    with pytest.raises(ContourError, match=r"outer contour crosses segment . of island 0"):
        Region(square, (Contour.circle([4, 2], 1.0),))
    with pytest.raises(ContourError, match="island 0 is not inside"):
        Region(square, (Contour.circle([9, 2], 1.0),))
    with pytest.raises(ContourError, match="is inside of island"):
        Region(square, (Contour.circle([2, 2], 1.0), Contour.circle([2, 2], 0.5)))
    with pytest.raises(ValueError, match="open"):
        Region(Contour.polyline([[0, 0], [1, 0]], closed=False))


@pytest.mark.parametrize("bulge", [0.0, 0.1])
def test_ways_that_cross_in_a_corner_of_both_are_refused_with_the_place(bulge):
    crossing = np.array([[0, 0], [5, 5], [10, 10], [10, 0], [5, 5], [0, 12]]) * 1e-3
    bulges = np.array([bulge, 0.0, 0.0, bulge, 0.0, 0.0])
    with pytest.raises(ContourError) as caught:
        Region(Contour(crossing, bulges))
    assert caught.value.where == pytest.approx((5e-3, 5e-3))
    touching = np.array([[0, 0], [5, 5], [10, 0], [10, 10], [5, 5], [0, 10]]) * 1e-3
    assert Region(Contour.polyline(touching)).area == pytest.approx(50e-6)


def test_an_island_that_leaves_through_corners_of_its_outline_is_refused():
    outline = Contour.polyline([[0, 0], [4, 0], [6, 0], [10, 0], [10, 10], [0, 10]])
    with pytest.raises(ContourError, match="crosses"):
        Region(outline, (Contour.polyline([[5, 2], [4, 0], [5, -1], [6, 0]]),))
    beside = Region(outline, (Contour.polyline([[5, 2], [4, 0], [6, 1]]),))
    assert beside.area == pytest.approx(100.0 - 1.5)


@pytest.mark.parametrize("corner", [[3.0, 0.0], [2.0, 3.0]])
def test_contours_that_share_a_part_of_an_edge_are_refused_with_the_place(corner):
    outline = Contour.rectangle([0.0, 0.0], [10.0, 10.0])
    islands = (Contour.rectangle([3.0, 5.0], [2.0, 2.0]), Contour.rectangle(corner, [4.0, 2.0]))
    with pytest.raises(ContourError, match="lies along") as caught:
        Region(outline, islands)
    assert caught.value.where == pytest.approx((5.0, 0.0) if corner[1] == 0.0 else (4.0, 5.0))


def test_round_islands_that_share_an_arc_are_refused_and_such_that_touch_are_not():
    outline = Contour.rectangle([-2.0, -2.0], [5.0, 4.0])
    ring, touching = Contour.circle([0.0, 0.0], 1.0), Contour.circle([2.0, 0.0], 1.0)
    bite = Contour(np.array([[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]), np.array([-tan(pi / 8), 0, 0]))
    with pytest.raises(ContourError, match="lies along"):
        Region(outline, (ring, bite))
    assert len(Region(outline, (ring, touching)).islands) == 2
