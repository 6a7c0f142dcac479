import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.sim.profile import ProfileKind, by_time, by_velocity, step

places = st.floats(-5000.0, 5000.0)
speeds = st.floats(-3000.0, 3000.0)


@pytest.mark.property
@given(places, speeds, places, st.floats(10.0, 3000.0), st.floats(100.0, 1e5))
def test_a_profile_by_velocity_goes_on_from_where_it_was_and_ends_at_rest(x, v, goal, top, rate):
    profile = by_velocity(x, v, goal, top, rate)
    ts = np.linspace(0.0, profile.duration, 401)
    states = np.array([profile.at(t) for t in ts])
    assert profile.at(0.0)[:2] == pytest.approx((x, v), abs=1e-6)
    assert profile.at(profile.duration + 1.0) == (goal, 0.0, 0.0)
    end = profile.at(profile.duration * (1 - 1e-12))
    assert end[0] == pytest.approx(goal, abs=1e-3)
    assert abs(end[1]) < 1.0
    # no jump of the velocity but by the acceleration, and never faster than allowed or begun
    assert np.abs(np.diff(states[:, 1])).max() <= rate * (ts[1] - ts[0]) * (1 + 1e-6) + 1e-6
    assert np.abs(states[:, 1]).max() <= max(top, abs(v)) * (1 + 1e-9) + 1e-6


def test_the_ramp_takes_the_time_that_the_manual_gives():
    # t1 = 64 * profile velocity / profile acceleration ms, in units 0.229 rpm and 214.577 rpm2
    velocity, acceleration = 100, 20
    profile = by_velocity(
        0.0, 0.0, 1e5, velocity * 0.229 / 60 * 4096, acceleration * 214.577 / 3600 * 4096
    )
    assert profile.phases[0].duration == pytest.approx(
        64 * velocity / acceleration * 1e-3, rel=2e-3
    )


@pytest.mark.parametrize(
    ("goal", "kind"), [(1000.0, ProfileKind.TRAPEZOIDAL), (10.0, ProfileKind.TRIANGULAR)]
)
def test_a_short_way_makes_a_triangle(goal, kind):
    assert by_velocity(0.0, 0.0, goal, 100.0, 500.0).kind is kind


def test_without_acceleration_the_velocity_jumps():
    profile = by_velocity(0.0, 0.0, -200.0, 100.0, 0.0)
    assert profile.kind is ProfileKind.RECTANGULAR
    assert profile.duration == 2.0
    assert profile.at(1.0) == (-100.0, -100.0, 0.0)


def test_a_step_is_at_its_goal_at_once():
    assert step(5.0).at(0.0) == (5.0, 0.0, 0.0)
    assert step(5.0).duration == 0.0


@pytest.mark.property
@given(places, speeds, places, st.floats(0.01, 5.0), st.integers(0, 5000))
def test_a_profile_by_time_takes_that_time_and_ends_at_rest(x, v, goal, total, ramp_ms):
    ramp = ramp_ms * 1e-3
    profile = by_time(x, v, goal, total, ramp)
    assert profile.duration == pytest.approx(total)
    end = profile.at(profile.duration * (1 - 1e-12))
    assert end[0] == pytest.approx(goal, abs=1e-3)
    if ramp:
        assert profile.at(0.0)[:2] == pytest.approx((x, v))
        assert abs(end[1]) < 1e-3 * max(1.0, abs(profile.at(ramp)[1]))
