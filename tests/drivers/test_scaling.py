from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.chain import ServoRole, ServoSpec
from splinearm.drivers.scaling import JointScale, operating_mode, position_range
from splinearm.errors import LimitError


def leader(**changes) -> ServoSpec:
    facts = {
        "name": "waist",
        "servo_id": 1,
        "model": "XM430-W350",
        "role": ServoRole.LEADER,
        "joint": "waist",
        "zero_ticks": 2048,
        "settings": {"Operating Mode": 4},
    }
    return ServoSpec(**(facts | changes))


SERVOS = [
    leader(),
    leader(name="elbow", servo_id=2, joint="elbow", model="XL430-W250", zero_ticks=100),
    leader(name="wrist", servo_id=3, joint="wrist", model="PH42-020-S300", zero_ticks=-7),
]
SCALE = JointScale.of(SERVOS)


@pytest.mark.property
@given(q=st.lists(st.floats(-100.0, 100.0), min_size=3, max_size=3))
def test_radians_come_back_within_half_a_tick(q):
    back = SCALE.to_q(SCALE.to_ticks(np.array(q)))
    assert (np.abs(back - q) <= 0.5 / SCALE.pulses_per_rad + 1e-12).all()


@pytest.mark.property
@given(ticks=st.lists(st.integers(-100_000, 100_000), min_size=3, max_size=3))
def test_ticks_come_back_exactly(ticks):
    assert SCALE.to_ticks(SCALE.to_q(ticks)).tolist() == ticks


def test_joint_zero_is_at_zero_ticks_and_a_quarter_turn_1024_on():
    assert SCALE.to_ticks(np.zeros(3)).tolist() == [2048, 100, -7]
    assert SCALE.to_ticks(np.full(3, pi / 2)).tolist() == [3072, 1124, 151868]


def test_batches_lead():
    q = np.zeros((4, 2, 3))
    assert SCALE.to_ticks(q).shape == SCALE.to_q(SCALE.to_ticks(q)).shape == (4, 2, 3)


def test_velocity_and_current_have_the_units_of_the_model():
    assert SCALE.to_qd([1, 1, 100]) == pytest.approx(np.array([0.229, 0.229, 1.0]) * pi / 30)
    current = SCALE.to_current([100, 100, 100])
    assert current[[0, 2]] == pytest.approx([0.269, 0.1])
    assert np.isnan(current[1])


def test_goals_that_a_servo_does_not_take_are_refused_with_the_joint():
    scale = JointScale.of([leader(settings={}), SERVOS[1]])
    assert scale.to_ticks(np.array([-pi, 0.0])).tolist() == [0, 100]
    assert scale.to_ticks(np.array([pi, 0.0])).tolist() == [4095, 100]
    with pytest.raises(LimitError, match=r"'waist': position 180\.482 deg is above"):
        scale.to_ticks(np.array([3.15, 0.0]))
    with pytest.raises(LimitError) as caught:
        scale.to_ticks(np.array([[0.0, 0.0], [-3.2, 0.0]]))
    assert caught.value.value == pytest.approx(-3.2)
    assert caught.value.limit == pytest.approx(-pi)
    assert scale.to_nearest_ticks(np.array([4.0, 0.0])).tolist() == [4095, 100]


def test_the_range_of_goals_is_that_of_the_mode():
    assert position_range(leader()) == (-256 * 4096 + 1, 256 * 4096 - 1)
    assert position_range(leader(settings={})) == (0, 4095)
    assert position_range(leader(settings={"Min Position Limit": 819})) == (819, 4095)
    ph42 = leader(model="PH42-020-S300", settings={})
    assert position_range(ph42) == (-303454, 303454)


@pytest.mark.parametrize(
    "servo",
    [
        leader(settings={"Operating Mode": 1}),
        leader(model="XL430-W250", settings={"Operating Mode": 5}),
        leader(model="XL320", settings={"Control Mode": 1}),
        leader(model="AX-12A", settings={"CCW Angle Limit": 0}),
    ],
    ids=["velocity mode", "no current mode", "xl320", "ax12"],
)
def test_a_servo_without_such_a_mode_is_refused(servo):
    with pytest.raises(ValueError, match=r"position mode|joint mode"):
        operating_mode(servo)


def test_an_uncalibrated_servo_has_no_scale():
    with pytest.raises(ValueError, match="calibrate"):
        JointScale.of([leader(zero_ticks=None)])


def test_a_scale_that_cannot_be_is_refused():
    with pytest.raises(ValueError, match="pulses_per_rad"):
        replace(SCALE, pulses_per_rad=np.zeros(3))
    with pytest.raises(ValueError, match="ticks_min"):
        replace(SCALE, ticks_min=SCALE.ticks_max)
    with pytest.raises(ValueError, match="current_unit"):
        replace(SCALE, current_unit=np.zeros(2))


@pytest.mark.parametrize("model", ["XL320", "AX-12A"])
def test_old_models_count_1024_steps_over_300_degrees_within_their_angle_limits(model):
    servo = leader(model=model, zero_ticks=512, settings={"CCW Angle Limit": 900})
    scale = JointScale.of([servo])
    assert position_range(servo) == (0, 900)
    assert scale.to_ticks(np.array([np.radians(30.0)])) == pytest.approx([614], abs=1)
    assert scale.to_qd([100])[0] == pytest.approx(11.1 * 2 * np.pi / 60)
    assert np.isnan(scale.to_current([100])[0])


def test_velocities_and_currents_go_the_way_back():
    servos = [leader(), leader(name="elbow", joint="elbow", servo_id=2, model="XL430-W250")]
    scale = JointScale.of(servos)
    raw = scale.from_qd(scale.to_qd([-7, 300]))
    assert raw.tolist() == [-7, 300]
    assert scale.from_current(np.array([0.269, 5.0])).tolist() == [100, 0]
    with pytest.raises(ValueError, match="finite"):
        scale.from_current(np.array([np.nan, 0.0]))
    with pytest.raises(ValueError, match="finite"):
        scale.from_qd(np.array([np.inf, 0.0]))


def test_the_scale_of_the_first_servos_is_theirs():
    servos = [leader(), leader(name="elbow", joint="elbow", servo_id=2, zero_ticks=7)]
    assert JointScale.of(servos).first(1).zero_ticks.tolist() == [2048]
