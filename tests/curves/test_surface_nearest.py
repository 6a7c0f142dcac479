"""Boxes around surfaces, nearest places and curves that lie on them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.plane import Plane
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_box import bounding_box, control_box
from splinearm.curves.surface_curve import SurfaceCurve
from splinearm.curves.surface_image import image_on_surface
from splinearm.curves.surface_nearest import nearest_on_surface
from splinearm.curves.surface_net import bezier_surface
from splinearm.curves.surface_normal import normal
from splinearm.curves.surface_of_curves import revolved
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)


def random_surface(seed, *, rational=True):
    rng = np.random.default_rng(seed)
    knots = np.r_[0, 0, 0, 0, 0.3, 0.6, 1, 1, 1, 1], np.r_[0, 0, 0, 0.5, 1, 1, 1]
    weights = rng.uniform(0.5, 2.0, (6, 4)) if rational else None
    return BSplineSurface(*knots, rng.normal(size=(6, 4, 3)), 3, 2, weights)


@pytest.fixture(scope="module")
def torus():
    away = Plane(np.array([3.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    return revolved(conic.circle(1.0, away), [0, 0, 0], [0, 0, 1])


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_a_box_holds_the_surface_and_touches_it(seed):
    surface = random_surface(seed, rational=bool(seed % 2))
    low, high = bounding_box(surface, 1e-6)
    x = np.linspace(0.0, 1.0, 81)
    p = surface.grid(x, x).reshape(-1, 3)
    assert (p >= low - 1e-13).all()
    assert (p <= high + 1e-13).all()
    np.testing.assert_allclose(p.max(axis=0), high, rtol=0, atol=0.02)
    outer = control_box(surface)
    assert (low >= outer[0] - 1e-13).all()
    assert (high <= outer[1] + 1e-13).all()


def test_the_box_of_a_torus_in_any_position_is_known(torus):
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    for surface, axis in ((torus, np.array([0.0, 0.0, 1.0])), (torus.mapped(matrix), turn[:, 2])):
        wanted = 3.0 * np.sqrt(1.0 - axis**2) + 1.0
        low, high = bounding_box(surface)
        np.testing.assert_allclose(high, wanted, rtol=0, atol=2e-8)
        np.testing.assert_allclose(low, -wanted, rtol=0, atol=2e-8)
    with pytest.raises(ValueError, match="tolerance"):
        bounding_box(torus, 0.0)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(SEEDS, st.sampled_from([1e-7, 1.0, 1e6]))
def test_the_nearest_place_of_a_torus_is_known_in_any_unit(torus, seed, unit):
    p = np.random.default_rng(seed).normal(size=3) * 3.0
    scaled = torus.mapped(np.diag([unit, unit, unit, 1.0]))
    found = nearest_on_surface(scaled, p * unit)
    wanted = abs(np.hypot(np.hypot(p[0], p[1]) - 3.0, p[2]) - 1.0)
    assert found.distance == pytest.approx(wanted * unit, abs=1e-12 * unit)
    place = scaled.at(found.u, found.v)
    np.testing.assert_allclose(found.point, place, rtol=0, atol=1e-14 * unit)
    assert np.linalg.norm(found.point - p * unit) == found.distance


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_no_place_is_nearer_than_the_nearest(seed):
    surface = random_surface(seed)
    p = np.random.default_rng(seed + 1).normal(size=3)
    found = nearest_on_surface(surface, p)
    x = np.linspace(0.0, 1.0, 101)
    assert found.distance <= np.linalg.norm(surface.grid(x, x) - p, axis=-1).min() + 1e-9


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS, st.floats(-14.0, -3.0))
def test_a_point_just_off_the_surface_is_as_far_as_it_was_moved(seed, exponent):
    surface = random_surface(seed)
    u, v = np.random.default_rng(seed).uniform(0.1, 0.9, 2)
    d = 10.0**exponent
    found = nearest_on_surface(surface, surface.at(u, v) + d * normal(surface, u, v))
    assert found.distance <= d + 1e-14
    assert nearest_on_surface(surface, surface.at(u, v)).distance <= 1e-14


def test_where_all_places_are_as_near_one_is_given(torus):
    sphere = revolved(
        conic.arc(1.0, -0.5 * np.pi, 0.5 * np.pi, Plane([0, 0, 0], [1, 0, 0], [0, 0, 1])),
        [0, 0, 0],
        [0, 0, 1],
    )
    assert nearest_on_surface(sphere, [0, 0, 0]).distance == pytest.approx(1.0, abs=1e-12)
    assert nearest_on_surface(torus, [0, 0, 0]).distance == pytest.approx(2.0, abs=1e-12)
    with pytest.raises(ValueError, match="point"):
        nearest_on_surface(torus, [0, 0])
    with pytest.raises(ValueError, match="tolerance"):
        nearest_on_surface(torus, [0, 0, 0], -1.0)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_a_curve_on_a_surface_has_its_places_and_derivatives(seed):
    rng = np.random.default_rng(seed)
    # one patch: no knots at which derivatives jump
    surface = bezier_surface(rng.normal(size=(4, 3, 3)), rng.uniform(0.5, 2, (4, 3)))
    weights = rng.uniform(0.5, 2.0, 4)
    path = BSpline(np.repeat([2.0, 3.0], 4), rng.uniform(0, 1, (4, 2)), 3, weights)
    curve = SurfaceCurve(surface, path)
    assert curve.domain == (2.0, 3.0)
    t = rng.uniform(2.01, 2.99, (3, 2))
    uv = path.at(t)
    np.testing.assert_allclose(curve.at(t), surface.at(uv[..., 0], uv[..., 1]), atol=1e-15)
    h = 1e-5
    for k in range(1, 5):
        wanted = (curve.at(t + h, k - 1) - curve.at(t - h, k - 1)) / (2.0 * h)
        scale = max(1.0, np.abs(wanted).max(), np.abs(curve.at(t, k)).max())
        np.testing.assert_allclose(curve.at(t, k), wanted, rtol=0, atol=1e-5 * scale)
    assert curve.jet(t, 2).shape == (3, 2, 3, 3)


def test_a_straight_way_along_a_parameter_is_an_isocurve():
    surface = random_surface(8)
    curve = SurfaceCurve(surface, conic.line([0.0, 0.4], [1.0, 0.4]))
    t, whole = np.linspace(0, 1, 23), surface.along_u(0.4)
    for k in range(3):
        np.testing.assert_allclose(curve.at(t, k), whole.at(t, k), rtol=1e-11, atol=1e-11)


def test_a_curve_that_leaves_the_surface_is_refused_there():
    surface = random_surface(8)
    curve = SurfaceCurve(surface, conic.line([0.0, 0.5], [2.0, 0.5]))
    curve.at(0.5)
    with pytest.raises(CurveError, match=r"curve at 0.75.*u = 1.5"):
        curve.at([0.1, 0.75])
    with pytest.raises(ValueError, match="u and v"):
        SurfaceCurve(surface, conic.line([0, 0, 0], [1, 1, 1]))


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_the_exact_image_is_the_curve_on_the_surface(seed):
    rng = np.random.default_rng(seed)
    surface = random_surface(seed, rational=bool(seed % 2))
    degree = int(rng.integers(1, 4))
    knots = np.r_[np.full(degree + 1, -1.0), 0.2, np.full(degree + 1, 2.0)]
    weights = rng.uniform(0.5, 2.0, degree + 2) if seed % 3 else None
    path = BSpline(knots, rng.uniform(0.0, 1.0, (degree + 2, 2)), degree, weights)
    image, curve = image_on_surface(surface, path), SurfaceCurve(surface, path)
    assert image.degree == 5 * degree
    assert image.is_rational == (surface.is_rational or path.is_rational)
    assert image.domain == path.domain
    t = rng.uniform(-1.0, 2.0, 60)
    np.testing.assert_allclose(image.at(t), curve.at(t), rtol=0, atol=1e-12)


def test_the_image_of_a_line_along_an_edge_is_that_edge():
    surface = random_surface(3)
    for v in (0.0, 0.5, 1.0):
        image = image_on_surface(surface, conic.line([0.0, v], [1.0, v]))
        x = np.linspace(0, 1, 31)
        np.testing.assert_allclose(image.at(x), surface.along_u(v).at(x), rtol=0, atol=1e-12)
    for wrong in (conic.line([0.5, 0.5], [0.5, 1.2]), conic.line([-0.1, 0.5], [0.5, 0.5])):
        with pytest.raises(CurveError, match="has no place"):
            image_on_surface(surface, wrong)
    jumping = BSpline([0, 0, 1, 1, 2, 2], [[0, 0], [0.2, 0.2], [0.5, 0.5], [1, 1]], 1)
    with pytest.raises(CurveError, match="u = 1: the curve jumps"):
        image_on_surface(surface, jumping)
    with pytest.raises(ValueError, match="u and v"):
        image_on_surface(surface, conic.line([0, 0, 0], [1, 1, 1]))
