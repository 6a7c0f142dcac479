"""What a servo does with its registers over time, on a bench with a clock that is stepped."""

from dataclasses import replace
from math import pi, tau

import pytest

from splinearm.drivers.model import servo_models
from splinearm.sim.rule import Refusal

RPM_UNIT = 0.229


def moved(bench) -> int:
    return abs(bench.servo.position - 2048)


@pytest.mark.parametrize("model", [m.name for m in servo_models() if "Goal PWM" in m.table])
def test_every_model_with_modes_goes_to_its_goal(make_bench, model):
    bench = make_bench(model, zero=None)
    goal = bench.servo.model.centre + bench.servo.model.pulses // 9
    assert bench.set("Torque Enable", 1) == 0
    assert bench.set("Goal Position", goal) == 0
    bench.run(1.5)
    tick = bench.servo.model.pulses / 4096
    assert bench.get("Present Position") == pytest.approx(goal, abs=4 * tick)
    assert bench.get("Moving") == 0


def test_with_the_torque_off_a_goal_moves_nothing(bench):
    assert bench.set("Goal Position", 3000) == 0
    bench.run(0.2)
    assert moved(bench) == 0


def test_a_goal_from_before_is_run_to_when_the_torque_comes_on(bench):
    bench.set("Goal Position", 2300)
    bench.set("Torque Enable", 1)
    bench.run(1.0)
    assert bench.servo.position == pytest.approx(2300, abs=4)


def test_by_choice_the_present_position_is_the_goal_when_the_torque_comes_on(bench):
    bench.servo.choices = replace(bench.servo.choices, goal_survives_torque_off=False)
    bench.set("Goal Position", 2300)
    bench.set("Torque Enable", 1)
    bench.run(0.5)
    assert bench.servo.position == 2048


def test_a_fresh_servo_holds_where_it_is_when_the_torque_comes_on(make_bench):
    bench = make_bench(angle=0.7)
    bench.set("Torque Enable", 1)
    bench.run(0.5)
    assert bench.servo.shaft.angle == pytest.approx(0.7, abs=1e-3)


def test_torque_off_lets_the_shaft_go(bench):
    bench.set("Torque Enable", 1)
    bench.run(0.01)
    assert bench.servo.shaft.duty is not None
    bench.set("Torque Enable", 0)
    bench.run(0.001)
    assert bench.servo.shaft.duty is None


# profiles


def test_a_profile_keeps_to_its_velocity(bench):
    bench.set("Profile Velocity", 50)
    bench.set("Profile Acceleration", 40)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 3600)
    bench.run(0.6)
    assert bench.get("Velocity Trajectory") == 50
    assert bench.get("Moving Status") == 0x32  # trapezoidal, ongoing
    assert bench.get("Present Velocity") == pytest.approx(50, abs=4)
    assert bench.get("Moving") == 1
    bench.run(3.0)
    assert bench.get("Moving Status") & 0x0B == 0x01  # arrived, nothing ongoing
    assert bench.get("Position Trajectory") == 3600


def test_a_time_based_profile_takes_its_time(make_bench):
    bench = make_bench(Drive_Mode=4)
    bench.set("Profile Velocity", 800)
    bench.set("Profile Acceleration", 200)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 3000)
    bench.run(0.79)
    assert bench.get("Moving Status") & 0x02
    bench.run(0.02)
    assert not bench.get("Moving Status") & 0x02
    assert bench.get("Position Trajectory") == 3000


def test_the_profile_is_never_faster_than_the_velocity_limit(make_bench):
    bench = make_bench(Velocity_Limit=30)
    bench.set("Profile Velocity", 100)
    bench.set("Profile Acceleration", 1000)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 3600)
    bench.run(0.3)
    assert bench.get("Velocity Trajectory") == 30


# modes


def test_velocity_mode_turns_at_its_goal(make_bench):
    bench = make_bench(Operating_Mode=1)
    bench.set("Torque Enable", 1)
    bench.set("Goal Velocity", -60)
    bench.run(2.0)
    assert bench.get("Present Velocity") == pytest.approx(-60, abs=2)
    rpm = -bench.servo.shaft.speed / tau * 60
    assert rpm == pytest.approx(60 * RPM_UNIT, rel=0.05)


def test_pwm_mode_drives_with_its_goal(make_bench):
    bench = make_bench(Operating_Mode=16)
    bench.set("Torque Enable", 1)
    bench.run(0.1)
    assert moved(bench) == 0  # the goal begins at 0
    bench.set("Goal PWM", 442)
    bench.run(1.0)
    assert bench.get("Present PWM") == 442
    assert bench.servo.shaft.speed == pytest.approx(46 / 60 * tau * 0.5, rel=0.05)


