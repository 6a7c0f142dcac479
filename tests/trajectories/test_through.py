"""Motions through waypoints without stopping there."""

from itertools import pairwise

import numpy as np
import pytest

from splinearm.errors import LimitError
from splinearm.joints import JointKind, JointLimits, JointSetpoint
from splinearm.trajectories.point_to_point import point_to_point
from splinearm.trajectories.through import through


def limits_of(n, *, jerk=20.0, q_max=np.inf):
    return JointLimits(
        names=tuple(f"joint{i}" for i in range(n)),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -q_max),
        q_max=np.full(n, q_max),
        qd_max=np.linspace(1.0, 1.5, n),
        qdd_max=np.linspace(3.0, 2.0, n),
        qddd_max=None if jerk is None else np.full(n, jerk),
    )


def stopping(limits, waypoints):
    """How long it takes to stop at each waypoint."""
    return sum(point_to_point(limits, *pair).duration for pair in pairwise(waypoints))


@pytest.mark.parametrize(("n", "m"), [(1, 4), (3, 5), (7, 4)])
def test_waypoints_are_passed_in_time_within_limits_and_quicker_than_by_stopping(n, m):
    limits = limits_of(n)
    for seed in range(3):
        Q = np.random.default_rng(seed).uniform(-2, 2, (m, n))
        profile, times = through(limits, Q)
        np.testing.assert_allclose(profile.sample(times)[0], Q, atol=1e-12)
        assert times[-1] == profile.duration
        assert profile.duration < stopping(limits, Q)
        _, qd, qdd = profile.sample(np.linspace(0.0, profile.duration, 20_001))
        assert (np.abs(qd) <= limits.qd_max * (1 + 1e-9)).all()
        assert (np.abs(qdd) <= limits.qdd_max * (1 + 1e-9)).all()
        assert (np.abs(profile.phases[:, :, 4]) <= 20.0 * (1 + 1e-9)).all()
        # C2 also where segments join
        steps = np.abs(np.diff(qdd, axis=0)) / (profile.duration / 20_000)
        assert steps.max() <= 20.0 * (1 + 1e-6)


@pytest.mark.kernel
@pytest.mark.parametrize("jerk", [20.0, None])
def test_waypoints_on_a_straight_way_cost_next_to_nothing(jerk):
    limits = limits_of(2, jerk=jerk)
    ends = np.array([[0.0, 0.0], [2.0, -3.0]])
    Q = ends[0] + np.array([[0.0], [0.3], [0.6], [1.0]]) * ends[1]
    profile, _ = through(limits, Q)
    straight = point_to_point(limits, *ends).duration
    assert straight * (1.0 - 1e-12) <= profile.duration <= 1.005 * straight


def test_one_joint_passes_one_waypoint_as_quickly_as_any_search_finds():
    limits = limits_of(1)
    Q = np.array([[0.0], [0.8], [0.2]])
    profile, times = through(limits, Q)

    def duration(qd, qdd):
        here = JointSetpoint(t=0.0, q=Q[1], qd=[qd], qdd=[qdd])
        return stopping(limits, [Q[0], here, Q[2]])

    best = min(
        duration(qd, qdd)
        for qd in np.linspace(-0.6, 0.6, 31)
        for qdd in np.linspace(-3.0, 3.0, 31)
        if abs(qd) + qdd**2 / 40.0 <= 1.0
    )
    assert profile.duration <= best + 1e-3
    assert times[1] < profile.duration


@pytest.mark.kernel
def test_whole_states_are_kept_as_they_are():
    limits = limits_of(2)
    rest = JointSetpoint(t=0.0, q=[1.0, 0.5], qd=[0.0, 0.0], qdd=[0.0, 0.0])
    moving = JointSetpoint(t=0.0, q=[0.0, 0.0], qd=[0.5, -0.2], qdd=[0.3, 0.0])
    profile, times = through(limits, [moving, rest, [0.2, 0.1], [1.0, 1.0]])
    start, stop = profile.at(0.0), profile.at(times[1])
    np.testing.assert_allclose(start.qd, moving.qd)
    np.testing.assert_allclose(start.qdd, moving.qdd)
    np.testing.assert_allclose(stop.qd, 0.0, atol=1e-12)
    assert np.abs(profile.at(times[2]).qd).max() > 0.05


@pytest.mark.kernel
def test_two_waypoints_are_a_motion_from_point_to_point():
    limits = limits_of(3)
    Q = np.random.default_rng(1).normal(size=(2, 3))
    profile, times = through(limits, Q)
    np.testing.assert_array_equal(profile.phases, point_to_point(limits, *Q).phases)
    np.testing.assert_array_equal(times, [0.0, profile.duration])


@pytest.mark.kernel
def test_where_speed_would_carry_a_joint_beyond_its_position_it_passes_more_slowly():
    Q = np.array([[0.0, 0.0], [0.9, 1.0], [1.0, -0.5], [-1.0, 0.9]])
    free, _ = through(limits_of(2), Q)
    high = free.position_range().q_high
    assert high.max() > 1.01
    profile, times = through(limits_of(2, q_max=1.0), Q)
    span = profile.position_range()
    assert max(span.q_high.max(), -span.q_low.min()) <= 1.0 + 1e-9
    np.testing.assert_allclose(profile.sample(times)[0], Q, atol=1e-12)
    assert profile.duration <= stopping(limits_of(2), Q) * (1 + 1e-12)


@pytest.mark.kernel
def test_a_waypoint_beyond_a_position_is_refused():
    with pytest.raises(LimitError, match="position"):
        through(limits_of(1, q_max=1.0), [[0.0], [1.1], [0.0]])


@pytest.mark.parametrize(
    ("waypoints", "message"),
    [
        ([[0.0]], "waypoints: want at least 2, got 1"),
        ([[0.0], [1.0], [1.0]], "waypoints: 1 and 2 are the same place"),
        ([[0.0], [np.nan]], "waypoint 1: want finite numbers"),
        ([[0.0], [1.0, 2.0]], r"waypoint 1: want shape \(1\)"),
    ],
)
def test_waypoints_that_are_no_way_are_refused(waypoints, message):
    with pytest.raises(ValueError, match=message):
        through(limits_of(1), waypoints)
