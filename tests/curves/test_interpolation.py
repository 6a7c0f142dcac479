import numpy as np
import pytest
import scipy.interpolate
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import banded
from splinearm.curves.interpolation import (
    EndDerivatives,
    choose_parameters,
    interpolate,
    interpolate_tangents,
)
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel


@st.composite
def point_sets(draw, least=2, most=14):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return rng.normal(size=(draw(st.integers(least, most)), draw(st.integers(1, 4))))


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(point_sets(), st.sampled_from(["chord", "centripetal", "uniform"]))
def test_a_natural_cubic_is_the_one_of_scipy(points, kind):
    u = choose_parameters(points, kind)
    curve = interpolate(points, parameters=kind)
    peer = scipy.interpolate.CubicSpline(u, points, bc_type="natural")
    at = np.linspace(0.0, u[-1], 101)
    assert np.allclose(curve.at(at), peer(at), atol=1e-12 * np.abs(points).max())


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(point_sets(least=3, most=120))
def test_a_closed_cubic_is_the_one_of_scipy(points):
    u = choose_parameters(points, closed=True)
    curve = interpolate(points, ends="closed")
    peer = scipy.interpolate.CubicSpline(u, np.vstack((points, points[:1])), bc_type="periodic")
    at = np.linspace(0.0, u[-1], 301)
    assert np.allclose(curve.at(at), peer(at), atol=1e-11 * np.abs(points).max())
    assert curve.is_closed(2, 1e-9)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(point_sets(least=7, most=60), st.integers(1, 6))
def test_free_curves_of_any_degree_pass_all_points(points, degree):
    curve = interpolate(points, degree=degree, parameters="uniform", ends="free")
    assert curve.degree == degree
    at = curve.at(np.arange(len(points), dtype=float))
    assert np.allclose(at, points, atol=1e-10)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(point_sets(least=3, most=40))
def test_given_end_derivatives_are_met(points):
    rng = np.random.default_rng(len(points))
    dim = points.shape[1]
    ends = EndDerivatives(rng.normal(size=(2, dim)), rng.normal(size=(2, dim)))
    curve = interpolate(points, degree=5, parameters="uniform", ends=ends)
    last = float(len(points) - 1)
    for order in (1, 2):
        assert np.allclose(curve.at(0.0, order), ends.start[order - 1], atol=1e-9)
        assert np.allclose(curve.at(last, order), ends.end[order - 1], atol=1e-9)
    assert np.allclose(curve.at(np.arange(len(points), dtype=float)), points, atol=1e-10)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(point_sets(least=5, most=20), st.integers(3, 6))
def test_the_ends_may_have_different_numbers_of_derivatives(points, degree):
    dim = points.shape[1]
    ends = EndDerivatives(np.ones((1, dim)), np.zeros((2, dim)))
    curve = interpolate(points, degree=degree, parameters="uniform", ends=ends)
    assert np.allclose(curve.at(0.0, 1), 1.0, atol=1e-8)
    assert np.allclose(curve.at(curve.domain[1], 1), 0.0, atol=1e-8)
    assert np.allclose(curve.at(curve.domain[1], 2), 0.0, atol=1e-7)


def test_a_clamped_cubic_is_the_one_of_scipy():
    points = np.random.default_rng(3).normal(size=(9, 2))
    slopes = np.array([[1.0, -2.0]]), np.array([[0.5, 0.0]])
    curve = interpolate(points, parameters="uniform", ends=EndDerivatives(*slopes))
    peer = scipy.interpolate.CubicSpline(
        np.arange(9.0), points, bc_type=((1, slopes[0][0]), (1, slopes[1][0]))
    )
    at = np.linspace(0.0, 8.0, 99)
    assert np.allclose(curve.at(at), peer(at), atol=1e-13)


