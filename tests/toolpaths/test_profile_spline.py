"""Profiles along splines as splines: beside them by the radius, and written as such."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest

from splinearm.toolpaths.action import ArcFeed, Feed, SplineFeed
from splinearm.toolpaths.checking import verified
from splinearm.toolpaths.drawing import Drawing, Drawn
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.operation import Side
from splinearm.toolpaths.profile_spline import spline_profile
from splinearm.toolpaths.shape import ellipse_piece
from splinearm.toolpaths.work import Exactness, Kind, Work, carry_out

pytestmark = pytest.mark.kernel

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


def profile_of(drawing, milling, side, splines=True):
    work = Work(kind=Kind.PROFILE, milling=milling, side=side)
    return carry_out(drawing, [work], Exactness(tolerance=TOLERANCE, splines=splines))


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
    # a way in or out goes along lines and arcs
    led, _ = profile_of(oval, milling(lead=1e-3), Side.OUTSIDE)
    assert not any(isinstance(a, SplineFeed) for a in led)


def test_on_the_line_is_for_engraving(oval, milling):
    with pytest.raises(ValueError, match="engrave"):
        spline_profile([], milling(), Side.ON, TOLERANCE)
