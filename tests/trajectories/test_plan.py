import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import CurveError, LimitError, UnreachableError
from splinearm.kinematics import quaternion
from splinearm.kinematics.pose import Pose
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.plan import plan, plan_joint_move
from splinearm.trajectories.waypoint import Move, Waypoint

PLAIN_MOVES = [Move.BSPLINE, Move.LINE, Move.JOINT]
TOLERANCE = 2e-5


@pytest.fixture(scope="module")
def figure_2r(arm_2r, heart, q_2r):
    q = plan(arm_2r, [Waypoint(position=heart[0])], q_2r).trajectory.q_goal
    return plan(arm_2r, [Waypoint(position=p, speed=0.2) for p in heart], q, closed=True)


@pytest.fixture(scope="module")
def poses_6(arm_6, q_6):
    T = arm_6.fk(q_6)
    a = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    p = T[:3, 3] + np.stack(
        (0.03 * np.sin(2 * a), 0.08 * (np.cos(a) - 1), 0.06 * np.sin(a)), axis=1
    )
    v = np.stack((0.3 * np.sin(a), 0.2 * np.sin(2 * a), 0.3 * (np.cos(a) - 1)), axis=1)
    quats = quaternion.multiply(quaternion.from_matrix(T[:3, :3]), quaternion.exp(v))
    return [Pose(p, quat) for p, quat in zip(p, quats, strict=True)]


@pytest.fixture(scope="module")
def figure_6(arm_6, q_6, poses_6):
    return plan(arm_6, [Waypoint(pose=pose) for pose in poses_6], q_6, closed=True)


@pytest.mark.parametrize("which", ["2r", "6"])
def test_a_closed_figure_keeps_limits_path_and_speed(
    which, request, worst_use, tool, tool_speed, sampled
):
    arm = request.getfixturevalue("arm_2r" if which == "2r" else "arm_6")
    made = request.getfixturevalue(f"figure_{which}")
    assert worst_use(made.trajectory, 20_001) <= 1.0 + 1e-9
    _, q, qd, _ = sampled(made)
    assert made.tool_path.distance(tool(arm, q)).max() < TOLERANCE
    assert np.allclose(q[0], q[-1], atol=1e-6)
    if which == "2r":
        assert tool_speed(arm, q, qd).max() <= 0.2 * (1.0 + 1e-9)


def test_a_closed_figure_passes_its_waypoints_in_order(figure_2r, arm_2r, heart, tool):
    times = figure_2r.waypoint_times
    assert times[0] == 0.0
    assert (np.diff(times) > 0.0).all()
    assert times[-1] < figure_2r.trajectory.duration
    q, qd, _ = figure_2r.trajectory.sample(times)
    assert np.linalg.norm(tool(arm_2r, q) - heart, axis=1).max() < TOLERANCE
    assert (np.abs(qd[1:]).max(axis=1) > 0.1).all(), "it does not stop at them"


def test_a_closed_figure_is_smooth_where_it_closes(figure_2r):
    (curve,) = figure_2r.tool_path.curves
    assert curve.position.is_closed(2, 1e-9)


def test_planning_is_quick(arm_2r, arm_6, heart, figure_2r, poses_6, q_6):
    begun = time.perf_counter()
    plan(arm_2r, [Waypoint(position=p) for p in heart], figure_2r.trajectory.q_start, closed=True)
    assert time.perf_counter() - begun < 3.0
    begun = time.perf_counter()
    plan(arm_6, [Waypoint(pose=pose) for pose in poses_6], q_6, closed=True)
    assert time.perf_counter() - begun < 6.0
    begun = time.perf_counter()
    for t in np.linspace(0.0, 2.0, 200):
        figure_2r.trajectory.at(t)
    assert (time.perf_counter() - begun) / 200 < 1e-3  # 30 us on an idle computer


def test_the_orientations_of_poses_are_passed(figure_6, arm_6, poses_6):
    q = figure_6.trajectory.sample(figure_6.waypoint_times)[0]
    have = quaternion.from_matrix(arm_6.fk(q)[:, :3, :3])
    want = np.array([pose.quat for pose in poses_6])
    assert quaternion.angle_between(have, want).max() < TOLERANCE / 0.1


def test_the_start_need_not_be_a_waypoint_of_a_closed_figure(arm_2r, heart, figure_2r, tool):
    made = plan(
        arm_2r, [Waypoint(position=p) for p in heart[1:]], figure_2r.trajectory.q_start, closed=True
    )
    assert made.waypoint_times[0] > 0.0
    assert np.allclose(tool(arm_2r, made.trajectory.q_goal), heart[0], atol=TOLERANCE)
    again = plan(
        arm_2r,
        [Waypoint(position=p) for p in [*heart[1:], heart[0]]],
        figure_2r.trajectory.q_start,
        closed=True,
    )
    assert again.waypoint_times[-1] == pytest.approx(again.trajectory.duration)
    assert again.trajectory.duration == pytest.approx(made.trajectory.duration, rel=1e-6)


