import time

import numpy as np
import pytest

pytestmark = pytest.mark.bus

TICK = 2 * np.pi / 4096


def test_the_watchdog_is_armed_while_setpoints_flow(open_arm, line, setpoint):
    with open_arm() as arm:
        assert line.servos[1]["Bus Watchdog"] == 0
        arm.write(setpoint(0.0, 0.0, 0.0))
        assert [servo["Bus Watchdog"] for servo in line.servos.values()] == [5, 5, 5, 5]
        written = len(line.written("Bus Watchdog"))
        arm.write(setpoint(0.0, 0.0, 0.0))
        arm.read()  # answered after what was written
        assert len(line.written("Bus Watchdog")) == written
        arm.hold()
        assert line.servos[1]["Bus Watchdog"] == 0
        arm.write(setpoint(0.0, 0.0, 0.0))
        assert line.servos[1]["Bus Watchdog"] == 5
    assert line.servos[1]["Bus Watchdog"] == 0


def test_a_servo_whose_watchdog_had_tripped_takes_goals_again(open_arm, line, setpoint):
    line.servos[1]["Bus Watchdog"] = 0xFF
    with open_arm(watchdog=0.04) as arm:
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
    with open_arm() as arm:
        line.deaf_to.add("Bus Watchdog")
        arm.write(setpoint(0.0, 0.0, 0.0))
        line.deaf_to.clear()
    assert "Bus Watchdog = 5 was not taken by waist, shoulder, elbow, shadow" in caplog.text
