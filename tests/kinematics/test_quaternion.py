from itertools import product
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from splinearm.kinematics import quaternion

PROPER = ["xyx", "xzx", "yxy", "yzy", "zxz", "zyz"]
TAIT_BRYAN = ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx"]
SEQUENCES = PROPER + TAIT_BRYAN + [s.upper() for s in PROPER + TAIT_BRYAN]

seeds = st.integers(0, 100_000)
# sizes of rotations, from none over tiny ones and the neighbourhood of a half turn to a half turn
SIZES = [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 1.0, pi - 1e-4, pi - 1e-8, pi - 1e-12, pi]


def some(seed, *batch):
    return quaternion.normalize(np.random.default_rng(seed).normal(size=(*batch, 4)))


def some_axis(seed):
    axis = np.random.default_rng(seed).normal(size=3)
    return axis / np.linalg.norm(axis)


def assert_same(a, b, atol=1e-14):
    """The same rotation: quaternions that are equal up to their sign."""
    a, b = np.broadcast_arrays(a, b)
    sign = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    np.testing.assert_allclose(a, sign * b, rtol=0, atol=atol)


def scipy_of(quat):
    return Rotation.from_quat(quaternion.to_xyzw(quat))


def test_i_times_j_is_k_and_the_other_way_minus_k():
    i, j, k = np.eye(4)[1:]
    np.testing.assert_array_equal(quaternion.multiply(i, j), k)
    np.testing.assert_array_equal(quaternion.multiply(j, i), -k)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_unit_quaternions_are_a_group(seed):
    a, b, c = some(seed, 3)
    one = np.array([1.0, 0.0, 0.0, 0.0])
    left = quaternion.multiply(quaternion.multiply(a, b), c)
    np.testing.assert_allclose(left, quaternion.multiply(a, quaternion.multiply(b, c)), atol=1e-15)
    np.testing.assert_array_equal(quaternion.multiply(one, a), a)
    np.testing.assert_allclose(quaternion.multiply(a, quaternion.inverse(a)), one, atol=1e-15)
    assert np.linalg.norm(left) == pytest.approx(1.0, abs=1e-15)


def test_the_inverse_of_a_longer_quaternion_undoes_its_length_too():
    long = 3.0 * some(1)
    one = quaternion.multiply(long, quaternion.inverse(long))
    np.testing.assert_allclose(one, [1.0, 0.0, 0.0, 0.0], atol=1e-15)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_the_product_turns_as_matrices_do_first_b_then_a(seed):
    a, b = some(seed, 2)
    v = np.random.default_rng(seed).normal(size=3)
    both = quaternion.multiply(a, b)
    in_turn = quaternion.rotate(a, quaternion.rotate(b, v))
    np.testing.assert_allclose(quaternion.rotate(both, v), in_turn, atol=1e-14)
    R = quaternion.to_matrix(a) @ quaternion.to_matrix(b)
    np.testing.assert_allclose(quaternion.to_matrix(both), R, atol=1e-15)
    np.testing.assert_allclose(R @ v, in_turn, atol=1e-14)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_matrices_agree_with_scipy(seed):
    quat = some(seed, 5)
    expected = scipy_of(quat).as_matrix()
    np.testing.assert_allclose(quaternion.to_matrix(quat), expected, atol=1e-15)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_the_way_over_a_matrix_leads_back_with_w_not_below_zero(seed):
    quat = some(seed, 2, 3)
    back = quaternion.from_matrix(quaternion.to_matrix(quat))
    assert_same(back, quat)
    assert (back[..., 0] >= 0.0).all()


@pytest.mark.parametrize("size", SIZES)
def test_rotations_of_every_size_survive_every_form(size):
    for seed in range(20):
        vector = size * some_axis(seed)
        quat = quaternion.exp(vector)
        np.testing.assert_allclose(quaternion.log(-quat), quaternion.log(quat), rtol=0)
        if size < pi - 1e-9:
            error = np.abs(quaternion.log(quat) - vector).max()
            assert error <= 4e-15 * size
        assert_same(quaternion.exp(quaternion.log(quat)), quat, 2e-16 * 4)
        assert_same(quaternion.from_matrix(quaternion.to_matrix(quat)), quat, 1e-15)
        axis, angle = quaternion.to_axis_angle(quat)
        assert_same(quaternion.from_axis_angle(axis, angle), quat, 1e-15)
        assert angle == pytest.approx(size, rel=1e-15, abs=1e-150)


def test_half_turns_about_the_axes_come_back_exactly():
    for axis in np.eye(3):
        R = 2.0 * np.outer(axis, axis) - np.eye(3)
        np.testing.assert_array_equal(quaternion.from_matrix(R), [0.0, *axis])


