from math import asinh, hypot, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.arc_length import ArcLength
from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel

EXACT = 1e-13


def clamped(points, degree, weights=None):
    m = len(points)
    inner = np.linspace(0.0, 1.0, m - degree + 1)
    knots = np.concatenate((np.zeros(degree), inner, np.ones(degree)))
    return BSpline(knots, points, degree, weights)


def random_curve(seed, m=12, degree=3, dim=3, rational=False):
    rng = np.random.default_rng(seed)
    weights = rng.uniform(0.3, 3.0, m) if rational else None
    return clamped(rng.normal(size=(m, dim)), degree, weights)


def check_both_ways(curve, length_to, tolerance=EXACT):
    """Against the exact length from the start to u: the map, its inverse and the whole."""
    arc = ArcLength(curve)
    start, end = curve.domain
    whole = length_to(end)
    assert arc.length == pytest.approx(whole, rel=tolerance)
    u = np.linspace(start, end, 101)
    exact = np.array([length_to(x) for x in u])
    assert np.abs(arc.s(u) - exact).max() <= tolerance * whole
    s = np.linspace(0.0, arc.length, 101)
    back = np.array([length_to(x) for x in arc.u(s)])
    assert np.abs(back - s).max() <= tolerance * whole


def test_the_length_of_a_line_is_even():
    curve = conic.line([1.0, 2.0], [4.0, 6.0])
    check_both_ways(curve, lambda u: 5.0 * u)
    assert ArcLength(curve).u(2.5) == pytest.approx(0.5)


def test_the_length_of_a_circle_is_its_angle_times_its_radius():
    curve = conic.arc(2.0, 0.3, 0.3 + 1.9 * pi)
    start = curve.at(0.0)

    def exact(u):
        x, y = curve.at(u)
        angle = np.arctan2(start[0] * y - start[1] * x, start @ [x, y]) % (2.0 * pi)
        return 2.0 * angle if u > 0.0 else 0.0

    check_both_ways(curve, exact)


def test_the_length_of_a_parabola_has_a_closed_form():
    # (v^2, 2 v) f: f (v sqrt(1 + v^2) + asinh v)
    def primitive(v):
        return 0.7 * (v * hypot(1.0, v) + asinh(v))

    check_both_ways(
        conic.parabola(0.7, -3.0, 40.0), lambda u: primitive(-3.0 + 43.0 * u) - primitive(-3.0)
    )


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_cusp_is_passed(scale):
    # (u^2, u^3) for u from -1 to 1: length (4 + 9 u^2)^(3/2) / 27 - 8/27 from the cusp
    points = scale * np.array([[1.0, -1.0], [-1 / 3, 1.0], [-1 / 3, -1.0], [1.0, 1.0]])
    curve = BSpline([-1, -1, -1, -1, 1, 1, 1, 1], points, 3)

    def from_cusp(u):
        return scale * np.sign(u) * u * u * _away(u)

    check_both_ways(curve, lambda u: from_cusp(u) - from_cusp(-1.0))


def _away(u):
    # ((4 + 9 u^2)^(3/2) - 8) / 27 / u^2 without cancellation
    square = 9.0 * u * u
    root = sqrt(4.0 + square)
    return (root**2 + 2.0 * root + 4.0) / (3.0 * (root + 2.0))


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_a_near_cusp_is_passed(gap):
    # (u^2 / 2, gap u): a parabola so slim that it nearly turns back
    points = [[0.5, -gap], [-0.5, 0.0], [0.5, gap]]
    curve = BSpline([-1, -1, -1, 1, 1, 1], points, 2)

    def from_tip(u):
        return 0.5 * (u * hypot(gap, u) + gap * gap * asinh(u / gap))

    check_both_ways(curve, lambda u: from_tip(u) - from_tip(-1.0))


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 6),
    st.integers(2, 3),
    st.booleans(),
    st.integers(-12, 12),
)
def test_lengths_are_those_of_quadrature(seed, degree, dim, rational, decade):
    curve = random_curve(seed, 9, degree, dim, rational)
    scaled = BSpline(curve.knots, curve.points * 10.0**decade, degree, curve.weights)
    arc = ArcLength(scaled)
    whole = scaled.length()
    assert arc.length == pytest.approx(whole, rel=EXACT)
    u = np.random.default_rng(seed).uniform(0.0, 1.0, 5)
    exact = np.array([scaled.length(0.0, float(x)) for x in u])
    assert np.abs(arc.s(u) - exact).max() <= EXACT * whole
    s = u * arc.length
    there = np.array([scaled.length(0.0, float(x)) for x in arc.u(s)])
    assert np.abs(there - s).max() <= EXACT * whole


