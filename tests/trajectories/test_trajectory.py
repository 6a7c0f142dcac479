import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.peak import peaks
from splinearm.trajectories.section import Section
from splinearm.trajectories.time_law import TimeLaw
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.trajectory import JointTrajectory
from splinearm.trajectories.travel import tool_travel


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 9999), dwell=st.sampled_from([0.0, 0.4]))
def test_velocity_and_acceleration_are_those_of_differences(seed, dwell, make_motion):
    motion = make_motion(seed, dwell)
    nodes = np.concatenate(
        [start + part.law.t for start, part in zip(motion.starts, motion.sections, strict=True)]
    )
    step = 1e-6
    ts = np.linspace(0.0, motion.duration, 400)[1:-1]
    ts = ts[np.abs(ts[:, None] - nodes).min(axis=1) > 2 * step]
    before, here, behind = (motion.sample(ts + d) for d in (-step, 0.0, step))
    assert np.allclose((behind[0] - before[0]) / (2 * step), here[1], atol=1e-5)
    assert np.allclose((behind[1] - before[1]) / (2 * step), here[2], atol=1e-3)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 9999), dwell=st.sampled_from([0.0, 0.4]))
def test_one_moment_is_what_a_sample_gives(seed, dwell, make_motion):
    motion = make_motion(seed, dwell)
    ts = np.concatenate((np.linspace(-0.1, motion.duration + 0.1, 77), motion.starts))
    for t, *row in zip(ts, *motion.sample(ts), strict=True):
        setpoint = motion.at(float(t))
        assert setpoint.t == t
        for have, want in zip((setpoint.q, setpoint.qd, setpoint.qdd), row, strict=True):
            assert np.allclose(have, want, atol=1e-9)


def test_the_ends_are_held_outside_the_motion(make_motion):
    motion = make_motion(1)
    for t, q in ((-1.0, motion.q_start), (motion.duration, motion.q_goal), (1e6, motion.q_goal)):
        setpoint = motion.at(t)
        assert np.array_equal(setpoint.q, q)
        assert not setpoint.qd.any()
        assert not setpoint.qdd.any()
    assert motion.n == 4


def test_the_arm_rests_during_a_dwell(make_motion):
    motion = make_motion(2, dwell=0.5)
    end = motion.sections[0].law.duration
    assert motion.starts[1] == pytest.approx(end + 0.5)
    for t in end + np.array([0.0, 0.1, 0.499]):
        setpoint = motion.at(float(t))
        assert np.array_equal(setpoint.q, motion.sections[0].q_end)
        assert not setpoint.qd.any()
        assert not setpoint.qdd.any()
        assert motion.stop_from(float(t)).duration == 0.0


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 9999), share=st.floats(0.0, 1.0), dwell=st.sampled_from([0.0, 0.3]))
def test_a_stop_keeps_limits_and_path_and_ends_at_rest(seed, share, dwell, make_motion, worst_use):
    motion = make_motion(seed, dwell)
    t = share * motion.duration
    stop = motion.stop_from(t)
    now, first = motion.at(t), stop.at(0.0)
    assert np.allclose(first.q, now.q, atol=1e-12)
    if stop.duration == 0.0:
        assert np.abs(now.qd).max() < 1e-6
        return
    assert np.allclose(first.qd, now.qd, atol=1e-9)
    assert worst_use(stop, 3001) <= 1.0 + 1e-9
    last = stop.at(stop.duration)
    assert not last.qd.any()
    # along the same path, never beyond the next planned rest, and never later than planned
    (section,) = stop.sections
    planned = next(part for part in motion.sections if part.path is section.path)
    assert section.law.s[-1] <= planned.law.s[-1]
    assert (np.diff(section.law.s) > 0.0).all()
    begun = motion.starts[motion.sections.index(planned)]
    assert stop.duration <= begun + planned.law.duration - t + 1e-9


@pytest.mark.property
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 9999), share=st.floats(0.05, 0.95))
def test_a_stop_brakes_as_hard_as_the_limits_allow(seed, share, make_motion):
    motion = make_motion(seed)
    stop = motion.stop_from(share * motion.duration)
    if stop.duration < 1e-3:
        return
    _, _, qdd = stop.sample(np.linspace(0.0, stop.duration, 400)[:-1])
    use = (np.abs(qdd) / stop.limits.qdd_max).max(axis=1)
    assert np.median(use) > 0.95


