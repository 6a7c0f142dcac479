from dataclasses import replace

import numpy as np
import pytest

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.model import servo_model, servo_models
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.sim.motor import (
    Motor,
    motor_of,
    motors_for,
    motors_from_chain,
    motors_from_limits,
    nominal_voltage,
    together,
)


def leader_and_shadow() -> ServoChain:
    def servo(name: str, number: int, role: ServoRole) -> ServoSpec:
        return ServoSpec(name=name, servo_id=number, model="XM430-W350", role=role, joint="j0")

    return ServoChain(
        servos=(servo("a", 1, ServoRole.LEADER), servo("b", 2, ServoRole.SHADOW)), baud=1_000_000
    )


@pytest.mark.parametrize(
    ("model", "voltage", "torque", "rpm"),
    [
        ("XM430-W350", 12.0, 4.1, 46),
        ("XM540-W270", 12.0, 10.6, 30),
        ("XL430-W250", 12.0, 1.5, 61),
        ("XL330-M288", 5.0, 0.52, 103),
        ("XL330-M077", 5.0, 0.215, 383),
    ],
)
def test_a_motor_has_the_figures_of_its_data_sheet_at_nominal_supply(model, voltage, torque, rpm):
    servo = servo_model(model)
    assert nominal_voltage(servo) == voltage
    assert motor_of(servo).stall_torque == torque
    assert motor_of(servo).no_load_speed == pytest.approx(rpm * 2.0 * np.pi / 60.0)


def test_a_model_with_a_continuous_torque_only_has_the_line_through_it():
    motor = motor_of(servo_model("PH42-020-S300"))
    rated = 29.2 * 2.0 * np.pi / 60.0
    assert motor.no_load_speed == pytest.approx(32.7 * 2.0 * np.pi / 60.0)
    assert motor.stall_torque * (1.0 - rated / motor.no_load_speed) == pytest.approx(5.1)
    assert nominal_voltage(servo_model("PH42-020-S300")) == 24.0


def test_a_model_whose_torque_is_not_published_is_refused():
    unknown = replace(servo_model("XM430-W350"), name="XM000", stall=())
    with pytest.raises(ValueError, match="XM000: its stall torque is not published"):
        motor_of(unknown)


def test_the_reflected_inertia_is_near_the_one_known_for_an_xm430():
    assert motor_of(servo_model("XM430-W350")).armature == pytest.approx(0.045, rel=0.1)


def test_every_published_motor_has_inertia_and_friction():
    motors = [motor_of(model) for model in servo_models() if model.stall]
    assert len(motors) >= 9
    assert all(m.armature > 0.0 and 0.0 < m.friction < 0.02 * m.stall_torque for m in motors)


@pytest.mark.parametrize("value", [0.0, -1.0, float("inf"), float("nan")])
def test_a_motor_without_torque_is_refused(value):
    with pytest.raises(ValueError, match="stall_torque: want a finite number above zero"):
        Motor(stall_torque=value, no_load_speed=1.0)


def test_two_motors_on_a_shaft_give_at_each_speed_what_both_give():
    a = Motor(stall_torque=4.0, no_load_speed=5.0, stall_current=2.0)
    b = Motor(stall_torque=1.5, no_load_speed=6.0, stall_current=1.0)
    both = together([a, b])
    for speed in (0.0, 1.0, 4.0):
        each = [m.stall_torque * (1.0 - speed / m.no_load_speed) for m in (a, b)]
        line = both.stall_torque * (1.0 - speed / both.no_load_speed)
        assert line == pytest.approx(sum(each))
    assert both.armature == pytest.approx(a.armature + b.armature)
    assert both.friction == pytest.approx(a.friction + b.friction)
    assert both.stall_current == 3.0


def test_a_current_that_one_motor_does_not_tell_is_not_known_for_both():
    a = Motor(stall_torque=4.0, no_load_speed=5.0, stall_current=2.0)
    assert together([a, Motor(stall_torque=1.0, no_load_speed=5.0)]).stall_current is None


def test_a_shadow_doubles_the_torque_of_its_joint():
    (motor,) = motors_from_chain(leader_and_shadow(), ("j0",))
    assert motor.stall_torque == pytest.approx(8.2)
    assert motor.no_load_speed == pytest.approx(46 * 2.0 * np.pi / 60.0)


def test_a_joint_that_no_servo_moves_is_named():
    with pytest.raises(ValueError, match="no servo moves joint 'j1'"):
        motors_from_chain(leader_and_shadow(), ("j0", "j1"))


def limits(torque: np.ndarray | None, kind: JointKind = JointKind.REVOLUTE) -> JointLimits:
    return JointLimits(
        names=("j0",),
        kinds=(kind,),
        q_min=np.array([-1.0]),
        q_max=np.array([1.0]),
        qd_max=np.array([2.0]),
        qdd_max=np.array([5.0]),
        torque_max=torque,
    )


def test_a_motor_known_by_its_limits_has_torque_left_at_its_top_speed():
    (motor,) = motors_from_limits(limits(np.array([3.0])))
    assert motor.stall_torque == 3.0
    assert motor.stall_torque * (1.0 - 2.0 / motor.no_load_speed) == pytest.approx(1.5)
    assert motor.stall_current is None


def test_limits_without_torque_give_no_motors():
    with pytest.raises(ValueError, match="set torque_max or name the servos"):
        motors_from_limits(limits(None))


def test_an_arm_takes_its_motors_from_its_servos_first():
    row = DHLink("j0", 0.1, 0.0, 0.0, 0.0)
    arm = Arm.from_dh("arm", [row], DHConvention.STANDARD, limits(np.array([3.0])))
    assert motors_for(arm, None)[0].stall_torque == 3.0
    assert motors_for(arm, leader_and_shadow())[0].stall_torque == pytest.approx(8.2)


def test_a_joint_that_slides_cannot_have_servos():
    row = DHLink("j0", 0.1, 0.0, 0.0, 0.0, JointKind.PRISMATIC)
    slide = limits(np.array([3.0]), JointKind.PRISMATIC)
    arm = Arm.from_dh("arm", [row], DHConvention.STANDARD, slide)
    assert motors_for(arm, None)[0].stall_torque == 3.0
    with pytest.raises(ValueError, match="joint 'j0' slides"):
        motors_for(arm, leader_and_shadow())
