"""Pockets: nothing is gouged, nothing that the cutter reaches stays, links cross no wall."""

import math

import numpy as np
import pytest

from splinearm.errors import GougeError
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid
from splinearm.toolpaths.clearance import Wall
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.operation import Entry, Notes
from splinearm.toolpaths.pocket import pocket, pocket_runs
from splinearm.toolpaths.pocket_side import ContourSides
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.spiral import spiral
from splinearm.toolpaths.verify import verify
from splinearm.toolpaths.verify_part import Stock, Task, Zone
from splinearm.toolpaths.zigzag import facing, zigzag

NAMES = ("plate", "islands", "wedge", "bone", "star", "disc")
KINDS = {"pocket": pocket, "zigzag": zigzag, "spiral": spiral}
RADIUS = 2e-3

each_part = pytest.mark.parametrize("name", NAMES)
each_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)


def nearest(part, pieces):
    """Give how near pieces come to the contours of a part, by close looks along them."""
    looks = []
    for ax, ay, bx, by, k, *_ in pieces:
        bulge = 0.0
        if k:
            c = math.hypot(bx - ax, by - ay)
            bulge = math.tan(0.5 * math.asin(max(-1.0, min(1.0, 0.5 * k * c))))
        path = Contour(np.array([[ax, ay], [bx, by]]), np.array([bulge]), closed=False)
        looks.append(path.flattened(1e-6))
    places = np.concatenate(looks)
    assert part.contains(places).all()
    return float(part.distance(places).min())


@each_kind
@each_part
@pytest.mark.parametrize("percent", [45, 65, 100])
def test_a_pocket_is_cleared_and_not_gouged(kind, name, percent, parts, milling, checks):
    part = parts[name]
    milled = kind([part], milling(step_over=percent * 4e-5, climb=percent < 50))
    checks.follows(milled.actions)
    found = checks.cuts(milled.actions)
    assert nearest(part, found.below(0.0)) >= RADIUS - 2e-11
    assert checks.uncut(part, found.at(-2e-3), RADIUS, RADIUS) <= 1e-9
    for dialect in DIALECTS.values():
        assert write_checked(milled.actions, dialect)


@each_kind
@pytest.mark.parametrize("entry", list(Entry))
def test_every_way_into_a_pocket_stays_clear_and_reaches_the_depth(
    kind, entry, parts, milling, cuts, follows
):
    part = parts["islands"]
    setting = milling(depth=5e-3, entry=entry, stock=3e-4, finish=True, lead=1.5e-3)
    milled = kind([part], setting)
    follows(milled.actions)
    found = cuts(milled.actions)
    assert nearest(part, found.below(0.0)) >= RADIUS - 2e-11
    levels = {way.end[2] for way in found.ways if way.end[2] == way.start[2]}
    assert levels == {-5e-3 / 3, -5e-3 * 2 / 3, -5e-3}
    assert min(way.end[2] for way in found.ways) == -5e-3
    # what is rough keeps the stock, what is fine touches the wall
    assert nearest(part, found.at(-5e-3 / 3)) >= RADIUS + 3e-4 - 2e-11
    assert nearest(part, found.at(-5e-3)) == pytest.approx(RADIUS, abs=1e-10)
    # nothing goes down quicker than the cutter may
    for way in found.ways:
        fall = way.start[2] - way.end[2]
        if fall > 0.0:
            assert way.feed * fall / way.length <= setting.cutter.plunge * (1.0 + 1e-9)
            if entry is Entry.HELIX and way.start[2] < 0.0 and not milled.notes:
                steep = fall / math.sqrt(way.length**2 - fall**2)
                assert steep <= math.tan(setting.ramp_angle) * (1.0 + 1e-9)


@each_kind
def test_a_pocket_is_verified_by_code_that_did_not_make_it(kind, parts, milling):
    for name in ("plate", "islands"):
        setting = milling(depth=4e-3, entry=Entry.RAMP)
        milled = kind([parts[name]], setting)
        task = Task(
            Stock.about(parts[name], margin=0.01, thick=0.01),
            (Zone(regions=(parts[name],), floor=-4e-3),),
        )
        report = verify(milled.actions, task, setting.cutter)
        assert report.ok, report.text()


@pytest.mark.kernel
def test_rings_are_linked_where_that_is_clear(parts, milling):
    part = parts["plate"]
    setting = milling()
    (run,) = pocket_runs(ContourSides(part), setting, Notes())
    links = [track for track in run.tracks if track.link]
    assert len(links) == len(run.tracks) // 2
    for track in links:
        assert track.path.length == pytest.approx(setting.over, rel=1e-6)
    for one, two in zip(run.tracks, run.tracks[1:], strict=False):
        np.testing.assert_array_equal(one.path.vertices[-1], two.path.vertices[0])
    # from the inside to the outside
    lengths = [track.path.length for track in run.tracks if not track.link]
    assert lengths == sorted(lengths)


