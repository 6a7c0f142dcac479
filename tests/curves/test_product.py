import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import product
from splinearm.curves.bspline import BSpline

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)


def pair(random_curve, seed, dim=2):
    f = random_curve(seed, dim=dim).over(0.0, 1.0)
    g = random_curve(seed + 1, dim=dim).over(0.0, 1.0)
    return f, g, np.linspace(0.0, 1.0, 60)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_sums_and_products_are_exact(random_curve, seed):
    f, g, u = pair(random_curve, seed)
    a, b = f.at(u), g.at(u)
    scalar = BSpline([0, 0, 0, 1, 1, 1], [[1.0], [-1.0], [0.5]], 2)
    turned = a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1]
    for made, wanted in (
        (product.add(f, g), a + b),
        (product.multiply(f, g), a * b),
        (product.multiply(scalar, g), scalar.at(u) * b),
        (product.dot(f, g), np.sum(a * b, axis=1, keepdims=True)),
        (product.cross(f, g), turned),
    ):
        assert made.domain == (0.0, 1.0)
        np.testing.assert_allclose(made.at(u), wanted, rtol=0, atol=2e-13)


def test_a_product_is_as_smooth_as_its_factors():
    f = BSpline([0, 0, 0, 0, 1, 2, 2, 2, 2], np.arange(5.0)[:, None] ** 2, 3)
    g = BSpline([0, 0, 0, 1, 2, 2, 2], [[1.0], [0.0], [2.0], [1.0]], 2)
    made = product.multiply(f, g)
    assert made.degree == 5
    # twice and once differentiable at 1: the product once
    assert np.count_nonzero(made.knots == 1.0) == 4
    assert not made.is_rational
    assert product.add(f, g).knots.tolist() == [0] * 4 + [1, 1] + [2] * 4


def test_vector_products_in_space(random_curve):
    for seed in range(8):
        f, g, u = pair(random_curve, seed, dim=3)
        made = product.cross(f, g)
        np.testing.assert_allclose(made.at(u), np.cross(f.at(u), g.at(u)), rtol=0, atol=1e-13)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_the_derivative_of_a_rational_curve_is_a_curve(random_curve, seed):
    curve = random_curve(seed, rational=True).over(0.0, 1.0)
    u = np.setdiff1d(np.linspace(0.0, 1.0, 40), curve.breaks)
    slope = curve.at(u, 1)
    size = max(1.0, np.abs(slope).max())
    made = curve.derivative()
    assert made.degree == 2 * curve.degree
    np.testing.assert_allclose(made.at(u), slope, rtol=0, atol=1e-12 * size)
    speed = product.squared_speed(curve).at(u)[:, 0]
    np.testing.assert_allclose(speed, np.sum(slope**2, axis=1), rtol=0, atol=1e-11 * size**2)


def test_the_second_derivative_of_a_circle_points_inwards(circle):
    u = np.linspace(0.05, 0.95, 9)
    twice = circle.derivative(2)
    np.testing.assert_allclose(twice.at(u), circle.at(u, 2), rtol=0, atol=1e-12)
    assert circle.derivative(0) is circle


def test_what_does_not_fit_is_refused():
    line = BSpline([0, 0, 1, 1], [[0.0, 0.0], [1.0, 1.0]], 1)
    long = line.over(0.0, 2.0)
    space = BSpline([0, 0, 1, 1], np.zeros((2, 4)), 1)
    for combine in (product.add, product.multiply, product.dot, product.cross):
        with pytest.raises(ValueError, match="domain: want the same of both"):
            combine(line, long)
        with pytest.raises(ValueError, match="dim: want as many coordinates"):
            combine(line, space)
    with pytest.raises(ValueError, match="2 or 3 coordinates"):
        product.cross(space, space)
