from math import inf, pi

import numpy as np
import pytest

from splinearm.errors import KinematicsError
from splinearm.joints import JointKind
from splinearm.kinematics import (
    DHConvention,
    DHLink,
    Pose,
    chain,
    gauge,
    six_kernel,
    structure,
)
from splinearm.kinematics.answer import IKStatus
from splinearm.kinematics.closed_form import ArmClass, ClosedForm, branches

pytestmark = pytest.mark.kernel

SIX = ("puma", "industrial", "ur5", "oblique wrist", "base 12", "base 23", "parallel 12", "quartic")
FEW = {
    "koch": ("nothing", "yaw", "roll", "yaw and roll", "orientation"),
    "omx_f": ("nothing", "yaw", "roll", "yaw and roll", "orientation"),
    "rx150": ("nothing", "yaw", "roll", "yaw and roll", "orientation"),
    "wx200": ("nothing", "yaw", "roll", "yaw and roll", "orientation"),
    "open_manipulator_x": ("nothing", "yaw", "yaw and roll", "orientation"),
}
FEW_CASES = [(name, free) for name, words in FEW.items() for free in words]


def away(q, other):
    """Give the largest difference of angles of rows of q and one vector, whole turns aside."""
    return np.abs(np.sin(0.5 * (np.atleast_2d(q) - other))).max(axis=1)


def unmet(arm, q, T, free):
    """Give the largest miss of rows of q in what is not free; the tool points along x."""
    reached = arm.fk(q)
    worst = np.abs(reached[:, :3, 3] - T[:3, 3]).max()
    if free == "orientation":
        return worst
    if free == "nothing":
        return max(worst, np.abs(reached - T).max())
    if free == "yaw":
        return max(worst, np.abs(reached[:, 2, :3] - T[2, :3]).max())
    if free == "yaw and roll":
        return max(worst, np.abs(reached[:, 2, 0] - T[2, 0]).max())
    last = chain.joint_frames(arm.packed, np.zeros(arm.n))
    axis = last[-1, :3, :3].T @ last[-2, :3, 2]
    return max(worst, np.abs(reached[:, :3, :3] @ axis - T[:3, :3] @ axis).max())


def check_six(arm, rng, m):
    """Solve random poses: every branch meets its pose, the generating q is among them."""
    form = ClosedForm.of(arm)
    Q = rng.uniform(-pi, pi, (m, 6))
    T = arm.fk(Q)
    found, count = form.solve_batch(T, np.zeros(6))
    counts = count.astype(int)
    for i in range(m):
        q = found[i, : counts[i]]
        assert away(q, Q[i]).min() < 1e-6
        for k in range(1, counts[i]):
            assert away(q[:k], q[k]).min() > 1e-7, "a branch came twice"
    branch = np.arange(found.shape[1]) < counts[:, None]
    wanted = np.broadcast_to(T[:, None], (*branch.shape, 4, 4))[branch]
    assert np.abs(arm.fk(found[branch]) - wanted).max() < 1e-9
    assert np.isnan(found[~branch]).all()


@pytest.mark.parametrize("name", SIX)
def test_every_branch_meets_its_pose_and_the_joints_it_came_from_are_among_them(
    closed_arms, name, rng_of
):
    check_six(closed_arms[name], rng_of(1), 400)


@pytest.mark.slow
@pytest.mark.parametrize("name", SIX)
def test_so_it_is_on_ten_thousand_poses(closed_arms, name, rng_of):
    check_six(closed_arms[name], rng_of(2), 10_000)


def test_a_spherical_wrist_with_parallel_axes_and_room_has_eight_branches(closed_arms, rng_of):
    form = ClosedForm.of(closed_arms["puma"])
    q = rng_of(3).uniform(-pi, pi, (200, 6))
    _, count = form.solve_batch(closed_arms["puma"].fk(q), np.zeros(6))
    assert (count == 8).all()


@pytest.mark.parametrize("name", SIX)
def test_single_calls_and_batches_agree(closed_arms, name, rng_of):
    form = ClosedForm.of(closed_arms[name])
    T = closed_arms[name].fk(rng_of(4).uniform(-pi, pi, (20, 6)))
    found, count = form.solve_batch(T, np.zeros(6))
    for i in range(20):
        q, _ = form.solve(np.ascontiguousarray(T[i]), np.zeros(6))
        assert len(q) == count[i]
        np.testing.assert_allclose(q, found[i, : len(q)], atol=1e-9)


