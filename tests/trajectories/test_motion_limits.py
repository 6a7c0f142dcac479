"""Torques and the tool: kept everywhere, met somewhere, refused where they cannot be."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.curves.interpolation import interpolate
from splinearm.errors import HoldError
from splinearm.kinematics.dynamics import Drives, Dynamics
from splinearm.kinematics.link import Inertia
from splinearm.trajectories.constraint import SpeedCap
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.limit_use import limit_use
from splinearm.trajectories.timing import quickest

FRICTION = Drives(viscous=np.full(6, 1.0), coulomb=np.full(6, 0.5), rotor_inertia=np.full(6, 0.02))
LOAD = Inertia(1.5, np.array([0.0, 0.02, 0.05]), 0.003 * np.eye(3))


def way(seed, n=6):
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, n))
    return JointPath(interpolate(points, degree=5, parameters="uniform"))


def motion(path, law, count=10_001):
    s, speed, acceleration = law.sample(np.linspace(0.0, law.duration, count))
    q, slope, bend = path.sample(s)
    qd = slope * speed[:, None]
    return q, qd, slope * acceleration[:, None] + bend * (speed * speed)[:, None]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("drives", "payload", "no_load"),
    [(None, None, None), (FRICTION, LOAD, None), (FRICTION, None, 4.0)],
)
def test_torques_are_kept_everywhere_and_slow_the_motion(
    seed, drives, payload, no_load, loaded_6, limit_uses
):
    arm, joints = loaded_6
    joints = replace(joints, torque_max=0.8 * joints.torque_max)
    limits = MotionLimits(
        joints=joints,
        dynamics=Dynamics(arm, payload=payload, drives=drives),
        no_load_speed=None if no_load is None else np.full(6, no_load),
    )
    path = way(seed)
    law = quickest(path, limits)
    assert limit_uses(path, law, limits)["torque"] <= 1.0 + 1e-6
    _, qd, qdd = motion(path, law)
    assert (np.abs(qd) <= joints.qd_max * (1.0 + 1e-9)).all()
    assert (np.abs(qdd) <= joints.qdd_max * (1.0 + 1e-9)).all()
    assert law.duration >= quickest(path, joints).duration * (1.0 - 1e-3)


def test_torques_alone_are_used_to_the_full(loaded_6, limit_uses):
    arm, joints = loaded_6
    free = replace(joints, qd_max=np.full(6, 100.0), qdd_max=np.full(6, 1e4))
    limits = MotionLimits(joints=free, dynamics=Dynamics(arm))
    path = way(1)
    law = quickest(path, limits)
    assert 0.99 < limit_uses(path, law, limits)["torque"] <= 1.0 + 1e-6
    use = limit_use(path, limits, law)
    assert {use.limits[k][1] for k in use.binding} == {"torque"}
    assert np.median(use.shares.max(axis=1)) > 0.98, "some torque is at its limit all the way"


def test_a_motor_line_alone_leads_to_its_speed_under_friction(motor_line):
    path = straight_path(np.zeros(1), np.array([motor_line.way]))
    law = quickest(path, motor_line.limits, cells=2000)
    assert law.speed.max() * motor_line.way == pytest.approx(motor_line.steady, rel=1e-3)
    assert law.duration == pytest.approx(motor_line.duration, rel=5e-3)


@pytest.mark.kernel
def test_few_cells_keep_torques_as_well(limits_2r):
    points = np.array([[0.0, 0.0], [0.8, -0.5], [0.3, 0.6], [1.2, 0.2]])
    path = JointPath(interpolate(points, degree=3, parameters="uniform"))
    law = quickest(path, limits_2r, cells=16)
    _, qd, qdd = motion(path, law, 301)
    assert (np.abs(qdd) <= limits_2r.joints.qdd_max * (1.0 + 1e-9)).all()
    use = limit_use(path, limits_2r, law)
    assert 0.9 < use.shares[:, 2:4].max() <= 1.0 + 1e-6
    assert np.abs(qd).max() < 5.0


def test_a_joint_too_weak_to_hold_the_arm_is_named(loaded_6):
    arm, joints = loaded_6
    weak = replace(joints, torque_max=[150.0, 20.0, 150.0, 28.0, 28.0, 28.0])
    with pytest.raises(HoldError, match=r"'joint1' cannot hold the arm at s = .* N m") as caught:
        quickest(way(0), MotionLimits(joints=weak, dynamics=Dynamics(arm)))
    assert caught.value.joint == "joint1"
    assert abs(caught.value.value) > caught.value.limit == 20.0


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_the_unit_of_the_parameter_does_not_matter_for_torques(factor, loaded_6):
    arm, joints = loaded_6
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm, drives=FRICTION))
    path = way(2)
    curve = path.curve
    other = JointPath(type(curve)(curve.knots * factor, curve.points, curve.degree))
    want = quickest(path, limits).duration
    assert quickest(other, limits).duration == pytest.approx(want, rel=1e-7)


@pytest.mark.parametrize("drives", [None, FRICTION])
def test_torques_are_kept_between_speeds_at_the_ends(drives, loaded_6, limit_uses):
    arm, joints = loaded_6
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm, drives=drives))
    path = way(5)
    whole = quickest(path, limits)
    i, j = len(whole.s) // 3, 2 * len(whole.s) // 3
    ends = (0.8 * float(whole.speed[i]), 0.9 * float(whole.speed[j]))
    law = quickest(path, limits, (float(whole.s[i]), float(whole.s[j])), ends=ends)
    assert law.speed[[0, -1]] == pytest.approx(ends)
    assert limit_uses(path, law, limits)["torque"] <= 1.0 + 1e-6


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    "most",
    [
        {"tool_speed": 0.6},
        {"tool_acceleration": 4.0},
        {"tool_turn_rate": 1.5},
        {"tool_turn_acceleration": 10.0},
        {"tool_speed": 0.8, "tool_acceleration": 4.0, "tool_turn_rate": 2.0},
    ],
)
def test_limits_of_the_tool_are_kept_and_met(seed, most, loaded_6, limit_uses):
    arm, joints = loaded_6
    limits = MotionLimits(joints=joints, arm=arm, **most)
    path = way(seed)
    law = quickest(path, limits)
    used = limit_uses(path, law, limits)
    assert max(used.values()) <= 1.0 + 1e-5
    assert max(used[name] for name in most) > 0.99
    use = limit_use(path, limits, law)
    assert "tool" in {use.limits[k][0] for k in use.binding}


def test_a_tool_on_a_circle_goes_as_fast_as_its_acceleration_across_allows(arm_2r, limit_uses):
    # the shoulder alone carries the tool round: across its way r w^2, along it r w'
    q = np.linspace(0.0, 3.0, 9)[:, None] * [1.0, 0.0] + [0.0, 0.4]
    path = JointPath(interpolate(q, degree=3, parameters="uniform"))
    fast = replace(arm_2r.limits, qd_max=np.full(2, 1e3), qdd_max=np.full(2, 1e5))
    limits = MotionLimits(joints=fast, arm=arm_2r, tool_acceleration=2.0)
    law = quickest(path, limits)
    r = np.linalg.norm(arm_2r.fk(q[0])[:2, 3])
    _, qd, _ = motion(path, law)
    assert np.abs(qd[:, 0]).max() == pytest.approx(np.sqrt(2.0 / r), rel=2e-3)
    assert limit_uses(path, law, limits)["tool_acceleration"] <= 1.0 + 1e-6


def test_caps_and_limits_of_the_tool_hold_together(loaded_6, limit_uses):
    arm, joints = loaded_6
    path = way(3)
    start, end = path.domain
    cap = SpeedCap(
        edges=np.array([start, 0.5 * (start + end), end]),
        speeds=np.array([np.inf, 0.2]),
        rate=np.ones_like,
    )
    limits = MotionLimits(joints=joints, arm=arm, tool_speed=0.9)
    law = quickest(path, limits, cap=cap)
    behind = law.s >= 0.5 * (start + end)
    assert law.speed[behind].max() == pytest.approx(0.2, rel=1e-6)
    assert limit_uses(path, law, limits)["tool_speed"] <= 1.0 + 1e-6


def test_the_use_of_joints_is_told_cell_by_cell(make_limits):
    limits = make_limits([1.0, 1.0], [2.0, 2.0])
    path = straight_path(np.zeros(2), np.array([4.0, 1.0]))
    use = limit_use(path, limits, quickest(path, limits))
    assert [use.name(k) for k in range(3)] == [
        ("joint0", "acceleration"),
        ("joint0", "velocity"),
        ("joint0", "acceleration"),
    ]
    assert use.shares.max() == pytest.approx(1.0)
    still = JointPath(interpolate(np.full((4, 2), 0.7), parameters="uniform"))
    assert limit_use(still, limits, quickest(still, limits)).shares.shape == (0, 4)


def test_limits_that_do_not_go_together_are_refused(loaded_6, arm_2r, make_limits):
    arm, joints = loaded_6
    for arguments, named in (
        ({"joints": make_limits([1.0] * 6, [1.0] * 6), "dynamics": Dynamics(arm)}, "torque_max"),
        ({"joints": joints, "no_load_speed": np.ones(6)}, "no_load_speed"),
        ({"joints": joints, "dynamics": Dynamics(arm), "no_load_speed": np.zeros(6)}, "above zero"),
        ({"joints": joints, "tool_speed": 1.0}, "arm"),
        ({"joints": joints, "arm": arm, "tool_speed": -1.0}, "tool_speed"),
        ({"joints": joints, "arm": arm_2r, "tool_speed": 1.0}, "6 joints"),
    ):
        with pytest.raises(ValueError, match=named):
            MotionLimits(**arguments)
