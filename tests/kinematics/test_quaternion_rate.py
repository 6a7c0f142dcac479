import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import quaternion, quaternion_rate

seeds = st.integers(0, 100_000)
FRAMES = ["fixed", "moving"]


def way(seed):
    """A turning frame: a quaternion as a function of t, by way of rotation vectors."""
    rng = np.random.default_rng(seed)
    start, (b, c, d) = quaternion.random(rng), rng.uniform(-1, 1, (3, 3))
    return lambda t: quaternion.multiply(start, quaternion.exp(b * t + c * t**2 + d * np.sin(t)))


@pytest.mark.property
@given(seeds, st.sampled_from(FRAMES))
@settings(deadline=None)
def test_rates_and_derivatives_are_each_others_inverse(seed, frame):
    rng = np.random.default_rng(seed)
    quat = quaternion.random(rng, 5)
    omega, alpha = rng.normal(size=(2, 5, 3))
    quat_d = quaternion_rate.derivative(quat, omega, frame)
    quat_dd = quaternion_rate.second_derivative(quat, omega, alpha, frame)
    back = quaternion_rate.angular_velocity(quat, quat_d, frame)
    np.testing.assert_allclose(back, omega, atol=1e-14)
    back = quaternion_rate.angular_acceleration(quat, quat_dd, frame)
    np.testing.assert_allclose(back, alpha, atol=1e-14)
    # the length stays 1: q.q' = 0 and q.q'' + q'.q' = 0
    np.testing.assert_allclose(np.sum(quat * quat_d, -1), 0.0, atol=1e-14)
    np.testing.assert_allclose(np.sum(quat * quat_dd + quat_d**2, -1), 0.0, atol=1e-14)


@pytest.mark.property
@given(seeds, st.sampled_from(FRAMES))
@settings(deadline=None)
def test_the_angular_velocity_is_what_a_small_step_turns(seed, frame):
    turn, h = way(seed), 1e-4
    quat, after, before = turn(0.4), turn(0.4 + h), turn(0.4 - h)
    quat_d, quat_dd = (after - before) / (2 * h), (after - 2 * quat + before) / h**2
    omega = quaternion_rate.angular_velocity(quat, quat_d, frame)
    moved = (
        quaternion.multiply(after, quaternion.conjugate(before))
        if frame == "fixed"
        else quaternion.multiply(quaternion.conjugate(before), after)
    )
    np.testing.assert_allclose(omega, quaternion.log(moved) / (2 * h), atol=1e-6)
    second = quaternion_rate.second_derivative(
        quat, omega, quaternion_rate.angular_acceleration(quat, quat_dd, frame), frame
    )
    np.testing.assert_allclose(second, quat_dd, atol=1e-6)


def test_the_two_frames_are_turned_into_each_other_by_the_quaternion():
    turn, h = way(3), 1e-5
    quat, quat_d = turn(0.1), (turn(0.1 + h) - turn(0.1 - h)) / (2 * h)
    fixed, moving = (quaternion_rate.angular_velocity(quat, quat_d, frame) for frame in FRAMES)
    np.testing.assert_allclose(quaternion.rotate(quat, moving), fixed, atol=1e-12)


def test_a_frame_that_is_neither_is_refused():
    with pytest.raises(ValueError, match="'fixed' or 'moving', got 'world'"):
        quaternion_rate.derivative([1, 0, 0, 0], [0, 0, 1], "world")
