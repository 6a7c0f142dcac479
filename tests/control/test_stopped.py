"""What remains of a motion that was stopped."""

import numpy as np
import pytest

from splinearm.control.stopped import StoppedMotion
from splinearm.trajectories.plan import plan_joint_move
from splinearm.trajectories.trajectory import JointTrajectory

pytestmark = pytest.mark.kernel

START, MIDDLE, GOAL = np.array([0.0, 0.5]), np.array([0.7, -0.2]), np.array([1.2, -1.4])


def two_moves(limits):
    first = plan_joint_move(limits, START, MIDDLE)
    second = plan_joint_move(limits, MIDDLE, GOAL)
    return JointTrajectory((*first.sections, *second.sections), START, limits)


def beside(q, start, goal):
    """Distance of joint vectors from the segment."""
    along = goal - start
    share = np.clip((q - start) @ along / (along @ along), 0.0, 1.0)
    return np.linalg.norm(q - start - share[:, None] * along, axis=1)


def sampled(motion, count=2000):
    return motion.sample(np.linspace(0.0, motion.duration, count))


@pytest.mark.parametrize("jerk", [None, 0.1])
@pytest.mark.parametrize("share", [0.02, 0.2, 0.45, 0.6, 0.97])
def test_the_rest_begins_at_rest_where_it_stopped_and_keeps_path_and_limits(limits, jerk, share):
    limits = limits if jerk is None else limits.with_jerk_time(jerk)
    motion = two_moves(limits)
    t = share * motion.duration
    stop = motion.stop_from(t)
    stopped = StoppedMotion.of(motion, t, stop)
    np.testing.assert_allclose(stopped.q, stop.q_goal, atol=1e-8)
    rest = stopped.remaining()
    assert rest.starts_at_rest
    assert rest.ends_at_rest
    np.testing.assert_allclose(rest.q_start, stop.q_goal, atol=1e-8)
    np.testing.assert_allclose(rest.q_goal, GOAL, atol=1e-9)
    q, qd, qdd = sampled(rest)
    off = np.minimum(beside(q, START, MIDDLE), beside(q, MIDDLE, GOAL))
    assert off.max() <= 1e-9
    assert (np.abs(qd) <= limits.qd_max * (1.0 + 1e-6)).all()
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + 1e-6)).all()
    if jerk is not None:
        qddd = rest.jerk(np.linspace(0.0, rest.duration, 2000))
        assert (np.abs(qddd) <= limits.qddd_max * (1.0 + 1e-6)).all()
    assert rest.duration <= motion.duration - stopped.t + 0.5


def test_the_rest_is_as_fast_as_it_was_planned(limits):
    motion = plan_joint_move(limits, START, GOAL)
    stop = motion.stop_from(0.3 * motion.duration)
    rest = StoppedMotion.of(motion, 0.3 * motion.duration, stop).remaining()
    _, qd, _ = sampled(rest)
    _, planned, _ = sampled(motion)
    np.testing.assert_allclose(np.abs(qd).max(axis=0), np.abs(planned).max(axis=0), rtol=0.02)


def test_a_motion_can_be_stopped_again_and_again(limits):
    motion = two_moves(limits)
    rounds = 0
    while motion.duration > 0.35:
        t = 0.25
        motion = StoppedMotion.of(motion, t, motion.stop_from(t)).remaining()
        rounds += 1
        assert rounds < 40
    assert rounds > 2
    np.testing.assert_allclose(motion.q_goal, GOAL, atol=1e-8)


def test_of_a_motion_that_had_ended_nothing_remains(limits):
    motion = two_moves(limits)
    end = motion.duration
    rest = StoppedMotion.of(motion, end, motion.stop_from(end)).remaining()
    assert rest.duration == 0.0
    np.testing.assert_array_equal(rest.q_start, motion.q_goal)


def test_a_motion_that_had_not_begun_remains_whole(limits):
    motion = two_moves(limits)
    rest = StoppedMotion(motion, 0.0).remaining()
    np.testing.assert_allclose(rest.q_start, START)
    assert rest.duration == pytest.approx(motion.duration, rel=0.05)


def test_a_stop_in_a_rest_leaves_the_rest_of_the_rest(limits):
    from dataclasses import replace

    moves = two_moves(limits)
    first, second = moves.sections
    motion = JointTrajectory((replace(first, dwell=0.5), second), START, limits)
    t = first.duration + 0.2
    rest = StoppedMotion.of(motion, t, motion.stop_from(t)).remaining()
    assert rest.duration == pytest.approx(0.3 + second.duration, rel=1e-6)
    np.testing.assert_allclose(rest.q_start, MIDDLE, atol=1e-9)
