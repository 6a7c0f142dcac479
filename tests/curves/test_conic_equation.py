import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.conic_equation import ConicEquation
from splinearm.curves.conic_form import ConicKind
from splinearm.curves.plane import Plane
from splinearm.errors import CurveError

K = ConicKind

KNOWN = [
    ([1, 0, 1, 0, 0, -4], K.CIRCLE),
    ([1, 0, 1, -2, 4, 1], K.CIRCLE),
    ([4, 0, 9, 0, 0, -36], K.ELLIPSE),
    ([5, -6, 5, 0, 0, -8], K.ELLIPSE),
    ([0, 1, 0, 0, 0, -1], K.HYPERBOLA),
    ([1, 0, -1, 0, 0, 1], K.HYPERBOLA),
    ([0, 0, 1, -4, 0, 0], K.PARABOLA),
    ([1, 2, 1, -1, 1, 0], K.PARABOLA),
    ([1, 0, 1, 0, 0, 0], K.POINT),
    ([1, 0, 2, -2, -8, 9], K.POINT),
    ([1, 0, -1, 0, 0, 0], K.CROSSING_LINES),
    ([0, 1, 0, -2, -3, 6], K.CROSSING_LINES),
    ([1, 0, 0, 0, 0, -1], K.PARALLEL_LINES),
    ([1, 2, 1, -3, -3, 2], K.PARALLEL_LINES),
    ([1, -2, 1, 0, 0, 0], K.DOUBLE_LINE),
    ([4, 4, 1, 4, 2, 1], K.DOUBLE_LINE),
    ([0, 0, 0, 1, 2, 3], K.LINE),
    ([1, 0, 1, 0, 0, 1], K.NOTHING),
    ([1, 0, 0, 0, 0, 1], K.NOTHING),
    ([0, 0, 0, 0, 0, 1], K.NOTHING),
]


def moved(coefficients, angle, shift, scale, factor):
    """The same points turned, shifted and scaled, the equation times a factor."""
    a, b, c, d, e, f = coefficients
    M = np.array([[a, b / 2, d / 2], [b / 2, c, e / 2], [d / 2, e / 2, f]], dtype=float)
    co, si = np.cos(angle), np.sin(angle)
    T = np.array([[co, -si, shift[0]], [si, co, shift[1]], [0, 0, 1]]) @ np.diag([scale, scale, 1])
    back = np.linalg.inv(T)
    N = factor * back.T @ M @ back
    return [N[0, 0], 2 * N[0, 1], N[1, 1], 2 * N[0, 2], 2 * N[1, 2], N[2, 2]]


@pytest.mark.parametrize(("coefficients", "kind"), KNOWN)
def test_an_equation_tells_its_kind(coefficients, kind):
    assert ConicEquation(coefficients).form().kind is kind


