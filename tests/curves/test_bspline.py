import numpy as np
import pytest
import scipy.interpolate
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import basis
from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel


@st.composite
def curves(draw, min_degree=0):
    """Clamped and unclamped curves of degree up to 6, inner knots repeated now and then."""
    degree = draw(st.integers(min_degree, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    spans = draw(st.integers(1, 6))
    breaks = np.cumsum(rng.uniform(0.2, 1.5, spans + 1))
    counts = rng.integers(1, max(degree, 1) + 1, spans - 1)
    if draw(st.booleans()):
        ends = breaks[[0] * (degree + 1)], breaks[[-1] * (degree + 1)]
    else:
        ends = (
            breaks[0] - np.cumsum(rng.uniform(0.1, 1.0, degree))[::-1],
            breaks[-1] + np.cumsum(rng.uniform(0.1, 1.0, degree)),
        )
        ends = np.append(ends[0], breaks[0]), np.append(breaks[-1], ends[1])
    knots = np.concatenate((ends[0], np.repeat(breaks[1:-1], counts), ends[1]))
    return BSpline(knots, rng.normal(size=(len(knots) - degree - 1, 3)), degree)


def inside(curve, count=57):
    return np.linspace(*curve.domain, count)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(), st.integers(0, 4))
def test_values_and_derivatives_are_those_of_scipy(curve, order):
    if order > curve.degree:
        assert not curve.at(inside(curve), order).any()
        return
    peer = scipy.interpolate.BSpline(curve.knots, curve.points, curve.degree)
    # scipy may take the other side at a knot where the derivative jumps
    u = np.setdiff1d(inside(curve), curve.breaks[1:-1])
    theirs = peer(u, nu=order)
    assert np.allclose(curve.at(u, order), theirs, rtol=1e-12, atol=1e-13 * np.abs(theirs).max())


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves())
def test_one_parameter_gives_what_many_give(curve):
    u = inside(curve, 7)
    for order in range(3):
        one_by_one = [curve.at(float(x), order) for x in u]
        assert np.allclose(one_by_one, curve.at(u, order), rtol=1e-13, atol=1e-13)
    assert curve.at(u.reshape(7, 1)).shape == (7, 1, 3)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves())
def test_basis_functions_are_a_partition_of_unity(curve):
    u = inside(curve)
    spans = basis.find_spans(curve.knots, curve.degree, u)
    values = basis.basis_values(curve.knots, curve.degree, spans, u)
    assert (values >= -1e-15).all()
    assert np.allclose(values.sum(axis=1), 1.0, atol=1e-14)
    rates = basis.basis_values(curve.knots, curve.degree, spans, u, 1)
    assert np.allclose(rates.sum(axis=1), 0.0, atol=1e-12 * max(1.0, np.abs(rates).max()))


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(min_degree=1))
def test_the_derivative_curve_is_the_derivative(curve):
    u = np.setdiff1d(inside(curve), curve.breaks)
    scale = max(1.0, np.abs(curve.at(u, 1)).max())
    assert np.allclose(curve.derivative().at(u), curve.at(u, 1), atol=1e-12 * scale)
    twice = curve.derivative(2)
    scale = max(1.0, np.abs(curve.at(u, 2)).max())
    assert np.allclose(twice.at(u), curve.at(u, 2), atol=1e-11 * scale)
    step = 1e-6
    u = u[np.abs(u[:, None] - curve.breaks).min(axis=1) > step]
    slope = (curve.at(u + step) - curve.at(u - step)) / (2.0 * step)
    assert np.allclose(slope, curve.at(u, 1), atol=1e-5 * scale)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(min_degree=1), st.lists(st.integers(0, 64), min_size=1, max_size=4))
def test_knot_insertion_changes_nothing(curve, shares):
    start, end = curve.domain
    us = [start + share / 64 * (end - start) for share in sorted(set(shares))]
    us = [min(u, end) for u in us if np.count_nonzero(curve.knots == u) < curve.degree]
    finer = curve.with_knots(us)
    assert len(finer.points) == len(curve.points) + len(us)
    assert np.allclose(finer.at(inside(curve)), curve.at(inside(curve)), atol=1e-13)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves())
def test_bezier_pieces_are_the_curve(curve):
    ends, pieces = curve.bezier()
    assert np.array_equal(ends, curve.breaks)
    for a, b, points in zip(ends[:-1], ends[1:], pieces, strict=True):
        t = np.linspace(0.0, 1.0, 9)[1:-1]
        level = np.repeat(points[:, None], len(t), axis=1)
        while len(level) > 1:  # de Casteljau
            level = level[:-1] * (1.0 - t)[:, None] + level[1:] * t[:, None]
        assert np.allclose(level[0], curve.at(a + t * (b - a)), atol=1e-13)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(), st.floats(0.01, 0.99))
