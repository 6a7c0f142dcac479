import pytest

from splinearm.drivers.packets import Instruction
from splinearm.errors import BusTimeoutError, ServoError

pytestmark = pytest.mark.bus

SHORT = 0.02  # margin where an answer is not to come, s


@pytest.mark.parametrize("servo_id", [1, 2, 4])
def test_a_leader_that_does_not_answer_is_named(open_arm, line, servo_id):
    line.silent.add(servo_id)
    name = {1: "waist", 2: "shoulder", 4: "elbow"}[servo_id]
    with pytest.raises(BusTimeoutError, match=rf"servo {servo_id} \({name}\)"), open_arm():
        pass
    assert line.written("Torque Enable") == []


def test_a_shadow_that_does_not_answer_is_refused_too(open_arm, line):
    line.silent.add(3)
    with pytest.raises(BusTimeoutError, match=r"servo 3 \(shadow\) does not answer"):
        open_arm().__enter__()
    assert line.written("Torque Enable") == []


def test_a_servo_of_another_model_is_refused(open_arm, make_chain):
    with pytest.raises(ServoError, match="found a XM430-W350, wanted a XL430-W250"):
        open_arm(make_chain(model="XL430-W250")).__enter__()


@pytest.mark.parametrize(
    ("servo_id", "register", "value"),
    [
        (1, "Drive Mode", 1),
        (1, "Operating Mode", 4),
        (2, "Homing Offset", -50),
        (2, "Secondary(Shadow) ID", 1),
        (3, "Drive Mode", 0),
    ],
)
def test_a_servo_that_is_set_otherwise_is_refused(open_arm, line, servo_id, register, value):
    line.servos[servo_id][register] = value
    with pytest.raises(ServoError, match=f"{value}, wanted") as caught, open_arm():
        pass
    assert caught.value.servo_id == servo_id
    assert register in caught.value.reason
    assert line.written("Goal Position") == []


def test_other_settings_that_differ_are_told(open_arm, line, caplog):
    line.servos[2]["Velocity Limit"] = 131
    with open_arm():
        pass
    assert "servo 2 (shoulder): Velocity Limit is 131, the arm's file says 200" in caplog.text


def test_settings_of_the_ram_are_written(open_arm, line):
    line.servos[1]["Profile Velocity"] = 30
    with open_arm():
        assert line.servos[1]["Profile Velocity"] == 0
        assert line.servos[2]["Position P Gain"] == 900


def test_a_servo_told_not_to_answer_is_told_to_answer(open_arm, line):
    line.servos[1]["Status Return Level"] = 0
    with open_arm():
        assert line.servos[1]["Status Return Level"] == 2


def test_a_latched_error_is_named_with_what_helps(open_arm, line):
    line.servos[4]["Hardware Error Status"] = 0x24
    with (
        pytest.raises(ServoError, match=r"overheating and overload .*reboot") as caught,
        open_arm(),
    ):
        pass
    assert caught.value.alert
    assert line.written("Torque Enable") == []


def test_an_uncalibrated_joint_is_refused_before_anything_is_sent(open_arm, make_chain, line):
    with pytest.raises(ServoError, match="splinearm calibrate"):
        open_arm(make_chain(zero_ticks=None)).__enter__()
    assert line.instructions == []


def test_lost_answers_are_asked_for_again(open_arm, line):
    line.drops = 2  # both to the first ping
    with open_arm() as arm:
        line.drops = 1
        assert arm.roll[1].servo_id == 1
        arm.hold()
    assert all(servo["Torque Enable"] for servo in line.servos.values())


def test_a_servo_of_an_unknown_model_is_refused_by_its_number(open_arm, line):
    line.servos[1]["Model Number"] = 4711
    with pytest.raises(ServoError, match="found a model number 4711"):
        open_arm().__enter__()


def test_a_servo_that_falls_silent_on_the_way_is_named_with_the_register(open_arm, line):
    line.mute.add((2, Instruction.SYNC_READ))
    with pytest.raises(BusTimeoutError, match=r"servo 2 \(shoulder\) .*Drive Mode"):
        open_arm(margin=SHORT).__enter__()