def test_natural_quintics_have_no_third_and_fourth_derivative_at_their_ends():
    points = np.random.default_rng(1).normal(size=(8, 3))
    curve = interpolate(points, degree=5, parameters="uniform")
    for order in (3, 4):
        assert np.abs(curve.at(np.array(curve.domain), order)).max() < 1e-10


def test_closed_quintics_close_to_the_fourth_derivative():
    points = np.random.default_rng(1).normal(size=(30, 3))
    curve = interpolate(points, degree=5, parameters="uniform", ends="closed")
    assert np.allclose(curve.at(np.arange(30.0)), points, atol=1e-12)
    assert curve.is_closed(4, 1e-8)


def test_two_points_of_a_closed_curve_lead_there_and_back():
    curve = interpolate([[0.0, 0.0], [1.0, 2.0]], ends="closed")
    length = np.sqrt(5.0)
    assert np.allclose(curve.at([0.0, length, 2 * length]), [[0, 0], [1, 2], [0, 0]], atol=1e-14)
    assert np.allclose(curve.at(length, 1), 0.0, atol=1e-14)


def test_repeated_points_are_named():
    with pytest.raises(CurveError, match="points 1 and 2 are the same"):
        interpolate([[0.0], [1.0], [1.0], [2.0]])
    with pytest.raises(CurveError, match="points 2 and 0 are the same"):
        interpolate([[0.0], [1.0], [0.0]], ends="closed")
    at = interpolate([[0.0], [1.0], [1.0], [2.0]], parameters="uniform").at(np.arange(4.0))
    assert np.allclose(at[:, 0], [0, 1, 1, 2])


@pytest.mark.parametrize(
    ("points", "wrong"),
    [
        ([[0.0]], {}),
        ([[0.0], [float("nan")]], {}),
        ([[0.0], [1.0]], {"degree": 0}),
        ([[0.0], [1.0]], {"degree": 5}),
        ([[0.0], [1.0], [2.0]], {"degree": 4}),
        ([[0.0], [1.0], [2.0]], {"degree": 4, "ends": "closed"}),
        ([[0.0], [1.0]], {"ends": "free"}),
        ([[0.0], [1.0], [3.0]], {"parameters": [0.0, 1.0]}),
        ([[0.0], [1.0], [3.0]], {"parameters": [0.0, 1.0, 1.0]}),
        ([[0.0], [1.0], [3.0]], {"parameters": "length"}),
        ([[0.0], [1.0], [3.0]], {"ends": "clamped"}),
        ([[0.0], [1.0]], {"ends": EndDerivatives(np.ones((1, 2)), np.ones((1, 1)))}),
    ],
)
def test_what_does_not_fit_is_refused(points, wrong):
    with pytest.raises(ValueError, match=r"points|degree|parameters|ends"):
        interpolate(points, **wrong)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(1, 80), st.integers(0, 3), st.booleans(), st.integers(0, 999))
def test_banded_systems_are_solved_as_dense_ones(n, half, closed, seed):
    rng = np.random.default_rng(seed)
    width = 2 * half + 1
    first = np.arange(n) - half
    values = rng.uniform(-1.0, 1.0, (n, width))
    values[:, half] += 2.0 * width
    if not closed:
        columns = first[:, None] + np.arange(width)
        values[(columns < 0) | (columns >= n)] = 0.0
    dense = np.zeros((n, n))
    np.add.at(dense, (np.arange(n)[:, None], (first[:, None] + np.arange(width)) % n), values)
    rhs = rng.normal(size=(n, 2))
    x = banded.solve(first, values, rhs, closed=closed)
    assert np.allclose(dense @ x, rhs, atol=1e-11)


def test_a_singular_banded_system_is_told():
    first = np.arange(30)
    with pytest.raises(np.linalg.LinAlgError):
        banded.solve(first, np.zeros((30, 1)), np.ones((30, 1)))


