from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, quaternion
from splinearm.kinematics.descent import Goal, descend, misses, rotation_vector

seeds = st.integers(0, 100_000)


def goal_of(arm, T, *, position_only=False):
    rows = 3 if position_only else 6
    weights = np.ones((rows, 1))
    weights[:3] = 8.0
    return Goal(
        p=T[:3, 3],
        R=None if position_only else T[:3, :3],
        lower=arm.limits.q_min,
        upper=arm.limits.q_max,
        weights=weights,
        units=np.ones(arm.n),
        position_tolerance=1e-6,
        orientation_tolerance=1e-6,
    )


@pytest.mark.parametrize("size", [0.0, 1e-200, 1e-12, 1e-6, 1.0, 3.0, 3.1, pi - 1e-9, pi])
def test_the_rotation_vector_agrees_with_quaternions_from_nothing_to_half_a_turn(size):
    rng = np.random.default_rng(2)
    for _ in range(20):
        axis = rng.normal(size=3)
        vector = size * axis / np.linalg.norm(axis)
        R = quaternion.to_matrix(quaternion.exp(vector))
        found = np.array(rotation_vector(R))
        assert np.linalg.norm(found) == pytest.approx(size, abs=2e-15, rel=1e-15)
        back = quaternion.exp(found)
        assert quaternion.angle_between(back, quaternion.exp(vector)) < 2e-15


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_from_a_near_seed_the_target_is_met_in_a_few_steps(widowx, joints_inside, seed):
    rng = np.random.default_rng(seed)
    q = joints_inside(widowx, rng)
    goal = goal_of(widowx, widowx.fk(q))
    start = np.clip(q + rng.uniform(-0.01, 0.01, 6), goal.lower, goal.upper)
    rest = descend(widowx.packed, goal, start, max_step=0.2, max_iterations=100)
    assert max(misses(widowx.packed, goal, rest.q)) <= 1e-6
    singular = np.linalg.svd(widowx.jacobian(q), compute_uv=False)[-1]
    if singular > 0.02:
        assert rest.iterations <= 8
        np.testing.assert_allclose(rest.q, q, atol=1e-4)


@pytest.mark.property
@given(seeds)
@settings(deadline=None)
def test_a_descent_never_leaves_the_limits_nor_gets_worse(widowx, joints_inside, seed):
    rng = np.random.default_rng(seed)
    start = joints_inside(widowx, rng)
    goal = goal_of(widowx, widowx.fk(rng.uniform(-pi, pi, 6)))
    costs = []
    for iterations in (1, 3, 10, 40):
        rest = descend(widowx.packed, goal, start, max_step=1.0, max_iterations=iterations)
        assert (rest.q >= goal.lower).all()
        assert (rest.q <= goal.upper).all()
        assert rest.iterations <= iterations
        costs.append(rest.cost)
    assert costs == sorted(costs, reverse=True)


def test_at_rest_on_limits_only_joints_that_would_go_beyond_still_feel_a_slope(widowx):
    goal = goal_of(widowx, widowx.fk([0.0, -2.2, 1.0, 0.0, 0.0, 0.0]), position_only=True)
    rest = descend(widowx.packed, goal, np.zeros(6), max_step=0.5, max_iterations=300)
    assert rest.at_rest
    slope = widowx.jacobian(rest.q)[:3].T @ (goal.p - widowx.fk(rest.q)[:3, 3])
    free = (rest.q > goal.lower) & (rest.q < goal.upper)
    np.testing.assert_allclose(slope[free], 0.0, atol=1e-6)
    assert (slope[rest.q == goal.lower] <= 0.0).all()
    assert (slope[rest.q == goal.upper] >= 0.0).all()


def test_a_straight_arm_finds_its_way_inwards(planar):
    goal = goal_of(planar, planar.fk([0.0, 0.0]), position_only=True)
    inwards = goal._replace(p=np.array([0.4, 0.0, 0.06]))
    rest = descend(planar.packed, inwards, np.zeros(2), max_step=0.2, max_iterations=100)
    assert rest.position_error < 1e-8


def test_nothing_is_done_where_the_target_is_already_met(planar):
    q = np.array([0.3, 0.4])
    rest = descend(planar.packed, goal_of(planar, planar.fk(q)), q, max_step=1.0, max_iterations=9)
    assert rest.iterations == 0
    np.testing.assert_array_equal(rest.q, q)


def test_a_step_is_no_longer_than_allowed(planar):
    goal = goal_of(planar, planar.fk([1.5, -1.0]), position_only=True)
    start = np.array([0.0, 0.5])
    rest = descend(planar.packed, goal, start, max_step=0.1, max_iterations=1)
    assert np.abs(rest.q - start).max() <= 0.1 + 1e-15


def test_a_step_that_helps_nothing_in_the_end_is_not_kept(planar):
    out_of_reach = goal_of(planar, planar.fk([0.0, 0.0]), position_only=True)
    out_of_reach = out_of_reach._replace(p=np.array([0.6, 0.0, 0.06]))
    for iterations in (1, 2, 5):
        rest = descend(
            planar.packed, out_of_reach, np.zeros(2), max_step=0.2, max_iterations=iterations
        )
        assert rest.position_error <= 0.05 + 1e-12


def test_a_joint_that_meets_its_limit_is_made_up_for_in_the_same_step(dh_arm):
    slide = JointKind.PRISMATIC
    rows = [DHLink("short", 0, 0, 0, 0, slide), DHLink("long", 0, 0, 0, 0, slide)]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=0.0, q_max=(0.1, 1.0))
    goal = goal_of(arm, arm.fk([0.1, 0.4]), position_only=True)
    rest = descend(arm.packed, goal, np.zeros(2), max_step=9.0, max_iterations=3)
    np.testing.assert_allclose(rest.q, [0.1, 0.4], atol=1e-6)
