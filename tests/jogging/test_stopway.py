"""Whatever is wished, what is sent keeps every bound, and a way to rest is at hand."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from splinearm.control.guard import Guard
from splinearm.guiding import TOOL_SPEED
from splinearm.jogging.hindrance import Broken
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.units import DEG

PERIOD = 0.01
ARMS = ("wx250s", "rx150", "open_manipulator_x", "planar_2r")


def _check(jogged):
    """Pass everything that was sent: the guard does, and the tool is never too fast."""
    guard = Guard(jogged.arm.limits)
    for setpoint in jogged.setpoints:
        guard.check(setpoint, PERIOD)
    assert jogged.tool_speeds().max() <= TOOL_SPEED


def _wild(jogged, seed, wishes):
    """Wish at random: joints and tool, quick and slow, changing while it moves."""
    rng = np.random.default_rng(seed)
    limits = jogged.arm.limits
    for _ in range(wishes):
        kind, seconds = rng.integers(4), rng.uniform(0.02, 0.6)
        if kind == 0:
            jogged.go(seconds, rng.uniform(-1.5, 1.5, limits.n) * 60.0 * DEG)
        elif kind == 3:
            jogged.go(0.5 * seconds)
        else:
            twist = rng.normal(size=6) * rng.choice([0.0, 1.0], 6) * ([0.2] * 3 + [1.0] * 3)
            jogged.go(seconds, twist, ("base", "tool")[kind - 1])
    assert jogged.rest() <= jogged.ramp.duration + PERIOD


@pytest.mark.property
@settings(
    max_examples=4, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)  # the fixture is a class
@given(name=st.sampled_from(ARMS), seed=st.integers(0, 2**32 - 1))
def test_random_wishes_never_break_a_bound(jogged, name, seed):
    arm = jogged(name)
    _wild(arm, seed, 8)
    _check(arm)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_many_random_wishes_never_break_a_bound(jogged, name):
    fastest = 0.0
    for seed in range(20):
        arm = jogged(name)
        _wild(arm, seed, 50)
        _check(arm)
        fastest = max(fastest, arm.tool_speeds().max())
    assert fastest > 0.98 * TOOL_SPEED  # it was put to the test


@pytest.mark.parametrize("frame", ["base", "tool"])
@pytest.mark.parametrize("axis", range(6))
def test_the_tool_goes_along_the_axis_and_nowhere_else(jogged, frame, axis):
    arm = jogged("wx250s", q=np.array([20.0, -10.0, 30.0, 15.0, 25.0, -20.0]) * DEG)
    T, rate = arm.pose, 0.05 if axis < 3 else 0.3
    twist = rate * np.eye(6)[axis]
    arm.go(0.5, twist, frame)
    arm.rest()
    assert not arm.words
    R = np.eye(3) if frame == "base" else T[:3, :3]
    way = R.T @ (arm.pose[:3, 3] - T[:3, 3])
    np.testing.assert_allclose(way, 0.5 * twist[:3], atol=1e-7)
    D = R.T @ arm.pose[:3, :3] @ T[:3, :3].T @ R
    turn = 0.5 * np.array([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
    np.testing.assert_allclose(turn, np.sin(0.5 * twist[3:]), atol=1e-7)
    # and straight on the way
    p = (arm.arm.fk(np.array(arm.sent))[:, :3, 3] - T[:3, 3]) @ R
    np.testing.assert_allclose(np.delete(p, axis % 3, 1) if axis < 3 else p, 0.0, atol=1e-7)


def test_an_arm_rests_in_the_stated_time_wherever_it_is_let_go(jogged):
    arm = jogged("wx250s")
    arm.go(0.5, [0.1, 0.05, 0.0, 0.0, 0.3, 0.0], "base")
    assert arm.rest() <= arm.ramp.duration
    ends = arm.sent[-1]
    arm.go(0.1)
    np.testing.assert_array_equal(arm.sent[-1], ends)
    assert not arm.setpoints[-1].qd.any()


@pytest.mark.parametrize("rates", [[1.0, 0.0], [1.0, -1.0], [-3.0, 0.2]])
def test_joints_go_as_wished_until_the_tool_is_too_fast(jogged, rates):
    arm = jogged("planar_2r", q=[0.0, 0.1])  # stretched: 0.45 m from the shoulder
    arm.go(0.4, rates)
    arm.rest()
    gone = arm.sent[-1] - arm.sent[0]
    assert gone[0] / gone[1] == pytest.approx(rates[0] / rates[1]) if rates[1] else gone[1] == 0.0
    _check(arm)
    slow = [found for _, found in arm.found if found is not None and not found.temporary]
    assert slow
    assert {found.broken for found in slow} <= {Broken.TOOL, Broken.VELOCITY}
    assert arm.tool_speeds().max() > 0.9 * TOOL_SPEED


def test_a_joint_stops_at_its_limit_and_says_so_while_others_go_on(jogged):
    arm = jogged("wx250s")
    limits = arm.arm.limits
    arm.go(8.0, [0.0, 0.0, 0.5, 0.0, 0.0, 0.1])
    assert arm.sent[-1][2] == pytest.approx(limits.q_max[2], abs=1e-9)
    assert arm.words[-1] == (
        f"{limits.names[2]} is at its upper limit {limits.q_max[2] / DEG:.1f} deg: go the other way"
    )
    assert arm.sent[-1][5] - arm.sent[0][5] > 0.7
    arm.go(1.0, [0.0, 0.0, -0.5, 0.0, 0.0, 0.0])
    assert arm.sent[-1][2] < limits.q_max[2] - 0.3
    _check(arm)


def test_the_tool_stops_where_a_joint_would_leave_its_limits(jogged):
    arm = jogged("wx250s")
    arm.go(3.0, [0.0, 0.0, 0.0, 0.0, 0.5, 0.0], "base")
    arm.rest()
    limit = [words for words in arm.words if "limit" in words]
    assert limit
    assert "the tool cannot go on that way" in limit[-1]
    assert arm.found[-1][0] == 0.0
    _check(arm)
    before = arm.pose
    arm.go(0.5, [0.0, 0.0, 0.0, 0.0, -0.5, 0.0], "base")
    assert np.abs(arm.pose - before).max() > 0.05


def test_the_tool_slows_down_towards_a_singularity_and_never_flips(jogged):
    arm = jogged("planar_2r", q=[0.3, 0.6])
    out = arm.pose[:3, 3] / np.linalg.norm(arm.pose[:2, 3])
    arm.go(2.0, [*(0.1 * out[:2]), 0.0, 0.0, 0.0, 0.0], "base")
    arm.rest()
    assert any(words.startswith("singular, joint1 and joint2") for words in arm.words)
    assert 0.0 < arm.sent[-1][1] < 0.1  # nearly straight, and on its side
    _check(arm)
    arm.go(2.0, [*(-0.1 * out[:2]), 0.0, 0.0, 0.0, 0.0], "base")
    assert arm.sent[-1][1] > 0.3


def test_a_way_that_no_joint_gives_is_refused_with_the_reason(jogged):
    arm = jogged("planar_2r")
    arm.go(0.1, [0.0, 0.0, 0.05, 0.0, 0.0, 0.0], "base")
    assert "cannot move its tool along z" in arm.words[0]
    arm = jogged("open_manipulator_x")
    arm.go(0.1, [0.0, 0.0, 0.0, 0.3, 0.0, 0.0], "tool")
    assert "cannot turn its tool about x" in arm.words[0]
    assert arm.way.rests


def test_an_arm_of_few_joints_keeps_the_tool_s_position_first(jogged):
    arm = jogged("open_manipulator_x")
    T = arm.pose
    arm.go(1.0, [0.0, 0.05, 0.0, 0.0, 0.0, 0.0], "base")
    arm.rest()
    assert not arm.words
    np.testing.assert_allclose(arm.pose[:3, 3] - T[:3, 3], [0.0, 0.05, 0.0], atol=1e-7)
    assert arm.pose[2, 0] == pytest.approx(T[2, 0], abs=1e-4)  # as steep as before


def test_a_planar_arm_of_three_joints_goes_along_x_and_y_and_turns(jogged):
    names = ("one", "two", "three")
    limits = JointLimits(
        names=names,
        kinds=(JointKind.REVOLUTE,) * 3,
        q_min=np.full(3, -2.0),
        q_max=np.full(3, 2.0),
        qd_max=np.full(3, 3.0),
        qdd_max=np.full(3, 10.0),
        qddd_max=np.full(3, 300.0),
    )
    rows = [DHLink(name, a=0.15, alpha=0.0, d=0.0, theta=0.0) for name in names]
    made = Arm.from_dh("planar_3r", rows, DHConvention.STANDARD, limits)
    arm = jogged("planar_2r", q=[0.3, 1.2, -0.5], arm=made)
    T = arm.pose
    arm.go(0.5, [0.05, -0.05, 0.0, 0.0, 0.0, 0.0], "base")
    arm.rest()
    np.testing.assert_allclose(arm.pose[:3, 3] - T[:3, 3], [0.025, -0.025, 0.0], atol=1e-7)
    np.testing.assert_allclose(arm.pose[:3, :3], T[:3, :3], atol=1e-6)
    T = arm.pose
    arm.go(0.5, [0.0, 0.0, 0.0, 0.0, 0.0, 0.4], "tool")
    arm.rest()
    assert not arm.words
    np.testing.assert_allclose(arm.pose[:3, 3], T[:3, 3], atol=1e-7)
    assert arm.sent[-1].sum() - np.arctan2(T[1, 0], T[0, 0]) == pytest.approx(0.2, abs=1e-6)
    for twist in np.eye(6)[2:5]:
        arm.go(0.05, 0.1 * twist, "base")
        assert arm.way.rests
        assert "with its 3 joints this arm cannot" in arm.words[-1]
    _check(arm)


def test_a_reversal_at_full_speed_keeps_every_bound(jogged):
    arm = jogged("wx250s")
    for sign in (1.0, -1.0, 1.0, -1.0):
        arm.go(0.3, [0.0, sign * 0.25, 0.0, 0.0, 0.0, 0.0], "base")
    arm.rest()
    _check(arm)
