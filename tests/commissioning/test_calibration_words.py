"""What a person is told, and the small parts: counting on, zero by ends, directions in words."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.commissioning.calibration_words import direction_words, growth_words, pose_words
from splinearm.commissioning.calibration_zero import Turned, check_zero, zero_by_ends, zero_by_pose
from splinearm.commissioning.sweep import Pairing, Sweep
from splinearm.config import load_cell, shipped_arms
from splinearm.drivers.model import servo_model
from splinearm.errors import CalibrationError
from splinearm.units import DEG

XM, AX = servo_model("XM430-W350"), servo_model("AX-12A")


@pytest.mark.property
@given(steps=st.lists(st.integers(-1000, 1000), min_size=1), at=st.integers(-5000, 5000))
def test_a_position_that_folds_into_one_turn_is_counted_on(steps, at):
    folds, counts = Sweep(XM), Sweep(XM)
    ways = np.cumsum([at, *steps])
    for ticks in ways:
        folds.add(int(ticks) % 4096)
        counts.add(int(ticks))
    assert folds.now - folds.low == counts.now - counts.low == ways[-1] - ways.min()
    assert folds.travel == counts.travel == ways.max() - ways.min()


def test_a_quick_hand_is_counted_by_a_servo_that_counts_turns():
    sweep = Sweep(XM)
    for ticks in (0, 2900, 5800):
        sweep.add(ticks)
    assert sweep.travel == 5800


def test_a_servo_that_does_not_see_all_says_when_it_was_turned_through_its_gap():
    sweep = Sweep(AX)
    for ticks in (500, 1023, 1023, 0):
        assert not sweep.torn
        sweep.add(ticks)
    assert sweep.torn
    sweep.begin_anew()
    sweep.add(0)
    assert (sweep.torn, sweep.travel) == (False, 0)


def test_a_pair_is_told_apart_by_direction_and_offset():
    for sign in (1, -1):
        pairing = Pairing(XM)
        assert pairing.line() is None
        for leader in range(0, 400, 7):
            pairing.add(leader, sign * leader + 300 + leader % 2)
        found, offset, worst = pairing.line()
        assert (found, worst <= 1.0) == (sign, True)
        assert offset == pytest.approx(300.5, abs=0.5)


def turned(low, high, sign=1, q_min=-1.0, q_max=2.0):
    return Turned(joint="elbow", model=XM, low=low, high=high, sign=sign, q_min=q_min, q_max=q_max)


@pytest.mark.parametrize("sign", [1, -1])
def test_both_ways_to_zero_agree_where_the_limits_are_the_stops(sign):
    per_rad = XM.pulses_per_rad
    ends = sorted(round(1234 + sign * q * per_rad) for q in (-1.0, 2.0))
    way = turned(*ends, sign=sign)
    assert zero_by_ends(way) == pytest.approx(1234, abs=1)
    assert zero_by_pose(1234 + sign * 0.5 * per_rad, 0.5, sign, XM) == pytest.approx(1234)
    assert check_zero(way, 1234.0 + 3.0 * DEG * per_rad) == ""
    assert "zero is 20.0 deg from where the pose says" in check_zero(way, 1234 + 227.6)
    assert "20." not in check_zero(turned(0, 500), 9999.0)  # limits that are no stops say nothing
    wrong = turned(*ends, sign=-sign)  # limits to different sides tell a wrong direction
    assert "does it count the right way?" in check_zero(wrong, 1234.0)


def test_a_travel_that_is_not_what_the_limits_span_gives_no_zero():
    with pytest.raises(CalibrationError, match=r"turned by 87.9 deg, its limits span 171.9 deg"):
        zero_by_ends(turned(0, 1000))


@pytest.mark.parametrize(
    ("v", "words"),
    [
        ((1.0, 0.1, 0.0), "forward"),
        ((0.0, -2.0, 0.0), "right"),
        ((0.1, 0.3, -1.0), "down, a little left"),
        ((-1.0, 0.0, 0.9), "backward and up"),
    ],
)
def test_directions_are_told_as_people_see_them(v, words):
    assert direction_words(np.array(v)) == words


@pytest.mark.parametrize("name", shipped_arms())
def test_every_joint_of_every_arm_has_words_and_they_are_true(name):
    cell = load_cell(name)
    q = cell.poses.get("zero", cell.poses["home"])
    R = cell.arm.T_world_base[:3, :3]
    for i in range(cell.arm.n):
        assert pose_words(cell.arm, q, i)
        words = growth_words(cell.arm, q, i)
        if "so that the tool goes" in words:
            ahead = q.copy()
            ahead[i] += 0.01
            moved = R @ (cell.arm.fk(ahead) - cell.arm.fk(q))[:3, 3]
            first = words.removeprefix("so that the tool goes ").split(",")[0].split(" and ")[0]
            assert direction_words(moved).startswith(first)
        else:
            assert "clockwise, seen from" in words


def test_words_of_an_arm_that_stands_up():
    cell = load_cell("wx250s")
    arm, q = cell.arm, cell.poses["zero"]
    names = list(arm.joint_names)
    assert pose_words(arm, q, names.index("shoulder")) == "from it to elbow: up"
    assert growth_words(arm, q, names.index("waist")) == "so that the tool goes left"
    turn = growth_words(arm, q, names.index("wrist_rotate"))
    assert turn == "counter-clockwise, seen from the front"
