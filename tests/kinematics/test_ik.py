from dataclasses import fields
from math import inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import UnreachableError
from splinearm.joints import JointKind
from splinearm.kinematics import (
    DHConvention,
    DHLink,
    IKResult,
    IKStatus,
    Pose,
    quaternion,
    search,
    solve,
    solver,
    space,
)

seeds = st.integers(0, 100_000)
conventions = st.sampled_from(list(DHConvention))


def pose_at(arm, q):
    return Pose.from_matrix(arm.fk(q))


def assert_holds(arm, target, result):
    """What a result says is so: errors by forward kinematics, limits, and its status."""
    T = arm.fk(result.q)
    p = target.p if isinstance(target, Pose) else target
    assert result.position_error == pytest.approx(np.linalg.norm(T[:3, 3] - p), abs=1e-12)
    turned = 0.0
    if isinstance(target, Pose):
        turned = quaternion.angle_between(quaternion.from_matrix(T[:3, :3]), target.quat)
    assert result.orientation_error == pytest.approx(turned, abs=1e-9)
    assert (result.q >= arm.limits.q_min).all()
    assert (result.q <= arm.limits.q_max).all()
    met = result.position_error <= 1e-6 and result.orientation_error <= 1e-6
    assert result.reached == met
    assert bool(result.reason) != met


@pytest.mark.property
@given(seeds, st.integers(2, 8), conventions)
@settings(deadline=None, max_examples=60)
def test_fk_of_solve_of_fk_is_fk_on_any_arm(random_arm, joints_inside, seed, n, convention):
    arm = random_arm(seed, n, convention)
    T = arm.fk(joints_inside(arm, np.random.default_rng(seed)))
    q = solve(arm, Pose.from_matrix(T))
    np.testing.assert_allclose(arm.fk(q), T, atol=3e-6)
    assert (q >= arm.limits.q_min).all()
    assert (q <= arm.limits.q_max).all()


@pytest.mark.property
@given(seeds)
@settings(deadline=None, max_examples=60)
def test_every_pose_of_the_widowx_is_found_without_a_seed(widowx, joints_inside, seed):
    target = pose_at(widowx, joints_inside(widowx, np.random.default_rng(seed)))
    result = search(widowx, target)
    assert result.status is IKStatus.REACHED
    assert_holds(widowx, target, result)


@pytest.mark.property
@given(seeds, st.integers(2, 8), conventions, st.booleans(), st.booleans())
@settings(deadline=None, max_examples=40)
def test_no_result_says_more_than_is_so(random_arm, seed, n, convention, near, whole):
    arm = random_arm(seed, n, convention)
    rng = np.random.default_rng(seed)
    target = Pose(rng.uniform(-0.8, 0.8, 3), quaternion.normalize(rng.normal(size=4)))
    aim = target if whole else target.p
    result = search(arm, aim, rng.uniform(-3, 3, n) if near else None, restarts=0 if near else 8)
    assert_holds(arm, aim, result)


def test_the_same_question_has_the_same_answer(widowx):
    target = pose_at(widowx, [0.5, 0.3, -0.4, 1.0, 0.7, -2.0])
    first, second = search(widowx, target), search(widowx, target)
    np.testing.assert_array_equal(first.q, second.q)


def test_a_position_leaves_the_orientation_free(widowx):
    target = np.array([0.3, 0.1, 0.2])
    result = search(widowx, target)
    assert_holds(widowx, target, result)
    assert result.reached
    assert result.orientation_error == 0.0


def test_tighter_tolerances_are_met(widowx):
    target = pose_at(widowx, [0.5, 0.3, -0.4, 1.0, 0.7, -2.0])
    result = search(widowx, target, position_tolerance=1e-12, orientation_tolerance=1e-12)
    assert result.reached
    assert max(result.position_error, result.orientation_error) <= 1e-12


