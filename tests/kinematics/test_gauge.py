import numpy as np
import pytest

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, Link, chain, gauge, space


@pytest.mark.parametrize("seed", range(25))
def test_any_turning_arm_is_found_again_in_its_simplest_frames(random_arm, seed):
    rng = np.random.default_rng(seed)
    convention = DHConvention.STANDARD if seed % 2 else DHConvention.MODIFIED
    arm = random_arm(seed, 2 + seed % 6, convention, slides=False)
    found = gauge.find(arm.packed)
    q = rng.uniform(-3.0, 3.0, arm.n)
    np.testing.assert_allclose(gauge.forward(found, q), arm.fk(q), atol=1e-12)


def test_every_arm_with_a_closed_form_is_found_again(closed_arms):
    rng = np.random.default_rng(0)
    for arm in closed_arms.values():
        q = rng.uniform(-3.0, 3.0, arm.n)
        found = gauge.find(arm.packed)
        np.testing.assert_allclose(gauge.forward(found, q), arm.fk(q), atol=1e-12)


def test_what_is_zero_is_exactly_zero_and_parallel_axes_point_the_same_way(closed_arms):
    rows = gauge.find(closed_arms["koch"].packed).rows
    np.testing.assert_array_equal(rows[1:3, 2:], ((1.0, 0.0), (1.0, 0.0)))
    np.testing.assert_array_equal(rows[[0, 3], 2], 0.0)
    rows = gauge.find(closed_arms["puma"].packed).rows
    np.testing.assert_array_equal(rows[[0, 3, 4], 0], 0.0)


def test_a_chain_seen_from_its_tool_is_the_inverse(random_arm):
    arm = random_arm(3, 6, DHConvention.STANDARD)
    q = np.random.default_rng(1).uniform(-1.0, 1.0, 6)
    back = chain.fk(gauge.reverse(arm.packed), -q[::-1])
    np.testing.assert_allclose(back @ arm.fk(q), np.eye(4), atol=1e-12)


@pytest.mark.parametrize("joint", range(6))
def test_a_locked_joint_stands_still(random_arm, joint):
    arm = random_arm(5, 6, DHConvention.MODIFIED)
    q = np.random.default_rng(2).uniform(-1.0, 1.0, 6)
    locked = gauge.lock(arm.packed, joint, q[joint])
    np.testing.assert_allclose(chain.fk(locked, np.delete(q, joint)), arm.fk(q), atol=1e-12)


def test_axes_so_nearly_parallel_that_they_meet_far_away_are_refused():
    second = space.translation((0.3, 0.0, 0.0)) @ space.rotation_y(1e-6)
    links = (
        Link("first", JointKind.REVOLUTE, np.eye(4), np.eye(4)),
        Link("second", JointKind.REVOLUTE, second, np.eye(4)),
    )
    with pytest.raises(ValueError, match="nearly parallel"):
        gauge.find(chain.pack(links, np.eye(4), space.translation((0.2, 0.0, 0.0))))
