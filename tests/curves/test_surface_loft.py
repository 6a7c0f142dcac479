"""Swept, lofted and Coons surfaces, and offsets."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.compatible import make_compatible
from splinearm.curves.coons import coons
from splinearm.curves.coons_bicubic import Side, coons_bicubic
from splinearm.curves.frame import RotationMinimisingFrame
from splinearm.curves.interpolation import interpolate
from splinearm.curves.loft import lofted
from splinearm.curves.plane import Plane
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_net import bezier_surface, is_closed
from splinearm.curves.surface_normal import normal
from splinearm.curves.surface_of_curves import revolved
from splinearm.curves.surface_offset import OffsetSurface
from splinearm.curves.surface_shape import curvatures
from splinearm.curves.sweep import swept
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)
X = np.linspace(0.0, 1.0, 23)


def curve_of(seed, degree, *, rational=False, dim=3):
    rng = np.random.default_rng(seed)
    knots = np.r_[np.zeros(degree + 1), np.sort(rng.uniform(0, 1, 6 - degree)), np.ones(degree + 1)]
    weights = rng.uniform(0.9, 1.1, 7) if rational else None
    points = rng.uniform(-0.5, 0.5, (7, dim))
    points[:, 0] += np.linspace(0.0, 4.0, 7)
    return BSpline(knots, points, degree, weights)


def carried(profile, frame, u, v):
    """Give the exact places of a swept surface, (k, l, 3)."""
    axes = frame.at(v)
    p = profile.at(u)
    p = np.column_stack((p, np.zeros((len(u), 3 - profile.dim))))
    return frame.curve.at(v) + np.einsum("lcj,kj->klc", np.roll(axes, -1, axis=2), p)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
@pytest.mark.parametrize(("degree", "rational"), [(3, False), (2, False), (4, True)])
def test_a_swept_surface_is_as_near_as_was_asked(degree, rational, tolerance):
    path = curve_of(degree, degree, rational=rational)
    profile = conic.ellipse(0.3, 0.1)
    surface = swept(profile, path, tolerance, normal=[0, 0, 1])
    u, v = np.linspace(0, 1, 17), np.linspace(0, 1, 301)
    frame = RotationMinimisingFrame(path, np.array([0.0, 0.0, 1.0]))
    off = surface.grid(u, v)[:, :, 0, 0] - carried(profile, frame, u, v)
    assert np.linalg.norm(off, axis=-1).max() <= tolerance
    assert surface.domain == (profile.domain, path.domain)


def test_a_circle_carried_around_a_circle_is_a_torus_that_closes():
    around = conic.circle(3.0, Plane.facing([0, 0, 0], [0, 0, 1]))
    surface = swept(conic.circle(1.0), around, 1e-9)
    p = surface.grid(X, X)[:, :, 0, 0]
    tube = np.hypot(np.hypot(p[..., 0], p[..., 1]) - 3.0, p[..., 2])
    np.testing.assert_allclose(tube, 1.0, rtol=0, atol=1e-9)


def test_along_a_closed_path_the_frame_may_close_as_well():
    a = 2.0 * np.pi * np.arange(7) / 7
    ring = np.column_stack((3 * np.cos(a), 3 * np.sin(a), np.sin(2 * a) + np.cos(3 * a)))
    bent = interpolate(ring, ends="closed")
    profile = BSpline([0, 0, 1, 1], [[0.2, 0, 0.1], [0.5, 0.1, 0]], 1)
    wavy = swept(profile, bent, 1e-7, closed=True)
    start, end = bent.domain
    np.testing.assert_allclose(wavy.at(X, start), wavy.at(X, end), rtol=0, atol=1e-12)
    open_ended = swept(profile, bent, 1e-7)
    assert np.abs(open_ended.at(X, start) - open_ended.at(X, end)).max() > 1e-3
    v = np.linspace(start, end, 201)
    frame = RotationMinimisingFrame(bent, None, closed=True)
    off = wavy.grid(X, v)[:, :, 0, 0] - carried(profile, frame, X, v)
    assert np.linalg.norm(off, axis=-1).max() <= 1e-7


def test_paths_that_nothing_can_be_carried_along_are_refused():
    corner = BSpline([0, 0, 1, 2, 2], [[0, 0, 0], [1, 0, 0], [1, 1, 0]], 1)
    with pytest.raises(CurveError, match="corner"):
        swept(conic.circle(0.1), corner, 1e-6)
    line = conic.line([0, 0, 0], [1, 0, 0])
    with pytest.raises(ValueError, match="tolerance"):
        swept(conic.circle(0.1), line, 0.0)
    with pytest.raises(ValueError, match="profile"):
        swept(BSpline([0, 0, 1, 1], [[0], [1]], 1), line, 1e-6)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(SEEDS, st.sampled_from(["free", "natural", "closed"]))
def test_a_lofted_surface_has_its_sections(seed, ends):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 7))
    sections = []
    for k in range(count):
        base = curve_of(seed + k, int(rng.integers(2, 5)), rational=bool(rng.integers(2)))
        weights = None if base.weights is None else 1.0 + 0.02 * (base.weights - 1.0)
        angle = 2.0 * np.pi * k / count
        points = base.points + 3.0 * np.array([0.0, np.cos(angle), np.sin(angle)])
        sections.append(BSpline(base.knots, points, base.degree, weights))
    closed = ends == "closed"
    v = np.concatenate(([0.0], np.cumsum(rng.uniform(0.5, 1.0, count - (not closed)))))
    surface = lofted(sections, parameters=v, ends=ends)
    for k in range(count + closed):
        found = surface.at(X, v[k])
        np.testing.assert_allclose(found, sections[k % count].at(X), rtol=0, atol=1e-12)
    by_distance = lofted(sections, ends=ends)
    assert by_distance.domain[1] == (0.0, 1.0)
    np.testing.assert_allclose(by_distance.at(X, 0.0), sections[0].at(X), rtol=0, atol=1e-12)
    assert is_closed(by_distance, "v") == closed


def test_what_cannot_be_lofted_is_refused():
    a, b = curve_of(1, 3), curve_of(2, 2)
    with pytest.raises(ValueError, match="sections"):
        lofted([a])
    with pytest.raises(CurveError, match="sections 1 and 2 are the same"):
        lofted([a, b, b, a], degree=2)
    with pytest.raises(ValueError, match="at least 4"):
        lofted([a, b])
    assert lofted([a, b], degree=1).degree_v == 1
    spiky = [BSpline(a.knots, a.points + k, 3, w) for k, w in enumerate(([1.0] * 7, [40.0] * 7,
        [1.0] * 7, [1.0] * 7))]  # fmt: skip
    with pytest.raises(CurveError, match="weight"):
        lofted(spiky)


def boundary(seed, *, rational):
    rng = np.random.default_rng(seed)
    corners = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [2, 2, 0]]) + rng.normal(size=(4, 3)) * 0.2
    curves = []
    for i, j in ((0, 1), (2, 3), (0, 2), (1, 3)):
        degree = int(rng.integers(1, 4))
        inner = np.sort(rng.uniform(0, 1, 2))
        knots = np.r_[np.zeros(degree + 1), inner, np.ones(degree + 1)]
        points = np.linspace(corners[i], corners[j], degree + 3)
        points[1:-1] += rng.normal(size=(degree + 1, 3)) * 0.3
        weights = rng.uniform(0.8, 1.2, degree + 3)
        weights[[0, -1]] = 1.0
        weights *= rng.uniform(0.2, 5.0)
        curves.append(BSpline(knots, points, degree, weights if rational and i + j < 5 else None))
    return curves


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(SEEDS, st.booleans())
def test_a_coons_patch_has_its_four_boundaries(seed, rational):
    bottom, top, left, right = boundary(seed, rational=rational)
    surface = coons(bottom, top, left, right)
    for found, curve in (
        (surface.along_u(0.0), bottom),
        (surface.along_u(1.0), top),
        (surface.along_v(0.0), left),
        (surface.along_v(1.0), right),
    ):
        np.testing.assert_allclose(found.at(X), curve.at(X), rtol=0, atol=1e-13)
    if not rational:
        u, v = X[:, None, None], X[None, :, None]
        ways = (1 - v) * bottom.at(X)[:, None] + v * top.at(X)[:, None]
        ways = ways + (1 - u) * left.at(X)[None] + u * right.at(X)[None]
        (a, b), (c, d) = (f.at([0.0, 1.0]) for f in (bottom, top))
        ways -= (1 - u) * (1 - v) * a + u * (1 - v) * b + (1 - u) * v * c + u * v * d
        np.testing.assert_allclose(surface.at(X[:, None], X), ways, rtol=0, atol=1e-13)


def test_boundaries_that_do_not_meet_are_refused():
    bottom, top, left, right = boundary(1, rational=False)
    with pytest.raises(CurveError, match=r"top and the left curve are .* apart"):
        coons(bottom, top.reversed(), left, right)
    with pytest.raises(ValueError, match="coordinates"):
        coons(bottom, top, left, conic.line([0, 0], [1, 1]))
    with pytest.raises(ValueError, match="degree"):
        coons(bottom, top, left, BSpline([0, 1], [[0, 0, 0]], 0))
    with pytest.raises(ValueError, match="at least one"):
        make_compatible([])
    uneven = BSpline(left.knots, left.points, left.degree, np.linspace(1.0, 2.0, len(left.points)))
    with pytest.raises(CurveError, match="weights"):
        coons(bottom, top, uneven, right)


def torus(plane=0.0):
    away = Plane([3.0, 0.0, plane], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    return revolved(conic.circle(1.0, away), [0, 0, 0], [0, 0, 1])


def test_an_offset_torus_is_a_thinner_torus():
    surface, thin = torus(), OffsetSurface(torus(), 0.4)
    u, v = np.random.default_rng(0).uniform(0, 1, (2, 50))
    p = thin.at(u, v)
    tube = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 3.0, p[:, 2])
    np.testing.assert_allclose(tube, 0.6, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(thin.normal(u, v), normal(surface, u, v))
    np.testing.assert_allclose(thin.curvatures(u, v).values[:, 1], 1.0 / 0.6, rtol=1e-12)
    assert thin.domain == surface.domain
    with pytest.raises(CurveError, match=r"reaches the centre of curvature"):
        OffsetSurface(surface, 1.01).curvatures(0.3, 0.4)


def test_curvatures_of_an_offset_are_those_of_its_bspline():
    surface = bezier_surface(
        np.dstack((*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), np.zeros((4, 4))))
        + np.random.default_rng(2).uniform(-0.3, 0.3, (4, 4, 3))
    )
    offset = OffsetSurface(surface, 0.1)
    fit, off = offset.to_bspline(1e-6)
    assert off <= 1e-6
    u, v = np.random.default_rng(0).uniform(0, 1, (2, 30))
    np.testing.assert_allclose(fit.at(u, v), offset.at(u, v), rtol=0, atol=1e-6)
    np.testing.assert_allclose(normal(fit, u, v), offset.normal(u, v), rtol=0, atol=1e-4)
    found, wanted = curvatures(fit, u, v), offset.curvatures(u, v)
    np.testing.assert_allclose(found.values, wanted.values, rtol=0, atol=5e-3)
    jets = fit.jet(u, v, 1)
    pair = np.stack((jets[:, 1, 0], jets[:, 0, 1]), axis=1)
    np.testing.assert_allclose(wanted.parameters @ pair, wanted.directions, rtol=0, atol=1e-4)


def test_an_offset_sphere_is_a_sphere_its_poles_among_it():
    half = conic.arc(1.0, -0.5 * np.pi, 0.5 * np.pi, Plane([0, 0, 0], [1, 0, 0], [0, 0, 1]))
    fit, _ = OffsetSurface(revolved(half, [0, 0, 0], [0, 0, 1]), -0.5).to_bspline(1e-2, 3)
    radii = np.linalg.norm(fit.grid(X, X), axis=-1)
    np.testing.assert_allclose(radii, 1.5, rtol=0, atol=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("degree", [3, 5])
def test_offsets_reach_tight_tolerances(degree):
    fit, off = OffsetSurface(torus(), 0.4).to_bspline(1e-9 if degree == 5 else 1e-7, degree)
    p = fit.at(*np.random.default_rng(0).uniform(0, 1, (2, 20_000)))
    tube = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 3.0, p[:, 2])
    assert np.abs(tube - 0.6).max() <= 1.5 * off


def test_offsets_that_are_none_are_refused():
    roof = BSplineSurface(np.r_[0, 0, 1, 2, 2], np.r_[0, 0, 1, 1],
        [[[0, 0, 0], [0, 1, 0]], [[1, 0, 1], [1, 1, 1]], [[2, 0, 0], [2, 1, 0]]], 1, 1)  # fmt: skip
    with pytest.raises(CurveError, match="u = 1: it has an edge"):
        OffsetSurface(roof, 0.1).to_bspline(1e-3)
    with pytest.raises(CurveError, match="v = 1: it has an edge"):
        OffsetSurface(roof.swapped(), 0.1).to_bspline(1e-3)
    with pytest.raises(CurveError, match="centre of curvature"):
        OffsetSurface(torus(), 1.5).to_bspline(1e-3)
    with pytest.raises(ValueError, match="distance"):
        OffsetSurface(roof, np.inf)
    for tolerance, degree in ((0.0, 3), (1e-3, 1)):
        with pytest.raises(ValueError, match="want"):
            OffsetSurface(roof, 0.1).to_bspline(tolerance, degree)


def side_of(surface, along, *, last):
    """Give a boundary of a polynomial surface with its slope, exactly."""
    flat = surface if along == "v" else surface.swapped()
    at = flat.domain[0][1 if last else 0]
    curve = flat.along_v(at)
    knots, points, p = flat.knots_u, flat.points, flat.degree_u
    i = len(points) - 2 if last else 0
    slope = (points[i + 1] - points[i]) * p / (knots[i + p + 1] - knots[i + 1])
    return Side(curve, BSpline(flat.knots_v, slope, flat.degree_v))


@pytest.fixture(scope="module")
def hilly():
    rng = np.random.default_rng(6)
    knots = np.r_[[2.0] * 5, 2.5, 3.1, [4.0] * 5], np.r_[[0.0] * 4, 0.2, 0.3, 0.9, [1.0] * 4]
    return BSplineSurface(*knots, rng.normal(size=(7, 7, 3)), 4, 3)


def test_a_bicubic_patch_has_boundaries_and_slopes(hilly):
    sides = [side_of(hilly, along, last=last) for along in "uv" for last in (False, True)]
    patch = coons_bicubic(*sides)
    assert patch.domain == hilly.domain
    u, v = 2.0 + 2.0 * X, X
    for found, wanted in ((patch, hilly), (patch.swapped(), hilly.swapped())):
        a, b = (u, v) if found is patch else (v, u)
        for end in (a[0], a[-1]):
            for order in (0, 1):
                np.testing.assert_allclose(
                    found.at(end, b, order), wanted.at(end, b, order), rtol=0, atol=1e-11
                )
    # inside, what the boundary says does not determine the surface
    assert np.abs(patch.at(3.0, 0.5) - hilly.at(3.0, 0.5)).max() > 1e-3


def test_a_bicubic_patch_from_a_bicubic_surface_is_it():
    surface = bezier_surface(np.random.default_rng(1).normal(size=(4, 4, 2)))
    sides = [side_of(surface, along, last=last) for along in "uv" for last in (False, True)]
    found = coons_bicubic(*sides)
    assert found.points.shape == (4, 4, 2)
    np.testing.assert_allclose(found.points, surface.points, rtol=0, atol=1e-13)


def test_sides_that_do_not_agree_are_refused(hilly):
    bottom, top, left, right = (
        side_of(hilly, along, last=last) for along in "uv" for last in (False, True)
    )
    steep = Side(top.curve, BSpline(top.slope.knots, 2.0 * top.slope.points, top.slope.degree))
    with pytest.raises(CurveError, match="top and the left side differ in tangent along v"):
        coons_bicubic(bottom, steep, left, right)
    bent = top.slope.points.copy()
    bent[1] += 0.1
    with pytest.raises(CurveError, match="differ in twist"):
        coons_bicubic(
            bottom, Side(top.curve, BSpline(top.slope.knots, bent, top.slope.degree)), left, right
        )
    with pytest.raises(ValueError, match="domain"):
        coons_bicubic(bottom, Side(top.curve.over(0.0, 1.0), top.slope.over(0.0, 1.0)), left, right)
    flat = Side(conic.line([0, 0], [1, 0]), conic.line([0, 1], [1, 1]))
    with pytest.raises(ValueError, match="coordinates"):
        coons_bicubic(
            flat, flat, *[Side(s.curve.over(0, 1), s.slope.over(0, 1)) for s in (left,) * 2]
        )
    with pytest.raises(ValueError, match="polynomial"):
        Side(conic.circle(1.0), conic.line([0, 0], [1, 1]))
    with pytest.raises(ValueError, match="slope"):
        Side(bottom.curve, conic.line([0, 0], [1, 1]))
