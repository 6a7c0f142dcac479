from math import cos, inf, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import UnreachableError
from splinearm.joints import JointKind
from splinearm.kinematics import (
    DHConvention,
    DHLink,
    Elbow,
    Planar2R,
    Pose,
    quaternion,
    search,
    solve_elbows,
    space,
)

lengths = st.floats(0.01, 2.0)
angles = st.floats(-pi, pi)


def tip(a1, a2, q):
    q1, q12 = q[..., 0], q[..., 0] + q[..., 1]
    x = a1 * np.cos(q1) + a2 * np.cos(q12)
    return np.stack((x, a1 * np.sin(q1) + a2 * np.sin(q12)), axis=-1)


@pytest.mark.property
@given(lengths, lengths, angles, angles)
def test_both_elbows_reach_the_point_and_one_is_the_pose_it_came_from(a1, a2, q1, q2):
    q = np.array((q1, q2))
    point = tip(a1, a2, q)
    up, down = solve_elbows(a1, a2, point)
    np.testing.assert_allclose(tip(a1, a2, up), point, atol=1e-12)
    np.testing.assert_allclose(tip(a1, a2, down), point, atol=1e-12)
    assert -pi <= up[1] <= 0.0 <= down[1] <= pi
    if 1e-3 < abs(q2) < pi - 1e-3 and np.hypot(*point) > 1e-3:
        same = up if q2 < 0.0 else down
        apart = same - q
        np.testing.assert_allclose(np.sin(0.5 * apart), 0.0, atol=1e-8)


@pytest.mark.property
@given(lengths, lengths, angles, st.floats(0.01, 3.1))
def test_the_elbow_that_is_up_lies_left_of_the_way_to_the_target(a1, a2, q1, bend):
    x, y = tip(a1, a2, np.array((q1, bend)))
    elbows = solve_elbows(a1, a2, (x, y))
    for q, side in ((elbows.up, 1.0), (elbows.down, -1.0)):
        elbow = (a1 * cos(q[0]), a1 * sin(q[0]))
        assert side * (x * elbow[1] - y * elbow[0]) >= -1e-12


def test_at_full_stretch_the_elbows_coincide_exactly():
    up, down = solve_elbows(0.3, 0.25, (0.55, 0.0))
    np.testing.assert_array_equal(up, [0.0, 0.0])
    np.testing.assert_array_equal(down, [0.0, 0.0])


@pytest.mark.parametrize(("a1", "a2"), [(0.3, 0.25), (0.25, 0.3)])
def test_at_full_fold_the_elbows_are_one_pose(a1, a2):
    up, down = solve_elbows(a1, a2, (0.05, 0.0))
    assert abs(up[1]) == abs(down[1]) == pytest.approx(pi, abs=1e-7)
    np.testing.assert_allclose(tip(a1, a2, up), [0.05, 0.0], atol=1e-15)
    np.testing.assert_allclose(np.sin(0.5 * (up - down)), 0.0, atol=1e-7)


def test_equal_links_reach_their_shoulder_with_the_first_angle_at_zero():
    up, down = solve_elbows(0.3, 0.3, (0.0, 0.0))
    np.testing.assert_array_equal(up, [0.0, -pi])
    np.testing.assert_array_equal(down, [0.0, pi])


@pytest.mark.parametrize("short", [1e-4, 1e-8, 1e-12, 1e-15])
def test_beside_full_stretch_the_answer_keeps_its_digits(short):
    r = 0.55 - short
    down = solve_elbows(0.3, 0.25, (r, 0.0)).down
    # near q2 = 0 the reach falls by a1 a2 q2^2 / (2 (a1 + a2))
    bend = np.sqrt(2.0 * 0.55 * (0.55 - r) / (0.3 * 0.25))
    assert down[1] == pytest.approx(bend, rel=1e-3)


def test_points_come_in_batches():
    points = np.random.default_rng(0).uniform(0.1, 0.35, (2, 5, 2))
    up, down = solve_elbows(0.3, 0.25, points)
    assert up.shape == down.shape == (2, 5, 2)
    np.testing.assert_allclose(tip(0.3, 0.25, up), points, atol=1e-15)


@pytest.mark.parametrize(
    ("point", "miss", "at"), [((0.6, 0.0), 0.05, "600 mm"), ((0.0, 0.02), 0.03, "20 mm")]
)
def test_a_point_off_the_ring_is_refused_with_the_ring(point, miss, at):
    with pytest.raises(UnreachableError) as caught:
        solve_elbows(0.3, 0.25, [(0.4, 0.0), point])
    assert caught.value.position_error == pytest.approx(miss)
    assert str(caught.value) == (
        f"the position is out of reach by {miss * 1e3:.4g} mm: the arm reaches from 50 mm to "
        f"550 mm from its shoulder; the target is at {at}"
    )


@pytest.mark.parametrize(
    ("a1", "a2", "point", "message"),
    [
        (0.0, 0.2, (0.1, 0.1), "a1: want a finite length above zero, got 0.0"),
        (0.2, inf, (0.1, 0.1), "a2: want a finite length above zero, got inf"),
        (0.2, 0.2, (0.1, 0.1, 0.1), r"points: want finite numbers of shape \(..., 2\)"),
        (0.2, 0.2, (0.1, np.nan), "points: want finite numbers"),
    ],
)
def test_lengths_and_points_that_are_none_are_refused(a1, a2, point, message):
    with pytest.raises(ValueError, match=message):
        solve_elbows(a1, a2, point)


