"""Profiles along splines as splines: beside them by the radius, and written as such."""

from dataclasses import replace
from itertools import pairwise
from math import pi

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.curves.curvature import curvature
from splinearm.errors import GougeError
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, SplineFeed
from splinearm.toolpaths.checking import verified
from splinearm.toolpaths.drawing import Drawing, Drawn
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.operation import Entry, Side
from splinearm.toolpaths.piece import SplinePiece
from splinearm.toolpaths.profile_spline import spline_profile
from splinearm.toolpaths.shape import ellipse_piece
from splinearm.toolpaths.tab import Tabs
from splinearm.toolpaths.wire import Wire
from splinearm.toolpaths.work import Exactness, Kind, Work, carry_out

TOLERANCE = 1e-5
RADIUS = 2e-3


@pytest.fixture
def oval():
    """Give an oval plate of 60 x 40 mm with an oval opening."""
    middle = np.array([0.03, 0.02])
    sizes = ((0.03, 0.02), (0.012, 0.008))
    axes = [(np.array([a, 0.0]), np.array([0.0, b])) for a, b in sizes]
    pieces = [ellipse_piece(middle, major, minor, 0.0, 2.0 * pi) for major, minor in axes]
    drawn = tuple(Drawn(piece, "cut") for piece in pieces)
    return Drawing(file="oval.dxf", unit="mm", drawn=drawn, left_out={})


@pytest.fixture
def star():
    """Give a star of 150 mm, one closed spline, with a peanut as its opening."""
    drawn = [ring(lambda a: 55.0 + 20.0 * np.cos(5.0 * a), 20)]
    drawn.append(ring(lambda a: 14.0 + 8.0 * np.cos(2.0 * a), 12))
    pieces = tuple(Drawn(SplinePiece(curve), "cut") for curve in drawn)
    return Drawing(file="star.dxf", unit="mm", drawn=pieces, left_out={})


def ring(radius, count):
    a = 2.0 * pi * np.arange(count) / count
    points = 1e-3 * radius(a)[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    return BSpline.closed(np.linspace(0.0, 1.0, count + 1), points, 3)


def profile_of(drawing, milling, side, splines=True, tabs=None):
    work = Work(kind=Kind.PROFILE, milling=milling, side=side, tabs=tabs)
    return carry_out(drawing, [work], Exactness(tolerance=TOLERANCE, splines=splines))


def directions(way):
    """Give the directions in which a way begins and ends, in the plane."""
    if isinstance(way, ArcFeed):
        sides = np.sign(way.turn) * np.array([way.start - way.centre, way.end - way.centre])
        ways = np.column_stack((-sides[:, 1], sides[:, 0]))
    else:
        ways = way.curve.at(np.array(way.curve.domain), 1)[:, :2]
    return ways / np.hypot(*ways.T)[:, None]


def source(drawing, count=4001):
    return [
        each.piece.curve.at(np.linspace(*each.piece.curve.domain, count)) for each in drawing.drawn
    ]


def gap(places, looks):
    return np.sqrt(((places[:, None] - looks) ** 2).sum(axis=2)).min(axis=1)


@pytest.mark.parametrize("side", [Side.OUTSIDE, Side.INSIDE])
def test_the_cutter_stays_beside_the_curve_by_its_radius(oval, milling, side):
    actions, done = profile_of(oval, milling(), side)
    ways = [a for a in actions if isinstance(a, SplineFeed)]
    assert ways
    assert not any(isinstance(a, ArcFeed) for a in actions)
    looks = np.vstack(source(oval))
    for way in ways:
        spans = [np.linspace(a, b, 9) for a, b in pairwise(way.curve.breaks)]
        places = way.curve.at(np.concatenate(spans))[:, :2]
        far = gap(places, looks)
        # the looks are 0.03 mm apart, which makes a distance of 2 mm too large by 0.06 um at most
        assert RADIUS - 1e-9 <= far.min() <= far.max() <= RADIUS + TOLERANCE + 1e-7
    report = verified(actions, done, TOLERANCE)
    assert report is not None
    assert report.ok, report.text()


@pytest.mark.parametrize(("side", "climb"), [(Side.OUTSIDE, True), (Side.INSIDE, False)])
def test_it_cuts_in_the_direction_that_is_asked_for(oval, milling, side, climb):
    actions, _ = profile_of(oval, milling(climb=climb), side)
    (plain, _) = profile_of(oval, milling(climb=climb), side, splines=False)

    def turning(ways):
        places = np.vstack([w.start[:2] for w in ways])
        x, y = (places - places.mean(axis=0)).T
        return np.sign(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))

    def loops(actions):
        found, ways = [], []
        for action in actions:
            if isinstance(action, SplineFeed | ArcFeed) or (
                isinstance(action, Feed) and action.start[2] == action.end[2]
            ):
                ways.append(action)
            elif ways:
                found.append(ways)
                ways = []
        return found

    wanted = sorted(turning(ways) for ways in loops(plain))
    pieces = [
        [SplineFeed(start=np.append(p, 0.0), end=w.end, curve=w.curve, feed=1.0) for w in ways
         for p in w.curve.at(np.linspace(*w.curve.domain, 50))[:, :2]]
        for ways in loops(actions)
    ]  # fmt: skip
    assert sorted(turning(ways) for ways in pieces) == wanted


