from math import pi

import numpy as np
import pytest

from splinearm.errors import KinematicsError
from splinearm.kinematics import DHConvention, DHLink, swivel
from splinearm.kinematics.closed_form import ClosedForm, branches

# KUKA LBR iiwa 7 R800, after its data sheet: a, alpha in right angles, d of standard rows
IIWA = ((0, -1, 0.34), (0, 1, 0), (0, 1, 0.4), (0, -1, 0), (0, -1, 0.4), (0, 1, 0), (0, 0, 0.126))
# made up: oblique axes, an elbow and a wrist with offsets, joints that count from elsewhere
OBLIQUE = ((0, -0.8, 0.34), (0, 0.9, 0), (0.05, 1.1, 0.4), (0.03, -1, 0.02), (0, -0.9, 0.4),
           (0.09, 0.8, 0.04), (0, 0, 0.126))  # fmt: skip
ARMS = ("iiwa", "panda", "oblique")
JOINTS = [f"joint{i}" for i in range(1, 8)]


@pytest.fixture(scope="module")
def arms(closed_arms, dh_arm):
    """Arms of seven joints, by name."""
    made = {"panda": closed_arms["panda"]}
    for name, table in (("iiwa", IIWA), ("oblique", OBLIQUE)):
        turned = 0.1 if name == "oblique" else 0.0
        rows = [
            DHLink(f"joint{i + 1}", a, alpha * pi / 2, d, turned * i)
            for i, (a, alpha, d) in enumerate(table)
        ]
        made[name] = dh_arm(rows, DHConvention.STANDARD)
    return made


def away(q, other):
    """Give the largest difference of angles of rows of q and one vector, whole turns aside."""
    return np.abs(np.sin(0.5 * (np.atleast_2d(q) - other))).max(axis=1)


def check_swivel(arm, rng, m):
    """Every branch meets pose and swivel, the generating q is among them, none comes twice."""
    form = ClosedForm.of(arm, given="swivel")
    for i, q in enumerate(rng.uniform(-pi, pi, (m, 7))):
        T, angle = arm.fk(q), swivel.swivel_of(arm, q)
        found, codes = form.solve(T, np.zeros(7), angle)
        assert len(found) == len(codes)
        assert away(found, q).min() < 1e-6
        assert np.abs(arm.fk(found) - T).max() < 1e-9
        row = found[i % len(found)]
        assert abs(np.sin(0.5 * (swivel.swivel_of(arm, row) - angle))) < 1e-8
        assert len(found) % 2 == 0
        for k in range(1, len(found)):
            assert away(found[:k], found[k]).min() > 1e-7


@pytest.mark.kernel
@pytest.mark.parametrize("name", ARMS)
def test_every_branch_with_a_swivel_is_found(arms, name, rng_of):
    check_swivel(arms[name], rng_of(1), 30)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_so_it_is_on_ten_thousand_poses(arms, name, rng_of):
    check_swivel(arms[name], rng_of(2), 10_000)


@pytest.mark.kernel
@pytest.mark.parametrize("name", ARMS)
def test_the_swivel_is_the_angle_from_the_first_axis_to_the_elbow_about_the_way(arms, name):
    arm = arms[name]
    q = np.array((0.2, 0.6, 0.1, -1.1, 0.3, 0.9, -0.4))
    angle = swivel.swivel_of(arm, q)
    assert -pi <= angle <= pi
    # turning all of the arm about the first axis leaves it as it is; so does the last joint of a
    # wrist whose axes meet
    turned = q + np.array((0.7, 0, 0, 0, 0, 0, 0))
    assert swivel.swivel_of(arm, turned) == pytest.approx(angle, abs=1e-12)
    wrist = q + np.array((0, 0, 0, 0, 0.4, 0.3, 0.7))
    assert swivel.swivel_of(arm, wrist) == pytest.approx(angle, abs=1e-12)


@pytest.mark.kernel
def test_an_elbow_straight_above_has_no_swivel_and_one_to_the_left_a_quarter_turn(arms):
    arm = arms["iiwa"]
    above = np.array((0.0, 0.5, 0.0, -1.2, 0.0, 0.0, 0.0))
    assert abs(swivel.swivel_of(arm, above)) < 1e-12
    T = arm.fk(above)
    found = branches(arm, T, given={"swivel": pi / 2})
    assert len(found) == 8
    for q in found.q:
        frames = arm.frames(q)
        shoulder, elbow, wrist = frames[1, :3, 3], frames[2, :3, 3], frames[4, :3, 3]
        way = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
        side = np.cross(way, (0.0, 0.0, 1.0))
        aside = elbow - shoulder - way * (way @ (elbow - shoulder))
        aside, side = aside / np.linalg.norm(aside), side / np.linalg.norm(side)
        np.testing.assert_allclose(aside, side, atol=1e-12)


@pytest.mark.kernel
def test_where_the_swivel_has_no_meaning_it_is_refused(arms):
    arm = arms["iiwa"]
    upright = arm.fk(np.array((0.3, 0.6, 0.0, 1.2, 0.1, 0.5, 0.2)))
    upright[:2, 3] = upright[:2, 2] * 0.126
    with pytest.raises(KinematicsError, match="wrist lies on the first axis"):
        branches(arm, upright, given={"swivel": 0.0})
    with pytest.raises(KinematicsError, match="arm is straight"):
        swivel.swivel_of(arm, (0.3, 0.6, 0.0, 0.0, 0.1, 0.5, 0.2))
    with pytest.raises(KinematicsError, match="wrist lies on the first axis"):
        swivel.swivel_of(arm, (0.3, 0.0, 0.0, 0.0, 0.1, 0.5, 0.2))
    with pytest.raises(ValueError, match=r"q: want shape \(7,\)"):
        swivel.swivel_of(arm, np.zeros((2, 7)))


