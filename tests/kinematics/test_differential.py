"""Derivatives of the Jacobian, analytic Jacobians and manipulability, against differences."""

from math import pi

import numpy as np
import pytest

from splinearm.errors import KinematicsError
from splinearm.kinematics import DHConvention, DHLink, differential, quaternion

STEP = 1e-6


@pytest.fixture(scope="module")
def arms(random_arm):
    return [random_arm(seed, 2 + seed % 7, list(DHConvention)[seed % 2]) for seed in range(42)]


def postures(arm, seed, *m):
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (*m, arm.n))


def slopes(function, q):
    """Give the derivative of a function of joint vectors by each joint, joints leading."""
    steps = STEP * np.eye(len(q))
    return (function(q + steps) - function(q - steps)) / (2 * STEP)


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_the_hessian_is_the_difference_of_jacobians(arms, frame):
    for seed, arm in enumerate(arms):
        q = postures(arm, seed)
        wanted = slopes(lambda q, arm=arm: arm.jacobian(q, frame=frame), q)
        found = differential.hessian(arm, q, frame=frame)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-8)


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_the_rate_of_the_jacobian_is_its_difference_in_time(arms, frame):
    for seed, arm in enumerate(arms):
        q, qd = postures(arm, seed, 2)
        over, under = arm.jacobian([q + STEP * qd, q - STEP * qd], frame=frame)
        found = differential.jacobian_rate(arm, q, qd, frame=frame)
        np.testing.assert_allclose(found, (over - under) / (2 * STEP), rtol=0, atol=1e-8)


def test_the_quaternion_jacobian_is_the_difference_of_quaternions(arms):
    for seed, arm in enumerate(arms):
        q = postures(arm, seed)
        near = arm.fk(q)

        def poses(q, arm=arm, near=near):
            T = arm.fk(q)
            quat = quaternion.from_matrix(T[..., :3, :3])
            there = quaternion.from_matrix(near[:3, :3])
            quat *= np.sign(quat @ there)[..., None]
            return np.concatenate((T[..., :3, 3], quat), axis=-1)

        found = differential.quaternion_jacobian(arm, q)
        np.testing.assert_allclose(found, slopes(poses, q).T, rtol=0, atol=1e-8)


@pytest.mark.parametrize("sequence", ["xyz", "zyx", "ZYX", "XYZ", "zxz", "ZYZ", "YXY"])
def test_the_euler_jacobian_is_the_difference_of_angles(arms, sequence):
    compared = 0
    for seed, arm in enumerate(arms):
        q = postures(arm, seed)

        def angles(q, arm=arm):
            return quaternion.to_euler(quaternion.from_matrix(arm.fk(q)[..., :3, :3]), sequence)

        middle = angles(q)[1]
        if min(abs(np.sin(middle)), abs(np.cos(middle))) < 0.15:
            continue  # near a jump of the angles, where differences say nothing
        compared += 1
        found = differential.euler_jacobian(arm, q, sequence)
        steps = STEP * np.eye(arm.n)
        change = (angles(q + steps) - angles(q - steps) + pi) % (2 * pi) - pi
        np.testing.assert_allclose(found[3:], (change / (2 * STEP)).T, rtol=0, atol=1e-6)
        np.testing.assert_array_equal(found[:3], arm.jacobian(q)[:3])
    assert compared > 20


def test_gimbal_lock_is_named(dh_arm):
    rows = [DHLink("turn", 0.3, 0.0, 0.0, 0.0), DHLink("tilt", 0.3, pi / 2, 0.0, 0.0)]
    arm = dh_arm(rows, DHConvention.MODIFIED)
    tool = rotation_taking_z_to_x(arm.fk([0.0, 0.0]))
    locked = dh_arm(rows, DHConvention.MODIFIED, T_flange_tool=tool)
    with pytest.raises(KinematicsError, match=r"'xyz' have no rates where the second is -?90 deg"):
        differential.euler_jacobian(locked, [0.0, 0.0], "xyz")


def rotation_taking_z_to_x(T):
    """Give a tool that makes the pitch of an arm with pose T a right angle."""
    wanted = np.eye(4)
    wanted[:3, :3] = quaternion.to_matrix(quaternion.from_euler([0.0, pi / 2, 0.0], "xyz"))
    tool = np.eye(4)
    tool[:3, :3] = T[:3, :3].T @ wanted[:3, :3]
    return tool


