import os
import signal
from dataclasses import replace

import numpy as np
import pytest

from splinearm.control.clock import StepClock
from splinearm.control.follow import Loop, Outcome
from splinearm.control.override import PaceRequest
from splinearm.control.record import Cycle
from splinearm.control.stop import StopRequest
from splinearm.errors import (
    FollowingError,
    LimitError,
    MotionError,
    StaleFeedbackError,
    StartError,
)
from splinearm.trajectories.plan import plan_joint_move

Q_GOAL = np.array([1.2, -1.4])


@pytest.fixture
def motion(arm, limits):
    return plan_joint_move(limits, arm.q, Q_GOAL)


class Loops:
    """A loop, what it observed and what it said."""

    def __init__(self, arm, clock, guard, **more):
        self.cycles: list[Cycle] = []
        self.said: list[str] = []
        self.loop = Loop(
            driver=arm,
            clock=clock,
            guard=guard,
            observe=self.cycles.append,
            announce=self.said.append,
            **more,
        )


@pytest.fixture
def loops(arm, clock, guard):
    return Loops(arm, clock, guard)


def on_the_segment(q, start, goal):
    """Distance of joint vectors from the straight joint move."""
    along = goal - start
    share = (q - start) @ along / (along @ along)
    return np.linalg.norm(q - start - share[:, None] * along, axis=1)


def assert_within(setpoints, limits):
    for setpoint in setpoints:
        limits.check(setpoint.q, setpoint.qd, setpoint.qdd, tolerance=1e-6)


def test_a_motion_ends_at_its_goal_and_holds(arm, loops, motion):
    assert loops.loop.follow(motion) is Outcome.FINISHED
    np.testing.assert_allclose(arm.q, Q_GOAL, atol=1e-12)
    assert arm.holding
    assert arm.torque


def test_a_motion_takes_as_many_cycles_as_it_lasts(loops, motion):
    loops.loop.follow(motion)
    assert len(loops.cycles) == int(np.ceil(motion.duration / 0.01 - 1e-9)) + 1
    assert [cycle.index for cycle in loops.cycles] == list(range(len(loops.cycles)))


def test_no_garbage_is_collected_while_the_arm_moves(arm, clock, guard, motion):
    import gc

    seen = []
    loop = Loop(driver=arm, clock=clock, guard=guard, observe=lambda _: seen.append(gc.isenabled()))
    loop.follow(motion)
    assert seen
    assert not any(seen)
    assert gc.isenabled()


def test_each_cycle_reads_before_it_writes(arm, loops, motion):
    loops.loop.follow(motion)
    assert arm.reads == len(arm.written) + 1
    wanted = np.array([cycle.setpoint.q for cycle in loops.cycles])
    measured = np.array([cycle.state.q for cycle in loops.cycles])
    np.testing.assert_allclose(measured[1:], wanted[:-1], atol=1e-12)


def test_nothing_is_written_when_the_motion_breaks_a_limit(arm, loops, guard, limits):
    far = plan_joint_move(limits, arm.q, Q_GOAL)
    guard.limits = limits.scaled(0.5)
    with pytest.raises(LimitError):
        loops.loop.follow(far)
    assert arm.written == []


def test_nothing_is_written_when_the_arm_is_elsewhere(arm, loops, motion):
    arm.q = np.array([0.3, 0.5])
    with pytest.raises(StartError, match="shoulder"):
        loops.loop.follow(motion)
    assert arm.written == []


def stop_after(count):
    """Ask for a stop in the given cycle."""
    stop = StopRequest()

    def observe(cycle):
        if cycle.index == count:
            stop.request()

    return stop, observe


@pytest.mark.parametrize("count", [0, 3, 20, 45, 70])
def test_a_stop_leaves_the_arm_at_rest_on_its_path(arm, clock, guard, limits, motion, count):
    stop, observe = stop_after(count)
    start = arm.q.copy()
    loop = Loop(driver=arm, clock=clock, guard=guard, observe=observe)
    assert loop.follow(motion, stop) is Outcome.STOPPED
    q = np.array([setpoint.q for setpoint in arm.written])
    assert on_the_segment(q, start, Q_GOAL).max() < 1e-9
    np.testing.assert_allclose(arm.written[-1].qd, 0.0, atol=1e-9)
    assert_within(arm.written, limits)
    assert arm.holding
    assert arm.torque


