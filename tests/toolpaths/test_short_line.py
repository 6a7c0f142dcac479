"""Runs of short lines become splines within what their corners may be cut by."""

from itertools import pairwise

import numpy as np
import pytest

from splinearm.toolpaths.action import Dwell, Feed, Message, Rapid, SplineFeed
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.short_line import smooth_runs
from splinearm.toolpaths.stage import itinerary_of

MM = 1e-3


def wave(count, *, height=0.0):
    """Give places of a smooth closed figure."""
    u = np.linspace(0.0, 2.0 * np.pi, count + 1)
    r = 30 * MM * (1.0 + 0.2 * np.sin(5.0 * u))
    return np.stack((r * np.cos(u), r * np.sin(u), height * np.sin(3.0 * u)), axis=1)


def lines(places, *, blend=0.02 * MM, feed=0.01, first=1):
    return [
        Feed(start=a, end=b, feed=feed, blend=blend, line=first + k)
        for k, (a, b) in enumerate(pairwise(places))
    ]


def farthest(places, curve_places):
    """Give how far places are from the polyline through others at most."""
    base, way = curve_places[:-1], np.diff(curve_places, axis=0)
    worst = 0.0
    for p in places:
        out = p - base
        share = np.clip((out * way).sum(axis=1) / (way * way).sum(axis=1), 0.0, 1.0)
        worst = max(worst, float(np.linalg.norm(out - share[:, None] * way, axis=1).min()))
    return worst


@pytest.mark.parametrize("height", [0.0, 2 * MM])
@pytest.mark.parametrize("blend", [0.005 * MM, 0.05 * MM, np.inf])
def test_a_curve_of_lines_becomes_one_spline_within_the_tolerance_both_ways(blend, height):
    places = wave(800, height=height)
    (run,) = smooth_runs(lines(places, blend=blend), {})
    spline = run.move
    assert isinstance(spline, SplineFeed)
    assert (run.first, run.count, spline.line, spline.feed) == (0, 800, 1, 0.01)
    assert len(spline.curve.points) < 800 / 4
    allowed = min(blend, 0.5 * MM)
    on_it = spline.curve.at(np.linspace(*spline.curve.domain, 4001))
    assert farthest(on_it[::7], places) <= allowed
    assert farthest(places, on_it) <= allowed
    np.testing.assert_allclose(spline.curve.points[[0, -1]], places[[0, -1]], atol=1e-15)


def test_corners_long_lines_and_exact_stops_stay_as_they_are():
    corners = Contour.rectangle([0, 0], [50 * MM, 30 * MM], 4 * MM).flattened(1e-6)
    places = np.column_stack((np.vstack((corners, corners[:1])), np.zeros(len(corners) + 1)))
    long_ones = [move for move in lines(places) if move.length > 10 * MM]
    runs = smooth_runs(lines(places), {})
    assert [run.move.line for run in runs if run.count == 1] == [move.line for move in long_ones]
    assert sum(isinstance(run.move, SplineFeed) for run in runs) == len(long_ones) == 4
    for blend in (None, 1e-6):
        moves = lines(wave(200), blend=blend)
        assert [run.move for run in smooth_runs(moves, {})] == moves
    saw = np.array([[k * MM, (k % 2) * MM, 0.0] for k in range(60)])
    moves = lines(saw, blend=np.inf)
    assert [run.move for run in smooth_runs(moves, {})] == moves


def test_another_feed_something_between_and_rapid_ways_end_a_run():
    places = wave(300)
    moves = lines(places[:101]) + lines(places[100:], feed=0.02, first=101)
    runs = smooth_runs(moves, {200})
    assert [(run.first, run.count) for run in runs] == [(0, 100), (100, 100), (200, 100)]
    lift = Rapid(start=places[100], end=places[100] + [0.0, 0.0, 5 * MM], line=101)
    assert [run.count for run in smooth_runs([*moves[:100], lift], {})] == [100, 1]


def test_an_itinerary_keeps_what_is_done_between_and_names_the_lines():
    places = wave(400)
    moves = lines(places, first=5)
    actions = [
        Rapid(start=places[0] + [0, 0, 5 * MM], end=places[0], line=4),
        *moves[:200],
        Message(line=205, text="half of it"),
        *moves[200:],
        Dwell(line=406, time=1.0),
    ]
    (stage,) = itinerary_of(actions, np.eye(4)).stages
    assert stage.names == ("lines 5 to 204", "lines 205 to 404")
    assert [(way, action.text) for way, action in stage.within] == [(1, "half of it")]
    assert len(stage.position.breaks) < 300
    assert stage.edges[-1] == pytest.approx(sum(move.length for move in moves), rel=1e-3)


def test_rounding_to_the_tolerance_itself_is_not_followed():
    rng = np.random.default_rng(4)
    rough = wave(400) + rng.normal(0.0, 1e-6, (401, 3))
    moves = lines(rough, blend=2e-6)
    assert [run.move for run in smooth_runs(moves, {})] == moves
