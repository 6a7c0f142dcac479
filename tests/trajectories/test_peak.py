from dataclasses import replace

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.kinematics.dynamics import Drives, Dynamics
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.limit_share import joint_rates
from splinearm.trajectories.peak import bindings, peaks
from splinearm.trajectories.plan import plan
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_law import SmoothLaw
from splinearm.trajectories.time_law import TimeLaw
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.trajectory import JointTrajectory
from splinearm.trajectories.waypoint import Move, Waypoint


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


def test_where_path_and_law_change_together_each_is_taken_with_its_own_side(make_limits):
    # q = s before 0.7, and s + 50 (s - 0.7)^3 after it, where the law's jerk falls from 1 to -40
    limits = replace(make_limits([10.0], [100.0]), qddd_max=[300.0])
    bezier = [[0.0], [0.7 / 3], [1.4 / 3], [0.7], [0.8], [0.9], [2.35]]
    path = JointPath(BSpline([0, 0, 0, 0, 0.7, 0.7, 0.7, 1, 1, 1, 1], bezier, 3))
    reached = (6.0 * 0.7) ** (1.0 / 3.0)
    for nudge in (-1, 0, 1):
        until = reached * (1.0 + nudge * 2.0**-52)
        law = SmoothLaw.of_jerks(0.0, np.array([1.0, -40.0]), np.array([until, 5e-4]))
        motion = JointTrajectory((Section(path, law),), np.zeros(1), limits)
        (jerk,) = [peak for peak in peaks(motion) if peak.quantity == "jerk"]
        speed = 0.5 * reached**2
        assert jerk.value == pytest.approx(300.0 * speed**3 - 40.0, rel=0.02)
        assert jerk.value < 300.0 * speed**3 - 30.0, "not the law's jerk of before"


def test_a_motion_that_takes_no_time_is_not_held_back(make_limits):
    assert bindings(JointTrajectory((), np.zeros(1), make_limits([1.0], [2.0]))) == ()


def curved_motion(limits, n):
    points = np.random.default_rng(1).uniform(-2.0, 2.0, (8, n))
    path = JointPath(interpolate(points, degree=5, parameters="uniform"))
    law = quickest(path, limits)
    motion = JointTrajectory((Section(path, law),), path.at(path.domain[0])[0], limits.joints)
    return path, law, motion


@pytest.mark.parametrize("no_load", [None, 60.0])
def test_torques_are_told_with_the_joint_that_lacks_them(no_load, loaded_6, limit_uses):
    arm, joints = loaded_6
    fast = replace(joints, qd_max=np.full(6, 50.0), qdd_max=np.full(6, 1e4))
    weak = replace(fast, torque_max=[1e4, 1e4, 55.0, 1e4, 1e4, 1e4])
    limits = MotionLimits(
        joints=weak,
        dynamics=Dynamics(arm, drives=Drives(viscous=np.full(6, 0.2))),
        no_load_speed=None if no_load is None else np.full(6, no_load),
    )
    path, law, motion = curved_motion(limits, 6)
    held = [b for b in bindings(motion, limits) if b.joint is not None]
    longest = max(held, key=lambda b: b.end - b.start)
    assert (longest.joint, longest.quantity) == ("joint2", "torque")
    assert longest.share == pytest.approx(1.0, abs=1e-6)
    torques = [peak for peak in peaks(motion, limits) if peak.quantity == "torque"]
    assert [peak.joint for peak in torques] == list(joints.names)
    used = [abs(peak.value) / peak.limit for peak in torques]
    assert max(used) == used[2] == pytest.approx(1.0, abs=1e-6)
    (most,) = [peak for peak in torques if peak.joint == "joint2"]
    q, qd, qdd = motion.sample([most.t])
    torque = float(limits.dynamics.inverse(q, qd, qdd)[0, 2])
    assert torque == pytest.approx(most.value)
    assert limit_uses(path, law, limits)["torque"] <= used[2] + 1e-9


def test_a_motor_has_the_torque_of_its_line_to_drive_and_all_of_it_to_brake(motor_line):
    path = straight_path(np.zeros(1), np.array([motor_line.way]))
    limits = motor_line.limits
    motion = JointTrajectory(
        (Section(path, quickest(path, limits, cells=400)),), np.zeros(1), limits.joints
    )
    told = bindings(motion, limits)
    assert {(b.joint, b.quantity) for b in (told[0], told[-1])} == {("joint0", "torque")}
    assert min(told[0].share, told[-1].share) == pytest.approx(1.0)
    t = np.linspace(0.0, motion.duration, 301)
    torque, there = joint_rates(motion, limits, t)["torque"]
    _, qd, _ = motion.sample(t)
    assert there[torque > 0.0] == pytest.approx(10.0 * (1.0 - qd[torque > 0.0] / 4.0))
    assert (there[torque <= 0.0] == 10.0).all()
    assert (np.abs(torque) <= there * (1.0 + 1e-9)).all()


@pytest.mark.parametrize(
    ("most", "quantity"),
    [
        ({"tool_speed": 0.1}, "tool speed"),
        ({"tool_acceleration": 0.5}, "tool acceleration"),
        ({"tool_turn_rate": 0.3}, "tool turn rate"),
        ({"tool_turn_acceleration": 1.0}, "tool turn acceleration"),
    ],
)
def test_a_limit_of_the_tool_is_told_by_its_name(most, quantity, loaded_6):
    arm, joints = loaded_6
    limits = MotionLimits(joints=joints, arm=arm, **most)
    _, _, motion = curved_motion(limits, 6)
    told = bindings(motion, limits)
    named = [b for b in told if b.quantity == quantity]
    assert sum(b.end - b.start for b in named) > 0.8 * motion.duration
    assert all(b.joint is None for b in named)
    assert max(b.share for b in named) == pytest.approx(1.0, abs=1e-4)
    free = [b for b in bindings(motion) if b.quantity is None]
    assert sum(b.end - b.start for b in free) > 0.8 * motion.duration, "its joints were quicker"


def test_a_plan_knows_what_it_was_planned_within(loaded_6):
    arm, joints = loaded_6
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm), tool_acceleration=1.0)
    start, goal = np.array([0.2, -1.2, 1.4, -0.3, 0.4, 0.1]), [0.9, -0.8, 1.0, -0.3, 0.4, 0.1]
    made = plan(arm, [Waypoint(q=goal, move=Move.JOINT)], start, limits=limits)
    assert {peak.quantity for peak in made.peaks()} >= {"torque"}
    assert "tool acceleration" in {binding.quantity for binding in made.bindings()}
    for peak in made.peaks():
        assert abs(peak.value) <= abs(peak.limit) * (1.0 + 1e-9)
