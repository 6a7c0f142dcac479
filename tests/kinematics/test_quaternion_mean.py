"""Squad, means and random rotations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from splinearm.kinematics import quaternion

seeds = st.integers(0, 100_000)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_squad_goes_through_its_rotations_without_a_jump_of_speed(seed):
    rng = np.random.default_rng(seed)
    # steps of less than a right angle: the shorter way is then never in doubt
    steps = quaternion.exp(rng.uniform(-0.7, 0.7, (4, 3)))
    quats = [quaternion.random(rng)]
    for step in steps:
        quats.append(quaternion.multiply(quats[-1], step))
    quats = np.array(quats)
    controls = quaternion.squad_controls(quats)
    h = 1e-6
    for i in range(1, 4):
        before = quats[i - 1], controls[i - 1], controls[i], quats[i]
        after = quats[i], controls[i], controls[i + 1], quats[i + 1]
        at_end, at_start = quaternion.squad(*before, 1.0), quaternion.squad(*after, 0.0)
        assert quaternion.angle_between(at_end, quats[i]) < 1e-14
        assert quaternion.angle_between(at_start, quats[i]) < 1e-14
        arriving = quaternion.log(
            quaternion.multiply(quaternion.conjugate(quaternion.squad(*before, 1.0 - h)), quats[i])
        )
        leaving = quaternion.log(
            quaternion.multiply(quaternion.conjugate(quats[i]), quaternion.squad(*after, h))
        )
        np.testing.assert_allclose(arriving / h, leaving / h, atol=2e-4)


def test_squad_takes_batches():
    a, b, c, d = quaternion.random(np.random.default_rng(1), 4, 6)
    shares = np.linspace(0, 1, 6)
    together = quaternion.squad(a, b, c, d, shares)
    for i in range(6):
        one = quaternion.squad(a[i], b[i], c[i], d[i], shares[i])
        np.testing.assert_allclose(together[i], one, atol=1e-15)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_the_mean_is_scipys_and_does_not_ask_for_signs(seed):
    rng = np.random.default_rng(seed)
    quats, weights = quaternion.random(rng, 5), rng.uniform(0.1, 1.0, 5)
    signs = rng.choice([-1.0, 1.0], (5, 1))
    mean = quaternion.average(signs * quats, weights)
    wanted = Rotation.from_quat(quaternion.to_xyzw(quats)).mean(weights)
    wanted = quaternion.from_xyzw(wanted.as_quat())
    assert quaternion.angle_between(mean, wanted) < 1e-12


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_the_mean_of_two_is_half_the_way_and_turns_with_them(seed):
    rng = np.random.default_rng(seed)
    a, turn = quaternion.random(rng, 2)
    b = quaternion.multiply(a, quaternion.exp(rng.uniform(-1, 1, 3)))
    middle = quaternion.average([a, b])
    assert quaternion.angle_between(middle, quaternion.slerp(a, b, 0.5)) < 1e-13
    turned = quaternion.average(quaternion.multiply(turn, [a, b]))
    assert quaternion.angle_between(turned, quaternion.multiply(turn, middle)) < 1e-13


def test_means_are_taken_over_batches():
    quats = quaternion.random(np.random.default_rng(1), 4, 5)
    means = quaternion.average(quats)
    assert means.shape == (4, 4)
    np.testing.assert_allclose(means[2], quaternion.average(quats[2]), atol=1e-15)


def test_rotations_without_one_mean_are_refused():
    with pytest.raises(ValueError, match="several"):
        quaternion.average([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])


def test_random_rotations_turn_every_direction_to_everywhere():
    quats = quaternion.random(np.random.default_rng(1), 20_000)
    assert quats.shape == (20_000, 4)
    np.testing.assert_allclose(np.linalg.norm(quats, axis=-1), 1.0, atol=1e-15)
    images = quaternion.rotate(quats, [1.0, 0.0, 0.0])
    np.testing.assert_allclose(images.mean(axis=0), 0.0, atol=0.02)
    np.testing.assert_allclose(images.T @ images / 20_000, np.eye(3) / 3.0, atol=0.01)
    # of rotations drawn uniformly the angle has density (1 - cos x) / pi, mean pi/2 + 2/pi
    angles = quaternion.to_axis_angle(quats)[1]
    assert angles.mean() == pytest.approx(np.pi / 2 + 2 / np.pi, abs=0.02)
