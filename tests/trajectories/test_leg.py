import numpy as np
import pytest

from splinearm.errors import CurveError
from splinearm.kinematics.pose import Pose
from splinearm.trajectories.plan import plan, plan_joint_move
from splinearm.trajectories.waypoint import Move, Waypoint

TOLERANCE = 2e-5


def test_lines_are_straight_and_the_tool_stops_at_sharp_corners(arm_2r, q_2r, tool, sampled):
    corners = tool(arm_2r, q_2r) + np.array([[0.08, 0, 0], [0.08, -0.06, 0], [0.0, -0.06, 0]])
    made = plan(arm_2r, [Waypoint(position=p, move=Move.LINE) for p in corners], q_2r)
    q, qd, _ = made.trajectory.sample(made.waypoint_times)
    assert np.abs(qd).max() < 1e-6
    assert np.allclose(tool(arm_2r, q), corners, atol=TOLERANCE)
    _, q, _, _ = sampled(made)
    p = tool(arm_2r, q) - tool(arm_2r, q_2r)
    on_a_side = np.abs(np.stack((p[:, 1], p[:, 0] - 0.08, p[:, 1] + 0.06), axis=1)).min(axis=1)
    assert on_a_side.max() < TOLERANCE


def test_a_blend_rounds_the_corner_without_a_stop(arm_2r, q_2r, tool):
    p = tool(arm_2r, q_2r)
    corner, end = p + np.array([0.08, 0, 0]), p + np.array([0.08, -0.06, 0])
    waypoints = [
        Waypoint(position=corner, move=Move.LINE, blend=0.01),
        Waypoint(position=end, move=Move.LINE),
    ]
    made = plan(arm_2r, waypoints, q_2r)
    t = made.waypoint_times[0]
    assert np.abs(made.trajectory.at(t).qd).max() > 0.05
    assert 1e-4 < np.linalg.norm(tool(arm_2r, made.trajectory.at(t).q) - corner) < 0.01
    sharp = plan(arm_2r, [Waypoint(position=w.position, move=Move.LINE) for w in waypoints], q_2r)
    assert made.trajectory.duration < sharp.trajectory.duration


def test_blends_that_touch_are_rounded_one_after_the_other(arm_2r, worst_use, q_2r, tool, sampled):
    p = tool(arm_2r, q_2r)
    offsets = ([0.07, 0.01, 0], [0.05, -0.04, 0], [0.0, -0.04, 0.0])
    corners = [p, *(p + np.array(offset) for offset in offsets)]
    sides = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    half = 0.5 * sides[1]
    waypoints = [
        Waypoint(position=corner, move=Move.LINE, blend=blend)
        for corner, blend in zip(corners[1:], (half, half, 0.0), strict=True)
    ]
    made = plan(arm_2r, waypoints, q_2r)
    assert worst_use(made.trajectory, 10_001) <= 1.0 + 1e-9
    _, q, qd, _ = sampled(made)
    assert made.tool_path.distance(tool(arm_2r, q)).max() < TOLERANCE
    assert (np.abs(qd[10:-10]).max(axis=1) > 1e-3).all()


def test_points_in_one_line_are_passed_without_a_stop(arm_2r, q_2r, tool):
    p = tool(arm_2r, q_2r)
    waypoints = [
        Waypoint(position=p + np.array([x, -0.5 * x, 0]), move=Move.LINE) for x in (0.03, 0.05, 0.1)
    ]
    made = plan(arm_2r, waypoints, q_2r)
    alone = plan(arm_2r, waypoints[-1:], q_2r)
    assert made.trajectory.duration == pytest.approx(alone.trajectory.duration, rel=1e-3)


def test_joint_moves_are_straight_in_joint_space(arm_6, q_6, tool, sampled):
    goal = q_6 + np.array([0.3, 0.2, -0.1, 0.4, -0.2, 0.1])
    made = plan(arm_6, [Waypoint(q=goal, move=Move.JOINT)], q_6)
    _, q, _, _ = sampled(made, 101)
    share = (q - q_6) / (goal - q_6)
    assert np.allclose(share, share[:, :1], atol=1e-12)
    assert np.allclose(made.trajectory.q_goal, goal, atol=1e-15)
    same = plan_joint_move(arm_6.limits, q_6, goal)
    assert same.duration == pytest.approx(made.trajectory.duration, rel=1e-12)
    assert made.tool_path.distance(tool(arm_6, q)).max() < 1e-9


@pytest.mark.parametrize("kind", ["pose", "position"])
def test_joint_moves_reach_poses_and_positions(arm_6, q_6, kind):
    T = arm_6.fk(q_6 + np.array([0.3, 0.2, -0.1, 0.4, -0.2, 0.1]))
    place = {"pose": Pose.from_matrix(T)} if kind == "pose" else {"position": T[:3, 3]}
    made = plan(arm_6, [Waypoint(move=Move.JOINT, **place)], q_6)
    have = arm_6.fk(made.trajectory.q_goal)
    assert np.allclose(have[:3, 3], T[:3, 3], atol=1e-6)
    if kind == "pose":
        assert np.allclose(have, T, atol=1e-5)


def test_blended_joint_moves_pass_within_the_blend(arm_6, q_6, worst_use, tool):
    rng = np.random.default_rng(0)
    goals = q_6 + np.cumsum(rng.uniform(-0.3, 0.3, (4, 6)), axis=0)
    blends = [0.0, 0.03, 0.01, 0.0]
    waypoints = [
        Waypoint(q=q, move=Move.JOINT, blend=blend) for q, blend in zip(goals, blends, strict=True)
    ]
    made = plan(arm_6, waypoints, q_6)
    q, qd, _ = made.trajectory.sample(made.waypoint_times)
    for i, blend in enumerate(blends):
        away = np.linalg.norm(tool(arm_6, q[i]) - tool(arm_6, goals[i]))
        assert away <= blend + 1e-12
        assert (np.abs(qd[i]).max() > 1e-3) == (blend > 0.0)
    assert worst_use(made.trajectory, 10_001) <= 1.0 + 1e-9
    stopping = plan(arm_6, [Waypoint(q=q, move=Move.JOINT) for q in goals], q_6)
    assert made.trajectory.duration < stopping.trajectory.duration


def test_joint_moves_may_have_a_tool_speed(arm_6, q_6, tool_speed, sampled):
    waypoint = Waypoint(q=q_6 + 0.4, move=Move.JOINT, speed=0.05)
    made = plan(arm_6, [waypoint], q_6)
    _, q, qd, _ = sampled(made)
    assert 0.0499 < tool_speed(arm_6, q, qd).max() <= 0.05 * (1.0 + 1e-9)


def test_blends_that_cannot_be_are_refused(arm_2r, q_2r, tool):
    p = tool(arm_2r, q_2r)

    def lines(*blends, move=Move.LINE):
        offsets = ([0.05, 0, 0], [0.05, 0.02, 0], [0.0, 0.02, 0])
        return [
            Waypoint(position=p + offset, move=move, blend=blend)
            for offset, blend in zip(offsets, blends, strict=True)
        ]

    for move in (Move.LINE, Move.JOINT):
        with pytest.raises(CurveError, match=r"waypoint 1 and waypoint 2: .* overlap"):
            plan(arm_2r, lines(0.015, 0.015, 0.0, move=move), q_2r)
        with pytest.raises(
            CurveError, match="waypoint 3: a blend of 1 mm, but the arm rests there"
        ):
            plan(arm_2r, lines(0.0, 0.0, 0.001, move=move), q_2r)
