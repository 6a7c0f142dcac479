"""Feed-forward: what it foretells of a servo, and what virtual servos make of it."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.conformance import check_arm_driver
from splinearm.drivers.feedforward import MOST, ServoFeedforward, cycle_latency
from splinearm.drivers.feedforward_drive import (
    JointDrive,
    joint_drives,
    read_tuning,
    stall_at,
    torque_per_amp,
)
from splinearm.drivers.model import servo_model
from splinearm.joints import JointSetpoint
from splinearm.kinematics.dynamics import Dynamics
from splinearm.units import DEG, RPM

MODELS = ["XM430-W350", "XM430-W210", "XM540-W270", "XH540-W270"]
MODELS += ["XL430-W250", "XC430-W150", "XL330-M288", "XL330-M077", "MX-28-2"]


def servo(servo_id=1, joint="j0", model="XM430-W350", role=ServoRole.LEADER, **settings):
    return ServoSpec(
        name=f"s{servo_id}",
        servo_id=servo_id,
        model=model,
        role=role,
        joint=joint,
        zero_ticks=2048,
        settings=settings,
    )


def chain_of(*servos: ServoSpec) -> ServoChain:
    return ServoChain(servos=servos)


def drive_of(*servos: ServoSpec) -> JointDrive:
    return joint_drives(chain_of(*servos), ["j0"])[0]


def setpoint(q, qd, qdd):
    q, qd, qdd = (np.atleast_1d(np.asarray(value, dtype=float)) for value in (q, qd, qdd))
    return JointSetpoint(t=0.0, q=q, qd=qd, qdd=qdd)


def constant(torque):
    return lambda q, qd, qdd: np.full(q.shape, torque)


def test_an_xm430_is_as_stiff_and_lags_as_its_manual_makes_it():
    drive = drive_of(servo())
    ticks = 4096 / (2 * np.pi)
    stiffness = 4.1 * 800 / 128 / 885 * ticks
    assert drive.stiffness == pytest.approx(stiffness, rel=1e-12)
    assert drive.stiffness == pytest.approx(18.9, abs=0.05)
    assert drive.lag == pytest.approx(4.1 / (46 * RPM) / stiffness, rel=1e-12)
    assert drive.lag == pytest.approx(0.045, abs=5e-4)
    assert drive.reach == pytest.approx(885 * 128 / 800 / ticks, rel=1e-12)


def test_a_d_gain_makes_a_servo_lag_by_its_share_of_the_p_gain():
    plain, damped = drive_of(servo()), drive_of(servo(**{"Position D Gain": 800}))
    # D/16 ticks a millisecond against P/128 ticks
    assert damped.lag - plain.lag == pytest.approx(800 / 16 / (800 / 128) * 1e-3, rel=1e-12)


def test_two_servos_at_a_joint_are_twice_as_stiff_and_lag_the_same():
    one = drive_of(servo())
    two = drive_of(servo(), servo(2, role=ServoRole.SHADOW))
    assert two.stiffness == pytest.approx(2 * one.stiffness)
    assert two.lag == pytest.approx(one.lag)
    assert two.friction == pytest.approx(2 * one.friction)


def test_a_higher_p_gain_is_stiffer_and_lags_less():
    soft, stiff = drive_of(servo()), drive_of(servo(**{"Position P Gain": 1600}))
    assert stiff.stiffness == pytest.approx(2 * soft.stiffness)
    assert stiff.lag == pytest.approx(soft.lag / 2)


def test_in_current_based_position_mode_the_speed_costs_nothing():
    drive = drive_of(servo(**{"Operating Mode": 5}))
    assert drive.lag == 0.0
    # a step of current is 2.69 mA of the 2.3 A that make 4.1 N m
    ticks = 4096 / (2 * np.pi)
    assert drive.stiffness == pytest.approx(6.25 * 2.69e-3 * 4.1 / 2.3 * ticks, rel=1e-9)


@pytest.mark.parametrize(
    ("volts", "torque"), [(12.0, 4.1), (11.1, 3.8), (11.55, 3.95), (6.0, None)]
)
def test_stall_figures_are_the_makers_and_go_with_the_supply(volts, torque):
    model = servo_model("XM430-W350")
    found, _, speed = stall_at(model, volts)
    assert found == pytest.approx(3.8 * volts / 11.1 if torque is None else torque)
    assert speed == pytest.approx(
        (43 if volts < 11.1 else speed / RPM) * RPM * min(1, volts / 11.1)
    )


def test_a_model_without_stall_torque_has_no_figures():
    with pytest.raises(ValueError, match="PH42"):
        stall_at(servo_model("PH42-020-S300"), 24.0)
    with pytest.raises(ValueError, match="PH42"):
        torque_per_amp(servo_model("PH42-020-S300"))


@pytest.mark.parametrize(
    ("one", "reason"),
    [
        (servo(**{"Profile Velocity": 50}), "profile"),
        (servo(**{"Position P Gain": 0}), "no P gain"),
        (servo(model="PH42-020-S300"), "stall torque"),
        (servo(model="XL320"), "has no"),
    ],
)
def test_a_servo_that_is_not_understood_is_not_led_and_that_is_told(one, reason, caplog):
    with caplog.at_level(logging.WARNING):
        ahead = ServoFeedforward.of(chain_of(one), ["j0"], constant(1.0))
    assert reason in caplog.text
    assert "j0" in caplog.text
    assert ahead.lead(setpoint(0.3, 1.0, 2.0)).tolist() == [0.0]


def test_a_servo_with_an_i_gain_carries_the_weight_itself():
    one = servo(**{"Position I Gain": 100})
    ahead = ServoFeedforward.of(chain_of(one), ["j0"], constant(1.0), latency=0.0)
    assert ahead.lead(setpoint(0.3, 0.0, 0.0)).tolist() == [0.0]
    assert ahead.lead(setpoint(0.3, 1.0, 0.0))[0] > 0.04


def test_at_rest_the_lead_is_what_the_weight_asks_for():
    ahead = ServoFeedforward.of(chain_of(servo()), ["j0"], constant(0.7))
    lead = ahead.lead(setpoint(0.3, 0.0, 0.0))
    assert lead == pytest.approx([0.7 / ahead.drives[0].stiffness], rel=1e-12)
    assert ahead.current(setpoint(0.3, 0.0, 0.0)) is None


def test_the_torque_is_asked_for_when_the_goal_counts():
    asked = []

    def torque(q, qd, qdd):
        asked.append((q[0], qd[0], qdd[0]))
        return np.zeros(1)

    ahead = ServoFeedforward.of(chain_of(servo()), ["j0"], torque, latency=0.01)
    lead = ahead.lead(setpoint(0.3, 1.0, 2.0))
    assert asked == [pytest.approx((0.3 + 0.01 + 1e-4, 1.02, 2.0))]
    drive = ahead.drives[0]
    own = drive.lag * 1.02 + (drive.inertia * 2.0 + drive.friction * 1.02 / (1.02 + 0.5 * DEG)) / (
        drive.stiffness
    )
    assert lead == pytest.approx([0.0101 + own], rel=1e-12)


@pytest.mark.property
@given(
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.tuples(*[st.floats(-1e-6, 1e-6)] * 3),
)
def test_the_lead_goes_on_as_the_setpoint_does(state, change):
    ahead = ServoFeedforward.of(chain_of(servo()), ["j0"], lambda q, qd, qdd: np.cos(q) + 0.1 * qdd)
    moved = tuple(a + b for a, b in zip(state, change, strict=True))
    jump = ahead.lead(setpoint(*moved)) - ahead.lead(setpoint(*state))
    # the steepest is the dry friction around rest: 0.03 N m within half a degree a second
    assert abs(jump[0]) <= 1.0 * max(map(abs, change)) + 1e-15


@pytest.mark.property
@given(st.floats(-1e4, 1e4), st.floats(-50, 50), st.floats(-500, 500))
def test_no_lead_is_above_the_most(torque, qd, qdd):
    ahead = ServoFeedforward.of(chain_of(servo()), ["j0"], constant(torque), latency=0.0)
    assert abs(ahead.lead(setpoint(0.0, qd, qdd))[0]) <= ahead.most[0] <= MOST


def test_a_lead_that_is_cut_is_told_once_a_joint(caplog):
    ahead = ServoFeedforward.of(chain_of(servo()), ["j0"], constant(50.0))
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            ahead.lead(setpoint(0.0, 0.0, 0.0))
    assert caplog.text.count("joint 'j0'") == 1


def test_a_goal_is_late_by_half_a_cycle_and_the_wire():
    assert cycle_latency(0.01, 6, 1_000_000) == pytest.approx(0.005 + 136 * 10e-6)
    assert cycle_latency(0.001, 2, 4_000_000) == pytest.approx(0.0005 + 60 * 2.5e-6)


def test_wrong_arguments_are_refused():
    drive = drive_of(servo())
    with pytest.raises(ValueError, match="drives"):
        ServoFeedforward([drive], ["a", "b"])
    with pytest.raises(ValueError, match="latency"):
        ServoFeedforward([drive], ["a"], latency=1.0)


def sway(arm, duration=1.6, amplitude=0.6, centre=0.7):
    """Give a smooth motion of every joint: rest to rest, some swings."""

    def at(t):
        s = np.clip(t / duration, 0.0, 1.0)
        turn = 4.0 * np.pi
        window, slope = 0.5 * (1 - np.cos(2 * np.pi * s)), np.pi * np.sin(2 * np.pi * s)
        bend = 2 * np.pi**2 * np.cos(2 * np.pi * s)
        sine, cosine = np.sin(turn * s), np.cos(turn * s)
        q = centre + amplitude * window * sine
        qd = amplitude * (slope * sine + window * turn * cosine) / duration
        qdd = amplitude * (bend * sine + 2 * slope * turn * cosine - window * turn**2 * sine)
        each = np.ones(arm.n)
        return JointSetpoint(t=t, q=q * each, qd=qd * each, qdd=qdd / duration**2 * each)

    return at


def tracking(one, duration=1.6, **motion) -> np.ndarray:
    """Follow a sway; give the errors, rad."""
    at = sway(one.arm, duration, **motion)
    errors = []
    with one.driver:
        one.rest(at(0.0).q, 1.0)
        for k in range(round(duration / one.period)):
            wanted = at(k * one.period)
            errors.append(one.cycle(wanted) - wanted.q)
    return np.array(errors)


def rms(errors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def hung(pendulum, chain, n=1):
    """Give a pendulum that asks each servo for about a third of what it can."""
    torque, _, speed = stall_at(servo_model(chain.servos[0].model), 12.0)
    if chain.servos[0].model.startswith("XL330"):
        torque, _, speed = stall_at(servo_model(chain.servos[0].model), 5.0)
    return pendulum(n, 0.3 * torque / (9.81 * 0.1 * n**2), speed=0.9 * speed)


def full(chain, arm, latency=0.007):
    """Give what makes the whole feed-forward once a bus is there."""
    torque = Dynamics(arm).inverse
    return lambda bus: ServoFeedforward.of(chain, arm.joint_names, torque, bus=bus, latency=latency)


@pytest.mark.kernel
@pytest.mark.parametrize("model", MODELS)
def test_every_model_follows_far_better_than_without(model, stepped_arm, pendulum):
    chain = chain_of(servo(model=model, **{"Return Delay Time": 0}))
    arm = hung(pendulum, chain)
    # the quickest moment takes a third of the speed that the motor has without a load
    motion = {"amplitude": min(0.4, 0.3 * arm.limits.qd_max[0] * 1.6 / (4 * np.pi))}
    q = [0.7]
    without = rms(tracking(stepped_arm(arm, chain, q), **motion))
    led = rms(tracking(stepped_arm(arm, chain, q, full(chain, arm)), **motion))
    assert led <= without / 15.0
    assert led <= 0.4 * DEG


@pytest.mark.kernel
def test_a_joint_of_two_servos_is_led_by_both(stepped_arm, pendulum):
    shadow = {"Drive Mode": 1, "Secondary(Shadow) ID": 1}
    chain = chain_of(servo(), servo(2, role=ServoRole.SHADOW, **shadow))
    arm = pendulum(1, 2.0, speed=4.0)
    errors = tracking(stepped_arm(arm, chain, [0.7], full(chain, arm)), amplitude=0.25)
    assert rms(errors) <= 0.2 * DEG


@pytest.mark.kernel
def test_gains_and_supply_that_servos_hold_count(stepped_arm, pendulum):
    chain = chain_of(servo())
    arm = pendulum(1, 0.5, speed=4.0)
    one = stepped_arm(arm, chain, [0.7])
    one.bus.write(1, servo_model("XM430-W350").table["Position P Gain"], 1600)
    held = read_tuning(one.bus, chain)
    assert held["Position P Gain"] == {1: 1600}
    found = joint_drives(chain, ["j0"], held)[0]
    assert found.stiffness == pytest.approx(2 * drive_of(servo()).stiffness, rel=0.01)
    weak = {"Present Input Voltage": {1: 111}}
    tired = joint_drives(chain, ["j0"], weak)[0]
    assert tired.stiffness == pytest.approx(drive_of(servo()).stiffness * 3.8 / 4.1)
    told = replace(chain, servos=(servo(**{"Position P Gain": 400}),))
    assert joint_drives(told, ["j0"], held)[0].stiffness == pytest.approx(found.stiffness / 4)


@pytest.mark.kernel
def test_nothing_jumps_when_the_torque_comes_on_and_when_the_first_setpoint_comes(
    stepped_arm, pendulum
):
    chain = chain_of(servo())
    arm = pendulum(1, 1.5, speed=4.0)
    one = stepped_arm(arm, chain, [0.7], full(chain, arm))
    with one.driver as driver:
        goal = one.virtual.servos[1].memory["Goal Position"]
        assert abs(goal - 2048 - 0.7 * 4096 / (2 * np.pi)) <= 1.0
        one.pass_time(1.0)
        hangs = one.virtual.q
        # it hangs by its weight: there a motion starts, and its first goal is the one it has
        assert driver.goal == pytest.approx(hangs, abs=0.3 * DEG)
        still = np.zeros(1)
        driver.write(JointSetpoint(t=0.0, q=driver.goal, qd=still, qdd=still))
        one.pass_time(0.5)
        assert abs(one.virtual.servos[1].memory["Goal Position"] - goal) <= 1
        assert one.virtual.q == pytest.approx(hangs, abs=0.1 * DEG)


@pytest.mark.kernel
def test_an_arm_with_feed_forward_keeps_the_promises_of_every_arm(stepped_arm, pendulum):
    chain = chain_of(servo())
    arm = pendulum(1, 0.8, speed=4.0)
    one = stepped_arm(arm, chain, [0.7], full(chain, arm))
    check_arm_driver(
        one.driver,
        wait=one.pass_time,
        is_holding=lambda: one.virtual.servos[1].torque_on,
    )


@pytest.mark.kernel
def test_a_goal_ahead_stays_within_what_the_servo_takes(stepped_arm, pendulum, caplog):
    ends = {"Min Position Limit": 1024, "Max Position Limit": 3072}
    chain = chain_of(servo(**ends))
    arm = pendulum(1, 1.0, speed=4.0)
    end = (3072 - 2048) / 4096 * 2 * np.pi
    limits = replace(arm.limits, q_min=np.array([-end]), q_max=np.array([end]))
    arm = replace(arm, limits=limits)

    def make(_):
        return ServoFeedforward.of(chain, ["j0"], constant(1.5))  # wants 4.5 deg more than there is

    one = stepped_arm(arm, chain, [1.3], make)
    with one.driver, caplog.at_level(logging.WARNING):
        one.rest(np.array([end]), 1.0)
        assert one.virtual.servos[1].memory["Goal Position"] == 3072
    assert caplog.text.count("beyond the last") == 1


@pytest.mark.kernel
@pytest.mark.parametrize("share", [0.7, 1.4])
def test_a_servo_that_is_not_as_strong_as_its_maker_says_still_follows_better(
    share, stepped_arm, pendulum
):
    chain = chain_of(servo())
    arm = pendulum(1, 1.0, speed=4.0)
    torque = Dynamics(arm).inverse
    [drive] = joint_drives(chain, ["j0"])
    wrong = replace(drive, stiffness=share * drive.stiffness, damping=share * drive.damping)

    def make(_):
        return ServoFeedforward([wrong], ["j0"], torque, latency=0.007)

    without = rms(tracking(stepped_arm(arm, chain, [0.7])))
    assert rms(tracking(stepped_arm(arm, chain, [0.7], make))) <= without / 2.0
