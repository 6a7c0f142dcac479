from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.segment import Line
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.path import TURN_ARM, ToolPlaces, course_path, is_smooth, spline_path


def lines(places):
    return [Line(*ends) for ends in pairwise(places.p)]


def line_path(places, blends, names):
    return course_path(places, lines(places), blends, names)


@st.composite
def places(draw, least=2, most=7):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    m = draw(st.integers(least, most))
    p = rng.uniform(-0.3, 0.3, (m, 3))
    quats = None
    if draw(st.booleans()):
        quats = quaternion.normalize(rng.normal(size=(m, 4)))
    return ToolPlaces(p, quats)


def names(count):
    return [f"place {i}" for i in range(count)]


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(places(), st.booleans())
def test_a_spline_path_passes_its_places(given_places, closed):
    path = spline_path(given_places, closed=closed)
    state = path.state(path.waypoint_s[: len(given_places.p)])
    assert np.allclose(state.p, given_places.p, atol=1e-14)
    if given_places.quats is not None:
        assert quaternion.angle_between(state.quat, given_places.quats).max() < 1e-13
    if closed:
        ends = path.state(np.array(path.domain))
        assert np.allclose(ends.p[0], ends.p[1], atol=1e-14)
        assert np.allclose(ends.slope[0], ends.slope[1], atol=1e-9)
        assert np.allclose(ends.bend[0], ends.bend[1], atol=1e-7)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(places(least=3), st.booleans())
def test_slope_and_bend_are_those_of_differences(given_places, rounded):
    if rounded:
        blends = np.full(len(given_places.p), 0.01)
        blends[[0, -1]] = 0.0
        try:
            path = line_path(given_places, blends, names(len(blends)))
        except CurveError:
            return
    else:
        path = spline_path(given_places)
    s = np.linspace(*path.domain, 41)[1:-1]
    s = s[np.abs(s[:, None] - path.breaks).min(axis=1) > 1e-4]
    step = 1e-6
    before, here, behind = path.state(s - step), path.state(s), path.state(s + step)
    slope = (behind.p - before.p) / (2 * step)
    assert np.allclose(here.slope[:, :3], slope, atol=1e-6)
    bend = (behind.slope - before.slope) / (2 * step)
    assert np.allclose(here.bend, bend, atol=1e-4 * max(1.0, np.abs(bend).max()))
    if here.quat is not None:
        turned = quaternion.multiply(behind.quat, quaternion.conjugate(before.quat))
        assert np.allclose(here.slope[:, 3:], quaternion.log(turned) / (2 * step), atol=1e-5)


def test_s_is_the_way_in_metres_or_the_turn_times_a_tenth():
    quats = quaternion.exp(np.array([[0.0, 0, 0], [0.0, 0, 0.5], [0.0, 0, 1.5]]))
    still = ToolPlaces(np.zeros((3, 3)), quats)
    assert np.allclose(spline_path(still).waypoint_s, [0.0, 0.5 * TURN_ARM, 1.5 * TURN_ARM])
    moving = ToolPlaces(np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 2.0, 0]]), quats)
    assert np.allclose(spline_path(moving).waypoint_s, [0.0, 1.0, 3.0])
    p, quat = spline_path(still).at(0.5 * TURN_ARM)
    assert not p.any()
    assert quaternion.angle_between(quat, quats[1]) < 1e-14


def test_lines_are_straight_and_their_corners_within_the_blend():
    p = np.array([[0.0, 0, 0], [0.2, 0, 0], [0.2, 0.1, 0], [0.0, 0.1, 0.1]])
    blends = np.array([0.0, 0.02, 0.08, 0.0])
    path = line_path(ToolPlaces(p, None), blends, names(4))
    for i in (1, 2):
        here = path.waypoint_s[i] + np.linspace(-1.0, 1.0, 101) * blends[i]
        away = np.linalg.norm(path.state(here).p - p[i], axis=1)
        assert away.max() <= blends[i] * (1.0 + 1e-12)
        assert away[50] > 0.0
    before = path.state(np.linspace(0.0, 0.18, 20)).p
    assert np.allclose(before[:, 1:], 0.0, atol=1e-16)


def test_blends_that_overlap_name_the_places():
    p = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.05, 0], [0.0, 0.05, 0.0]])
    with pytest.raises(CurveError, match="place 1 and place 2: blends of 30 mm and 30 mm overlap"):
        line_path(ToolPlaces(p, None), np.array([0.0, 0.03, 0.03, 0.0]), names(4))
    with pytest.raises(CurveError, match="place 0 and place 1"):
        line_path(ToolPlaces(p, None), np.array([0.0, 0.11, 0.0, 0.0]), names(4))
    # together exactly the way between: the corners touch
    path = line_path(ToolPlaces(p, None), np.array([0.0, 0.025, 0.025, 0.0]), names(4))
    assert np.isfinite(path.state(np.linspace(*path.domain, 50)).bend).all()


def test_straight_means_way_and_turn():
    p = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.3, 0, 0]])
    assert is_smooth(ToolPlaces(p, None), lines(ToolPlaces(p, None)))
    even = quaternion.exp(np.array([[0.0, 0, 0], [0.0, 0, 0.1], [0.0, 0, 0.3]]))
    assert is_smooth(ToolPlaces(p, even), lines(ToolPlaces(p, even)))
    uneven = quaternion.exp(np.array([[0.0, 0, 0], [0.0, 0, 0.1], [0.0, 0, 0.2]]))
    assert not is_smooth(ToolPlaces(p, uneven), lines(ToolPlaces(p, uneven)))
    p[2, 1] = 0.01
    assert not is_smooth(ToolPlaces(p, None), lines(ToolPlaces(p, None)))


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(places(least=3), st.integers(0, 999))
def test_distances_are_those_of_a_dense_search(given_places, seed):
    path = spline_path(given_places)
    points = np.random.default_rng(seed).uniform(-0.4, 0.4, (40, 3))
    dense = path.state(np.linspace(*path.domain, 4000)).p
    want = np.linalg.norm(points[:, None] - dense, axis=2).min(axis=1)
    have = path.distance(points)
    assert (have <= want + 1e-9).all()
    assert np.allclose(have, want, atol=1e-4)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(places(least=2), st.floats(1e-7, 1e-4))
def test_points_beside_the_path_are_as_far_as_they_were_put(given_places, away):
    path = spline_path(ToolPlaces(given_places.p, None))
    s = np.linspace(*path.domain, 97)
    state = path.state(s)
    assert path.distance(state.p).max() < 1e-9
    fast = np.linalg.norm(state.slope, axis=1) > 0.3  # elsewhere it may bend too sharply
    aside = np.cross(state.slope, [0.3, 0.8, -0.5])
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    distance = path.distance(state.p + away * aside)[fast]
    assert (distance <= away * (1.0 + 1e-9) + 1e-15).all()
    assert np.median(distance) == pytest.approx(away, rel=1e-6)


def test_an_s_beyond_the_path_is_refused():
    path = spline_path(ToolPlaces(np.array([[0.0, 0, 0], [0.1, 0, 0]]), None))
    with pytest.raises(CurveError):
        path.at(0.11)
