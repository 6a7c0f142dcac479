"""Servos that get hot, hungry or tired are noticed while they move, at no cost worth a word."""

import logging

import numpy as np
import pytest

from splinearm.drivers.health_limit import HealthLimits, stall_current
from splinearm.drivers.model import servo_model, servo_models
from splinearm.drivers.packets import Instruction
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusTimeoutError, HealthError, ServoError

PERIOD = 0.01


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


def cycle(arm, bus, setpoint, count: int) -> None:
    """Read and write at 100 Hz."""
    for _ in range(count):
        arm.read()
        arm.write(setpoint(*arm.goal))
        bus.sleep(PERIOD)


def test_all_is_read_of_all_in_little_more_than_a_second(arm, bus, setpoint):
    cycle(arm, bus, setpoint, 110)
    for servo_id, reading in arm.health.items():
        servo = bus.servos[servo_id]
        assert reading.temperature == pytest.approx(servo.temperature, abs=1.5)
        assert reading.voltage == pytest.approx(servo.voltage, abs=0.1)
        assert bus.now - reading.t < 1.2
    assert arm.health[1].current == pytest.approx(0.0, abs=0.1)


def test_a_look_now_and_then_costs_no_third_transaction_in_most_cycles(arm, bus, setpoint):
    bus.sent.clear()
    cycle(arm, bus, setpoint, 100)
    looks = [packet for packet in bus.sent if packet.instruction == Instruction.SYNC_READ]
    assert len(bus.sent) - len(looks) <= 210  # two a cycle, and the watchdog
    assert len(looks) <= 15


def test_a_warm_servo_is_told_of_once(arm, bus, setpoint, caplog):
    bus.servos[4].temperature = 60.0
    cycle(arm, bus, setpoint, 300)
    told = [r.message for r in caplog.records if r.levelno == logging.WARNING]
    assert len(told) == 1
    assert "servo 4 (elbow): its temperature is 6" in told[0]
    assert "at 67 degC the arm stops; let it cool down" in told[0]


def test_a_hot_servo_stops_the_arm_before_it_stops_itself(arm, bus, setpoint):
    bus.servos[1].temperature = 77.0
    with pytest.raises(HealthError, match=r"joint 'waist': temperature 7\d degC is at") as caught:
        cycle(arm, bus, setpoint, 200)
    error = caught.value
    assert (error.joint, error.quantity, error.limit, error.unit) == (
        "waist",
        "temperature",
        75.0,
        "degC",
    )
    assert not error.alert
    assert bus.servos[1].torque_on
    cycle(arm, bus, setpoint, 200)  # raised once: while it stops the loop needs feedback
    arm.hold()
    with pytest.raises(HealthError):
        cycle(arm, bus, setpoint, 200)
    bus.servos[1].temperature = 40.0
    arm.hold()
    cycle(arm, bus, setpoint, 150)


@pytest.mark.parametrize(("volts", "words"), [(9.5, "at or below 9.5 V"), (16.0, "at or above 16")])
def test_a_supply_at_its_limits_stops_the_arm(arm, bus, setpoint, volts, words):
    bus.servos[2].voltage = volts
    with pytest.raises(HealthError, match=rf"supply .* V is {words}.*, where the arm stops"):
        cycle(arm, bus, setpoint, 200)


def test_a_servo_that_works_at_its_limit_for_long_stops_the_arm(arm, bus, setpoint):
    bus.servos[1].current_offset = 2.2  # of the 2.3 A at which it stalls
    with pytest.raises(HealthError, match=r"current 2\.\d+ A .*look for what blocks the joint"):
        cycle(arm, bus, setpoint, 400)


def test_a_short_effort_is_no_overload(arm, bus, setpoint):
    for _ in range(5):
        bus.servos[1].current_offset = 2.3
        cycle(arm, bus, setpoint, 10)
        bus.servos[1].current_offset = 0.0
        cycle(arm, bus, setpoint, 30)


