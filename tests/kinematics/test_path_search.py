from itertools import pairwise

import numpy as np
import pytest

from splinearm.errors import PathError
from splinearm.kinematics import DHConvention, DHLink, Pose, search
from splinearm.kinematics.path_search import PathStatus, search_path, solve_path

NAMES = ["puma", "ur5", "panda", "widowx"]


def line(T, way, m):
    Ts = np.repeat(T[None], m, axis=0)
    Ts[:, :3, 3] += np.linspace(0.0, 1.0, m)[:, None] * way
    return Ts


def random_line(arm, inside, rng, m):
    """Give a straight line along which the tool keeps its orientation."""
    way = rng.normal(size=3)
    return line(arm.fk(inside(arm, rng)), rng.uniform(0.05, 0.3) * way / np.linalg.norm(way), m)


def follows(arm, q, a, b, parts=32):
    """Say whether the branch of q follows the line from pose a to pose b, by another way.

    Many small steps of the search that stays with its seed, each of which may move the joints by
    no more than a little.
    """
    for share in np.linspace(0.0, 1.0, parts + 1)[1:]:
        T = a.copy()
        T[:3, 3] += share * (b - a)[:3, 3]
        result = search(arm, Pose.from_matrix(T), q, restarts=0)
        if not result.reached or np.abs(result.q - q).max() > 0.1:
            return None
        q = result.q
    return q


def assert_no_jump(arm, Ts, result):
    """Every point is met within limits, and so is what lies between points."""
    q = result.q
    assert (q >= arm.limits.q_min).all()
    assert (q <= arm.limits.q_max).all()
    np.testing.assert_allclose(arm.fk(q), Ts[: len(q)], atol=4e-6)
    for i, step in enumerate(np.abs(np.diff(q, axis=0)).max(axis=1)):
        if step <= 0.05:
            # so small that the straight way between is the branch's own
            middle = arm.fk(0.5 * (q[i] + q[i + 1]))
            np.testing.assert_allclose(middle, 0.5 * (Ts[i] + Ts[i + 1]), atol=0.02 * step + 1e-5)
            continue
        arrived = follows(arm, q[i], Ts[i], Ts[i + 1], 512)
        assert arrived is not None
        # where an arm with joints to spare goes depends a little on the size of the steps
        np.testing.assert_allclose(arrived, q[i + 1], atol=1e-2 if arm.n == 6 else 0.1)


def assert_lines_are_followed(arm, inside, count, seed):
    rng = np.random.default_rng(seed)
    outcomes = []
    for _ in range(count):
        Ts = random_line(arm, inside, rng, 25)
        result = search_path(arm, Ts)
        outcomes.append(result.status)
        assert_no_jump(arm, Ts, result)
        if not result.followed:
            assert result.point == len(result.q)
            assert f"point {result.point}" in result.reason
        if result.status is PathStatus.BRANCH_ENDS:
            # no branch that reaches the point before goes on
            branches = {
                tuple(np.round(q, 2)): q
                for q in (search(arm, Pose.from_matrix(Ts[0]), s).q for s in inside(arm, rng, 10))
            }
            for q in branches.values():
                at = q
                for a, b in pairwise(Ts[: result.point + 1]):
                    at = None if at is None else follows(arm, at, a, b, 8)
                assert at is None
    return outcomes


@pytest.mark.parametrize("name", NAMES)
def test_straight_lines_are_followed_without_a_jump(known_arm, joints_inside, name):
    outcomes = assert_lines_are_followed(known_arm(name), joints_inside, 25, 1)
    assert outcomes.count(PathStatus.FOLLOWED) >= 5


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", NAMES)
def test_many_straight_lines_are_followed_without_a_jump(known_arm, joints_inside, name):
    assert_lines_are_followed(known_arm(name), joints_inside, 250, 2)


@pytest.mark.parametrize("name", NAMES)
def test_what_one_branch_is_known_to_follow_is_followed(known_arm, joints_inside, name):
    arm = known_arm(name)
    rng = np.random.default_rng(3)
    followed = 0
    while followed < 8:
        q = joints_inside(arm, rng)
        Ts = random_line(arm, joints_inside, rng, 2)
        Ts = line(arm.fk(q), Ts[1, :3, 3] - Ts[0, :3, 3], 20)
        known = q
        for a, b in pairwise(Ts):
            known = None if known is None else follows(arm, known, a, b, 4)
        if known is None:
            continue
        followed += 1
        assert search_path(arm, Ts).status is PathStatus.FOLLOWED


