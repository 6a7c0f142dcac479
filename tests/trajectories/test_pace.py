"""Paused, resumed, slowed and hurried: on the path, within every limit, without a jump."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.interpolation import interpolate
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.pace import FASTEST, PacedMotion
from splinearm.trajectories.paced_law import PacedLaw
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_timing import quickest_smooth
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.trajectory import JointTrajectory

HOLDS = 1e-3
"""Between the places where timing looks, the motions themselves may be over a limit by this."""


@pytest.fixture(scope="module")
def smooth_motion(make_limits):
    """Gives motions within limits of jerk."""

    def motion(seed, n=3):
        rng = np.random.default_rng(seed)
        limits = make_limits(rng.uniform(0.5, 3.0, n), rng.uniform(2.0, 15.0, n))
        limits = replace(limits, qddd_max=10.0 * limits.qdd_max)
        path = JointPath(interpolate(rng.uniform(-1.5, 1.5, (5, n)), degree=5))
        law = quickest_smooth(path, limits)
        return JointTrajectory((Section(path, law),), path.at(path.domain[0])[0], limits)

    return motion


def run(paced, asks=(), steps=20_000):
    """Carry a motion out with paces asked for at steps; give its setpoints."""
    asks = dict(asks)
    found = [paced.setpoint()]
    for k in range(steps):
        if k in asks:
            paced.ask(asks[k])
        found.append(paced.step())
        if paced.finished:
            break
    return found


def distance_from_path(motion, q):
    near = motion.sample(np.linspace(0.0, motion.duration, 40_001))[0]
    return max(np.abs(near - here).max(axis=1).min() for here in q)


@pytest.mark.property
@settings(max_examples=4, deadline=None)
@given(
    seed=st.integers(0, 999),
    asks=st.lists(
        st.tuples(st.integers(1, 400), st.sampled_from([0.0, 0.2, 0.7, 1.0, 1.3, FASTEST])),
        max_size=5,
    ),
)
def test_whatever_is_asked_limits_path_and_smoothness_are_kept(seed, asks, smooth_motion):
    motion = smooth_motion(seed)
    period = 0.005
    # at the end of what was asked it goes on as planned, so that it comes to an end
    found = run(PacedMotion(motion, period), [*asks, (450, 1.0)])
    qd, qdd = (np.array([getattr(s, name) for s in found]) for name in ("qd", "qdd"))
    limits = motion.limits
    assert (np.abs(qd) <= limits.qd_max * (1.0 + HOLDS)).all()
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + HOLDS)).all()
    assert (np.abs(np.diff(qdd, axis=0)) / period <= limits.qddd_max * (1.0 + HOLDS)).all()
    # positions and velocities follow from what comes next in order
    q = np.array([s.q for s in found])
    assert np.abs(np.diff(q, axis=0) / period - 0.5 * (qd[1:] + qd[:-1])).max() <= 1e-2
    assert np.array_equal(found[-1].q, motion.q_goal)
    assert distance_from_path(motion, q[::25]) <= 1e-3


@pytest.mark.kernel
def test_as_planned_it_is_the_plan(smooth_motion):
    motion = smooth_motion(1)
    for setpoint in run(PacedMotion(motion, 0.01))[:-1]:
        planned = motion.at(setpoint.t)
        for name in ("q", "qd", "qdd"):
            assert np.allclose(getattr(setpoint, name), getattr(planned, name), atol=1e-9)


def test_a_pause_rests_on_the_path_until_it_is_resumed(smooth_motion):
    motion = smooth_motion(2)
    paced = PacedMotion(motion, 0.01)
    run(paced, steps=30)
    assert not paced.rests
    paced.pause()
    run(paced, steps=150)
    assert paced.rests
    assert not paced.finished
    where = paced.motion_t
    held = run(paced, steps=20)
    assert paced.motion_t == where
    assert not any(setpoint.qd.any() or setpoint.qdd.any() for setpoint in held)
    paced.resume()
    run(paced)
    assert paced.finished
    assert paced.rests
    assert not paced.setpoint().qd.any()


@pytest.mark.kernel
def test_half_the_pace_is_reached_and_held(smooth_motion):
    paced = PacedMotion(smooth_motion(3), 0.01)
    run(paced, [(0, 0.5)], steps=120)
    assert paced.pace == 0.5


def test_faster_than_planned_takes_less_time_where_there_is_room(smooth_motion):
    motion = smooth_motion(4).scaled(0.4)
    hurried = PacedMotion(motion, 0.01)
    run(hurried, [(0, FASTEST)])
    assert hurried.elapsed <= 0.75 * motion.duration
    with pytest.raises(ValueError, match=r"pace: want a share from 0 to 1\.5 of the plan, got 2"):
        PacedMotion(motion, 0.01).ask(2.0)


def test_limits_below_those_of_the_plan_are_those_that_hold(smooth_motion):
    motion = smooth_motion(5).scaled(0.5)
    own = motion.limits
    limits = replace(own, qdd_max=0.3 * own.qdd_max)
    found = run(PacedMotion(motion, 0.01, limits=limits), [(10, FASTEST)])
    qdd = np.array([s.qdd for s in found])
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + HOLDS)).all()


@pytest.mark.kernel
def test_without_a_limit_of_jerk_accelerations_are_kept_all_the_same(make_motion):
    motion = make_motion(7, n=2)
    found = run(PacedMotion(motion, 0.01), [(20, 0.0), (80, 1.0), (150, 0.3), (200, FASTEST)])
    qdd = np.array([s.qdd for s in found])
    assert (np.abs(qdd) <= motion.limits.qdd_max * (1.0 + HOLDS)).all()
    assert np.array_equal(found[-1].q, motion.q_goal)


@pytest.mark.property
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 999), share=st.floats(0.02, 0.98))
def test_a_stop_keeps_every_limit_and_begins_as_the_motion_is(seed, share, smooth_motion):
    motion = smooth_motion(seed)
    t = share * motion.duration
    stop, now, limits = motion.stop_from(t), motion.at(t), motion.limits
    assert stop.duration <= motion.duration - t + 1e-9
    ts = np.linspace(0.0, stop.duration * (1.0 - 1e-9), 3001)
    q, qd, qdd = stop.sample(ts)
    assert (np.abs(qd) <= limits.qd_max * (1.0 + HOLDS)).all()
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + HOLDS)).all()
    assert (np.abs(stop.jerk(ts)) <= limits.qddd_max * (1.0 + 2.0 * HOLDS)).all()
    for have, want in ((q, now.q), (qd, now.qd), (qdd, now.qdd)):
        assert np.allclose(have[0], want, atol=1e-9)
    assert stop.ends_at_rest
    assert np.abs(qdd[-1]).max() <= 1e-4
    assert distance_from_path(motion, q[::300]) <= 1e-3


def test_a_stop_is_much_shorter_than_going_on(smooth_motion):
    motion = smooth_motion(11)
    stops = [motion.stop_from(t).duration for t in np.linspace(0.3, motion.duration - 1.0, 12)]
    assert np.median(stops) <= 0.3 * motion.duration


@pytest.mark.kernel
def test_a_law_at_a_pace_is_a_law_like_others(smooth_motion):
    motion = smooth_motion(6)
    stop = motion.stop_from(0.4 * motion.duration)
    (section,) = stop.sections
    law = section.law
    assert isinstance(law, PacedLaw)
    ts = np.linspace(0.0, law.duration, 41)[1:-1]
    s, speed, acceleration = law.sample(ts)
    step = 1e-6
    before, behind = law.sample(ts - step), law.sample(ts + step)
    smooth = np.abs(ts[:, None] - law.t).min(axis=1) > 2 * step
    assert np.allclose((behind[0] - before[0]) / (2 * step), speed, atol=1e-6)
    assert np.allclose((behind[1] - before[1]) / (2 * step), acceleration, atol=1e-3)
    jerk = (behind[2] - before[2]) / (2 * step)
    assert np.allclose(jerk[smooth], law.jerk(ts)[smooth], rtol=1e-3, atol=1e-2)
    for t, place in zip(ts, s, strict=True):
        assert law.time_at(float(place)) == pytest.approx(t, abs=1e-8)
        assert law.at(float(t)) == pytest.approx(
            [v[np.searchsorted(ts, t)] for v in law.sample(ts)]
        )
    slow, back = law.slower(0.5), law.reversed()
    assert np.allclose(slow.sample(2.0 * ts)[1], 0.5 * speed, atol=1e-12)
    assert np.allclose(back.sample(law.duration - ts)[0], law.s[0] + law.s[-1] - s, atol=1e-9)
    assert np.allclose(back.sample(law.duration - ts)[1], speed, atol=1e-9)
    part = law.between(float(ts[5]), float(ts[-5]))
    assert np.allclose(part.sample(ts[5:-5] - ts[5])[0], s[5:-5], atol=1e-12)


def test_what_has_no_pace_is_refused(make_limits):
    limits = make_limits([1.0], [1.0])
    path = straight_path(np.zeros(1), np.ones(1))
    motion = JointTrajectory((Section(path, quickest(path, limits)),), np.zeros(1), limits)
    with pytest.raises(ValueError, match="period: want a time above 0, got 0"):
        PacedMotion(motion, 0.0)
    with pytest.raises(ValueError, match="takes no time"):
        PacedMotion(JointTrajectory((), np.zeros(1), limits), 0.01)
    times = [setpoint.t for setpoint in run(PacedMotion(motion, 0.25))]
    assert all(late - early == pytest.approx(0.25) for early, late in pairwise(times[:-1]))


@pytest.mark.property
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 999), pace=st.sampled_from([0.3, 1.0, 1.4]), steps=st.integers(1, 300))
def test_a_stop_at_any_pace_goes_on_from_there(seed, pace, steps, smooth_motion):
    motion = smooth_motion(seed)
    paced = PacedMotion(motion, 0.005)
    run(paced, [(0, pace)], steps=steps)
    now, stop, limits = paced.setpoint(), paced.stop(), motion.limits
    ts = np.linspace(0.0, stop.duration * (1.0 - 1e-9), 1001)
    q, qd, qdd = stop.sample(ts)
    for have, want in ((q, now.q), (qd, now.qd), (qdd, now.qdd)):
        assert np.allclose(have[0], want, atol=1e-6)
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + HOLDS)).all()
    assert (np.abs(stop.jerk(ts)) <= limits.qddd_max * (1.0 + 2.0 * HOLDS)).all()
    assert stop.ends_at_rest
