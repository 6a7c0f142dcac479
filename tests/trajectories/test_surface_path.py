"""Ways over surfaces against closed forms, differences and the surfaces themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.conic import arc_through
from splinearm.curves.interpolation import interpolate
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_curve import SurfaceCurve
from splinearm.curves.surface_normal import normal
from splinearm.curves.surface_of_curves import extruded, revolved
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.surface_path import Heading, surface_path


def segment(start, end):
    return BSpline(np.array([0.0, 0.0, 1.0, 1.0]), np.array([start, end], dtype=float), 1)


def hilly(seed, degree=5):
    """A patch over a square of 0.2 m with hills of some centimetres."""
    rng = np.random.default_rng(seed)
    n = degree + 1
    x = np.linspace(0.0, 0.2, n)
    points = np.empty((n, n, 3))
    points[..., 0], points[..., 1] = np.meshgrid(x, x, indexing="ij")
    points[..., 2] = 0.06 * rng.uniform(-1.0, 1.0, (n, n))
    knots = np.repeat([0.0, 1.0], n)
    return BSplineSurface(knots, knots, points, degree, degree)


def winding(seed):
    """A smooth curve in the plane of parameters, of degree 5."""
    rng = np.random.default_rng(seed)
    places = np.linspace([0.1, 0.15], [0.9, 0.8], 6) + rng.uniform(-0.04, 0.04, (6, 2))
    return interpolate(places, degree=5, parameters="uniform").over(0.0, 1.0)


def axes(quat):
    return np.moveaxis(quaternion.to_matrix(quat), -1, 0)


@pytest.mark.property
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 999), heading=st.sampled_from(Heading), outward=st.booleans())
def test_the_tool_stands_in_the_normal_and_its_rates_are_exact(
    orientation_differences, seed, heading, outward
):
    curve = SurfaceCurve(hilly(seed), winding(seed))
    path = surface_path(curve, outward=outward, heading=heading)
    length = path.domain[1]
    s = np.linspace(0.0, length, 41)[1:-1]
    state = path.state(s)
    _, y, z = axes(state.quat)
    wanted = normal(curve.surface, *curve.plane_curve.at(s / length).T)
    assert np.allclose(z, wanted if outward else -wanted, atol=1e-13)
    assert np.allclose(state.p, curve.at(s / length), atol=1e-15)
    omega, alpha = orientation_differences(path.orientation, s, 2e-4 * length)
    size = np.abs(state.slope[:, 3:]).max()
    assert np.allclose(state.slope[:, 3:], omega, atol=1e-6 * size)
    assert np.allclose(state.bend[:, 3:], alpha, atol=1e-4 * np.abs(state.bend[:, 3:]).max())
    if heading is Heading.TRAVEL:
        x = axes(state.quat)[0]
        along = state.slope[:, :3] / np.linalg.norm(state.slope[:, :3], axis=1, keepdims=True)
        assert np.allclose(x, along, atol=1e-13)
        assert np.abs(np.sum(y * along, axis=1)).max() < 1e-13
    else:
        assert np.abs(np.sum(state.slope[:, 3:] * z, axis=1)).max() < 1e-12 * size


def dome(radius):
    """The upper half of a sphere, its pole at the end of u."""
    half = radius * np.sqrt(0.5)
    profile = arc_through([radius, 0.0, 0.0], [half, 0.0, half], [0.0, 0.0, radius])
    return revolved(profile, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0])


def test_a_free_heading_turns_no_more_than_the_normals_make_it():
    # around a latitude of a sphere carried directions come back turned by the solid angle inside:
    # Gauss and Bonnet
    radius, polar = 0.1, 0.7
    sphere = dome(radius)
    low, high = sphere.domain[0]
    for _ in range(80):
        middle = 0.5 * (low + high)
        below = sphere.at(middle, 0.0)[2] < radius * np.cos(polar)
        low, high = (middle, high) if below else (low, middle)
    around = SurfaceCurve(sphere, segment([low, 0.0], [low, 1.0]))
    path = surface_path(around, heading=Heading.FREE, outward=True)
    assert path.domain[1] == pytest.approx(2.0 * np.pi * radius * np.sin(polar), rel=1e-9)
    first, last = path.state(np.array(path.domain)).quat
    turned = float(quaternion.angle_between(first, last))
    solid = 2.0 * np.pi * (1.0 - np.cos(polar))
    assert np.cos(turned) == pytest.approx(np.cos(solid), abs=1e-7)


def test_along_a_cylinder_the_tool_turns_evenly_about_its_axis():
    ring = arc_through([0.05, 0.0, 0.0], [0.03, 0.04, 0.0], [0.0, 0.05, 0.0])
    pipe = extruded(ring, [0.0, 0.0, 0.2])
    (u0, u1), (v0, v1) = pipe.domain
    middle = 0.5 * (v0 + v1)
    path = surface_path(SurfaceCurve(pipe, segment([u0, middle], [u1, middle])))
    state = path.state(np.linspace(*path.domain, 30))
    rates = np.linalg.norm(state.slope[:, :3], axis=1)
    turning = state.slope[:, 3:] / rates[:, None]
    assert np.allclose(turning, [0.0, 0.0, 20.0], atol=1e-9)
    z = axes(state.quat)[2]
    assert np.allclose(np.abs(z[:, :2]) * 0.05, np.abs(state.p[:, :2]), atol=1e-12)


def test_x_points_at_the_start_where_it_is_told_to():
    curve = SurfaceCurve(hilly(4), winding(4))
    told = np.array([0.3, -1.0, 0.4])
    path = surface_path(curve, heading=Heading.FREE, x_start=told)
    x, y, _ = axes(path.state(np.zeros(1)).quat)
    assert abs(told @ y[0]) < 1e-12
    assert told @ x[0] > 0.0
    other = surface_path(curve, heading=Heading.FREE)
    # both carry the same frame, turned about the tool by one angle all the way
    s = np.linspace(*path.domain, 20)
    between = quaternion.multiply(quaternion.conjugate(path.state(s).quat), other.state(s).quat)
    assert np.allclose(np.abs(between), np.abs(between[0]), atol=1e-7)
    assert np.abs(between[:, 1:3]).max() < 1e-12


def test_the_start_direction_must_not_be_the_normal():
    curve = SurfaceCurve(hilly(4), winding(4))
    along = normal(curve.surface, *curve.plane_curve.at(0.0))
    with pytest.raises(ValueError, match="x_start: want a direction beside the normal"):
        surface_path(curve, heading=Heading.FREE, x_start=along)
    with pytest.raises(ValueError, match="x_start: is for"):
        surface_path(curve, x_start=along)


def test_crossing_a_knot_of_the_surface_is_a_break():
    flat = hilly(2, degree=4).with_knots([0.5], [0.25])
    path = surface_path(SurfaceCurve(flat, segment([0.1, 0.1], [0.9, 0.9])))
    shares = path.breaks / path.domain[1]
    assert np.allclose(shares, [0.0, 0.15 / 0.8, 0.4 / 0.8, 1.0], atol=1e-12)


def test_an_edge_of_the_surface_is_named():
    roof = np.array([[[0, 0, 0], [0, 1, 0]], [[1, 0, 1], [1, 1, 1]], [[2, 0, 0], [2, 1, 0.0]]])
    knots_u, knots_v = np.array([0, 0, 1, 2, 2.0]), np.array([0, 0, 1, 1.0])
    curve = SurfaceCurve(
        BSplineSurface(knots_u, knots_v, 0.1 * roof, 1, 1), segment([0, 0.5], [2, 0.5])
    )
    with pytest.raises(CurveError, match=r"corner there.*\n?.*s = 0\.14|s = 0\.14.*corner there"):
        surface_path(curve)
    along = SurfaceCurve(curve.surface, segment([0.2, 0.0], [1.8, 1.0]))
    with pytest.raises(CurveError, match=r"corner|edge"):
        surface_path(along, heading=Heading.FREE)


def test_a_pole_has_no_frame_and_is_named():
    with pytest.raises(CurveError, match=r"degenerate at u = 1, v = 0\.3"):
        surface_path(SurfaceCurve(dome(0.1), segment([0.0, 0.3], [1.0, 0.3])))


def test_a_way_that_turns_back_or_stands_still_is_refused():
    back = BSpline(
        np.array([0.0] * 3 + [1.0] * 3), np.array([[0.2, 0.5], [0.9, 0.5], [0.2, 0.5]]), 2
    )
    with pytest.raises(CurveError, match=r"no direction there|turn on the spot") as caught:
        surface_path(SurfaceCurve(hilly(1), back))
    assert "s = " in caught.value.where
    with pytest.raises(CurveError, match="stays where it is"):
        surface_path(SurfaceCurve(hilly(1), segment([0.5, 0.5], [0.5, 0.5])))