def test_stock_is_left_and_taken_off_in_the_end(oval, milling):
    actions, done = profile_of(oval, milling(stock=3e-4, finish=True, depth=5e-3), Side.OUTSIDE)
    looks = np.vstack(source(oval))
    ways = [a for a in actions if isinstance(a, SplineFeed)]
    first, last = (
        gap(way.curve.at(np.linspace(*way.curve.domain, 50))[:, :2], looks).min()
        for way in (ways[0], ways[-1])
    )
    assert first == pytest.approx(RADIUS + 3e-4, abs=2e-5)
    assert last == pytest.approx(RADIUS, abs=2e-5)
    report = verified(actions, done, TOLERANCE)
    assert report is not None
    assert report.ok, report.text()


def test_a_program_has_splines_where_the_controller_has_them(oval, milling):
    with_splines, _ = profile_of(oval, milling(), Side.OUTSIDE)
    without, _ = profile_of(oval, milling(), Side.OUTSIDE, splines=False)
    text = write_checked(with_splines, DIALECTS["linuxcnc"])
    assert text.count("G5 ") > 4
    assert "G5 " not in write_checked(without, DIALECTS["grbl"])


@pytest.mark.parametrize("entry", [Entry.PLUNGE, Entry.RAMP])
def test_on_the_line_the_splines_themselves_are_followed(star, milling, entry, proven):
    tabs = Tabs(count=2, length=3e-3, height=1e-3)
    for held in (None, tabs):
        actions, done = profile_of(star, milling(entry=entry), Side.ON, tabs=held)
        proven(actions, done, TOLERANCE)
        assert done[0].aim.slack <= 1e-7
        ways = [a.curve for a in actions if isinstance(a, SplineFeed)]
        lines = [each.piece.curve for each in star.drawn]
        assert sum(c.length() for c in ways) == pytest.approx(
            sum(c.length() for c in lines), rel=1e-9
        )
        heights = {float(z) for curve in ways for z in curve.points[:, 2]}
        assert heights == ({-2e-3} if held is None else {-2e-3, -1e-3})


def parts_near_each_other(apart):
    """Give two ovals of 20 x 19 mm whose edges are that far apart, m."""
    axes = np.array([0.01, 0.0]), np.array([0.0, 0.0095])
    middles = (np.zeros(2), np.array([0.02 + apart, 0.0]))
    return [(Wire((ellipse_piece(each, *axes, 0.0, 2.0 * pi),), True),) for each in middles]


@pytest.mark.parametrize(
    ("side", "entry", "tabs"),
    [
        (Side.OUTSIDE, Entry.PLUNGE, Tabs(count=3, length=4e-3, height=1e-3)),
        (Side.OUTSIDE, Entry.RAMP, Tabs(count=2, length=3e-3, height=1.2e-3)),
        (Side.INSIDE, Entry.RAMP, None),
        (Side.OUTSIDE, Entry.HELIX, None),
    ],
)
def test_leads_entries_and_tabs_keep_the_splines(star, milling, side, entry, tabs, proven):
    setting = milling(depth=3e-3, entry=entry, lead=2e-3)
    actions, done = profile_of(star, setting, side, tabs=tabs)
    text = proven(actions, done, TOLERANCE)
    assert not done[0].milled.notes
    ways = [a for a in actions if isinstance(a, SplineFeed)]
    # all that is level, but for leads, is along splines
    level = [a for a in actions if isinstance(a, ArcFeed) and a.start[2] == a.end[2] < 0.0]
    passes = len(setting.levels) * 2
    assert len(level) == 2 * passes
    assert text.count("\nG5 ") >= len(ways)
    heights = {float(z) for way in ways for z in way.curve.points[:, 2]}
    tops = set() if tabs is None else {-setting.depth + tabs.height}
    assert heights == set(setting.levels) | tops
    assert sum(a.length for a in ways) > 0.9 * passes / 2 * 2e-3 * pi


