"""Torques and the tool under limits of jerk: kept everywhere, met somewhere."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.errors import CurveError, HoldError
from splinearm.kinematics.dynamics import Drives, Dynamics
from splinearm.kinematics.link import Inertia
from splinearm.trajectories.constraint import SpeedCap
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_timing import Passage, quickest_smooth
from splinearm.trajectories.timing import quickest

FRICTION = Drives(viscous=np.full(6, 1.0), coulomb=np.full(6, 0.5), rotor_inertia=np.full(6, 0.02))
LOAD = Inertia(1.5, np.array([0.0, 0.02, 0.05]), 0.003 * np.eye(3))


@pytest.fixture(scope="module")
def loaded(loaded_6):
    """An arm with masses, and limits with torques and jerks."""
    arm, joints = loaded_6
    torques = 0.8 * joints.torque_max
    return arm, replace(joints, torque_max=torques, qddd_max=np.full(6, 200.0))


def way(seed, u=1.0):
    """A quintic through eight random places, whose parameter is as long as that."""
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, 6))
    return JointPath(interpolate(points, degree=5, parameters=np.linspace(0.0, u, 8)))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("drives", "payload", "no_load"),
    [(None, None, None), (FRICTION, LOAD, None), (FRICTION, None, 4.0)],
)
def test_torques_are_kept_together_with_jerks(seed, drives, payload, no_load, loaded, limit_uses):
    arm, joints = loaded
    joints = replace(joints, torque_max=0.7 * joints.torque_max)
    limits = MotionLimits(
        joints=joints,
        dynamics=Dynamics(arm, payload=payload, drives=drives),
        no_load_speed=None if no_load is None else np.full(6, no_load),
    )
    path = way(seed)
    law = quickest_smooth(path, limits)
    used = limit_uses(path, law, limits)
    assert max(used.values()) <= 1.0 + 1e-6, used
    assert max(used.values()) > 0.99, used
    # neither limit alone makes it as slow
    least = max(quickest(path, limits).duration, quickest_smooth(path, joints).duration)
    assert least * (1.0 - 2e-3) <= law.duration <= 1.06 * least
    # and it does not jump
    qdd = Section(path, law).sample(np.linspace(0.0, law.duration, 20_001))[2]
    assert np.abs(np.diff(qdd, axis=0)).max() <= 200.0 * law.duration / 20_000 * 1.01


def test_torques_alone_are_used_nearly_as_if_jerk_were_free(loaded, limit_uses):
    arm, joints = loaded
    joints = replace(joints, qd_max=np.full(6, 100.0), qdd_max=np.full(6, 1e4))
    limits = MotionLimits(joints=replace(joints, qddd_max=np.full(6, 3e5)), dynamics=Dynamics(arm))
    path = way(1)
    law = quickest_smooth(path, limits, cells=500)
    assert 0.99 < limit_uses(path, law, limits)["torque"] <= 1.0 + 1e-6
    assert law.duration == pytest.approx(quickest(path, limits).duration, rel=0.03)


def test_a_motor_line_is_kept_on_a_straight_way(motor_line, limit_uses):
    # full torque is reached within 5 ms
    joints = replace(motor_line.limits.joints, qddd_max=[1e3])
    limits = replace(motor_line.limits, joints=joints)
    path = straight_path(np.zeros(1), np.array([motor_line.way]))
    law = quickest_smooth(path, limits, cells=400)
    assert limit_uses(path, law, limits)["torque"] <= 1.0 + 1e-6
    assert law.speed.max() * motor_line.way == pytest.approx(motor_line.steady, rel=1e-3)
    want = motor_line.duration
    assert want * (1.0 - 1e-3) <= law.duration <= want * 1.01


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
def test_limits_of_the_tool_are_kept_together_with_jerks(seed, most, loaded, limit_uses):
    arm, joints = loaded
    limits = MotionLimits(joints=joints, arm=arm, **most)
    path = way(seed)
    law = quickest_smooth(path, limits)
    used = limit_uses(path, law, limits)
    assert max(used.values()) <= 1.0 + 1e-6, used
    assert max(used[name] for name in most) > 0.99
    least = quickest(path, limits).duration
    assert least * (1.0 - 2e-3) <= law.duration <= 1.02 * least


def drawn(seed, arm, joints):
    """A path, and limits of all kinds some of which bind."""
    rng = np.random.default_rng(seed)
    m = int(rng.integers(3, 10))
    points = rng.uniform(-2.0, 2.0, (m, 6))
    u = 10.0 ** rng.integers(-6, 7) * np.cumsum(rng.uniform(0.3, 1.0, m))
    path = JointPath(interpolate(points, degree=int(rng.choice([3, 5])), parameters=u))
    qdd_max = joints.qdd_max * 10.0 ** rng.uniform(-0.5, 1.5)
    joints = replace(
        joints,
        qd_max=joints.qd_max * 10.0 ** rng.uniform(-0.5, 1.5),
        qdd_max=qdd_max,
        qddd_max=qdd_max * 10.0 ** rng.uniform(0.0, 2.5),
        torque_max=joints.torque_max * rng.uniform(0.5, 2.0),
    )
    some = {}
    if rng.random() < 0.7:
        some["dynamics"] = Dynamics(
            arm,
            payload=LOAD if rng.random() < 0.5 else None,
            drives=FRICTION if rng.random() < 0.5 else None,
        )
        if rng.random() < 0.5:
            some["no_load_speed"] = np.full(6, 10.0 ** rng.uniform(0.0, 1.5))
    for name, most in (
        ("tool_speed", 1.0),
        ("tool_acceleration", 5.0),
        ("tool_turn_rate", 3.0),
        ("tool_turn_acceleration", 10.0),
    ):
        if rng.random() < 0.35:
            some[name] = most * 10.0 ** rng.uniform(-1.0, 0.5)
    return path, MotionLimits(joints=joints, arm=arm, **some)


def check_within_limits(seed, loaded, limit_uses):
    path, limits = drawn(seed, *loaded)
    try:
        law = quickest_smooth(path, limits, cells=100)
    except HoldError:
        return
    used = limit_uses(path, law, limits)
    assert max(used.values()) <= 1.0 + 1e-5, used
    if limits.no_load_speed is None:
        # with one the law without jerk keeps further from the motors' lines than this one
        assert law.duration >= 0.99 * quickest(path, limits).duration


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_limit_is_broken_at_any_moment(seed, loaded, limit_uses):
    check_within_limits(seed, loaded, limit_uses)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_no_limit_is_broken_on_five_hundred_paths(loaded, limit_uses):
    for seed in range(500):
        check_within_limits(seed, loaded, limit_uses)


@pytest.mark.kernel
def test_few_cells_keep_torques_and_the_tool_as_well(limits_2r, limit_uses):
    # small, for it is run as plain Python too
    joints = replace(limits_2r.joints, qddd_max=[200.0, 200.0])
    limits = replace(limits_2r, joints=joints, tool_acceleration=4.0)
    points = np.array([[0.0, 0.0], [0.8, -0.5], [0.3, 0.6]])
    path = JointPath(interpolate(points, degree=3, parameters="uniform"))
    law = quickest_smooth(path, limits, cells=10)
    assert 0.9 < max(limit_uses(path, law, limits, 301).values()) <= 1.0 + 1e-5


@pytest.mark.parametrize("factor", [1e-6, 3.7, 1e6])
def test_the_unit_of_the_parameter_does_not_matter(factor, loaded):
    arm, joints = loaded
    limits = MotionLimits(
        joints=joints, dynamics=Dynamics(arm, drives=FRICTION), tool_acceleration=8.0
    )
    path = way(2)
    curve = path.curve
    other = JointPath(BSpline(curve.knots * factor, curve.points, curve.degree))
    want = quickest_smooth(path, limits).duration
    assert quickest_smooth(other, limits).duration == pytest.approx(want, rel=1e-6)


def test_a_cap_and_torques_hold_together(loaded, limit_uses):
    arm, joints = loaded
    path = way(3)
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm, drives=FRICTION, payload=LOAD))
    cap = SpeedCap(
        edges=np.array([0.0, 0.5, 1.0]), speeds=np.array([np.inf, 0.1]), rate=np.ones_like
    )
    law = quickest_smooth(path, limits, cap=cap)
    assert max(limit_uses(path, law, limits).values()) <= 1.0 + 1e-6
    behind = law.s >= 0.5
    assert 0.0999 <= law.speed[behind].max() <= 0.1 * (1.0 + 1e-9)


def test_it_begins_and_ends_moving_within_torques(loaded, limit_uses):
    arm, joints = loaded
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm, drives=FRICTION))
    path = way(5)
    whole = quickest_smooth(path, limits)
    begin, end = 0.3, 0.7
    speeds = (0.7 * whole.at(whole.time_at(s))[1] for s in (begin, end))
    course = Passage(start_speed=next(speeds), end_speed=next(speeds))
    law = quickest_smooth(path, limits, (begin, end), passage=course)
    assert law.speed[[0, -1]] == pytest.approx((course.start_speed, course.end_speed))
    assert max(limit_uses(path, law, limits).values()) <= 1.0 + 1e-5
    # weak as that no motor could stop it
    weak = replace(limits, no_load_speed=np.full(6, 0.02))
    with pytest.raises(CurveError, match="no motion within the limits"):
        quickest_smooth(path, weak, (begin, end), passage=course)


def test_a_joint_too_weak_to_hold_the_arm_is_named(loaded):
    arm, joints = loaded
    weak = replace(joints, torque_max=[150.0, 20.0, 150.0, 28.0, 28.0, 28.0])
    with pytest.raises(HoldError, match=r"'joint1' cannot hold the arm at s = .* N m"):
        quickest_smooth(way(0), MotionLimits(joints=weak, dynamics=Dynamics(arm)))
