"""What ends a motion, and what is told of it."""

import time

import numpy as np
import pytest

from splinearm.control.clock import StepClock
from splinearm.control.ending import ExitReason, Outcome, reason_of
from splinearm.control.follow import Loop
from splinearm.control.guard import Guard
from splinearm.control.stop import StopRequest
from splinearm.control.tolerance import Tolerances
from splinearm.drivers.servo_stats import LastSeen
from splinearm.errors import (
    BusTimeoutError,
    ConfigError,
    FollowingError,
    HealthError,
    LimitError,
    MotionError,
    ServoError,
    StaleFeedbackError,
    StartError,
    UnreachableError,
)
from splinearm.joints import JointSetpoint, JointState
from splinearm.trajectories.plan import plan_joint_move

Q_GOAL = np.array([1.2, -1.4])


class PartialArm:
    """An arm of servos: says what it heard of each joint, and fails as it is told to."""

    def __init__(self, arm):
        self.arm = arm
        self.heard_at = np.full(2, -np.inf)
        self.dead: dict[int, range] = {}
        self.raises: dict[int, Exception] = {}

    def __getattr__(self, name):
        return getattr(self.arm, name)

    @property
    def last_seen(self):
        nothing = np.full(2, np.nan)
        return LastSeen(t=self.heard_at, q=self.arm.q, qd=self.arm.qd, current=nothing)

    def read(self) -> JointState:
        state = self.arm.read()
        cycle = self.arm.reads - 2  # the first reading is before the motion
        lost = [joint for joint, cycles in self.dead.items() if cycle in cycles]
        self.heard_at = self.heard_at.copy()
        self.heard_at[[joint for joint in range(2) if joint not in lost]] = time.monotonic()
        if cycle in self.raises:
            raise self.raises[cycle]
        if lost:
            raise BusTimeoutError(lost[0] + 1, "Present Position", name=f"servo{lost[0]}")
        return state


@pytest.fixture
def partial(arm):
    return PartialArm(arm)


@pytest.fixture
def motion(arm, limits):
    return plan_joint_move(limits, arm.q, Q_GOAL)


class Followed:
    """A motion carried out, with what was said and seen."""

    def __init__(self, driver, arm, guard, motion, **more):
        self.said: list[str] = []
        self.cycles = []
        more.setdefault("observe", self.cycles.append)
        stop = more.pop("stop", None)
        loop = Loop(
            driver=driver,
            clock=StepClock(arm.advance, lambda: arm.now),
            guard=guard,
            announce=self.said.append,
            **more,
        )
        self.ending = loop.carry_out(motion, stop)


def on_the_segment(q, start, goal):
    along = goal - start
    share = (q - start) @ along / (along @ along)
    return np.linalg.norm(q - start - share[:, None] * along, axis=1)


def assert_stopped_on_its_path(arm, start):
    q = np.array([setpoint.q for setpoint in arm.written])
    assert on_the_segment(q, start, Q_GOAL).max() < 1e-9
    np.testing.assert_allclose(arm.written[-1].qd, 0.0, atol=1e-9)
    assert arm.holding
    assert arm.torque


def test_a_finished_motion_says_so_in_every_word(partial, arm, guard, motion):
    ending = Followed(partial, arm, guard, motion).ending
    assert (ending.outcome, ending.reason) == (Outcome.FINISHED, ExitReason.SUCCESSFUL)
    assert ending.fault is None
    assert ending.stopped is None


def test_a_stop_leaves_the_rest_of_the_motion_and_that_leads_to_the_goal(
    partial, arm, guard, motion
):
    stop = StopRequest()
    first = Followed(
        partial,
        arm,
        guard,
        motion,
        stop=stop,
        observe=lambda cycle: cycle.index == 20 and stop.request(),
    )
    ending = first.ending
    assert (ending.outcome, ending.reason) == (
        Outcome.STOPPED,
        ExitReason.GOAL_TOLERANCE_VIOLATED,
    )
    np.testing.assert_allclose(ending.stopped.q, arm.q, atol=1e-9)
    assert any("of joint 'elbow'" in line for line in first.said)
    second = Followed(partial, arm, guard, ending.stopped.remaining())
    assert second.ending.outcome is Outcome.FINISHED
    np.testing.assert_allclose(arm.q, Q_GOAL, atol=1e-9)
    q = np.array([setpoint.q for setpoint in arm.written])
    assert on_the_segment(q, motion.q_start, Q_GOAL).max() < 1e-9


