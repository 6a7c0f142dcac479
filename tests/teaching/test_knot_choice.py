"""Knots: few of them, where they are needed, and none that could be left out."""

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError
from splinearm.teaching.knot_choice import KnotChoice

U = np.linspace(0.0, 4.0, 401)


def choice_of(q, near, degree=3, u=U, **more):
    wide = np.full(q.shape[1], 100.0)
    return KnotChoice(
        u=u,
        q=q,
        misses=lambda found, part: np.abs(found - q[part]).max(axis=1) / near,
        degree=degree,
        low=more.get("low", -wide),
        high=more.get("high", wide),
    )


@pytest.mark.parametrize("degree", [3, 5])
def test_a_spline_is_found_again_with_few_knots(degree):
    rng = np.random.default_rng(degree)
    inner = [0.7, 1.1, 2.4, 3.3]
    knots = np.concatenate((np.zeros(degree + 1), inner, np.full(degree + 1, 4.0)))
    q = BSpline(knots, rng.normal(size=(len(inner) + degree + 1, 2)), degree).at(U)
    found = choice_of(q, 1e-3, degree).fewest()
    assert len(found.inner) <= 3 * len(inner)
    assert np.abs(found.curve.at(U) - q).max() <= 1e-3


def test_a_cubic_needs_no_knot():
    q = np.column_stack((U**3 - 2.0 * U, 1.0 - U**2))
    found = choice_of(q, 1e-6).fewest()
    assert found.inner.size == 0


def test_no_knot_can_be_left_out():
    q = np.column_stack((np.sin(2.0 * U), np.exp(-3.0 * (U - 2.0) ** 2)))
    choice = choice_of(q, 1e-3)
    found = choice.fewest()
    for i in range(len(found.inner)):
        assert choice.attempt(np.delete(found.inner, i))[0] is None


def test_knots_lie_on_the_grid_of_files():
    found = choice_of(np.column_stack((np.sin(3.0 * U), np.cos(U))), 1e-3).fewest()
    np.testing.assert_allclose(found.inner, np.round(found.inner, 4), atol=1e-12)


def test_no_control_point_goes_beyond_a_limit():
    q = np.column_stack((np.minimum(np.sin(2.0 * U), 0.999), U))
    limit = np.array([1.0, 4.0])
    found = choice_of(q, 5e-3, low=-limit, high=limit).fewest()
    assert (np.abs(found.curve.points) <= limit).all()


def test_long_ones_are_looked_at_window_by_window_at_the_cost_of_few_knots():
    u = np.round(np.linspace(0.0, 46.0, 4600), 4)
    q = np.column_stack((np.sin(u), np.cos(0.7 * u)))
    found = choice_of(q, 1e-3, u=u).fewest()
    assert np.abs(found.curve.at(u) - q).max() <= 1e-3
    once = choice_of(q[:1400], 1e-3, u=u[:1400]).fewest()
    assert len(found.inner) <= 1.2 * 4600 / 1400 * (len(once.inner) + 1)


def test_what_no_curve_follows_is_refused():
    q = np.random.default_rng(0).normal(size=(401, 2))
    with pytest.raises(CurveError, match="allow more"):
        choice_of(q, 1e-6).fewest()
