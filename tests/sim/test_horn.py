from math import pi, radians, tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.sim.horn import Horn, Potentiometer

PER_RAD = 4096 / tau


def horn(*, reverse: bool = False, zero: float = 2048, homing: int = 0, angle: float = 0.0) -> Horn:
    made = Horn(PER_RAD, 4096, reverse=reverse, at_zero=zero - homing)
    made.set_up(reverse=reverse, homing=homing)
    made.fold(angle)
    return made


@pytest.mark.property
@given(st.booleans(), st.integers(600, 3500), st.integers(-500, 500), st.floats(-0.5, 0.5))
def test_the_position_grows_with_the_joint_from_its_zero_however_it_is_mounted(
    reverse, zero, homing, angle
):
    made = horn(reverse=reverse, zero=zero, homing=homing, angle=0.0)
    assert made.position(0.0) == zero
    assert made.position(angle) == pytest.approx(zero + angle * PER_RAD, abs=0.51)
    assert made.speed(1.0) == pytest.approx(PER_RAD)


@pytest.mark.property
@given(st.floats(-50.0, 50.0), st.booleans())
def test_folded_the_position_is_within_one_turn_and_differs_by_whole_turns(angle, reverse):
    made = horn(reverse=reverse)
    unfolded = made.position(angle)
    made.fold(angle)
    assert 0 <= made.position(angle) <= 4095
    assert (made.position(angle) - unfolded) % 4096 == 0


def test_reversing_a_mounted_servo_turns_its_direction_about_the_centre():
    made = horn()
    quarter = made.position(pi / 2)
    made.set_up(reverse=True, homing=0)
    made.fold(0.0)
    assert made.position(0.0) == 2048
    assert made.position(pi / 2) == 4096 - quarter
    assert made.speed(1.0) < 0.0


def test_a_homing_offset_is_added_last_and_not_reversed():
    made = horn(reverse=True)
    made.set_up(reverse=True, homing=100)
    assert made.position(0.0) == 2148


@pytest.mark.property
@given(st.booleans(), st.floats(-0.4, 0.4), st.floats(-0.5, 0.5))
def test_a_horn_that_slips_reads_as_if_the_joint_were_further(reverse, angle, slipped):
    made, other = horn(reverse=reverse), horn(reverse=reverse)
    made.slip(slipped)
    assert abs(made.position(angle) - other.position(angle + slipped)) <= 1
    made.set_up(reverse=reverse, homing=0)  # and it stays so
    assert abs(made.position(angle) - other.position(angle + slipped)) <= 1


def test_one_turn_can_begin_below_zero():
    made = Horn(607_500 / tau, 607_500, reverse=False, at_zero=0, lowest=-303_750)
    made.fold(0.6 * tau)
    assert made.position(0.6 * tau) == -243_000


@pytest.mark.property
@given(st.floats(-40.0, 40.0))
def test_a_potentiometer_reads_the_same_every_turn_and_never_beyond_its_ends(angle):
    made = Potentiometer(1024 / radians(300.0), 1024, reverse=False, at_zero=512)
    made.set_up(reverse=False, homing=0)
    made.fold(angle)
    position = made.position(angle)
    assert 0 <= position <= 1023
    assert made.position(angle + tau) == pytest.approx(position, abs=1)
