"""Torques and the tool under limits of jerk: kept everywhere, met somewhere."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.errors import CurveError, HoldError
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.kinematics.differential import jacobian_rate
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
def loaded(make_limits):
    """Give an arm of the size and weight of a UR5, and limits with torques and jerks."""
    # a, alpha, d, mass: Universal Robots, DH parameters of the UR5
    rows = [
        (0.0, np.pi / 2, 0.089159, 3.7),
        (-0.425, 0.0, 0.0, 8.393),
        (-0.39225, 0.0, 0.0, 2.275),
        (0.0, np.pi / 2, 0.10915, 1.219),
        (0.0, -np.pi / 2, 0.09465, 1.219),
        (0.0, 0.0, 0.0823, 0.1879),
    ]
    links = [
        DHLink(f"joint{i}", a=a, alpha=b, d=d, theta=0.0) for i, (a, b, d, _) in enumerate(rows)
    ]
    inertias = [
        Inertia(m, np.array([-0.5 * a, 0.0, -0.5 * d]), m * (0.01 + a * a / 12.0) * np.eye(3))
        for a, _, d, m in rows
    ]
    limits = make_limits([3.15] * 6, [20.0] * 6)
    arm = Arm.from_dh("UR5 size", links, DHConvention.STANDARD, limits, inertias=inertias)
    torques = np.array([120.0, 120.0, 120.0, 22.4, 22.4, 22.4])
    return arm, replace(limits, torque_max=torques, qddd_max=np.full(6, 200.0))


def way(seed, u=1.0):
    """A quintic through eight random places, whose parameter is as long as that."""
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, 6))
    return JointPath(interpolate(points, degree=5, parameters=np.linspace(0.0, u, 8)))


def uses(path, law, limits, count=10_001):
    """The largest share of each limit at many moments, by quantity."""
    ts = np.linspace(0.0, law.duration, count)
    section, joints = Section(path, law), limits.joints
    q, qd, qdd = section.sample(ts)
    found = {
        "velocity": np.abs(qd) / joints.qd_max,
        "acceleration": np.abs(qdd) / joints.qdd_max,
        "jerk": np.abs(section.jerk(ts)) / joints.qddd_max,
    }
    if limits.dynamics is not None:
        torque = limits.dynamics.inverse(q, qd, qdd)
        no_load = np.inf if limits.no_load_speed is None else limits.no_load_speed
        line = np.where(torque * qd > 0.0, np.abs(qd) / no_load, 0.0)
        found["torque"] = np.abs(torque) / joints.torque_max + line
    arm = limits.arm
    if arm is not None:
        J = arm.jacobian(q)
        v = np.einsum("mij,mj->mi", J, qd)
        a = np.einsum("mij,mj->mi", J, qdd) + np.einsum("mij,mj->mi", jacobian_rate(arm, q, qd), qd)
        for name, of in (
            ("tool_speed", v[:, :3]),
            ("tool_turn_rate", v[:, 3:]),
            ("tool_acceleration", a[:, :3]),
            ("tool_turn_acceleration", a[:, 3:]),
        ):
            if (most := getattr(limits, name)) is not None:
                found[name] = np.linalg.norm(of, axis=1) / most
    return {name: float(share.max()) for name, share in found.items()}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("drives", "payload", "no_load"),
    [(None, None, None), (FRICTION, LOAD, None), (FRICTION, None, 4.0)],
)
def test_torques_are_kept_together_with_jerks(seed, drives, payload, no_load, loaded):
    arm, joints = loaded
    joints = replace(joints, torque_max=0.7 * joints.torque_max)
    limits = MotionLimits(
        joints=joints,
        dynamics=Dynamics(arm, payload=payload, drives=drives),
        no_load_speed=None if no_load is None else np.full(6, no_load),
    )
    path = way(seed)
    law = quickest_smooth(path, limits)
    used = uses(path, law, limits)
    assert max(used.values()) <= 1.0 + 1e-6, used
    assert max(used.values()) > 0.99, used
    # neither limit alone makes it as slow
    least = max(quickest(path, limits).duration, quickest_smooth(path, joints).duration)
    assert least * (1.0 - 2e-3) <= law.duration <= 1.06 * least
    # and it does not jump
    qdd = Section(path, law).sample(np.linspace(0.0, law.duration, 20_001))[2]
    assert np.abs(np.diff(qdd, axis=0)).max() <= 200.0 * law.duration / 20_000 * 1.01


def test_torques_alone_are_used_nearly_as_if_jerk_were_free(loaded):
    arm, joints = loaded
    joints = replace(joints, qd_max=np.full(6, 100.0), qdd_max=np.full(6, 1e4))
    limits = MotionLimits(joints=replace(joints, qddd_max=np.full(6, 3e5)), dynamics=Dynamics(arm))
    path = way(1)
    law = quickest_smooth(path, limits, cells=500)
    assert 0.99 < uses(path, law, limits)["torque"] <= 1.0 + 1e-6
    assert law.duration == pytest.approx(quickest(path, limits).duration, rel=0.03)


def test_a_motor_line_is_kept_on_a_straight_way(make_limits):
    # one joint about a vertical axis: torque full (1 - qd / qd0) = inertia qdd + viscous qd
    full, no_load, inertia, viscous = 10.0, 4.0, 2.0, 1.0
    joints = replace(make_limits([100.0], [1e3]), torque_max=[full], qddd_max=[1e3])
    body = Inertia(1.0, np.zeros(3), np.diag([1.0, 1.0, inertia]))
    links = [DHLink("joint0", a=0.0, alpha=0.0, d=0.0, theta=0.0)]
    arm = Arm.from_dh("1R", links, DHConvention.STANDARD, joints, inertias=[body])
    dynamics = Dynamics(arm, drives=Drives(viscous=np.array([viscous])))
    limits = MotionLimits(joints=joints, dynamics=dynamics, no_load_speed=np.array([no_load]))
    path = straight_path(np.zeros(1), np.array([40.0]))
    law = quickest_smooth(path, limits, cells=400)
    assert uses(path, law, limits)["torque"] <= 1.0 + 1e-6
    steady = full / (full / no_load + viscous)
    assert law.speed.max() * 40.0 == pytest.approx(steady, rel=1e-3)
    # the exact law without a limit of jerk, as in the tests of motion limits; full torque is
    # reached within 5 ms
    tau = inertia / (full / no_load + viscous)
    braking = inertia / viscous * np.log1p(viscous * steady / full)
    braked = inertia / viscous * (steady - full / viscous * np.log1p(viscous * steady / full))
    want = tau + braking + (40.0 - braked) / steady
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
def test_limits_of_the_tool_are_kept_together_with_jerks(seed, most, loaded):
    arm, joints = loaded
    limits = MotionLimits(joints=joints, arm=arm, **most)
    path = way(seed)
    law = quickest_smooth(path, limits)
    used = uses(path, law, limits)
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


def check_within_limits(seed, loaded):
    path, limits = drawn(seed, *loaded)
    try:
        law = quickest_smooth(path, limits, cells=100)
    except HoldError:
        return
    used = uses(path, law, limits)
    assert max(used.values()) <= 1.0 + 1e-5, used
    if limits.no_load_speed is None:
        # with one the law without jerk keeps further from the motors' lines than this one
        assert law.duration >= 0.99 * quickest(path, limits).duration


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_limit_is_broken_at_any_moment(seed, loaded):
    check_within_limits(seed, loaded)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_no_limit_is_broken_on_five_hundred_paths(loaded):
    for seed in range(500):
        check_within_limits(seed, loaded)


@pytest.mark.kernel
def test_few_cells_keep_torques_and_the_tool_as_well(make_limits):
    # small, for it is run as plain Python too
    joints = make_limits([3.0, 3.0], [20.0, 20.0])
    joints = replace(joints, torque_max=[18.0, 8.0], qddd_max=[200.0, 200.0])
    links = [DHLink(f"joint{i}", a=0.4, alpha=1.0, d=0.0, theta=0.0) for i in range(2)]
    bodies = [Inertia(1.5, np.array([-0.2, 0.0, 0.0]), 0.02 * np.eye(3))] * 2
    arm = Arm.from_dh("2R", links, DHConvention.STANDARD, joints, inertias=bodies)
    drives = Drives(viscous=np.full(2, 0.5), coulomb=np.full(2, 0.2))
    limits = MotionLimits(
        joints=joints,
        dynamics=Dynamics(arm, drives=drives),
        no_load_speed=np.full(2, 5.0),
        tool_acceleration=4.0,
    )
    points = np.array([[0.0, 0.0], [0.8, -0.5], [0.3, 0.6]])
    path = JointPath(interpolate(points, degree=3, parameters="uniform"))
    law = quickest_smooth(path, limits, cells=10)
    assert 0.9 < max(uses(path, law, limits, 301).values()) <= 1.0 + 1e-5


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


def test_a_cap_and_torques_hold_together(loaded):
    arm, joints = loaded
    path = way(3)
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm, drives=FRICTION, payload=LOAD))
    cap = SpeedCap(
        edges=np.array([0.0, 0.5, 1.0]), speeds=np.array([np.inf, 0.1]), rate=np.ones_like
    )
    law = quickest_smooth(path, limits, cap=cap)
    assert max(uses(path, law, limits).values()) <= 1.0 + 1e-6
    behind = law.s >= 0.5
    assert 0.0999 <= law.speed[behind].max() <= 0.1 * (1.0 + 1e-9)


def test_it_begins_and_ends_moving_within_torques(loaded):
    arm, joints = loaded
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm, drives=FRICTION))
    path = way(5)
    whole = quickest_smooth(path, limits)
    begin, end = 0.3, 0.7
    speeds = (0.7 * whole.at(whole.time_at(s))[1] for s in (begin, end))
    course = Passage(start_speed=next(speeds), end_speed=next(speeds))
    law = quickest_smooth(path, limits, (begin, end), passage=course)
    assert law.speed[[0, -1]] == pytest.approx((course.start_speed, course.end_speed))
    assert max(uses(path, law, limits).values()) <= 1.0 + 1e-5
    # weak as that no motor could stop it
    weak = replace(limits, no_load_speed=np.full(6, 0.02))
    with pytest.raises(CurveError, match="no motion within the limits"):
        quickest_smooth(path, weak, (begin, end), passage=course)


def test_a_joint_too_weak_to_hold_the_arm_is_named(loaded):
    arm, joints = loaded
    weak = replace(joints, torque_max=[150.0, 20.0, 150.0, 28.0, 28.0, 28.0])
    with pytest.raises(HoldError, match=r"'joint1' cannot hold the arm at s = .* N m"):
        quickest_smooth(way(0), MotionLimits(joints=weak, dynamics=Dynamics(arm)))
