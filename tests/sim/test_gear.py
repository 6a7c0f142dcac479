import pytest

from splinearm.sim.gear import Gear


def test_in_the_gap_nothing_is_passed_on():
    gear = Gear(play=0.02, no_load_speed=5.0)  # in its middle: 0.01 rad take 4 ms at half speed
    passed = [gear.pass_on(0.5, 0.0, 1e-3) for _ in range(6)]
    assert passed == [None, None, None, 0.5, 0.5, 0.5]


def test_turned_round_it_runs_through_the_whole_gap():
    gear = Gear(play=0.02, no_load_speed=5.0)
    for _ in range(10):
        gear.pass_on(1.0, 0.0, 1e-3)
    passed = [gear.pass_on(-1.0, 0.0, 1e-3) for _ in range(5)]
    assert passed == [None, None, None, -1.0, -1.0]


def test_a_shaft_that_runs_ahead_is_not_braked_at_once():
    gear = Gear(play=0.02, no_load_speed=5.0)
    for _ in range(10):
        gear.pass_on(1.0, 0.0, 1e-3)
    assert gear.pass_on(0.5, 4.0, 1e-3) is None


@pytest.mark.parametrize("duty", [-0.3, 0.0, 0.4])
def test_the_shaft_and_the_motor_can_rest_together(duty):
    gear = Gear(play=0.0, no_load_speed=5.0)
    assert gear.pass_on(duty, 0.0, 1e-3) == duty
