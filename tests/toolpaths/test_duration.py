"""How long a toolpath takes within limits of acceleration and jerk."""

from itertools import pairwise
from math import inf, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.action import ArcFeed, Dwell, Feed, Rapid, Spindle, SplineFeed
from splinearm.toolpaths.duration import Drive, _change, _reached, estimate
from splinearm.toolpaths.edge_feed import feeds_along

DRIVE = Drive(rapid=0.05, acceleration=0.5, jerk=10.0, junction=1e-5)

pytestmark = pytest.mark.kernel


def line(start, end, feed=0.02):
    return Feed(start=np.array(start, dtype=float), end=np.array(end, dtype=float), feed=feed)


def test_a_long_way_takes_its_ramps_longer_than_its_feed_says():
    # both ramps cover half of what the feed would: a/j + v/a of time together
    time = estimate([line((0, 0, 0), (1, 0, 0), 0.1)], DRIVE)
    assert time == pytest.approx(10.0 + 0.1 / 0.5 + 0.5 / 10.0)


@pytest.mark.parametrize("length", [1e-5, 1e-3, 4e-3, 0.1])
def test_a_short_way_is_as_quick_as_its_jerk_lets_it(length):
    drive = Drive(rapid=100.0, acceleration=1e3, jerk=10.0)
    assert estimate(
        [Rapid(start=np.zeros(3), end=np.array([length, 0, 0]))], drive
    ) == pytest.approx(4.0 * (length / (2.0 * 10.0)) ** (1 / 3))


@given(v=st.floats(0.0, 0.2), length=st.floats(1e-6, 0.5))
@settings(max_examples=60, deadline=None)
def test_the_speed_that_can_be_reached_takes_just_that_length(v, length):
    w = _reached(v, length, DRIVE)
    assert w > v or length < 1e-5
    assert _change(v, w, DRIVE)[1] == pytest.approx(length, rel=1e-6, abs=1e-12)


def test_parts_of_a_straight_way_are_one_way():
    whole = estimate([line((0, 0, 0), (0.1, 0, 0))], DRIVE)
    marks = np.linspace(0.0, 0.1, 50)
    parts = [line((a, 0, 0), (b, 0, 0)) for a, b in pairwise(marks)]
    assert estimate(parts, DRIVE) == pytest.approx(whole)


def test_a_corner_costs_less_the_more_it_may_be_rounded():
    ways = [line((0, 0, 0), (0.02, 0, 0)), line((0.02, 0, 0), (0.02, 0.02, 0))]
    times = [
        estimate(ways, Drive(acceleration=0.5, jerk=10.0, junction=d)) for d in (0.0, 1e-5, 1e-3)
    ]
    apart = sum(estimate([way], DRIVE) for way in ways)
    assert times[0] == pytest.approx(apart)
    assert times[0] > times[1] > times[2] > 0.04 / 0.02


def test_a_turn_about_stops():
    ways = [line((0, 0, 0), (0.02, 0, 0)), line((0.02, 0, 0), (0, 0, 0))]
    assert estimate(ways, DRIVE) == pytest.approx(2 * estimate(ways[:1], DRIVE), rel=1e-3)


def test_tight_arcs_are_slower_than_their_feed():
    circle = ArcFeed(
        start=np.array([1e-4, 0, 0]), end=np.array([1e-4, 0, 0]), feed=1.0,
        centre=np.zeros(3), axis=2, turn=2 * pi,
    )  # fmt: skip
    assert estimate([circle], DRIVE) > circle.length / sqrt(0.5 * 1e-4)


def test_rests_count_and_what_takes_no_time_stops_the_way():
    ways = [line((0, 0, 0), (0.02, 0, 0)), line((0.02, 0, 0), (0.04, 0, 0))]
    together = estimate(ways, DRIVE)
    apart = estimate([ways[0], Spindle(speed=1.0), Dwell(time=2.0), ways[1]], DRIVE)
    assert apart > together + 2.0
    assert estimate([], DRIVE) == 0.0


def test_a_spline_takes_about_its_length():
    curve = BSpline(
        np.array([0.0, 0, 0, 0, 1, 1, 1, 1]),
        np.array([[0.0, 0, 0], [0.1, 0.02, 0], [0.2, -0.02, 0], [0.3, 0, 0]]), 3,
    )  # fmt: skip
    way = SplineFeed(start=curve.points[0], end=curve.points[-1], feed=0.02, curve=curve)
    assert estimate([way]) == pytest.approx(way.length / 0.02, rel=0.02)
    timed = Feed(start=np.zeros(3), end=np.array([0.1, 0, 0]), feed=None, time=5.0)
    assert estimate([timed], DRIVE) == pytest.approx(5.0, rel=0.05)


def test_what_cannot_be_a_machine_is_refused():
    for facts in ({"rapid": 0.0}, {"acceleration": inf}, {"jerk": -1.0}, {"junction": -1e-9}):
        with pytest.raises(ValueError, match="want"):
            Drive(**facts)


def test_feeds_fall_on_inner_arcs_alone():
    lengths, turns = np.array([1.0, pi, pi, 1e-9]), np.array([0.0, pi, -pi, pi])
    assert feeds_along(lengths, turns, -1, 1.0, 1.0) == pytest.approx([1.0, 0.5, 1.0, 0.05])
    assert feeds_along(lengths, turns, 1, 1.0, 1.0) == pytest.approx([1.0, 1.0, 0.5, 1.0])
    assert feeds_along(lengths, turns, 0, 1.0, 1.0) == pytest.approx(np.ones(4))