def test_an_open_run_begins_where_the_tool_is(arm_2r, heart, q_2r, tool):
    made = plan(arm_2r, [Waypoint(position=p) for p in heart[1:4]], q_2r)
    assert np.allclose(made.tool_path.p_start, tool(arm_2r, q_2r))
    assert np.array_equal(made.trajectory.q_start, q_2r)
    assert np.allclose(tool(arm_2r, made.trajectory.q_goal), heart[3], atol=TOLERANCE)
    assert made.waypoint_times[-1] == made.trajectory.duration


def test_stops_and_dwells_are_kept(arm_2r, heart, figure_2r, tool, sampled):
    asks = {3: {"stop": True}, 6: {"dwell": 0.4}}
    waypoints = [Waypoint(position=p, **asks.get(i, {})) for i, p in enumerate(heart)]
    made = plan(arm_2r, waypoints, figure_2r.trajectory.q_start, closed=True)
    trajectory = made.trajectory
    for i in asks:
        assert np.abs(trajectory.at(made.waypoint_times[i]).qd).max() < 1e-9
    resting = trajectory.at(made.waypoint_times[6] + 0.39)
    assert not resting.qd.any()
    assert np.allclose(tool(arm_2r, resting.q), heart[6], atol=TOLERANCE)
    assert np.abs(trajectory.at(made.waypoint_times[6] + 0.41).qd).max() > 0.0
    # the stops do not bend the curve
    _, q, _, _ = sampled(made)
    assert figure_2r.tool_path.distance(tool(arm_2r, q)).max() < TOLERANCE


def test_each_way_has_its_own_speed(arm_2r, heart, figure_2r, tool_speed, sampled):
    speeds = [None, 0.05, None, 0.1, None]
    waypoints = [Waypoint(position=p, speed=v) for p, v in zip(heart[:5], speeds, strict=True)]
    made = plan(arm_2r, waypoints, figure_2r.trajectory.q_start)
    ts, q, qd, _ = sampled(made)
    speed = tool_speed(arm_2r, q, qd)
    for i, limit in ((1, 0.05), (3, 0.1)):
        on_the_way = (ts > made.waypoint_times[i - 1]) & (ts < made.waypoint_times[i])
        assert speed[on_the_way].max() <= limit * (1.0 + 1e-9)
        assert speed[on_the_way].max() > 0.99 * limit
    assert speed.max() > 0.15


def test_all_kinds_of_moves_go_together(arm_6, q_6, poses_6, worst_use, tool, sampled):
    waypoints = [
        Waypoint(pose=poses_6[1]),
        Waypoint(pose=poses_6[2]),
        Waypoint(pose=poses_6[3], move=Move.LINE, blend=0.005),
        Waypoint(pose=poses_6[4], move=Move.LINE, dwell=0.2),
        Waypoint(q=q_6 + 0.1, move=Move.JOINT),
        Waypoint(position=poses_6[6].p, move=Move.LINE),
        Waypoint(position=poses_6[7].p),
    ]
    made = plan(arm_6, waypoints, q_6, closed=True)
    assert worst_use(made.trajectory, 20_001) <= 1.0 + 1e-9
    _, q, _, _ = sampled(made)
    assert made.tool_path.distance(tool(arm_6, q)).max() < TOLERANCE
    assert np.allclose(tool(arm_6, made.trajectory.q_goal), tool(arm_6, q_6), atol=TOLERANCE)
    assert np.abs(np.diff(q, axis=0)).max() < 0.01, "no jump"
    assert (np.diff(made.waypoint_times) > 0.0).all()


@pytest.mark.parametrize("move", PLAIN_MOVES)
def test_to_be_there_already_takes_no_time(arm_2r, move, q_2r, tool):
    made = plan(arm_2r, [Waypoint(q=q_2r, move=move)] * 2, q_2r, closed=move is Move.LINE)
    assert made.trajectory.duration == 0.0
    assert made.waypoint_times.tolist() == [0.0, 0.0]
    assert np.array_equal(made.trajectory.at(0.0).q, q_2r)
    assert np.array_equal(made.trajectory.at(1.0).q, q_2r)
    assert np.allclose(made.tool_path.sample(3), tool(arm_2r, q_2r))
    assert made.tool_path.distance(tool(arm_2r, q_2r)[None]).tolist() == [0.0]
    assert made.tool_path.length == 0.0
    assert len(made.peaks()) == 6