def test_current_mode_pulls_with_its_goal(make_bench):
    bench = make_bench(Operating_Mode=0)
    bench.set("Torque Enable", 1)
    bench.set("Goal Current", 100)
    bench.run(0.01)
    assert bench.get("Present Current") == pytest.approx(100, abs=2)


def test_current_based_position_mode_goes_gently(make_bench):
    bench = make_bench(Operating_Mode=5)
    bench.set("Goal Current", 150)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 6000)
    currents = []
    for _ in range(300):
        bench.run(0.01)
        currents.append(abs(bench.get("Present Current")))
    assert 140 < max(currents) <= 152
    assert bench.servo.position == pytest.approx(6000, abs=10)


def test_a_change_of_mode_resets_gains_profile_and_goals(bench):
    for name, value in {"Position P Gain": 300, "Profile Velocity": 9, "Goal PWM": 100}.items():
        bench.set(name, value)
    assert bench.set("Operating Mode", 3) == 0  # no change
    assert bench.get("Position P Gain") == 300
    bench.set("Operating Mode", 5)
    assert bench.get("Position P Gain") == 800
    assert bench.get("Profile Velocity") == 0
    assert bench.get("Goal PWM") == 885
    assert bench.get("Goal Current") == 1193
    assert bench.get("Goal Position") == bench.get("Present Position")


def test_reverse_mode_turns_the_direction(make_bench):
    bench = make_bench()
    bench.set("Drive Mode", 1)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 2500)
    bench.run(1.0)
    assert bench.get("Present Position") == pytest.approx(2500, abs=4)
    assert bench.servo.shaft.angle == pytest.approx(-(2500 - 2048) / 4096 * tau, abs=0.01)


def test_mounted_in_reverse_its_position_grows_with_the_joint(make_bench):
    bench = make_bench(Drive_Mode=1)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 2500)
    bench.run(1.0)
    assert bench.servo.shaft.angle == pytest.approx((2500 - 2048) / 4096 * tau, abs=0.01)


def test_torque_on_by_goal_update(make_bench):
    bench = make_bench(Drive_Mode=8)
    bench.set("Goal Position", 2300)
    assert bench.get("Torque Enable") == 1
    bench.run(1.0)
    assert bench.servo.position == pytest.approx(2300, abs=4)


# turns


def test_mode_3_counts_turns_until_the_torque_comes_on(make_bench):
    bench = make_bench()
    bench.servo.shaft.angle = 3 * tau + 0.1
    turned = bench.get("Present Position")
    assert turned > 3 * 4096
    bench.set("Torque Enable", 1)
    assert bench.get("Present Position") == turned - 3 * 4096


def test_mode_4_keeps_its_turns_when_the_torque_comes_on(make_bench):
    bench = make_bench(Operating_Mode=4)
    bench.servo.shaft.angle = 3 * tau
    bench.set("Torque Enable", 1)
    assert bench.get("Present Position") == 2048 + 3 * 4096


def test_a_reboot_loses_the_turns(make_bench):
    bench = make_bench(Operating_Mode=4)
    bench.servo.shaft.angle = -2 * tau
    bench.servo.reboot()
    assert bench.get("Present Position") == 2048


def test_a_homing_offset_shifts_the_position(bench):
    bench.set("Homing Offset", -300)
    assert bench.get("Present Position") == 1748


def test_in_mode_3_a_homing_offset_beyond_a_quarter_turn_is_ignored(bench):
    bench.set("Homing Offset", 1025)
    assert bench.get("Present Position") == 2048
    bench.set("Operating Mode", 4)
    assert bench.get("Present Position") == 2048 + 1025


def test_a_folded_position_still_has_its_homing_offset(make_bench):
    bench = make_bench(zero=4000, Homing_Offset=500)
    assert bench.get("Present Position") == 4000
    bench.servo.shaft.angle = 700 / 4096 * tau
    bench.set("Torque Enable", 1)
    assert bench.get("Present Position") == (3500 + 700) % 4096 + 500


# faults


def test_a_hardware_error_that_shutdown_names_cuts_the_torque_until_a_reboot(bench):
    bench.set("Torque Enable", 1)
    bench.servo.hardware_error(0x20)
    assert bench.get("Torque Enable") == 0
    assert bench.get("Hardware Error Status") == 0x20
    assert bench.servo.error_byte(0) == 0x80
    assert bench.set("Torque Enable", 1) == Refusal.ACCESS
    bench.servo.reboot()
    assert bench.servo.error_byte(0) == 0
    assert bench.set("Torque Enable", 1) == 0


