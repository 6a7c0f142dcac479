import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import Pose, quaternion

seeds = st.integers(0, 100_000)


def some(seed):
    rng = np.random.default_rng(seed)
    return Pose(rng.normal(size=3), quaternion.normalize(rng.normal(size=4)))


def assert_close(a, b):
    np.testing.assert_allclose(a.matrix(), b.matrix(), atol=1e-14)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_poses_are_a_group(seed):
    a, b, c = (some(seed + i) for i in range(3))
    assert_close((a @ b) @ c, a @ (b @ c))
    assert_close(a @ Pose.identity(), a)
    assert_close(a @ a.inverse(), Pose.identity())
    assert_close((a @ b).inverse(), b.inverse() @ a.inverse())


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_poses_compose_and_apply_as_their_matrices_do(seed):
    a, b = some(seed), some(seed + 1)
    np.testing.assert_allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=1e-14)
    points = np.random.default_rng(seed).normal(size=(4, 3))
    expected = points @ a.matrix()[:3, :3].T + a.p
    np.testing.assert_allclose(a.apply(points), expected, atol=1e-14)
    assert_close(Pose.from_matrix(a.matrix()), a)


def test_a_quaternion_off_by_rounding_becomes_exact():
    pose = Pose(np.zeros(3), np.array([1.0 + 5e-7, 0.0, 0.0, 0.0]))
    np.testing.assert_array_equal(pose.quat, [1.0, 0.0, 0.0, 0.0])


def test_a_quaternion_that_is_not_unit_is_refused_with_its_length():
    with pytest.raises(ValueError, match=r"want a unit quaternion w x y z, got .* of length 2"):
        Pose(np.zeros(3), np.array([2.0, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize(
    ("p", "quat", "message"),
    [
        ([0.0, 0.0], [1.0, 0.0, 0.0, 0.0], r"p: want shape \(3\), got \(2,\)"),
        ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], r"quat: want shape \(4\), got \(3,\)"),
        ([0.0, np.nan, 0.0], [1.0, 0.0, 0.0, 0.0], "p: want finite numbers, got .*nan"),
        ([0.0, 0.0, 0.0], [np.inf, 0.0, 0.0, 0.0], "quat: want finite numbers"),
    ],
)
def test_a_pose_refuses_what_is_no_position_or_orientation(p, quat, message):
    with pytest.raises(ValueError, match=message):
        Pose(p, quat)


def test_a_matrix_that_is_not_rigid_is_refused():
    with pytest.raises(ValueError, match="T: want a rotation"):
        Pose.from_matrix(2.0 * np.eye(4) - np.diag((0.0, 0.0, 0.0, 1.0)))


def test_the_arrays_of_a_pose_are_its_own_and_read_only():
    p = np.zeros(3)
    pose = Pose(p, np.array([1.0, 0.0, 0.0, 0.0]))
    p[0] = 5.0
    assert pose.p[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        pose.p[0] = 1.0


def test_a_pose_composes_with_poses_only():
    with pytest.raises(TypeError):
        Pose.identity() @ 3.0
