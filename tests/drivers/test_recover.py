"""Servos that stopped themselves are brought back, one by one, and nothing else is touched."""

import numpy as np
import pytest

from splinearm.drivers.packets import Instruction
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusTimeoutError, ServoError

PULSE = 2 * np.pi / 4096
EVERYONE = (1, 2, 3, 4)


@pytest.fixture
def bus(make_chain, make_direct, in_their_time):
    made = make_direct(make_chain())
    in_their_time(made)
    return made


@pytest.fixture
def arm(bus, make_chain, make_limits):
    limits = make_limits()
    with ServoArm(make_chain(), limits.names, limits, bus) as made:
        yield made


def rebooted(bus) -> list[int]:
    return [p.servo_id for p in bus.sent if p.instruction == Instruction.REBOOT]


@pytest.mark.parametrize("servo_id", EVERYONE)
@pytest.mark.parametrize("cause", ["overload", "electrical shock", "overheating", "input voltage"])
def test_only_the_servo_concerned_is_rebooted_and_gets_all_back(bus, arm, servo_id, cause):
    victim = bus.servos[servo_id]
    before = dict(victim.memory.table)
    ram = ("Position P Gain", "Profile Velocity", "Status Return Level", "Bus Watchdog")
    kept = {name: victim.memory[name] for name in ram if name in before}
    others = [bus.servos[i] for i in EVERYONE if i != servo_id]
    held = True

    def look():
        nonlocal held
        # a shadow obeys its leader's id too, and starts anew with it
        held = held and all(s.torque_on for s in others if s.secondary_id != servo_id)

    bus.watch = look
    victim.fail(cause)
    victim.shut_down = True
    victim.release(cause)
    bus.sent.clear()
    faults = arm.recover()
    assert [(fault.servo.servo_id, fault.causes) for fault in faults] == [(servo_id, (cause,))]
    assert rebooted(bus) == [servo_id]
    assert held
    assert all(servo.torque_on for servo in bus.servos.values())
    assert {name: victim.memory[name] for name in kept} == kept
    assert victim.memory["Goal Position"] == pytest.approx(victim.position, abs=1)
    arm.read()


def test_a_leader_takes_its_shadow_along(bus, arm):
    bus.servos[2].fail("overload")
    arm.recover()
    assert bus.servos[2].torque_on
    assert bus.servos[3].torque_on
    assert bus.servos[3].memory["Goal Position"] == bus.servos[2].memory["Goal Position"]


def test_settings_of_the_file_are_there_again(bus, arm):
    bus.servos[2].fail("overload")
    assert bus.servos[2].memory["Position P Gain"] == 900
    arm.recover()
    assert bus.servos[2].memory["Position P Gain"] == 900


def test_a_servo_that_is_still_hot_is_not_rebooted(bus, arm):
    servo = bus.servos[4]
    servo.temperature = 73.0
    bus.sleep(0.1)
    with pytest.raises(ServoError, match=r"still at 7\d degC: let it cool down below 57 degC"):
        arm.recover()
    assert rebooted(bus) == []
    servo.temperature = 50.0
    arm.recover()
    assert servo.torque_on


def test_a_failed_encoder_is_for_a_person(bus, arm):
    bus.servos[1].fail("motor encoder")
    with pytest.raises(ServoError, match=r"encoder cannot be trusted.*power off and on"):
        arm.recover()
    assert rebooted(bus) == []


def test_a_supply_that_is_still_wrong_is_to_be_mended_first(bus, arm):
    servo = bus.servos[1]
    servo.voltage = 9.0
    bus.sleep(0.1)
    with pytest.raises(ServoError, match=r"supply is 9 V, outside 9.5 to 16 V"):
        arm.recover()
    assert rebooted(bus) == []
    servo.voltage = 12.0
    arm.recover()
    assert servo.memory["Hardware Error Status"] == 0


def test_an_illness_that_comes_back_is_said(bus, arm, monkeypatch):
    servo = bus.servos[1]
    begin_anew = servo.begin_anew

    def worse(*args, **more):
        begin_anew(*args, **more)
        servo.fail("overload")

    servo.begin_anew = worse
    servo.fail("overload")
    with pytest.raises(ServoError, match="overload"):
        arm.recover()
    assert not servo.torque_on
    servo.begin_anew = begin_anew
    arm.recover()
    assert servo.torque_on


def test_a_servo_that_started_anew_gets_its_settings_and_its_torque(bus, arm, setpoint):
    for _ in range(50):
        arm.write(setpoint(0.2, 0.1, -0.1))
        bus.sleep(0.01)
    arm.hold()
    for servo in bus.servos.values():
        servo.power_cycle()
    bus.sleep(0.5)
    assert arm.recover() == ()
    assert rebooted(bus) == []
    assert all(servo.torque_on for servo in bus.servos.values())
    assert bus.servos[2].memory["Position P Gain"] == 900
    np.testing.assert_allclose(arm.goal, [0.2, 0.1, -0.1], atol=0.02)


def test_a_released_arm_stays_released(bus, arm):
    arm.release()
    bus.servos[1].fail("overload")
    arm.recover()
    assert not any(servo.torque_on for servo in bus.servos.values())
    arm.hold()
    assert all(servo.torque_on for servo in bus.servos.values())


def test_a_servo_that_does_not_come_back_is_named(bus, arm):
    servo = bus.servos[4]
    begin_anew = servo.begin_anew

    def vanish(*args, **more):
        begin_anew(*args, **more)
        servo.unplugged = True

    servo.begin_anew = vanish
    servo.fail("overload")
    with pytest.raises(BusTimeoutError, match=r"servo 4 \(elbow\)"):
        arm.recover()
    assert bus.servos[1].torque_on


def multi_turn(make_chain, make_limits):
    return make_chain(settings={"Operating Mode": 4}), make_limits(-7.0, 7.0)


@pytest.mark.parametrize("q", [-6.5, -3.3, 0.2, 3.3, 6.9])
def test_a_joint_of_many_turns_is_where_it_was_after_a_reboot(
    q, make_chain, make_limits, make_direct, in_their_time
):
    chain, limits = multi_turn(make_chain, make_limits)
    bus = make_direct(chain)
    in_their_time(bus)
    narrow = make_limits()
    limits = type(limits)(
        names=limits.names,
        kinds=limits.kinds,
        q_min=np.array([-7.0, *narrow.q_min[1:]]),
        q_max=np.array([7.0, *narrow.q_max[1:]]),
        qd_max=limits.qd_max,
        qdd_max=limits.qdd_max,
    )
    bus.shafts["waist"].angle = q
    bus.servos[1].forget_turns()
    with pytest.raises(ServoError, match="which turn joint 'waist' is in cannot be told"):
        ServoArm(chain, limits.names, limits, bus).__enter__()
    with ServoArm(chain, limits.names, limits, bus, near=[q + 1.0, np.nan, np.nan]) as arm:
        assert arm.goal[0] == pytest.approx(q, abs=PULSE)
        bus.servos[1].fail("overload")
        arm.recover()
        assert arm.goal[0] == pytest.approx(q, abs=2 * PULSE)
        assert arm.read().q[0] == pytest.approx(q, abs=2 * PULSE)
        bus.servos[1].power_cycle()
        bus.sleep(0.5)
        with pytest.raises(ServoError, match="say about where it stands"):
            arm.recover()
        arm.recover(near=[q - 1.0, np.nan, np.nan])
        assert arm.goal[0] == pytest.approx(q, abs=2 * PULSE)
    with pytest.raises(ValueError, match="near: want 3 angles"):
        ServoArm(chain, limits.names, limits, bus, near=[q])