def test_a_dead_servo_is_named_within_three_cycles_and_the_others_are_served_on(
    partial, arm, guard, motion
):
    partial.dead[1] = range(20, 10_000)
    followed = Followed(partial, arm, guard, motion, bridge=10_000)
    named = [line for line in followed.said if "gave no answer" in line]
    assert len(named) == 1
    assert named[0].startswith("joint 'elbow' gave no answer for 3 cycles: servo 2 (servo1)")
    assert len(arm.written) == len(followed.cycles) == followed.cycles[-1].index + 1


def test_while_one_servo_is_dead_the_other_joint_is_still_watched(partial, arm, guard, motion):
    partial.dead[1] = range(5, 10_000)
    arm.stuck_from = 0.2
    fault = Followed(partial, arm, guard, motion, bridge=10_000).ending.fault
    assert isinstance(fault, FollowingError)
    assert fault.joint == "shoulder"


def test_answers_lost_here_and_there_do_not_add_up(partial, arm, guard, motion):
    partial.dead = {0: range(10, 60, 2), 1: range(11, 60, 2)}
    followed = Followed(partial, arm, guard, motion)
    assert followed.ending.outcome is Outcome.FINISHED
    assert sum(cycle.state is None for cycle in followed.cycles) == 50


def test_a_first_answer_that_is_lost_is_asked_for_again(partial, arm, guard, motion):
    partial.dead[0] = range(-1, 1)
    assert Followed(partial, arm, guard, motion).ending.outcome is Outcome.FINISHED


def test_an_arm_that_does_not_answer_at_all_does_not_begin(partial, arm, guard, motion):
    partial.dead[0] = range(-1, 10_000)
    with pytest.raises(BusTimeoutError):
        Followed(partial, arm, guard, motion)
    assert arm.written == []


def test_a_joint_that_answers_again_is_told(partial, arm, guard, motion):
    partial.dead[0] = range(20, 23)
    followed = Followed(partial, arm, guard, motion)
    assert followed.ending.outcome is Outcome.FINISHED
    assert "every joint answers again" in followed.said


@pytest.mark.parametrize(
    "error",
    [
        ServoError(2, "overload: the torque is off", alert=True, name="elbow"),
        HealthError(2, "elbow", "temperature", 72.0, 70.0, unit="degC", remedy="let it cool"),
    ],
)
def test_a_servo_in_trouble_stops_the_arm_on_its_path_at_once(partial, arm, guard, motion, error):
    start = arm.q.copy()
    partial.raises[30] = error
    followed = Followed(partial, arm, guard, motion)
    assert followed.ending.reason is ExitReason.PATH_TOLERANCE_VIOLATED
    assert str(error) in str(followed.ending.fault)
    assert followed.ending.fault.__cause__ is error
    assert followed.ending.fault.stopped is followed.ending.stopped
    assert_stopped_on_its_path(arm, start)
    begun = [c.setpoint.t for c in followed.cycles].index(0.0, 1)
    assert begun == 30


def test_a_refusal_without_an_alert_is_bridged(partial, arm, guard, motion):
    partial.raises[30] = ServoError(2, "Present Position refused", code=1)
    assert Followed(partial, arm, guard, motion).ending.outcome is Outcome.FINISHED


def test_an_observer_that_fails_stops_the_arm_on_its_path(partial, arm, guard, motion):
    start = arm.q.copy()

    def observe(cycle):
        if cycle.index == 25:
            raise KeyError("a bug")

    fault = Followed(partial, arm, guard, motion, observe=observe).ending.fault
    assert "KeyError('a bug')" in str(fault)
    assert_stopped_on_its_path(arm, start)


def test_a_joint_out_of_its_own_path_tolerance_stops_the_arm(arm, limits, motion):
    guard = Guard(limits, Tolerances(path=np.array([1.0, 0.02]), lag=0.0))
    arm.stuck_from = 0.3
    ending = Followed(arm, arm, guard, motion).ending
    assert ending.reason is ExitReason.PATH_TOLERANCE_VIOLATED
    assert ending.fault.joint == "elbow"