def test_a_hardware_error_that_shutdown_does_not_name_is_only_told(bench):
    bench.set("Torque Enable", 1)
    bench.servo.hardware_error(0x01)
    assert bench.get("Torque Enable") == 1
    assert bench.servo.error_byte(7) == 0x87


def test_shut_down_not_even_a_goal_switches_the_torque_on(make_bench):
    bench = make_bench(Drive_Mode=8)
    bench.servo.hardware_error(0x20)
    bench.set("Goal Position", 2300)
    assert bench.get("Torque Enable") == 0


def test_a_supply_outside_its_limits_is_an_error(bench):
    bench.servo.voltage = 9.0
    bench.run(0.15)
    assert bench.get("Hardware Error Status") == 0x01
    assert bench.get("Present Input Voltage") == 90


def test_a_hot_servo_shuts_down(bench):
    bench.set("Torque Enable", 1)
    bench.servo.temperature = 81.0
    bench.run(0.15)
    assert bench.get("Hardware Error Status") == 0x04
    assert bench.get("Torque Enable") == 0


# what it measures


def test_the_tick_counts_milliseconds_and_turns_over(bench):
    bench.run(0.25)
    assert bench.get("Realtime Tick") == 250
    bench.servo.watch(40.0)
    assert bench.get("Realtime Tick") == 40_000 - 32_768


def test_an_xl330_measures_current_at_its_supply(make_bench):
    bench = make_bench("XL330-M288", Operating_Mode=16)
    bench.set("Torque Enable", 1)
    bench.set("Goal PWM", 442)
    bench.run(0.02)  # its PWM Slope lets the output grow by 5 % a millisecond
    motor = bench.servo.motor_current
    assert bench.get("Present Current") == pytest.approx(motor * 0.5 * 1e3, rel=0.02)


def test_a_servo_without_a_current_sensor_tells_its_load(make_bench):
    bench = make_bench("XL430-W250", Operating_Mode=16)
    bench.set("Torque Enable", 1)
    bench.set("Goal PWM", 442)
    bench.servo.tick(0.001)
    assert bench.get("Present Load") == pytest.approx(500, abs=2)


def test_moving_is_told_by_its_threshold(make_bench):
    bench = make_bench(Operating_Mode=1)
    bench.set("Torque Enable", 1)
    bench.servo.shaft.speed = 9 * RPM_UNIT / 60 * tau
    assert bench.get("Moving") == 0
    bench.servo.shaft.speed = 11 * RPM_UNIT / 60 * tau
    assert bench.get("Moving") == 1


def test_what_does_not_follow_says_so(bench):
    bench.set("PWM Limit", 0)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 3000)
    bench.run(0.1)
    assert bench.get("Moving Status") & 0x09 == 0x08


def test_the_position_is_that_of_the_shaft(make_bench):
    assert make_bench(angle=pi / 2).get("Present Position") == 3072


# the P series


def test_a_p_servo_counts_from_minus_half_a_turn_to_half_a_turn(make_bench):
    bench = make_bench("PH42-020-S300", zero=None)
    assert bench.get("Present Position") == 0
    bench.servo.shaft.angle = tau * 0.4
    assert bench.get("Present Position") == 243_000
    bench.servo.shaft.angle = tau * 0.6
    bench.set("Torque Enable", 1)
    assert bench.get("Present Position") == -243_000
    assert bench.set("Goal Position", -303_455) == Refusal.DATA_LIMIT
    assert bench.set("Goal Position", -303_454) == Refusal.NONE


def test_a_p_servo_keeps_its_indirect_addresses_in_eeprom(make_bench):
    bench = make_bench("PH42-020-S300", zero=None)
    for k in range(4):
        assert bench.set(f"Indirect Address {k + 1}", 580 + k) == 0
    bench.set("Torque Enable", 1)
    assert bench.set("Indirect Address 1", 564) == Refusal.ACCESS
    bench.servo.reboot()
    bench.servo.shaft.angle = 0.3
    number, data = bench.servo.read(634, 4)
    assert number == 0
    assert int.from_bytes(data, "little", signed=True) == bench.get("Present Position") > 0


def test_a_p_servos_current_is_that_of_its_line(make_bench):
    bench = make_bench("PH42-020-S300", zero=None, Operating_Mode=0)
    bench.servo.stuck = True
    bench.set("Torque Enable", 1)
    assert bench.set("Goal Current", 4501) == Refusal.DATA_LIMIT
    bench.set("Goal Current", 1500)
    bench.run(0.01)
    assert bench.get("Present Current") == pytest.approx(1500, abs=2)
