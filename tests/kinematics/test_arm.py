from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.joints import JointKind
from splinearm.kinematics import (
    Arm,
    DHConvention,
    DHLink,
    Inertia,
    Link,
    Pose,
    quaternion,
    space,
)

seeds = st.integers(0, 100_000)
joints = st.integers(2, 8)
conventions = st.sampled_from(list(DHConvention))


@pytest.mark.property
@given(seeds, joints, conventions)
@settings(deadline=None)
def test_fk_is_the_product_of_the_rows_between_base_and_tool(random_arm, seed, n, convention):
    arm = random_arm(seed, n, convention)
    q = np.random.default_rng(seed).uniform(-pi, pi, n)
    T = arm.T_base_first
    for row, frame, value in zip(arm.dh, arm.frames(q), q, strict=True):
        T = T @ row.matrix(value, convention)
        np.testing.assert_allclose(frame, T, atol=1e-13)
    np.testing.assert_allclose(arm.fk(q), T @ arm.T_flange_tool, atol=1e-13)


@pytest.mark.property
@given(seeds, joints, conventions)
@settings(deadline=None)
def test_the_jacobian_is_the_derivative_of_fk(random_arm, seed, n, convention):
    arm = random_arm(seed, n, convention)
    q = np.random.default_rng(seed).uniform(-pi, pi, n)
    h = 1e-6
    T, jacobian = arm.fk(q), arm.jacobian(q)
    for k, step in enumerate(h * np.eye(n)):
        ahead, behind = arm.fk(q + step), arm.fk(q - step)
        linear = (ahead[:3, 3] - behind[:3, 3]) / (2.0 * h)
        spin = (ahead[:3, :3] - behind[:3, :3]) / (2.0 * h) @ T[:3, :3].T
        angular = [spin[2, 1], spin[0, 2], spin[1, 0]]
        np.testing.assert_allclose(jacobian[:, k], [*linear, *angular], atol=2e-8)


@pytest.mark.property
@given(seeds, joints, conventions)
@settings(deadline=None)
def test_batches_of_any_shape_give_what_single_vectors_give(random_arm, seed, n, convention):
    arm = random_arm(seed, n, convention)
    q = np.random.default_rng(seed).uniform(-pi, pi, (2, 3, n))
    T, frames, jacobian = arm.fk(q), arm.frames(q), arm.jacobian(q)
    assert T.shape == (2, 3, 4, 4)
    assert frames.shape == (2, 3, n, 4, 4)
    assert jacobian.shape == (2, 3, 6, n)
    for at in np.ndindex(2, 3):
        np.testing.assert_allclose(T[at], arm.fk(q[at]), atol=1e-13)
        np.testing.assert_allclose(frames[at], arm.frames(q[at]), atol=1e-13)
        np.testing.assert_allclose(jacobian[at], arm.jacobian(q[at]), atol=1e-13)


def test_a_batch_longer_than_a_block_is_whole(widowx):
    q = np.random.default_rng(0).uniform(-pi, pi, (1100, 6))
    singles = np.array([widowx.fk(one) for one in q])
    np.testing.assert_allclose(widowx.fk(q), singles, atol=1e-14)
    jacobians = np.array([widowx.jacobian(one) for one in q])
    np.testing.assert_allclose(widowx.jacobian(q), jacobians, atol=1e-14)


def test_an_empty_batch_gives_an_empty_batch(widowx):
    assert widowx.fk(np.empty((0, 6))).shape == (0, 4, 4)
    assert widowx.jacobian(np.empty((0, 6))).shape == (0, 6, 6)


def test_the_widowx_stands_where_its_maker_says_at_zero(widowx):
    np.testing.assert_allclose(widowx.fk(np.zeros(6))[:3, 3], [0.458325, 0.0, 0.36065], atol=1e-12)
    np.testing.assert_allclose(widowx.fk(np.zeros(6))[:3, :3], np.eye(3), atol=1e-12)