@pytest.mark.property
@settings(max_examples=150, deadline=None)
@given(
    st.sampled_from(KNOWN),
    st.floats(-4.0, 4.0),
    st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)),
    st.integers(-9, 9),
    st.integers(-9, 9),
    st.sampled_from([1.0, -1.0]),
)
def test_the_kind_depends_on_no_unit_place_or_factor(known, angle, shift, decade, power, sign):
    coefficients, kind = known
    unit, factor = 10.0**decade, sign * 10.0**power
    turned = moved(coefficients, angle, np.array(shift) * unit, unit, factor)
    # what goes through the origin up to rounding has no size but that of rounding
    terms = np.abs(turned) * [unit**2, unit**2, unit**2, unit, unit, 1.0]
    assume(kind in (K.LINE, K.NOTHING) or terms[3:].max() > 1e-3 * terms[:3].max())
    form, straight = ConicEquation(turned).form(), ConicEquation(coefficients).form()
    assert form.kind is kind
    scale = unit if kind is not K.CROSSING_LINES else 1.0
    assert form.a == pytest.approx(straight.a * scale)
    assert form.b == pytest.approx(straight.b * scale)
    if kind in (K.CIRCLE, K.ELLIPSE, K.HYPERBOLA, K.PARABOLA):
        c, s = np.cos(angle), np.sin(angle)
        foci = (straight.foci @ [[c, s], [-s, c]] + shift) * unit
        gaps = np.linalg.norm(form.foci[:, None] - foci, axis=2)
        assert gaps.min(axis=0).max() < 1e-9 * unit


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([known for known in KNOWN if known[1] not in (K.POINT, K.NOTHING)]),
    st.floats(-4.0, 4.0),
    st.sampled_from([1, -1]),
)
def test_a_curve_made_from_an_equation_fulfils_it(known, angle, branch):
    equation = ConicEquation(moved(known[0], angle, (1.0, -2.0), 1.0, 1.0))
    curve = equation.form().curve(-1.0, 1.5, branch)
    points = curve.at(np.linspace(*curve.domain, 101))
    terms = np.abs(equation.coefficients).max() * (1.0 + np.abs(points).max()) ** 2
    assert np.abs(equation.value(points)).max() < 2e-14 * terms


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([K.CIRCLE, K.ELLIPSE, K.PARABOLA, K.HYPERBOLA]),
    st.floats(0.1, 5.0),
    st.floats(0.1, 5.0),
    st.floats(-3.0, 3.0),
)
def test_a_curve_gives_its_equation_and_that_its_form(kind, a, b, angle):
    assume(abs(a - b) > 1e-3)
    a, b = max(a, b), min(a, b)
    plane = Plane.turned((3.0, -1.0), angle)
    curve = {
        K.CIRCLE: lambda: conic.arc(a, 0.2, 3.0, plane),
        K.ELLIPSE: lambda: conic.elliptic_arc((a, b), -1.0, 1.2, plane),
        K.PARABOLA: lambda: conic.parabola(a, -1.0, 2.0, plane),
        K.HYPERBOLA: lambda: conic.hyperbola((a, b), -1.0, 1.3, plane),
    }[kind]()
    form = ConicEquation.of(curve).form(1e-9)
    assert form.kind is kind
    assert form.a == pytest.approx(a, rel=1e-7)
    assert np.allclose(form.centre, plane.origin, atol=1e-7 * a / min(b, 1.0))
    if kind is not K.PARABOLA:
        assert form.b == pytest.approx(a if kind is K.CIRCLE else b, rel=1e-7)
    if kind is not K.CIRCLE:
        turn = (form.turn - angle + np.pi / 2) % np.pi - np.pi / 2
        assert turn == pytest.approx(0.0, abs=1e-7 * a / (a - b) / b)


@pytest.mark.parametrize("away", [1e3, 1e6])
def test_a_circle_far_away_is_still_one(away):
    form = ConicEquation(moved([1, 0, 1, 0, 0, -1], 0.0, (away, -away), 1.0, 1.0)).form()
    assert form.kind is K.CIRCLE
    assert form.a == pytest.approx(1.0, rel=1e-15 * away**2)


def test_forms_have_centres_axes_and_foci():
    ellipse = ConicEquation([4, 0, 9, -8, 36, 4]).form()
    assert np.allclose(ellipse.centre, [1.0, -2.0])
    assert (ellipse.a, ellipse.b, ellipse.turn) == pytest.approx((3.0, 2.0, 0.0))
    assert ellipse.eccentricity == pytest.approx(np.sqrt(5.0) / 3.0)
    assert np.allclose(ellipse.foci, [[1 + np.sqrt(5), -2], [1 - np.sqrt(5), -2]])
    parabola = ConicEquation([1, 0, 0, 0, 4, 0]).form()
    assert np.allclose(parabola.centre, 0.0)
    assert np.allclose(parabola.foci, [[0.0, -1.0]])
    assert (parabola.eccentricity, parabola.turn) == (1.0, pytest.approx(-np.pi / 2))
    hyperbola = ConicEquation([-16, 0, 9, 0, 0, -144]).form()
    assert (hyperbola.a, hyperbola.b) == pytest.approx((4.0, 3.0))
    assert hyperbola.turn == pytest.approx(np.pi / 2)
    assert hyperbola.eccentricity == pytest.approx(1.25)
    slopes = hyperbola.lines[:, 1, 1] / hyperbola.lines[:, 1, 0]
    assert sorted(slopes) == pytest.approx([-4 / 3, 4 / 3])
    circle = ConicEquation([2, 0, 2, -4, 0, -6]).form()
    assert (circle.eccentricity, circle.a) == (0.0, pytest.approx(2.0))
    assert np.allclose(circle.foci, [[1.0, 0.0]])


