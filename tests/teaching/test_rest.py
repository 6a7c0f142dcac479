"""Pauses of a hand: when they begin, how long they last, and what is none."""

import numpy as np
import pytest

from splinearm.curves.smoothing import smooth
from splinearm.errors import StillError
from splinearm.teaching.recording import Nearness, Ruler
from splinearm.teaching.rest import RestRule, find_moving

T = np.arange(600) / 100.0


def stroke(begin, lasts, far):
    x = np.clip((T - begin) / lasts, 0.0, 1.0)
    return far * (10 * x**3 - 15 * x**4 + 6 * x**5)


def moving_of(cell, q, rule=None):
    q = np.array(cell.poses["home"]) + q
    ruler = Ruler(cell.arm, Nearness())
    return find_moving(T, q, smooth(q, parameters=T), ruler, cell.arm, rule or RestRule())


def test_a_pause_between_two_strokes_is_a_rest(planar):
    q = np.column_stack((stroke(0.6, 1.0, 0.5) + stroke(3.0, 1.0, -0.3), stroke(0.6, 1.2, 0.2)))
    moving = moving_of(planar, q)
    ((begin, end),) = moving.rests
    assert T[begin] == pytest.approx(1.75, abs=0.15)
    assert T[end] == pytest.approx(3.1, abs=0.15)
    assert T[moving.first] == pytest.approx(0.7, abs=0.15)
    assert T[moving.last] == pytest.approx(3.9, abs=0.15)


def test_the_time_of_moving_stands_still_in_a_rest_and_at_the_ends(planar):
    q = np.column_stack((stroke(0.6, 1.0, 0.5) + stroke(3.0, 1.0, -0.3), np.zeros(600)))
    moving = moving_of(planar, q)
    u = moving.times(T)
    ((begin, end),) = moving.rests
    shift = moving.ends[0]
    assert (np.diff(u) >= -1e-12).all()
    assert u[0] == u[moving.first - shift] == 0.0
    assert u[begin - shift] == u[end - shift]
    lasts = T[moving.last] - T[moving.first] - (T[end] - T[begin])
    assert u[-1] == pytest.approx(lasts)


def test_a_slow_motion_is_no_rest(planar):
    q = np.column_stack((stroke(0.5, 1.0, 0.5) + 0.004 * np.clip(T - 1.6, 0, 3), np.zeros(600)))
    assert not moving_of(planar, q).rests


def test_a_short_pause_is_none_unless_that_is_wished(planar):
    q = np.column_stack((stroke(0.5, 1.0, 0.5) + stroke(2.05, 1.0, -0.5), np.zeros(600)))
    assert not moving_of(planar, q, RestRule(time=1.0)).rests
    assert len(moving_of(planar, q, RestRule(time=0.3)).rests) == 1


def test_an_arm_that_never_moves_has_nothing_to_teach(planar):
    with pytest.raises(StillError, match="nothing moves"):
        moving_of(planar, np.zeros((600, 2)))


@pytest.mark.parametrize("name", ["time", "tool_speed", "joint_speed"])
def test_a_rule_wants_numbers_above_zero(name):
    with pytest.raises(ValueError, match=name):
        RestRule(**{name: 0.0})
