"""Offsets: right wherever they can be checked by something else, and the same from every side."""

from math import pi, sqrt, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import ContourError
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.offset import Offsets, offset, offset_path, rings, widened
from splinearm.toolpaths.region import Region

pytestmark = pytest.mark.kernel


def star(n, seed, radius=0.1, rough=0.1):
    """A star-shaped contour whose every second segment is an arc, not crossing itself."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    far = np.ones(n)
    for k in range(2, 7):
        far += 0.25 / k * rng.uniform(-1, 1) * np.cos(k * angle + rng.uniform(0.0, 6.3))
    far *= radius * (1.0 + rough * min(1.0, 40.0 / n) * rng.uniform(-1, 1, n))
    points = far[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    bulges = np.where(np.arange(n) % 2, 0.0, rng.uniform(-0.4, 0.4, n))
    for _ in range(30):
        try:
            return Region(Contour(points, bulges)).outer
        except ContourError:
            bulges = 0.7 * bulges
    raise AssertionError("no valid star")


def pocket(n, seed):
    """A star with islands in it if the seed is odd."""
    rng = np.random.default_rng(seed)
    outer, islands = star(n, seed, rough=rng.uniform(0.02, 0.25)), []
    for _ in range(20 * (seed % 2)):
        where = rng.uniform(-0.05, 0.05, 2)
        island = star(max(4, n // 8), seed, radius=rng.uniform(0.004, 0.02))
        try:
            Region(outer, (*islands, island.transformed(shift=where)))
        except ContourError:
            continue
        islands.append(island.transformed(shift=where))
        if len(islands) == 4:
            break
    return Region(outer, tuple(islands))


def summary(regions):
    """Count, area and length."""
    contours = sum(len(region.contours) for region in regions)
    return len(regions), contours, sum(r.area for r in regions), sum(r.length for r in regions)


def same(one, other, scale=1.0):
    assert one[:2] == other[:2]
    assert other[2] == pytest.approx(scale**2 * one[2], rel=1e-9, abs=1e-13 * scale**2)
    assert other[3] == pytest.approx(scale * one[3], rel=1e-8, abs=1e-10 * scale)


# by hand


def test_a_square_grows_by_its_sides_and_a_disc():
    square = Contour.rectangle([0.0, 0.0], [1.0, 1.0])
    (grown,) = offset(square, 0.25)
    assert grown.area == pytest.approx(1.0 + 4 * 0.25 + pi * 0.25**2, rel=1e-14)
    assert len(grown.outer.vertices) == 8
    assert sorted(set(np.round(grown.outer.bulges, 14))) == [0.0, round(tan(pi / 8), 14)]
    (shrunk,) = offset(square, -0.25)
    assert len(shrunk.outer.vertices) == 4
    assert shrunk.area == pytest.approx(0.25, rel=1e-14)


def test_corners_may_be_mitred_or_cut_off():
    square = Contour.rectangle([0.0, 0.0], [1.0, 1.0])
    (mitred,) = offset(square, 0.25, corner="mitre")
    assert len(mitred.outer.vertices) == 4
    assert mitred.area == pytest.approx(1.5**2, rel=1e-14)
    cut = 0.25 * sqrt(2.0) - 0.25  # what a chamfer at the distance leaves of the diagonal
    for way in ({"corner": "chamfer"}, {"corner": "mitre", "mitre_limit": 1.2}):
        (chamfered,) = offset(square, 0.25, **way)
        assert len(chamfered.outer.vertices) == 8
        assert chamfered.area == pytest.approx(1.5**2 - 4 * cut**2, rel=1e-13)


def test_arcs_stay_arcs_and_those_that_shrink_to_nothing_go():
    rounded = Contour.rectangle([0.0, 0.0], [3.0, 2.0], 0.5)
    for d, count in ((0.3, 8), (-0.3, 8), (-0.5, 4), (-0.6, 4)):
        (result,) = offset(rounded, d)
        assert len(result.outer.vertices) == count
        radius = max(0.0, 0.5 + d)
        wanted = (3.0 + 2 * d) * (2.0 + 2 * d) - (4.0 - pi) * radius**2
        assert result.area == pytest.approx(wanted, rel=1e-13)


@pytest.mark.parametrize("share", [1.0, 1.0 - 1e-13, 1.0 + 1e-13, 1.2])
def test_what_is_as_narrow_as_twice_the_distance_vanishes(share):
    for shape in (
        Contour.rectangle([0, 0], [1, 1]),
        Contour.rectangle([0, 0], [2, 1]),
        Contour.rectangle([0, 0], [3, 1], 0.5),
        Contour.circle([0.3, 0.1], 0.5),
    ):
        assert offset(shape, -0.5 * share) == ()


@pytest.mark.parametrize("off", [0.0, 1e-13, -1e-13, 1e-9])
def test_a_neck_of_twice_the_distance_parts_two_rooms(off):
    rooms = [(0, 0), (1, 0), (1, 0.4), (2, 0.4), (2, 0), (3, 0)]
    rooms += [(3 - x, 1 - y) for x, y in rooms]
    regions = offset(Contour.polyline(rooms), -0.1 - off)
    assert len(regions) == 2
    # each is a square of 0.8 with two arcs about the corners of the neck
    corner = 0.1**2 * (1.0 - pi / 4.0)
    for region in regions:
        assert region.area == pytest.approx(0.8**2 + 2.0 * corner, abs=2e-9 + 5.0 * abs(off))


def test_a_neck_a_little_wider_is_kept():
    rooms = [(0, 0), (1, 0), (1, 0.4), (2, 0.4), (2, 0), (3, 0)]
    rooms += [(3 - x, 1 - y) for x, y in rooms]
    assert len(offset(Contour.polyline(rooms), -0.1 + 1e-8)) == 1


def test_islands_that_grow_until_they_touch_close_what_is_between_them():
    region = Region(
        Contour.rectangle([0, 0], [4, 4]),
        (Contour.circle([1, 2], 0.5), Contour.circle([3, 2], 0.5)),
    )
    assert [len(r.contours) for r in offset(region, -0.25)] == [1]
    assert [len(r.contours) for r in offset(region, -0.2)] == [3]
    assert [len(r.contours) for r in offset(region, -0.5)] == [1, 1]
    assert [len(r.contours) for r in offset(region, 0.5)] == [1]


def test_a_grid_of_islands_just_touching():
    spots = [(i + 0.5, j + 0.5) for i in range(4) for j in range(4)]
    islands = tuple(Contour.circle(spot, 0.25) for spot in spots)
    region = Region(Contour.rectangle([0, 0], [4, 4]), islands)
    parts = offset(region, -0.25)
    # squares of 1 without four quarter discs, and what is left along the sides closes
    square = 1.0 - pi * 0.25
    assert sum(abs(r.area - square) < 1e-12 for r in parts) == 9


# against theory


@pytest.mark.property
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), d=st.floats(1e-3, 10.0), n=st.integers(3, 30))
def test_a_convex_contour_grows_as_minkowski_says_and_shrinks_back(seed, d, n):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0.0, 2.0 * pi, n))
    gaps = np.diff(np.append(angle, angle[0] + 2.0 * pi))
    if gaps.max() > 2.8 or gaps.min() < 1e-3:
        return
    points = np.stack((np.cos(angle), 0.7 * np.sin(angle)), axis=1)
    convex = Contour(points, np.where(rng.uniform(size=n) < 0.5, 0.0, 0.2 * np.tan(gaps / 4.0)))
    (grown,) = offset(convex, d)
    assert grown.area == pytest.approx(convex.area + convex.length * d + pi * d * d, rel=1e-12)
    assert grown.length == pytest.approx(convex.length + 2.0 * pi * d, rel=1e-12)
    (again,) = offset(grown, -d)
    assert again.area == pytest.approx(convex.area, rel=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_result_is_the_same_however_the_part_is_given(seed):
    part = star(24, seed)
    d = (-0.004, -0.02, 0.01)[seed % 3]
    wanted = summary(offset(part, d))
    for vertex in range(0, 24, 1 if seed == 0 else 5):
        same(wanted, summary(offset(part.starting_at(vertex), d)))
    same(wanted, summary(offset(part.reversed(), d)))
    for scale in (1e-6, 1e-3, 7.0, 1e6):
        for angle, shift in ((0.0, (0.0, 0.0)), (0.7, (scale, -3.0 * scale))):
            moved = part.transformed(scale=scale, angle=angle, shift=shift)
            same(wanted, summary(offset(moved, scale * d)), scale)
    same(wanted, summary(offset(part.transformed(mirrored=True), d)))


def test_a_closed_contour_may_have_segments_without_length_and_corners_without_a_turn():
    xs = np.linspace(0.0, 1.0, 11)
    busy = [(x, 0.0) for x in xs] + [(1, 1), (1, 1), (0.5, 1), (0.5, 1), (0, 1), (0, 1 - 1e-15)]
    for d in (-0.2, 0.2):
        plain = summary(offset(Contour.rectangle([0, 0], [1, 1]), d))
        same(plain, summary(offset(Contour.polyline(busy), d)))


@pytest.mark.parametrize("d", [-0.4, -0.1, 0.3])
def test_arcs_that_are_nearly_straight_are_nearly_lines(d):
    bulges = np.array([1e-9, 1e-12, -1e-8, 1e-15])
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    plain = summary(offset(Contour.polyline(square), d))
    bent = summary(offset(Contour(np.array(square, float), bulges), d))
    assert bent[:2] == plain[:2]
    assert bent[2] == pytest.approx(plain[2], abs=1e-7)


@pytest.mark.parametrize("count", [30, 300])
def test_a_circle_of_many_arcs_is_a_circle(count):
    t = 2.0 * pi * np.arange(count) / count
    many = Contour(np.stack((np.cos(t), np.sin(t)), 1), np.full(count, tan(pi / (2 * count))))
    for d in (-0.9, -0.3, 0.5):
        (result,) = offset(many, d)
        assert result.area == pytest.approx(pi * (1.0 + d) ** 2, rel=1e-11)


# against clipper


def by_clipper(pyclipr, region, d, tolerance):
    """Area and count of contours by Clipper2, arcs as chords."""
    work = pyclipr.ClipperOffset()
    work.scaleFactor = int(1e8)
    work.arcTolerance = tolerance * 1e8
    paths = [contour.flattened(tolerance) for contour in region.contours]
    work.addPaths(paths, pyclipr.JoinType.Round, pyclipr.EndType.Polygon)
    found = work.execute(d)
    area = 0.0
    for path in found:
        x, y = path[:, 0], path[:, 1]
        area += 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    return area, len(found)


def agrees_with_clipper(pyclipr, seed, largest):
    rng = np.random.default_rng(seed)
    part = pocket(int(10 * (largest / 10) ** rng.uniform()), seed)
    x0, y0, x1, y1 = part.bounds
    share = np.exp(rng.uniform(np.log(1e-4), np.log(0.5)))
    d = share * min(x1 - x0, y1 - y0) * (1 if rng.uniform() < 0.25 else -1)
    _, contours, area, length = summary(offset(part, d))
    tolerance = 1e-6
    theirs, count = by_clipper(pyclipr, part, d, tolerance)
    assert area == pytest.approx(theirs, abs=4.0 * tolerance * (length + part.length) + 1e-9)
    return contours == count


@pytest.mark.parametrize("first", range(0, 30, 10))
def test_random_pockets_agree_with_clipper(first):
    pyclipr = pytest.importorskip("pyclipr", reason="pyclipr is not installed")
    agree = [agrees_with_clipper(pyclipr, seed, 200) for seed in range(first, first + 10)]
    assert sum(agree) >= 9  # what is as narrow as its tolerance may be there or not


def test_rings_are_offsets_of_the_part_itself():
    part = pocket(40, 3)
    steps = [-0.002 * k for k in range(1, 8)]
    for d, regions in zip(steps, rings(part, steps), strict=True):
        same(summary(offset(part, d)), summary(regions))
    assert Offsets(part).at(0.0) == (part,)


# paths


def test_a_path_is_followed_to_its_left_and_its_right():
    path = Contour.polyline([[0, 0], [1, 0], [1, 1], [2, 1]], closed=False)
    (left,) = offset_path(path, 0.1)
    assert not left.closed
    assert left.vertices[[0, -1]] == pytest.approx(np.array([[0, 0.1], [2, 1.1]]), abs=1e-15)
    # shorter by d before the inner corner and behind it, longer by the arc about the outer one
    assert left.length == pytest.approx(3.0 - 0.2 + 0.1 * pi / 2)
    (right,) = offset_path(path, -0.1)
    assert right.vertices[[0, -1]] == pytest.approx(np.array([[0, -0.1], [2, 0.9]]), abs=1e-15)
    assert right.length == pytest.approx(left.length)
    for way in (left, right):
        assert path.distance(way.flattened(1e-4)) == pytest.approx(0.1, abs=1.1e-4)


def test_a_path_that_passes_itself_too_near_is_left_out_there():
    turns = np.array([[np.cos(k * pi) * (1.0 + 0.1 * k), 0.0] for k in range(8)])
    spiral = Contour(turns, np.full(7, 1.0), closed=False)
    (near,) = offset_path(spiral, 0.05)
    assert near.length > 0.9 * spiral.length
    (rest,) = offset_path(spiral, 0.11)
    assert rest.length < 0.5 * spiral.length
    assert spiral.distance(rest.flattened(1e-5)).min() > 0.11 - 1.1e-5


def test_a_closed_path_has_an_inside_and_an_outside():
    circle = Contour.circle([0, 0], 1.0)
    for path, sign in ((circle, 1.0), (circle.reversed(), -1.0)):
        (inner,) = offset_path(path, sign * 0.25)
        (outer,) = offset_path(path, -sign * 0.25)
        assert inner.area == pytest.approx(sign * pi * 0.75**2)
        assert outer.area == pytest.approx(sign * pi * 1.25**2)
    assert offset_path(circle, 0.0) == (circle,)


def test_a_widened_path_is_a_slot_with_round_ends():
    line = Contour.polyline([[0, 0], [1, 0]], closed=False)
    (slot,) = widened(line, 0.1)
    assert slot.area == pytest.approx(0.2 + pi * 0.01, rel=1e-13)
    bent = Contour.polyline([[0, 0], [1, 0], [1, 1]], closed=False)
    (mitred,) = widened(bent, 0.1, corner="mitre")
    assert mitred.area == pytest.approx(0.2 * 2.0 + pi * 0.01, rel=1e-13)


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (lambda: offset(Contour.polyline([[0, 0], [1, 0]], closed=False), 0.1), "open"),
        (lambda: offset(Contour.circle([0, 0], 1.0), np.nan), "finite"),
        (lambda: offset(Contour.circle([0, 0], 1.0), 0.1, corner="square"), "one of round, mitre"),
        (lambda: offset(Contour.circle([0, 0], 1.0), 0.1, mitre_limit=0.5), "mitre_limit"),
        (lambda: widened(Contour.circle([0, 0], 1.0), 0.1), "want an open one"),
        (lambda: widened(Contour.polyline([[0, 0], [1, 0]], closed=False), -0.1), "above zero"),
    ],
)
def test_what_cannot_be_offset_is_refused(ask, says):
    with pytest.raises(ValueError, match=says):
        ask()


def test_the_mitres_of_near_parts_join():
    # the corner of one island reaches beyond the offset of another's side
    spear = Contour.polyline([[0.0, 0.0], [1.0, -0.4], [1.0, 0.4]])
    wall = Contour.rectangle([-0.45, -1.0], [0.2, 2.0])
    part = Region(Contour.rectangle([-3, -3], [6, 6]), (spear, wall))
    (sharp,) = offset(part, -0.12, corner="mitre", mitre_limit=4.0)
    (blunt,) = offset(part, -0.12)
    assert (len(sharp.contours), len(blunt.contours)) == (2, 3)
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (4000, 2))
    # a mitre takes whatever a round corner takes
    assert (blunt.contains(points) | ~sharp.contains(points)).all()
    assert sharp.area < blunt.area


def test_an_arc_of_nearly_a_full_turn_reaches_far_beyond_its_ends():
    gap = 1e-3
    turn = 2.0 * pi - 2.0 * np.arcsin(gap / 2.0)
    keyhole = Contour(np.array([[0.0, 0.0], [0.0, gap]]), np.array([tan(turn / 4), 0.0]))
    assert keyhole.bounds[2] - keyhole.bounds[0] == pytest.approx(2.0, abs=1e-6)
    (result,) = offset(keyhole, -0.5)
    assert result.area == pytest.approx(pi * 0.25, rel=1e-3)
    (grown,) = offset(keyhole, 30.0)
    assert grown.area == pytest.approx(pi * 31.0**2, rel=1e-3)


def test_cusps_point_inwards_or_outwards():
    # an arbelos: where its arcs touch it ends in cusps, the middle one is the part's own
    arbelos = Contour(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), np.array([1.0, 1.0, -1.0]))
    assert abs(arbelos.area) == pytest.approx(pi / 4.0)
    (inner,) = offset(arbelos, -0.1)
    assert len(inner.outer.vertices) == 3
    assert arbelos.distance(inner.outer.flattened(1e-6)).min() > 0.1 - 2e-6
    (outer,) = offset(arbelos, 0.1)
    assert outer.area > abs(arbelos.area)


@pytest.mark.parametrize("share", [1e-8, -1e-8, -1e-12, 1e3])
def test_distances_may_be_very_small_and_very_large(share):
    (result,) = offset(Contour.rectangle([0, 0], [1, 1]), share)
    round_part = pi * share**2 if share > 0.0 else 4.0 * share**2
    assert result.area == pytest.approx(1.0 + 4.0 * share + round_part, rel=1e-11)