def test_following_a_line_from_answer_to_answer_stays_on_the_branch(widowx):
    start = np.array([0.2, 0.4, -0.3, 0.5, 0.8, 0.1])
    T = widowx.fk(start)
    q = start
    steps = []
    for share in np.linspace(0.0, 1.0, 101)[1:]:
        there = T.copy()
        there[:3, 3] += share * np.array([-0.08, 0.06, 0.05])
        result = search(widowx, Pose.from_matrix(there), q, restarts=0)
        assert result.reached
        assert result.iterations <= 5
        steps.append(np.abs(result.q - q).max())
        q = result.q
    assert max(steps) < 0.02
    assert max(steps) < 3.0 * np.median(steps)


def test_following_through_a_stretched_wrist_does_not_jump(widowx):
    # at wrist_angle = 0 the axes of forearm_roll and wrist_rotate are one line
    q = np.array([0.0, 0.2, -0.3, 0.0, 0.3, 0.0])
    for wrist in np.linspace(0.3, -0.3, 121)[1:]:
        wanted = np.array([0.0, 0.2, -0.3, 0.0, wrist, 0.0])
        result = search(widowx, pose_at(widowx, wanted), q, restarts=0)
        assert result.reached
        assert np.abs(result.q - q).max() < 0.05
        q = result.q


def test_full_stretch_is_reached_from_a_bent_seed(planar):
    result = search(planar, [0.55, 0.0, 0.06], [0.1, -0.2], restarts=0)
    assert result.reached
    assert result.position_error < 1e-6


@pytest.mark.property
@given(seeds)
@settings(deadline=None, max_examples=60)
def test_turns_of_free_joints_are_those_next_to_the_seed(dh_arm, seed):
    rows = [DHLink(f"j{i}", length, 0, 0, 0) for i, length in enumerate((0.3, 0.25, 0.1))]
    arm = dh_arm(rows, DHConvention.STANDARD)
    rng = np.random.default_rng(seed)
    q_seed = rng.uniform(-20.0, 20.0, 3)
    result = search(arm, pose_at(arm, rng.uniform(-3.0, 3.0, 3)), q_seed)
    assert result.reached
    assert (np.abs(result.q - q_seed) <= pi).all()


def test_an_arm_of_sliding_joints_is_solved(dh_arm):
    slide = JointKind.PRISMATIC
    rows = [
        DHLink("x", 0.0, -pi / 2, 0.0, -pi / 2, slide),
        DHLink("y", 0.0, -pi / 2, 0.0, -pi / 2, slide),
        DHLink("z", 0.0, 0.0, 0.0, 0.0, slide),
    ]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=0.0, q_max=0.4)
    target = arm.fk([0.1, 0.3, 0.2])[:3, 3]
    np.testing.assert_allclose(solve(arm, target), [0.1, 0.3, 0.2], atol=1e-9)
    beyond = search(arm, arm.fk([0.1, 0.45, 0.2])[:3, 3])
    assert beyond.status is IKStatus.JOINT_LIMIT
    assert beyond.joint == "y"
    assert beyond.reason == "out of reach by 50 mm: y is at its limit, 50 mm short"
    np.testing.assert_allclose(beyond.q, [0.1, 0.4, 0.2], atol=1e-9)


def test_sizes_do_not_matter_a_watchmakers_arm_and_a_crane_are_solved(dh_arm):
    for size in (1e-3, 50.0):
        rows = [DHLink(f"j{i}", size, pi / 2 * (i % 2), 0.0, 0.0) for i in range(6)]
        arm = dh_arm(rows, DHConvention.STANDARD, q_min=-3.0, q_max=3.0)
        target = pose_at(arm, [0.3, 0.5, -0.4, 0.2, 0.6, -0.1])
        assert search(arm, target, position_tolerance=1e-6 * size).reached


def test_a_far_target_is_out_of_reach_by_what_is_missing(planar):
    result = search(planar, [0.6, 0.0, 0.06])
    assert result.status is IKStatus.OUT_OF_REACH
    assert result.joint is None
    assert result.position_error == pytest.approx(0.05, abs=1e-9)
    assert result.reason == (
        "out of reach by 50 mm: the arm stretches to 550 mm at most from its first joint; "
        "the target is at 600 mm"
    )
    assert result.iterations < 300


