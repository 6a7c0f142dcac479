"""Quickest motions from state to state: against an oracle, by their laws, at their edges."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import LimitError, TrajectoryError
from splinearm.joints import JointKind, JointLimits, JointSetpoint
from splinearm.trajectories.point_to_point import Synchronisation, point_to_point, retarget

INF = math.inf


def limits_of(qd_max, qdd_max, qddd_max, q_max=INF):
    n = len(qd_max)
    return JointLimits(
        names=tuple(f"joint{i}" for i in range(n)),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -q_max),
        q_max=np.full(n, q_max),
        qd_max=qd_max,
        qdd_max=qdd_max,
        qddd_max=qddd_max,
    )


def state(q, qd, qdd=None):
    return JointSetpoint(t=0.0, q=q, qd=qd, qdd=np.zeros(len(q)) if qdd is None else qdd)


def random_limits(rng, n):
    return limits_of(rng.uniform(0.5, 3, n), rng.uniform(0.5, 10, n), rng.uniform(1, 100, n))


def random_state(rng, limits, share=1.0):
    """A state from which the limits can be kept, or with a share above 1 perhaps not."""
    most = np.minimum(limits.qdd_max, 0.999 * np.sqrt(2.0 * limits.qd_max * limits.qddd_max))
    qdd = rng.uniform(-1, 1, limits.n) * most
    qd = rng.uniform(-1, 1, limits.n) * (limits.qd_max - 0.5 * qdd**2 / limits.qddd_max)
    return state(rng.normal(size=limits.n), share * qd, share * qdd)


def assert_within(profile, start, goal, limits, *, share=1.0):
    """The motion leads from start to goal, is C2, and within its limits everywhere."""
    t, q, qd, qdd, qddd = np.moveaxis(profile.phases, 2, 0)
    h = np.diff(t)
    q1 = q[:, :-1] + h * (qd[:, :-1] + h * (qdd[:, :-1] / 2 + h * qddd[:, :-1] / 6))
    qd1 = qd[:, :-1] + h * (qdd[:, :-1] + h * qddd[:, :-1] / 2)
    qdd1 = qdd[:, :-1] + h * qddd[:, :-1]
    size = max(1.0, np.abs(q).max())
    np.testing.assert_allclose(q1, q[:, 1:], atol=1e-11 * size)
    np.testing.assert_allclose(qd1, qd[:, 1:], atol=1e-11 * size)
    if limits.qddd_max is not None:
        np.testing.assert_allclose(qdd1, qdd[:, 1:], atol=1e-11 * size)
        assert (np.abs(qddd) <= limits.qddd_max[:, None] * (1 + 1e-9)).all()
    for row, want in ((q, "q"), (qd, "qd"), (qdd, "qdd")):
        if want == "qdd" and limits.qddd_max is None:
            continue
        np.testing.assert_allclose(row[:, 0], getattr(start, want), atol=1e-12)
        np.testing.assert_allclose(row[:, -1], getattr(goal, want), atol=1e-9 * size)
    # velocity is highest where a phase begins or where its acceleration is zero
    with np.errstate(all="ignore"):
        rest = np.where(qddd[:, :-1] != 0.0, -qdd[:, :-1] / qddd[:, :-1], -1.0)
    inside = (rest > 0.0) & (rest < h)
    extreme = qd[:, :-1] + np.where(inside, rest * qdd[:, :-1] / 2, 0.0)
    highest = share * limits.qd_max[:, None] * (1 + 1e-9)
    assert (np.abs(extreme) <= highest).all()
    assert (np.abs(qd) <= highest).all()
    assert (np.abs(qdd) <= share * limits.qdd_max[:, None] * (1 + 1e-9)).all()


def oracle_duration(ruckig, otg, start, goal, limits):
    task = ruckig.InputParameter(limits.n)
    for name, one in (("current", start), ("target", goal)):
        setattr(task, f"{name}_position", one.q.tolist())
        setattr(task, f"{name}_velocity", one.qd.tolist())
        setattr(task, f"{name}_acceleration", one.qdd.tolist())
    task.max_velocity = limits.qd_max.tolist()
    task.max_acceleration = limits.qdd_max.tolist()
    task.max_jerk = limits.qddd_max.tolist()
    motion = ruckig.Trajectory(limits.n)
    assert otg.calculate(task, motion) == ruckig.Result.Working
    return motion.duration


def compare_with_oracle(kind, count, seed):
    ruckig = pytest.importorskip("ruckig", reason="ruckig, the oracle of durations, is missing")
    rng = np.random.default_rng(seed)
    otg = ruckig.Ruckig(7)
    for _ in range(count):
        limits = random_limits(rng, 7)
        share = 1.5 if kind == "start beyond" else 1.0
        start, goal = random_state(rng, limits, share), random_state(rng, limits)
        if kind == "rest":
            start = state(start.q, np.zeros(7))
        if kind in ("rest", "moving start"):
            goal = state(goal.q, np.zeros(7))
        profile = point_to_point(limits, start, goal)
        wanted = oracle_duration(ruckig, otg, start, goal, limits)
        assert profile.duration == pytest.approx(wanted, abs=1e-9)
        # a start with too much acceleration may carry the velocity far beyond its limit
        assert_within(profile, start, goal, limits, share=1.0 if share == 1.0 else INF)


KINDS = ["rest", "moving start", "moving goal", "start beyond"]


@pytest.mark.parametrize("kind", KINDS)
def test_durations_are_those_of_the_oracle(kind):
    compare_with_oracle(kind, 500, KINDS.index(kind))


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("kind", KINDS)
def test_durations_are_those_of_the_oracle_in_a_hundred_thousand_motions(kind):
    compare_with_oracle(kind, 25_000, 100 + KINDS.index(kind))


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("way", "duration"),
    [
        (0.001, 4.0 * (0.001 / (2.0 * 8.0)) ** (1 / 3)),  # jerk alone
        (0.3, 0.25 + math.sqrt(0.25**2 + 4.0 * 0.3 / 2.0)),  # jerk and acceleration
        (2.0, 2.0 / 1.0 + 1.0 / 2.0 + 2.0 / 8.0),  # all three
    ],
)
def test_from_rest_to_rest_durations_are_those_of_the_textbooks(way, duration):
    # Biagiotti and Melchiorri 2008, section 3.4
    limits = limits_of([1.0], [2.0], [8.0])
    for goal in (way, -way):
        assert point_to_point(limits, [0.2], [0.2 + goal]).duration == pytest.approx(duration)


@pytest.mark.kernel
def test_the_shortest_is_found_where_every_limit_is_just_touched():
    # up, down twice as long, up: velocity and acceleration touch their limits for a moment;
    # ruckig 0.19.4 gives 6 s here
    limits = limits_of([1.0], [0.5], [0.5])
    start, goal = state([0.0], [0.5]), state([3.0], [0.5])
    profile = point_to_point(limits, start, goal)
    assert profile.duration == pytest.approx(4.0, abs=1e-12)
    assert_within(profile, start, goal, limits)


unit = st.floats(-1.0, 1.0, allow_subnormal=False)


@st.composite
def tasks(draw, *, goal_moves=True):
    """Limits and two states of two joints from which the limits can be kept, in any units."""

    def size(low, high):
        return draw(st.lists(st.floats(low, high), min_size=2, max_size=2))

    limits = limits_of(size(0.1, 10), size(0.1, 10), size(0.1, 100))

    def one(*, moves):
        share = np.array([[draw(unit) for _ in range(2)] for _ in range(3)])
        most = np.minimum(limits.qdd_max, 0.999 * np.sqrt(2.0 * limits.qd_max * limits.qddd_max))
        qdd = share[2] * most * moves
        qd = share[1] * (limits.qd_max - 0.5 * qdd**2 / limits.qddd_max) * moves
        return state(3.0 * share[0], qd, qdd)

    return limits, one(moves=True), one(moves=goal_moves)


@pytest.mark.kernel
@pytest.mark.property
@given(tasks())
@settings(max_examples=100, deadline=None)
def test_motions_keep_their_limits_and_reach_their_goals(task):
    limits, start, goal = task
    assert_within(point_to_point(limits, start, goal), start, goal, limits)


@pytest.mark.kernel
@pytest.mark.property
@given(tasks())
@settings(max_examples=60, deadline=None)
def test_backwards_in_time_and_mirrored_a_motion_takes_as_long(task):
    limits, start, goal = task
    duration = point_to_point(limits, start, goal).duration
    back = point_to_point(
        limits, state(goal.q, -goal.qd, goal.qdd), state(start.q, -start.qd, start.qdd)
    )
    mirror = point_to_point(
        limits, state(-start.q, -start.qd, -start.qdd), state(-goal.q, -goal.qd, -goal.qdd)
    )
    assert mirror.duration == pytest.approx(duration, rel=1e-9, abs=1e-9)
    assert back.duration == pytest.approx(duration, rel=1e-6, abs=1e-6)


@pytest.mark.kernel
@pytest.mark.parametrize("length", [1e-7, 1.0, 1e6])
@pytest.mark.parametrize("time", [1e-4, 1.0, 1e4])
def test_units_do_not_matter(length, time):
    rng = np.random.default_rng(4)
    for _ in range(5):
        limits = random_limits(rng, 2)
        start, goal = random_state(rng, limits), random_state(rng, limits)
        duration = point_to_point(limits, start, goal).duration
        scaled = limits_of(
            limits.qd_max * length / time,
            limits.qdd_max * length / time**2,
            limits.qddd_max * length / time**3,
        )
        ends = [
            state(one.q * length, one.qd * length / time, one.qdd * length / time**2)
            for one in (start, goal)
        ]
        assert point_to_point(scaled, *ends).duration == pytest.approx(duration * time, rel=1e-9)


@pytest.mark.kernel
def test_at_half_the_speed_a_motion_takes_twice_as_long():
    limits = limits_of([1.0, 2.0], [3.0, 4.0], [20.0, 50.0])
    whole = point_to_point(limits, [0.0, 1.0], [2.0, -1.0]).duration
    half = point_to_point(limits.scaled(0.5), [0.0, 1.0], [2.0, -1.0]).duration
    assert half == pytest.approx(2.0 * whole, rel=1e-12)


@pytest.mark.kernel
def test_a_given_duration_is_taken_by_every_joint():
    rng = np.random.default_rng(2)
    limits = random_limits(rng, 3)
    start, goal = random_state(rng, limits), random_state(rng, limits)
    shortest = point_to_point(limits, start, goal).duration
    for duration in (shortest + 20.0, 100.0):
        profile = point_to_point(limits, start, goal, duration=duration)
        assert profile.duration == pytest.approx(duration, rel=1e-12)
        assert_within(profile, start, goal, limits)


@pytest.mark.kernel
def test_a_duration_that_is_too_short_is_refused_with_the_shortest():
    limits = limits_of([1.0], [2.0], [8.0])
    with pytest.raises(TrajectoryError, match=r"1 s is too short: .* is 2\.75 s"):
        point_to_point(limits, [0.0], [2.0], duration=1.0)
    assert point_to_point(limits, [0.0], [2.0], duration=2.75).duration == pytest.approx(2.75)


@pytest.mark.kernel
def test_a_duration_that_a_moving_joint_must_step_over_is_refused_with_the_next():
    # at full speed over a short way and on at full speed: at once, or after turning back
    limits = limits_of([1.0], [2.0], [8.0])
    start, goal = state([0.0], [0.9]), state([0.3], [0.9])
    shortest = point_to_point(limits, start, goal).duration
    assert shortest == pytest.approx(0.32, abs=0.02)
    with pytest.raises(TrajectoryError, match="and then from") as refusal:
        point_to_point(limits, start, goal, duration=1.0)
    later = float(str(refusal.value).split("from ")[-1].split(" s")[0])
    profile = point_to_point(limits, start, goal, duration=later * (1.0 + 1e-8))
    assert_within(profile, start, goal, limits)
    # and a second joint that needs longer makes the first one turn back
    both = limits_of([1.0, 1.0], [2.0, 2.0], [8.0, 8.0])
    start, goal = state([0.0, 0.0], [0.9, 0.0]), state([0.3, 0.5], [0.9, 0.0])
    assert point_to_point(both, start, goal).duration == pytest.approx(later, rel=1e-8)


@pytest.mark.kernel
def test_straight_motions_stay_on_the_line_and_use_the_tightest_limits():
    rng = np.random.default_rng(5)
    for _ in range(5):
        limits = random_limits(rng, 4)
        q_start, way = rng.normal(size=(2, 4))
        start, goal = state(q_start, 0.1 * way, -0.2 * way), state(q_start + way, 0.05 * way)
        profile = point_to_point(limits, start, goal, synchronisation=Synchronisation.PHASE)
        assert_within(profile, start, goal, limits)
        q, qd, _ = profile.sample(np.linspace(0.0, profile.duration, 50))
        s = (q - q_start) @ way / (way @ way)
        np.testing.assert_allclose(q, q_start + np.outer(s, way), atol=1e-13)
        np.testing.assert_allclose(qd * way[0], np.outer(qd[:, 0], way), atol=1e-13)
        free = point_to_point(limits, start, goal)
        assert profile.duration >= free.duration * (1.0 - 1e-12)


@pytest.mark.kernel
def test_straight_motions_are_as_quick_as_free_ones_where_limits_are_in_proportion():
    way = np.array([1.0, -0.5, 0.0])
    share = np.array([1.0, 0.5, 0.3])
    limits = limits_of(share, 3.0 * share, 20.0 * share)
    free = point_to_point(limits, np.zeros(3), way)
    straight = point_to_point(limits, np.zeros(3), way, synchronisation=Synchronisation.PHASE)
    assert straight.duration == pytest.approx(free.duration, rel=1e-12)
    nowhere = point_to_point(limits, way, way, synchronisation=Synchronisation.PHASE)
    assert nowhere.duration == 0.0


@pytest.mark.kernel
def test_a_start_that_moves_beside_the_line_cannot_go_straight():
    limits = limits_of([1.0, 1.0], [2.0, 2.0], [9.0, 9.0])
    with pytest.raises(ValueError, match="start: it does not move along the line"):
        point_to_point(
            limits,
            state([0.0, 0.0], [0.1, 0.2]),
            [1.0, 1.0],
            synchronisation=Synchronisation.PHASE,
        )


@pytest.mark.kernel
def test_joints_on_their_own_each_take_their_shortest_and_rest():
    limits = limits_of([1.0, 1.0], [2.0, 2.0], [8.0, 8.0])
    profile = point_to_point(limits, [0.0, 0.0], [2.0, 0.001], synchronisation=Synchronisation.NONE)
    q, qd, _ = profile.sample([0.6, 2.75])
    assert profile.duration == pytest.approx(2.75)
    np.testing.assert_allclose(q[:, 1], 0.001)
    assert (qd[:, 1] == 0.0).all()
    with pytest.raises(ValueError, match="must end at rest"):
        point_to_point(
            limits, [0.0, 0.0], state([1.0, 1.0], [0.1, 0.0]), synchronisation=Synchronisation.NONE
        )
    with pytest.raises(ValueError, match="take their shortest"):
        point_to_point(
            limits, [0.0, 0.0], [1.0, 1.0], duration=9.0, synchronisation=Synchronisation.NONE
        )


@pytest.mark.kernel
def test_joints_on_their_own_never_wait_for_each_other():
    rng = np.random.default_rng(3)
    limits = random_limits(rng, 2)
    for _ in range(30):
        start = random_state(rng, limits)
        goal = start.q + rng.uniform(-0.3, 0.3, 2)
        profile = point_to_point(limits, start, goal, synchronisation=Synchronisation.NONE)
        alone = []
        for i in range(2):
            k = slice(i, i + 1)
            one = limits_of(limits.qd_max[k], limits.qdd_max[k], limits.qddd_max[k])
            here = state(start.q[k], start.qd[k], start.qdd[k])
            alone.append(point_to_point(one, here, goal[k]).duration)
        assert profile.duration == max(alone)


@pytest.mark.kernel
def test_without_a_limit_of_jerk_motions_are_trapezoids_and_the_limit_of_high_jerks():
    rng = np.random.default_rng(8)
    for _ in range(20):
        smooth = limits_of(rng.uniform(0.5, 2, 2), rng.uniform(1, 5, 2), np.full(2, 1e9))
        sharp = limits_of(smooth.qd_max, smooth.qdd_max, None)
        start, goal = (
            state(rng.normal(size=2), rng.uniform(-1, 1, 2) * smooth.qd_max) for _ in range(2)
        )
        profile = point_to_point(sharp, start, goal)
        assert_within(profile, start, goal, sharp)
        assert profile.duration == pytest.approx(
            point_to_point(smooth, start, goal).duration, abs=1e-6
        )
    for way, duration in ((0.1, 2.0 * math.sqrt(0.1 / 2.0)), (3.0, 3.0 + 0.5)):
        sharp = limits_of([1.0], [2.0], None)
        assert point_to_point(sharp, [0.0], [way]).duration == pytest.approx(duration)
    # too fast at the start: braked first
    fast = point_to_point(limits_of([1.0], [2.0], None), state([0.0], [3.0]), [2.0])
    # down to 1 m/s in 1 s and 2 m, down to rest in 0.5 s and 0.25 m, and 0.25 m back
    assert fast.duration == pytest.approx(1.5 + 2.0 * math.sqrt(0.25 / 2.0))
    assert fast.q_goal[0] == pytest.approx(2.0)


@pytest.mark.kernel
def test_a_way_that_swings_beyond_a_position_is_refused_with_joint_place_and_time():
    limits = limits_of([1.0, 1.0], [2.0, 2.0], [8.0, 8.0], q_max=1.0)
    start = state([0.0, 0.9], [0.0, 0.9])
    with pytest.raises(LimitError) as refusal:
        point_to_point(limits, start, [0.0, 0.5])
    free = point_to_point(limits_of([1.0, 1.0], [2.0, 2.0], [8.0, 8.0]), start, [0.0, 0.5])
    ts = np.linspace(0.0, free.duration, 20001)
    q = free.sample(ts)[0][:, 1]
    assert (refusal.value.joint, refusal.value.quantity) == ("joint1", "position")
    assert refusal.value.value == pytest.approx(q.max(), abs=1e-7)
    assert refusal.value.t == pytest.approx(ts[q.argmax()], abs=1e-3)


@pytest.mark.kernel
def test_joints_that_do_not_move_rest():
    limits = limits_of([1.0, 1.0], [2.0, 2.0], [8.0, 8.0])
    profile = point_to_point(limits, [0.3, 0.0], [0.3, 1.0])
    q, qd, qdd = profile.sample(np.linspace(0.0, profile.duration, 30))
    np.testing.assert_allclose(q[:, 0], 0.3, atol=1e-16)
    assert np.abs(qd[:, 0]).max() == 0.0
    assert np.abs(qdd[:, 0]).max() == 0.0


@pytest.mark.kernel
@pytest.mark.parametrize("jerk", [[8.0], None])
def test_from_a_state_to_itself_it_takes_no_time(jerk):
    limits = limits_of([1.0], [2.0], jerk)
    for qd, qdd in ((0.0, 0.0), (0.5, 0.0), (-1.0, 0.0), (0.5, 1.0), (-0.2, -0.7)):
        here = state([0.4], [qd], [0.0 if jerk is None else qdd])
        profile = point_to_point(limits, here, here)
        assert profile.duration == 0.0
        assert profile.at(0.0).qd[0] == qd


@pytest.mark.kernel
@pytest.mark.parametrize("tiny", [1e-300, 1e-150, 1e-61, 1e-20])
def test_next_to_nothing_is_no_trouble(tiny):
    limits = limits_of([1.0], [1.0], [1.0])
    for start in (state([0.0], [tiny]), state([0.0], [0.0], [-tiny]), state([-tiny], [0.0])):
        for goal in (state([0.0], [0.0], [tiny]), state([0.0], [-tiny])):
            # the cube root of what differs, at most
            assert point_to_point(limits, start, goal).duration < 1e-6


@pytest.mark.kernel
def test_a_moving_joint_comes_back_to_where_it_was():
    limits = limits_of([1.0], [2.0], [8.0])
    start, goal = state([0.4], [0.5]), state([0.4], [0.0])
    profile = point_to_point(limits, start, goal)
    assert profile.duration > 0.5
    assert_within(profile, start, goal, limits)


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("qd", "qdd"),
    [(1.5, 0.0), (-1.5, 0.0), (0.9, 2.0), (0.0, 3.0), (-1.5, 3.0), (1.5, -3.0), (-3.0, 2.5)],
)
def test_a_start_beyond_its_limits_is_brought_back_and_stays_within(qd, qdd):
    limits = limits_of([1.0], [2.0], [8.0])
    start = state([0.0], [qd], [qdd])
    profile = point_to_point(limits, start, [0.3])
    ts = np.linspace(0.0, profile.duration, 2001)
    _, qds, qdds = profile.sample(ts)
    assert profile.q_goal[0] == pytest.approx(0.3, abs=1e-12)
    for value, limit in ((qds, 1.0), (qdds, 2.0)):
        beyond = np.flatnonzero(np.abs(value[:, 0]) > limit * (1.0 + 1e-9))
        # once within, always within
        assert np.diff(beyond).max(initial=1) == 1
        assert beyond.size == 0 or beyond[-1] < 1500


@pytest.mark.kernel
def test_goals_that_cannot_be_reached_or_left_within_the_limits_are_refused():
    limits = limits_of([1.0], [2.0], [8.0], q_max=2.0)
    with pytest.raises(LimitError, match="velocity"):
        point_to_point(limits, [0.0], state([1.0], [1.2]))
    with pytest.raises(LimitError, match="acceleration"):
        point_to_point(limits, [0.0], state([1.0], [0.0], [-2.1]))
    with pytest.raises(LimitError, match=r"velocity 63\.59"):  # 0.95 + 1.6^2 / 16 rad/s
        point_to_point(limits, [0.0], state([1.0], [0.95], [1.6]))
    with pytest.raises(LimitError, match="position"):
        point_to_point(limits, [0.0], [2.1])


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (([np.nan], [1.0]), {}, "start: want finite"),
        (([0.0, 0.0], [1.0]), {}, r"start: want shape \(1\)"),
        (([0.0], state([1.0, 1.0], [0.0, 0.0])), {}, "goal: want 1 joints, got 2"),
        (([0.0], [1.0]), {"duration": -1.0}, "duration: want a time above 0 s"),
        (([0.0], [1.0]), {"duration": np.nan}, "duration: want a time above 0 s"),
    ],
)
def test_wrong_arguments_are_refused(arguments, options, message):
    with pytest.raises(ValueError, match=message):
        point_to_point(limits_of([1.0], [2.0], [8.0]), *arguments, **options)


def test_a_synchronisation_is_one_of_its_kind():
    with pytest.raises(TypeError, match=r"want one of Synchronisation\.TIME"):
        point_to_point(limits_of([1.0], [2.0], [8.0]), [0.0], [1.0], synchronisation="time")


@pytest.mark.kernel
def test_a_new_goal_is_taken_up_without_a_jump():
    rng = np.random.default_rng(6)
    limits = random_limits(rng, 3)
    profile = point_to_point(limits, rng.normal(size=3), rng.normal(size=3))
    for share in (0.1, 0.5, 0.9):
        now = profile.at(share * profile.duration)
        goal = state(rng.normal(size=3), np.zeros(3))
        on = retarget(profile, share * profile.duration, goal.q)
        assert_within(on, now, goal, limits)


@pytest.mark.kernel
def test_the_old_goal_taken_up_again_takes_what_was_left():
    rng = np.random.default_rng(7)
    for _ in range(4):
        limits = random_limits(rng, 3)
        start, goal = random_state(rng, limits), random_state(rng, limits)
        # one joint alone: the others may have used their time otherwise
        one = limits_of(limits.qd_max[:1], limits.qdd_max[:1], limits.qddd_max[:1])
        start, goal = (state(s.q[:1], s.qd[:1], s.qdd[:1]) for s in (start, goal))
        profile = point_to_point(one, start, goal)
        for share in (0.0, 0.2, 0.5, 0.8, 0.99, 1.0):
            t = share * profile.duration
            left = retarget(profile, t, goal).duration
            assert left == pytest.approx(profile.duration - t, abs=2e-7)


MOTIONS = """
import numpy as np
from splinearm.joints import JointKind, JointLimits, JointSetpoint
from splinearm.trajectories.point_to_point import point_to_point
from splinearm.trajectories.through import through

rng = np.random.default_rng(7)
found = []
for n, jerk in ((1, 30.0), (2, 4.0), (2, None)):
    limits = JointLimits(names=tuple("abc"[:n]), kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -np.inf), q_max=np.full(n, np.inf), qd_max=np.full(n, 1.5),
        qdd_max=np.full(n, 2.0), qddd_max=None if jerk is None else np.full(n, jerk))
    for _ in range(6):
        q, goal = rng.normal(size=(2, n))
        qd, qdd = rng.uniform(-3, 3, size=(2, n))
        start = JointSetpoint(t=0.0, q=q, qd=qd, qdd=qdd)
        profile = point_to_point(limits, start, goal)
        span = profile.position_range()
        found += [*profile.sample(np.linspace(0, profile.duration, 7)), span.q_low, span.t_high]
    found.append(through(limits, rng.normal(size=(4 - n, n)))[1])
"""


def test_kernels_give_the_same_motions_as_plain_python(compiled_as_plain):
    compiled_as_plain(MOTIONS, 93, rtol=1e-12)
