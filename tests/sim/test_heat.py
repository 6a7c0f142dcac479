from math import exp

import pytest

from splinearm.sim.heat import Heat


def test_it_comes_to_its_final_temperature_in_its_time_constant():
    heat = Heat(ambient=20.0, rise_at_stall=100.0, time_constant=60.0)
    assert heat.after(20.0, 0.5, 60.0) == pytest.approx(20.0 + 25.0 * (1.0 - exp(-1.0)))
    assert heat.after(20.0, 0.5, 1e6) == pytest.approx(45.0)


def test_many_short_times_are_one_long_one():
    heat = Heat()
    warm = 30.0
    for _ in range(1000):
        warm = heat.after(warm, 0.4, 0.02)
    assert warm == pytest.approx(heat.after(30.0, 0.4, 20.0), rel=1e-9)


def test_without_load_it_cools_and_its_pace_can_be_quicker():
    assert Heat(pace=600.0).after(80.0, 0.0, 1.0) == pytest.approx(30.0 + 50.0 * exp(-1.0))
