"""Corners that are not round, ends of paths, and contours that run along themselves."""

from math import pi

import numpy as np
import pytest

from splinearm.errors import ContourError, OffsetError
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.offset import offset, offset_path, widened
from splinearm.toolpaths.region import Region

pytestmark = pytest.mark.kernel


def area(regions):
    return sum(region.area for region in regions)


@pytest.mark.parametrize("largest", [200, pytest.param(2000, marks=pytest.mark.slow)])
def test_mitres_of_lines_have_the_area_that_shapely_gives_them(largest):
    geometry = pytest.importorskip("shapely.geometry", reason="shapely is not installed")
    rng = np.random.default_rng(3)
    for _ in range(largest // 10):
        n = int(rng.integers(4, 40))
        angle = 2.0 * pi * (np.arange(n) + rng.uniform(-0.4, 0.4, n)) / n
        points = rng.uniform(0.6, 1.4, n)[:, None] * np.stack((np.cos(angle), np.sin(angle)), 1)
        # a limit that no corner comes to: what is cut there is cut elsewhere by others
        wanted = geometry.Polygon(points)
        d = float(rng.uniform(0.01, 0.05))
        ours = area(offset(Contour.polyline(points), d, corner="mitre", mitre_limit=1e3))
        theirs = wanted.buffer(d, join_style="mitre", mitre_limit=1e3).area
        assert ours == pytest.approx(theirs, rel=1e-9)


def test_a_corner_that_reaches_through_a_wall_leaves_nothing_outside():
    # the tip of the island's corner lies beyond the wall
    spear = Contour.polyline([[0.0, 0.0], [1.0, -0.4], [1.0, 0.4]])
    part = Region(Contour.rectangle([-0.1, -2.0], [4.0, 4.0]), (spear,))
    (found,) = offset(part, -0.3, corner="mitre", mitre_limit=5.0)
    assert found.bounds == pytest.approx((0.2, -1.7, 3.6, 1.7))


# ends


def slot_by_shapely(points, d, end, corner):
    geometry = pytest.importorskip("shapely.geometry", reason="shapely is not installed")
    style = {"butt": "flat"}.get(end, end)
    return geometry.LineString(points).buffer(
        d, cap_style=style, join_style=corner, mitre_limit=1e3, quad_segs=2000
    )


@pytest.mark.parametrize("end", ["round", "butt", "square"])
@pytest.mark.parametrize("corner", ["round", "mitre"])
def test_slots_end_as_those_of_shapely_do(end, corner):
    rng = np.random.default_rng(1)
    for _ in range(12):
        points = np.cumsum(rng.uniform(0.2, 1.0, (6, 2)) * [1.0, rng.choice([-1.0, 1.0])], axis=0)
        points[:, 1] += rng.uniform(-0.3, 0.3, 6)
        path = Contour.polyline(points, closed=False)
        found = widened(path, 0.08, end=end, corner=corner, mitre_limit=1e3)
        wanted = slot_by_shapely(points, 0.08, end, corner).area
        assert area(found) == pytest.approx(wanted, rel=1e-5 if "round" in (end, corner) else 1e-9)


def test_slots_of_a_line_end_round_square_or_flat():
    line = Contour.polyline([[0, 0], [1, 0]], closed=False)
    for end, wanted in (("round", 0.2 + pi * 0.01), ("square", 0.24), ("butt", 0.2)):
        (slot,) = widened(line, 0.1, end=end)
        assert slot.area == pytest.approx(wanted, rel=1e-13)
        assert len(slot.outer.vertices) == 4
    # also of one that is shorter than it is wide
    (slot,) = widened(Contour.polyline([[0, 0], [0.1, 0]], closed=False), 0.1, end="butt")
    assert slot.area == pytest.approx(0.02, rel=1e-13)


def test_arcs_end_square_but_want_a_line_to_end_flat():
    arc = Contour(np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([0.4]), closed=False)
    (slot,) = widened(arc, 0.1, end="square")
    assert slot.area == pytest.approx(0.2 * arc.length + 2.0 * 0.02, rel=1e-12)
    with pytest.raises(OffsetError, match="flat end wants a straight line"):
        widened(arc, 0.1, end="butt")
    short = Contour.polyline([[0, 0], [1, 0], [1, 0.05]], closed=False)
    with pytest.raises(OffsetError, match=r"1000, 50"):
        widened(short, 0.1, end="butt")


@pytest.mark.parametrize("d", [0.1, -0.1])
def test_ways_beside_a_path_end_beside_it_or_go_on_until_they_are_ahead(d):
    path = Contour.polyline([[0, 0], [1, 0], [1, 1], [2, 1]], closed=False)
    (beside,) = offset_path(path, d)
    for end, more in (("round", 2.0 * 0.1 * pi / 2.0), ("square", 4.0 * 0.1)):
        (way,) = offset_path(path, d, end=end)
        assert way.vertices[[0, -1]] == pytest.approx(np.array([[-0.1, 0], [2.1, 1]]), abs=1e-14)
        assert way.length == pytest.approx(beside.length + more, rel=1e-13)
        assert not way.closed
    assert offset_path(path, d, end="butt")[0].length == pytest.approx(beside.length)


def test_ends_have_names():
    path = Contour.polyline([[0, 0], [1, 0]], closed=False)
    for door in (offset_path, widened):
        with pytest.raises(ValueError, match="one of round, butt, square, got 'flat'"):
            door(path, 0.1, end="flat")


# ways along each other


def outline(*more):
    return Contour.polyline([[0, 0], [4, 0], [4, 4], [2, 4], *more, [2, 4], [0, 4]])


def test_ways_along_each_other_may_part_again_to_the_same_side():
    Region(outline([2, 2]))  # a slit
    Region(outline([2, 3], [3, 2], [1, 2], [2, 3]))  # and an island at its end
    Region(outline([2, 3.5], [2, 3], [3, 2], [1, 2], [2, 3]))


def test_ways_along_each_other_that_part_to_the_other_side_cross():
    wrong_way = [[2, 3], [1, 2], [3, 2], [2, 3]]
    for ways in (wrong_way, [[2, 3.5], *wrong_way]):
        with pytest.raises(
            ContourError, match=r"runs along .* and crosses it at \(2000, [34]000\)"
        ):
            Region(outline(*ways))
    eight = [(0, 0), (1, 0), (2, 0), (3, -1), (3, 1.5), (2, 2), (2, 0), (1, 0), (0, -1), (-1, 0.5)]
    with pytest.raises(ContourError, match="runs along"):
        Region(Contour.polyline(eight))
