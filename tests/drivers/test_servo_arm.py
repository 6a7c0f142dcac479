import logging

import numpy as np
import pytest

from splinearm.drivers.conformance import check_arm_driver
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusTimeoutError, LimitError, PortError
from splinearm.units import DEG

pytestmark = pytest.mark.bus

SHORT = 0.02  # margin where an answer is not to come, s
TICK = 2 * np.pi / 4096


def test_the_arm_passes_what_every_arm_must(open_arm, line):
    def torque():
        return all(servo["Torque Enable"] == 1 for servo in line.servos.values())

    check_arm_driver(open_arm(), settle=0.1, is_holding=torque)


def test_a_setpoint_becomes_goals_of_leaders_in_one_packet(open_arm, line, setpoint):
    with open_arm() as arm:
        before = len(line.writes)
        arm.write(setpoint(100 * TICK, -100 * TICK, 0.0))
        arm.read()  # answered after what was written
        goals = [entry for entry in line.writes[before:] if entry[1] == "Goal Position"]
    assert goals == [
        (1, "Goal Position", 2148),
        (2, "Goal Position", 1948),
        (3, "Goal Position", 1948),
        (4, "Goal Position", 2048),
    ]


def test_a_setpoint_outside_the_limits_never_leaves(open_arm, line, setpoint):
    with open_arm() as arm:
        arm.read()  # answered after what was written
        before = len(line.instructions)
        with pytest.raises(LimitError, match=r"'elbow': position 91.67.* deg is above .*t = 1.5"):
            arm.write(setpoint(0.0, 0.0, 1.6, t=1.5))
        with pytest.raises(ValueError, match="want 3 joints"):
            arm.write(setpoint(0.0, 0.0))
        assert len(line.instructions) == before


def test_hold_keeps_near_goals_and_gives_up_far_ones(open_arm, line, setpoint):
    with open_arm() as arm:
        arm.write(setpoint(0.5, 0.5, 0.5))
        arm.read()  # answered after what was written
        goal = line.servos[1]["Goal Position"]
        for servo in line.servos.values():
            servo.stuck = True
        line.servos[1]["Present Position"] = goal - 20  # it hangs
        line.servos[4]["Present Position"] = goal - 200  # it is blocked
        arm.hold()
        arm.read()  # answered after what was written
        assert line.servos[1]["Goal Position"] == goal
        assert line.servos[4]["Goal Position"] == goal - 200
        assert arm.goal == pytest.approx([0.5, 0.5, 0.5 - 200 * TICK], abs=TICK)


def test_hold_does_without_a_servo_that_is_lost(open_arm, line, setpoint):
    with open_arm(margin=SHORT) as arm:
        arm.write(setpoint(0.1, 0.1, 0.1))
        line.silent.add(2)
        arm.hold()
        line.silent.clear()
        arm.read()  # answered after what was written
        assert line.servos[1]["Goal Position"] == 2048 + round(0.1 / TICK)


@pytest.mark.parametrize("error", [ValueError("a bug"), KeyboardInterrupt()])
def test_an_exception_keeps_the_torque_and_comes_through(open_arm, line, error, setpoint):
    def fail(arm):
        arm.write(setpoint(0.1, 0.0, 0.0))
        raise error

    with pytest.raises(type(error)), open_arm() as arm:
        fail(arm)
    assert line.written("Torque Enable") == [(i, 1) for i in (1, 2, 3, 4, 3)]
    assert all(servo["Bus Watchdog"] == 0 for servo in line.servos.values())


def test_a_lost_port_on_the_way_out_does_not_mask_the_first_error(open_arm, line, caplog):
    def fail(arm):
        arm.read()
        line.vanish()
        raise ValueError("a bug")

    with pytest.raises(ValueError, match="a bug"), open_arm() as arm:
        fail(arm)
    assert "could not be told to hold" in caplog.text


def test_a_lost_port_on_the_way_out_is_an_error_of_its_own(open_arm, line):
    with pytest.raises(PortError), open_arm():
        line.vanish()


def test_release_takes_the_torque_away_and_leaving_does_not_bring_it_back(open_arm, line, setpoint):
    with open_arm() as arm:
        arm.release()
        assert not any(servo["Torque Enable"] for servo in line.servos.values())
        arm.read()
        with pytest.raises(RuntimeError, match="torque is off"):
            arm.write(setpoint(0.0, 0.0, 0.0))
    assert not any(servo["Torque Enable"] for servo in line.servos.values())


def test_release_tells_everyone_even_if_one_does_not_answer(open_arm, line):
    with open_arm(margin=SHORT) as arm:
        line.silent.add(1)
        with pytest.raises(BusTimeoutError, match="servo 1"):
            arm.release()
        assert [line.servos[i]["Torque Enable"] for i in (1, 2, 3, 4)] == [1, 0, 0, 0]


def test_what_does_not_fit_together_is_refused(line, make_chain, make_limits):
    limits = make_limits()
    with DynamixelBus(line.port) as bus:
        with pytest.raises(ValueError, match="limits"):
            ServoArm(make_chain(), ("waist",), limits, bus)
        with pytest.raises(ValueError, match="hold_tolerance"):
            ServoArm(make_chain(), limits.names, limits, bus, hold_tolerance=0.0)
        arm = ServoArm(make_chain(), limits.names, limits, bus)
        with pytest.raises(RuntimeError, match="with-block"):
            arm.read()


def test_an_arm_that_could_not_be_entered_gives_its_port_back(open_arm, line):
    line.silent.add(1)
    with pytest.raises(BusTimeoutError):
        open_arm().__enter__()
    DynamixelBus(line.port).close()


def test_nothing_is_logged_when_all_is_well(open_arm, caplog, setpoint):
    caplog.set_level(logging.WARNING)
    with open_arm() as arm:
        arm.write(setpoint(1 * DEG, 0.0, 0.0))
        arm.read()
    assert caplog.text == ""