def test_degenerate_forms_give_their_lines():
    crossing = ConicEquation([0, 1, 0, -2, -3, 6]).form()
    assert np.allclose(crossing.centre, [3.0, 2.0])
    assert np.allclose(sorted(np.abs(crossing.lines[:, 1]).tolist()), [[0, 1], [1, 0]], atol=1e-15)
    parallel = ConicEquation([1, 0, 0, -4, 0, 3]).form()
    assert sorted(parallel.lines[:, 0, 0]) == pytest.approx([1.0, 3.0])
    single = ConicEquation([0, 0, 0, 3, 4, -10]).form()
    assert np.allclose(single.centre, [1.2, 1.6])
    for form in (crossing, single):
        with pytest.raises(CurveError, match="no eccentricity"):
            _ = form.eccentricity
    for numbers in ([1, 0, 1, 0, 0, 0], [1, 0, 1, 0, 0, 1]):
        with pytest.raises(CurveError, match="no curve"):
            ConicEquation(numbers).form().curve()
    with pytest.raises(ValueError, match="branch"):
        crossing.curve(0.0, 1.0, 0)


@pytest.mark.property
@settings(max_examples=80, deadline=None)
@given(st.sampled_from(KNOWN), st.integers(0, 2**32 - 1), st.integers(-6, 6))
def test_meeting_points_lie_on_both(known, seed, decade):
    rng = np.random.default_rng(seed)
    unit = 10.0**decade
    equation = ConicEquation(moved(known[0], rng.uniform(-3, 3), (0.0, 0.0), unit, 1.0))
    point, direction = rng.normal(size=(2, 2))
    met = equation.meet_line(point * unit, direction)
    terms = np.abs(equation.coefficients) @ [
        *(np.abs(met.points).max(initial=unit) ** np.array([2, 2, 2, 1, 1, 0]))
    ]
    assert np.abs(equation.value(met.points)).max(initial=0.0) <= 1e-13 * terms
    along = (met.points / unit - point) @ direction
    assert (np.diff(along) > 0.0).all()
    off = (met.points / unit - point) @ [-direction[1], direction[0]]
    assert np.allclose(off, 0.0, atol=1e-12 * (1.0 + np.abs(along).max(initial=0.0)))
    # the parity that the sign of the equation far away on both sides asks for
    far = equation.value(unit * (point + 1e7 * np.array([[1.0], [-1.0]]) * direction))
    if known[1] not in (K.DOUBLE_LINE, K.POINT) and not met.touches:
        assert len(met.points) % 2 == (far[0] * far[1] < 0.0)


