from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bernstein import (
    EPS,
    Bounded,
    bezier_pieces,
    binomials,
    differentiate,
    multiply,
    values,
)
from splinearm.curves.bspline import BSpline
from splinearm.curves.root import find_roots

T = np.linspace(0.0, 1.0, 33)


def at(c, t):
    """A polynomial of numbers (n + 1,) at many t."""
    return values(np.broadcast_to(c, (len(t), len(c))), t)


def with_roots(roots):
    c = np.ones(1)
    for root in roots:
        c = multiply(c, np.array([-root, 1.0 - root]))
    return c


def bounded(*rows):
    c = np.array(rows, dtype=float)
    return Bounded(c, 8.0 * EPS * np.abs(c).max(axis=1))


@st.composite
def polynomials(draw, most=7):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return rng.normal(size=draw(st.integers(1, most)))


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(polynomials(), polynomials())
def test_products_sums_and_derivatives_are_those_of_values(f, g):
    assert np.allclose(at(multiply(f, g), T), at(f, T) * at(g, T), rtol=1e-13, atol=1e-13)
    a, b = bounded(f), bounded(g)
    assert np.allclose(at((a + b).c[0], T), at(f, T) + at(g, T), atol=1e-13)
    assert np.allclose(at((a - b).c[0], T), at(f, T) - at(g, T), atol=1e-13)
    assert np.allclose(at(a.times(-3.0).c[0], T), -3.0 * at(f, T), atol=1e-13)
    h = 1e-6
    slope = (at(f, T[1:-1] + h) - at(f, T[1:-1] - h)) / (2.0 * h)
    assert np.allclose(at(differentiate(f), T[1:-1]), slope, atol=1e-7 * np.abs(f).max() * 50)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(polynomials(6), polynomials(6), polynomials(4))
def test_a_bound_holds_what_rounding_did(f, g, h):
    from fractions import Fraction

    def exact_product(p, q):
        m, n = len(p) - 1, len(q) - 1
        out = [Fraction(0)] * (m + n + 1)
        for i, x in enumerate(p):
            for j, y in enumerate(q):
                weight = int(binomials(m)[i]) * int(binomials(n)[j])
                out[i + j] += x * y * Fraction(weight, int(binomials(m + n)[i + j]))
        return out

    rows = [[Fraction(float(x)) for x in row] for row in (f, g, h)]
    exact = exact_product(exact_product(rows[0], rows[1]), rows[2])
    degree = len(exact) - 1
    exact = [degree * (b - a) for a, b in pairwise(exact)] or [Fraction(0)]
    zero = np.zeros(1)
    parts = [Bounded(row[None], zero) for row in (f, g, h)]
    product = (parts[0] * parts[1] * parts[2]).derivative()
    off = max(abs(Fraction(float(x)) - y) for x, y in zip(product.c[0], exact, strict=True))
    assert float(off) <= product.error[0]


@pytest.mark.property
@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.floats(0.01, 0.99), min_size=0, max_size=6),
    st.lists(st.floats(1.1, 3.0), max_size=3),
)
def test_roots_of_products_are_found(inside, outside):
    inside = sorted(inside)
    if np.diff(inside).min(initial=1.0) < 0.02:
        return
    found = find_roots(bounded(with_roots([*inside, *outside, *(-x for x in outside)])))
    assert len(found.t) == len(inside)
    assert np.allclose(found.t, inside, rtol=0, atol=1e-9)
    assert not len(found.everywhere)


@pytest.mark.parametrize("roots", [(0.0, 0.5, 1.0), (0.25, 0.75), (0.0,), (1.0,), (0.5,)])
def test_roots_at_ends_and_halves_are_exact(roots):
    found = find_roots(bounded(with_roots([*roots, -1.0])))
    assert np.allclose(found.t, roots, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("times", "accuracy"), [(2, 1e-7), (3, 1e-4), (4, 2e-3)])
def test_roots_of_several_at_once_are_one(times, accuracy):
    found = find_roots(bounded(with_roots([0.3] * times + [0.8])))
    assert len(found.t) == 2
    assert np.allclose(found.t, [0.3, 0.8], rtol=0, atol=accuracy)
    assert (found.low <= [0.3, 0.8 + 1e-12]).all()
    assert (found.high >= [0.3, 0.8 - 1e-12]).all()


def test_what_only_comes_near_is_no_root():
    lifted = with_roots([0.3, 0.3]) + 1e-12
    assert len(find_roots(bounded(lifted)).t) == 0


def test_zero_everywhere_is_said():
    found = find_roots(bounded([1.0, 1.0, 1.0], [1e-17, -1e-17, 0.0], [-1.0, 0.0, 1.0]))
    # the second is not 0 beside its own bound
    assert found.everywhere.tolist() == []
    zero = Bounded(np.array([[1e-17, -1e-17]]), np.array([1e-16]))
    assert find_roots(zero).everywhere.tolist() == [0]


def test_common_roots_are_roots_of_all():
    f = bounded(with_roots([0.2, 0.7]), with_roots([0.1, 0.4]))
    g = bounded(with_roots([0.7, 0.9]), with_roots([0.3, 0.5]))
    found = find_roots(f, g)
    assert found.piece.tolist() == [0]
    assert np.allclose(found.t, 0.7, atol=1e-12)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 5), st.booleans())
def test_pieces_are_the_curve(seed, degree, unclamped):
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, max(degree, 1) + 1, 3)
    inner = np.repeat([1.0, 1.7, 3.0], counts)
    reach = np.arange(degree + 1)[::-1] * (0.3 if unclamped else 0.0)
    knots = np.concatenate((-reach, inner, 4.0 + reach[::-1]))
    curve = BSpline(knots, rng.normal(size=(len(knots) - degree - 1, 2)), degree)
    ends, pieces = bezier_pieces(curve.knots, curve.points, degree)
    assert np.array_equal(ends, curve.breaks)
    t = T[1:-1]
    for i, piece in enumerate(pieces):
        u = ends[i] + t * (ends[i + 1] - ends[i])
        for d in range(2):
            assert np.allclose(at(piece[:, d], t), curve.at(u)[:, d], atol=1e-13)
