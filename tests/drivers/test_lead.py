import numpy as np
import pytest

from splinearm.drivers.lead import GoalLead
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import LimitError
from splinearm.joints import JointSetpoint
from splinearm.units import DEG

PULSE = 2 * np.pi / 4096


class Ahead:
    """A feed-forward: so much droop under the weight, so much lag a speed."""

    def __init__(self, droop=2.0 * DEG, lag=0.05, current=None) -> None:
        self.droop, self.lag, self.amperes = droop, lag, current

    def lead(self, setpoint: JointSetpoint):
        return self.droop * np.cos(setpoint.q) + self.lag * setpoint.qd

    def current(self, setpoint: JointSetpoint):
        return None if self.amperes is None else np.full(setpoint.q.size, self.amperes)


def moving(q, qd, t=0.0) -> JointSetpoint:
    return JointSetpoint(t=t, q=np.array(q), qd=np.array(qd), qdd=np.zeros(len(q)))


@pytest.fixture
def bus(make_chain, make_direct, in_their_time):
    made = make_direct(make_chain())
    in_their_time(made)
    return made


def arm_with(ahead, bus, chain, limits) -> ServoArm:
    return ServoArm(chain, limits.names, limits, bus, feedforward=ahead)


def test_goals_are_ahead_and_limits_count_for_the_setpoint(bus, make_chain, make_limits):
    with arm_with(Ahead(), bus, make_chain(), make_limits()) as arm:
        arm.write(moving([1.5, 0.0, 0.0], [0.0, 1.0, 0.0]))
        goals = [(bus.servos[i].memory["Goal Position"] - 2048) * PULSE for i in (1, 2, 4)]
        wanted = [1.5 + 2 * DEG * np.cos(1.5), 2 * DEG + 0.05, 2 * DEG]
        np.testing.assert_allclose(goals, wanted, atol=PULSE)
        np.testing.assert_allclose(arm.goal, [1.5, 0.0, 0.0])
        with pytest.raises(LimitError):
            arm.write(moving([1.51, 0.0, 0.0], [0.0, 0.0, 0.0]))


def test_a_motion_that_starts_at_the_goal_does_not_jump_by_the_lead(bus, make_chain, make_limits):
    with arm_with(Ahead(), bus, make_chain(), make_limits()) as arm:
        held = {i: bus.servos[i].memory["Goal Position"] for i in (1, 2, 4)}
        np.testing.assert_allclose(arm.goal, -2 * DEG, atol=0.1 * DEG)
        arm.write(moving(arm.goal, [0.0, 0.0, 0.0]))
        assert all(abs(bus.servos[i].memory["Goal Position"] - held[i]) <= 1 for i in held)
        arm.hold()
        assert all(abs(bus.servos[i].memory["Goal Position"] - held[i]) <= 1 for i in held)


def test_an_arm_that_rests_at_its_limit_starts_there_and_does_not_jump(
    bus, make_chain, make_limits
):
    limits = make_limits(-0.01, 1.5)
    with arm_with(Ahead(), bus, make_chain(), limits) as arm:
        np.testing.assert_allclose(arm.goal, -0.01)
        before = 2048
        for k in range(60):
            arm.write(moving([-0.01] * 3, [0.0] * 3, t=0.01 * k))
            goal = bus.servos[1].memory["Goal Position"]
            assert abs(goal - before) <= 2
            before = goal
        assert goal == pytest.approx(2048 + (2 * DEG - 0.01) / PULSE, abs=1.5)


def test_at_the_end_of_what_a_servo_takes_the_goal_stays_and_that_is_told_once(
    bus, make_chain, make_limits, caplog
):
    for servo in bus.servos.values():
        servo.memory["Max Position Limit"] = 2148
    limits = make_limits(-0.5, 100 * PULSE)
    with arm_with(Ahead(), bus, make_chain(), limits) as arm:
        for _ in range(3):
            arm.write(moving([100 * PULSE, 0.0, 0.0], [0.0] * 3))
        assert bus.servos[1].memory["Goal Position"] == 2148
    told = [r.message for r in caplog.records if "feed-forward" in r.message]
    assert len(told) == 1
    assert "joint 'waist': its feed-forward wants a goal 1.98 deg beyond" in told[0]


def test_a_feed_forward_that_makes_no_sense_is_refused(make_limits):
    with pytest.raises(LimitError, match="'waist'"):
        GoalLead(make_limits(), Ahead(droop=1.0)).goal(moving([0.0] * 3, [0.0] * 3))
    with pytest.raises(ValueError, match="lead"):
        GoalLead(make_limits(), Ahead(droop=np.nan)).goal(moving([0.0] * 3, [0.0] * 3))


def test_without_a_feed_forward_goals_are_where_setpoints_are(make_limits):
    lead, setpoint = GoalLead(make_limits(), None), moving([0.1, 0.2, 0.3], [1.0, 1.0, 1.0])
    assert lead.goal(setpoint) is setpoint.q
    assert lead.current(setpoint) is None
    assert lead.setpoint_at(setpoint.q) is setpoint.q


def test_a_current_goes_out_where_there_is_one(bus, make_chain, make_limits):
    with arm_with(Ahead(droop=0.0, current=0.5), bus, make_chain(), make_limits()) as arm:
        arm.write(moving([0.0] * 3, [0.0] * 3))
        assert bus.servos[1].memory["Goal Current"] == round(500 / 2.69)
        assert bus.servos[2].memory["Goal Current"] == round(500 / 2.69)
