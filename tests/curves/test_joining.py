import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.joining import join
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 3))
def test_what_was_split_is_joined_again(random_curve, places, seed, continuity):
    curve = random_curve(seed).over(0.0, 1.0)
    smooth = min(continuity, curve.degree)
    u = float(np.random.default_rng(seed).uniform(0.3, 0.7))
    if np.abs(curve.breaks - u).min() < 0.01:
        return
    whole = join(*curve.split(u), smooth, 1e-7)
    assert whole.domain == pytest.approx((0.0, 1.0), abs=1e-15)
    assert np.count_nonzero(np.abs(whole.knots - u) < 1e-12) == max(curve.degree - smooth, 0)
    at = np.minimum(places(curve), whole.domain[1])
    np.testing.assert_allclose(whole.at(at), curve.at(at), rtol=0, atol=1e-6)


def test_degrees_and_domains_are_brought_together(circle):
    line = BSpline([5.0, 5.0, 7.0, 7.0], [[1.0, 0.0], [1.0, -2.0]], 1)
    whole = join(circle, line)
    assert whole.domain == (0.0, 6.0)
    assert whole.degree == 2
    assert whole.is_rational
    np.testing.assert_allclose(whole.at(5.0), [1.0, -1.0], rtol=0, atol=1e-15)
    u = np.linspace(0.0, 4.0, 50)
    assert np.abs(np.linalg.norm(whole.at(u), axis=1) - 1.0).max() < 1e-15
    back = join(line, circle.reversed().mapped([[1, 0, 0], [0, 1, -2], [0, 0, 1]]))
    assert back.domain == (5.0, 11.0)
    np.testing.assert_allclose(back.at(6.0), [1.0, -1.0], rtol=0, atol=1e-15)


def test_curves_that_do_not_meet_are_refused():
    line = BSpline([0, 0, 1, 1], [[0.0, 0.0], [1.0, 0.0]], 1)
    bent = BSpline([0, 0, 1, 1], [[1.0, 0.0], [1.0, 1.0]], 1)
    with pytest.raises(CurveError, match=r"they are apart by 1"):
        join(line, line)
    with pytest.raises(CurveError, match=r"derivative 1 jumps by 1\.41"):
        join(line, bent, 1)
    assert join(line, bent).at(1.5).tolist() == [1.0, 0.5]
    with pytest.raises(ValueError, match="dim: want as many"):
        join(line, BSpline([0, 0, 1, 1], [[1.0], [2.0]], 1))
    with pytest.raises(ValueError, match="want no less than 0"):
        join(line, bent, -1)


def test_a_curve_that_rests_where_it_meets_is_smooth():
    slow = BSpline([0] * 4 + [1] * 4, [[0.0], [1.0 / 3], [1.0], [1.0]], 3)
    on = BSpline([0] * 4 + [1] * 4, [[1.0], [1.0 + 1e-16], [1.5], [2.0]], 3)
    assert np.count_nonzero(join(slow, on, 1).knots == 1.0) == 2
