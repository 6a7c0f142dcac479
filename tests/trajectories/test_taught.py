"""Taught motions: planned as they were led, or as quick as can be, with their rests."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.errors import LimitError
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.taught import TaughtMotion, plan_taught

CELL = load_cell("planar_2r")


def taught(**more) -> TaughtMotion:
    home = np.array(CELL.poses["home"])
    swing = np.array([[0, 0], [0, 0], [0.2, 0.1], [0.5, -0.2], [0.2, 0.3], [0.1, 0.2], [0.1, 0.2]])
    wanted = {
        "names": CELL.arm.joint_names,
        "degree": 3,
        "knots": [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0],
        "points": home + swing,
        "rests": ((1.5, 0.8),),
    }
    return TaughtMotion(**(wanted | more))


def test_recorded_it_takes_as_long_as_it_was_led():
    motion = taught()
    plan = plan_taught(motion, CELL.arm)
    assert motion.duration == 4.8
    assert motion.duration <= plan.trajectory.duration < motion.duration * 1.15
    assert plan.waypoint_times[0] == pytest.approx(1.5, abs=0.2)


def test_it_stands_where_and_as_long_as_the_hand_paused():
    motion = taught()
    for timing in ("recorded", "fastest"):
        plan = plan_taught(motion, CELL.arm, timing=timing)
        at = plan.waypoint_times[0]
        for share in (0.01, 0.5, 0.99):
            setpoint = plan.trajectory.at(at + 0.8 * share)
            np.testing.assert_allclose(setpoint.q, motion.curve.at(1.5), atol=1e-12)
            assert not setpoint.qd.any()


def test_the_way_is_the_one_that_was_led():
    motion = taught()
    plan = plan_taught(motion, CELL.arm, CELL.arm.limits.scaled(0.3), timing="fastest")
    q, _, _ = plan.trajectory.sample(np.linspace(0.0, plan.trajectory.duration, 300))
    way = motion.curve.at(np.linspace(0.0, 4.0, 4001))
    assert np.abs(q[:, None] - way[None]).max(axis=2).min(axis=1).max() < 1e-3
    assert plan.tool_path.distance(CELL.arm.fk(q)[:, :3, 3]).max() < 1e-9


def test_fastest_is_quicker_and_both_slow_down_with_the_limits():
    motion = taught(rests=())
    slow = CELL.arm.limits.scaled(0.1)
    fast = plan_taught(motion, CELL.arm, timing="fastest").trajectory.duration
    assert fast < 2.0
    late = plan_taught(motion, CELL.arm, slow).trajectory.duration
    assert late == pytest.approx(10.0 * fast, rel=0.1)


def test_limits_of_the_tool_are_kept_too():
    limits = MotionLimits(joints=CELL.arm.limits, arm=CELL.arm, tool_speed=0.1)
    plan = plan_taught(taught(), CELL.arm, limits, timing="fastest")
    t = np.linspace(0.0, plan.trajectory.duration, 500)
    q, qd, _ = plan.trajectory.sample(t)
    speed = np.linalg.norm((CELL.arm.jacobian(q)[:, :3] @ qd[..., None])[..., 0], axis=1)
    assert 0.095 < speed.max() <= 0.1 * (1 + 1e-6)


def test_rests_at_both_ends_and_a_motion_that_only_rests():
    plan = plan_taught(taught(rests=((0.0, 0.5), (4.0, 0.4))), CELL.arm)
    np.testing.assert_allclose(plan.trajectory.at(0.4).q, taught().q_start)
    assert plan.trajectory.at(0.4).qd.max() == 0.0
    still = taught(points=np.tile(CELL.poses["home"], (7, 1)))
    assert plan_taught(still, CELL.arm).trajectory.duration == 0.8
    assert plan_taught(replace(still, rests=()), CELL.arm).trajectory.duration == 0.0


def test_a_way_beyond_a_limit_is_refused_with_the_joint():
    points = taught().points + np.array([3.3, 0.0])
    with pytest.raises(LimitError, match="joint1"):
        plan_taught(taught(points=points), CELL.arm)
    # control points beyond it are no way beyond it
    near = taught().points.copy()
    near[3, 0] = CELL.arm.limits.q_max[0] + 0.05
    plan_taught(taught(points=near), CELL.arm)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"rests": ((2.0, 0.5), (1.0, 0.5))}, "rising"),
        ({"rests": ((5.0, 0.5),)}, "rising"),
        ({"rests": ((1.0, 0.0),)}, "above 0"),
        ({"knots": [1.0] * 4 + [2.0, 3.0, 4.0] + [5.0] * 4}, "begins at 0"),
        ({"names": ("a",)}, "points"),
    ],
)
def test_what_does_not_fit_is_refused(wrong, words):
    with pytest.raises(ValueError, match=words):
        taught(**wrong)


def test_other_joints_and_unknown_timings_are_refused():
    with pytest.raises(ValueError, match="want joints"):
        plan_taught(replace(taught(), names=("a", "b")), CELL.arm)
    with pytest.raises(ValueError, match="recorded, fastest"):
        plan_taught(taught(), CELL.arm, timing="slow")
