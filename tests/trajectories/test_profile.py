"""Motions of constant jerk from phase to phase: asked, measured, slowed down and turned round."""

import numpy as np
import pytest

from splinearm.errors import LimitError
from splinearm.joints import JointKind, JointLimits, JointSetpoint
from splinearm.trajectories.point_to_point import point_to_point
from splinearm.trajectories.profile import JointProfile


def limits_of(n, *, jerk=30.0, q_max=np.inf):
    return JointLimits(
        names=tuple(f"joint{i}" for i in range(n)),
        kinds=(JointKind.REVOLUTE,) * (n - 1) + (JointKind.PRISMATIC,),
        q_min=np.full(n, -q_max),
        q_max=np.full(n, q_max),
        qd_max=np.full(n, 1.0),
        qdd_max=np.full(n, 3.0),
        qddd_max=None if jerk is None else np.full(n, jerk),
    )


def moving(seed, n=3, **options):
    """A motion from one moving state to another."""
    rng = np.random.default_rng(seed)
    most = min(1.0, 0.3 * (options.get("jerk") or 30.0))
    start, goal = (
        JointSetpoint(
            t=0.0,
            q=rng.normal(size=n),
            qd=rng.uniform(-0.8, 0.8, n),
            qdd=rng.uniform(-most, most, n),
        )
        for _ in range(2)
    )
    return point_to_point(limits_of(n, **options), start, goal)


@pytest.mark.kernel
@pytest.mark.parametrize("jerk", [30.0, None])
def test_velocity_acceleration_and_jerk_are_the_derivatives(jerk):
    profile = moving(1, jerk=jerk)
    h = 1e-5
    ts = np.linspace(0.01, profile.duration - 0.01, 57)
    nodes = profile.nodes()
    assert (nodes[0], nodes[-1]) == (0.0, profile.duration)
    ts = ts[np.abs(ts[:, None] - nodes).min(axis=1) > 2.0 * h]
    before, here, after = (profile.sample(ts + step) for step in (-h, 0.0, h))
    for k in (0, 1):
        np.testing.assert_allclose((after[k] - before[k]) / (2 * h), here[k + 1], atol=1e-7)
    np.testing.assert_allclose((after[2] - before[2]) / (2 * h), profile.jerk(ts), atol=1e-5)


@pytest.mark.kernel
def test_at_one_time_and_at_many_the_same_is_given_in_any_order():
    profile = moving(2)
    ts = np.random.default_rng(0).permutation(np.linspace(-0.1, profile.duration + 0.1, 41))
    q, qd, qdd = profile.sample(ts)
    for k, t in enumerate(ts):
        here = profile.at(t)
        assert here.t == t
        np.testing.assert_array_equal(np.stack((here.q, here.qd, here.qdd)), [q[k], qd[k], qdd[k]])


@pytest.mark.kernel
def test_before_the_start_and_after_the_end_the_joints_hold():
    profile = moving(3)
    for t, q in ((-1.0, profile.q_start), (profile.duration + 1.0, profile.q_goal)):
        here = profile.at(t)
        np.testing.assert_array_equal(here.q, q)
        assert not here.qd.any()
        assert not here.qdd.any()
    assert profile.at(profile.duration).qd.any()
    assert not profile.jerk([-1.0, profile.duration + 1.0]).any()


@pytest.mark.kernel
@pytest.mark.parametrize("t", [np.nan, np.inf])
def test_a_time_is_a_finite_number(t):
    profile = moving(3)
    with pytest.raises(ValueError, match="t: want a finite time"):
        profile.at(t)
    with pytest.raises(ValueError, match="ts: want finite numbers"):
        profile.sample([t])


@pytest.mark.kernel
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("jerk", [30.0, 1.0, None])
def test_the_range_is_the_lowest_and_highest_place_and_when(seed, jerk):
    profile = moving(seed, jerk=jerk)
    ts = np.linspace(0.0, profile.duration, 4001)
    q = profile.sample(ts)[0]
    span = profile.position_range()
    np.testing.assert_allclose(span.q_low, q.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(span.q_high, q.max(axis=0), atol=1e-6)
    assert (span.q_low <= q.min(axis=0) + 1e-15).all()
    assert (span.q_high >= q.max(axis=0) - 1e-15).all()
    for i in range(3):
        assert profile.at(span.t_low[i]).q[i] == pytest.approx(span.q_low[i], abs=1e-12)
        assert profile.at(span.t_high[i]).q[i] == pytest.approx(span.q_high[i], abs=1e-12)


@pytest.mark.kernel
def test_a_position_beyond_its_limit_is_named_in_the_unit_of_the_joint():
    profile = moving(1, n=2)
    high = profile.position_range().q_high
    inside = JointProfile(limits_of(2, q_max=3.0), profile.phases)
    inside.check_positions()
    tight = limits_of(2)
    object.__setattr__(tight, "q_max", high - [-1.0, 1e-3])
    with pytest.raises(LimitError, match=r"joint 'joint1': position .* mm is above"):
        JointProfile(tight, profile.phases).check_positions()


@pytest.mark.kernel
@pytest.mark.parametrize("jerk", [30.0, None])
def test_backwards_it_passes_the_same_states_in_reverse(jerk):
    profile = moving(4, jerk=jerk)
    back = profile.reversed()
    ts = np.linspace(0.0, profile.duration, 200)[1:-1]
    there, here = profile.sample(profile.duration - ts), back.sample(ts)
    for k, sign in enumerate((1.0, -1.0, 1.0)):
        np.testing.assert_allclose(here[k], sign * there[k], atol=1e-12)
    np.testing.assert_allclose(back.jerk(ts), -profile.jerk(profile.duration - ts), atol=1e-12)
    np.testing.assert_array_equal(back.q_start, profile.q_goal)


@pytest.mark.kernel
def test_at_a_share_of_its_speed_it_goes_the_same_way():
    profile = moving(5)
    slow = profile.scaled(0.5)
    ts = np.linspace(0.0, profile.duration, 50)
    for k, factor in enumerate((1.0, 0.5, 0.25)):
        np.testing.assert_allclose(
            slow.sample(2.0 * ts)[k], factor * profile.sample(ts)[k], atol=1e-12
        )
    assert slow.duration == pytest.approx(2.0 * profile.duration)
    with pytest.raises(ValueError, match="share: want above 0 and at most 1"):
        profile.scaled(1.5)


@pytest.mark.parametrize(
    ("phases", "message"),
    [
        (np.zeros((2, 1, 5)), r"phases: want shape \(1, any, 5\)"),
        (np.zeros((1, 0, 5)), "begin at 0"),
        (np.ones((1, 2, 5)), "begin at 0"),
        ([[[0.0] * 5, [2.0] * 5, [1.0] * 5]], "do not fall"),
    ],
)
def test_phases_that_are_no_motion_are_refused(phases, message):
    with pytest.raises(ValueError, match=message):
        JointProfile(limits_of(1), phases)


def test_joints_that_end_apart_are_refused():
    phases = np.zeros((2, 2, 5))
    phases[:, 1, 0] = 1.0, 2.0
    with pytest.raises(ValueError, match="all end at the same time"):
        JointProfile(limits_of(2), phases)