def placed_arm(dh_arm, seed, **limits):
    """Give a planar arm that stands anywhere, with any zeros, offsets and axis senses."""
    rng = np.random.default_rng(seed)
    base = Pose(rng.normal(size=3), quaternion.normalize(rng.normal(size=4))).matrix()
    flip = rng.choice([0.0, pi])
    d1, d2, theta1, theta2 = rng.uniform(-1.0, 1.0, 4)
    rows = [
        DHLink("one", rng.uniform(0.1, 0.5), flip, d1, theta1),
        DHLink("two", 0.0, 0.0, d2, theta2),
    ]
    tool = space.translation(rng.uniform(0.05, 0.3, 3)) @ space.rotation((1.0, 2.0, 3.0), 0.7)
    return dh_arm(rows, DHConvention.STANDARD, T_base_first=base, T_flange_tool=tool, **limits)


@pytest.mark.property
@given(st.integers(0, 100_000))
@settings(deadline=None)
def test_a_planar_arm_is_recognised_however_it_stands(dh_arm, seed):
    arm = placed_arm(dh_arm, seed)
    planar = Planar2R.of(arm)
    q = np.random.default_rng(seed).uniform(-pi, pi, 2)
    target = arm.fk(q)[:3, 3]
    found = planar.solutions(target, q)
    assert set(found) == set(Elbow)
    for answer in found.values():
        np.testing.assert_allclose(arm.fk(answer)[:3, 3], target, atol=1e-12)
    np.testing.assert_allclose(planar.solve(target, q), q, atol=1e-6)


def test_an_elbow_is_named_from_the_tip_of_the_first_axis(planar):
    found = Planar2R.of(planar).solutions([0.4, 0.0, 0.06])
    assert found[Elbow.UP][0] > 0.0 > found[Elbow.UP][1]
    assert found[Elbow.DOWN][0] < 0.0 < found[Elbow.DOWN][1]


@pytest.mark.property
@given(st.integers(0, 100_000))
@settings(deadline=None)
def test_closed_form_and_search_agree(planar, joints_inside, seed):
    q = joints_inside(planar, np.random.default_rng(seed))
    target = planar.fk(q)[:3, 3]
    closed = Planar2R.of(planar).solutions(target)
    result = search(planar, target)
    assert result.reached
    apart = min(np.abs(result.q - answer).max() for answer in closed.values())
    assert apart < 1e-3 if abs(q[1]) < 1e-2 else apart < 1e-6


def test_limits_are_kept_and_the_other_elbow_is_given(planar):
    found = Planar2R.of(planar).solutions([-0.45, -0.2, 0.06])
    assert list(found) == [Elbow.UP]
    with pytest.raises(UnreachableError, match=r"shoulder is at its limit, .* deg short") as caught:
        Planar2R.of(planar).solve([-0.45, -0.2, 0.06], elbow=Elbow.DOWN)
    assert caught.value.position_error > 1e-3


def test_a_joint_limit_in_the_way_is_named_with_the_true_miss(planar):
    with pytest.raises(UnreachableError) as caught:
        Planar2R.of(planar).solve([-0.55, 0.0, 0.06])
    error = caught.value
    assert error.joint == "shoulder"
    assert error.reason == "shoulder is at its limit, 25.3 deg short"
    grid = np.stack(np.meshgrid(np.linspace(-2.7, 2.7, 801), np.linspace(-2.6, 2.6, 801)), axis=-1)
    p = planar.fk(grid)[..., :3, 3]
    best = np.linalg.norm(p - [-0.55, 0.0, 0.06], axis=-1).min()
    assert error.position_error == pytest.approx(best, abs=1e-4)
    with pytest.raises(UnreachableError, match="shoulder is at its limit"):
        Planar2R.of(planar).solutions([-0.55, 0.0, 0.06])


def test_turns_are_chosen_next_to_the_seed(dh_arm):
    rows = [DHLink("one", 0.3, 0, 0, 0), DHLink("two", 0.25, 0, 0, 0)]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=-20.0, q_max=20.0)
    planar = Planar2R.of(arm)
    seed = np.array([7.0, -12.0])
    q = planar.solve([0.3, 0.2, 0.0], seed)
    assert (np.abs(q - seed) <= 2 * pi).all()
    np.testing.assert_allclose(arm.fk(q)[:3, 3], [0.3, 0.2, 0.0], atol=1e-14)


def test_a_target_off_the_plane_is_refused_with_its_height(planar):
    with pytest.raises(UnreachableError) as caught:
        Planar2R.of(planar).solve([0.4, 0.0, 0.05])
    assert caught.value.position_error == pytest.approx(0.01)
    assert caught.value.reason == "the target is 10 mm below the plane of the arm"


@pytest.mark.parametrize(
    "rows",
    [
        [("one", 0.3, 0.0, 0.0, 0.0)],
        [("one", 0.3, 0.1, 0.0, 0.0), ("two", 0.25, 0.0, 0.0, 0.0)],
        [("one", 0.0, 0.0, 0.0, 0.0), ("two", 0.25, 0.0, 0.0, 0.0)],
        [("one", 0.3, 0.0, 0.0, 0.0), ("two", 0.0, 0.0, 0.0, 0.0)],
        [("one", 0.3, 0.0, 0.0, 0.0), ("two", 0.25, 0.0, 0.0, 0.0, JointKind.PRISMATIC)],
    ],
)
def test_an_arm_that_is_no_planar_2r_is_not_taken_for_one(dh_arm, rows):
    arm = dh_arm([DHLink(*row) for row in rows], DHConvention.STANDARD)
    assert Planar2R.of(arm) is None


def test_a_seed_of_another_shape_is_refused(planar):
    with pytest.raises(ValueError, match=r"q_seed: want shape \(2\), got \(3,\)"):
        Planar2R.of(planar).solve([0.4, 0.0, 0.06], [0.0, 0.0, 0.0])
