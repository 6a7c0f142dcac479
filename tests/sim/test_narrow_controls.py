"""AX-12A and XL-320: small tables, two modes, 300 degrees."""

from dataclasses import replace
from math import radians, tau

import pytest

from splinearm.sim.narrow_controls import bits_of, signed_of
from splinearm.sim.rule import Refusal

NARROW = ["AX-12A", "XL320"]
TICK = radians(300.0) / 1024


@pytest.fixture(params=NARROW)
def small(request, make_bench):
    return make_bench(request.param, zero=None)


def wheel(bench) -> None:
    if "Control Mode" in bench.servo.memory:
        assert bench.set("Control Mode", 1) == 0
    else:
        assert bench.set("CW Angle Limit", 0) == bench.set("CCW Angle Limit", 0) == 0


@pytest.mark.parametrize("value", [-1023, -1, 0, 1, 512, 1023])
def test_ten_bits_and_a_direction_say_a_number(value):
    assert signed_of(bits_of(value)) == value


def test_what_does_not_fit_stops_at_the_end():
    assert (bits_of(5000.0), bits_of(-5000.0)) == (1023, 2047)


def test_it_goes_to_its_goal_over_300_degrees(small):
    assert small.get("Present Position") == 512
    small.set("Torque Enable", 1)
    small.set("Goal Position", 800)
    small.run(1.5)
    assert small.get("Present Position") == pytest.approx(800, abs=2)
    assert small.servo.shaft.angle == pytest.approx((800 - 512) * TICK, abs=2 * TICK)
    assert small.get("Moving") == 0


def test_moving_speed_is_its_speed_and_zero_is_as_fast_as_it_can(small):
    small.set("Torque Enable", 1)
    small.set("Moving Speed", 100)
    small.set("Goal Position", 800)
    small.run(1.0)
    assert small.get("Moving") == 1
    rpm = small.servo.shaft.speed / tau * 60
    assert rpm == pytest.approx(100 * 0.111, rel=0.1)
    assert signed_of(small.get("Present Speed")) == pytest.approx(100, abs=10)


def test_goal_and_speed_in_one_write_go_together(small):
    small.set("Torque Enable", 1)
    address = small.servo.memory.table["Goal Position"].address
    assert small.servo.write(address, (700).to_bytes(2, "little") + (50).to_bytes(2, "little")) == 0
    assert small.servo.law.settings.top_velocity == pytest.approx(50 * 0.111 / 60 * tau / TICK)
    assert small.servo.law.profile_ongoing


def test_in_wheel_mode_moving_speed_is_its_output_with_a_direction(small):
    wheel(small)
    small.set("Torque Enable", 1)
    small.run(0.2)
    assert small.servo.shaft.speed == 0.0
    small.set("Moving Speed", 512 | 0x400)
    small.run(1.0)
    assert small.servo.duty == pytest.approx(-512 / 1023)
    assert signed_of(small.get("Present Load")) == pytest.approx(-500, abs=1)
    assert small.get("Present Speed") & 0x400


def test_the_torque_limit_begins_at_max_torque_and_limits_the_output(make_bench):
    bench = make_bench("AX-12A", zero=None, Max_Torque=400)
    assert bench.get("Torque Limit") == 400
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 1000)
    bench.run(0.01)
    assert bench.servo.duty == pytest.approx(400 / 1023)


def test_a_goal_beyond_the_angle_limits_is_refused(small):
    small.set("CCW Angle Limit", 700)
    assert small.set("Goal Position", 701) == Refusal.DATA_LIMIT
    assert small.servo.error_byte_v1(Refusal.DATA_LIMIT) == 0x02
    assert small.set("Goal Position", 700) == Refusal.NONE
    assert small.set("Goal Position", 1024) == Refusal.DATA_RANGE
    assert small.servo.error_byte_v1(Refusal.DATA_RANGE) == 0x08


def test_beyond_its_range_it_reads_the_nearer_end(small):
    for degrees, position in ((149.9, 1023), (160.0, 1023), (-160.0, 0), (200.0, 0), (360.0, 512)):
        small.servo.shaft.angle = radians(degrees)
        assert small.get("Present Position") == pytest.approx(position, abs=1)


def test_an_ax_has_slack_on_either_side_of_its_goal(make_bench):
    bench = make_bench("AX-12A", zero=None)
    bench.set("CW Compliance Margin", 20)
    bench.set("CCW Compliance Margin", 20)
    bench.set("Torque Enable", 1)
    bench.servo.shaft.angle = 15 * TICK
    bench.run(0.1)
    assert bench.servo.duty == 0.0
    bench.servo.shaft.angle = 25 * TICK
    bench.run(0.001)
    assert bench.servo.duty < 0.0


def test_the_lock_of_an_ax_is_undone_by_a_loss_of_power_only(make_bench):
    bench = make_bench("AX-12A", zero=None)
    assert bench.set("Lock", 1) == 0
    assert bench.set("ID", 5) == Refusal.ACCESS
    assert bench.set("Lock", 0) == Refusal.DATA_RANGE
    bench.servo.power_cycle()
    assert bench.set("ID", 5) == Refusal.NONE


def test_an_ax_knows_no_reboot_and_takes_any_baud_code(make_bench):
    bench = make_bench("AX-12A", zero=None)
    assert bench.servo.reboot() == Refusal.INSTRUCTION
    assert bench.servo.error_byte_v1(Refusal.INSTRUCTION) == 0x40
    assert bench.set("Baud Rate", 9) == 0
    assert bench.servo.baud == 200_000
    assert bench.set("Baud Rate", 10) == 0
    assert bench.servo.baud == 181_818
    assert bench.servo.protocol == 1
    assert bench.servo.clear(b"\x01\x44\x58\x4c\x22") == Refusal.INSTRUCTION


def test_a_reg_write_shows_in_registered(small):
    address = small.servo.memory.table["LED"].address
    assert small.servo.reg_write(address, b"\x01") == 0
    name = "Registered" if "Registered" in small.servo.memory else "Registered Instruction"
    assert small.get(name) == 1
    small.servo.action()
    assert (small.get(name), small.get("LED")) == (0, 1)


def test_its_goal_switches_the_torque_on_by_choice_only(small):
    small.set("Goal Position", 600)
    assert small.get("Torque Enable") == 0
    small.servo.choices = replace(small.servo.choices, torque_on_by_goal=True)
    small.set("Goal Position", 600)
    assert small.get("Torque Enable") == 1