@pytest.fixture(scope="module")
def elbow(dh_arm):
    """A planar arm whose elbow bends both ways, its shoulder only a little."""
    rows = [DHLink("shoulder", 0.3, 0.0, 0.0, 0.0), DHLink("elbow", 0.3, 0.0, 0.0, 0.0)]
    return dh_arm(rows, DHConvention.STANDARD, q_min=(-1.0, -2.8), q_max=(1.0, 2.8))


def test_the_branch_is_chosen_that_reaches_the_end(elbow):
    # upwards only the elbow that bends left stays within the shoulder's limits
    way = np.array([[0.4, y, 0.0] for y in np.linspace(0.0, 0.35, 30)])
    q = solve_path(elbow, way)
    assert (q[:, 1] > 0.0).all()
    assert np.abs(np.diff(q, axis=0)).max() < 0.1


def test_a_refusal_names_the_point_and_the_joint_where_only_a_jump_goes_on(elbow):
    # from far up to far down one elbow begins and the other ends
    way = np.array([[0.35, y, 0.0] for y in np.linspace(0.33, -0.33, 67)])
    result = search_path(elbow, way)
    assert result.status is PathStatus.BRANCH_ENDS
    assert result.joint == "shoulder"
    assert 33 <= result.point < 66
    assert "shoulder is at its limit" in result.reason
    assert "jump" in result.reason
    with pytest.raises(PathError, match=f"to point {result.point} of 0 to 66") as caught:
        solve_path(elbow, way)
    assert caught.value.joint == "shoulder"
    assert caught.value.point == result.point


def test_a_point_out_of_reach_is_named(elbow):
    way = np.array([[x, 0.0, 0.0] for x in np.linspace(0.4, 0.7, 31)])
    result = search_path(elbow, way)
    assert result.status is PathStatus.UNREACHABLE
    assert result.point == 21
    assert result.reason.startswith("point 21 of 0 to 30 is out of reach by 10 mm")


def test_a_gap_between_two_points_is_told_from_a_point_out_of_reach(dh_arm):
    rows = [DHLink("one", 0.3, 0, 0, 0), DHLink("two", 0.2, 0, 0, 0)]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=-3.1, q_max=3.1)
    result = search_path(arm, [[0.3, 0.01, 0.0], [-0.3, 0.01, 0.0]])
    assert result.status is PathStatus.UNREACHABLE
    assert (
        "% of the way from point 0 to point 1 of 0 to 1 the tool is out of reach" in result.reason
    )


def test_the_first_branch_is_the_one_next_to_where_the_arm_stands(elbow):
    way = np.array([[0.4, y, 0.0] for y in np.linspace(-0.05, 0.05, 5)])
    for bend in (-1.0, 1.0):
        q = solve_path(elbow, way, [0.0, bend])
        assert (np.sign(q[:, 1]) == bend).all()


def test_a_wrist_may_turn_on_past_half_a_turn_where_its_limits_have_room(dh_arm):
    rows = [DHLink(f"j{i}", 0.2, 0, 0, 0) for i in range(3)]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=(-3.1, -2.8, -9.0), q_max=(3.1, 2.8, 9.0))
    bent = np.linspace([0.3, 0.5, 2.0], [-0.2, 0.9, 8.0], 200)
    q = solve_path(arm, arm.fk(bent))
    assert np.ptp(q[:, 2]) > 5.0
    assert np.abs(np.diff(q, axis=0)).max() < 0.1


def test_a_point_that_is_said_twice_is_no_harm(elbow):
    q = solve_path(elbow, [[0.4, 0.1, 0.0], [0.4, 0.1, 0.0], [0.4, 0.12, 0.0]])
    np.testing.assert_allclose(q[0], q[1], atol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"targets": np.empty((0, 3))}, "targets: want at least one point"),
        ({"targets": [[np.nan, 0.0, 0.0]]}, "targets: want finite numbers"),
        ({"q_start": [0.0]}, r"q_start: want shape \(2\)"),
        ({"orientation_tolerance": 0.0}, "orientation_tolerance: want a finite number above"),
    ],
)
def test_arguments_that_are_none_are_refused(elbow, arguments, message):
    with pytest.raises(ValueError, match=message):
        search_path(elbow, **{"targets": [[0.4, 0.1, 0.0]], **arguments})