def test_split_pieces_are_the_curve(curve, share):
    start, end = curve.domain
    u = start + share * (end - start)
    for piece in curve.split(u):
        at = inside(piece)[1:-1]
        assert np.allclose(piece.at(at), curve.at(at), atol=1e-13)
        assert (piece.knots[: curve.degree + 1] == piece.domain[0]).all()
    assert curve.split(u)[0].domain == (start, u)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(min_degree=1))
def test_taylor_pieces_are_the_curve(curve):
    ends, coefficients = basis.taylor_pieces(curve.knots, curve.points, curve.degree)
    for a, b, c in zip(ends[:-1], ends[1:], coefficients, strict=True):
        u = np.linspace(a, b, 9)[1:-1]
        value = sum(c[j] * (u - a)[:, None] ** j for j in range(len(c)))
        assert np.allclose(value, curve.at(u), atol=1e-12)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(), st.floats(0.0, 5.0, exclude_min=True))
def test_nothing_is_extrapolated(curve, beyond):
    start, end = curve.domain
    for u in (start - beyond, end + beyond):
        if start <= u <= end:
            continue  # lost in rounding
        with pytest.raises(CurveError, match="defined from"):
            curve.at(u)
        with pytest.raises(CurveError):
            curve.at(np.array([start, u]))
    with pytest.raises(CurveError):
        curve.at(float("nan"))


def test_the_error_names_parameter_and_domain():
    line = BSpline([0.0, 0.0, 2.0, 2.0], [[0.0], [1.0]], 1)
    with pytest.raises(CurveError, match=r"defined from 0\.0 to 2\.0, not at 2\.5"):
        line.at([1.0, 2.5])


@pytest.mark.parametrize(
    ("knots", "points", "degree"),
    [
        ([0, 0, 1, 0.5], [[0.0], [1.0]], 1),
        ([0, 0, 0, 0], [[0.0], [1.0]], 1),
        ([0, 0, 0.5, 0.5, 0.5, 1, 1], np.zeros((5, 1)), 1),
        ([0, 0, 1], [[0.0], [1.0]], 1),
        ([0, 0, float("nan"), 1], [[0.0], [1.0]], 1),
        ([0, 0, 1, 1], [[0.0], [float("nan")]], 1),
        ([0, 1, 2, 3], np.zeros((1, 2)), 2),
        ([0, 0, 1, 1], np.zeros((2, 0)), 1),
        ([0, 1], np.zeros((2, 1)), -1),
    ],
)
def test_what_is_no_curve_is_refused(knots, points, degree):
    with pytest.raises(ValueError, match=r"knots|points|degree"):
        BSpline(knots, points, degree)


def test_a_degree_is_a_whole_number():
    with pytest.raises(TypeError):
        BSpline([0, 0, 1, 1], [[0.0], [1.0]], 1.0)


def test_a_knot_cannot_be_there_more_often_than_the_degree():
    line = BSpline([0.0, 0.0, 1.0, 2.0, 2.0], [[0.0], [1.0], [0.0]], 1)
    with pytest.raises(ValueError, match="more than 1 times"):
        line.with_knots([1.0])


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(1, 5), st.integers(2, 9), st.integers(0, 999))
def test_a_ring_of_points_makes_a_closed_curve(degree, m, seed):
    rng = np.random.default_rng(seed)
    knots = np.concatenate(([0.0], np.cumsum(rng.uniform(0.5, 1.5, m))))
    ring = BSpline.closed(knots, rng.normal(size=(m, 2)), degree)
    assert ring.domain == (0.0, knots[-1])
    assert ring.is_closed(degree - 1, 1e-10)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(min_degree=2))
def test_lengths_add_up(curve):
    start, end = curve.domain
    middle = start + 0.37 * (end - start)
    whole = curve.length()
    assert curve.length(start, middle) + curve.length(middle, end) == pytest.approx(
        whole, rel=1e-12
    )
    assert curve.length(end, start) == -whole
    at = np.union1d(np.linspace(start, end, 3000), curve.breaks)
    chords = np.linalg.norm(np.diff(curve.at(at), axis=0), axis=1)
    assert chords.sum() == pytest.approx(whole, rel=1e-4)


def test_a_parabola_has_its_known_length():
    # y = x^2 from 0 to 1: sqrt(5)/2 + asinh(2)/4
    parabola = BSpline([0, 0, 0, 1, 1, 1], [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]], 2)
    assert parabola.length() == pytest.approx(np.sqrt(5) / 2 + np.arcsinh(2) / 4, rel=1e-14)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(curves(), st.integers(0, 2**32 - 1))