def test_a_joint_that_does_not_settle_in_its_own_time_is_named(arm, limits, motion):
    goal, settle = np.array([1e-3, 1e-3]), np.array([0.5, 0.2])
    guard = Guard(limits, Tolerances(path=None, goal=goal, settle=settle))
    arm.stuck_from = motion.duration - 0.1
    followed = Followed(arm, arm, guard, motion)
    assert followed.ending.reason is ExitReason.GOAL_TOLERANCE_VIOLATED
    assert followed.ending.fault.joint == "elbow"
    assert followed.cycles[-1].t == pytest.approx(motion.duration + 0.2, abs=0.02)


def test_a_cable_that_is_pulled_leaves_the_rest_from_the_last_setpoint(arm, guard, motion):
    arm.cut_off_from = 20
    ending = Followed(arm, arm, guard, motion).ending
    assert ending.reason is ExitReason.PATH_TOLERANCE_VIOLATED
    assert ending.stopped.t == pytest.approx(arm.written[-1].t)
    arm.cut_off_from = None
    rest = ending.stopped.remaining()
    arm.q = rest.q_start.copy()
    assert Followed(arm, arm, guard, rest).ending.outcome is Outcome.FINISHED


def test_a_quick_loop_bridges_as_long_a_time_as_a_slow_one(arm, guard):
    clock = StepClock(arm.advance, lambda: arm.now)
    cycles = [
        Loop(driver=arm, clock=clock, guard=guard, period=period).bridged
        for period in (0.001, 0.002, 0.01, 0.05)
    ]
    assert cycles == [20, 10, 3, 3]
    assert Loop(driver=arm, clock=clock, guard=guard, bridge=0).bridged == 0


@pytest.mark.parametrize(
    ("error", "at_goal", "reason"),
    [
        (FollowingError("a", 0.0, 1.0, 0.1, 0.2), False, -4),
        (FollowingError("a", 0.0, 1.0, 0.1, 0.2), True, -5),
        (StaleFeedbackError(0.1, 0.03), True, -4),
        (MotionError("the arm can no longer be told where to go"), False, -4),
        (StartError("a", 0.0, 1.0, 0.1), False, -1),
        (LimitError("a", "velocity", 2.0, 1.0), False, -1),
        (UnreachableError(0.1, 0.0), False, -1),
        (BusTimeoutError(3), False, -1),
        (ConfigError("f.json", "joints", "is for others"), False, -2),
        (ConfigError("f.json", "rate", "is wrong"), False, -1),
    ],
)
def test_every_error_has_a_code_that_ros_knows(error, at_goal, reason):
    assert reason_of(error, at_goal=at_goal) == reason


def test_the_codes_are_those_of_control_msgs():
    # control_msgs/action/FollowJointTrajectory.action
    assert {reason.name: int(reason) for reason in ExitReason} == {
        "SUCCESSFUL": 0,
        "INVALID_GOAL": -1,
        "INVALID_JOINTS": -2,
        "OLD_HEADER_TIMESTAMP": -3,
        "PATH_TOLERANCE_VIOLATED": -4,
        "GOAL_TOLERANCE_VIOLATED": -5,
    }


@pytest.mark.parametrize("at", [5, 20, 40, 80])
def test_a_stop_keeps_the_limit_of_jerk(arm, limits, at):
    smooth = limits.with_jerk_time(0.15)
    motion = plan_joint_move(smooth, arm.q, Q_GOAL)
    stop = StopRequest()
    followed = Followed(
        arm,
        arm,
        Guard(smooth),
        motion,
        stop=stop,
        observe=lambda cycle: cycle.index == at and stop.request(),
    )
    assert followed.ending.outcome is Outcome.STOPPED
    qdd = np.array([setpoint.qdd for setpoint in arm.written])
    assert (np.abs(np.diff(qdd, axis=0)) / 0.01 <= smooth.qddd_max * (1.0 + 1e-3)).all()
    np.testing.assert_allclose(arm.written[-1].qdd, 0.0, atol=1e-6)


def test_a_setpoint_whose_acceleration_jumps_does_not_pass(limits):
    guard = Guard(limits.with_jerk_time(0.1))
    rest = np.zeros(2)
    guard.check(JointSetpoint(t=0.0, q=rest, qd=rest, qdd=rest), 0.0)
    jump = JointSetpoint(t=0.01, q=rest, qd=rest, qdd=np.array([0.0, 3.0]))
    with pytest.raises(LimitError, match="joint 'elbow': jerk"):
        guard.check(jump, 0.01)