def test_heights_along_parallel_axes_are_no_part_of_the_stretch(dh_arm):
    rows = [DHLink("one", 0.3, pi, 0.2, 0), DHLink("two", 0.25, 0, 0.15, 0)]
    arm = dh_arm(rows, DHConvention.STANDARD)
    result = search(arm, [0.6, 0.0, 0.05])
    assert result.position_error == pytest.approx(0.05, abs=1e-9)
    assert "the arm stretches to 550 mm" in result.reason
    assert "the target is at 600 mm" in result.reason


def test_a_target_too_near_is_out_of_reach(dh_arm):
    rows = [DHLink("one", 0.3, 0, 0, 0), DHLink("two", 0.25, 0, 0, 0)]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=-3.5, q_max=3.5)
    result = search(arm, [0.02, 0.0, 0.0])
    assert result.status is IKStatus.OUT_OF_REACH
    assert result.position_error == pytest.approx(0.03, abs=1e-7)


def test_a_limit_in_the_way_is_named_with_what_is_short(widowx):
    q = np.array([0.3, 0.2, -0.3, 0.4, 2.4, 0.3])
    result = search(
        widowx, pose_at(widowx, q), np.clip(q, widowx.limits.q_min, widowx.limits.q_max), restarts=0
    )
    assert result.status is IKStatus.JOINT_LIMIT
    assert result.joint == "wrist_angle"
    assert result.cause == "wrist_angle is at its limit, 14.5 deg short"
    assert result.position_error <= 1e-6
    assert result.q[4] == widowx.limits.q_max[4]


def test_an_orientation_that_four_joints_cannot_give_is_told_by_its_angle(dh_arm):
    rows = [
        DHLink("turn", 0.0, pi / 2, 0.1, 0.0),
        DHLink("shoulder", 0.3, 0.0, 0.0, 0.0),
        DHLink("elbow", 0.25, 0.0, 0.0, 0.0),
        DHLink("wrist", 0.1, 0.0, 0.0, 0.0),
    ]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=-3.0, q_max=3.0)
    T = arm.fk([0.4, 0.6, -0.8, 0.3])
    assert search(arm, Pose.from_matrix(T)).reached
    # turned out of the arm's own upright plane, which it cannot leave
    axis = T[:3, 0]
    twisted = T.copy()
    twisted[:3, :3] = space.rotation(axis, np.radians(20.0))[:3, :3] @ T[:3, :3]
    result = search(arm, Pose.from_matrix(twisted))
    assert result.status is IKStatus.ORIENTATION
    assert result.position_error <= 1e-6
    assert result.orientation_error == pytest.approx(np.radians(20.0), abs=1e-6)
    assert result.reason.startswith("out of reach by 20 deg: the 4 joints of the arm cannot")


def test_a_tight_tolerance_does_not_turn_a_missed_orientation_into_a_missed_position(widowx):
    # the tool pulled back to the shoulder's height, but looking where only a seventh joint could
    target = Pose([0.55, 0.0, 0.2], quaternion.from_euler([0.0, 0.0, 2.0], "xyz"))
    result = search(widowx, target, position_tolerance=1e-9)
    assert result.status is IKStatus.ORIENTATION
    assert result.position_error <= 1e-9
    assert result.reason.startswith("out of reach by ")
    assert " mm" not in result.reason


def test_a_limit_before_the_position_is_named_even_if_the_orientation_is_hopeless(planar):
    upside_down = Pose([-0.55, 0.0, 0.06], [0.0, 1.0, 0.0, 0.0])
    result = search(planar, upside_down)
    assert result.status is IKStatus.JOINT_LIMIT
    assert result.joint == "shoulder"
    assert result.position_error > 0.05