def test_rational_curves_are_quotients(curve, seed):
    weights = np.random.default_rng(seed).uniform(0.3, 3.0, len(curve.points))
    nurbs = BSpline(curve.knots, curve.points, curve.degree, weights)
    assert nurbs.dim == 3
    assert nurbs.homogeneous.shape == (len(weights), 4)
    rows = nurbs.homogeneous
    top = scipy.interpolate.BSpline(curve.knots, rows[:, :3], curve.degree)
    below = scipy.interpolate.BSpline(curve.knots, rows[:, 3:], curve.degree)
    u = np.setdiff1d(inside(curve), curve.breaks)
    A, w = top(u), below(u)
    A1, w1 = (top(u, nu=1), below(u, nu=1)) if curve.degree else (0.0 * A, 0.0 * w)
    A2, w2 = (top(u, nu=2), below(u, nu=2)) if curve.degree > 1 else (0.0 * A, 0.0 * w)
    C = A / w
    C1 = (A1 - w1 * C) / w
    C2 = (A2 - 2.0 * w1 * C1 - w2 * C) / w
    jet = nurbs.jet(u, 2)
    for order, wanted in enumerate((C, C1, C2)):
        scale = max(1.0, np.abs(wanted).max())
        assert np.allclose(jet[:, order], wanted, rtol=0, atol=1e-12 * scale)
        assert np.array_equal(nurbs.at(u, order), nurbs.jet(u, order)[:, order])
    back = BSpline.from_homogeneous(curve.knots, rows, curve.degree)
    assert np.allclose(back.points, nurbs.points, rtol=1e-15, atol=1e-15)


def test_a_rational_curve_of_the_nurbs_book():
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, ex. 4.1
    knots, points = [0, 0, 0, 1, 2, 3, 3, 3], [[0, 0], [1, 1], [3, 2], [4, 1], [5, -1]]
    curve = BSpline(knots, points, 2, [1, 4, 1, 1, 1])
    assert curve.at(1.0) == pytest.approx([7 / 5, 6 / 5], abs=1e-15)
    assert curve.at(0.0).tolist() == [0.0, 0.0]
    assert curve.at(3.0).tolist() == [5.0, -1.0]
    # without its weight the second point pulls less
    assert BSpline(knots, points, 2).at(1.0).tolist() == [2.0, 1.5]


def test_derivatives_of_the_quarter_circle_of_the_nurbs_book():
    # Piegl and Tiller, ex. 4.2
    quarter = BSpline([0, 0, 0, 1, 1, 1], [[1, 0], [1, 1], [0, 1]], 2, [1, 1, 2])
    ends = np.array([0.0, 1.0])
    np.testing.assert_allclose(quarter.at(ends, 1), [[0, 2], [-1, 0]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(quarter.at(ends, 2), [[-4, 0], [1, -1]], rtol=0, atol=1e-14)
    jets = quarter.jet(ends, 2)
    np.testing.assert_allclose(jets[:, 1:], [[[0, 2], [-4, 0]], [[-1, 0], [1, -1]]], atol=1e-14)


def test_equal_weights_change_nothing():
    rng = np.random.default_rng(2)
    points = rng.normal(size=(6, 2))
    plain = BSpline([0, 0, 0, 0, 1, 2, 3, 3, 3, 3], points, 3)
    nurbs = BSpline(plain.knots, points, 3, np.full(6, 0.25))
    u = np.linspace(0.0, 3.0, 50)
    for order in range(5):
        assert np.allclose(nurbs.at(u, order), plain.at(u, order), rtol=0, atol=1e-13)
    assert plain.homogeneous[:, -1].tolist() == [1.0] * 6
    assert not plain.is_rational


def test_a_circle_of_weights_is_round(circle):
    u = np.linspace(0.0, 4.0, 1001)
    assert np.abs(np.linalg.norm(circle.at(u), axis=1) - 1.0).max() < 1e-15
    assert circle.length() == pytest.approx(2.0 * np.pi, rel=1e-15)
    assert circle.at(1.5, 1) @ circle.at(1.5) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("weights", [[1.0, 0.0], [1.0, -2.0], [1.0, float("nan")], [1.0], 1.0])
def test_weights_are_positive_numbers(weights):
    with pytest.raises(ValueError, match="weights: want"):
        BSpline([0, 0, 1, 1], [[0.0], [1.0]], 1, weights)
    with pytest.raises(ValueError, match="weights: want"):
        BSpline.closed([0.0, 1.0, 2.0], [[0.0], [1.0]], 1, weights)


def test_homogeneous_points_have_positive_weights():
    with pytest.raises(ValueError, match="rows: want each weight above 0"):
        BSpline.from_homogeneous([0, 0, 1, 1], [[0.0, 1.0], [1.0, 0.0]], 1)
    with pytest.raises(ValueError, match="order: want 0 or more"):
        BSpline([0, 0, 1, 1], [[0.0], [1.0]], 1).jet(0.5, -1)


def test_points_may_come_in_any_order():
    points = np.array([[0.0, 1.0, 3.0], [2.0, 2.0, 0.0]]).T
    curve = BSpline([0, 0, 0, 1, 1, 1], points, 2)
    assert np.array_equal(curve.with_knots([0.5]).points[0], [0.0, 2.0])
    assert np.array_equal(curve.reversed().sampler().sample(0.0, 0), [[3.0, 0.0]])
