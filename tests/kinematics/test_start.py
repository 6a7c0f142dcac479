from math import inf, pi

import numpy as np
import pytest

from splinearm.kinematics import start
from splinearm.kinematics.descent import Goal


def goal_at(arm, T):
    return Goal(
        p=T[:3, 3],
        R=T[:3, :3],
        lower=arm.limits.q_min,
        upper=arm.limits.q_max,
        weights=np.ones((6, 1)),
        units=np.ones(arm.n),
        position_tolerance=1e-6,
        orientation_tolerance=1e-6,
    )


def test_starts_fill_the_limits_evenly_and_are_always_the_same():
    lower, upper = np.array([-1.0, 0.0, 2.0]), np.array([1.0, 0.5, 2.5])
    starts = start.spread(lower, upper, np.ones(3), 400)
    assert ((starts >= lower) & (starts <= upper)).all()
    np.testing.assert_array_equal(starts, start.spread(lower, upper, np.ones(3), 400))
    cells = np.floor((starts - lower) / (upper - lower) * 4.0).astype(int)
    counts = np.unique(cells, axis=0, return_counts=True)[1]
    assert len(counts) == 64
    assert counts.max() <= 12


def test_joints_without_limits_are_spread_over_a_turn():
    starts = start.spread(np.full(2, -inf), np.full(2, inf), np.ones(2), 200)
    assert np.abs(starts).max() <= pi
    assert np.ptp(starts, axis=0).min() > 1.9 * pi


def test_nearest_first_is_in_the_order_of_the_miss(widowx, joints_inside):
    q = joints_inside(widowx, np.random.default_rng(1), 50)
    T = widowx.fk(q[17])
    goal = goal_at(widowx, T)
    ordered = start.nearest_first(widowx.packed, goal, q)
    np.testing.assert_array_equal(ordered[0], q[17])
    assert sorted(map(tuple, ordered)) == sorted(map(tuple, q))
    by_position = goal._replace(R=None, weights=np.ones((3, 1)))
    distances = np.linalg.norm(
        widowx.fk(start.nearest_first(widowx.packed, by_position, q))[:, :3, 3] - T[:3, 3], axis=1
    )
    assert (np.diff(distances) >= 0.0).all()


@pytest.mark.parametrize("count", [1, 10, 24, 25, 60, 1024, 1100])
def test_near_and_far_gives_as_many_different_starts_as_asked_the_nearest_first(widowx, count):
    T = widowx.fk(np.full(6, 0.2))
    goal = goal_at(widowx, T)
    starts = start.near_and_far(widowx.packed, goal, count)
    assert len(np.unique(starts, axis=0)) == count
    all_of_them = start.spread(goal.lower, goal.upper, goal.units, max(start.CANDIDATES, count))
    nearest = start.nearest_first(widowx.packed, goal, all_of_them)
    np.testing.assert_array_equal(
        starts[: min(count, start.NEAREST)], nearest[: min(count, start.NEAREST)]
    )
