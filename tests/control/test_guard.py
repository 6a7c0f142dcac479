import numpy as np
import pytest

from splinearm.control.guard import Guard, Tolerances
from splinearm.errors import FollowingError, LimitError, StartError, TrajectoryError
from splinearm.joints import JointKind, JointLimits, JointSetpoint, JointState
from splinearm.trajectories.plan import plan_joint_move


def setpoint(q, qd=(0.0, 0.0), qdd=(0.0, 0.0), t=0.0):
    return JointSetpoint(t=t, q=np.array(q), qd=np.array(qd), qdd=np.array(qdd))


def state(q):
    return JointState(t=0.0, q=np.array(q), qd=np.zeros(2), current=np.full(2, np.nan))


def test_a_motion_within_the_limits_is_admitted(guard, limits):
    guard.admit(plan_joint_move(limits, np.zeros(2), np.array([1.5, -2.0])), 0.01)


@pytest.mark.parametrize(
    ("tightened", "quantity"),
    [("q_max", "position"), ("qd_max", "velocity"), ("qdd_max", "acceleration")],
)
def test_a_motion_beyond_a_limit_is_refused_with_joint_and_time(limits, tightened, quantity):
    motion = plan_joint_move(limits, np.zeros(2), np.array([1.5, -2.0]))
    strict = {
        name: getattr(limits, name) * (0.5 if name == tightened else 1.0)
        for name in ("q_min", "q_max", "qd_max", "qdd_max")
    }
    guard = Guard(JointLimits(names=limits.names, kinds=limits.kinds, **strict))
    with pytest.raises(LimitError) as caught:
        guard.admit(motion, 0.01)
    assert caught.value.quantity == quantity
    assert caught.value.joint in limits.names
    assert 0.0 <= caught.value.t <= motion.duration


def test_a_motion_that_starts_elsewhere_is_refused_by_the_joint_that_is_off(guard, limits):
    motion = plan_joint_move(limits, np.zeros(2), np.array([1.0, 1.0]))
    held = np.array([0.001, -0.001])
    guard.begin(motion, state([0.001, -0.04]), held)
    with pytest.raises(StartError) as caught:
        guard.begin(motion, state([0.0, 0.2]), np.array([0.0, 0.2]))
    assert caught.value.joint == "elbow"
    assert "11.46 deg" in str(caught.value)
    with pytest.raises(StartError, match="shoulder"):
        guard.begin(motion, state([-0.3, 0.0]), held)


def test_a_setpoint_beyond_a_limit_does_not_pass(guard):
    with pytest.raises(LimitError, match="joint 'shoulder': position"):
        guard.check(setpoint([2.1, 0.0]), 0.01)
    with pytest.raises(LimitError, match="joint 'elbow': velocity"):
        guard.check(setpoint([0.0, 0.0], qd=(0.0, -3.5)), 0.01)
    with pytest.raises(LimitError, match="joint 'elbow': acceleration"):
        guard.check(setpoint([0.0, 0.0], qdd=(0.0, 13.0)), 0.01)


def test_a_setpoint_that_jumps_from_the_last_one_does_not_pass(guard):
    guard.check(setpoint([0.0, 0.0]), 0.0)
    guard.check(setpoint([0.019, 0.0], t=0.01), 0.01)
    with pytest.raises(LimitError, match="joint 'shoulder': velocity"):
        guard.check(setpoint([0.1, 0.0], t=0.02), 0.01)


def test_a_setpoint_whose_velocity_jumps_does_not_pass(guard):
    guard.check(setpoint([0.0, 0.0]), 0.0)
    with pytest.raises(LimitError, match="joint 'shoulder': acceleration"):
        guard.check(setpoint([0.0, 0.0], qd=(0.5, 0.0), t=0.01), 0.01)


def test_an_arm_that_falls_behind_is_named_with_what_was_wanted(guard):
    guard.follows(setpoint([0.5, 0.5]), state([0.45, 0.5]), 0.3)
    guard.follows(setpoint([0.5, 0.5], qd=(2.0, 0.0)), state([0.2, 0.5]), 0.3)
    with pytest.raises(FollowingError) as caught:
        guard.follows(setpoint([0.5, 0.5]), state([0.1, 0.5]), 0.3)
    assert (caught.value.joint, caught.value.t) == ("shoulder", 0.3)
    assert caught.value.wanted == 0.5


def test_a_sliding_joint_that_falls_behind_is_named_in_millimetres(limits):
    sliding = JointLimits(
        names=limits.names,
        kinds=(JointKind.PRISMATIC, JointKind.REVOLUTE),
        q_min=limits.q_min,
        q_max=limits.q_max,
        qd_max=limits.qd_max,
        qdd_max=limits.qdd_max,
    )
    guard = Guard(sliding, Tolerances(path=0.01, lag=0.0))
    with pytest.raises(FollowingError, match=r"is at 475 mm where 500 mm was .*\(allowed 10 mm"):
        guard.follows(setpoint([0.5, 0.5]), state([0.475, 0.5]), 0.3)


def test_a_guard_without_a_path_tolerance_watches_no_path(limits):
    guard = Guard(limits, Tolerances(path=None, goal=None))
    guard.follows(setpoint([0.5, 0.5]), state([0.0, 0.0]), 0.3)
    assert guard.arrived(setpoint([0.5, 0.5]), state([0.0, 0.0]))


def test_tolerances_refuse_a_number_that_is_not_above_zero():
    with pytest.raises(ValueError, match="path: want a number above zero"):
        Tolerances(path=0.0)
    with pytest.raises(ValueError, match="lag: want a time of at least zero"):
        Tolerances(lag=-0.1)


def test_a_part_of_a_motion_that_begins_or_ends_moving_is_refused(guard, limits):
    motion = plan_joint_move(limits, np.zeros(2), np.array([1.5, -2.0]))
    first, second = motion.split(0.5 * motion.duration)
    with pytest.raises(TrajectoryError, match="the motion ends while joints move"):
        guard.admit(first, 0.01)
    with pytest.raises(TrajectoryError, match="the motion begins while joints move"):
        guard.admit(second, 0.01)


def test_a_motion_that_breaks_a_limit_of_jerk_is_refused(limits):
    smooth = limits.with_jerk_time(0.1)
    motion = plan_joint_move(smooth, np.zeros(2), np.array([1.5, -2.0]))
    Guard(smooth).admit(motion, 0.01)
    with pytest.raises(LimitError, match=r"jerk .* is above its limit"):
        Guard(limits.with_jerk_time(0.2)).admit(motion, 0.01)
