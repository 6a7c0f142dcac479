import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from splinearm.curves.interpolation import interpolate
from splinearm.trajectories import timing
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
    fine = timing._solve(path, limits, np.linspace(*path.domain, 7 * 1500 + 1), None)
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