def test_a_sliding_joint_moves_the_tool_along_its_axis_and_turns_nothing(dh_arm):
    rows = [
        DHLink("lift", 0.0, pi / 2, 0.1, 0.0, JointKind.PRISMATIC),
        DHLink("turn", 0.2, 0, 0, 0),
    ]
    arm = dh_arm(rows, DHConvention.STANDARD)
    np.testing.assert_allclose(arm.fk([0.3, 0.0])[:3, 3], [0.2, 0.0, 0.4], atol=1e-15)
    np.testing.assert_array_equal(arm.jacobian([0.3, 0.5])[:, 0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


@pytest.mark.property
@given(seeds, joints)
@settings(deadline=None)
def test_both_conventions_agree_after_the_table_is_rewritten(random_arm, dh_arm, seed, n):
    standard = random_arm(seed, n, DHConvention.STANDARD)
    none = DHLink("none", 0.0, 0.0, 0.0, 0.0)
    rows = [
        DHLink(row.name, before.a, before.alpha, row.d, row.theta, row.kind)
        for before, row in zip([none, *standard.dh[:-1]], standard.dh, strict=True)
    ]
    last = standard.dh[-1]
    tail = space.translation((last.a, 0.0, 0.0)) @ space.rotation_x(last.alpha)
    modified = dh_arm(
        rows,
        DHConvention.MODIFIED,
        T_base_first=standard.T_base_first,
        T_flange_tool=tail @ standard.T_flange_tool,
    )
    q = np.random.default_rng(seed).uniform(-pi, pi, (3, n))
    np.testing.assert_allclose(modified.fk(q), standard.fk(q), atol=1e-13)
    np.testing.assert_allclose(modified.jacobian(q), standard.jacobian(q), atol=1e-13)


def test_another_tool_moves_the_tool_point_only(widowx):
    T_flange_tool = Pose([0.0, 0.0, 0.1], quaternion.from_euler([0.1, 0.2, 0.3], "xyz")).matrix()
    other = widowx.with_tool(T_flange_tool)
    q = np.full(6, 0.3)
    np.testing.assert_allclose(other.fk(q), widowx.frames(q)[-1] @ T_flange_tool, atol=1e-14)
    assert other.limits is widowx.limits
    assert other.dh is widowx.dh


def test_where_the_arm_stands_in_the_world_changes_nothing_in_base(dh_arm):
    rows = [DHLink("one", 0.3, 0.0, 0.0, 0.0)]
    here = dh_arm(rows, DHConvention.STANDARD)
    there = dh_arm(rows, DHConvention.STANDARD, T_world_base=space.translation((1.0, 2.0, 3.0)))
    np.testing.assert_array_equal(here.fk([0.3]), there.fk([0.3]))
    np.testing.assert_array_equal(there.T_world_base[:3, 3], [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("q", "message"),
    [
        (np.zeros(5), r"q: want shape \(\.\.\., 6\) for the joints of arm 'test arm', got \(5,\)"),
        (np.zeros((6, 2)), r"got \(6, 2\)"),
        (1.0, r"got \(\)"),
        ([0.0, 0.0, np.nan, 0.0, 0.0, 0.0], "q: want finite numbers, got .*nan"),
        ([0.0, 0.0, np.inf, 0.0, 0.0, 0.0], "q: want finite numbers"),
        (["a"] * 6, "q: want an array of numbers"),
    ],
)
@pytest.mark.parametrize("ask", ["fk", "frames", "jacobian"])
def test_joint_vectors_that_are_none_are_refused(widowx, ask, q, message):
    with pytest.raises(ValueError, match=message):
        getattr(widowx, ask)(q)


@pytest.fixture(scope="module")
def links():
    kind = JointKind.REVOLUTE
    return tuple(Link(name, kind, np.eye(4), np.eye(4)) for name in ("one", "two"))


def test_an_arm_may_be_made_of_links_alone(links, limits_of):
    arm = Arm(
        "bare", links, limits_of(["one", "two"], [JointKind.REVOLUTE] * 2, -np.ones(2), np.ones(2))
    )
    assert arm.n == 2
    assert arm.joint_names == ("one", "two")
    assert arm.dh is None
    np.testing.assert_allclose(arm.fk([0.3, 0.4]), space.rotation_z(0.7), atol=1e-15)


def test_limits_of_other_joints_are_refused(links, limits_of):
    limits = limits_of(["one", "three"], [JointKind.REVOLUTE] * 2, -np.ones(2), np.ones(2))
    with pytest.raises(
        ValueError, match=r"want those of the joints \['one', 'two'\], got \['one',"
    ):
        Arm("bare", links, limits)


def test_limits_of_another_kind_are_refused(links, limits_of):
    limits = limits_of(["one", "two"], list(JointKind), -np.ones(2), np.ones(2))
    with pytest.raises(ValueError, match="joint 'two' is prismatic there but revolute here"):
        Arm("bare", links, limits)


def test_an_arm_without_links_and_one_with_a_name_twice_are_refused(links, limits_of):
    with pytest.raises(ValueError, match="want at least one link"):
        Arm("bare", (), limits_of([], [], [], []))
    limits = limits_of(["one", "one"], [JointKind.REVOLUTE] * 2, -np.ones(2), np.ones(2))
    with pytest.raises(ValueError, match="joint names repeat"):
        Arm("bare", (links[0], links[0]), limits)


def test_a_table_that_does_not_describe_the_links_is_refused(links, limits_of):
    limits = limits_of(["one", "two"], [JointKind.REVOLUTE] * 2, -np.ones(2), np.ones(2))
    rows = (DHLink("one", 0.0, 0.0, 0.0, 0.0), DHLink("two", 0.1, 0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="row 'two' does not describe link 'two'"):
        Arm("bare", links, limits, convention=DHConvention.STANDARD, dh=rows)
    with pytest.raises(ValueError, match="convention: want the one of the DH table"):
        Arm("bare", links, limits, dh=rows)
    with pytest.raises(ValueError, match="dh: want 2 rows"):
        Arm("bare", links, limits, convention=DHConvention.STANDARD, dh=rows[:1])


def test_inertias_stay_with_their_links(limits_of):
    rows = [DHLink("one", 0.1, 0.0, 0.0, 0.0), DHLink("two", 0.1, 0.0, 0.0, 0.0)]
    limits = limits_of(["one", "two"], [JointKind.REVOLUTE] * 2, -np.ones(2), np.ones(2))
    body = Inertia(1.0, np.zeros(3), np.eye(3))
    arm = Arm.from_dh("a", rows, DHConvention.MODIFIED, limits, inertias=[None, body])
    assert [link.inertia for link in arm.links] == [None, body]
    with pytest.raises(ValueError, match="inertias: want 2 of them, one a link, got 1"):
        Arm.from_dh("a", rows, DHConvention.MODIFIED, limits, inertias=[body])


def test_a_tool_that_is_not_rigid_is_refused(widowx):
    with pytest.raises(ValueError, match="T_flange_tool: want a rotation"):
        widowx.with_tool(np.diag((1.0, 2.0, 1.0, 1.0)))


def test_an_arm_prints_as_its_name_and_joints(planar):
    assert repr(planar) == "Arm('test arm', joints shoulder, elbow)"
