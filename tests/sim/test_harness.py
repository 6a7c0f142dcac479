"""Cables and power of a virtual bus, and servos fresh out of the box."""

import pytest

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.drivers.bus import PingReply
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.sim.choice import Choices
from splinearm.sim.virtual_bus import VirtualBus


@pytest.fixture
def fresh():
    cell = load_cell("koch_v1_1")
    home = cell.poses["home"]
    with VirtualBus(cell.arm, centred(cell.chain), home, fresh=True) as bus:
        for servo in bus.all_servos:
            servo.choices = Choices(boot_time=0.0)
        yield bus


@pytest.mark.bus
def test_a_servo_fresh_out_of_the_box_has_id_1_at_57600_baud_once_it_is_connected(fresh):
    assert fresh.harness.connected == ()
    with DynamixelBus(fresh.port, 57_600) as line:
        assert line.scan() == ()
        fresh.harness.connect("shoulder_lift")
        assert line.scan() == (PingReply(1, 1060, 53, 2),)
    servo = fresh.all_servos[1]
    assert servo.memory["Return Delay Time"] == 250
    assert servo.memory["Operating Mode"] == 3
    assert fresh.changes == 0


@pytest.mark.bus
def test_two_of_one_id_spoil_each_other_s_answers(fresh):
    fresh.harness.connect("shoulder_pan", "elbow_flex")
    with DynamixelBus(fresh.port, 57_600) as line:
        assert line.scan() == ()
        fresh.harness.disconnect("elbow_flex")
        assert len(line.scan()) == 1


@pytest.mark.bus
def test_without_power_there_is_neither_voice_nor_torque_and_ram_begins_anew(fresh):
    fresh.harness.connect("gripper")
    servo = fresh.all_servos[5]
    table = servo.model.table
    with DynamixelBus(fresh.port, 57_600) as line:
        line.write(1, table["Profile Velocity"], 30)
        line.write(1, table["Torque Enable"], 1)
        fresh.harness.power(on=False)
        assert not servo.torque_on
        assert line.scan() == ()
        fresh.harness.power(on=True)
        assert len(line.scan()) == 1
        assert line.read(1, table["Profile Velocity"]) == 0
    assert fresh.changes == 2


def test_a_servo_that_there_is_not_is_refused(fresh):
    with pytest.raises(ValueError, match="no servo 'nose'; there are shoulder_pan, shoulder_lift"):
        fresh.harness.connect("nose")
