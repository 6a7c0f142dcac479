from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import DHConvention, IKStatus, verdict
from splinearm.kinematics.descent import Goal, descend


def place(arm, p):
    return Goal(
        p=np.asarray(p),
        R=None,
        lower=arm.limits.q_min,
        upper=arm.limits.q_max,
        weights=np.full((3, 1), 8.0),
        units=np.ones(arm.n),
        position_tolerance=1e-6,
        orientation_tolerance=1e-6,
    )


@pytest.fixture(scope="module")
def stuck(planar):
    """A reachable goal and a descent that a limit keeps from it."""
    goal = place(planar, [-0.4, 0.0, 0.06])
    rest = descend(planar.packed, goal, np.array([0.0, 0.1]), max_step=0.2, max_iterations=100)
    assert rest.position_error > 0.1
    return goal, rest


def test_an_answer_found_while_looking_for_the_reason_is_given(planar, stuck):
    goal, rest = stuck
    found = verdict.why_not(planar, goal, [rest], may_jump=True)
    assert found.rest.position_error <= 1e-6
    assert (found.rest.q >= goal.lower).all()
    assert (found.rest.q <= goal.upper).all()


def test_but_not_when_the_seeds_branch_was_asked_for(planar, stuck):
    goal, rest = stuck
    found = verdict.why_not(planar, goal, [rest], may_jump=False)
    assert found.status is IKStatus.NOT_CONVERGED
    np.testing.assert_array_equal(found.rest.q, rest.q)


@pytest.mark.property
@given(st.integers(0, 100_000), st.integers(2, 8), st.sampled_from(list(DHConvention)))
@settings(deadline=None)
def test_nothing_within_the_limits_is_called_out_of_reach(
    random_arm, joints_inside, seed, n, convention
):
    arm = random_arm(seed, n, convention)
    for p in arm.fk(joints_inside(arm, np.random.default_rng(seed), 20))[:, :3, 3]:
        assert not verdict.is_out_of_reach(arm, place(arm, p))


def test_the_stretch_of_a_planar_arm_is_exact(planar):
    for turn in np.linspace(-pi, pi, 7):
        way = np.array([np.cos(turn), np.sin(turn), 0.0])
        assert verdict.is_out_of_reach(planar, place(planar, 0.55001 * way + [0.0, 0.0, 0.06]))
        assert not verdict.is_out_of_reach(planar, place(planar, 0.55 * way + [0.0, 0.0, 0.06]))
