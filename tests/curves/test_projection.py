import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import BSpline, interpolate
from splinearm.curves.conic import circle, ellipse, parabola
from splinearm.curves.projection import Projection, invert, nearest_point
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.sampled_from([0.3, 1.0, 5.0]))
def test_no_place_is_nearer_than_the_nearest(random_curve, seed, dim, reach):
    curve = random_curve(seed, dim=dim)
    points = reach * np.random.default_rng(seed).normal(size=(8, dim))
    found = nearest_point(curve, points)
    pieces = zip(curve.breaks[:-1], curve.breaks[1:], strict=True)
    places = curve.at(np.concatenate([np.linspace(a, b, 501) for a, b in pieces]))
    least = np.linalg.norm(points[:, None] - places, axis=2).min(axis=1)
    assert (found.distance <= least + 1e-14).all()
    assert np.allclose(np.linalg.norm(found.points - points, axis=1), found.distance, atol=1e-14)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 3))
def test_points_of_a_curve_are_inverted(random_curve, seed, dim):
    curve = random_curve(seed, dim=dim, form="clamped")
    u = np.random.default_rng(seed).uniform(*curve.domain, 12)
    found = invert(curve, curve.at(u), 1e-13)
    assert np.allclose(curve.at(found), curve.at(u), rtol=0, atol=1e-13)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 6.28), st.floats(0.0, 9.0))
def test_the_distance_from_a_circle_is_the_difference_of_radii(angle, radius):
    point = radius * np.array([np.cos(angle), np.sin(angle)])
    found = nearest_point(circle(2.0), point)
    assert abs(float(found.distance) - abs(radius - 2.0)) <= 2e-15 * max(radius, 2.0)
    if radius > 1e-3:
        assert np.allclose(found.points, 2.0 / radius * point, atol=1e-12)


def test_the_vertex_of_a_parabola_is_nearest_up_to_its_centre_of_curvature():
    curve = parabola(1.0, -3.0, 3.0)
    for x in (-1.0, 0.5, 1.9, 2.0):
        assert np.isclose(nearest_point(curve, [x, 0.0]).distance, abs(x), atol=1e-12)
    # beyond it two feet are: y^2 = 4 x, x_foot = x - 2
    for x in (2.5, 5.0):
        assert np.isclose(nearest_point(curve, [x, 0.0]).distance, 2.0 * np.sqrt(x - 1.0))


def test_the_foot_on_an_ellipse_is_square_to_it():
    curve = ellipse(3.0, 1.0)
    points = np.random.default_rng(0).normal(size=(30, 2)) * 2.0
    found = nearest_point(curve, points)
    normals = found.points / [9.0, 1.0]
    across = (found.points - points)[:, 0] * normals[:, 1] - (found.points - points)[
        :, 1
    ] * normals[:, 0]
    assert np.abs(across).max() <= 1e-13


def test_a_near_miss_of_two_branches_is_told_apart():
    # two straight legs 1e-9 apart
    curve = BSpline([0, 0, 1, 2, 3, 3], [[0, 0], [1, 0], [1, 1e-9], [0, 1e-9]], 1)
    found = nearest_point(curve, [[0.25, 0.2e-9], [0.25, 0.8e-9], [0.25, 0.0], [0.25, 1e-9]])
    assert np.allclose(found.u, [0.25, 2.75, 0.25, 2.75], atol=1e-12)
    assert np.allclose(found.distance, [0.2e-9, 0.2e-9, 0.0, 0.0], rtol=1e-6, atol=1e-22)


def test_batches_keep_their_shape_and_single_points_theirs():
    projection = Projection(circle(1.0))
    found = projection.nearest(np.random.default_rng(0).normal(size=(4, 3, 2)))
    assert (found.u.shape, found.points.shape, found.distance.shape) == ((4, 3), (4, 3, 2), (4, 3))
    single = projection.nearest([0.0, 3.0])
    assert (single.u.shape, single.points.shape) == ((), (2,))
    assert np.isclose(single.u, 0.25)
    assert projection.nearest(np.empty((0, 2))).u.shape == (0,)


def test_the_answer_does_not_depend_on_units():
    walk = np.cumsum(np.random.default_rng(1).normal(size=(20, 3)), axis=0)
    points = walk[:10] + 0.3
    plain = nearest_point(interpolate(walk), points)
    for unit in (1e-9, 1e6):
        other = nearest_point(interpolate(unit * walk, parameters="uniform"), unit * points)
        assert np.allclose(
            other.distance / unit,
            nearest_point(interpolate(walk, parameters="uniform"), points).distance,
            rtol=1e-10,
        )
    assert plain.distance.shape == (10,)


def test_constant_curves_and_curves_of_degree_0_have_a_nearest_place():
    still = BSpline([0, 0, 0, 1, 1, 1], np.ones((3, 2)), 2)
    assert np.isclose(nearest_point(still, [1.0, 3.0]).distance, 2.0)
    steps = BSpline([0.0, 1.0, 2.0], [[0.0], [5.0]], 0)
    assert np.isclose(nearest_point(steps, [4.0]).distance, 1.0)


def test_points_off_the_curve_are_refused_with_their_distance():
    with pytest.raises(CurveError, match=r"0\.5 off the curve, allowed 0\.1") as caught:
        invert(circle(1.0), [[1.0, 0.0], [0.0, 1.5]], 0.1)
    assert caught.value.where == "point 1"
    with pytest.raises(CurveError, match="off the curve"):
        invert(circle(1.0), [2.0, 0.0], 0.5)


@pytest.mark.parametrize("points", [[1.0, 2.0, 3.0], [np.nan, 0.0], 1.0])
def test_what_is_no_point_is_refused(points):
    with pytest.raises(ValueError, match="2 finite coordinates"):
        nearest_point(circle(1.0), points)


def test_a_tolerance_below_0_is_refused():
    with pytest.raises(ValueError, match="tolerance"):
        invert(circle(1.0), [1.0, 0.0], -1.0)
