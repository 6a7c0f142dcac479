from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bezier import Bezier, bezier_curves
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
U = np.linspace(0.0, 1.0, 21)


@st.composite
def beziers(draw, least=0):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    degree = draw(st.integers(least, 7))
    weights = rng.uniform(0.4, 2.0, degree + 1) if draw(st.booleans()) else None
    return Bezier(rng.uniform(-1.0, 1.0, (degree + 1, 2)), weights)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(beziers())
def test_a_bezier_curve_is_a_bspline_of_one_piece(curve):
    spline = curve.to_bspline()
    for order in range(3):
        wanted = spline.at(U, order)
        scale = max(1.0, np.abs(wanted).max())
        np.testing.assert_allclose(curve.at(U, order), wanted, rtol=0, atol=1e-13 * scale)
    assert curve.at(0.5).shape == (2,)
    assert curve.at(U.reshape(3, 7)).shape == (3, 7, 2)
    (again,) = bezier_curves(curve.to_bspline(2.0, 5.0))
    np.testing.assert_allclose(again.points, curve.points, rtol=0, atol=1e-15)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(beziers(), st.floats(0.0, 1.0))
def test_pieces_are_the_curve(curve, u):
    first, last = curve.split(u)
    np.testing.assert_allclose(first.at(U), curve.at(u * U), rtol=0, atol=1e-13)
    at = np.minimum(u + (1.0 - u) * U, 1.0)
    np.testing.assert_allclose(last.at(U), curve.at(at), rtol=0, atol=1e-13)
    assert np.array_equal(first.points[-1], last.points[0])
    if u > 1e-6:
        np.testing.assert_allclose(curve.part(0.0, u).points, first.points, rtol=0, atol=1e-13)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(beziers())
def test_elevation_and_reversing(curve):
    raised = curve.elevated(3)
    assert raised.degree == curve.degree + 3
    np.testing.assert_allclose(raised.at(U), curve.at(U), rtol=0, atol=1e-14)
    np.testing.assert_allclose(curve.reversed().at(1.0 - U), curve.at(U), rtol=0, atol=1e-13)
    if curve.degree:
        lower, error = curve.elevated().reduced(1e-9)
        assert lower.degree == curve.degree
        assert error < 1e-11
        np.testing.assert_allclose(lower.at(U), curve.at(U), rtol=0, atol=1e-11)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(beziers())
def test_the_derivative_and_powers(curve):
    slope = curve.at(U, 1)
    scale = max(1.0, np.abs(slope).max())
    np.testing.assert_allclose(curve.derivative().at(U), slope, rtol=0, atol=1e-12 * scale)
    sums = sum(c * U[:, None] ** j for j, c in enumerate(curve.power()))
    values = sums if curve.weights is None else sums[:, :-1] / sums[:, -1:]
    np.testing.assert_allclose(values, curve.at(U), rtol=0, atol=1e-11)
    if curve.weights is None:
        again = Bezier.from_power(curve.power())
        np.testing.assert_allclose(again.points, curve.points, rtol=0, atol=1e-12)


def test_de_casteljau_in_fractions():
    points = [[Fraction(n) for n in row] for row in ((0, 0), (1, 3), (4, 2), (5, -1))]
    u = Fraction(1, 4)
    level = points
    while len(level) > 1:
        level = [
            [(1 - u) * a + u * b for a, b in zip(p, q, strict=True)] for p, q in pairwise(level)
        ]
    curve = Bezier([[float(x) for x in row] for row in points])
    assert curve.at(0.25).tolist() == [float(x) for x in level[0]]
    assert curve.power().tolist() == [[0, 0], [3, 9], [6, -12], [-4, 2]]


def test_a_quarter_of_a_circle():
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, ex. 1.13: weights 1, 1, 2
    quarter = Bezier([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], [1.0, 1.0, 2.0])
    assert np.abs(np.linalg.norm(quarter.at(U), axis=1) - 1.0).max() < 1e-15
    assert quarter.at(0.5) == pytest.approx([0.6, 0.8], abs=1e-15)
    # its first derivatives at the ends are (0, 2) and (-1, 0)
    assert quarter.at(0.0, 1) == pytest.approx([0.0, 2.0], abs=1e-15)
    assert quarter.at(1.0, 1) == pytest.approx([-1.0, 0.0], abs=1e-15)


def test_what_is_no_bezier_curve_is_refused():
    for points, weights in (([[0.0], [float("nan")]], None), (np.zeros((0, 2)), None)):
        with pytest.raises(ValueError, match="points"):
            Bezier(points, weights)
    for weights in ([1.0, 0.0], [1.0, -1.0], [1.0], [1.0, float("nan")]):
        with pytest.raises(ValueError, match="weights"):
            Bezier([[0.0], [1.0]], weights)
    line = Bezier([[0.0], [1.0]])
    for u in (-0.1, 1.1, float("nan")):
        with pytest.raises(CurveError, match="defined from 0 to 1, not at"):
            line.at(u)
        with pytest.raises(CurveError, match="defined from 0 to 1, not at"):
            line.split(u)
    with pytest.raises(ValueError, match="derivative: want 0 or more"):
        line.at(0.5, -1)
    with pytest.raises(ValueError, match="times"):
        line.elevated(-1)
    with pytest.raises(ValueError, match="start below end"):
        line.part(0.5, 0.5)