@pytest.mark.slow
@pytest.mark.parametrize("rational", [False, True])
def test_lengths_are_those_of_quadrature_on_many_curves(rational):
    for seed in range(40):
        curve = random_curve(seed, 20, 1 + seed % 9, 2 + seed % 3, rational)
        arc, whole = ArcLength(curve), curve.length()
        u = np.random.default_rng(seed).uniform(0.0, 1.0, 6)
        exact = np.array([curve.length(0.0, float(x)) for x in u])
        assert np.abs(arc.s(u) - exact).max() <= 1e-13 * whole
        s = u * arc.length
        there = np.array([curve.length(0.0, float(x)) for x in arc.u(s)])
        assert np.abs(there - s).max() <= 1e-13 * whole


@pytest.mark.property
@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_there_and_back_is_where_one_was(seed, rational):
    curve = random_curve(seed, rational=rational)
    arc = ArcLength(curve)
    s = np.sort(np.random.default_rng(seed).uniform(0.0, arc.length, 500))
    u = arc.u(s)
    assert (np.diff(u) >= 0.0).all()
    assert np.abs(arc.s(u) - s).max() <= EXACT * arc.length
    assert np.array_equal(arc.u(s[::-1]), u[::-1])


@pytest.mark.property
@settings(max_examples=6, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0), st.floats(-1e3, 1e3))
def test_a_moved_curve_and_one_with_more_knots_have_the_same_length(seed, angle, shift):
    curve = random_curve(seed)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved = BSpline(curve.knots, curve.points @ turn.T + shift, 3)
    arc, other = ArcLength(curve), ArcLength(moved)
    u = np.linspace(0.0, 1.0, 31)
    assert np.allclose(arc.s(u), other.s(u), rtol=0, atol=1e-12 * arc.length)
    more = ArcLength(curve.with_knots([0.123, 0.5, 0.777]))
    assert np.allclose(arc.s(u), more.s(u), rtol=0, atol=EXACT * arc.length)
    backwards = ArcLength(BSpline(1.0 - curve.knots[::-1], curve.points[::-1], 3))
    whole = arc.length - backwards.s(1.0 - u)
    assert np.allclose(arc.s(u), whole, rtol=0, atol=EXACT * arc.length)


def test_ends_are_exact_and_shapes_are_kept():
    curve = random_curve(3)
    arc = ArcLength(curve)
    assert arc.s(0.0) == 0.0
    assert arc.s(1.0) == arc.length
    assert arc.u(arc.length) == 1.0
    assert np.shape(arc.u(0.3)) == ()
    assert arc.u(np.zeros((2, 0, 3))).shape == (2, 0, 3)
    u = np.linspace(0.0, 1.0, 6).reshape(2, 3)
    assert np.array_equal(arc.s(u).ravel(), arc.s(u.ravel()))


def test_a_closed_curve_goes_round_and_round():
    arc = ArcLength(conic.circle(0.5), closed=True)
    s = np.array([-7.0, -pi, -0.1, 0.0, 0.1, pi, 100.0])
    u = arc.u(s)
    assert np.allclose(arc.s(u), s, rtol=0, atol=1e-12)
    assert np.allclose(u[2], -u[4], atol=1e-15)
    assert u[5] == pytest.approx(1.0)
    # a full turn is a full turn of the parameter
    assert np.allclose(arc.u(s + arc.length), u + 1.0, atol=1e-12)


