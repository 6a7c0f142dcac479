import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.curves.segment import Arc, Line
from splinearm.errors import CurveError

SHARES = np.linspace(0.0, 1.0, 101)
coordinates = st.floats(-1.0, 1.0).map(lambda x: round(x, 3))
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)


def length_of(segment, count=20001):
    p = segment.at(np.linspace(0.0, 1.0, count))
    return np.linalg.norm(np.diff(p, axis=0), axis=1).sum()


@pytest.mark.property
@given(start=points, via=points, end=points)
def test_an_arc_passes_its_three_points_in_order_at_one_radius(start, via, end):
    normal = np.cross(via - start, end - start)
    if np.linalg.norm(normal) < 1e-3:
        return
    arc = Arc.through(start, via, end)
    assert np.allclose(arc.at(np.array([0.0, 1.0])), [start, end], atol=1e-10)
    p = arc.at(SHARES)
    assert np.allclose(np.linalg.norm(p - arc.centre, axis=1), arc.radius, rtol=1e-9)
    assert np.abs((p - start) @ normal).max() <= 1e-9 * arc.radius
    fine = arc.at(np.linspace(0.0, 1.0, 20001))
    assert np.linalg.norm(fine - via, axis=1).min() <= 1e-3 * arc.length
    assert 0.0 < arc.angle < 2.0 * np.pi
    assert length_of(arc) == pytest.approx(arc.length, rel=1e-6)


@pytest.mark.parametrize("derivative", [1, 2, 3])
@pytest.mark.parametrize(
    "segment",
    [
        Line(np.zeros(3), np.array([0.1, 0.2, -0.3])),
        Arc.through([0, 0, 0], [0.1, 0.1, 0.0], [0.3, -0.1, 0.1]),
        Arc.about([0.1, 0, 0], [0, 0.1, 0.05], [0, 0, 0], [0, 0, 2.0], turns=2),
    ],
)
def test_derivatives_are_those_of_differences(segment, derivative):
    x, step = np.linspace(0.01, 0.99, 9), 1e-6
    before, behind = (segment.at(x + d, derivative - 1) for d in (-step, step))
    size = 1.0 + np.abs(segment.at(x, derivative)).max()
    assert np.allclose((behind - before) / (2 * step), segment.at(x, derivative), atol=1e-8 * size)


def test_about_an_axis_the_right_hand_says_which_way():
    quarter = Arc.about([1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1])
    assert quarter.angle == pytest.approx(0.5 * np.pi)
    assert np.allclose(quarter.at(np.array([0.5]))[0], [np.sqrt(0.5), np.sqrt(0.5), 0])
    other = Arc.about([1, 0, 0], [0, 1, 0], [0, 0, 5], [0, 0, -3])
    assert other.angle == pytest.approx(1.5 * np.pi)


def test_to_the_same_place_it_is_a_full_turn_and_more_on_request():
    assert Arc.about([1, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 1]).angle == pytest.approx(2 * np.pi)
    helix = Arc.about([1, 0, 0], [1, 0, 0.3], [0, 0, 9.0], [0, 0, 1], turns=3)
    assert helix.angle == pytest.approx(8.0 * np.pi)
    p = helix.at(SHARES)
    assert np.allclose(p[:, 2], 0.3 * SHARES, atol=1e-14)
    assert helix.length == pytest.approx(np.hypot(8.0 * np.pi, 0.3))
    assert isinstance(helix, Arc)


def test_what_is_no_arc_is_refused():
    with pytest.raises(CurveError, match="three points in line make no arc"):
        Arc.through([0, 0, 0], [0.1, 0, 0], [0.2, 0, 0])
    with pytest.raises(CurveError, match="three points in line"):
        Arc.through([0, 0, 0], [0.1, 0.1, 0], [0, 0, 0])
    with pytest.raises(CurveError, match="begins 100 mm from its axis and ends 110 mm"):
        Arc.about([0.1, 0, 0], [0, 0.11, 0], [0, 0, 0], [0, 0, 1])
    with pytest.raises(CurveError, match="begins 0 mm from its axis"):
        Arc.about([0, 0, 0.4], [0, 0, 0.5], [0, 0, 0], [0, 0, 1])
    with pytest.raises(ValueError, match="normal: want a direction"):
        Arc.about([1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0])
    with pytest.raises(ValueError, match="turns: want 0 or more, got -1"):
        Arc.about([1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1], turns=-1)
    with pytest.raises(ValueError, match="via: want finite numbers"):
        Arc.through([0, 0, 0], [np.nan, 0, 0], [1, 0, 0])