def test_no_rotation_has_the_z_axis_and_a_quaternion_and_its_negative_one_angle():
    axis, angle = quaternion.to_axis_angle([[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]])
    np.testing.assert_array_equal(axis, [[0.0, 0.0, 1.0]] * 2)
    np.testing.assert_array_equal(angle, [0.0, 0.0])


def test_the_axis_may_have_any_length_and_angles_broadcast():
    angles = np.linspace(-3.0, 3.0, 7)
    quats = quaternion.from_axis_angle([0.0, 0.0, 5.0], angles)
    np.testing.assert_allclose(quats[:, 3], np.sin(angles / 2.0))
    assert quaternion.from_axis_angle(np.eye(3), 0.3).shape == (3, 4)


def test_w_moves_to_the_end_for_others_and_back():
    quat = [1.0, 2.0, 3.0, 4.0]
    np.testing.assert_array_equal(quaternion.to_xyzw(quat), [2.0, 3.0, 4.0, 1.0])
    np.testing.assert_array_equal(quaternion.from_xyzw(quaternion.to_xyzw([quat])), [quat])


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_agree_with_scipy(sequence):
    angles = np.random.default_rng(5).uniform(-pi, pi, (50, 3))
    quat = quaternion.from_euler(angles, sequence)
    assert_same(quat, quaternion.from_xyzw(Rotation.from_euler(sequence, angles).as_quat()))
    back = quaternion.to_euler(quat, sequence)
    np.testing.assert_allclose(back, scipy_of(quat).as_euler(sequence), atol=1e-12)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_come_back_as_the_same_rotation_also_beside_gimbal_lock(sequence):
    middles = np.array([-pi, -pi / 2, 0.0, pi / 2, pi])
    beside = (middles[:, None] + np.array([0.0, 1e-14, 1e-12, 1e-9, 1e-7, 1e-3])).ravel()
    angles = np.array(list(product([0.4, -2.0], beside, [1.3, -0.2])))
    quat = quaternion.from_euler(angles, sequence)
    back = quaternion.to_euler(quat, sequence)
    assert_same(quaternion.from_euler(back, sequence), quat, 5e-12)
    assert (np.abs(back) <= pi + 1e-15).all()
    first_is_third = sequence[0] == sequence[2]
    low, high = (0.0, pi) if first_is_third else (-pi / 2, pi / 2)
    assert ((back[:, 1] >= low - 1e-15) & (back[:, 1] <= high + 1e-15)).all()


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_in_gimbal_lock_the_third_angle_is_zero(sequence):
    middle = 0.0 if sequence[0] == sequence[2] else pi / 2
    back = quaternion.to_euler(quaternion.from_euler([0.4, middle, 0.3], sequence), sequence)
    assert back[2] == 0.0


def test_roll_pitch_yaw_about_fixed_axes_is_yaw_pitch_roll_about_moving_ones():
    fixed = quaternion.from_euler([0.1, 0.2, 0.3], "xyz")
    assert_same(fixed, quaternion.from_euler([0.3, 0.2, 0.1], "ZYX"))
    turned = quaternion.rotate(quaternion.from_euler([0.0, 0.0, pi / 2], "xyz"), [1.0, 0.0, 0.0])
    np.testing.assert_allclose(turned, [0.0, 1.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("sequence", ["xy", "xxy", "xyy", "xyw", "Xyz", "", "xyzx"])
def test_a_sequence_that_is_none_is_refused(sequence):
    with pytest.raises(ValueError, match=f"sequence: want three of .* got '{sequence}'"):
        quaternion.from_euler([0.0, 0.0, 0.0], sequence)


@pytest.mark.property
@given(seeds, st.floats(0.0, 1.0))
@settings(deadline=None)
def test_slerp_goes_the_shorter_way_at_an_even_pace(seed, share):
    a, b = some(seed, 2)
    between = quaternion.slerp(a, b, share)
    whole = quaternion.angle_between(a, b)
    assert quaternion.angle_between(a, between) == pytest.approx(share * whole, abs=1e-14)
    rest = quaternion.angle_between(between, b)
    assert rest == pytest.approx((1.0 - share) * whole, abs=1e-14)
    assert_same(quaternion.slerp(a, -b, share), between)


def test_slerp_starts_exactly_and_broadcasts():
    a, b = some(3, 2)
    path = quaternion.slerp(a, b, np.linspace(0.0, 1.0, 11))
    assert path.shape == (11, 4)
    np.testing.assert_allclose(path[0], a, atol=1e-15)
    assert_same(path[-1], b)


@pytest.mark.parametrize("size", SIZES)
def test_the_angle_between_is_right_from_nothing_to_half_a_turn(size):
    a = some(8)
    b = quaternion.multiply(a, quaternion.exp(size * some_axis(9)))
    assert quaternion.angle_between(a, b) == pytest.approx(size, abs=1e-15, rel=1e-14)
    assert quaternion.angle_between(a, -b) == pytest.approx(size, abs=1e-15, rel=1e-14)
