from math import inf, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.chain import ServoRole, ServoSpec
from splinearm.drivers.turn import fold, unwrapped_zero
from splinearm.errors import ServoError

PER_RAD = 4096 / (2 * pi)


def leader(mode: int, **settings) -> ServoSpec:
    return ServoSpec(
        name="waist",
        servo_id=1,
        model="XM430-W350",
        role=ServoRole.LEADER,
        joint="waist",
        zero_ticks=2048,
        settings={"Operating Mode": mode} | settings,
    )


@pytest.mark.property
@given(
    q=st.floats(-1.0, 1.0),
    middle=st.floats(-6.0, 6.0),
    half=st.floats(0.2, 3.1),
    turns=st.integers(-300, 300),
    zero=st.integers(-5000, 5000),
)
def test_whatever_turns_a_servo_forgot_the_angle_is_the_same(q, middle, half, turns, zero):
    angle = middle + q * (half - 0.01)
    ticks = round(zero + angle * PER_RAD) + turns * 4096
    found = unwrapped_zero(leader(4), zero, ticks, middle - half, middle + half)
    assert found == zero + turns * 4096


def test_a_joint_that_sags_a_little_beyond_its_limits_is_still_in_its_turn():
    assert unwrapped_zero(leader(5), 2048, 2048 + 4096 + 1100, -1.6, 1.6) == 2048 + 4096


def test_a_joint_that_hangs_over_the_seam_of_a_whole_turn_is_not_at_its_other_end():
    assert unwrapped_zero(leader(4), 2048, 2048 + 2048 + 10, -pi, pi) == 2048
    assert unwrapped_zero(leader(4), 2048, 2048 + 2048 + 100, -pi, pi) == 2048 + 4096


def test_limits_of_more_than_a_turn_leave_the_turn_open():
    with pytest.raises(ServoError, match="cannot be told: it may be at"):
        unwrapped_zero(leader(4), 2048, 4048, -4.0, 4.0)
    with pytest.raises(ServoError, match="narrow its limits"):
        unwrapped_zero(leader(4), 2048, 2048, 0.0, inf)


def test_wide_limits_do_not_matter_where_only_one_turn_fits():
    assert unwrapped_zero(leader(4), 2048, 2048 + 4096, -pi, pi + 0.5) == 2048 + 4096


def test_a_joint_far_outside_its_limits_is_refused():
    with pytest.raises(ServoError, match="outside its limits"):
        unwrapped_zero(leader(4), 2048, 4096, -1.0, 1.0)


def test_an_endless_joint_and_a_one_turn_servo_keep_their_zero():
    assert unwrapped_zero(leader(4), 2048, 9000, -inf, inf) == 2048
    assert unwrapped_zero(leader(3), 2048, 9000, -1.0, 1.0) == 2048


@pytest.mark.property
@given(ticks=st.integers(-100_000, 100_000), homing=st.integers(-1024, 1024))
def test_a_one_turn_servo_folds_into_its_turn(ticks, homing):
    servo = leader(3, **{"Homing Offset": homing})
    folded = fold(servo, ticks)
    assert homing <= folded < homing + 4096
    assert (folded - ticks) % 4096 == 0
    assert fold(leader(4), ticks) == ticks
