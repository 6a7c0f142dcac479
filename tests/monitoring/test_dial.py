"""Positions by what registers say, with the turns that servos count and forget."""

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.chain import ServoRole, ServoSpec
from splinearm.drivers.model import servo_model
from splinearm.monitoring.dial import Dial, Place

MODEL = servo_model("XM430-W350")
TICKS = 4096


def place(mode, zero=2048, reach=(-2.0, 2.0)):
    servo = ServoSpec(
        name="elbow",
        servo_id=1,
        model=MODEL.name,
        role=ServoRole.LEADER,
        joint="elbow",
        zero_ticks=zero,
        settings={"Operating Mode": mode},
    )
    return Place(servo=servo, zero=zero, range=reach)


@pytest.mark.property
@given(q=st.floats(-2.0, 2.0), turns=st.integers(-3, 3), torque=st.booleans())
def test_the_turn_of_a_servo_that_counts_many_follows_from_the_range(q, turns, torque):
    ticks = 2048 + round(q * TICKS / (2 * pi)) + turns * TICKS
    dial = Dial(MODEL, place(4), ticks)
    assert dial.position(ticks, torque=torque) == pytest.approx(q, abs=1e-3)


@pytest.mark.property
@given(q=st.floats(-2.0, 2.0), turns=st.integers(-2, 2))
def test_a_servo_of_one_turn_without_torque_counts_on_and_is_folded(q, turns):
    ticks = 2048 + round(q * TICKS / (2 * pi))
    dial = Dial(MODEL, place(3), ticks)
    assert dial.position(ticks + turns * TICKS, torque=False) == pytest.approx(q, abs=1e-3)
    assert dial.position(ticks, torque=True) == pytest.approx(q, abs=1e-3)


def test_a_turn_that_cannot_be_told_stays_as_it_is():
    dial = Dial(MODEL, place(4, reach=(-5.0, 5.0)), 2048 + TICKS // 2)
    assert dial.position(2048 + TICKS // 2, torque=True) == pytest.approx(pi)


def test_without_an_arm_positions_are_from_the_middle():
    dial = Dial(MODEL, Place(), 0)
    assert dial.position(2048 + 1024, torque=None) == pytest.approx(pi / 2)
    assert dial.position(2048 + 1024, torque=False) == pytest.approx(pi / 2)


def test_a_servo_that_turns_for_ever_counts_as_it_turns():
    dial = Dial(MODEL, place(1), 2048)
    assert dial.position(2048 + TICKS, torque=False) == pytest.approx(2 * pi)