def singular_joints(arm, rng):
    """Give joint positions where the arm has lost a direction: a zero of det(J) on a line."""
    while True:
        q, k = rng.uniform(-pi, pi, 6), rng.integers(1, 5)
        line = np.tile(q, (40, 1))
        line[:, k] = np.linspace(-pi, pi, 40)
        det = np.linalg.det(arm.jacobian(line))
        change = np.flatnonzero(det[:-1] * det[1:] < 0.0)
        if not len(change):
            continue
        low, high = line[change[0]], line[change[0] + 1]
        for _ in range(60):
            middle = 0.5 * (low + high)
            same = np.linalg.det(arm.jacobian(middle)) * det[change[0]] > 0.0
            low, high = (middle, high) if same else (low, middle)
        return 0.5 * (low + high)


@pytest.mark.parametrize("name", SIX)
def test_every_singular_pose_is_solved(closed_arms, name, rng_of):
    arm, rng = closed_arms[name], rng_of(5)
    form = ClosedForm.of(arm)
    joints = [rng.choice([0.0, pi / 2, -pi / 2, pi, 0.3], 6) for _ in range(85)]
    joints += [singular_joints(arm, rng) for _ in range(40)]
    for q in joints:
        T = arm.fk(q)
        found, _ = form.solve(T, rng.uniform(-pi, pi, 6))
        assert len(found), f"none for {q.tolist()}"
        assert np.abs(arm.fk(found) - T).max() < 1e-9
        found, _ = form.solve(T, q)
        assert away(found, q).min() < 1e-4, "free joints do not keep the seed's values"


@pytest.mark.parametrize("name", SIX)
def test_close_to_singular_poses_the_branch_is_found_too(closed_arms, name, rng_of):
    arm, rng = closed_arms[name], rng_of(6)
    form = ClosedForm.of(arm)
    for _ in range(40):
        q = singular_joints(arm, rng) + rng.normal(size=6) * 10 ** rng.uniform(-12, -2)
        T = arm.fk(q)
        found, _ = form.solve(T, q)
        assert np.abs(arm.fk(found) - T).max() < 1e-8
        assert away(found, q).min() < 1e-4


@pytest.mark.parametrize(("name", "free"), FEW_CASES)
def test_arms_of_few_joints_meet_what_is_not_free(closed_arms, name, free, rng_of):
    arm, rng = closed_arms[name], rng_of(7)
    redundant = free in ("yaw and roll", "orientation") or (free == "roll" and name != "koch")
    for _ in range(60):
        q = rng.uniform(-pi, pi, arm.n)
        T = arm.fk(q)
        seed = q if redundant else np.zeros(arm.n)
        found = branches(arm, T, seed, free=free)
        assert found.reached
        assert away(found.q, q).min() < 1e-6
        assert unmet(arm, found.q, T, free) < 1e-9
        assert len(found.names) == len(found) == len(found.position_error)


@pytest.mark.parametrize("name", FEW)
def test_a_tool_that_looks_straight_down_is_no_trouble(closed_arms, name, rng_of):
    arm, rng = closed_arms[name], rng_of(8)
    # how each joint turns about the axis that nods the tool down
    sense = np.array((0, -1, 1, -1, 0) if name == "koch" else (0, 1, 1, 1, 0), dtype=float)
    for _ in range(40):
        q = rng.uniform(-1.5, 1.5, arm.n)
        q[3] = sense[3] * (pi / 2 - sense[1:3] @ q[1:3])
        T = arm.fk(q)
        for free in FEW[name]:
            found = branches(arm, T, q, free=free)
            assert away(found.q, q).min() < 1e-6
            assert unmet(arm, found.q, T, free) < 1e-9


def test_what_is_met_is_said(closed_arms):
    arm = closed_arms["rx150"]
    T = arm.fk(np.array((0.3, 0.2, 0.4, -0.2, 0.5)))
    words = [branches(arm, T, free=free).met for free in FEW["rx150"]]
    assert words == [
        "pose",
        "position, pitch and roll",
        "position and pointing direction",
        "position and pitch",
        "position",
    ]


