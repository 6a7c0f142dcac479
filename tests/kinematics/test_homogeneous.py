from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import affine, homogeneous, plane, space

numbers = st.floats(-5.0, 5.0)
points = st.tuples(numbers, numbers)
normals = points.filter(lambda normal: np.hypot(*normal) > 0.1)


@pytest.mark.property
@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=4), st.floats(0.1, 9.0))
def test_a_multiple_is_the_same_point(cartesian, factor):
    points = homogeneous.from_cartesian(cartesian)
    back = homogeneous.to_cartesian(-factor * points)
    np.testing.assert_allclose(back, cartesian, atol=1e-14)


def test_a_point_at_infinity_has_no_cartesian_coordinates():
    with pytest.raises(ValueError, match="want none at infinity"):
        homogeneous.to_cartesian(homogeneous.at_infinity([[1.0, 2.0]]))


@pytest.mark.property
@given(points, points)
def test_the_line_through_two_points_contains_both(a, b):
    if np.hypot(*np.subtract(a, b)) < 1e-3:
        return
    line = homogeneous.line_through(*homogeneous.from_cartesian([a, b]))
    np.testing.assert_allclose(homogeneous.distance(line, [a, b]), 0.0, atol=1e-11)


@pytest.mark.property
@given(normals, normals, points)
def test_lines_through_a_point_meet_there(u, v, point):
    if abs(u[0] * v[1] - u[1] * v[0]) < 1e-2:
        return
    a, b = ((*normal, -np.dot(normal, point)) for normal in (u, v))
    met = homogeneous.to_cartesian(homogeneous.meeting_point(a, b))
    np.testing.assert_allclose(met, point, atol=1e-9)


def test_parallel_lines_meet_at_infinity_along_their_direction():
    met = homogeneous.meeting_point([1.0, 2.0, 3.0], [2.0, 4.0, 1.0])
    assert met[2] == 0.0
    assert met[0] * 1.0 + met[1] * 2.0 == 0.0


@pytest.mark.parametrize("same", [homogeneous.line_through, homogeneous.meeting_point])
def test_one_thing_twice_is_refused(same):
    with pytest.raises(ValueError, match="want two different"):
        same([1.0, 2.0, 1.0], [2.0, 4.0, 2.0])


@pytest.mark.property
@given(normals, st.floats(-1.5, 1.5))
def test_the_angle_between_lines_is_the_turn_from_one_to_the_other(normal, angle):
    turned = affine.apply_to_directions(plane.rotation(angle), normal)
    measured = homogeneous.angle_between_lines((*normal, 1.0), (*turned, -2.0))
    assert measured == pytest.approx(angle, abs=1e-12)
    other_sign = homogeneous.angle_between_lines((*normal, 1.0), (*(-turned), 2.0))
    assert other_sign == pytest.approx(angle, abs=1e-12)


def test_lines_at_right_angles_are_half_pi_apart_whatever_their_signs():
    for u in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
        for v in ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0)):
            assert homogeneous.angle_between_lines(u, v) == pi / 2


@pytest.mark.property
@given(st.integers(0, 10_000), st.sampled_from([2, 3]))
@settings(deadline=None)
def test_images_of_lines_and_planes_contain_the_images_of_their_points(seed, d):
    rng = np.random.default_rng(seed)
    T = affine.from_parts(rng.normal(size=(d, d)), rng.normal(size=d))
    point, normal = rng.normal(size=d), rng.normal(size=d)
    line = np.append(normal, -normal @ point)
    image = homogeneous.image(T, line)
    assert image @ np.append(affine.apply(T, point), 1.0) == pytest.approx(0.0, abs=1e-10)


def test_a_flattening_transform_gives_no_image_of_a_line():
    with pytest.raises(ValueError, match="flattens nothing"):
        homogeneous.image(plane.scaling((0.0, 1.0)), [1.0, 0.0, 1.0])


def test_the_plane_through_three_points_contains_them_and_looks_at_the_viewer():
    corners = np.array([[1.0, 0.0, 2.0], [0.0, 1.0, 2.0], [-1.0, 0.0, 2.0]])
    through = homogeneous.plane_through(*corners)
    np.testing.assert_allclose(homogeneous.distance(through, corners), 0.0, atol=1e-15)
    assert homogeneous.distance(through, [0.0, 0.0, 5.0]) == pytest.approx(3.0)
    with pytest.raises(ValueError, match="not on one line"):
        homogeneous.plane_through([0, 0, 0], [1, 1, 1], [2, 2, 2])


@pytest.mark.property
@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_two_planes_meet_in_a_line_that_lies_in_both(seed):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, 4))
    point, direction = homogeneous.line_of_planes(a, b)
    for p in (point, point + 3.0 * direction):
        np.testing.assert_allclose(homogeneous.distance([a, b], p), 0.0, atol=1e-9)
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    assert point @ direction == pytest.approx(0.0, abs=1e-9)


def test_parallel_planes_are_told_and_have_no_line():
    assert homogeneous.are_parallel([1.0, 2.0, 3.0, 4.0], [-2.0, -4.0, -6.0, 0.0])
    with pytest.raises(ValueError, match="want planes that meet"):
        homogeneous.line_of_planes([1.0, 2.0, 3.0, 4.0], [-2.0, -4.0, -6.0, 0.0])


def test_a_line_meets_a_plane_in_a_point_or_at_infinity():
    floor = homogeneous.plane_at([0.0, 0.0, 1.0], [0.0, 0.0, 2.0])
    met = homogeneous.line_meets_plane([1.0, 2.0, 5.0], [1.0, 0.0, -1.0], floor)
    np.testing.assert_allclose(homogeneous.to_cartesian(met), [5.0, 2.0, 1.0])
    assert homogeneous.line_meets_plane([1.0, 2.0, 5.0], [1.0, 0.0, 0.0], floor)[3] == 0.0
    with pytest.raises(ValueError, match="do not lie in their planes"):
        homogeneous.line_meets_plane([1.0, 2.0, 1.0], [1.0, 0.0, 0.0], floor)


def test_three_planes_of_a_rotated_corner_meet_in_it():
    T = space.rotation((1.0, 1.0, 0.0), 0.6, about=(0.3, 0.2, 0.1))
    planes = homogeneous.image(T, np.eye(4)[:3])
    corner = space.apply(T, (0.0, 0.0, 0.0))
    np.testing.assert_allclose(homogeneous.distance(planes, corner), 0.0, atol=1e-15)