def test_a_straight_stop_takes_speed_over_acceleration(make_limits):
    limits = make_limits([1.0, 5.0], [2.0, 50.0])
    path = straight_path(np.zeros(2), np.array([3.0, -1.0]))
    motion = JointTrajectory((Section(path, quickest(path, limits)),), np.zeros(2), limits)
    stop = motion.stop_from(1.2)
    assert stop.duration == pytest.approx(0.5, rel=0.05)
    assert stop.duration >= 0.5
    way = stop.q_goal - motion.at(1.2).q
    assert way[0] == pytest.approx(0.25, rel=0.05)
    assert way[1] == pytest.approx(-way[0] / 3.0)


def test_a_stop_just_after_the_start_is_short(make_motion):
    motion = make_motion(3)
    for t in (1e-4, 1e-3, 1e-2):
        assert motion.stop_from(t).duration <= 2.0 * t


def test_a_stop_can_be_stopped_again(make_motion, worst_use):
    motion = make_motion(4)
    stop = motion.stop_from(0.4 * motion.duration)
    again = stop.stop_from(0.3 * stop.duration)
    assert again.duration == pytest.approx(0.7 * stop.duration, rel=0.05)
    assert worst_use(again, 500) <= 1.0 + 1e-9


def test_before_the_start_and_after_the_end_a_stop_takes_no_time(make_motion):
    motion = make_motion(5)
    for t in (-1.0, 0.0, motion.duration, motion.duration + 5.0):
        stop = motion.stop_from(t)
        assert stop.duration == 0.0
        assert np.array_equal(stop.q_goal, motion.at(t).q)


def test_a_motion_without_sections_stays(make_limits):
    limits = make_limits([1.0], [1.0])
    motion = JointTrajectory((), np.array([0.3]), limits)
    assert motion.duration == 0.0
    for t in (-1.0, 0.0, 1.0):
        assert motion.at(t).q == [0.3]
        assert not motion.at(t).qd.any()
    assert motion.sample([0.0, 1.0])[0].tolist() == [[0.3], [0.3]]
    assert motion.stop_from(0.0).duration == 0.0
    assert motion.scaled(0.5).duration == 0.0
    assert [peak.value for peak in peaks(motion)] == [0.3, 0.0, 0.0]


def test_a_scaled_motion_is_the_same_but_slower(make_motion):
    motion = make_motion(6, dwell=0.5)
    slow = motion.scaled(0.25)
    moving = motion.duration - 0.5
    assert slow.duration == pytest.approx(4.0 * moving + 0.5)
    t = 0.3 * motion.sections[0].law.duration
    assert np.allclose(slow.at(4.0 * t).q, motion.at(t).q, atol=1e-12)
    assert np.allclose(slow.at(4.0 * t).qd, 0.25 * motion.at(t).qd)
    assert np.allclose(slow.at(4.0 * t).qdd, 0.0625 * motion.at(t).qdd)
    for share in (0.0, -1.0, 1.1, float("nan")):
        with pytest.raises(ValueError, match="share"):
            motion.scaled(share)


@pytest.mark.parametrize("t", [float("nan"), float("inf"), -float("inf")])
def test_a_time_must_be_a_finite_number(t, make_motion):
    motion = make_motion(7)
    for ask in (motion.at, motion.stop_from, lambda t: motion.sample([t])):
        with pytest.raises(ValueError, match="finite"):
            ask(t)


@pytest.mark.property
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 9999))
def test_peaks_are_the_largest_values_of_a_dense_sample(seed, make_limits, make_motion):
    motion = make_motion(seed)
    limits = make_limits(motion.limits.qd_max, motion.limits.qdd_max, q_max=[4.0] * 4)
    motion = JointTrajectory(motion.sections, motion.q_start, limits)
    found = peaks(motion)
    assert [peak.joint for peak in found] == [name for name in limits.names for _ in range(3)]
    q, qd, qdd = motion.sample(np.linspace(0.0, motion.duration, 20_001))
    margin = np.minimum(q - limits.q_min, limits.q_max - q).min(axis=0)
    for i in range(4):
        position, velocity, acceleration = found[3 * i : 3 * i + 3]
        assert abs(position.limit - position.value) == pytest.approx(margin[i], abs=1e-4)
        assert abs(velocity.value) >= np.abs(qd[:, i]).max() * (1.0 - 1e-4)
        assert abs(acceleration.value) >= np.abs(qdd[:, i]).max() * (1.0 - 1e-4)
        assert velocity.limit == limits.qd_max[i]
        assert acceleration.limit == limits.qdd_max[i]
        for peak in (position, velocity, acceleration):
            assert 0.0 <= peak.t <= motion.duration
        assert motion.at(velocity.t).qd[i] == pytest.approx(velocity.value, abs=1e-6)
        assert motion.at(position.t).q[i] == pytest.approx(position.value, abs=1e-6)