def test_a_shadow_that_stops_itself_is_noticed_too(arm, bus, setpoint):
    bus.servos[3].fail("overload")
    with pytest.raises(ServoError, match=r"servo 3 \(shadow\).*overload") as caught:
        cycle(arm, bus, setpoint, 150)
    assert caught.value.alert


def test_a_servo_that_started_anew_is_noticed_and_told_again_after_a_hold(arm, bus, setpoint):
    bus.servos[1].power_cycle()
    with pytest.raises(BusTimeoutError):  # it is booting
        cycle(arm, bus, setpoint, 1)
    bus.sleep(0.5)
    with pytest.raises(ServoError, match=r"servo 1 \(waist\).*(has started anew|lost its torque)"):
        cycle(arm, bus, setpoint, 200)
    arm.hold()
    with pytest.raises(ServoError, match=r"servo 1"):
        cycle(arm, bus, setpoint, 1)
    arm.recover()
    cycle(arm, bus, setpoint, 150)


def test_a_shadow_that_falls_silent_is_named(arm, bus, setpoint):
    bus.servos[3].unplugged = True
    with pytest.raises(BusTimeoutError, match=r"servo 3 \(shadow\)"):
        cycle(arm, bus, setpoint, 150)
    bus.servos[3].unplugged = False
    cycle(arm, bus, setpoint, 150)


def test_a_lost_answer_is_no_trouble(arm, bus, setpoint):
    bus.servos[3].corrupt_replies = 2
    cycle(arm, bus, setpoint, 150)


@pytest.mark.parametrize("model", [m for m in servo_models() if "Homing Offset" in m.table])
def test_thresholds_follow_from_the_model(model):
    limits = HealthLimits().resolved(model, {})
    assert 45.0 <= limits.temperature_warn < limits.temperature_stop < 80.0
    assert limits.voltage_low_stop < limits.voltage_low_warn < limits.voltage_high_warn
    assert limits.voltage_high_warn < limits.voltage_high_stop
    if model.has_current and model.stall:
        assert 0.0 < limits.current_warn < limits.current_stop < stall_current(model, 12.0)
        assert np.isinf(limits.load_stop)
    elif not model.has_current:
        assert (limits.load_warn, limits.load_stop) == (0.7, 0.9)
        assert np.isinf(limits.current_stop)


def test_thresholds_of_the_file_and_of_the_registers_count_before_those_of_the_model():
    xm = servo_model("XM430-W350")
    assert HealthLimits().resolved(xm, {"Temperature Limit": 70}).temperature_stop == 65.0
    own = HealthLimits(temperature_stop=50.0).resolved(xm, {"Temperature Limit": 70})
    assert (own.temperature_warn, own.temperature_stop) == (50.0, 50.0)
    own = HealthLimits(temperature_warn=78.0).resolved(xm, {})
    assert (own.temperature_warn, own.temperature_stop) == (78.0, 78.0)
    own = HealthLimits(voltage_low_stop=11.0).resolved(xm, {})
    assert (own.voltage_low_warn, own.voltage_low_stop) == (11.0, 11.0)


def test_a_warning_after_the_stop_is_refused():
    with pytest.raises(ValueError, match="temperature_warn: want it below temperature_stop, 50"):
        HealthLimits(temperature_warn=60.0, temperature_stop=50.0)
    with pytest.raises(ValueError, match="voltage_low_warn: want it above"):
        HealthLimits(voltage_low_warn=9.0, voltage_low_stop=10.0)


def test_a_servo_that_comes_back_without_torque_is_noticed_at_once(arm, bus, setpoint):
    bus.servos[1].power_cycle()
    for _ in range(5):
        with pytest.raises(BusTimeoutError):
            arm.read()
    bus.sleep(0.5)
    with pytest.raises(ServoError, match=r"servo 1 \(waist\).*(has started anew|lost its torque)"):
        arm.read()
