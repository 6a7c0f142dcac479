"""Ways of the tool in one table, and their roundings."""

from itertools import pairwise

import numpy as np
import pytest

from splinearm.curves import BSpline
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, SplineFeed
from splinearm.toolpaths.corner import half_widths
from splinearm.toolpaths.stage import itinerary_of
from splinearm.toolpaths.stroke import bends, strokes_of

UNIT = np.eye(4)
CUBIC = np.repeat([0.0, 1.0], 4)


def line(a, b, **words):
    return Feed(start=np.array(a, float), end=np.array(b, float), feed=0.01, **words)


def quarter(**words):
    return ArcFeed(
        start=np.array([0.02, 0.0, 0.0]), end=np.array([0.0, 0.02, 0.0]), feed=0.01,
        centre=np.zeros(3), axis=2, turn=0.5 * np.pi, **words,
    )  # fmt: skip


def test_a_line_and_an_arc_are_run_through_by_their_length():
    strokes = strokes_of([line((0.0, 0.0, 0.0), (0.02, 0.0, 0.0)), quarter()])
    s = np.linspace(0.0, strokes.edges[-1], 500)
    p, slope, bend = strokes.jets(s, np.searchsorted(strokes.edges[1:-1], s, side="right"))
    assert np.allclose(np.linalg.norm(slope, axis=1), 1.0, atol=1e-6)
    on_arc = s > 0.0201
    assert np.allclose(np.linalg.norm(p[on_arc, :2], axis=1), 0.02, atol=2e-9)
    assert np.allclose(np.linalg.norm(bend[on_arc], axis=1), 50.0, rtol=1e-3)
    assert strokes.edges[-1] == pytest.approx(0.02 + 0.01 * np.pi, rel=1e-12)


def test_a_helix_rises_evenly():
    helix = ArcFeed(
        start=np.array([0.01, 0.0, 0.0]), end=np.array([0.01, 0.0, 0.005]), feed=0.01,
        centre=np.zeros(3), axis=2, turn=-2.0 * np.pi,
    )  # fmt: skip
    strokes = strokes_of([helix])
    half = strokes.edges[-1:] * 0.5
    p = strokes.jets(half, np.zeros(1, dtype=np.intp))[0]
    assert np.allclose(p, [[-0.01, 0.0, 0.0025]], atol=1e-9)


def test_a_spline_is_followed_closely_at_an_even_rate():
    curve = BSpline(CUBIC, [(0, 0, 0), (0.02, 0.03, 0), (-0.01, 0.03, 0), (0.02, 0, 0)], 3)
    way = SplineFeed(start=curve.points[0], end=curve.points[-1], feed=0.01, curve=curve)
    strokes = strokes_of([way])
    s = np.linspace(0.0, strokes.edges[-1], 300)
    p, slope, _ = strokes.jets(s, np.zeros(300, dtype=np.intp))
    assert farthest(p[::10], curve.at(np.linspace(0.0, 1.0, 4001))) < 1e-7
    assert np.allclose(np.linalg.norm(slope, axis=1), 1.0, atol=1e-4)


def test_a_spline_with_a_kink_is_two_ways():
    knots = [0, 0, 1, 2, 2]
    curve = BSpline(knots, [(0, 0, 0), (0.01, 0, 0), (0.01, 0.01, 0)], 1)
    way = SplineFeed(start=curve.points[0], end=curve.points[-1], feed=0.01, curve=curve)
    strokes = strokes_of([way])
    assert strokes.owners.tolist() == [0, 0]
    assert np.allclose(strokes.lengths, 0.01)