def test_a_stop_announces_how_long_it_takes(arm, clock, guard, motion):
    stop, observe = stop_after(30)
    said: list[str] = []
    loop = Loop(driver=arm, clock=clock, guard=guard, observe=observe, announce=said.append)
    loop.follow(motion, stop)
    assert any(line.startswith("stop asked for: stopping along the path in") for line in said)


def test_ctrl_c_stops_along_the_path_and_the_handler_is_put_back(arm, clock, guard, motion):
    before = signal.getsignal(signal.SIGINT)

    def observe(cycle):
        if cycle.index == 20:
            os.kill(os.getpid(), signal.SIGINT)

    loop = Loop(driver=arm, clock=clock, guard=guard, observe=observe)
    assert loop.follow(motion) is Outcome.STOPPED
    np.testing.assert_allclose(arm.written[-1].qd, 0.0, atol=1e-9)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_few_lost_answers_are_bridged_by_the_plan(arm, loops, motion):
    arm.lose_reads_from, arm.lose_reads = 20, 3
    assert loops.loop.follow(motion) is Outcome.FINISHED
    assert sum(cycle.state is None for cycle in loops.cycles) == 3
    np.testing.assert_allclose(arm.q, Q_GOAL, atol=1e-12)


def test_an_arm_that_answers_no_more_is_stopped_along_its_path(arm, loops, limits, motion):
    start = arm.q.copy()
    arm.lose_reads_from, arm.lose_reads = 20, 1000
    with pytest.raises(StaleFeedbackError, match=r"servo 2 \(elbow\) does not answer"):
        loops.loop.follow(motion)
    q = np.array([setpoint.q for setpoint in arm.written])
    assert on_the_segment(q, start, Q_GOAL).max() < 1e-9
    np.testing.assert_allclose(arm.written[-1].qd, 0.0, atol=1e-9)
    assert_within(arm.written, limits)
    assert arm.holding


def test_a_cable_that_is_pulled_is_a_fault_of_the_motion_and_named(arm, loops, motion):
    arm.cut_off_from = 20
    with pytest.raises(MotionError, match="told where to go: port nowhere: the connection is lost"):
        loops.loop.follow(motion)
    assert len(arm.written) == 20


def test_a_cable_that_is_pulled_at_the_end_is_not_taken_for_a_finished_motion(arm, loops, motion):
    last = int(np.ceil(motion.duration / 0.01 - 1e-9)) + 1
    arm.cut_off_from = last
    with pytest.raises(MotionError, match="told where to go: port nowhere"):
        loops.loop.follow(motion)


def test_an_arm_that_is_stuck_is_stopped_and_the_joint_named(arm, loops, motion):
    arm.stuck_from = 0.3
    with pytest.raises(FollowingError) as caught:
        loops.loop.follow(motion)
    assert caught.value.joint in ("shoulder", "elbow")
    np.testing.assert_allclose(arm.written[-1].qd, 0.0, atol=1e-9)
    assert arm.torque


def test_an_arm_that_does_not_arrive_is_reported_after_the_settling_time(
    arm, clock, limits, motion
):
    from splinearm.control.guard import Guard, Tolerances

    arm.stuck_from = motion.duration - 0.12
    guard = Guard(limits, Tolerances(path=None, goal=1e-4, settle=0.3))
    loops = Loops(arm, clock, guard)
    with pytest.raises(FollowingError):
        loops.loop.follow(motion)
    assert loops.cycles[-1].t == pytest.approx(motion.duration + 0.3, abs=0.02)


class LateClock(StepClock):
    """A step clock that oversleeps once."""

    def __init__(self, advance, now, at, by):
        super().__init__(advance, now)
        self.at, self.by = at, by

    def wait_until(self, t):
        super().wait_until(t)
        if self.by and t >= self.at:
            late, self.by = self.by, 0.0
            super().wait_until(t + late)
            return late
        return 0.0


def test_a_missed_cycle_is_skipped_and_seen(arm, guard, limits, motion):
    loops = Loops(arm, LateClock(arm.advance, lambda: arm.now, 0.3, 0.021), guard)
    assert loops.loop.follow(motion) is Outcome.FINISHED
    gaps = np.diff([cycle.index for cycle in loops.cycles])
    assert max(gaps) == 3
    assert_within(arm.written, limits)


