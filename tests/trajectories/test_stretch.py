"""Joint moves that end in the configuration from which the tool can go on."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import UnreachableError
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import ik, quaternion
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.kinematics.pose import Pose
from splinearm.trajectories.plan import plan
from splinearm.trajectories.waypoint import ArcThrough, Facing, Move, Waypoint

TOLERANCE = 2e-5


@pytest.fixture(scope="module")
def puma():
    """Puma 560, standard DH: Corke and Armstrong-Helouvry, ICRA 1994."""
    rows = [
        (0.0, np.pi / 2, 0.6718),
        (0.4318, 0.0, 0.1501),
        (0.0203, -np.pi / 2, 0.0),
        (0.0, np.pi / 2, 0.4318),
        (0.0, -np.pi / 2, 0.0),
        (0.0, 0.0, 0.06),
    ]
    names = ("waist", "shoulder", "elbow", "roll", "pitch", "flange")
    links = [
        DHLink(name, a=a, alpha=alpha, d=d, theta=0.0)
        for name, (a, alpha, d) in zip(names, rows, strict=True)
    ]
    reach = np.radians([160.0, 110.0, 135.0, 266.0, 100.0, 266.0])
    limits = JointLimits(
        names=names,
        kinds=(JointKind.REVOLUTE,) * 6,
        q_min=-reach,
        q_max=reach,
        qd_max=[3.0] * 6,
        qdd_max=[10.0] * 6,
    )
    return Arm.from_dh("Puma", links, DHConvention.STANDARD, limits)


@pytest.fixture(params=["arm_6", "puma"])
def arm(request):
    return request.getfixturevalue(request.param)


def pose_at(arm, q):
    T = arm.fk(np.asarray(q))
    return Pose(T[:3, 3], quaternion.from_matrix(T[:3, :3]))


def moved(pose, step):
    return Pose(pose.p + np.asarray(step), pose.quat)


def largest_step(made, count=4000):
    """The largest change of a joint from one moment to the next, beside what its speed allows."""
    t = np.linspace(0.0, made.trajectory.duration, count)
    q, qd, _ = made.trajectory.sample(t)
    allowed = 1.5 * np.abs(qd).max(axis=0) * (t[1] - t[0]) + 1e-6
    return float((np.abs(np.diff(q, axis=0)) / allowed).max())


def tool_misses(arm, made, first, last, quat, count=2000):
    """How far the tool is off a straight line and off its orientation while it goes along it."""
    t = np.linspace(*made.waypoint_times[-2:], count)
    T = arm.fk(made.trajectory.sample(t)[0])
    along = (last - first) / np.linalg.norm(last - first)
    off = T[:, :3, 3] - first
    off = off - (off @ along)[:, None] * along
    turned = quaternion.angle_between(quaternion.from_matrix(T[:, :3, :3]), quat)
    return np.linalg.norm(off, axis=1).max(), turned.max()


CASES = {
    "arm_6": [
        (
            [-0.7, -0.4, 0.5, 0.1, -0.6, -0.1],
            [-0.1, -0.8, 0.4, -1.5, -0.1, 0.1],
            [-0.03, 0.03, 0.1],
        ),
        ([0.3, -0.2, 0.1, 0.3, 0.3, 0.0], [0.2, -0.7, -0.2, -1.4, 0.1, 0.1], [0.11, -0.04, -0.19]),
        ([0.7, 0.5, 0.4, 0.5, 0.5, -0.4], [-0.1, -0.3, -0.7, 0.3, -0.3, 0.4], [0.03, -0.16, -0.02]),
    ],
    "puma": [
        ([0.0, -0.5, -0.1, 0.6, 0.1, 0.7], [-1.7, -0.4, 0.8, 1.0, 0.1, 0.9], [0.15, 0.07, 0.02]),
        (
            [0.7, -0.5, -0.6, -0.8, 0.6, 0.8],
            [-0.9, -0.5, -0.9, 0.6, 0.0, 1.8],
            [-0.12, 0.15, -0.01],
        ),
        ([0.7, -0.7, 0.7, -0.3, 0.4, -0.8], [-0.2, 0.4, 0.4, 1.7, -0.7, -0.6], [0.05, -0.19, 0.13]),
    ],
}


@pytest.mark.parametrize("which", range(3))
def test_a_joint_move_ends_where_the_line_behind_it_can_be_followed(request, arm, which):
    q_start, q_there, step = CASES[request.node.callspec.params["arm"]][which]
    first = pose_at(arm, q_there)
    last = moved(first, step)
    nearest = ik.solve(arm, first, np.asarray(q_start))
    line = [Waypoint(pose=last, move=Move.LINE)]
    with pytest.raises(UnreachableError, match="if the arm starts in another configuration"):
        plan(arm, line, nearest)
    made = plan(arm, [Waypoint(pose=first, move=Move.JOINT), *line], q_start)
    assert largest_step(made) <= 1.0
    off, turned = tool_misses(arm, made, first.p, last.p, first.quat)
    assert off <= TOLERANCE
    assert turned <= TOLERANCE / 0.1
    q_begin = made.trajectory.at(made.waypoint_times[0]).q
    assert np.abs(q_begin - nearest).max() > 0.1


@pytest.mark.parametrize("which", range(3))
def test_the_configuration_that_a_refusal_names_can_follow(request, arm, which):
    q_start, q_there, step = CASES[request.node.callspec.params["arm"]][which]
    first = pose_at(arm, q_there)
    line = [Waypoint(pose=moved(first, step), move=Move.LINE)]
    with pytest.raises(UnreachableError) as caught:
        plan(arm, line, ik.solve(arm, first, np.asarray(q_start)))
    words = caught.value.reason.rsplit(": ", 1)[1].split(", ")
    named = np.radians([float(word.split()[-2]) for word in words])
    assert [word.split()[0] for word in words] == list(arm.joint_names)
    # what is said has four digits: the arm goes to the very pose from there
    made = plan(arm, [Waypoint(pose=first, move=Move.JOINT), *line], named)
    assert np.abs(made.trajectory.at(made.waypoint_times[0]).q - named).max() < 0.01


def test_where_the_nearest_configuration_can_follow_it_is_kept(arm_6, q_6):
    first = pose_at(arm_6, q_6)
    q_start = q_6 + 0.2
    made = plan(
        arm_6,
        [
            Waypoint(pose=first, move=Move.JOINT),
            Waypoint(pose=moved(first, [0.0, -0.1, 0.02]), move=Move.LINE),
        ],
        q_start,
    )
    nearest = ik.solve(arm_6, first, q_start)
    assert np.allclose(made.trajectory.at(made.waypoint_times[0]).q, nearest, atol=1e-9)


def test_all_moves_of_the_tool_up_to_the_next_joint_move_count(arm_6):
    q_start, q_there, step = CASES["arm_6"][0]
    first = pose_at(arm_6, q_there)
    nearest = ik.solve(arm_6, first, np.asarray(q_start))
    there_and_back = [
        Waypoint(pose=first, move=Move.JOINT),
        Waypoint(pose=moved(first, 0.05 * np.asarray(step)), move=Move.BSPLINE),
        Waypoint(pose=moved(first, step), move=Move.LINE),
        Waypoint(q=q_start, move=Move.JOINT),
    ]
    short = plan(arm_6, there_and_back[:2], q_start)
    assert np.allclose(short.trajectory.at(short.waypoint_times[0]).q, nearest, atol=1e-9)
    whole = plan(arm_6, there_and_back, q_start)
    assert np.abs(whole.trajectory.at(whole.waypoint_times[0]).q - nearest).max() > 0.1
    assert largest_step(whole) <= 1.0


def test_joint_positions_that_are_given_are_never_changed(arm_6):
    q_start, q_there, step = CASES["arm_6"][0]
    first = pose_at(arm_6, q_there)
    nearest = ik.solve(arm_6, first, np.asarray(q_start))
    with pytest.raises(UnreachableError, match="if the arm starts in another configuration"):
        plan(
            arm_6,
            [
                Waypoint(q=nearest, move=Move.JOINT),
                Waypoint(pose=moved(first, step), move=Move.LINE),
            ],
            q_start,
        )


def test_a_planar_arm_changes_its_elbow_in_the_joint_move(arm_2r):
    # the shoulder would pass its limit with one elbow, with the other it has room
    p = arm_2r.fk(np.array([2.6, -0.8]))[:3, 3]
    line = [Waypoint(position=arm_2r.fk(np.array([2.9, -0.8]))[:3, 3], move=Move.LINE)]
    with pytest.raises(UnreachableError, match="'shoulder' would have to pass its limit"):
        plan(arm_2r, line, np.array([2.6, -0.8]))
    made = plan(arm_2r, [Waypoint(position=p, move=Move.JOINT), *line], np.array([2.5, -0.8]))
    elbow = made.trajectory.sample(np.linspace(*made.waypoint_times, 100))[0][:, 1]
    assert (elbow > 0.5).all()


def test_a_place_that_no_configuration_reaches_is_named_without_advice(arm_6, q_6):
    first = pose_at(arm_6, q_6)
    far = Waypoint(pose=moved(first, [2.0, 0.0, 0.0]), move=Move.LINE, name="far")
    with pytest.raises(UnreachableError, match=r"waypoint 2 'far' is out of reach") as caught:
        plan(arm_6, [Waypoint(pose=first, move=Move.JOINT), far], q_6 + 0.1)
    assert "configuration" not in str(caught.value)


KINDS = ["line", "arc", "spline", "turning"]


@pytest.mark.property
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10_000), kind=st.sampled_from(KINDS))
def test_joints_never_jump_and_the_tool_keeps_its_way_or_the_place_is_named(
    arm_6, puma, seed, kind
):
    check_one(arm_6, puma, seed, kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_on_many_ways_joints_never_jump(arm_6, puma, kind):
    followed = sum(check_one(arm_6, puma, seed, kind) for seed in range(20_000, 20_250))
    assert followed > 25


def check_one(arm_6, puma, seed, kind):
    """Plan a random way; look at all that is promised; tell whether it could be followed."""
    rng = np.random.default_rng(seed)
    arm = (arm_6, puma)[seed % 2]
    low, high = 0.8 * arm.limits.q_min, 0.8 * arm.limits.q_max
    first = pose_at(arm, rng.uniform(low, high))
    steps = np.cumsum(rng.normal(scale=0.05, size=(3, 3)), axis=0)
    waypoints = [Waypoint(pose=first, move=Move.JOINT), *_tool_moves(kind, first, steps)]
    try:
        made = plan(arm, waypoints, rng.uniform(low, high))
    except UnreachableError as error:
        refusal = error
        made = None
    if made is None:
        assert "waypoint" in refusal.what
        return False
    assert largest_step(made) <= 1.0
    t = np.linspace(made.waypoint_times[0], made.trajectory.duration, 3000)
    q, _, _ = made.trajectory.sample(t)
    assert (q >= arm.limits.q_min - 1e-9).all()
    assert (q <= arm.limits.q_max + 1e-9).all()
    for a, b in pairwise(made.trajectory.sections):
        assert np.allclose(a.path.at(a.law.s[-1])[0], b.path.at(b.law.s[0])[0], atol=1e-9)
    T = arm.fk(q)
    assert made.tool_path.distance(T[:, :3, 3]).max() <= TOLERANCE
    if kind in ("line", "arc"):
        have = quaternion.from_matrix(T[:, :3, :3])
        assert quaternion.angle_between(have, first.quat).max() <= TOLERANCE / 0.1
    return True


def _tool_moves(kind, first, steps):
    p = first.p + steps
    if kind == "line":
        return [Waypoint(pose=Pose(x, first.quat), move=Move.LINE) for x in p]
    if kind == "arc":
        return [Waypoint(pose=Pose(p[1], first.quat), move=Move.ARC, arc=ArcThrough(p[0]))]
    if kind == "turning":
        return [Waypoint(position=x, move=Move.BSPLINE, facing=Facing.TANGENT) for x in p]
    turns = quaternion.exp(3.0 * steps)
    quats = quaternion.multiply(turns, first.quat)
    return [Waypoint(pose=Pose(x, quat)) for x, quat in zip(p, quats, strict=True)]
