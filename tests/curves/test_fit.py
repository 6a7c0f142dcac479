import numpy as np
import pytest
import scipy.interpolate
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import BSpline, basis, least
from splinearm.curves.fit import correct_parameters, fit, fit_corrected
from splinearm.curves.interpolation import EndDerivatives, choose_parameters
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel


def walk(seed, count=60, dim=3):
    return np.cumsum(np.random.default_rng(seed).normal(size=(count, dim)), axis=0)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.booleans())
def test_a_free_fit_is_the_one_of_scipy(seed, degree, weighted):
    points = walk(seed)
    u = choose_parameters(points)
    weights = np.random.default_rng(seed).uniform(0.1, 3.0, len(u)) if weighted else None
    curve = fit(points, 14, degree=degree, weights=weights, ends="free")
    # scipy's weights multiply the miss, not its square
    root = None if weights is None else np.sqrt(weights)
    peer = scipy.interpolate.make_lsq_spline(u, points, curve.knots, degree, w=root)
    assert np.allclose(curve.points, peer.c, atol=1e-9 * np.abs(points).max())


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
@pytest.mark.parametrize("count", [6, 9, 25])
def test_a_closed_fit_and_its_influence_are_those_of_dense_algebra(degree, count):
    points = walk(1, 70, 2)
    curve = fit(points, count, degree=degree, ends="closed")
    u = choose_parameters(points, closed=True)[:-1]
    spans = basis.find_spans(curve.knots, degree, u)
    rows = basis.basis_values(curve.knots, degree, spans, u)
    dense = np.zeros((70, count))
    columns = (spans[:, None] - degree + np.arange(degree + 1)) % count
    np.add.at(dense, (np.arange(70)[:, None], columns), rows)
    wanted = np.linalg.lstsq(dense, points, rcond=None)[0]
    assert np.allclose(curve.points[:count], wanted, atol=1e-10)
    assert curve.is_closed(degree - 1, 1e-9)
    none = np.empty((0, 2))
    frame = least.Frame(curve.knots, degree, none, none, closed=True)
    equations = least.equations(frame, u, points)
    shares = least.influence(least.solve(frame, equations), equations)
    assert np.allclose(shares, np.diag(dense @ np.linalg.pinv(dense)), atol=1e-12)


def test_kept_ends_are_met_exactly_and_the_rest_is_best():
    points = walk(2)
    curve = fit(points, 12)
    assert np.array_equal(curve.points[[0, -1]], points[[0, -1]])
    u = choose_parameters(points)
    error = ((curve.at(u) - points) ** 2).sum()
    rng = np.random.default_rng(0)
    for _ in range(10):
        moved = curve.points.copy()
        moved[1:-1] += 1e-3 * rng.normal(size=moved[1:-1].shape)
        assert ((BSpline(curve.knots, moved, 3).at(u) - points) ** 2).sum() > error


def test_end_derivatives_are_met():
    points, rng = walk(3), np.random.default_rng(1)
    ends = EndDerivatives(rng.normal(size=(2, 3)), rng.normal(size=(1, 3)))
    curve = fit(points, 15, degree=4, ends=ends)
    u = choose_parameters(points)
    assert np.allclose(curve.at(u[[0, -1]]), points[[0, -1]])
    assert np.allclose(curve.at(0.0, 1), ends.start[0], atol=1e-9)
    assert np.allclose(curve.at(0.0, 2), ends.start[1], atol=1e-9)
    assert np.allclose(curve.at(u[-1], 1), ends.end[0], atol=1e-9)
    whole = fit(points, 4, ends=EndDerivatives(ends.start[:1], ends.end))
    assert np.allclose(whole.at(0.0, 1), ends.start[0], atol=1e-9)


