from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from splinearm.kinematics import quaternion, se3, space

seeds = st.integers(0, 100_000)
SIZES = [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 0.2999, 0.3001, 1.0, pi - 1e-4, pi - 1e-8, pi]


def hat(twist):
    v, (x, y, z) = twist[:3], twist[3:]
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    matrix[:3, 3] = v
    return matrix


def some_twist(seed, angle):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    return np.concatenate((rng.uniform(-1, 1, 3), angle * axis / np.linalg.norm(axis)))


def some_pose(seed, *batch):
    rng = np.random.default_rng(seed)
    T = np.zeros((*batch, 4, 4))
    T[..., :3, :3] = quaternion.to_matrix(quaternion.random(rng, *batch))
    T[..., :3, 3] = rng.uniform(-1, 1, (*batch, 3))
    T[..., 3, 3] = 1.0
    return T


@pytest.mark.property
@given(seeds, st.sampled_from(SIZES))
@settings(deadline=None)
def test_exp_is_the_matrix_exponential(seed, angle):
    twist = some_twist(seed, angle)
    np.testing.assert_allclose(se3.exp(twist), expm(hat(twist)), atol=2e-14, rtol=0)


@pytest.mark.property
@given(seeds, st.sampled_from(SIZES))
@settings(deadline=None)
def test_log_undoes_exp_near_no_turn_and_near_a_half_turn_too(seed, angle):
    twist = some_twist(seed, angle)
    found = se3.log(se3.exp(twist))
    np.testing.assert_allclose(se3.exp(found), se3.exp(twist), atol=4e-15, rtol=0)
    if angle < pi:
        np.testing.assert_allclose(found, twist, atol=4e-15, rtol=0)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_the_adjoint_is_a_homomorphism_and_carries_twists_along(seed):
    a, b = some_pose(seed, 2)
    product = se3.adjoint(a) @ se3.adjoint(b)
    np.testing.assert_allclose(se3.adjoint(a @ b), product, atol=1e-14)
    inverse = se3.adjoint(space.rigid_inverse(a))
    np.testing.assert_allclose(inverse @ se3.adjoint(a), np.eye(6), atol=1e-14)
    twist = some_twist(seed, 1.0)
    carried = a @ se3.exp(twist) @ space.rigid_inverse(a)
    np.testing.assert_allclose(se3.exp(se3.adjoint(a) @ twist), carried, atol=1e-14)


@pytest.mark.property
@given(seeds, st.floats(0.0, 1.0))
@settings(deadline=None)
def test_a_screw_motion_is_even_and_keeps_its_twist(seed, share):
    a, b = some_pose(seed, 2)
    whole = se3.log(space.rigid_inverse(a) @ b)
    part = se3.interpolate_screw(a, b, share)
    np.testing.assert_allclose(se3.log(space.rigid_inverse(a) @ part), share * whole, atol=1e-13)
    np.testing.assert_allclose(se3.interpolate_screw(a, b, [0.0, 1.0]), [a, b], atol=1e-14)


@pytest.mark.property
@given(seeds, st.floats(0.0, 1.0))
@settings(deadline=None)
def test_apart_the_origin_runs_straight_and_the_turn_is_even(seed, share):
    a, b = some_pose(seed, 2)
    T = se3.interpolate_apart(a, b, share)
    np.testing.assert_allclose(T[:3, 3], (1 - share) * a[:3, 3] + share * b[:3, 3], atol=1e-15)
    quats = quaternion.from_matrix(np.array([a, b, T])[:, :3, :3])
    whole = quaternion.angle_between(quats[0], quats[1])
    assert quaternion.angle_between(quats[0], quats[2]) == pytest.approx(share * whole, abs=1e-14)


def test_all_of_it_takes_batches():
    a, b = some_pose(1, 2, 3), some_pose(2, 2, 3)
    for function in (se3.interpolate_screw, se3.interpolate_apart):
        together = function(a, b, np.full((2, 3), 0.3))
        one_by_one = [[function(a[i, j], b[i, j], 0.3) for j in range(3)] for i in range(2)]
        np.testing.assert_allclose(together, one_by_one, atol=1e-15)
    assert se3.adjoint(a).shape == (2, 3, 6, 6)
    np.testing.assert_allclose(se3.adjoint(a)[1, 2], se3.adjoint(a[1, 2]), atol=0)
    np.testing.assert_allclose(se3.exp(se3.log(a)), a, atol=1e-14)
