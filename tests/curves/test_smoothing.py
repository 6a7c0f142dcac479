from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
import scipy.interpolate

from splinearm.curves.smoothing import choose_stiffness, smooth

pytestmark = pytest.mark.kernel


def noisy(seed, count):
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, 10.0, count))
    return x, np.sin(x) + 0.1 * rng.normal(size=count)


def reinsch(x, y, stiffness):
    """Values at the points in exact arithmetic: Reinsch, Numer. Math. 10 (1967) 177."""
    x, y, m = [Fraction(v) for v in x], [Fraction(v) for v in y], len(x)
    h = [b - a for a, b in pairwise(x)]
    Q = [[Fraction(0)] * (m - 2) for _ in range(m)]
    for j in range(m - 2):
        Q[j][j], Q[j + 2][j] = 1 / h[j], 1 / h[j + 1]
        Q[j + 1][j] = -Q[j][j] - Q[j + 2][j]
    A = [
        [stiffness * sum(Q[k][i] * Q[k][j] for k in range(m)) for j in range(m - 2)]
        for i in range(m - 2)
    ]
    for j in range(m - 2):
        A[j][j] += (h[j] + h[j + 1]) / 3
        if j + 1 < m - 2:
            A[j][j + 1] += h[j + 1] / 6
            A[j + 1][j] += h[j + 1] / 6
    b = [sum(Q[k][i] * y[k] for k in range(m)) for i in range(m - 2)]
    for i in range(m - 2):
        for k in range(i + 1, m - 2):
            f = A[k][i] / A[i][i]
            A[k] = [p - f * q for p, q in zip(A[k], A[i], strict=True)]
            b[k] -= f * b[i]
    for i in reversed(range(m - 2)):
        b[i] = (b[i] - sum(A[i][j] * b[j] for j in range(i + 1, m - 2))) / A[i][i]
    return np.array(
        [float(y[k] - stiffness * sum(Q[k][j] * b[j] for j in range(m - 2))) for k in range(m)]
    )


@pytest.mark.parametrize("stiffness", [Fraction(1, 1024), Fraction(1), Fraction(65536)])
def test_a_cubic_smoothing_spline_is_reinschs_in_exact_arithmetic(stiffness):
    x, y = noisy(0, 14)
    curve = smooth(y[:, None], float(stiffness), parameters=x)
    assert np.allclose(curve.at(x)[:, 0], reinsch(x, y, stiffness), rtol=0, atol=1e-11)


@pytest.mark.parametrize("stiffness", [1e-3, 1.0])
def test_weights_count_as_in_scipy(stiffness):
    x, y = noisy(1, 40)
    weights = np.random.default_rng(2).uniform(0.2, 3.0, 40)
    curve = smooth(y[:, None], stiffness, parameters=x, weights=weights)
    peer = scipy.interpolate.make_smoothing_spline(x, y, w=weights, lam=stiffness)
    at = np.linspace(x[0], x[-1], 201)
    assert np.allclose(curve.at(at)[:, 0], peer(at), atol=1e-8)


@pytest.mark.parametrize("count", [30, 120])
def test_cross_validation_finds_the_stiffness_of_scipy(count):
    x, y = noisy(3, count)
    peer = scipy.interpolate.make_smoothing_spline(x, y)
    at = np.linspace(x[0], x[-1], 201)
    curve = smooth(y[:, None], parameters=x)
    assert np.allclose(curve.at(at)[:, 0], peer(at), atol=1e-3)
    assert choose_stiffness(y[:, None], parameters=x) > 0.0


def test_a_little_stiffness_interpolates_and_much_gives_a_line():
    x, y = noisy(4, 25)
    near = smooth(y[:, None], 1e-9, parameters=x)
    assert np.allclose(near.at(x)[:, 0], y, atol=1e-3)
    far = smooth(y[:, None], 1e7, parameters=x)
    assert np.allclose(far.at(x)[:, 0], np.polyval(np.polyfit(x, y, 1), x), atol=1e-4)


def test_a_closed_curve_is_smooth_across_its_seam_and_nearer_than_its_points():
    rng = np.random.default_rng(5)
    u = np.linspace(0.0, 2.0 * np.pi, 81)
    points = np.column_stack((np.cos(u), np.sin(u)))[:-1] + 0.05 * rng.normal(size=(80, 2))
    curve = smooth(points, parameters=u, closed=True)
    assert curve.is_closed(2, 1e-9)
    at = np.linspace(0.0, 2.0 * np.pi, 300)
    off = np.abs(np.linalg.norm(curve.at(at), axis=1) - 1.0)
    assert off.max() < 0.6 * np.abs(np.linalg.norm(points, axis=1) - 1.0).max()


@pytest.mark.parametrize("degree", [2, 4, 5])
def test_other_degrees_smooth_too(degree):
    x, y = noisy(6, 80)
    curve = smooth(y[:, None], parameters=x, degree=degree)
    off = np.abs(curve.at(x)[:, 0] - np.sin(x))
    assert curve.degree == degree
    assert np.sqrt((off**2).mean()) < 0.6 * np.sqrt(((y - np.sin(x)) ** 2).mean())


def test_the_answer_does_not_depend_on_units():
    x, y = noisy(7, 50)
    one = smooth(y[:, None], parameters=x)
    other = smooth(1e-6 * y[:, None], parameters=1e4 * x)
    assert np.allclose(1e6 * other.at(1e4 * x), one.at(x), atol=1e-6)


def test_what_cannot_be_smoothed_is_refused():
    x, y = noisy(8, 10)
    for change, match in (
        ({"stiffness": 0.0}, "stiffness"),
        ({"degree": 1}, "degree"),
        ({"parameters": np.zeros(10)}, "rising"),
        ({"points": np.ones((2, 1)), "parameters": [0.0, 1.0]}, "at least 3"),
        ({"points": np.eye(3), "parameters": "uniform", "closed": True}, "at least 4"),
    ):
        with pytest.raises(ValueError, match=match):
            smooth(**{"points": y[:, None], "parameters": x, **change})
