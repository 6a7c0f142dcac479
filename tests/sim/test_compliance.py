import pytest

from splinearm.sim.compliance import Compliance, representative_slope

AX = Compliance(margin_below=1, margin_above=3, slope_below=32, slope_above=64, punch=32, full=1023)


@pytest.mark.parametrize(
    ("value", "slope"),
    [(0, 2), (3, 2), (4, 4), (25, 16), (32, 32), (127, 64), (128, 128), (254, 128)],
)
def test_the_slope_is_one_of_seven(value, slope):
    assert representative_slope(value) == slope


@pytest.mark.parametrize(("error", "pwm"), [(0, 0), (3, 0), (-1, 0), (67, 1023), (-33, -1023)])
def test_it_grows_from_the_margin_by_the_slope(error, pwm):
    assert AX.pwm(error) == pwm


def test_it_begins_with_punch_and_ends_at_full():
    assert AX.pwm(3.001) == pytest.approx(32, abs=0.1)
    assert AX.pwm(35) == pytest.approx(32 + (1023 - 32) / 2)
    assert AX.pwm(-17) == pytest.approx(-(32 + (1023 - 32) / 2))
    assert AX.pwm(500) == 1023