def test_repeated_waypoints_are_one_and_their_dwells_add_up(arm_2r, heart, q_2r):
    waypoints = [
        Waypoint(q=q_2r, dwell=0.3),
        Waypoint(position=heart[1]),
        Waypoint(position=heart[1], dwell=0.2),
        Waypoint(position=heart[1], dwell=0.1),
        Waypoint(position=heart[2]),
    ]
    made = plan(arm_2r, waypoints, q_2r)
    t = made.waypoint_times
    assert t[0] == 0.0
    assert not made.trajectory.at(0.29).qd.any()
    assert t[1] == t[2] == t[3]
    assert not made.trajectory.at(t[1] + 0.29).qd.any()
    assert made.trajectory.at(t[1] + 0.31).qd.any()


def test_a_run_of_poses_and_positions_is_refused(arm_6, q_6, poses_6):
    waypoints = [Waypoint(pose=poses_6[1], name="a"), Waypoint(position=poses_6[2].p)]
    with pytest.raises(ValueError, match=r"waypoint 1 'a' gives a pose .* and waypoint 2 a pos"):
        plan(arm_6, waypoints, q_6)


def test_an_unreachable_waypoint_is_named(arm_2r, heart, q_2r):
    waypoints = [Waypoint(position=heart[1]), Waypoint(position=[0.7, 0, 0.06], name="far")]
    with pytest.raises(UnreachableError, match="waypoint 2 'far' is out of reach by 150 mm"):
        plan(arm_2r, waypoints, q_2r)
    with pytest.raises(UnreachableError, match=r"waypoint 1 is out of reach by"):
        plan(arm_2r, [Waypoint(position=[0.7, 0, 0.06], move=Move.JOINT)], q_2r)


def test_wrong_arguments_are_refused(arm_2r, arm_6, heart, q_2r):
    waypoint = Waypoint(position=heart[1])
    with pytest.raises(ValueError, match="waypoints: want at least one"):
        plan(arm_2r, [], q_2r)
    with pytest.raises(ValueError, match="q_start"):
        plan(arm_2r, [waypoint], np.zeros(3))
    with pytest.raises(ValueError, match="q_start"):
        plan(arm_2r, [waypoint], [0.0, float("nan")])
    with pytest.raises(LimitError, match="elbow"):
        plan(arm_2r, [waypoint], [0.0, 2.7])
    with pytest.raises(LimitError, match="shoulder"):
        plan(arm_2r, [Waypoint(q=[3.0, 0.0], move=Move.JOINT)], q_2r)
    with pytest.raises(ValueError, match=r"waypoint 1: want 2 joint positions, got 3"):
        plan(arm_2r, [Waypoint(q=np.zeros(3))], q_2r)
    with pytest.raises(ValueError, match="limits"):
        plan(arm_2r, [waypoint], q_2r, limits=arm_6.limits)
    for tolerance in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="position_tolerance"):
            plan(arm_2r, [waypoint], q_2r, position_tolerance=tolerance)


def test_a_limit_of_jerk_is_kept_by_every_move(arm_6, q_6, poses_6, worst_use):
    limits = arm_6.limits.with_jerk_time(0.1)
    waypoints = [
        Waypoint(pose=poses_6[1]),
        Waypoint(pose=poses_6[2], speed=0.1),
        Waypoint(pose=poses_6[3], move=Move.LINE, blend=0.005),
        Waypoint(pose=poses_6[4], move=Move.LINE, dwell=0.2),
        Waypoint(q=q_6 + 0.1, move=Move.JOINT),
    ]
    made = plan(arm_6, waypoints, q_6, limits=limits)
    assert worst_use(made.trajectory, 4000) <= 1.0 + 1e-6
    ts = np.linspace(0.0, made.trajectory.duration, 4000)
    assert np.abs(made.trajectory.jerk(ts) / limits.qddd_max).max() <= 1.0 + 1e-3
    # acceleration never jumps: between two moments it changes by no more than the jerk allows
    steps = np.abs(np.diff(made.trajectory.sample(ts)[2], axis=0)) / np.diff(ts)[:, None]
    assert (steps <= limits.qddd_max * (1.0 + 1e-3)).all()
    assert {peak.quantity for peak in made.peaks()} >= {"jerk"}
    plain = plan(arm_6, waypoints, q_6)
    assert plain.trajectory.duration < made.trajectory.duration < 3.0 * plain.trajectory.duration


def test_accelerations_of_the_tool_are_kept_if_asked_for(arm_6, q_6, poses_6, tool, tool_speed):
    limits = MotionLimits(joints=arm_6.limits, arm=arm_6, tool_acceleration=0.8, tool_speed=0.15)
    made = plan(arm_6, [Waypoint(pose=pose) for pose in poses_6[1:4]], q_6, limits=limits)
    ts = np.linspace(0.0, made.trajectory.duration, 20_001)
    p = arm_6.fk(made.trajectory.sample(ts)[0])[:, :3, 3]
    speed = np.diff(p, axis=0) / ts[1]
    acceleration = np.linalg.norm(np.diff(speed, axis=0), axis=1) / ts[1]
    assert np.linalg.norm(speed, axis=1).max() <= 0.15 * (1.0 + 1e-3)
    # differences blur the jumps of acceleration between two cells
    assert np.percentile(acceleration, 99.5) <= 0.8 * (1.0 + 2e-2)
    told = {binding.quantity for binding in made.bindings()}
    assert "tool speed" in told