@pytest.mark.parametrize("degree", [1, 3, 5, 7])
def test_a_not_a_knot_curve_is_the_one_of_scipy(degree):
    points = np.random.default_rng(degree).normal(size=(12, 3))
    u = choose_parameters(points)
    curve = interpolate(points, degree=degree, ends="not-a-knot")
    peer = scipy.interpolate.make_interp_spline(u, points, k=degree)
    assert np.array_equal(curve.knots, peer.t)
    assert np.allclose(curve.points, peer.c, atol=1e-10)


def test_not_a_knot_ends_of_an_even_degree_are_refused():
    with pytest.raises(ValueError, match="odd"):
        interpolate(np.eye(5), degree=4, ends="not-a-knot")


@pytest.mark.parametrize("at_start", [True, False])
@pytest.mark.parametrize(("degree", "count"), [(3, 1), (3, 2), (5, 3), (4, 2)])
def test_end_derivatives_may_be_given_on_one_side_only(at_start, degree, count):
    rng = np.random.default_rng(count)
    points, given = rng.normal(size=(9, 2)), rng.normal(size=(count, 2))
    ends = EndDerivatives(start=given) if at_start else EndDerivatives(end=given)
    curve = interpolate(points, degree=degree, parameters="uniform", ends=ends)
    assert np.allclose(curve.at(np.arange(9.0)), points, atol=1e-10)
    for order in range(count):
        assert np.allclose(curve.at(0.0 if at_start else 8.0, order + 1), given[order], atol=1e-8)


@pytest.mark.parametrize(("degree", "smooth"), [(3, 1), (5, 3)])
def test_given_tangents_are_met_at_every_point(degree, smooth):
    rng = np.random.default_rng(3)
    points, tangents = rng.normal(size=(2, 8, 3))
    curve = interpolate_tangents(points, tangents, degree=degree)
    u = choose_parameters(points)
    assert np.allclose(curve.at(u), points, atol=1e-12)
    assert np.allclose(curve.at(u, 1), tangents, atol=1e-11)
    counts = np.unique(curve.knots, return_counts=True)[1]
    assert (counts[1:-1] == degree - smooth).all()
    peer = scipy.interpolate.CubicHermiteSpline(u, points, tangents)
    at = np.linspace(0.0, u[-1], 101)
    assert (degree == 5) or np.allclose(curve.at(at), peer(at), atol=1e-12)


def test_the_smoothest_quintic_has_less_third_derivative_than_any_other():
    rng = np.random.default_rng(4)
    points, tangents = rng.normal(size=(2, 6, 1))
    u = choose_parameters(points)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    half = 0.5 * np.diff(u)[:, None]
    places = (u[:-1, None] + half + half * nodes).ravel()

    def energy(curve):
        return ((half * weights).ravel() * curve.at(places, 3)[:, 0] ** 2).sum()

    best = interpolate_tangents(points, tangents, degree=5)
    assert np.allclose(best.at(u[[0, -1]], 3), 0.0, atol=1e-9)
    bends = best.at(u, 2)
    same = interpolate_tangents(points, tangents, degree=5, bends=bends)
    assert np.isclose(energy(same), energy(best), rtol=1e-9)
    for _ in range(5):
        other = bends + rng.normal(size=bends.shape)
        assert energy(interpolate_tangents(points, tangents, degree=5, bends=other)) > energy(best)


def test_tangents_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="tangents"):
        interpolate_tangents(np.eye(3), np.eye(2))
    with pytest.raises(ValueError, match="degree"):
        interpolate_tangents(np.eye(3), np.eye(3), degree=4)
    with pytest.raises(ValueError, match="without bends"):
        interpolate_tangents(np.eye(3), np.eye(3), bends=np.eye(3))
    with pytest.raises(ValueError, match="rising"):
        interpolate_tangents(np.eye(3), np.eye(3), parameters=[0.0, 2.0, 1.0])
    with pytest.raises(ValueError, match="at least 2"):
        interpolate_tangents(np.eye(3)[:1], np.eye(3)[:1])