@pytest.mark.property
@given(seeds, st.integers(3, 5))
@settings(deadline=None, max_examples=30)
def test_a_position_that_can_be_reached_is_reached_whatever_the_orientation(
    random_arm, joints_inside, seed, n
):
    arm = random_arm(seed, n, DHConvention.STANDARD)
    rng = np.random.default_rng(seed)
    p = arm.fk(joints_inside(arm, rng))[:3, 3]
    result = search(arm, Pose(p, quaternion.normalize(rng.normal(size=4))))
    assert result.position_error <= 1e-6
    assert result.status in (IKStatus.REACHED, IKStatus.ORIENTATION, IKStatus.JOINT_LIMIT)


def test_following_says_when_the_seeds_branch_ends(planar):
    result = search(planar, [-0.4, 0.0, 0.06], [0.0, 0.1], restarts=0)
    assert result.status is IKStatus.NOT_CONVERGED
    assert "try another seed" in result.reason
    assert search(planar, [-0.4, 0.0, 0.06], [0.0, 0.1]).reached


def test_solve_raises_with_the_facts(planar):
    with pytest.raises(UnreachableError, match="the position is out of reach by 50 mm: the arm"):
        solve(planar, [0.6, 0.0, 0.06])
    with pytest.raises(UnreachableError, match="the pose is out of reach by 50 mm") as caught:
        solve(planar, Pose([0.6, 0.0, 0.06], [1.0, 0.0, 0.0, 0.0]))
    assert caught.value.position_error == pytest.approx(0.05, abs=1e-6)
    tipped = Pose([0.4, 0.1, 0.06], quaternion.from_euler([0.3, 0.0, 0.0], "XYZ"))
    with pytest.raises(UnreachableError, match=r"out of reach by [\d.]+ deg: the 2 joints"):
        solve(planar, tipped)


def test_a_seed_beyond_a_limit_starts_on_it(planar):
    result = search(planar, planar.fk([2.6, 0.5])[:3, 3], [9.0, 0.5], restarts=0)
    assert result.reached
    np.testing.assert_allclose(result.q, [2.6, 0.5], atol=1e-7)


def test_a_target_in_other_words_for_the_same_rotation_is_the_same(widowx):
    target = pose_at(widowx, np.full(6, 0.4))
    other = Pose(target.p, -target.quat)
    np.testing.assert_array_equal(search(widowx, target).q, search(widowx, other).q)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"target": np.eye(4)}, r"target: want shape \(3\), got \(4, 4\)"),
        ({"target": [0.0, np.nan, 0.0]}, "target: want finite numbers"),
        ({"q_seed": [0.0]}, r"q_seed: want shape \(2\), got \(1,\)"),
        ({"q_seed": [0.0, inf]}, "q_seed: want finite numbers"),
        ({"position_tolerance": 0.0}, "position_tolerance: want a finite number above zero"),
        ({"orientation_tolerance": inf}, "orientation_tolerance: want a finite number above"),
        ({"restarts": 0}, "restarts: want at least 1 without a seed"),
        ({"restarts": -1, "q_seed": [0.0, 0.0]}, "restarts: want .* got -1"),
    ],
)
@pytest.mark.parametrize("ask", [search, solve])
def test_arguments_that_are_none_are_refused(planar, ask, arguments, message):
    with pytest.raises(ValueError, match=message):
        ask(planar, **{"target": [0.4, 0.1, 0.06], **arguments})


@pytest.mark.kernel
def test_a_confirmed_result_is_like_any_other(widowx):
    solver.load()
    result = search(widowx, pose_at(widowx, np.full(6, 0.3)))
    values = {each.name: getattr(result, each.name) for each in fields(IKResult)}
    assert repr(IKResult(**values)) == repr(result)
    assert not result.q.flags.writeable
    with pytest.raises(AttributeError):
        result.q = np.zeros(6)


@pytest.mark.kernel
def test_joints_with_room_for_a_turn_may_be_turned_through_their_limits(dh_arm):
    rows = [DHLink(f"j{i}", 0.3, 0, 0, 0) for i in range(2)]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=-pi, q_max=pi)
    solver.load()
    for angle in (3.1, -3.1, pi, -pi):
        result = search(arm, arm.fk([angle, 0.4])[:3, 3])
        assert result.reached
        assert (np.abs(result.q) <= pi).all()
