"""Runs of short lines become splines within what their corners may be cut by."""

from dataclasses import replace
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


def flat(x, y):
    return np.column_stack((x, y, np.zeros(len(x))))


def dense(places, step):
    """Give places along lines, so near to each other."""
    found = [places[:1]]
    for a, b in pairwise(places):
        count = max(1, int(np.linalg.norm(b - a) / step))
        found.append(a + np.linspace(0.0, 1.0, count + 1)[1:, None] * (b - a))
    return np.vstack(found)


def hairpin(radius, step=0.1 * MM, far=4 * MM):
    """Give lines out, around a half circle and back beside themselves."""
    a = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 13)
    x = np.arange(0.0, far, step)
    x = np.concatenate((x, far + radius * np.cos(a), x[::-1]))
    y = np.concatenate((np.full(40, -radius), radius * np.sin(a), np.full(40, radius)))
    return flat(x, y)


def cornered(count=600):
    """Give a wavy line, a corner of about a right angle, and a wavy line back."""
    one = wave(count)[: count // 2]
    back = one[::-1] - one[-1]
    return np.vstack((one, one[-1] + back[1:] @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]])))


ODD = {
    "hairpin of 10 um": (hairpin(0.01 * MM), np.inf),
    "hairpin of 0.1 mm": (hairpin(0.1 * MM), np.inf),
    "hairpin, narrow": (hairpin(0.1 * MM), 0.02 * MM),
    "cycloid": (flat(3e-3 * (T := np.linspace(0.0, 9.0, 700)) - 3e-3 * np.sin(T),
                     3e-3 - 3e-3 * np.cos(T)), 0.02 * MM),
    "semicubic": (flat((U := np.linspace(-1.0, 1.0, 501)) ** 2 * 0.02, U**3 * 0.02), 0.05 * MM),
    "spiral down": (np.stack((0.01 * np.cos(3 * T), 0.01 * np.sin(3 * T), -2e-4 * T), 1), 2e-5),
    "spiral up from its middle": (np.stack((1e-3 * T * np.cos(2 * T), 1e-3 * T * np.sin(2 * T),
                                            2e-4 * T), 1), 2e-5),
    "corner": (cornered(), 0.05 * MM),
    "rounded to 10 um": (np.round(wave(4000), 5), 0.2 * MM),
    "rounded to 1 um": (np.round(wave(3000), 6), 0.02 * MM),
}  # fmt: skip


SHORT = ("hairpin of 10 um", "hairpin, narrow", "cycloid", "corner")


@pytest.mark.parametrize(
    "name", [n if n in SHORT else pytest.param(n, marks=pytest.mark.slow) for n in ODD]
)
def test_the_way_of_the_tool_is_within_the_tolerance_of_the_program(name):
    places, blend = ODD[name]
    allowed = min(blend, 0.5 * MM)
    moves = lines(places, blend=blend)
    runs = smooth_runs(moves, {})
    assert sum(run.count for run in runs) == len(moves)
    assert sum(isinstance(run.move, SplineFeed) for run in runs) >= 1
    for run in runs:
        if isinstance(run.move, SplineFeed):  # none stands still or goes back
            u = np.linspace(*run.move.curve.domain, 400)
            assert np.linalg.norm(run.move.curve.at(u, 1), axis=1).min() > 0.3
    stages = itinerary_of(moves, np.eye(4)).stages
    step = max(0.1 * allowed, sum(move.length for move in moves) / 4000)
    on_it = np.vstack(
        [
            stage.position.at(
                np.linspace(*stage.position.domain, 2 + int(stage.position.domain[1] / step))
            )
            for stage in stages
        ]
    )
    # chords between looks are beside the way by so much at most where it bends most
    spare = 1e-8 + 0.02 * allowed
    assert farthest(on_it[::3], places) <= allowed + spare
    assert farthest(dense(places, step)[::3], on_it) <= allowed + spare


def test_ends_that_crowd_together_are_one():
    rng = np.random.default_rng(0)
    tripled = np.repeat(wave(800), 3, axis=0)
    tripled = tripled + rng.normal(0.0, 3e-9, tripled.shape)
    (run,) = smooth_runs(lines(tripled), {})
    assert run.count == len(tripled) - 1
    assert len(run.move.curve.points) < 200
    np.testing.assert_array_equal(run.move.end, tripled[-1])


def test_a_long_line_amid_short_ones_does_not_keep_these_from_being_one():
    places = np.delete(wave(800), np.r_[300:330], axis=0)
    runs = smooth_runs(lines(places), {})
    assert [run.count for run in runs] == [299, 1, 470]
    assert runs[1].move.length > 3 * MM


def test_what_bends_much_is_several_splines():
    u = np.linspace(0.0, 2.0 * np.pi, 4001)
    r = 30 * MM * (1.0 + 0.02 * np.sin(80.0 * u))
    runs = smooth_runs(lines(flat(r * np.cos(u), r * np.sin(u))), {})
    assert 3 <= len(runs) < 20
    assert all(run.goes_on for run in runs[1:])


def test_inverse_time_and_planar_arms():
    places = wave(600, height=1 * MM)
    moves = lines(places)
    timed = [replace(move, feed=None, time=0.01) for move in moves]
    assert [run.move for run in smooth_runs(timed, {})] == timed
    (stage,) = itinerary_of(moves, np.eye(4), flat=True).stages
    assert not stage.position.points[:, 2].any()
    assert stage.names == ("lines 1 to 600",)


def test_every_way_of_programs_at_random_is_one_of_a_run():
    rng = np.random.default_rng(5)
    for _ in range(15):
        steps = rng.normal(0.0, 1.0, (120, 2)) * 10.0 ** rng.uniform(-8, -3, (120, 1))
        places = np.cumsum(flat(*steps.T), axis=0)
        moves = lines(places, blend=float(10.0 ** rng.uniform(-5, -3)))
        between = set(rng.choice(119, 3).tolist())
        runs = smooth_runs(moves, between)
        assert [run.first for run in runs] == np.cumsum([0, *(r.count for r in runs)])[:-1].tolist()
        assert between <= {run.first for run in runs}
        for run in runs:
            if isinstance(run.move, SplineFeed):
                own = places[run.first : run.first + run.count + 1]
                on_it = run.move.curve.at(np.linspace(*run.move.curve.domain, 500))
                assert farthest(own, on_it) <= moves[0].blend * 1.02
