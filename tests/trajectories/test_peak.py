from dataclasses import replace

import numpy as np
import pytest

from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.peak import bindings, peaks
from splinearm.trajectories.section import Section
from splinearm.trajectories.time_law import TimeLaw
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.trajectory import JointTrajectory


def straight_motion(limits, q_goal):
    path = straight_path(np.zeros(len(q_goal)), np.array(q_goal))
    return JointTrajectory((Section(path, quickest(path, limits)),), np.zeros(len(q_goal)), limits)


def test_a_trapezoid_is_held_back_by_acceleration_speed_and_acceleration(make_limits):
    motion = straight_motion(make_limits([1.0, 2.0], [2.0, 9.0]), [3.0, 0.5])
    told = [(b.joint, b.quantity) for b in bindings(motion)]
    assert told == [("joint0", "acceleration"), ("joint0", "velocity"), ("joint0", "acceleration")]
    edges = [bindings(motion)[0].start, *(b.end for b in bindings(motion))]
    assert edges == pytest.approx([0.0, 0.5, 3.0, 3.5])
    assert all(b.share == pytest.approx(1.0, abs=1e-6) for b in bindings(motion))


def test_at_half_speed_no_joint_is_at_a_limit(make_limits):
    (free,) = bindings(straight_motion(make_limits([1.0], [2.0]), [3.0]).scaled(0.5))
    assert (free.joint, free.quantity) == (None, None)
    assert free.share == pytest.approx(0.5, abs=1e-6)


def test_jerk_is_looked_at_where_it_is_limited(make_limits):
    limits = replace(make_limits([1.0], [2.0]), qddd_max=[10.0])
    path = straight_path(np.zeros(1), np.ones(1))
    # the parameter is s = 3 u^2 - 2 u^3 of time by a path that is itself cubic
    cubic = path.__class__(type(path.curve)([0, 0, 0, 0, 4, 4, 4, 4], [[0], [0], [1], [1]], 3))
    motion = JointTrajectory(
        (Section(cubic, TimeLaw(np.array([0.0, 4.0]), np.ones(2))),), np.zeros(1), limits
    )
    (jerk,) = [peak for peak in peaks(motion) if peak.quantity == "jerk"]
    assert jerk.value == pytest.approx(-12.0 / 64.0)
    assert jerk.limit == 10.0


def test_a_motion_that_takes_no_time_is_not_held_back(make_limits):
    assert bindings(JointTrajectory((), np.zeros(1), make_limits([1.0], [2.0]))) == ()