def test_lines_touch_miss_and_lie_inside():
    circle = ConicEquation([1, 0, 1, 0, 0, -4])
    touch = circle.meet_line([2.0, -7.0], [0.0, 3.0])
    assert touch.touches
    assert np.allclose(touch.points, [[2.0, 0.0]])
    assert len(circle.meet_line([3.0, 0.0], [0.0, 1.0]).points) == 0
    hyperbola = ConicEquation([0, 1, 0, 0, 0, -1])
    assert np.allclose(hyperbola.meet_line([0.5, 0.0], [0.0, 1.0]).points, [[0.5, 2.0]])
    asymptote = hyperbola.meet_line([0.0, 0.0], [0.0, 1.0])
    assert (len(asymptote.points), asymptote.contained) == (0, False)
    parabola = ConicEquation([1, 0, 0, 0, -1, 0])
    assert np.allclose(parabola.meet_line([3.0, 1.0], [0.0, 1.0]).points, [[3.0, 9.0]])
    lines = ConicEquation([0, 1, 0, -2, -3, 6])
    inside = lines.meet_line([3.0, 17.0], [0.0, 1.0])
    assert (len(inside.points), inside.contained) == (0, True)
    assert lines.meet_line([3.0, 2.0], [1.0, 1.0]).touches
    with pytest.raises(ValueError, match="direction"):
        circle.meet_line([0, 0], [0, 0])


def test_tangents_touch():
    ellipse = ConicEquation([4, 0, 9, -8, 36, 4])
    for v in np.linspace(0.0, 6.0, 7):
        p = np.array([1.0 + 3.0 * np.cos(v), -2.0 + 2.0 * np.sin(v)])
        l, m, n = ellipse.polar(p)
        assert l * p[0] + m * p[1] + n == pytest.approx(0.0, abs=1e-14)
        assert ellipse.meet_line(p, (-m, l)).touches
        outside = p + 1.3 * np.array([l, m])
        feet = ellipse.tangents_from(outside)
        assert len(feet) == 2
        for foot in feet:
            a, b, c = ellipse.polar(foot)
            assert a * outside[0] + b * outside[1] + c == pytest.approx(0.0, abs=1e-13)
    assert len(ellipse.tangents_from([1.1, -2.0])) == 0
    for centre in ([1.0, -2.0],):
        with pytest.raises(CurveError, match="no tangent or polar"):
            ellipse.polar(centre)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(st.sampled_from(KNOWN[:8]), st.integers(0, 2**32 - 1), st.integers(-6, 6))
def test_five_points_of_a_conic_give_it_back(known, seed, decade):
    rng = np.random.default_rng(seed)
    unit = 10.0**decade
    equation = ConicEquation(moved(known[0], 0.4, (unit, -unit), unit, 1.0))
    curve = equation.form().curve(-1.0, 1.0)
    points = curve.at((np.arange(5) + rng.uniform(0.2, 0.8, 5)) / 5)
    found = ConicEquation.through(points)
    ratio = found.coefficients @ equation.coefficients
    others = curve.at(np.linspace(0.0, 1.0, 50))
    slopes = np.linalg.norm(found.gradient(others), axis=1)
    assert (np.abs(found.value(others)) <= 1e-8 * unit * slopes).all()
    assert ratio != 0.0


def test_what_determines_no_conic_is_refused():
    with pytest.raises(CurveError, match="several conics"):
        ConicEquation.through([[0, 0], [1, 0], [2, 0], [3, 0], [1, 1]])
    with pytest.raises(CurveError, match="several conics"):
        ConicEquation.through([[0, 0], [1, 0], [2, 5], [3, 1], [1, 0]])
    with pytest.raises(CurveError, match="the same"):
        ConicEquation.through(np.ones((5, 2)))
    with pytest.raises(ValueError, match="0 = 0"):
        ConicEquation(np.zeros(6))
    knots = [0, 0, 0, 1, 1, 1]
    with pytest.raises(CurveError, match="straight"):
        ConicEquation.of(BSpline(knots, [[0, 0], [1, 1], [2, 2]], 2))
    with pytest.raises(CurveError, match="degree 2"):
        ConicEquation.of(conic.line([0, 0], [1, 1]))
    points = np.random.default_rng(0).normal(size=(5, 2))
    with pytest.raises(CurveError, match="several conics"):
        ConicEquation.of(BSpline([0, 0, 0, 1, 2, 3, 3, 3], points, 2))