@pytest.mark.parametrize("angle", [0.01, 0.5, 1.5, 2.6])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-4, 1e-3])
def test_a_rounded_corner_is_within_its_tolerance_and_uses_it(angle, tolerance):
    far = 0.01 * np.array([1.0 + np.cos(angle), np.sin(angle), 0.0])
    strokes = strokes_of([line((0, 0, 0), (0.01, 0, 0)), line((0.01, 0, 0), far)])
    corner = np.array([1], dtype=np.intp)
    at = strokes.edges[1:2]
    turn, bent = bends(strokes.jets(at, corner - 1), strokes.jets(at, corner))
    assert bent.all()
    h = half_widths(strokes, corner, np.array([tolerance]), turn, np.zeros(1))[0]
    assert h[0] == pytest.approx(h[1])
    assert 0.0 < h[0] <= 0.005 + 1e-12
    rounded = itinerary_of(
        [
            line((0, 0, 0), (0.01, 0, 0), blend=tolerance),
            line((0.01, 0, 0), far, blend=tolerance),
        ],
        UNIT,
    )
    assert len(rounded.stages) == 1
    curve = rounded.stages[0].position
    p = curve.at(np.linspace(0.01 - h[0], 0.01 + h[0], 201))
    cut = np.linalg.norm(p - [0.01, 0.0, 0.0], axis=1).min()
    away = max(cut, farthest(p, np.array([(0, 0, 0), (0.01, 0, 0), far])))
    assert away <= tolerance * (1.0 + 1e-6)
    assert h[0] > 0.00499 or away > 0.6 * tolerance


def test_an_arc_that_a_line_touches_is_rounded_too_for_its_curvature_jumps():
    ways = [quarter(blend=1e-5), line((0.0, 0.02, 0.0), (-0.02, 0.02, 0.0), blend=1e-5)]
    curve = itinerary_of(ways, UNIT).stages[0].position
    s = np.linspace(*curve.domain, 4000)
    bend = np.linalg.norm(curve.at(s, 2), axis=1)
    assert np.abs(np.diff(bend)).max() < 5.0  # 50 1/m to nothing, without a jump


@pytest.mark.parametrize(("blend", "stages"), [(None, 3), (0.0, 3), (1e-4, 1), (np.inf, 1)])
def test_corners_are_rested_at_where_they_may_not_be_rounded(blend, stages):
    places = [(0, 0, 0), (0.01, 0, 0), (0.01, 0.01, 0), (0.02, 0.01, 0)]
    ways = [line(a, b, blend=blend) for a, b in pairwise(places)]
    assert len(itinerary_of(ways, UNIT).stages) == stages


def test_a_way_back_is_rested_at_whatever_may_be_rounded():
    ways = [line((0, 0, 0), (0.01, 0, 0), blend=1e-3), line((0.01, 0, 0), (0, 0, 0), blend=1e-3)]
    assert len(itinerary_of(ways, UNIT).stages) == 2


def test_a_program_begins_where_its_first_rapid_way_ends():
    rapid = Rapid(start=np.zeros(3), end=np.array([0.03, 0.0, 0.005]))
    cut = line((0.03, 0.0, 0.005), (0.03, 0.0, 0.0))
    plain = itinerary_of([rapid, cut], UNIT)
    assert np.allclose(plain.stages[0].position.points[0], [0.03, 0.0, 0.005])
    above = itinerary_of([rapid, cut], UNIT, lift=np.array([0.0, 0.0, 0.02]))
    assert np.allclose(above.stages[0].position.points[0], [0.03, 0.0, 0.025])
    assert above.stages[0].lines == (0,)


def test_the_work_lies_where_it_is_placed():
    T = np.eye(4)
    T[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    T[:3, 3] = 0.1, 0.2, 0.3
    curve = itinerary_of([line((0, 0, 0), (0.01, 0, 0))], T).stages[0].position
    assert np.allclose(curve.points[[0, -1]], [[0.1, 0.2, 0.3], [0.1, 0.21, 0.3]])


def test_nothing_that_moves_is_refused():
    with pytest.raises(ValueError, match="move the tool"):
        itinerary_of([], UNIT)


def farthest(p, corners):
    """Give how far places are from a polyline at the most."""
    nearest = np.full(len(p), np.inf)
    for a, b in pairwise(corners):
        share = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(p - a - share[:, None] * (b - a), axis=1))
    return nearest.max()