def test_manipulability_is_yoshikawas(arms):
    for seed, arm in enumerate(arms):
        J = arm.jacobian(postures(arm, seed))
        for part, rows in (("all", J), ("position", J[:3]), ("orientation", J[3:])):
            small = rows @ rows.T if len(rows) <= arm.n else rows.T @ rows
            wanted = np.sqrt(max(np.linalg.det(small), 0.0))
            found = differential.manipulability(arm, postures(arm, seed), part=part)
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-7)


@pytest.mark.parametrize("part", ["all", "position", "orientation"])
def test_its_gradient_is_its_difference(arms, part):
    compared = 0
    for seed, arm in enumerate(arms):
        q = postures(arm, seed)
        if differential.manipulability(arm, q, part=part) < 1e-3:
            continue  # near the kink at a singularity, where differences say nothing
        compared += 1
        wanted = slopes(lambda q, arm=arm: differential.manipulability(arm, q, part=part), q)
        found = differential.manipulability_gradient(arm, q, part=part)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6)
    assert compared > 10


def test_the_gradient_is_finite_where_the_arm_is_singular(dh_arm):
    rows = [DHLink("shoulder", 0.3, 0.0, 0.0, 0.0), DHLink("elbow", 0.2, 0.0, 0.0, 0.0)]
    arm = dh_arm(rows, DHConvention.STANDARD)
    assert differential.manipulability(arm, [0.4, 0.0], part="position") < 1e-12
    slope = differential.manipulability_gradient(arm, [0.4, 0.0], part="position")
    # w = a1 a2 |sin elbow|
    np.testing.assert_allclose(np.abs(slope), [0.0, 0.06], rtol=0, atol=1e-12)


def test_batches_are_what_their_members_are(arms):
    for arm in arms[:7]:
        q, qd = postures(arm, 3, 2, 2, 3)
        for ask in (
            lambda q, qd, arm=arm: differential.hessian(arm, q),
            lambda q, qd, arm=arm: differential.jacobian_rate(arm, q, qd, frame="tool"),
            lambda q, qd, arm=arm: differential.quaternion_jacobian(arm, q),
            lambda q, qd, arm=arm: differential.euler_jacobian(arm, q, "ZYX"),
            lambda q, qd, arm=arm: differential.manipulability(arm, q),
            lambda q, qd, arm=arm: differential.manipulability_gradient(arm, q),
        ):
            whole = ask(q, qd)
            np.testing.assert_allclose(whole[1, 2], ask(q[1, 2], qd[1, 2]), rtol=0, atol=1e-10)


def test_wrong_words_are_refused(arms):
    arm = arms[0]
    q = np.zeros(arm.n)
    with pytest.raises(ValueError, match="part: want 'all', 'position' or 'orientation'"):
        differential.manipulability(arm, q, part="rotation")
    with pytest.raises(ValueError, match="frame: want 'base' or 'tool'"):
        differential.hessian(arm, q, frame="world")
    with pytest.raises(ValueError, match="qd: want finite numbers"):
        differential.jacobian_rate(arm, q, [0.0, np.nan])


@pytest.mark.kernel
@pytest.mark.parametrize("part", ["all", "position", "orientation"])
def test_kernels_of_one_posture_say_what_numpy_says_of_many(arms, part):
    for seed, arm in enumerate(arms[:14]):
        arm.compiled()
        q, qd = postures(arm, seed, 2)
        rate = differential.jacobian_rate(arm, q[None], qd[None])[0]
        np.testing.assert_allclose(differential.jacobian_rate(arm, q, qd), rate, rtol=0, atol=1e-13)
        volume = differential.manipulability(arm, q[None], part=part)[0]
        found = differential.manipulability(arm, q, part=part)
        assert found.shape == ()
        assert found == pytest.approx(volume, abs=1e-13)
        slopes = differential.manipulability_gradient(arm, q[None], part=part)[0]
        found = differential.manipulability_gradient(arm, q, part=part)
        np.testing.assert_allclose(found, slopes, rtol=1e-9, atol=1e-11)


@pytest.mark.kernel
def test_kernels_leave_singular_postures_to_the_singular_values(dh_arm):
    rows = [DHLink("one", 0.3, 0, 0, 0), DHLink("two", 0.2, 0, 0, 0)]
    arm = dh_arm(rows, DHConvention.STANDARD).compiled()
    gradient = differential.manipulability_gradient(arm, np.zeros(2), part="position")
    # the volume is |0.3 * 0.2 sin q|
    np.testing.assert_allclose(np.abs(gradient), [0.0, 0.06], atol=1e-15)
    with pytest.raises(ValueError, match="q: want finite numbers"):
        differential.manipulability(arm, np.array([0.0, np.nan]))
    with pytest.raises(ValueError, match="part: want"):
        differential.manipulability(arm, np.zeros(2), part="half")