@pytest.mark.parametrize("name", FEW)
def test_a_position_is_met_with_the_pitch_nearest_to_the_seeds(closed_arms, name, rng_of):
    arm, rng = closed_arms[name], rng_of(18)
    for _ in range(40):
        q = rng.uniform(-pi, pi, arm.n)
        p = arm.fk(q)[:3, 3]
        # from any pitch the position is reached; a roll that moves the tool point matters
        seed = rng.uniform(-pi, pi, arm.n)
        seed[4:] = q[4:]
        found = branches(arm, p, seed, free="orientation")
        assert found.met == "position"
        assert 1 <= len(found) <= 4
        assert np.abs(arm.fk(found.q)[:, :3, 3] - p).max() < 1e-9


def test_a_pose_that_five_joints_cannot_meet_says_what_would_help(closed_arms):
    arm = closed_arms["rx150"]
    T = Pose((0.25, 0.0, 0.2), (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))).matrix()
    none = branches(arm, T)
    assert not none.reached
    assert none.status is IKStatus.ORIENTATION
    assert none.reason.endswith("they can with yaw free")
    assert branches(arm, T, free="yaw").reached


@pytest.mark.parametrize("name", SIX[:4])
def test_arms_built_from_tool_to_base_are_solved_alike(closed_arms, name, rng_of):
    arm = closed_arms[name]
    found = structure.find(gauge.reverse(arm.packed))
    assert found.words.endswith("(seen from the tool)")
    for q in rng_of(14).uniform(-pi, pi, (30, 6)):
        back, _ = six_kernel.solve(found.packed, np.linalg.inv(arm.fk(q)), np.zeros(6))
        assert away(back, -q[::-1]).min() < 1e-6


def planar_arm(dh_arm, n, **limits):
    rows = [DHLink(f"joint{i + 1}", a, 0.0, 0.02, 0.3 * i) for i, a in enumerate((0.3, 0.25, 0.1))]
    return dh_arm(rows[:n], DHConvention.STANDARD, **limits)


def test_planar_arms_and_scara_are_solved(dh_arm, rng_of):
    rng = rng_of(10)
    scara = [
        DHLink("shoulder", 0.25, 0.0, 0.2, 0.0),
        DHLink("elbow", 0.2, pi, 0.0, 0.0),
        DHLink("lift", 0.0, 0.0, 0.0, 0.0, JointKind.PRISMATIC),
        DHLink("roll", 0.0, 0.0, 0.05, 0.0),
    ]
    for arm in (
        planar_arm(dh_arm, 2),
        planar_arm(dh_arm, 3),
        dh_arm(scara, DHConvention.STANDARD),
        dh_arm([scara[2], *scara[:2], scara[3]], DHConvention.STANDARD),
    ):
        assert ClosedForm.of(arm).structure.kind is ArmClass.PLANAR
        for _ in range(40):
            q = rng.uniform(-2.0, 2.0, arm.n)
            T = arm.fk(q)
            found = branches(arm, T, np.zeros(arm.n))
            assert away(found.q, q).min() < 1e-6
            assert np.abs(arm.fk(found.q) - T).max() < 1e-9
            assert len(found) == (1 if arm.n == 2 else 2)
            point = branches(arm, T[:3, 3], q, free="orientation")
            assert away(point.q, q).min() < 1e-6
            assert sorted(point.names) == ["elbow down", "elbow up"]


def test_limits_forbid_branches_and_turns_are_unwrapped(widowx, rng_of):
    rng = rng_of(11)
    limits = widowx.limits
    for _ in range(50):
        q = rng.uniform(limits.q_min, limits.q_max)
        found = branches(widowx, widowx.fk(q), q)
        assert np.abs(found.q[0] - q).max() < 1e-8
        assert (found.q >= limits.q_min).all()
        assert (found.q <= limits.q_max).all()
        assert len(found) + found.beyond in (4, 8)
        np.testing.assert_array_equal(found.nearest(q), found.q[0])


def test_turns_are_those_nearest_to_the_seed(closed_arms):
    arm = closed_arms["ur5"]
    q = np.array((5.0, -7.0, 1.0, 9.0, 0.5, -5.5))
    assert np.abs(branches(arm, arm.fk(q), q).q[0] - q).max() < 1e-9


def test_names_tell_the_branches_apart(closed_arms, widowx):
    q = np.array((0.4, -0.3, 0.2, 0.5, 0.7, -0.2))
    for arm in (closed_arms["puma"], closed_arms["ur5"], widowx):
        names = branches(arm, arm.fk(q)).names
        assert len(set(names)) == len(names)
    assert branches(widowx, widowx.fk(q), q).names[0].split(", ")[1] == "elbow up"