def test_the_travel_of_the_tool_is_its_way(arm_2r):
    # the elbow alone turns: the tool is on a circle of 0.25 m
    path = straight_path(np.zeros(2), np.array([0.0, 1.2]))
    motion = JointTrajectory(
        (Section(path, quickest(path, arm_2r.limits)),), np.zeros(2), arm_2r.limits
    )
    assert tool_travel(arm_2r, motion) == pytest.approx(0.3, rel=1e-12)
    parts = [tool_travel(arm_2r, motion, 0.0, 0.2), tool_travel(arm_2r, motion, 0.2)]
    assert sum(parts) == pytest.approx(0.3, rel=1e-12)
    assert tool_travel(arm_2r, motion, 0.3, 0.3) == 0.0
    with pytest.raises(ValueError, match="do not fall"):
        tool_travel(arm_2r, motion, 0.3, 0.2)


def test_sections_of_other_joints_are_refused(make_limits, make_motion):
    motion = make_motion(8, n=4)
    with pytest.raises(ValueError, match="sections: want ways of 3 joints, got one of 4"):
        JointTrajectory(motion.sections, np.zeros(3), make_limits([1.0] * 3, [1.0] * 3))


def test_a_rest_alone_is_a_motion(make_limits):
    still = JointPath(BSpline([0.0, 1.0], [[0.1, 0.2]], 0))
    rest = Section(still, TimeLaw(np.zeros(1), np.zeros(1)), 2.0)
    motion = JointTrajectory((rest,), np.array([0.1, 0.2]), make_limits([1.0, 1.0], [1.0, 1.0]))
    assert motion.duration == 2.0
    assert motion.at(1.0).q.tolist() == [0.1, 0.2]
    assert not motion.sample([0.5, 1.5])[1].any()
    assert motion.stop_from(1.0).duration == 0.0


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 9999), dwell=st.sampled_from([0.0, 0.4]))
def test_backwards_the_joints_are_where_they_were(seed, dwell, make_motion):
    motion = make_motion(seed, dwell)
    back = motion.reversed()
    assert back.duration == pytest.approx(motion.duration)
    ts = np.linspace(0.0, motion.duration, 200)[1:-1]
    # accelerations jump at nodes, and rounding decides on which side of one a moment lies
    near = np.abs(ts[:, None] - motion.nodes()).min(axis=1) < 1e-9
    for have, want, sign in zip(
        back.sample(motion.duration - ts), motion.sample(ts), (1, -1, 1), strict=True
    ):
        assert np.allclose(have[~near], sign * want[~near], atol=1e-9)
    again = back.reversed()
    for have, want in zip(again.sample(ts[~near]), motion.sample(ts[~near]), strict=True):
        assert np.allclose(have, want, atol=1e-9)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 9999),
    dwell=st.sampled_from([0.0, 0.4]),
    share=st.floats(0.001, 0.999),
)
def test_two_parts_make_the_whole(seed, dwell, share, make_motion):
    motion = make_motion(seed, dwell)
    cut = share * motion.duration
    first, second = motion.split(cut)
    assert first.duration + second.duration == pytest.approx(motion.duration)
    assert np.allclose(first.q_goal, second.q_start, atol=1e-12)
    ts = np.linspace(0.0, motion.duration, 200)[1:-1]
    ts = ts[np.abs(ts[:, None] - np.append(motion.nodes(), cut)).min(axis=1) > 1e-9]
    before = ts < cut
    for have, tail, want in zip(
        first.sample(ts[before]), second.sample(ts[~before] - cut), motion.sample(ts), strict=True
    ):
        assert np.allclose(np.vstack((have, tail)), want, atol=1e-9)
    moves = np.abs(motion.at(cut).qd).max() > 1e-6
    assert first.ends_at_rest == (not moves)
    assert second.starts_at_rest == (not moves)
    assert first.starts_at_rest
    assert second.ends_at_rest


def test_a_motion_is_split_within_it_only(make_motion):
    motion = make_motion(5)
    for t in (0.0, -1.0, motion.duration, np.nan):
        with pytest.raises(ValueError, match="want a time between 0 and"):
            motion.split(t)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 9999))
def test_jerk_is_that_of_differences(seed, make_motion):
    motion = make_motion(seed, 0.3)
    step = 1e-5
    ts = np.linspace(0.0, motion.duration, 300)[1:-1]
    ts = ts[np.abs(ts[:, None] - motion.nodes()).min(axis=1) > 2 * step]
    difference = (motion.sample(ts + step)[2] - motion.sample(ts - step)[2]) / (2 * step)
    jerk = motion.jerk(ts)
    assert np.allclose(jerk, difference, rtol=1e-4, atol=1e-3)
