import numpy as np
import pytest
import scipy.interpolate
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import BSpline
from splinearm.curves.approximation import approximate, approximate_curve
from splinearm.curves.conic import circle
from splinearm.curves.interpolation import choose_parameters
from splinearm.curves.projection import nearest_point
from splinearm.errors import CurveError

T = np.linspace(0.0, 1.0, 300)
SHAPES = {
    "lissajous": np.column_stack((np.sin(6.0 * T), np.cos(4.0 * T + 1.0))),
    "spiral": np.column_stack((T * np.cos(20.0 * T), T * np.sin(20.0 * T), T)),
    "bump": np.column_stack((4.0 * T, np.exp(-((20.0 * (T - 0.5)) ** 2)))),
}


def fewest_of_scipy(points, u, tolerance):
    """How many control points scipy's smoothing takes at the best of many smoothing factors."""
    fewest = len(points)
    for s in len(u) * tolerance**2 * np.geomspace(1e-3, 2.0, 25):
        (knots, _, _), _ = found = scipy.interpolate.splprep(points.T, u=u, s=s)
        gap = np.array(scipy.interpolate.splev(u, found[0])).T - points
        if np.linalg.norm(gap, axis=1).max() <= tolerance:
            fewest = min(fewest, len(knots) - 4)
    return fewest


@pytest.mark.parametrize("name", list(SHAPES))
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
@pytest.mark.parametrize("geometric", [False, True])
def test_a_tolerance_is_kept_with_no_more_control_points_than_scipy(name, tolerance, geometric):
    points = SHAPES[name]
    u = choose_parameters(points)
    curve, error = approximate(points, tolerance, geometric=geometric)
    assert error <= tolerance
    assert nearest_point(curve, points).distance.max() <= error + 1e-15
    if not geometric:
        assert np.isclose(np.linalg.norm(curve.at(u) - points, axis=1).max(), error)
    assert np.array_equal(curve.points[[0, -1]], points[[0, -1]])
    assert len(curve.points) <= fewest_of_scipy(points, u, tolerance)


@pytest.mark.kernel
@pytest.mark.property
@settings(max_examples=10, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 5),
    st.sampled_from(["kept", "free", "closed"]),
    st.booleans(),
)
def test_points_anywhere_are_met_within_the_tolerance(seed, degree, ends, geometric):
    points = np.random.default_rng(seed).normal(size=(20, 2))
    if ends == "closed" and degree % 2 == 0:
        degree += 1
    curve, error = approximate(points, 0.05, degree=degree, ends=ends, geometric=geometric)
    assert error <= 0.05
    assert nearest_point(curve, points).distance.max() <= 0.05
    assert ends != "closed" or curve.is_closed(degree - 1, 1e-6)


@pytest.mark.kernel
def test_points_of_one_polynomial_need_one_piece():
    u = np.linspace(0.0, 2.0, 50)
    points = np.column_stack((u, u**3 - u))
    curve, error = approximate(points, 1e-12, parameters=u)
    assert len(curve.points) == 4
    assert error <= 1e-12


def test_noise_within_the_tolerance_costs_no_control_points():
    rng = np.random.default_rng(0)
    points = SHAPES["lissajous"] + 1e-3 * rng.uniform(-1.0, 1.0, (300, 2))
    curve, _ = approximate(points, 5e-3, parameters=T)
    assert len(curve.points) <= 11


def test_a_closed_curve_comes_back_as_one():
    angle = np.linspace(0.0, 2.0 * np.pi, 201)[:-1]
    curve, error = approximate(np.column_stack((np.cos(angle), np.sin(angle))), 1e-4, ends="closed")
    assert error <= 1e-4
    assert curve.is_closed(2, 1e-9)
    assert len(curve.points) - 3 <= 16


@pytest.mark.parametrize("degree", [3, 5])
def test_a_circle_is_approximated_within_a_proved_distance(degree):
    curve, error = approximate_curve(circle(1.0), 1e-4, degree=degree)
    at = np.linspace(0.0, 1.0, 5001)
    off = np.linalg.norm(curve.at(at) - circle(1.0).at(at), axis=1).max()
    assert off <= error <= 1e-4
    assert not curve.is_rational


def test_a_function_is_approximated():
    def wave(u):
        return np.column_stack((u, np.sin(3.0 * u)))

    curve, error = approximate_curve(wave, 1e-5, domain=(-1.0, 2.0))
    at = np.linspace(-1.0, 2.0, 3001)
    assert np.linalg.norm(curve.at(at) - wave(at), axis=1).max() <= 1e-5
    assert error <= 1e-5
    assert curve.domain == (-1.0, 2.0)


def test_corners_stay():
    corner = BSpline([0, 0, 1, 2, 2], [[0, 0], [1, 0], [1, 1]], 1)
    curve, error = approximate_curve(corner, 1e-9)
    assert error <= 1e-9
    assert np.allclose(curve.at(1.0), [1.0, 0.0], atol=1e-9)
    assert len(curve.points) == 7


def test_a_spline_with_knots_to_spare_loses_them():
    curve = BSpline([0, 0, 0, 0, 1, 1, 1, 1], [[0, 0], [1, 2], [2, -1], [3, 0]], 3)
    found, error = approximate_curve(curve.with_knots([0.2, 0.5, 0.6, 0.9]), 1e-9)
    assert len(found.points) == 4
    assert error <= 1e-9


def test_what_cannot_be_approximated_is_refused():
    points = SHAPES["bump"]
    for change, match in (
        ({"tolerance": 0.0}, "tolerance"),
        ({"ends": "natural"}, "kept, free or closed"),
        ({"parameters": np.zeros(300)}, "rising"),
    ):
        with pytest.raises(ValueError, match=match):
            approximate(**{"points": points, "tolerance": 1e-3, **change})
    with pytest.raises(ValueError, match="domain"):
        approximate_curve(np.sin, 1e-3)
    with pytest.raises(ValueError, match="its own"):
        approximate_curve(circle(1.0), 1e-3, domain=(0.0, 1.0))
    jump = BSpline([0, 0, 1, 1, 2, 2], [[0.0], [1.0], [5.0], [6.0]], 1)
    with pytest.raises(CurveError, match="jumps"):
        approximate_curve(jump, 1e-3)
