import numpy as np
import pytest

from splinearm.control.forecast import forecast_stops, joint_travel
from splinearm.joints import JointKind, JointLimits
from splinearm.trajectories.plan import plan_joint_move

pytestmark = pytest.mark.kernel

START, GOAL = np.array([0.0, 0.5]), np.array([1.2, -1.4])


def tool(q):
    """Where the end of two links of 1 m is."""
    a, b = q[:, 0], q[:, 0] + q[:, 1]
    return np.stack((np.cos(a) + np.cos(b), np.sin(a) + np.sin(b), np.zeros_like(a)), axis=1)


def test_no_stop_takes_longer_or_goes_farther_than_was_foretold(limits):
    motion = plan_joint_move(limits, START, GOAL)
    forecast = forecast_stops(motion, tool)
    for t in np.linspace(0.0, motion.duration, 57):
        stop = motion.stop_from(t)
        q, _, _ = stop.sample(np.linspace(0.0, stop.duration, 40))
        way = np.linalg.norm(np.diff(tool(q), axis=0), axis=1).sum()
        assert stop.duration <= forecast.time * 1.02
        assert way <= forecast.tool * 1.02
        assert np.abs(stop.q_goal - stop.q_start).max() <= forecast.travel * 1.02
    assert forecast.joint == "elbow"
    assert "deg of joint 'elbow'" in forecast.words
    assert "mm of the tool's path" in forecast.words


def test_without_a_tool_nothing_is_said_of_it(limits):
    forecast = forecast_stops(plan_joint_move(limits, START, GOAL))
    assert np.isnan(forecast.tool)
    assert "tool" not in forecast.words


def test_a_sliding_joint_goes_on_by_millimetres(limits):
    sliding = JointLimits(
        names=limits.names,
        kinds=(JointKind.PRISMATIC,) * 2,
        q_min=limits.q_min,
        q_max=limits.q_max,
        qd_max=limits.qd_max,
        qdd_max=limits.qdd_max,
    )
    motion = plan_joint_move(sliding, START, GOAL)
    assert forecast_stops(motion).words.endswith("mm of joint 'elbow'")
    assert " mm of joint 'elbow'" in joint_travel(motion.stop_from(0.5 * motion.duration))


def test_a_motion_that_does_not_move_needs_no_stop(limits):
    forecast = forecast_stops(plan_joint_move(limits, START, START), tool)
    assert (forecast.time, forecast.tool, forecast.travel) == (0.0, 0.0, 0.0)