def test_limits_of_a_plan_are_those_it_was_given(arm_2r, heart, q_2r):
    limits = arm_2r.limits.scaled(0.5)
    waypoints = [Waypoint(position=p) for p in heart[1:4]]
    slow, quick = plan(arm_2r, waypoints, q_2r, limits=limits), plan(arm_2r, waypoints, q_2r)
    assert slow.trajectory.duration == pytest.approx(2.0 * quick.trajectory.duration, rel=1e-6)
    assert slow.trajectory.limits is limits
    shares = [abs(p.value / p.limit) for p in slow.peaks() if p.quantity == "acceleration"]
    assert max(shares) == pytest.approx(1.0, abs=1e-3)


def test_a_joint_move_starts_and_ends_where_it_should(make_limits):
    limits = make_limits([1.0, 2.0], [3.0, 4.0], q_max=[2.0, 2.0])
    motion = plan_joint_move(limits, [0.0, 1.0], [1.5, -1.0])
    assert motion.at(0.0).q.tolist() == [0.0, 1.0]
    assert motion.at(motion.duration).q.tolist() == [1.5, -1.0]
    assert plan_joint_move(limits, [0.5, 0.5], [0.5, 0.5]).duration == 0.0
    for wrong in ([0.0, 2.5], [-2.5, 0.0]):
        with pytest.raises(LimitError):
            plan_joint_move(limits, [0.0, 1.0], wrong)
        with pytest.raises(LimitError):
            plan_joint_move(limits, wrong, [0.0, 1.0])
    with pytest.raises(ValueError, match="q_goal"):
        plan_joint_move(limits, [0.0, 1.0], [0.0])


def test_a_plan_stops_along_its_path(arm_6, figure_6, worst_use, tool):
    duration = figure_6.trajectory.duration
    for t in np.linspace(0.03, 0.97, 12) * duration:
        stop = figure_6.trajectory.stop_from(t)
        q, _, _ = stop.sample(np.linspace(0.0, stop.duration, 200))
        assert figure_6.tool_path.distance(tool(arm_6, q)).max() < TOLERANCE
        assert worst_use(stop, 2000) <= 1.0 + 1e-9


def test_a_tool_path_is_sampled_evenly(figure_2r, arm_2r):
    path = figure_2r.tool_path
    p = path.sample(200)
    assert p.shape == (200, 3)
    assert np.allclose(p[0], path.p_start)
    assert path.distance(p).max() < 1e-9
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
    assert steps.max() < 1.05 * np.median(steps)
    assert steps.sum() == pytest.approx(path.length, rel=2e-3)
    with pytest.raises(ValueError, match="m: want at least 2"):
        path.sample(1)
    with pytest.raises(ValueError, match="points"):
        path.distance([0.0, 0.0, 0.0])


@pytest.mark.property
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 99_999))
def test_any_plan_keeps_limits_path_and_waypoints_or_says_why_not(
    arm_2r, arm_6, seed, worst_use, tool, sampled
):
    rng = np.random.default_rng(seed)
    arm = arm_2r if rng.random() < 0.5 else arm_6
    limits = arm.limits
    q_start = q = 0.6 * rng.uniform(limits.q_min, limits.q_max)
    waypoints = []
    for _ in range(rng.integers(1, 6)):
        q = np.clip(q + 0.1 * rng.normal(size=arm.n), limits.q_min, limits.q_max)
        place = {"position": tool(arm, q)} if arm.n == 2 else {"q": q}
        waypoints.append(
            Waypoint(move=rng.choice(PLAIN_MOVES), speed=rng.choice([None, 0.1]), **place)
        )
    try:
        made = plan(arm, waypoints, q_start, closed=bool(rng.random() < 0.3))
    except (UnreachableError, CurveError):
        return
    assert worst_use(made.trajectory, 5001) <= 1.0 + 1e-9
    _, q, _, _ = sampled(made, 2001)
    assert made.tool_path.distance(tool(arm, q)).max() < TOLERANCE
    assert (q >= limits.q_min - 1e-8).all()
    assert (q <= limits.q_max + 1e-8).all()
    at = tool(arm, made.trajectory.sample(made.waypoint_times)[0])
    want = [w.position if w.q is None else tool(arm, w.q) for w in waypoints]
    assert np.linalg.norm(at - want, axis=1).max() < TOLERANCE
