"""Extruded, ruled, translated and revolved surfaces are exactly what they are called."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.plane import Plane
from splinearm.curves.surface_of_curves import extruded, revolved, ruled, translated
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)
UPRIGHT = Plane(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
SHARES = np.linspace(0.0, 1.0, 21)


def by_share(curve, x):
    start, end = curve.domain
    return curve.at(np.clip(start + x * (end - start), start, end))


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_a_curve_moved_along_a_vector_and_a_path(random_curve, seed):
    curve, path = (random_curve(seed + k, dim=3) for k in range(2))
    way = np.random.default_rng(seed).normal(size=3)
    u = np.linspace(*curve.domain, 15)[:, None]
    v = np.linspace(*path.domain, 11)
    moved = extruded(curve, way).at(u, SHARES)
    wanted = curve.at(u) + SHARES[:, None] * way
    np.testing.assert_allclose(moved, wanted, rtol=0, atol=1e-13)
    sums = translated(curve, path).at(u, v)
    np.testing.assert_allclose(sums, curve.at(u) + path.at(v), rtol=0, atol=1e-13)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_a_ruled_surface_runs_through_both_curves_on_straight_lines(random_curve, seed):
    first, second = (random_curve(seed + k, dim=3) for k in range(2))
    surface = ruled(first, second)
    start, end = surface.domain[0]
    assert (start, end) == first.domain
    # ends of evenly spaced shares may miss the narrowest pieces' jumps by rounding
    u = np.clip(start + SHARES * (end - start), start, end)
    np.testing.assert_allclose(surface.at(u, 0.0), by_share(first, SHARES), rtol=0, atol=1e-11)
    np.testing.assert_allclose(surface.at(u, 1.0), by_share(second, SHARES), rtol=0, atol=1e-11)
    lines = surface.at(u[:, None], SHARES)
    across = np.cross(lines - lines[:, :1], lines[:, -1:] - lines[:, :1])
    np.testing.assert_allclose(across, 0.0, atol=1e-12)


def test_a_turned_half_circle_is_a_sphere():
    sphere = revolved(conic.arc(1.0, -0.5 * np.pi, 0.5 * np.pi, UPRIGHT), [0, 0, 0], [0, 0, 3])
    rng = np.random.default_rng(0)
    radii = np.linalg.norm(sphere.at(*rng.uniform(0.0, 1.0, (2, 5000))), axis=1)
    np.testing.assert_allclose(radii, 1.0, rtol=0, atol=1e-15)
    # a pole is one point, and a full turn ends where it began, to the last bit
    np.testing.assert_array_equal(sphere.points[0], np.tile([0.0, 0.0, -1.0], (9, 1)))
    np.testing.assert_array_equal(sphere.points[:, 0], sphere.points[:, -1])


def test_a_turned_circle_is_a_torus():
    away = Plane(np.array([3.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    torus = revolved(conic.circle(1.0, away), [0, 0, 0], [0, 0, 1])
    p = torus.at(*np.random.default_rng(0).uniform(0.0, 1.0, (2, 5000)))
    tube = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 3.0, p[:, 2])
    np.testing.assert_allclose(tube, 1.0, rtol=0, atol=4e-15 / 2)


def test_a_turned_line_is_a_cone_or_a_cylinder_and_turns_the_right_way():
    cone = revolved(conic.line([0, 0, 0], [1, 0, 2]), [0, 0, 5], [0, 0, 1], 1.2)
    p = cone.at(SHARES[:, None], SHARES)
    np.testing.assert_allclose(2 * np.hypot(p[..., 0], p[..., 1]), p[..., 2], rtol=0, atol=1e-15)
    angles = np.arctan2(p[1:, :, 1], p[1:, :, 0])
    np.testing.assert_allclose(angles[:, -1], 1.2, rtol=0, atol=1e-15)
    assert (np.diff(angles, axis=1) > 0.0).all()
    back = revolved(conic.line([1, 0, 0], [1, 0, 2]), [0, 0, 0], [0, 0, 1], -1.2)
    np.testing.assert_allclose(back.at(0.5, 1.0), [np.cos(1.2), -np.sin(1.2), 1.0], atol=1e-15)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_all_of_a_turned_curve_keeps_height_and_distance(random_curve, seed):
    rng = np.random.default_rng(seed)
    curve = random_curve(seed, dim=3)
    foot, axis = rng.normal(size=(2, 3))
    surface = revolved(curve, foot, axis, float(rng.uniform(0.1, 6.2)))
    u = np.linspace(*curve.domain, 15)
    n = axis / np.linalg.norm(axis)
    start, turned = curve.at(u)[:, None] - foot, surface.at(u[:, None], SHARES) - foot
    np.testing.assert_allclose(turned[:, :1], start, rtol=0, atol=1e-13)
    np.testing.assert_allclose(turned @ n, np.broadcast_to(start @ n, (15, 21)), atol=1e-13)
    distance = np.linalg.norm(np.cross(turned, n), axis=2)
    wanted = np.broadcast_to(np.linalg.norm(np.cross(start, n), axis=2), (15, 21))
    np.testing.assert_allclose(distance, wanted, rtol=0, atol=1e-13)


def test_what_draws_no_surface_is_refused():
    line, flat = conic.line([0, 0, 0], [0, 0, 1]), conic.line([0, 0], [1, 0])
    with pytest.raises(ValueError, match="vector"):
        extruded(line, [0, 0, 0])
    with pytest.raises(ValueError, match="coordinates"):
        ruled(line, flat)
    with pytest.raises(ValueError, match="coordinates"):
        translated(line, flat)
    with pytest.raises(ValueError, match="3 coordinates"):
        revolved(flat, [0, 0, 0], [0, 0, 1])
    with pytest.raises(ValueError, match="axis"):
        revolved(line, [0, 0, 0], [0, 0, 0])
    with pytest.raises(ValueError, match="one turn"):
        revolved(line, [1, 0, 0], [0, 0, 1], 7.0)
    with pytest.raises(CurveError, match="on the axis"):
        revolved(line, [0, 0, 4], [0, 0, 1])


def test_curves_of_different_kinds_share_knots_and_degree():
    first = BSpline([0, 0, 0.3, 1, 1], [[0, 0, 0], [1, 0, 0], [2, 0, 0]], 1)
    second = conic.arc(1.0, 0.0, 2.0, Plane.facing([0, 0, 1], [0, 0, 1]))
    surface = ruled(first, second)
    assert surface.degree_u == 2
    assert surface.is_rational
    np.testing.assert_array_equal(surface.breaks[0], [0.0, 0.3, 0.5, 1.0])
