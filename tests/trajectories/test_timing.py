import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.errors import TrajectoryError
from splinearm.trajectories.constraint import SpeedCap
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.section import Section
from splinearm.trajectories.time_law import TimeLaw
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.trajectory import JointTrajectory


@st.composite
def paths_and_limits(draw, limits_of):
    """Smooth paths of 1 to 7 joints, some with joints that rest, turn back or repeat points."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, m = draw(st.integers(1, 7)), draw(st.integers(3, 10))
    points = rng.uniform(-2.0, 2.0, (m, n))
    kind = draw(st.sampled_from(["any", "resting", "repeated", "there and back", "one line"]))
    if kind == "resting":
        points[:, 0] = 0.5
    elif kind == "repeated":
        points = np.repeat(points, rng.integers(1, 3, m), axis=0)
    elif kind == "there and back":
        points = np.vstack((points, points[::-1]))
    elif kind == "one line":
        points = np.outer(rng.uniform(-1.0, 1.0, m), rng.uniform(-1.0, 1.0, n))
    assume(np.ptp(points, axis=0).max() > 1e-3)
    u = 10.0 ** draw(st.integers(-4, 4)) * np.cumsum(rng.uniform(0.3, 1.0, len(points)))
    path = JointPath(interpolate(points, degree=draw(st.sampled_from([3, 5])), parameters=u))
    return path, limits_of(10.0 ** rng.uniform(-2, 2, n), 10.0 ** rng.uniform(-2, 2, n))


def trajectory_of(path, law, limits):
    return JointTrajectory((Section(path, law),), path.at(path.domain[0])[0], limits)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_no_limit_is_broken_at_any_moment(data, make_limits, worst_use):
    path, limits = data.draw(paths_and_limits(make_limits))
    motion = trajectory_of(path, quickest(path, limits), limits)
    assert worst_use(motion, 10_001) <= 1.0 + 1e-9
    assert worst_use(motion, 10_001) > 0.9, "but nearly reached: else it is not the quickest"


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_the_path_is_kept_and_ends_at_rest(data, make_limits):
    path, limits = data.draw(paths_and_limits(make_limits))
    law = quickest(path, limits)
    motion = trajectory_of(path, law, limits)
    ts = np.linspace(0.0, motion.duration, 501)
    s, speed, _ = law.sample(ts)
    assert (np.diff(s) >= 0.0).all()
    scale = np.abs(path.curve.points).max()
    assert np.allclose(motion.sample(ts)[0], path.curve.at(s), atol=1e-12 * scale)
    for t in (0.0, motion.duration):
        assert not motion.at(t).qd.any()
    assert (speed[1:-1] > 0.0).all()


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(data=st.data(), share=st.floats(0.05, 1.0))
def test_limits_of_c_and_c_squared_take_one_cth_longer(data, share, make_limits):
    path, limits = data.draw(paths_and_limits(make_limits))
    whole, slow = quickest(path, limits), quickest(path, limits.scaled(share))
    assert slow.duration * share == pytest.approx(whole.duration, rel=1e-6)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(data=st.data(), factor=st.sampled_from([1e-6, 1e-3, 1e3, 1e6]))
def test_the_unit_of_the_parameter_does_not_matter(data, factor, make_limits):
    path, limits = data.draw(paths_and_limits(make_limits))
    curve = path.curve
    other = JointPath(type(curve)(curve.knots * factor, curve.points, curve.degree))
    want = quickest(path, limits).duration
    assert quickest(other, limits).duration == pytest.approx(want, rel=1e-7)


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_wider_limits_are_never_slower(data, make_limits):
    path, limits = data.draw(paths_and_limits(make_limits))
    narrow = quickest(path, limits).duration
    wider = make_limits(limits.qd_max * 1.5, limits.qdd_max * 1.3)
    assert quickest(path, wider).duration <= narrow * 1.001


def trapezoid_time(distance, speed, acceleration):
    if distance * acceleration < speed**2:
        return 2.0 * np.sqrt(distance / acceleration)
    return distance / speed + speed / acceleration


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(
    turns=st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=6),
    speed=st.floats(0.05, 5.0),
    acceleration=st.floats(0.05, 20.0),
)
def test_a_straight_move_takes_the_time_of_the_trapezoid(turns, speed, acceleration, make_limits):
    assume(max(map(abs, turns)) > 1e-6)
    limits = make_limits([speed] * len(turns), [acceleration] * len(turns))
    path = straight_path(np.zeros(len(turns)), np.array(turns))
    want = trapezoid_time(max(map(abs, turns)), speed, acceleration)
    assert quickest(path, limits).duration == pytest.approx(want, rel=1e-12)
    # a tool speed, even one that is never reached, takes it to the general solver
    cap = SpeedCap(edges=np.array([0.0, 1.0]), speeds=np.array([1e9]), rate=np.ones_like)
    general = quickest(path, limits, cap=cap)
    assert general.duration == pytest.approx(want, rel=1e-3)
    assert general.duration >= want * (1.0 - 1e-12)


def test_known_durations_are_met_within_a_part_in_a_thousand(make_limits):
    # joints in a circle, q = (cos s, sin s), with ample acceleration: one of them is always at its
    # full speed, max(|sin s|, |cos s|) ds/dt = 1, and once round takes 8 sin(pi / 4)
    a = np.linspace(0.0, 2.0 * np.pi, 81)
    circle = np.stack((np.cos(a), np.sin(a)), axis=1)
    path = JointPath(interpolate(circle[:-1], parameters=a, ends="closed"))
    law = quickest(path, make_limits([1.0, 1.0], [1e4, 1e4]))
    assert law.duration == pytest.approx(8.0 * np.sin(np.pi / 4.0), rel=1e-3)


def test_the_optimum_is_approached_from_above(make_limits):
    rng = np.random.default_rng(2)
    path = JointPath(interpolate(rng.uniform(-2, 2, (8, 7)), degree=5, parameters="uniform"))
    limits = make_limits([2.175] * 4 + [2.61] * 3, [15, 7.5, 10, 12.5, 15, 20, 20])
    law = quickest(path, limits)
    fine = quickest(path, limits, cells=7 * 1500)
    assert fine.duration <= law.duration <= 1.002 * fine.duration


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(
    data=st.data(),
    seed=st.integers(0, 999),
    waves=st.sampled_from([(20.0, 1e-7), (1000.0, 2e-3)]),
)
def test_the_tool_speed_is_kept_in_each_section(data, seed, waves, make_limits):
    # of a rate that swings within a cell it is kept where the cell is looked at
    path, limits = data.draw(paths_and_limits(make_limits))
    start, end = path.domain
    rng = np.random.default_rng(seed)
    edges = np.linspace(start, end, 4)
    typical = 1.0 / quickest(path, limits).duration * (end - start)
    speeds = typical * np.array([rng.uniform(0.1, 1.0), np.inf, rng.uniform(0.1, 1.0)])

    def rate(s):
        return 1.0 + 0.5 * np.sin(waves[0] * (s - start) / (end - start))

    cap = SpeedCap(edges=edges, speeds=speeds, rate=rate)
    law = quickest(path, limits, cap=cap)
    s, sd, _ = law.sample(np.linspace(0.0, law.duration, 5001))
    cell = np.clip(np.searchsorted(edges, s, side="right") - 1, 0, 2)
    inside = np.abs(s[:, None] - edges).min(axis=1) > 1e-12 * (end - start)
    assert (rate(s) * sd / speeds[cell])[inside].max() <= 1.0 + waves[1]
    assert law.duration >= quickest(path, limits).duration * (1.0 - 1e-3)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_a_part_of_a_path_can_be_timed(data, make_limits, worst_use):
    path, limits = data.draw(paths_and_limits(make_limits))
    start, end = path.domain
    span = (start + 0.21 * (end - start), start + 0.68 * (end - start))
    law = quickest(path, limits, span)
    assert (law.s[0], law.s[-1]) == span
    part = JointTrajectory((Section(path, law),), path.at(span[0])[0], limits)
    assert worst_use(part, 2001) <= 1.0 + 1e-9


def test_joints_that_stay_take_no_time(make_limits):
    for curve in (
        interpolate(np.full((4, 2), 0.7), parameters="uniform"),
        interpolate(np.zeros((2, 2)), degree=1, parameters="uniform"),
    ):
        assert quickest(JointPath(curve), make_limits([1.0, 1.0], [1.0, 1.0])).duration == 0.0


def test_a_time_law_is_its_own_derivatives_and_inverse():
    law = TimeLaw(np.array([0.0, 0.5, 2.0, 3.0]), np.array([0.0, 1.0, 4.0, 0.0]))
    assert law.duration == pytest.approx(1.0 + 1.0 + 1.0)
    ts = np.linspace(0.0, law.duration, 301)
    s, speed, acceleration = law.sample(ts)
    for t, *state in zip(ts, s, speed, acceleration, strict=True):
        assert np.allclose(law.at(t), state)
        assert law.time_at(state[0]) == pytest.approx(t, abs=1e-7)
    inner = ~np.isin(ts, law.t)
    step = 1e-7
    middle = inner & (ts > 0.01) & (ts < law.duration - 0.01)
    behind, before = law.sample(ts[middle] + step), law.sample(ts[middle] - step)
    assert np.allclose((behind[0] - before[0]) / (2 * step), speed[middle], atol=1e-6)
    near_node = np.abs(ts[middle][:, None] - law.t).min(axis=1) < 1e-5
    slope = (behind[1] - before[1]) / (2 * step)
    assert np.allclose(slope[~near_node], acceleration[middle][~near_node], atol=1e-5)
    assert law.slower(0.5).duration == pytest.approx(2.0 * law.duration)


def random_case(rng, make_limits, units=(1.0, 1.0)):
    """Give a path through random places and limits, in other units of length and of time."""
    length, time = units
    n, m = int(rng.integers(1, 8)), int(rng.integers(3, 10))
    points = rng.uniform(-2.0, 2.0, (m, n)) * length
    curve = interpolate(points, degree=int(rng.choice([3, 5])), parameters="uniform")
    qd_max, qdd_max = 10.0 ** rng.uniform(-1, 1, (2, n)) * length
    return JointPath(curve), make_limits(qd_max / time, qdd_max / time**2)


def check_random_paths(seeds, make_limits, worst_use):
    for seed in seeds:
        path, limits = random_case(np.random.default_rng(seed), make_limits)
        law = quickest(path, limits)
        assert worst_use(trajectory_of(path, law, limits), 10_001) <= 1.0 + 1e-9, seed


def test_a_hundred_random_paths_keep_their_limits(make_limits, worst_use):
    check_random_paths(range(100), make_limits, worst_use)


@pytest.mark.slow
def test_a_thousand_random_paths_keep_their_limits(make_limits, worst_use):
    check_random_paths(range(100, 1100), make_limits, worst_use)


@pytest.mark.parametrize("length", [1e-7, 1e-3, 1.0, 1e6])
@pytest.mark.parametrize("time", [1e-4, 1.0, 1e4])
def test_units_of_length_and_time_do_not_matter(length, time, make_limits):
    for seed in range(3):
        want = quickest(*random_case(np.random.default_rng(seed), make_limits))
        path, limits = random_case(np.random.default_rng(seed), make_limits, (length, time))
        law = quickest(path, limits)
        assert law.duration == pytest.approx(want.duration * time, rel=1e-9)
        assert np.allclose(law.t, want.t * time, rtol=1e-6)


def test_the_number_of_cells_is_about_the_wanted_one(make_limits):
    path, limits = random_case(np.random.default_rng(1), make_limits)
    for cells in (50, 300, 1000):
        assert 0.8 * cells <= len(quickest(path, limits, cells=cells).s) - 1 <= 1.3 * cells + 40


def test_accelerations_alone_scale_with_their_root(make_limits):
    path, _ = random_case(np.random.default_rng(4), make_limits)
    ones = np.ones(path.n)
    want = quickest(path, make_limits(1e6 * ones, ones)).duration
    for factor in (0.01, 9.0):
        law = quickest(path, make_limits(1e6 * ones, factor * ones))
        assert law.duration * np.sqrt(factor) == pytest.approx(want, rel=1e-9)


def parabola(width):
    """Give q = (s^2, s): the first joint turns back at s = 0, where it has no inertia to move."""
    w = width
    curve = BSpline(np.repeat([-w, w], 3), np.array([[w * w, -w], [-w * w, 0.0], [w * w, w]]), 2)
    return JointPath(curve)


def test_a_point_without_inertia_is_passed_at_the_speed_of_its_bend(make_limits, worst_use):
    # at s = 0 the first joint's acceleration is 2 x, whatever the push
    path, limits = parabola(2.0), make_limits([100.0, 100.0], [1.0, 50.0])
    law = quickest(path, limits, cells=2000)
    speed = np.interp(0.0, law.s, law.x)
    assert 0.49 < speed <= 0.5 * (1.0 + 1e-12)
    assert worst_use(trajectory_of(path, law, limits), 10_001) <= 1.0 + 1e-9


def test_a_path_that_turns_back_on_itself_is_passed(make_limits, worst_use):
    # all joints stop at s = 0 and go back the same way: q' vanishes there, q'' does not
    curve = BSpline(np.array([-1.0] * 3 + [1.0] * 3), np.array([[1.0, 2], [-1, -2], [1, 2]]), 2)
    path, limits = JointPath(curve), make_limits([1.0, 2.0], [3.0, 6.0])
    law = quickest(path, limits)
    assert worst_use(trajectory_of(path, law, limits), 10_001) <= 1.0 + 1e-9
    # there and back: two trapezoids that share the turn, which begins and ends at half speed
    assert law.duration == pytest.approx(1.0 / 1.0 * 2.0 + 1.0 / 3.0 * 2.0, rel=2e-3)


def test_pieces_in_which_nothing_moves_take_no_time(make_limits, worst_use):
    a = np.array([0, 0, 0, 0.5, 1, 1, 1, 1, 1.5, 2.0, 2.0, 2.0])[:, None]
    path = JointPath(BSpline(np.concatenate(([0] * 3, np.arange(10.0), [9] * 3)), a, 3))
    limits = make_limits([1.0], [10.0])
    law = quickest(path, limits)
    assert worst_use(trajectory_of(path, law, limits), 10_001) <= 1.0 + 1e-9
    assert (
        trapezoid_time(2.0, 1.0, 10.0) <= law.duration < 2.0 * trapezoid_time(1.0, 1.0, 10.0) + 0.2
    )


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(data=st.data(), shares=st.tuples(st.floats(0.0, 0.9), st.floats(0.0, 0.9)))
def test_a_law_begins_and_ends_at_given_speeds(data, shares, make_limits, worst_use):
    path, limits = data.draw(paths_and_limits(make_limits))
    whole = quickest(path, limits)
    i, j = len(whole.s) // 4, 3 * len(whole.s) // 4
    span = (float(whole.s[i]), float(whole.s[j]))
    ends = (shares[0] * float(whole.speed[i]), shares[1] * float(whole.speed[j]))
    law = quickest(path, limits, span, ends=ends)
    assert law.speed[[0, -1]] == pytest.approx(ends)
    part = JointTrajectory((Section(path, law),), path.at(span[0])[0], limits)
    assert worst_use(part, 5001) <= 1.0 + 1e-8
    assert law.duration >= (whole.t[j] - whole.t[i]) * (1.0 - 1e-2)


def test_a_part_of_the_quickest_law_is_the_quickest_between_its_speeds(make_limits):
    path, limits = random_case(np.random.default_rng(8), make_limits)
    whole = quickest(path, limits, cells=2000)
    i, j = 600, 1500
    ends = (float(whole.speed[i]) * 0.999, float(whole.speed[j]) * 0.999)
    law = quickest(path, limits, (float(whole.s[i]), float(whole.s[j])), ends=ends)
    assert law.duration == pytest.approx(whole.t[j] - whole.t[i], rel=5e-3)


def test_speeds_at_the_ends_that_cannot_be_are_refused_with_those_that_can(make_limits):
    path, limits = random_case(np.random.default_rng(3), make_limits)
    with pytest.raises(TrajectoryError, match=r"cannot begin at 1e\+06 /s: .* up to [\d.]+ /s"):
        quickest(path, limits, ends=(1e6, 0.0))
    with pytest.raises(TrajectoryError, match=r"cannot end at 1e\+06 /s: .* reaches [\d.]+ /s"):
        quickest(path, limits, ends=(0.0, 1e6))
    straight = straight_path(np.zeros(2), np.ones(2))
    slow = make_limits([10.0, 10.0], [1.0, 1.0])
    assert quickest(straight, slow, ends=(0.0, 1.4)).speed[-1] == 1.4
    with pytest.raises(TrajectoryError, match=r"cannot end at 1.5 /s: .* reaches 1.41421 /s"):
        quickest(straight, slow, ends=(0.0, 1.5))
    with pytest.raises(TrajectoryError, match=r"cannot begin at 1.5 /s: .* up to 1.41421 /s"):
        quickest(straight, slow, ends=(1.5, 0.0))
    # from 1.5 /s it cannot slow down to 0.1 /s either
    with pytest.raises(TrajectoryError, match=r"cannot begin at 1.5 /s: .* up to 1.41774 /s"):
        quickest(straight, slow, ends=(1.5, 0.1))


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"ends": (-1.0, 0.0)}, "ends"),
        ({"ends": (0.0, np.nan)}, "ends"),
        ({"cells": 0}, "cells"),
        ({"span": (0.7, 0.2)}, "span"),
        ({"span": (0.0, 99.0)}, "span"),
    ],
)
def test_what_is_no_span_no_speed_or_no_number_is_refused(arguments, named, make_limits):
    path, limits = random_case(np.random.default_rng(3), make_limits)
    with pytest.raises(ValueError, match=named):
        quickest(path, limits, **arguments)


def test_limits_of_another_arm_are_refused(make_limits):
    path, limits = random_case(np.random.default_rng(3), make_limits)
    others = make_limits(np.ones(limits.n + 1), np.ones(limits.n + 1))
    with pytest.raises(ValueError, match="limits: want those of"):
        quickest(path, others)


def test_a_span_of_no_length_takes_no_time(make_limits):
    path, limits = random_case(np.random.default_rng(3), make_limits)
    assert quickest(path, limits, (0.5, 0.5)).duration == 0.0


def test_toppra_finds_the_same_duration_on_a_fine_grid(make_limits):
    ta = pytest.importorskip("toppra", reason="a peer, development extra")
    from toppra import algorithm, constraint

    rng = np.random.default_rng(2)
    points = rng.uniform(-2.0, 2.0, (8, 7))
    path = JointPath(interpolate(points, degree=5, parameters="uniform"))
    limits = make_limits([2.175] * 4 + [2.61] * 3, [15, 7.5, 10, 12.5, 15, 20, 20])

    class Way(ta.interpolator.AbstractGeometricPath):
        dof, path_interval = 7, np.array(path.domain)

        def __call__(self, s, order=0):
            return path.at(s)[order] if np.ndim(s) == 0 else path.sample(np.asarray(s))[order]

    rows = [
        constraint.JointVelocityConstraint(np.stack((-limits.qd_max, limits.qd_max), axis=1)),
        constraint.JointAccelerationConstraint(
            np.stack((-limits.qdd_max, limits.qdd_max), axis=1),
            discretization_scheme=constraint.DiscretizationType.Interpolation,
        ),
    ]
    s = np.linspace(*path.domain, 7001)
    solver = algorithm.TOPPRA(rows, Way(), gridpoints=s, solver_wrapper="seidel")
    _, speed, _ = solver.compute_parameterization(0.0, 0.0)
    want = float(np.sum(2.0 * np.diff(s) / (speed[1:] + speed[:-1])))
    assert quickest(path, limits, cells=7000).duration == pytest.approx(want, rel=3e-4)
