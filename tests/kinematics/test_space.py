from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from splinearm.kinematics import homogeneous, quaternion, space

numbers = st.floats(-3.0, 3.0)
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: np.linalg.norm(v) > 0.1)
angles = st.floats(-7.0, 7.0)


@pytest.mark.property
@given(directions, angles, vectors, vectors)
@settings(deadline=None)
def test_rotation_about_a_line_agrees_with_scipy_and_leaves_the_line(axis, angle, about, point):
    T = space.rotation(axis, angle, about)
    turn = Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis))
    expected = turn.apply(np.subtract(point, about)) + about
    np.testing.assert_allclose(space.apply(T, point), expected, atol=1e-12)
    on_line = np.add(about, np.multiply(2.0, axis))
    np.testing.assert_allclose(space.apply(T, on_line), on_line, atol=1e-12)


@pytest.mark.parametrize(
    ("turn", "axis"),
    [(space.rotation_x, (1, 0, 0)), (space.rotation_y, (0, 1, 0)), (space.rotation_z, (0, 0, 1))],
)
def test_rotations_about_the_axes_are_those_about_their_lines(turn, axis):
    np.testing.assert_allclose(turn(0.7), space.rotation(axis, 0.7), atol=1e-16)
    R = quaternion.to_matrix(quaternion.from_axis_angle(axis, 0.7))
    np.testing.assert_allclose(turn(0.7)[:3, :3], R, atol=1e-15)


def test_a_rotation_needs_an_axis():
    with pytest.raises(ValueError, match="axis: want a vector of some length"):
        space.rotation((0.0, 0.0, 0.0), 1.0)


@pytest.mark.property
@given(directions, numbers, vectors)
@settings(deadline=None)
def test_a_reflection_puts_points_as_far_on_the_other_side(normal, offset, point):
    plane = (*normal, offset)
    T = space.reflection(plane)
    mirrored = space.apply(T, point)
    here = homogeneous.distance(plane, point)
    assert homogeneous.distance(plane, mirrored) == pytest.approx(-here, abs=1e-11)
    assert space.volume_factor(T) == pytest.approx(-1.0)
    np.testing.assert_allclose(T @ T, np.eye(4), atol=1e-10)


def test_the_coordinate_planes_mirror_one_coordinate():
    for axis in range(3):
        plane = np.zeros(4)
        plane[axis] = 2.0
        image = [1.0, 2.0, 3.0]
        image[axis] *= -1.0
        np.testing.assert_allclose(space.apply(space.reflection(plane), [1, 2, 3]), image)


def test_a_plane_without_normal_is_refused():
    with pytest.raises(ValueError, match="plane: want a normal"):
        space.reflection((0.0, 0.0, 0.0, 1.0))


def test_scaling_about_a_point_leaves_it():
    T = space.scaling((1.0, 2.0, 3.0), (1.0, 1.0, 1.0))
    np.testing.assert_allclose(space.apply(T, [[1, 1, 1], [2, 2, 2]]), [[1, 1, 1], [2, 3, 4]])
    assert space.volume_factor(T) == pytest.approx(6.0)


def test_a_shear_moves_by_height_and_keeps_volume():
    T = space.shear((2.0, 0.0, 0.0), (0.0, 0.0, 5.0), 0.5, about=(0.0, 0.0, 1.0))
    np.testing.assert_allclose(space.apply(T, [[0, 0, 1], [0, 0, 3]]), [[0, 0, 1], [1, 0, 3]])
    assert space.volume_factor(T) == pytest.approx(1.0)


def test_a_shear_out_of_its_plane_is_refused():
    with pytest.raises(ValueError, match="direction: want it at right angles"):
        space.shear((1.0, 0.0, 1.0), (0.0, 0.0, 1.0), 0.5)


@pytest.mark.property
@given(directions, angles, vectors)
@settings(deadline=None)
def test_the_rigid_inverse_is_the_inverse(axis, angle, offset):
    T = space.concatenate(space.rotation(axis, angle), space.translation(offset))
    np.testing.assert_allclose(space.rigid_inverse(T) @ T, np.eye(4), atol=1e-14)
    np.testing.assert_allclose(space.rigid_inverse(T), space.inverse(T), atol=1e-13)
    batch = np.array([T, np.eye(4)])
    np.testing.assert_array_equal(space.rigid_inverse(batch)[0], space.rigid_inverse(T))


def test_a_rigid_transform_passes_unchanged_and_read_only():
    T = space.concatenate(space.rotation_y(0.4), space.translation((1.0, 2.0, 3.0)))
    frozen = space.frozen_rigid(T, "T")
    np.testing.assert_array_equal(frozen, T)
    assert not frozen.flags.writeable


def test_a_rotation_with_few_digits_becomes_the_nearest_exact_one():
    rounded = np.round(space.rotation((1.0, 2.0, 3.0), 0.8), 7)
    R = space.frozen_rigid(rounded, "T")[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=2e-15)
    np.testing.assert_allclose(R, rounded[:3, :3], atol=1e-7)


@pytest.mark.parametrize(
    ("T", "message"),
    [
        (np.eye(3), r"T: want shape \(4, 4\), got \(3, 3\)"),
        (np.diag((1.0, 1.0, 1.0, 2.0)), "T: want 0 0 0 1 as last row, got .*2.0"),
        (np.diag((1.0, 1.0, -1.0, 1.0)), "T: want a rotation"),
        (np.diag((1.0, 1.0, 1.1, 1.0)), "T: want a rotation"),
        (np.full((4, 4), np.nan), "T: want finite numbers"),
    ],
)
def test_what_is_not_rigid_is_refused(T, message):
    with pytest.raises(ValueError, match=message):
        space.frozen_rigid(T, "T")


def test_a_half_turn_comes_out_the_same_both_ways():
    np.testing.assert_allclose(space.rotation_z(pi), space.rotation_z(-pi), atol=3e-16)
