import time
from dataclasses import replace

import numpy as np
import pytest

from splinearm.drivers.cyclic import GroupWrite
from splinearm.drivers.servo_arm import ServoArm
from splinearm.sim.choice import TripStop

pytestmark = pytest.mark.bus

TICK = 2 * np.pi / 4096
SHORT = 0.012  # margin at which the watchdog is as short as it is by itself, s


def test_the_watchdog_is_armed_while_setpoints_flow(open_arm, line, setpoint):
    with open_arm(margin=SHORT) as arm:
        assert line.servos[1]["Bus Watchdog"] == 0
        arm.write(setpoint(0.0, 0.0, 0.0))
        assert [servo["Bus Watchdog"] for servo in line.servos.values()] == [2, 2, 2, 2]
        written = len(line.written("Bus Watchdog"))
        arm.write(setpoint(0.0, 0.0, 0.0))
        arm.read()  # answered after what was written
        assert len(line.written("Bus Watchdog")) == written
        arm.hold()
        assert line.servos[1]["Bus Watchdog"] == 0
        arm.write(setpoint(0.0, 0.0, 0.0))
        assert line.servos[1]["Bus Watchdog"] == 2
    assert line.servos[1]["Bus Watchdog"] == 0


def test_a_servo_whose_watchdog_had_tripped_takes_goals_again(open_arm, line, setpoint):
    line.servos[1]["Bus Watchdog"] = 0xFF
    with open_arm(margin=SHORT, watchdog=0.04) as arm:
        arm.write(setpoint(0.0, 0.0, 0.0))
        line.servos[1]["Bus Watchdog"] = 0xFF
        time.sleep(0.05)  # the silence that trips it
        arm.write(setpoint(100 * TICK, 0.0, 0.0))
        assert line.servos[1]["Goal Position"] == 2148
        assert line.servos[1]["Bus Watchdog"] == 2
        assert arm.watchdog_trips == 1


def test_without_a_watchdog_none_is_armed(open_arm, line, setpoint):
    with open_arm(watchdog=None) as arm:
        arm.write(setpoint(0.0, 0.0, 0.0))
        arm.read()  # answered after what was written
        assert {value for _, value in line.written("Bus Watchdog")} == {0}
    with pytest.raises(ValueError, match=r"2.54 s or None, got 3.0"):
        open_arm(watchdog=3.0)


def test_a_servo_that_does_not_take_the_watchdog_is_told(open_arm, line, setpoint, caplog):
    with open_arm(margin=SHORT) as arm:
        line.deaf_to.add("Bus Watchdog")
        arm.write(setpoint(0.0, 0.0, 0.0))
        line.deaf_to.clear()
    assert "Bus Watchdog = 2 was not taken by waist, shoulder, elbow, shadow" in caplog.text


def test_a_silence_before_a_read_is_a_silence(open_arm, line, setpoint):
    with open_arm(margin=SHORT) as arm:
        arm.write(setpoint(0.0, 0.0, 0.0))
        line.servos[1]["Bus Watchdog"] = 0xFF
        time.sleep(0.05)
        arm.read()  # a loop reads first, and only then writes
        arm.write(setpoint(100 * TICK, 0.0, 0.0))
        assert line.servos[1]["Goal Position"] == 2148
        assert arm.watchdog_trips == 1


def test_hold_after_a_silence_stays_where_the_servos_were_stopped(open_arm, line, setpoint):
    with open_arm(margin=SHORT) as arm:
        arm.write(setpoint(200 * TICK, 0.0, 0.0))
        servo = line.servos[1]
        servo.stuck, servo["Present Position"], servo["Bus Watchdog"] = True, 2200, 0xFF
        time.sleep(0.05)
        arm.hold()
        arm.read()  # answered after what was written
        assert servo["Goal Position"] == 2200
        assert arm.goal[0] == pytest.approx(152 * TICK)


def test_where_a_lost_answer_is_waited_for_long_the_watchdog_is_longer(open_arm, line, setpoint):
    with open_arm(margin=0.05) as arm:
        arm.write(setpoint(0.0, 0.0, 0.0))
        assert line.servos[1]["Bus Watchdog"] == 8


@pytest.mark.parametrize("how", list(TripStop))
def test_however_a_servo_stops_it_takes_goals_again(
    how, make_chain, make_limits, make_direct, in_their_time, setpoint
):
    bus, limits = make_direct(make_chain()), make_limits()
    in_their_time(bus)
    with ServoArm(make_chain(), limits.names, limits, bus) as arm:
        for servo in bus.servos.values():
            servo.choices = replace(servo.choices, on_trip=how)
        for k in range(20):
            arm.read()
            arm.write(setpoint(*(0.005 * k,) * 3))
            bus.sleep(0.01)
        bus.sleep(0.06)
        assert all(servo.memory["Bus Watchdog"] == 0xFF for servo in bus.servos.values())
        goals = [servo.memory["Goal Position"] for servo in bus.servos.values()]
        bus.sync_write(GroupWrite([(1, bus.servos[1].model.table["Goal Position"])]), [2000])
        assert [servo.memory["Goal Position"] for servo in bus.servos.values()] == goals  # closed
        arm.read()
        arm.write(setpoint(0.1, 0.1, 0.1))
        assert arm.watchdog_trips == 4
        bus.sleep(0.03)
        arm.read()
        assert all(servo.memory["Bus Watchdog"] == 2 for servo in bus.servos.values())
        assert bus.servos[1].memory["Goal Position"] == round(2048 + 0.1 / TICK)


def test_an_offset_by_which_a_stopped_servo_may_move_is_told(open_arm, line, make_chain, caplog):
    line.servos[1]["Homing Offset"] = 100
    with open_arm(make_chain(settings={"Homing Offset": 100})):
        pass
    assert "servo 1 (waist): with a Homing Offset of 100 in position mode" in caplog.text