def test_no_link_crosses_a_wall(parts, milling, cuts):
    # a wall of 1 mm between two halves, and the island's two sides
    outer = Contour.rectangle([0.0, 0.0], [0.05, 0.03])
    thin = Contour.rectangle([0.024, 0.0045], [0.001, 0.02])
    part = Region(outer, (thin,))
    milled = pocket([part], milling())
    assert nearest(part, cuts(milled.actions).below(0.0)) >= RADIUS - 2e-11


@pytest.mark.parametrize("wide", [1.05, 1.3, 1.6, 2.0])
@each_part
def test_steps_above_the_radius_leave_no_ridges(name, wide, parts, milling, cuts, uncut):
    part = parts[name]
    milled = pocket([part], milling(step_over=wide * RADIUS))
    assert uncut(part, cuts(milled.actions).at(-2e-3), RADIUS, RADIUS) <= 1e-9


def test_wide_steps_cut_less_length(parts, milling):
    lengths = []
    for wide in (0.9, 1.4):
        milled = pocket([parts["plate"]], milling(step_over=wide * RADIUS))
        lengths.append(sum(a.length for a in milled.actions if isinstance(a, Feed | ArcFeed)))
    assert lengths[1] < 0.8 * lengths[0]


def test_climbing_has_the_wall_to_the_right_of_a_clockwise_cutter(parts, milling):
    sides = ContourSides(parts["plate"])
    for climb, speed, area in ((True, 100, 1), (False, 100, -1), (True, -100, -1)):
        runs = pocket_runs(sides, milling(climb=climb, speed=speed), Notes())
        for track in runs[0].tracks:
            if not track.link:
                around = Contour(track.path.vertices[:-1], track.path.bulges)
                assert around.area * area > 0.0


def test_the_edge_of_the_cutter_keeps_its_feed_on_inner_arcs(parts, milling, cuts):
    setting = milling()
    ways = cuts(pocket([parts["plate"]], setting).actions).ways
    arcs = [way for way in ways if isinstance(way, ArcFeed)]
    assert arcs
    for way in arcs:
        radius = way.radius_at_start
        edge = way.feed * (radius + RADIUS) / radius
        assert edge == pytest.approx(setting.cutter.feed, rel=1e-6)
    assert max(way.feed for way in ways) <= setting.cutter.feed


def test_what_is_too_narrow_is_told(parts, milling):
    milled = pocket([parts["plate"], parts["disc"]], milling(diameter=30e-3, step_over=5e-3))
    assert any("too narrow" in note for note in milled.notes)
    assert milled.actions
    tiny = Region(Contour.circle([0.0, 0.0], 1e-3))
    for kind in (pocket, zigzag, spiral):
        assert "too narrow" in kind([tiny], milling()).notes[-1]


def test_a_spiral_is_one_way_without_lifting(parts, milling):
    for name in ("plate", "disc"):
        milled = spiral([parts[name]], milling())
        rapids = [a for a in milled.actions if isinstance(a, Rapid)]
        assert len(rapids) <= 4
    assert any("islands" in note for note in spiral([parts["islands"]], milling()).notes)


@pytest.mark.parametrize("angle", [0.0, 0.5, -1.2])
def test_lines_to_and_fro_may_have_any_direction(angle, parts, milling, cuts, uncut):
    part = parts["star"]
    milled = zigzag([part], milling(step_over=3.6e-3), angle)
    found = cuts(milled.actions)
    assert nearest(part, found.below(0.0)) >= RADIUS - 2e-11
    assert uncut(part, found.at(-2e-3), RADIUS, RADIUS) <= 1e-9


def test_facing_takes_all_of_a_face(parts, milling, cuts):
    part = parts["wedge"]
    milled = facing([part], milling(step_over=3.5e-3, depth=5e-4), 0.3)
    pieces = cuts(milled.actions).at(-5e-4)
    rng = np.random.default_rng(5)
    points = rng.uniform([0, 0], [0.06, 0.025], (4000, 2))
    points = np.concatenate((points[part.contains(points)], part.outer.vertices))
    from splinearm.toolpaths.contour_kernel import distances

    found = np.empty(len(points))
    distances(pieces, points, found)
    assert found.max() <= RADIUS


def test_ways_that_gouge_are_refused(parts):
    wall = Wall.of(parts["plate"].contours, RADIUS)
    inside = Contour.polyline([[0.01, 0.01], [0.05, 0.03]], closed=False)
    wall.require_clear([inside])
    wall.require_clear([])
    with pytest.raises(GougeError) as caught:
        wall.require_clear([Contour.polyline([[0.01, 0.0015], [0.05, 0.03]], closed=False)])
    assert caught.value.depth == pytest.approx(0.5e-3)
    assert not wall.is_clear(np.array([0.01, 0.01]), np.array([0.01, 0.05]))
    assert wall.is_clear(np.array([0.01, 0.01]), np.array([0.01, 0.01]))


@pytest.mark.parametrize("kind", [pocket, zigzag, spiral, facing])
def test_a_pocket_wants_parts(kind, milling):
    with pytest.raises(ValueError, match="parts"):
        kind([], milling())
