import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.curvature import curvature
from splinearm.curves.natural import NaturalCurve
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel


def random_curve(seed, degree=3, rational=False, m=9):
    rng = np.random.default_rng(seed)
    inner = np.linspace(0.0, 1.0, m - degree + 1)
    knots = np.concatenate((np.zeros(degree), inner, np.ones(degree)))
    weights = rng.uniform(0.5, 2.0, m) if rational else None
    return BSpline(knots, np.cumsum(rng.normal(size=(m, 3)), axis=0), degree, weights)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_by_arc_length_the_speed_is_one_and_the_bend_is_the_curvature(seed, rational):
    curve = random_curve(seed, rational=rational)
    natural = NaturalCurve(curve)
    s = np.linspace(0.0, natural.length, 50)
    jet = natural.jet(s, 2)
    assert np.allclose(np.linalg.norm(jet[:, 1], axis=1), 1.0, atol=1e-14)
    bend = np.linalg.norm(jet[:, 2], axis=1)
    assert np.allclose(bend, curvature(curve, natural.arc_length.u(s)), rtol=1e-11)
    across = np.abs(np.sum(jet[:, 1] * jet[:, 2], axis=1))
    assert (across <= 1e-12 * (1.0 + bend) ** 3).all()
    assert np.allclose(jet[:, 0], curve.at(natural.arc_length.u(s)), atol=1e-15)
    assert np.array_equal(natural.at(s, 1), jet[:, 1])


@pytest.mark.parametrize("order", [0, 1, 2])
def test_each_derivative_is_that_of_the_one_before(order):
    natural = NaturalCurve(random_curve(4, degree=5, rational=True))
    s = natural.length * np.array([0.11, 0.37, 0.52, 0.93])
    h = 1e-5 * natural.length
    slope = (natural.at(s + h, order) - natural.at(s - h, order)) / (2.0 * h)
    wanted = natural.at(s, order + 1)
    assert np.allclose(slope, wanted, rtol=0, atol=1e-5 * (1.0 + np.abs(wanted).max()))


def test_a_circle_by_arc_length():
    natural = NaturalCurve(conic.circle(2.0), closed=True)
    s = np.array([-30.0, -1.0, 0.0, 0.5, 4.0 * np.pi, 100.0])
    angle = 0.5 * s
    around = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    onward = np.stack((-np.sin(angle), np.cos(angle)), axis=1)
    for order, wanted in enumerate((2.0 * around, onward, -0.5 * around, -0.25 * onward)):
        assert np.allclose(natural.at(s, order), wanted, rtol=0, atol=1e-12)
    assert natural.domain == (0.0, natural.length)
    assert natural.dim == 2
    assert np.allclose(natural.breaks, np.pi * np.arange(5))


@pytest.mark.property
@settings(max_examples=12, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 5),
    st.booleans(),
    st.sampled_from([1e-2, 1e-5, 1e-8]),
)
def test_the_spline_keeps_its_tolerance(seed, degree, rational, tolerance):
    natural = NaturalCurve(random_curve(seed, degree, rational))
    spline = natural.to_bspline(tolerance)
    assert spline.domain[0] == 0.0
    assert spline.domain[1] == pytest.approx(natural.length, rel=1e-15)
    s = np.linspace(*spline.domain, 3000)
    off = np.linalg.norm(spline.at(s) - natural.at(s), axis=1)
    assert off.max() <= tolerance
    assert spline.degree == 5


def test_the_spline_is_c2_where_the_curve_is():
    spline = NaturalCurve(random_curve(1)).to_bspline(1e-6)
    counts = np.unique(spline.knots[6:-6], return_counts=True)[1]
    assert counts.max() == 3
    # and where direction jumps, it does not
    corner = BSpline([0, 0, 1, 2, 2], [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]], 1)
    spline = NaturalCurve(corner).to_bspline(1e-6)
    assert np.allclose(spline.at([0.5, 1.0, 2.0]), [[0.5, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert np.count_nonzero(np.isclose(spline.knots, 1.0)) == 5
    # a full circle has double knots and yet is smooth
    spline = NaturalCurve(conic.circle(1.0)).to_bspline(1e-6)
    assert np.unique(spline.knots[6:-6], return_counts=True)[1].max() == 3


def test_cusps_and_wrong_questions_are_refused():
    points = [[1, -1], [-1 / 3, 1], [-1 / 3, -1], [1, 1]]
    cusp = NaturalCurve(BSpline([-1, -1, -1, -1, 1, 1, 1, 1], points, 3))
    middle = 0.5 * cusp.length
    assert np.allclose(cusp.at(middle), 0.0, atol=1e-12)
    with pytest.raises(CurveError, match="stands still"):
        cusp.to_bspline(1e-9)
    with pytest.raises(CurveError, match=r"stands still at u = 0\.0"):
        NaturalCurve(BSpline([0, 0, 0, 1, 1, 1], [[0.0], [0.0], [1.0]], 2)).at(0.0, 1)
    line = NaturalCurve(conic.line([0.0, 0.0], [3.0, 4.0]))
    with pytest.raises(ValueError, match="tolerance"):
        line.to_bspline(0.0)
    with pytest.raises(ValueError, match="order: want 0 to 3"):
        line.at(0.0, 4)
    with pytest.raises(CurveError, match="not to 6"):
        line.at(6.0)
    with pytest.raises(CurveError, match="cannot be met"):
        NaturalCurve(random_curve(2)).to_bspline(1e-18)