def test_leads_go_over_into_the_spline_without_a_corner(oval, milling, proven):
    actions, done = profile_of(oval, milling(lead=1e-3), Side.OUTSIDE)
    proven(actions, done, TOLERANCE)
    cuts = [a for a in actions if isinstance(a, ArcFeed | SplineFeed)]
    joints = [
        (directions(a)[1], directions(b)[0])
        for a, b in pairwise(cuts)
        if (a.end == b.start).all() and isinstance(a, ArcFeed) != isinstance(b, ArcFeed)
    ]
    assert len(joints) == 4
    for before, behind in joints:
        np.testing.assert_allclose(before, behind, atol=1e-6)


def test_it_goes_from_level_to_level_without_lifting(star, oval, milling):
    for drawing in (star, oval):
        actions, _ = profile_of(drawing, milling(depth=6e-3), Side.OUTSIDE)
        # up; over, down and up again of each of two ways
        assert sum(isinstance(action, Rapid) for action in actions) == 7


def test_a_lifted_spline_is_the_same_curve_cut_in_two(oval, milling, proven):
    plain, _ = profile_of(oval, milling(), Side.OUTSIDE)
    tabs = Tabs(count=2, length=3e-3, height=5e-4)
    lifted, done = profile_of(oval, milling(), Side.OUTSIDE, tabs=tabs)
    proven(lifted, done, TOLERANCE)
    whole = [a.curve for a in plain if isinstance(a, SplineFeed)]
    parts = [a.curve for a in lifted if isinstance(a, SplineFeed)]
    assert sum(c.length() for c in parts) == pytest.approx(sum(c.length() for c in whole), 1e-9)
    high = [c for c in parts if (c.points[:, 2] == -2e-3 + 5e-4).all()]
    # an opening has no tabs of its own asked for, but it is an outline here as the others are
    per_way = 2 * 2
    assert len(high) >= per_way
    lengths = sum(c.length() for c in high)
    assert lengths == pytest.approx(per_way * (3e-3 + 2.0 * RADIUS), rel=1e-3)
    for curve in high:
        looks = curve.at(np.linspace(*curve.domain, 20))[:, :2]
        places = np.vstack([c.at(np.linspace(*c.domain, 20001))[:, :2] for c in whole])
        assert gap(looks, places).max() < 1e-5


def test_inner_bends_are_slowed_and_others_are_not(star, milling):
    actions, _ = profile_of(star, milling(), Side.INSIDE)
    ways = [a for a in actions if isinstance(a, SplineFeed)]
    feeds = np.array([way.feed for way in ways])
    assert feeds.max() == 0.015
    for way in ways:
        # climbing inside, what is cut along lies to the right: bends to the left are inner ones
        u = np.linspace(*way.curve.domain, 200)[1:-1]
        flat = replace(way.curve, points=way.curve.points[:, :2])
        bend = max(0.0, float(curvature(flat, u).max()))
        own = 0.015 / (1.0 + RADIUS * bend)
        assert way.feed == pytest.approx(own, rel=0.03)
    assert feeds.min() < 0.014


def test_parts_nearer_to_each_other_than_the_cutter_are_refused(milling):
    with pytest.raises(GougeError, match="smaller"):
        spline_profile(parts_near_each_other(3.9e-3), milling(), Side.OUTSIDE, TOLERANCE)
    apart = parts_near_each_other(4.1e-3)
    assert spline_profile(apart, milling(), Side.OUTSIDE, TOLERANCE).actions


def test_what_has_no_room_is_told(milling):
    wires = [(parts_near_each_other(0.0)[0][0],)]
    led = spline_profile(wires, milling(lead=1e-2), Side.INSIDE, TOLERANCE)
    assert any("no room for a lead-in of 10 mm" in note for note in led.notes)
    (note,) = spline_profile(wires, milling(diameter=0.021), Side.INSIDE, TOLERANCE).notes
    assert "(10, 0) mm is too narrow" in note
    tabs = Tabs(count=9, length=9e-3, height=1e-3)
    with pytest.raises(ValueError, match="have no room"):
        spline_profile(wires, milling(), Side.OUTSIDE, TOLERANCE, tabs)


def test_linuxcnc_takes_leads_ramps_and_tabs_along_splines(star, milling, tmp_path, rs274, proven):
    setting = milling(depth=3e-3, entry=Entry.RAMP, lead=2e-3)
    tabs = Tabs(count=2, length=3e-3, height=1e-3)
    actions, done = profile_of(star, setting, Side.OUTSIDE, tabs=tabs)
    text = proven(actions, done, TOLERANCE)
    file = tmp_path / "part.ngc"
    file.write_text(text)
    told = rs274(file)
    assert told.stdout.count("NURBS_G5_FEED") + told.stdout.count("NURBS_FEED") >= text.count("G5 ")