def test_a_long_pause_stops_the_arm_from_where_it_was(arm, guard, limits, motion):
    start = arm.q.copy()
    loops = Loops(arm, LateClock(arm.advance, lambda: arm.now, 0.3, 0.2), guard)
    with pytest.raises(StaleFeedbackError, match="the computer was busy"):
        loops.loop.follow(motion)
    q = np.array([setpoint.q for setpoint in arm.written])
    assert np.abs(np.diff(q, axis=0)).max() <= 0.01 * limits.qd_max.max() * (1.0 + 1e-6)
    assert on_the_segment(q, start, Q_GOAL).max() < 1e-9
    np.testing.assert_allclose(arm.written[-1].qd, 0.0, atol=1e-9)


class SlowArm:
    """An arm whose readings take 60 ms once a servo is lost, six cycles."""

    def __init__(self, arm, slow_from):
        self.arm, self.slow_from = arm, slow_from

    def __getattr__(self, name):
        return getattr(self.arm, name)

    def read(self):
        if self.arm.reads >= self.slow_from:
            self.arm.advance(0.06)
        return self.arm.read()


class WallLikeClock(StepClock):
    """A step clock that is late when the arm has lived on by itself."""

    def wait_until(self, t):
        super().wait_until(t)
        return max(0.0, self.now() - t)


def test_a_stop_comes_to_its_end_also_when_every_cycle_is_late(arm, guard, limits, motion):
    start = arm.q.copy()
    arm.lose_reads_from, arm.lose_reads = 20, 10_000
    loops = Loops(SlowArm(arm, 19), WallLikeClock(arm.advance, lambda: arm.now), guard)
    with pytest.raises(StaleFeedbackError):
        loops.loop.follow(motion)
    q = np.array([setpoint.q for setpoint in arm.written])
    assert np.abs(np.diff(q, axis=0)).max() <= 0.03 * limits.qd_max.max() * (1.0 + 1e-6)
    assert on_the_segment(q, start, Q_GOAL).max() < 1e-9
    np.testing.assert_allclose(arm.written[-1].qd, 0.0, atol=1e-9)


def test_a_loop_refuses_a_period_that_is_not_a_time(arm, clock, guard):
    with pytest.raises(ValueError, match="period"):
        Loop(driver=arm, clock=clock, guard=guard, period=0.0)
    with pytest.raises(ValueError, match="bridge"):
        Loop(driver=arm, clock=clock, guard=guard, bridge=-1)


def test_a_motion_takes_as_long_as_its_pace_says(loops, motion, limits):
    assert loops.loop.follow(motion, pace=PaceRequest(0.5)) is Outcome.FINISHED
    half = loops.cycles[-1].t
    assert half == pytest.approx(2.0 * motion.duration, rel=0.1)
    assert np.array_equal(loops.cycles[-1].setpoint.q, Q_GOAL)
    assert_within([cycle.setpoint for cycle in loops.cycles], limits)


def test_a_motion_is_paused_and_goes_on(loops, motion, limits):
    request = PaceRequest()

    def ask(cycle):
        loops.cycles.append(cycle)
        if cycle.index == 20:
            request.pause()
        if cycle.index == 120:
            request.resume()

    loop = replace(loops.loop, observe=ask)
    assert loop.follow(motion, pace=request) is Outcome.FINISHED
    resting = [c.setpoint.q for c in loops.cycles[110:120]]
    assert np.ptp(resting, axis=0).max() == 0.0
    assert 0.0 < np.abs(resting[0] - Q_GOAL).max() < np.abs(motion.q_start - Q_GOAL).max()
    setpoints = [cycle.setpoint for cycle in loops.cycles]
    assert_within(setpoints, limits)
    assert on_the_segment(np.array([s.q for s in setpoints]), motion.q_start, Q_GOAL).max() <= 1e-9
    assert np.array_equal(setpoints[-1].q, Q_GOAL)


def test_a_stop_at_another_pace_is_along_the_path(loops, motion, limits):
    stop, request = StopRequest(), PaceRequest(0.6)

    def ask(cycle):
        loops.cycles.append(cycle)
        if cycle.index == 40:
            stop.request()

    loop = replace(loops.loop, observe=ask)
    assert loop.follow(motion, stop, request) is Outcome.STOPPED
    setpoints = [cycle.setpoint for cycle in loops.cycles]
    assert_within(setpoints, limits)
    assert not setpoints[-1].qd.any()
    assert on_the_segment(np.array([s.q for s in setpoints]), motion.q_start, Q_GOAL).max() <= 1e-9
    assert any("stopping along the path in" in line for line in loops.said)


def test_a_pace_that_means_nothing_is_refused():
    for pace in (-0.1, 1.6, np.nan):
        with pytest.raises(ValueError, match=r"pace: want a share from 0 to 1\.5"):
            PaceRequest(pace)
