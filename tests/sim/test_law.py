from math import inf

import pytest

from splinearm.sim.law import LawSettings, Mode, ServoLaw
from splinearm.sim.profile import ProfileKind

NO_LOAD, STALL = 3140.0, 2.3  # ticks/s and A of an XM430-W350


def settings(**changes: float) -> LawSettings:
    values = {
        "mode": Mode.POSITION, "p": 6.25, "i": 0.0, "d": 0.0, "ff1": 0.0, "ff2": 0.0,
        "vp": 0.78, "vi": 0.029, "velocity_unit": 15.6, "full_pwm": 885.0, "duty_limit": 1.0,
        "current_limit": inf, "top_velocity": 0.0, "acceleration": 0.0, "time_based": False,
    }  # fmt: skip
    return LawSettings(**{**values, **changes})


def law(**changes: float) -> ServoLaw:
    made = ServoLaw(settings(**changes), no_load_speed=NO_LOAD, stall_current=STALL)
    made.rest_at(2000.0)
    return made


def test_the_p_gain_gives_pwm_units_a_tick():
    made = law()
    made.aim_at(2010.0)
    assert made.tick(2000, 0.0) == pytest.approx(10 * 6.25 / 885)


def test_the_i_gain_sums_up_every_millisecond_and_stops_at_full_duty():
    made = law(p=0.0, i=0.5)
    made.aim_at(2010.0)
    duties = [made.tick(2000, 0.0) for _ in range(1000)]
    assert duties[1] == pytest.approx(2 * 10 * 0.5 / 885)
    assert duties[-1] == 1.0
    made.aim_at(1990.0)
    back = [made.tick(2000, 0.0) for _ in range(400)]
    assert back[-1] < 0.0  # it did not wind up meanwhile


def test_the_d_gain_brakes():
    made = law(p=0.0, d=16.0)
    made.aim_at(2000.0)
    assert made.tick(2000, 500.0) == pytest.approx(-16.0 * 0.5 / 885)


def test_feed_forward_gains_act_on_the_trajectory():
    made = law(p=0.0, ff1=4.0, ff2=1000.0, top_velocity=500.0, acceleration=2000.0)
    made.aim_at(3000.0)
    first = made.tick(2000, 0.0)
    assert first == pytest.approx((4.0 * 2.0 * 1e-3 + 1000.0 * 2000.0 * 1e-6) / 885)
    for _ in range(400):
        last = made.tick(2000, 0.0)
    assert last == pytest.approx(4.0 * 0.5 / 885)


def test_the_duty_stays_within_its_limit():
    made = law(duty_limit=0.3)
    made.aim_at(9000.0)
    assert made.tick(2000, 0.0) == 0.3
    made.aim_at(-9000.0)
    made.tick(2000, 0.0)
    assert made.tick(2000, 0.0) == -0.3


@pytest.mark.parametrize("speed", [-1000.0, 0.0, 1000.0])
def test_in_current_based_position_mode_the_current_stays_within_its_limit(speed):
    made = law(mode=Mode.CURRENT_POSITION, current_limit=0.4)
    made.aim_at(9000.0)
    assert made.current(made.tick(2000, speed), speed) == pytest.approx(0.4)


@pytest.mark.parametrize("speed", [-1000.0, 0.0, 1000.0])
def test_in_current_based_position_mode_the_error_asks_for_a_current_at_any_speed(speed):
    made = law(mode=Mode.CURRENT_POSITION, current_unit=2.69e-3)
    made.aim_at(2020.0)
    wanted = 20 * 6.25 * 2.69e-3
    assert made.current(made.tick(2000, speed), speed) == pytest.approx(wanted)
    made.strength = 0.8
    assert made.current(made.tick(2000, speed), speed) == pytest.approx(wanted)


def test_in_current_mode_the_motor_has_the_goal_current_at_any_speed():
    made = law(mode=Mode.CURRENT)
    made.goal_current = -0.5
    for speed in (-800.0, 0.0, 800.0):
        assert made.current(made.tick(2000, speed), speed) == pytest.approx(-0.5)


def test_in_pwm_mode_the_duty_is_the_goal():
    made = law(mode=Mode.PWM)
    made.goal_duty = -0.25
    assert made.tick(2000, 123.0) == -0.25


def test_in_velocity_mode_the_trajectory_ramps():
    made = law(mode=Mode.VELOCITY, acceleration=1000.0)
    made.goal_velocity = 100.0
    made.tick(2000, 0.0)
    assert made.velocity == pytest.approx(1.0)
    for _ in range(200):
        made.tick(2000, 0.0)
    assert made.velocity == 100.0


def test_a_new_goal_goes_on_from_the_trajectorys_velocity():
    made = law(top_velocity=500.0, acceleration=5000.0)
    made.aim_at(3000.0)
    for _ in range(300):
        made.tick(2000, 0.0)
    before = made.velocity
    made.aim_at(2100.0)
    made.tick(2000, 0.0)
    assert before == 500.0
    assert made.velocity == pytest.approx(495.0)
    assert made.profile_kind is ProfileKind.TRAPEZOIDAL


def test_the_trajectory_arrives_exactly():
    made = law(top_velocity=500.0, acceleration=5000.0)
    made.aim_at(2300.5)
    while made.profile_ongoing:
        made.tick(2000, 0.0)
    made.tick(2000, 0.0)
    assert (made.position, made.velocity) == (2300.5, 0.0)


def test_the_duty_changes_no_faster_than_its_slew():
    made = law(slew=0.05)
    made.aim_at(9000.0)
    assert [round(made.tick(2000, 0.0), 3) for _ in range(3)] == [0.05, 0.1, 0.15]
    made.release(2000.0)
    made.aim_at(-9000.0)
    assert made.tick(2000, 0.0) == pytest.approx(-0.05)


@pytest.mark.parametrize("strength", [0.7, 1.2])
def test_at_another_supply_currents_are_the_same(strength):
    made = law(mode=Mode.CURRENT)
    made.strength = strength
    made.goal_current = 0.5
    assert made.current(made.tick(2000, 300.0), 300.0) == pytest.approx(0.5)


@pytest.mark.parametrize("mode", list(Mode))
def test_braking_it_opposes_the_motion_within_its_limit_whatever_the_mode(mode):
    made = law(mode=mode, duty_limit=0.6)
    made.brake(900.0)
    assert made.busy
    assert made.tick(2000, 900.0) == -0.6


@pytest.mark.parametrize("mode", list(Mode))
def test_at_rest_it_keeps_the_output_that_carries_its_load(mode):
    made = law(mode=mode)
    load, time_constant, speed, position = 0.3, 100.0, 900.0, 2000.0
    made.brake(speed)
    for _ in range(400):
        duty = made.tick(position, speed)
        speed += NO_LOAD * (duty - speed / NO_LOAD - load) / time_constant
        position += 1e-3 * speed
    assert not made.busy
    assert abs(speed) < 0.01 * NO_LOAD
    assert duty == pytest.approx(load, abs=0.03)


def test_a_new_goal_ends_braking():
    made = law(mode=Mode.PWM)
    made.brake(900.0)
    made.tick(2000, 900.0)
    made.go_on()
    made.goal_duty = 0.2
    assert made.tick(2000, 500.0) == 0.2