@pytest.mark.kernel
def test_arms_without_an_elbow_between_shoulder_and_wrist_have_none(closed_arms, random_arm):
    for arm in (closed_arms["puma"], random_arm(1, 7, DHConvention.STANDARD, slides=False)):
        with pytest.raises(KinematicsError, match="has no swivel"):
            swivel.swivel_of(arm, np.zeros(arm.n))
    with pytest.raises(ValueError, match="want an arm of seven joints, got one of 6"):
        branches(closed_arms["puma"], np.eye(4), given={"swivel": 0.0})


@pytest.mark.kernel
@pytest.mark.parametrize("name", ARMS)
def test_batches_with_a_swivel_agree_with_single_calls(arms, name, rng_of):
    arm = arms[name]
    form = ClosedForm.of(arm, given="swivel")
    T = arm.fk(rng_of(3).uniform(-pi, pi, (4, 7)))
    found, count = form.solve_batch(T, np.zeros(7), 0.4)
    for T_one, answers, n in zip(T, found, count.astype(int), strict=True):
        q, _ = form.solve(T_one, np.zeros(7), 0.4)
        np.testing.assert_array_equal(q, answers[:n])
        assert np.isnan(answers[n:]).all()


@pytest.mark.kernel
def test_branches_with_a_swivel_have_names(arms):
    q = np.array((0.3, -0.4, 0.9, -1.5, 1.1, 0.7, 0.2))
    for arm in arms.values():
        found = branches(arm, arm.fk(q), q, given={"swivel": swivel.swivel_of(arm, q)})
        assert np.abs(found.q[0] - q).max() < 1e-8
        assert found.names[0].startswith("shoulder ")


def check_given(arm, joint, rng, m):
    """Every branch meets the pose and keeps the joint, the generating q is among them."""
    i = arm.joint_names.index(joint)
    for _ in range(m):
        q = rng.uniform(-pi, pi, 7)
        T = arm.fk(q)
        found = branches(arm, T, given={joint: q[i]})
        assert away(found.q, q).min() < 1e-6
        assert np.abs(arm.fk(found.q) - T).max() < 1e-8
        np.testing.assert_allclose(np.sin(found.q[:, i] - q[i]), 0.0, atol=1e-12)


@pytest.mark.parametrize("joint", JOINTS)
def test_any_joint_of_a_panda_may_be_given(arms, joint, rng_of):
    check_given(arms["panda"], joint, rng_of(9), 12)


@pytest.mark.slow
@pytest.mark.parametrize("joint", JOINTS)
def test_so_it_may_in_a_thousand_poses(arms, joint, rng_of):
    check_given(arms["panda"], joint, rng_of(10), 1000)


@pytest.mark.kernel
@pytest.mark.parametrize("joint", [name for name in JOINTS if name != "joint4"])
def test_any_joint_but_the_elbow_of_an_arm_with_two_spheres_may_be_given(arms, joint, rng_of):
    check_given(arms["iiwa"], joint, rng_of(11), 12)


@pytest.mark.kernel
def test_the_elbow_of_two_spheres_says_nothing_that_the_pose_does_not(arms):
    arm, q = arms["iiwa"], np.array((0.3, -0.4, 0.9, -1.5, 1.1, 0.7, 0.2))
    T = arm.fk(q)
    # what is left open stays where the seed has it
    assert away(branches(arm, T, q, given={"joint4": q[3]}).q, q).min() < 1e-6
    assert not branches(arm, T, q, given={"joint4": q[3] + 0.1}).reached


@pytest.mark.parametrize("joint", JOINTS)
def test_a_given_joint_may_stand_where_axes_line_up(arms, joint, rng_of):
    arm, rng = arms["panda"], rng_of(17)
    i = arm.joint_names.index(joint)
    for angle in (0.0, pi / 2, -pi / 2, pi):
        q = rng.uniform(-pi, pi, 7)
        q[i] = angle
        T = arm.fk(q)
        if (joint, angle) in (("joint2", 0.0), ("joint2", pi), ("joint4", 0.0)):
            # the axes on both sides of the joint become one
            with pytest.raises(KinematicsError, match="give another position"):
                branches(arm, T, q, given={joint: angle})
            continue
        found = branches(arm, T, q, given={joint: angle})
        assert away(found.q, q).min() < 1e-6
        assert np.abs(arm.fk(found.q) - T).max() < 1e-8


@pytest.mark.parametrize("joint", ["joint1", "joint4", "joint7"])
def test_batches_with_a_joint_given_agree_with_single_calls(arms, joint, rng_of):
    arm = arms["panda"]
    form = ClosedForm.of(arm, given=joint)
    Q = rng_of(12).uniform(-pi, pi, (4, 7))
    Q[:, arm.joint_names.index(joint)] = 0.6
    T = arm.fk(Q)
    found, count = form.solve_batch(T, np.zeros(7), 0.6)
    for q, T_one, answers, n in zip(Q, T, found, count.astype(int), strict=True):
        assert away(answers[:n], q).min() < 1e-6
        one, _ = form.solve(T_one, np.zeros(7), 0.6)
        assert len(one) == n
        assert np.isnan(answers[n:]).all()


@pytest.mark.kernel
def test_seven_joints_want_something_given(arms):
    arm = arms["panda"]
    with pytest.raises(KinematicsError, match="give the position of one joint, or the swivel"):
        branches(arm, np.eye(4))
    with pytest.raises(ValueError, match="want one of"):
        branches(arm, np.eye(4), given={"elbow": 0.0})
    with pytest.raises(ValueError, match="q_given: want a number"):
        branches(arm, np.eye(4), given={"swivel": np.nan})
