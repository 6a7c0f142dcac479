"""Servos on an arm, brought up to a time that the test gives."""

from math import inf, tau

import numpy as np
import pytest

from splinearm.sim.choice import Choices
from splinearm.sim.motor import motor_of
from splinearm.sim.plant import ArmPlant, Drive
from splinearm.sim.rig import QUIET_TIME, Rig
from splinearm.sim.shaft import Shaft
from splinearm.sim.virtual_servo import VirtualServo

pytestmark = pytest.mark.sim

TORQUE, GOAL, WATCHDOG = 64, 116, 98


def rig_of(arm, chain, q_start, **options):
    shafts = [Shaft() for _ in chain.servos]
    drives = [
        Drive(spec.joint, motor_of(spec.servo_model), shaft)
        for spec, shaft in zip(chain.servos, shafts, strict=True)
    ]
    plant = ArmPlant(arm, drives, np.asarray(q_start, dtype=float))
    servos = [
        VirtualServo.of(spec, chain.baud, shaft)
        for spec, shaft in zip(chain.servos, shafts, strict=True)
    ]
    return Rig(servos, [plant], **options), servos, plant


@pytest.fixture
def flat(make_arm, make_chain):
    return rig_of(make_arm(2), make_chain(2), [0.5, -0.5])


@pytest.fixture
def upright(make_arm, make_chain):
    return rig_of(make_arm(2, upright=True), make_chain(2), [0.5, -0.5])


def hold(servos) -> None:
    for servo in servos:
        servo.write(TORQUE, b"\x01")


def test_servos_hold_the_arm_and_let_it_fall(upright):
    rig, servos, plant = upright
    hold(servos)
    rig.advance_to(1.0)
    assert plant.q == pytest.approx([0.5, -0.5], abs=0.15)  # it droops, as servos do
    for servo in servos:
        servo.write(TORQUE, b"\x00")
    rig.wake()
    rig.advance_to(1.5)
    assert plant.q[0] < 0.0


def test_goals_move_joints(flat):
    rig, servos, plant = flat
    hold(servos)
    for servo, q in zip(servos, (-0.4, 0.9), strict=True):
        servo.write(GOAL, round(2048 + q * 4096 / tau).to_bytes(4, "little"))
    rig.advance_to(2.0)
    assert plant.q == pytest.approx([-0.4, 0.9], abs=0.01)


def test_an_arm_at_rest_is_not_stepped(flat):
    rig, servos, _ = flat
    hold(servos)
    rig.advance_to(QUIET_TIME + 0.1)
    assert rig.asleep
    rig.advance_to(1e6)  # or this would take hours
    assert rig.now == pytest.approx(1e6)
    assert servos[0].now == pytest.approx(1e6)


def test_a_falling_arm_is_stepped(upright):
    rig, _, _ = upright
    rig.advance_to(QUIET_TIME + 0.1)
    assert not rig.asleep


def test_held_the_arm_falls_only_after_its_torque_was_on(make_arm, make_chain):
    arm, chain = make_arm(2, upright=True), make_chain(2)
    rig, servos, plant = rig_of(arm, chain, [0.5, -0.5], held=True)
    rig.advance_to(3.0)
    assert plant.q.tolist() == [0.5, -0.5]
    hold(servos)
    rig.advance_to(3.5)
    for servo in servos:
        servo.write(TORQUE, b"\x00")
    rig.wake()
    rig.advance_to(4.0)
    assert plant.q[0] < 0.3


def test_woken_it_goes_on_where_it_was(flat):
    rig, servos, plant = flat
    hold(servos)
    rig.advance_to(100.0)
    servos[0].write(GOAL, (2048).to_bytes(4, "little"))
    rig.wake()
    rig.advance_to(101.5)
    assert plant.q[0] == pytest.approx(0.0, abs=0.01)
    assert rig.now == pytest.approx(101.5)


def test_a_watchdog_trips_while_the_arm_is_at_rest(flat):
    rig, servos, _ = flat
    hold(servos)
    servos[1].write(WATCHDOG, b"\x64")
    rig.advance_to(1.0)
    assert rig.asleep
    rig.advance_to(1.9)
    assert not servos[1].tripped
    rig.advance_to(2.2)
    assert servos[1].tripped


def test_a_fault_at_rest_lets_the_arm_fall(upright):
    rig, servos, plant = upright
    hold(servos)
    rig.advance_to(5.0)
    assert rig.asleep
    for servo in servos:
        servo.hardware_error(0x20)
    rig.advance_to(5.001)
    rig.advance_to(5.5)
    assert plant.q[0] < 0.0


def test_time_never_goes_back(flat):
    rig, _, _ = flat
    rig.advance_to(0.2)
    rig.advance_to(0.1)
    assert rig.now == pytest.approx(0.2)


def test_a_servo_that_still_sums_up_an_error_is_not_at_rest(make_arm, make_chain):
    # so slow that friction holds it for a while before the integral breaks it loose
    chain = make_chain(1, **{"Operating Mode": 1, "Velocity P Gain": 1, "Velocity I Gain": 20})
    rig, servos, plant = rig_of(make_arm(1), chain, [0.0])
    hold(servos)
    servos[0].write(104, (3).to_bytes(4, "little"))
    rig.advance_to(30.0)
    assert plant.q[0] > 0.1


def test_a_servo_stuck_at_a_stop_is_at_rest(make_arm, make_chain):
    rig, servos, _ = rig_of(make_arm(1), make_chain(1, **{"Operating Mode": 1}), [2.8])
    servos[0].choices = Choices(overload_time=inf)
    hold(servos)
    servos[0].write(104, (30).to_bytes(4, "little"))
    rig.advance_to(10.0)
    assert rig.asleep
    assert servos[0].value("Present PWM") == 885


def test_what_is_done_to_a_servo_by_hand_wakes_the_rig(flat):
    rig, servos, plant = flat
    hold(servos)
    rig.advance_to(1.0)
    assert rig.asleep
    servos[0].slip(0.2)
    rig.advance_to(2.0)
    assert plant.q[0] == pytest.approx(0.3, abs=0.01)


def test_an_arm_at_rest_under_load_is_overloaded_in_its_time(upright):
    rig, servos, _ = upright
    for servo in servos:
        servo.choices = Choices(overload_share=0.05, overload_time=5.0)
    hold(servos)
    for k in range(100):
        rig.advance_to(0.1 * k)
    assert any(servo.alarms == 0x20 for servo in servos)
