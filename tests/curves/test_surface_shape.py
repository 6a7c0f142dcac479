"""Normals, fundamental forms, curvatures, area and frames, against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.plane import Plane
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_frame import surface_frame
from splinearm.curves.surface_net import bezier_surface
from splinearm.curves.surface_normal import normal
from splinearm.curves.surface_of_curves import revolved, ruled
from splinearm.curves.surface_shape import area, curvatures, fundamental_forms
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)
INSIDE = np.random.default_rng(0).uniform(0.05, 0.95, (2, 40))


def upright(x):
    return Plane(np.array([x, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))


@pytest.fixture(scope="module")
def sphere():
    half = conic.arc(2.0, -0.5 * np.pi, 0.5 * np.pi, upright(0.0))
    return revolved(half, [0, 0, 0], [0, 0, 1]).reversed("u")


@pytest.fixture(scope="module")
def torus():
    return revolved(conic.circle(1.0, upright(3.0)), [0, 0, 0], [0, 0, 1])


@pytest.fixture(scope="module")
def bumpy():
    points = np.random.default_rng(3).uniform(-0.2, 0.2, (6, 5, 3))
    points[..., 0] += np.linspace(0, 3, 6)[:, None]
    points[..., 1] += np.linspace(0, 2, 5)
    knots = np.r_[0, 0, 0, 0, 0.3, 0.6, 1, 1, 1, 1], np.r_[0, 0, 0, 0.5, 0.8, 1, 1, 1]
    return BSplineSurface(*knots, points, 3, 2, np.random.default_rng(4).uniform(0.7, 1.4, (6, 5)))


def test_a_sphere_has_its_normals_also_at_the_poles(sphere):
    u, v = INSIDE
    np.testing.assert_allclose(normal(sphere, u, v), sphere.at(u, v) / 2.0, rtol=0, atol=1e-14)
    for pole in (0.0, 1.0):
        found = normal(sphere, pole, np.array([0.0, 0.1, 0.25, 0.6, 1.0]))
        wanted = np.tile([0.0, 0.0, 1.0 - 2.0 * pole], (5, 1))
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)


def test_a_sphere_is_bent_alike_everywhere(sphere):
    found = curvatures(sphere, *INSIDE)
    np.testing.assert_allclose(found.values, -0.5, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.gaussian, 0.25, rtol=0, atol=1e-12)
    assert area(sphere) == pytest.approx(16.0 * np.pi, rel=1e-14)


def test_a_torus_has_the_curvatures_of_the_books(torus):
    u, v = INSIDE
    p = torus.at(u, v)
    from_axis = np.hypot(p[:, 0], p[:, 1])
    # its normals point inwards, so it bends towards them: 1 / r and cos / distance from the axis
    along = np.stack(((from_axis - 3.0) / from_axis, np.ones(40)), axis=1)
    found = curvatures(torus, u, v)
    np.testing.assert_allclose(found.values, along, rtol=0, atol=1e-11)
    around = np.stack((-p[:, 1], p[:, 0], np.zeros(40)), axis=1) / from_axis[:, None]
    np.testing.assert_allclose(np.abs(np.sum(found.directions[:, 0] * around, 1)), 1.0, atol=1e-12)
    assert area(torus) == pytest.approx(12.0 * np.pi**2, rel=1e-14)


def test_cylinder_and_cone_are_flat_and_bend_by_their_distance_from_the_axis():
    cylinder = revolved(conic.line([2, 0, 0], [2, 0, 1]), [0, 0, 0], [0, 0, 1])
    found = curvatures(cylinder, *INSIDE)
    np.testing.assert_allclose(found.values, np.tile([0.0, 0.5], (40, 1)), rtol=0, atol=1e-13)
    assert area(cylinder) == pytest.approx(4.0 * np.pi, rel=1e-14)
    cone = revolved(conic.line([0, 0, 0], [1, 0, 2]), [0, 0, 0], [0, 0, 1])
    u, v = INSIDE
    # the normal's way to the axis is the radius of curvature
    wanted = 2.0 / np.sqrt(5.0) / u
    np.testing.assert_allclose(curvatures(cone, u, v).values[:, 1], wanted, rtol=1e-12)
    np.testing.assert_allclose(curvatures(cone, u, v).gaussian, 0.0, rtol=0, atol=1e-11)
    assert area(cone) == pytest.approx(np.pi * np.sqrt(5.0), rel=1e-14)
    # the tip has a normal for each v, that of the line there
    np.testing.assert_allclose(normal(cone, 0.0, 0.4), normal(cone, 0.5, 0.4), atol=1e-12)


def test_a_saddle_has_minus_one_and_its_directions_lie_between_its_lines():
    saddle = ruled(conic.line([-1, -1, 1], [1, -1, -1]), conic.line([-1, 1, -1], [1, 1, 1]))
    found = curvatures(saddle, 0.5, 0.5)
    np.testing.assert_allclose(found.values, [-1.0, 1.0], rtol=0, atol=1e-14)
    wanted = [np.sqrt(0.5) * np.array([1, -1, 0]), np.sqrt(0.5) * np.array([1, 1, 0])]
    cosines = np.abs(np.sum(found.directions * wanted, axis=1))
    np.testing.assert_allclose(cosines, 1.0, rtol=0, atol=1e-14)
    u, v = INSIDE
    x, y = 2 * u - 1, 2 * v - 1
    bent = curvatures(saddle, u, v).gaussian
    np.testing.assert_allclose(bent, -1.0 / (1 + x * x + y * y) ** 2, rtol=1e-12)


def test_curvatures_agree_with_the_forms_and_their_directions_by_u_and_v(bumpy):
    u, v = INSIDE
    first, second = fundamental_forms(bumpy, u, v)
    found = curvatures(bumpy, u, v)
    gauss = np.linalg.det(second) / np.linalg.det(first)
    np.testing.assert_allclose(found.gaussian, gauss, rtol=1e-9, atol=1e-10)
    trace = np.trace(np.linalg.solve(first, second), axis1=1, axis2=2)
    np.testing.assert_allclose(2.0 * found.mean, trace, rtol=1e-9, atol=1e-10)
    jets = bumpy.jet(u, v, 1)
    pair = np.stack((jets[:, 1, 0], jets[:, 0, 1]), axis=1)
    np.testing.assert_allclose(found.parameters @ pair, found.directions, rtol=0, atol=1e-12)
    square = found.directions @ found.directions.swapaxes(1, 2)
    np.testing.assert_allclose(square, np.tile(np.eye(2), (40, 1, 1)), rtol=0, atol=1e-12)
    # along them the second form is diagonal, with the curvatures on it
    bend = found.parameters @ second @ found.parameters.swapaxes(1, 2)
    wanted = found.values[:, :, None] * np.eye(2)
    np.testing.assert_allclose(bend, wanted, rtol=0, atol=1e-10)


@pytest.mark.property
@settings(max_examples=5, deadline=None)
@given(SEEDS, st.floats(0.01, 100.0))
def test_shape_moves_and_scales_with_the_surface(bumpy, seed, scale):
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = scale * turn, rng.normal(size=3)
    moved = bumpy.mapped(matrix)
    before, after = curvatures(bumpy, *INSIDE), curvatures(moved, *INSIDE)
    size = np.abs(before.values).max()
    np.testing.assert_allclose(after.values * scale, before.values, rtol=0, atol=1e-11 * size)
    units = normal(bumpy, *INSIDE) @ turn.T
    np.testing.assert_allclose(normal(moved, *INSIDE), units, rtol=0, atol=1e-12)
    flat = ruled(conic.line([0, 0, 0], [1, 0, 0]), conic.line([0, 1, 0], [1, 1, 2]))
    assert area(flat.mapped(matrix)) == pytest.approx(scale**2 * area(flat), rel=1e-12)
    # other parameters and a finer net are the same surface
    other = bumpy.over((3.0, 5.0), (-1.0, 7.0)).elevated(1, 0)
    u, v = INSIDE
    bent = curvatures(other, 3.0 + 2.0 * u, -1.0 + 8.0 * v)
    np.testing.assert_allclose(bent.values, before.values, rtol=0, atol=1e-10 * size)
    swapped = curvatures(bumpy.swapped(), v, u).values
    np.testing.assert_allclose(-swapped[:, ::-1], before.values, rtol=0, atol=1e-11 * size)


def patch(points):
    return bezier_surface(points)


def test_degenerate_places_have_a_limit_or_are_refused_by_name():
    # a triangle: one edge is a point, and normals have a limit there
    triangle = patch([[[0, 0, 0], [0, 0, 0]], [[1, 0, 0], [1, 1, 0]]])
    np.testing.assert_allclose(normal(triangle, 0.0, [0.0, 0.5, 1.0]), [[0, 0, 1]] * 3, atol=1e-14)
    # folded along u = 1/2: normals point up on one side and down on the other
    fold = patch([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]], [[0, 0, 0], [0, 1, 0]]])
    with pytest.raises(CurveError, match=r"u = 0.5, v = 0.3.*no common limit"):
        normal(fold, [0.2, 0.5], [0.3, 0.3])
    line = patch([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 0, 0]]])
    with pytest.raises(CurveError, match="has no normal"):
        normal(line, 0.5, 0.5)
    with pytest.raises(CurveError, match=r"u = 0, v = 0.5.*degenerate"):
        curvatures(triangle, 0.0, 0.5)
    # u^3 stands still at u = 0 but not its normals, also at an inner edge
    cubic = patch([[[-1, 0, 0], [-1, 1, 0]], [[1, 0, 0], [1, 1, 0]], [[-1, 0, 0], [-1, 1, 0]],
        [[1, 0, 0], [1, 1, 0]]])  # fmt: skip
    for surface in (cubic, cubic.with_knots([0.5])):
        assert not surface.at(0.5, 0.5, 1, 0).any()
        np.testing.assert_allclose(normal(surface, 0.5, 0.5), [0, 0, 1], atol=1e-12)


def test_shape_is_for_surfaces_in_space():
    flat = patch(np.random.default_rng(0).normal(size=(2, 2, 2)))
    for ask in (normal, curvatures, fundamental_forms):
        with pytest.raises(ValueError, match="3 coordinates"):
            ask(flat, 0.5, 0.5)
    with pytest.raises(ValueError, match="3 coordinates"):
        area(flat)


def test_frames_stand_on_the_surface_and_look_along_the_direction(bumpy):
    u, v = INSIDE
    ways = np.random.default_rng(1).normal(size=(40, 2))
    frames = surface_frame(bumpy, u, v, ways)
    square = frames.swapaxes(1, 2) @ frames
    np.testing.assert_allclose(square, np.tile(np.eye(3), (40, 1, 1)), rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(frames[:, :, 2], normal(bumpy, u, v), rtol=0, atol=1e-15)
    h = 1e-6
    step = bumpy.at(u + h * ways[:, 0], v + h * ways[:, 1]) - bumpy.at(u, v)
    step /= np.linalg.norm(step, axis=1)[:, None]
    np.testing.assert_allclose(frames[:, :, 0], step, rtol=0, atol=2e-5)
    one = surface_frame(bumpy, u.reshape(8, 5), v.reshape(8, 5), [1.0, 0.0])
    assert one.shape == (8, 5, 3, 3)
    longer = surface_frame(bumpy, 0.3, 0.4, [1e-5, 2e-5])
    np.testing.assert_allclose(longer, surface_frame(bumpy, 0.3, 0.4, [1, 2]), atol=1e-14)


def test_no_frame_stands_where_there_is_none(sphere, bumpy):
    with pytest.raises(CurveError, match=r"u = 0, v = 0.2.*no frame"):
        surface_frame(sphere, [0.5, 0.0], 0.2, [1.0, 0.0])
    with pytest.raises(CurveError, match="leads nowhere"):
        surface_frame(bumpy, 0.5, 0.5, [0.0, 0.0])
    with pytest.raises(ValueError, match="direction"):
        surface_frame(bumpy, 0.5, 0.5, [0.0, 0.0, 1.0])
