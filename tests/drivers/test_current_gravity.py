"""Leading an arm by hand: it stays where it is left, goes where it is pushed, and never drops."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.current_gravity import GravityCompensation, GuidingFeel
from splinearm.drivers.feedforward import ServoFeedforward
from splinearm.drivers.feedforward_drive import JointDrive
from splinearm.errors import BusTimeoutError, StaleFeedbackError
from splinearm.joints import JointState
from splinearm.kinematics.dynamics import Dynamics
from splinearm.units import DEG


def chain_of(n: int, **settings: int) -> ServoChain:
    return ServoChain(
        servos=tuple(
            ServoSpec(
                name=f"s{k}",
                servo_id=k + 1,
                model="XM430-W350",
                role=ServoRole.LEADER,
                joint=f"j{k}",
                zero_ticks=2048,
                settings={"Return Delay Time": 0, **settings},
            )
            for k in range(n)
        )
    )


class Arm:
    """An arm that is where the test says, and remembers what it was told."""

    def __init__(self, q: list[float]) -> None:
        self.q, self.n = np.array(q), len(q)
        self.goal = self.q.copy()
        self.lost = self.held = 0
        self.written: list[np.ndarray] = []

    def read(self) -> JointState:
        if self.lost:
            self.lost -= 1
            raise BusTimeoutError(1, "Present Position", port="none", name="s1")
        still = np.zeros(self.n)
        return JointState(t=0.0, q=self.q, qd=still, current=still)

    def write(self, setpoint) -> None:
        self.written.append(setpoint.q)

    def hold(self) -> None:
        self.held += 1


REACH = 10.0 * DEG


def weightless(n: int) -> ServoFeedforward:
    drives = [JointDrive(stiffness=20.0, reach=REACH)] * n
    return ServoFeedforward(drives, [f"j{k}" for k in range(n)], lambda q, qd, qdd: 0.0 * q)


@pytest.fixture
def guided(make_limits):
    """Make the compensation of such an arm."""

    def make(q, **options):
        names = tuple(f"j{k}" for k in range(len(q)))
        arm = Arm(q)
        limits = make_limits(names=names)
        return arm, GravityCompensation(arm, weightless(len(q)), limits, **options)

    return make


def test_the_goal_stays_while_the_joint_is_within_the_slack_and_trails_it_beyond(guided):
    arm, guide = guided([0.0, 0.5])
    slack = 0.06 * REACH
    assert guide.slack == pytest.approx([slack, slack])
    with guide:
        arm.q = np.array([0.9 * slack, 0.5])
        guide.step()
        assert arm.written[-1].tolist() == [0.0, 0.5]
        arm.q = np.array([1.5 * slack, 0.5 - 2.0 * slack])
        guide.step()
        assert arm.written[-1] == pytest.approx([0.5 * slack, 0.5 - slack])
        arm.q = np.array([0.6 * slack, 0.5])
        guide.step()
        assert arm.written[-1] == pytest.approx([0.5 * slack, 0.5 - slack])
    assert arm.held == 1
    assert guide.goal == pytest.approx([0.5 * slack, 0.5 - slack])


def test_the_goal_is_no_quicker_than_joints_and_tool_may_be(guided):
    feel = GuidingFeel(speed=0.25)
    arm, guide = guided([0.0], feel=feel, period=0.01)
    with guide:
        arm.q = np.array([1.0])
        guide.step()
        assert arm.written[-1] == pytest.approx([0.25 * 3.0 * 0.01])
    tool = replace(feel, haste=lambda q, qd: abs(qd[0]) / 0.2)
    arm, guide = guided([0.0], feel=tool, period=0.01)
    with guide:
        arm.q = np.array([1.0])
        for k in range(1, 4):
            guide.step()
            assert arm.written[-1] == pytest.approx([0.2 * 0.01 * k])


def test_the_goal_stays_within_the_limits(guided):
    arm, guide = guided([1.45])
    with guide:
        arm.q = np.array([1.7])
        for _ in range(20):
            guide.step()
    assert arm.written[-1] == pytest.approx([1.5])


def test_lost_feedback_is_bridged_then_the_arm_stays_at_its_last_goal(guided):
    arm, guide = guided([0.3], bridge=2)
    with guide:
        arm.lost = 2
        assert guide.step() is None
        assert guide.step() is None
        assert guide.step() is not None
        assert [q.tolist() for q in arm.written] == [[0.3]] * 3
    arm.lost = 3
    with guide:
        guide.step()
        guide.step()
        with pytest.raises(StaleFeedbackError, match="s1"):
            guide.step()
    assert arm.held == 2


def test_what_does_not_go_together_is_refused(make_limits):
    two = make_limits(names=("j0", "j1"))
    with pytest.raises(ValueError, match="joints"):
        GravityCompensation(Arm([0.0]), weightless(2), two)
    blind = ServoFeedforward([JointDrive(why_not="is of wood")], ["j0"])
    with pytest.raises(ValueError, match="torques"):
        GravityCompensation(Arm([0.0]), blind, make_limits(names=("j0",)))
    with pytest.raises(ValueError, match="period"):
        GravityCompensation(Arm([0.0] * 2), weightless(2), two, period=0.0)
    with pytest.raises(ValueError, match="bridge"):
        GravityCompensation(Arm([0.0] * 2), weightless(2), two, bridge=-1)
    with pytest.raises(ValueError, match="breakaway"):
        GuidingFeel(breakaway=0.0)
    with pytest.raises(ValueError, match="speed"):
        GuidingFeel(speed=2.0)
    with pytest.raises(ValueError, match="ease"):
        GuidingFeel(ease=-0.1)


def full(chain, arm, mass=1.0):
    torque = Dynamics(arm).inverse

    def wrong(q, qd, qdd):
        return mass * torque(q, qd, qdd)

    return lambda bus: ServoFeedforward.of(chain, arm.joint_names, wrong, bus=bus)


def lead_by_hand(one, torques, duration, feel=None):
    """Push the joints for some time; give where they were in each cycle."""
    path = [one.virtual.q]
    with GravityCompensation(one.driver, one.feedforward, one.arm.limits, feel) as guide:
        one.push(torques)
        for _ in range(round(duration / one.period)):
            guide.step()
            one.pass_time(one.period)
            path.append(one.virtual.q)
        one.push(0.0)
        for _ in range(round(0.3 / one.period)):
            guide.step()
            one.pass_time(one.period)
    return np.array(path)


@pytest.mark.kernel
@pytest.mark.parametrize("pose", [[0.0, 0.0], [1.2, -1.0], [-2.0, 0.6]])
@pytest.mark.parametrize("mass", [1.0, 0.85])
def test_an_arm_that_is_let_go_anywhere_stays_there(pose, mass, stepped_arm, pendulum):
    chain = chain_of(2)
    arm = pendulum(2, 0.35)  # full reach takes a third of what the first servo gives
    one = stepped_arm(arm, chain, pose, full(chain, arm, mass))
    with one.driver:
        one.pass_time(0.6)
        path = lead_by_hand(one, np.zeros(2), 5.0)
    assert np.abs(path - path[0]).max() <= (0.4 if mass == 1.0 else 1.0) * DEG


@pytest.mark.kernel
def test_a_hand_moves_the_arm_and_it_stays_where_it_was_led(stepped_arm, pendulum):
    chain = chain_of(2)
    arm = pendulum(2, 0.35)
    one = stepped_arm(arm, chain, [0.4, 0.3], full(chain, arm))
    with one.driver:
        one.pass_time(0.6)
        path = lead_by_hand(one, np.array([0.6, 0.0]), 1.5)
        left = one.virtual.q
        assert path[-1][0] - path[0][0] >= 30.0 * DEG
        assert abs(path[-1][1] - path[0][1]) <= 2.0 * DEG
        assert left == pytest.approx(path[-1], abs=6.0 * DEG)
        one.pass_time(1.0)
        stays = one.virtual.q
        assert stays == pytest.approx(left, abs=1.0 * DEG)
        one.pass_time(2.0)
        assert one.virtual.q == pytest.approx(stays, abs=0.05 * DEG)


@pytest.mark.kernel
def test_a_hand_that_pushes_hard_makes_the_arm_no_faster_than_it_may_be(stepped_arm, pendulum):
    chain = chain_of(1)
    arm = pendulum(1, 0.5)
    one = stepped_arm(arm, chain, [0.4], full(chain, arm))
    feel = GuidingFeel(haste=lambda q, qd: abs(qd[0]) / 0.3)
    with one.driver:
        one.pass_time(0.6)
        path = lead_by_hand(one, np.array([1.5]), 1.5, feel)
    speed = np.diff(path[:, 0]) / one.period
    assert np.mean(speed[-50:]) == pytest.approx(0.3, abs=0.03)
    assert path[-1][0] - path[0][0] <= 0.3 * 1.5 + 8.0 * DEG  # the servo gives way at first


@pytest.mark.kernel
def test_with_ease_the_same_hand_leads_the_arm_further(stepped_arm, pendulum):
    chain = chain_of(1)
    arm = pendulum(1, 0.5)
    ways = []
    for ease in (0.0, 0.8):
        one = stepped_arm(arm, chain, [0.4], full(chain, arm))
        with one.driver:
            one.pass_time(0.6)
            path = lead_by_hand(one, np.array([0.5]), 1.0, GuidingFeel(ease=ease))
        ways.append(path[-1][0] - path[0][0])
    assert 0.0 < 1.5 * ways[0] < ways[1]


@pytest.mark.kernel
def test_an_arm_whose_program_dies_in_the_hand_does_not_drop(stepped_arm, pendulum):
    chain = chain_of(2)
    arm = pendulum(2, 0.35)
    one = stepped_arm(arm, chain, [0.0, 0.0], full(chain, arm))
    with one.driver:
        one.pass_time(0.6)
        guide = GravityCompensation(one.driver, one.feedforward, arm.limits)
        guide.__enter__()
        for _ in range(20):
            guide.step()
            one.pass_time(one.period)
        left = one.virtual.q
        for servo in one.chain.servos:
            watchdog = servo.servo_model.table["Bus Watchdog"]
            one.bus.write(servo.servo_id, watchdog, 5)
        one.t += 3.0  # nobody says anything any more
        one.virtual.advance()
        assert one.virtual.q == pytest.approx(left, abs=1.0 * DEG)
        assert all(servo.tripped for servo in one.virtual.servos.values())
