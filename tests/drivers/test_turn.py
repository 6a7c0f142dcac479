from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.chain import ServoRole, ServoSpec
from splinearm.drivers.model import servo_model
from splinearm.drivers.turn import fold, unwrapped_zero
from splinearm.errors import ServoError
from splinearm.sim.horn import Horn
from splinearm.units import DEG

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


def test_a_joint_at_the_seam_of_a_whole_turn_may_be_at_either_end_and_is_refused():
    for beyond in (-10, 0, 10):
        with pytest.raises(ServoError, match=r"it may be at -1\d\d.\d or 1\d\d.\d deg; say about"):
            unwrapped_zero(leader(4), 2048, 2048 + 2048 + beyond, -pi, pi)
    assert unwrapped_zero(leader(4), 2048, 2048 + 2048 + 100, -pi, pi) == 2048 + 4096
    assert unwrapped_zero(leader(4), 2048, 2048 + 2048 - 100, -pi, pi) == 2048


def test_a_joint_in_the_gap_between_its_limits_is_refused_unless_one_is_much_nearer():
    gap = pi - 0.1
    with pytest.raises(ServoError, match="cannot be told"):
        unwrapped_zero(leader(4), 2048, 2048 + 2048, -gap, gap)
    assert unwrapped_zero(leader(4), 2048, 2048 + 2048 - 50, -gap, gap) == 2048


def test_who_knows_about_where_a_joint_is_settles_its_turn():
    assert unwrapped_zero(leader(4), 2048, 4048, -4.0, 4.0, near=-3.0) == 2048 + 4096
    assert unwrapped_zero(leader(4), 2048, 4048, -4.0, 4.0, near=3.0) == 2048
    assert unwrapped_zero(leader(5), 2048, 2048, 0.0, inf, near=12.0) == 2048 - 2 * 4096
    assert unwrapped_zero(leader(4), 2048, 2048, -inf, inf, near=-6.0) == 2048 + 4096


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


MODELS = ("XM430-W350", "XL430-W250", "XL330-M288", "XH540-W270", "MX-28-2", "PH42-020-S300")
SEAM = 2.5 * DEG


def mounted(rng: np.random.Generator, mode: int) -> tuple[ServoSpec, Horn]:
    """Give a servo set and mounted anyhow, and its encoder."""
    name = str(rng.choice(MODELS[:5] if mode == 3 else MODELS))
    model = servo_model(name)
    most = 1024 if mode == 3 else 1_000_000
    homing = int(rng.integers(-most, most + 1)) if rng.random() < 0.7 else 0
    reverse = bool(rng.integers(0, 2))
    low = model.centre - model.pulses // 2
    one_turn = (low + max(homing, 0), low + model.pulses + min(homing, 0))
    far = (-5 * model.pulses, 5 * model.pulses)
    zero = int(rng.integers(*(one_turn if mode == 3 else far)))
    servo = ServoSpec(
        name="waist",
        servo_id=1,
        model=name,
        role=ServoRole.LEADER,
        joint="waist",
        zero_ticks=zero,
        settings={"Operating Mode": mode, "Homing Offset": homing, "Drive Mode": int(reverse)},
    )
    horn = Horn(
        model.pulses_per_rad,
        model.pulses,
        reverse=reverse,
        at_zero=zero - homing,
        lowest=low if model.centre == 0 else 0,
    )
    horn.set_up(reverse=reverse, homing=homing)
    return servo, horn


def working_range(rng: np.random.Generator, servo: ServoSpec, *, wide: bool) -> tuple[float, float]:
    """Give the travel of a joint that its servo can make; wide: of more than a turn."""
    model, zero = servo.servo_model, servo.zero_ticks
    if servo.settings["Operating Mode"] == 3:
        homing = servo.settings["Homing Offset"]
        low = model.centre - model.pulses // 2
        ends = sorted(rng.uniform(low + max(homing, 0), low + model.pulses - 1 + min(homing, 0), 2))
        return (ends[0] - zero) / model.pulses_per_rad, (ends[1] - zero) / model.pulses_per_rad
    travel = rng.uniform(2 * pi, 4 * pi) if wide else rng.uniform(0.1, 2 * pi)
    low = rng.uniform(-2 * pi, 2 * pi - travel / 2)
    return low, low + travel


def wake_up(rng: np.random.Generator, *, wide: bool) -> bool:
    """Let a servo lose its power at a random place; give whether the angle found is right.

    A place that may be in two turns must be refused, and nothing else may be.
    """
    servo, horn = mounted(rng, mode=int(rng.choice([3, 4, 5])) if not wide else 4)
    if servo.settings["Operating Mode"] not in servo.servo_model.modes:
        return True
    low, high = working_range(rng, servo, wide=wide)
    q = rng.uniform(low, high)
    horn.fold(q)  # the power comes on
    ticks = fold(servo, horn.position(q))
    per_rad = servo.servo_model.pulses_per_rad
    rivals = [k for k in (-2, -1, 1, 2) if low - SEAM <= q + k * 2 * pi <= high + SEAM]
    try:
        zero = unwrapped_zero(servo, servo.zero_ticks, ticks, low, high)
    except ServoError:
        assert rivals
        near = unwrapped_zero(servo, servo.zero_ticks, ticks, low, high, near=q + 1.5)
        return abs((ticks - near) / per_rad - q) < 1.01 / per_rad
    surely = [k for k in rivals if low <= q + k * 2 * pi <= high]
    assert not surely or servo.settings["Operating Mode"] == 3
    return abs((ticks - zero) / per_rad - q) < 1.01 / per_rad


def test_the_angle_is_right_after_a_loss_of_power_wherever_the_joint_stands():
    rng = np.random.default_rng(3)
    assert all(wake_up(rng, wide=False) for _ in range(5_000))
    assert all(wake_up(rng, wide=True) for _ in range(2_000))


@pytest.mark.slow
def test_the_angle_is_right_after_100_000_losses_of_power():
    rng = np.random.default_rng(4)
    assert all(wake_up(rng, wide=False) for _ in range(80_000))
    assert all(wake_up(rng, wide=True) for _ in range(20_000))
