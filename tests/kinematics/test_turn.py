from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.kinematics import turn

angles = st.floats(-30.0, 30.0)


def nearest(q, near, lower, upper):
    return float(turn.nearest(*(np.array([x]) for x in (q, near, lower, upper)))[0])


@pytest.mark.property
@given(angles, angles, st.floats(-9.0, 0.0), st.floats(0.1, 9.0))
def test_the_nearest_fitting_turn_is_found_as_by_trying_all(q, near, lower, upper):
    chosen = nearest(q, near, lower, upper)
    assert (chosen - q) / (2 * pi) == pytest.approx(round((chosen - q) / (2 * pi)), abs=1e-9)
    fitting = [c for k in range(-12, 13) if lower <= (c := q + 2 * pi * k) <= upper]
    if fitting:
        assert lower <= chosen <= upper
        assert abs(chosen - near) <= min(abs(c - near) for c in fitting) + 1e-9
    else:
        beyond = max(lower - chosen, chosen - upper)
        others = [max(lower - c, c - upper) for k in (-1, 1) if (c := chosen + 2 * pi * k)]
        assert beyond <= min(others) + 1e-9


def test_without_limits_the_turn_is_the_one_next_to_the_wish():
    assert nearest(0.1, 20.0, -inf, inf) == pytest.approx(0.1 + 6 * pi)


def test_what_is_beyond_a_limit_by_rounding_is_put_on_it():
    assert nearest(pi + 4e-16, 1.0, -pi, pi) == pi
    assert nearest(-2.7 - 4e-16, 0.0, -2.7, 2.7) == -2.7


def test_the_middle_of_open_limits_is_zero_or_the_limit():
    lower, upper = np.array([-1.0, -inf, 2.0, -inf]), np.array([3.0, inf, inf, -1.0])
    np.testing.assert_array_equal(turn.middle(lower, upper), [1.0, 0.0, 2.0, -1.0])
