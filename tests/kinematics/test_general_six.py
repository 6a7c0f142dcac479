from math import pi

import numpy as np
import pytest

from splinearm.errors import KinematicsError
from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, general_six, structure
from splinearm.kinematics.closed_form import ArmClass, ClosedForm, branches

ANY = ("meeting wrist", "meeting wrist, base 12", "meeting wrist, oblique", "any", "random")


@pytest.fixture(scope="module")
def arms(closed_arms, dh_arm, random_arm):
    """Arms of six joints of no class that has a closed form of its own, by name."""
    rng = np.random.default_rng(0)
    rows = [
        DHLink(f"joint{i}", *rng.uniform((-0.3, -pi, -0.3, -pi), (0.3, pi, 0.3, pi)))
        for i in range(6)
    ]
    return {
        **closed_arms,
        "any": dh_arm(rows, DHConvention.STANDARD),
        "random": random_arm(0, 6, DHConvention.STANDARD, slides=False),
    }


def away(q, other):
    """Give the largest difference of angles of rows of q and one vector, whole turns aside."""
    return np.abs(np.sin(0.5 * (np.atleast_2d(q) - other))).max(axis=1)


def check_random(arm, rng, m):
    """Solve random poses: every branch meets its pose, the generating q is among them."""
    form = ClosedForm.of(arm)
    assert form.structure.kind is ArmClass.GENERAL
    Q = rng.uniform(-pi, pi, (m, 6))
    T = arm.fk(Q)
    found, count = form.solve_batch(T, np.zeros(6))
    for q, T_one, answers, n in zip(Q, T, found, count.astype(int), strict=True):
        assert away(answers[:n], q).min() < 1e-6
        assert np.abs(arm.fk(answers[:n]) - T_one).max() < 1e-8
        assert np.isnan(answers[n:]).all()
        # real roots of a polynomial of degree 16 come in pairs
        assert n % 2 == 0
        for k in range(1, n):
            assert away(answers[:k], answers[k]).min() > 1e-7, "a branch came twice"


@pytest.mark.parametrize("name", ANY)
def test_every_branch_meets_its_pose_and_the_joints_it_came_from_are_among_them(arms, name, rng_of):
    check_random(arms[name], rng_of(1), 40)


@pytest.mark.slow
@pytest.mark.parametrize("name", ANY)
def test_so_it_is_on_ten_thousand_poses(arms, name, rng_of):
    check_random(arms[name], rng_of(2), 10_000)


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


def check_singular(arm, rng, m):
    """Solve singular poses and such close to them: none is left, the seed is kept where free."""
    form = ClosedForm.of(arm)
    for i in range(m):
        if i % 3:
            q = singular_joints(arm, rng)
            q = q + (i % 3 - 1) * rng.normal(size=6) * 10 ** rng.uniform(-12, -2)
        else:
            q = rng.choice([0.0, pi / 2, -pi / 2, pi, 0.3], 6)
        T = arm.fk(q)
        found, _ = form.solve(T, np.zeros(6))
        assert len(found), f"none for {q.tolist()}"
        assert np.abs(arm.fk(found) - T).max() < 1e-8
        found, _ = form.solve(T, q)
        assert away(found, q).min() < 1e-4, "free joints do not keep the seed's values"


@pytest.mark.parametrize("name", ANY)
def test_every_singular_pose_is_solved(arms, name, rng_of):
    check_singular(arms[name], rng_of(3), 15)


@pytest.mark.slow
@pytest.mark.parametrize("name", ANY)
def test_so_are_a_thousand(arms, name, rng_of):
    check_singular(arms[name], rng_of(4), 1000)


@pytest.mark.slow
@pytest.mark.parametrize("name", ANY)
def test_many_restarts_of_the_numeric_steps_find_no_branch_that_is_missing(arms, name, rng_of):
    from splinearm.kinematics import general_six_kernel

    arm, rng = arms[name], rng_of(5)
    form = ClosedForm.of(arm)
    one, more = form.structure.gauge, 0
    for _ in range(40):
        T = arm.fk(rng.uniform(-pi, pi, 6))
        found, _ = form.solve(T, np.zeros(6))
        B = np.linalg.solve(one.first, T) @ np.linalg.inv(one.last)
        for _ in range(400):
            angles = rng.uniform(-pi, pi, 6)
            if general_six_kernel.polish(form.structure.packed, B[:3].copy(), angles) < 1e-9:
                assert away(found, one.sign * (angles - one.offset)).min() < 1e-6
                more += 1
    assert more > 4000


def test_single_calls_and_batches_agree(arms, rng_of):
    arm = arms["any"]
    form = ClosedForm.of(arm)
    T = arm.fk(rng_of(6).uniform(-pi, pi, (5, 6)))
    found, count = form.solve_batch(T, np.zeros(6))
    assert found.shape == (5, 16, 6)
    for T_one, answers, n in zip(T, found, count.astype(int), strict=True):
        np.testing.assert_array_equal(form.solve(T_one, np.zeros(6))[0], answers[:n])


def test_the_door_names_branches_by_number_nearest_first(arms):
    arm, q = arms["any"], np.array((0.3, -0.4, 0.9, 0.5, 1.1, -0.7))
    found = branches(arm, arm.fk(q), q)
    assert np.abs(found.q[0] - q).max() < 1e-8
    assert all(name.startswith("branch ") for name in found.names)
    assert len(set(found.names)) == len(found)


@pytest.mark.kernel
def test_a_pose_out_of_reach_has_no_branch_and_says_why(arms):
    T = np.eye(4)
    T[0, 3] = 5.0
    none = branches(arms["any"], T)
    assert not none.reached
    assert "mm" in none.reason


def test_ways_that_serve_are_kept_for_arms_that_are_alike(arms):
    found = general_six.complete(structure.find(arms["any"].packed))
    again = general_six.complete_like(structure.find(arms["any"].packed), found)
    np.testing.assert_array_equal(found.packed, again.packed)
    # along the ways of another arm this one's determinant may be zero throughout
    other = general_six.complete(structure.find(arms["meeting wrist"].packed))
    assert other is not None
    like = general_six.complete_like(structure.find(arms["meeting wrist"].packed), found)
    assert len(like.packed) > 14


def test_arms_that_move_no_more_than_in_five_ways_are_refused(dh_arm):
    parallel = [DHLink(f"joint{i}", 0.2, 0.0 if i < 4 else 1.0, 0.1, 0.0) for i in range(6)]
    with pytest.raises(KinematicsError, match="no closed form"):
        branches(dh_arm(parallel, DHConvention.STANDARD), np.eye(4))
    slides = [DHLink("slide", 0.1, 1.0, 0.2, 0.0, JointKind.PRISMATIC), *parallel[1:]]
    with pytest.raises(KinematicsError, match="no closed form"):
        branches(dh_arm(slides, DHConvention.STANDARD), np.eye(4))