def test_where_a_curve_stands_still_the_parameter_goes_on():
    # four equal control points: the cubic does not move between 1 and 2
    points = [[0.0], [1.0], [2.0], [2.0], [2.0], [2.0], [3.0], [5.0]]
    curve = BSpline([0, 0, 0, 0, 1, 2, 3, 4, 5, 5, 5, 5], points, 3)
    u0, u1 = 2.0, 3.0
    assert np.array_equal(curve.at(np.array([u0, 2.5, u1])), [[2.0], [2.0], [2.0]])
    arc = ArcLength(curve)
    assert arc.length == pytest.approx(5.0)
    assert np.allclose(arc.s(np.array([u0, 2.5, u1])), 2.0, atol=1e-15)
    assert arc.u(2.0 - 1e-12) <= u0 + 1e-9
    assert arc.u(2.0 + 1e-12) >= u1 - 1e-9
    # at the very end the parameter where it stopped
    stops = BSpline([0, 0, 1, 2, 2], [[0.0], [3.0], [3.0]], 1)
    assert ArcLength(stops).u(3.0) == 1.0
    assert ArcLength(stops).s(1.5) == pytest.approx(3.0)


def test_a_slow_start_does_not_hurt():
    # u^3: the first three control points are one
    curve = BSpline([0, 0, 0, 0, 1, 1, 1, 1], [[0.0], [0.0], [0.0], [1.0]], 3)
    arc = ArcLength(curve)
    u = np.linspace(0.0, 1.0, 50)
    assert np.allclose(arc.s(u), u**3, rtol=0, atol=1e-15)
    s = np.linspace(0.0, 1.0, 50)
    assert np.allclose(arc.u(s) ** 3, s, rtol=0, atol=1e-15)
    assert np.allclose(arc.u(s[1:]), s[1:] ** (1 / 3), rtol=1e-10)


@pytest.mark.parametrize(
    ("ask", "why"),
    [
        (lambda arc: arc.u(-1e-9), "lengths go from 0.0 to .*, not to -1e-09"),
        (lambda arc: arc.u([1.0, 6.0]), "not to 6.0"),
        (lambda arc: arc.u(float("nan")), "not to nan"),
        (lambda arc: arc.s([0.5, 1.5]), "parameters go from 0.0 to 1.0, not to 1.5"),
    ],
)
def test_what_lies_outside_is_refused(ask, why):
    with pytest.raises(CurveError, match=why):
        ask(ArcLength(conic.line([0.0, 0.0], [3.0, 4.0])))


# numbers of plain Python warn where compiled ones do not
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_curves_without_length_are_refused():
    with pytest.raises(CurveError, match="no length"):
        ArcLength(BSpline([0, 0, 1, 1], np.ones((2, 3)), 1))
    with pytest.raises(CurveError, match="degree 0"):
        ArcLength(BSpline([0, 1, 2], [[1.0], [2.0]], 0))
    weights = np.array([1e-170] * 7 + [1.0])
    with pytest.raises(CurveError, match="weights differ too much"):
        ArcLength(clamped(np.random.default_rng(0).normal(size=(8, 2)), 3, weights))
    with pytest.raises(CurveError, match="not closed"):
        ArcLength(conic.line([0.0], [1.0]), closed=True)


KERNELS = """
import numpy as np
from splinearm.curves import BSpline, conic
from splinearm.curves.arc_length import ArcLength
points = np.random.default_rng(5).normal(size=(5, 3))
knots = [0, 0, 0, 0, 0.4, 1, 1, 1, 1]
cusp = [[1.0, -1.0], [-1 / 3, 1.0], [-1 / 3, -1.0], [1.0, 1.0]]
found = []
for curve in (BSpline(knots, points, 3), conic.ellipse(3.0, 1.0),
              BSpline([0, 0, 0, 0, 1, 1, 1, 1], cusp, 3)):
    arc = ArcLength(curve)
    x = np.linspace(0.0, 1.0, 40)
    found += [arc.s(x), curve.at(arc.u(x * arc.length))]
"""


def test_compiled_and_plain_kernels_agree(compiled_as_plain):
    compiled_as_plain(KERNELS, 6)
