"""``splinearm recover``, on virtual servos."""

import pytest

from splinearm.backends import centred
from splinearm.cli.main import main
from splinearm.config import load_cell
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus


@pytest.fixture
def bus():
    cell = load_cell("wx250s")
    with VirtualBus(cell.arm, centred(cell.chain), cell.poses["home"], transport="socket") as made:
        yield made


def recover(bus, *more: str) -> int:
    return main(["recover", "wx250s", "--port", bus.port, *more])


def test_an_arm_that_is_well_is_told_so_and_holds(bus, capsys):
    assert recover(bus, "--look") == 0
    assert not any(servo.torque_on for servo in bus.all_servos)
    assert recover(bus) == 0
    said = capsys.readouterr().out
    assert "no servo reports a hardware error" in said
    assert "the arm holds at" in said
    assert all(servo.torque_on for servo in bus.all_servos if servo.servo_id < 9)


def test_servos_that_stopped_themselves_are_named_and_come_back(bus, capsys):
    with bus.lock:
        bus.servos[4].fail("overload")
        bus.servos[9].fail("overload")
    assert recover(bus, "--look") == 2
    said = capsys.readouterr().out
    assert "servo 4 (elbow) at joint 'elbow': overload" in said
    assert "servo 9 (gripper) at the gripper: overload" in said
    assert bus.servos[4].memory["Hardware Error Status"]
    assert recover(bus) == 0
    assert "gripper: rebooted; its torque stays off" in capsys.readouterr().out
    assert bus.servos[4].torque_on
    assert bus.servos[4].memory["Hardware Error Status"] == 0
    assert not bus.servos[9].torque_on


def test_one_that_is_still_hot_is_refused_with_what_helps(bus, capsys):
    with bus.lock:
        bus.servos[4].temperature = 90.0
        bus.servos[4].fail("overheating")
    assert recover(bus) == 2
    assert "let it cool down below 65 degC" in capsys.readouterr().err
    assert not bus.servos[4].torque_on