def test_the_elbow_that_is_up_is_higher(closed_arms):
    arm = closed_arms["rx150"]
    found = branches(arm, arm.fk((0.2, 0.5, 0.3, 0.1, 0.0)), free="yaw")
    height = chain.frames_batch(arm.packed, found.q)[:, 2, 2, 3]
    by_name = dict(zip(found.names, height, strict=True))
    for shoulder in ("shoulder left", "shoulder right"):
        for wrist in ("", ", wrist flipped"):
            up, down = (f"{shoulder}, elbow {word}{wrist}" for word in ("up", "down"))
            if up in by_name and down in by_name:
                assert by_name[up] > by_name[down]


def test_out_of_reach_says_so_in_millimetres(closed_arms):
    for name in (*SIX, *FEW):
        none = branches(closed_arms[name], Pose((3.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)))
        assert not none.reached
        assert none.status is IKStatus.OUT_OF_REACH
        assert "the arm stretches to" in none.reason
        with pytest.raises(ValueError, match="there is none"):
            none.nearest(np.zeros(closed_arms[name].n))


def test_every_pose_without_a_branch_has_a_status_and_a_reason(closed_arms, widowx, rng_of):
    rng, without = rng_of(15), 0
    arms = [closed_arms[name] for name in ("puma", "ur5", "rx150", "open_manipulator_x")]
    for arm in (*arms, widowx):
        for _ in range(250):
            quat = rng.normal(size=4)
            target = Pose(rng.uniform(-0.9, 0.9, 3), quat / np.linalg.norm(quat))
            found = branches(arm, target)
            assert found.reached == (found.status is IKStatus.REACHED) == (not found.reason)
            without += not found.reached
            if found.reached:
                assert np.abs(arm.fk(found.q) - target.matrix()).max() < 1e-8
            if found.status is IKStatus.JOINT_LIMIT:
                assert found.joint in found.reason
                assert found.beyond
    assert without > 700


def test_a_wrist_that_is_straight_keeps_the_seed_and_stays_within_limits(widowx, rng_of):
    rng = rng_of(16)
    for _ in range(50):
        q = rng.uniform(widowx.limits.q_min, widowx.limits.q_max)
        q[4] = 0.0
        seed = 0.3 * rng.uniform(widowx.limits.q_min, widowx.limits.q_max)
        found = branches(widowx, widowx.fk(q), seed)
        assert found.reached
        assert np.abs(found.q[:, 3] - seed[3]).min() < 1e-9


def test_a_limit_in_the_way_is_named(dh_arm):
    arm = planar_arm(dh_arm, 2, q_min=(-0.1, -inf), q_max=(0.1, inf))
    free = planar_arm(dh_arm, 2)
    none = branches(arm, free.fk((1.2, 0.3)), free="orientation")
    assert none.status is IKStatus.JOINT_LIMIT
    assert none.joint == "joint1"
    assert none.reason.startswith("joint1 is at its limit, ")
    assert none.beyond == 2


def test_wrong_words_and_numbers_are_refused(closed_arms, dh_arm):
    puma = closed_arms["puma"]
    with pytest.raises(ValueError, match="free: want one of"):
        branches(puma, np.eye(4), free="yaw")
    with pytest.raises(ValueError, match="want finite numbers"):
        branches(puma, np.full((4, 4), np.nan))
    with pytest.raises(ValueError, match="T: "):
        branches(puma, np.diag((1.0, 2.0, 1.0, 1.0)))
    with pytest.raises(ValueError, match="q_seed: want shape"):
        branches(puma, np.eye(4), np.zeros(5))
    with pytest.raises(ValueError, match="pointing: want a direction"):
        branches(closed_arms["rx150"], np.eye(4), pointing=np.zeros(3))
    with pytest.raises(ValueError, match="one joint and its position"):
        branches(puma, np.eye(4), given={})
    with pytest.raises(ValueError, match="want an arm of six joints or more"):
        ClosedForm.of(closed_arms["rx150"]).solve_batch(np.eye(4)[None], np.zeros(5))
    with pytest.raises(ValueError, match="use branches"):
        ClosedForm.of(closed_arms["rx150"]).solve(np.eye(4), np.zeros(5))
    rows = [DHLink(f"j{i}", 0.1, 1.0, 0.2, 0.0) for i in range(5)]
    with pytest.raises(KinematicsError, match="no closed form"):
        branches(dh_arm(rows, DHConvention.STANDARD), np.eye(4))
