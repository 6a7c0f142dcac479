import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.box import bounding_box, control_box, convex_hull

pytestmark = pytest.mark.kernel


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_boxes_hold_the_curve_and_touch_it(random_curve, places, seed):
    curve = random_curve(seed, dim=3)
    low, high = bounding_box(curve)
    outer = control_box(curve)
    assert (outer[0] <= low + 1e-15).all()
    assert (high <= outer[1] + 1e-15).all()
    values = curve.at(places(curve, 400))
    assert (values >= low - 1e-14).all()
    assert (values <= high + 1e-14).all()
    # between samples a curve rises by little
    slack = 1e-4 * np.ptp(np.concatenate(outer)) + 1e-12
    assert (values.min(axis=0) - low < slack).all()
    assert (high - values.max(axis=0) < slack).all()


def test_a_circle_fills_its_square(circle):
    turned = circle.mapped([[0.6, -0.8, 2.0], [0.8, 0.6, 0.0], [0, 0, 1]])
    low, high = bounding_box(turned)
    np.testing.assert_allclose(low, [1.0, -1.0], rtol=0, atol=2e-15)
    np.testing.assert_allclose(high, [3.0, 1.0], rtol=0, atol=2e-15)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_hulls_are_convex_and_hold_the_curve(random_curve, places, seed):
    curve = random_curve(seed)
    values = curve.at(places(curve, 50))
    areas = []
    for pieces in (False, True):
        hull = convex_hull(curve, pieces=pieces)
        if len(hull) < 3:
            assert len(np.unique(curve.points, axis=0)) < 3
            return
        edges = np.roll(hull, -1, axis=0) - hull
        following = np.roll(edges, -1, axis=0)
        assert (edges[:, 0] * following[:, 1] > edges[:, 1] * following[:, 0]).all()
        away = values[:, None] - hull
        assert (edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0] >= -1e-13).all()
        x, y = hull.T
        areas.append(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert areas[1] <= areas[0] + 1e-13


def test_a_hull_is_of_the_plane(random_curve):
    with pytest.raises(ValueError, match="got 3 coordinates"):
        convex_hull(random_curve(1, dim=3))