@pytest.mark.parametrize("ends", ["kept", "free", "closed"])
def test_points_of_a_spline_give_it_back(ends):
    rng = np.random.default_rng(4)
    if ends == "closed":
        curve = BSpline.closed(np.arange(9.0), rng.normal(size=(8, 2)), 3)
        u = np.linspace(0.0, 8.0, 41)
        found = fit(curve.at(u[:-1]), np.arange(9.0), parameters=u, ends=ends)
    else:
        knots = np.array([0.0, 0, 0, 0, 1, 1.5, 3, 4, 4, 4, 4])
        curve = BSpline(knots, rng.normal(size=(7, 2)), 3)
        u = np.linspace(0.0, 4.0, 41)
        found = fit(curve.at(u), knots, parameters=u, ends=ends)
    assert np.allclose(found.points, curve.points, atol=1e-12)


def test_a_weight_of_zero_leaves_a_point_out():
    points = walk(5)
    weights = np.ones(60)
    weights[20] = 0.0
    away = points.copy()
    away[20] += 100.0
    u = choose_parameters(points)
    curves = [fit(p, 12, parameters=u, weights=weights).points for p in (points, away)]
    assert np.allclose(*curves, atol=1e-10)


@pytest.mark.parametrize("ends", ["kept", "free", "closed"])
def test_corrected_parameters_lower_the_error(ends):
    angle = np.linspace(0.0, 2.0 * np.pi, 81)[:-1]
    points = np.column_stack((2.0 * np.cos(angle), np.sin(angle)))
    plain = fit(points, 8, ends=ends)
    u = choose_parameters(points)
    curve, v = fit_corrected(points, 8, ends=ends)
    first, last = (
        np.linalg.norm(c.at(p[:80]) - points, axis=1) for c, p in ((plain, u), (curve, v))
    )
    assert (last**2).sum() < 0.6 * (first**2).sum()
    assert (np.diff(v) >= 0.0).all()
    assert len(v) == 80 + (ends == "closed")


def test_a_correction_leads_to_the_feet():
    curve = BSpline([0, 0, 0, 0, 1, 1, 1, 1], [[0, 0], [1, 2], [2, -1], [3, 0]], 3)
    u = np.linspace(0.0, 1.0, 11)
    way = curve.at(u, 1)
    points = curve.at(u) + 0.02 * np.column_stack((-way[:, 1], way[:, 0]))
    guess = u + 0.01 * np.sin(9.0 * u) * (u > 0) * (u < 1)
    for _ in range(4):
        guess = correct_parameters(curve, points, guess)
    assert np.allclose(guess, u, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "error", "match"),
    [
        ({"control": 3}, ValueError, "at least 4"),
        ({"control": [0.0, 1.0]}, ValueError, "knots rising"),
        ({"control": [0.0, 1.0], "ends": "closed"}, ValueError, "one turn"),
        ({"control": 3, "ends": "closed"}, ValueError, "at least 4"),
        ({"ends": "natural"}, ValueError, "kept, free, closed"),
        ({"weights": -np.ones(60)}, ValueError, "0 or more"),
        ({"weights": np.zeros(60)}, ValueError, "not all 0"),
        ({"parameters": np.zeros(60)}, ValueError, "rising"),
        ({"degree": 0}, ValueError, "at least 1"),
        ({"control": 70}, CurveError, "too few points"),
        ({"control": 4, "ends": EndDerivatives(np.ones((2, 3)), np.ones((2, 3)))}, ValueError, "6"),
        ({"ends": EndDerivatives(np.ones((1, 2)))}, ValueError, "3 coordinates"),
        ({"points": np.ones((1, 3))}, ValueError, "at least 2"),
    ],
)
def test_what_cannot_be_fitted_is_refused(change, error, match):
    arguments = {"points": walk(6), "control": 12, **change}
    with pytest.raises(error, match=match):
        fit(**arguments)


def test_corrections_need_a_round():
    with pytest.raises(ValueError, match="rounds"):
        fit_corrected(walk(7), 12, rounds=0)


def test_knots_without_points_between_are_refused_by_name():
    u = np.concatenate((np.linspace(0.0, 1.0, 20), np.linspace(9.0, 10.0, 20)))
    knots = np.concatenate((np.zeros(4), np.linspace(1.0, 9.0, 9), np.full(4, 10.0)))
    with pytest.raises(CurveError, match="too few points behind parameter"):
        fit(np.sin(u)[:, None], knots, parameters=u)
