"""B-spline surfaces: values, derivatives and changes that change nothing."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import NdBSpline

from splinearm.curves.bspline import BSpline
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_net import bezier_surface, closed_surface, is_closed
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)
SAME = 3e-14


def make_surface(random_curve, seed, *, rational=None, dim=3, form="any", degree=None):
    """Give a random surface whose two directions are those of random curves."""
    rng = np.random.default_rng(seed)
    forms = form if isinstance(form, tuple) else (form, form)
    first, second = (
        random_curve(int(rng.integers(2**31)), degree=degree, form=f, rational=False) for f in forms
    )
    shape = len(first.points), len(second.points)
    points = rng.uniform(-1.0, 1.0, (*shape, dim))
    weights = rng.uniform(0.5, 2.0, shape)
    rational = bool(rng.integers(2)) if rational is None else rational
    for axis, curve in ((0, first), (1, second)):
        if curve.is_periodic:
            m = shape[axis] - curve.degree
            around = np.arange(shape[axis]) % m
            points, weights = points.take(around, axis), weights.take(around, axis)
    return BSplineSurface(
        first.knots,
        second.knots,
        points,
        first.degree,
        second.degree,
        weights if rational else None,
    )


def places_of(surface, count=5):
    """Give parameters on every patch, its edges among them, as two columns to broadcast."""
    u, v = (
        np.unique(np.concatenate([np.linspace(a, b, count) for a, b in pairwise(k)]))
        for k in surface.breaks
    )
    return u[:, None], v[None]


def check_same(surface, other, tolerance=SAME):
    assert surface.domain == other.domain
    assert surface.is_rational == other.is_rational
    at = places_of(surface)
    np.testing.assert_allclose(other.at(*at), surface.at(*at), rtol=0, atol=tolerance)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_values_and_all_derivatives_are_those_of_scipy(random_curve, seed):
    surface = make_surface(random_curve, seed, rational=False)
    degrees = surface.degree_u, surface.degree_v
    peer = NdBSpline((surface.knots_u, surface.knots_v), surface.points, degrees)
    rng = np.random.default_rng(seed)
    u, v = (rng.uniform(*ends, 20) for ends in surface.domain)
    jet = surface.jet(u, v, 3)
    narrow = [np.diff(breaks).min() for breaks in surface.breaks]
    for i in range(min(3, degrees[0]) + 1):
        for j in range(min(3, degrees[1]) + 1):
            wanted = peer(np.stack((u, v), axis=-1), nu=(i, j))
            # what points of size 1 may be differentiated to on the narrowest patch
            scale = max(1.0, np.abs(wanted).max(), 0.1 * narrow[0] ** -i * narrow[1] ** -j)
            for found in (jet[:, i, j], surface.at(u, v, i, j)):
                np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * scale)
    if degrees[0] < 3:
        assert not jet[:, degrees[0] + 1 :].any()


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_derivatives_of_rational_surfaces_are_limits_of_differences(random_curve, seed):
    surface = make_surface(random_curve, seed, rational=True, degree=3)
    rng = np.random.default_rng(seed)
    pieces = [rng.integers(len(b) - 1) for b in surface.breaks]
    low, high = np.array([b[k : k + 2] for b, k in zip(surface.breaks, pieces, strict=True)]).T
    u, v = low + (high - low) * rng.uniform(0.2, 0.8, 2)
    h = 1e-5 * (high - low)
    jet = surface.jet(u, v, 3)
    for i in range(3):
        for j in range(3):
            by_u = surface.at(u + h[0], v, i, j) - surface.at(u - h[0], v, i, j)
            by_v = surface.at(u, v + h[1], i, j) - surface.at(u, v - h[1], i, j)
            for k, step, found in ((0, by_u, jet[i + 1, j]), (1, by_v, jet[i, j + 1])):
                # per share of the patch, on which derivatives are of the size of the points
                scale = (high[0] - low[0]) ** -i * (high[1] - low[1]) ** -j / (high[k] - low[k])
                off = np.abs(step / (2.0 * h[k]) - found).max()
                assert off < 3e-4 * scale * max(1.0, np.abs(found).max() / scale)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_weights_all_the_same_count_nothing_and_constant_nets_give_constants(random_curve, seed):
    surface = make_surface(random_curve, seed, rational=True)
    at = places_of(surface)
    ones = np.ones_like(surface.points)
    flat = BSplineSurface(
        surface.knots_u, surface.knots_v, ones, surface.degree_u, surface.degree_v, surface.weights
    )
    np.testing.assert_allclose(flat.at(*at), 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(flat.jet(*at, 1)[..., 1, 0, :].max(), 0.0, atol=1e-9)
    plain, even = (
        BSplineSurface(
            surface.knots_u,
            surface.knots_v,
            surface.points,
            surface.degree_u,
            surface.degree_v,
            w,
        )
        for w in (None, np.full(surface.points.shape[:2], 3.0))
    )
    np.testing.assert_allclose(even.at(*at), plain.at(*at), rtol=0, atol=SAME)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_insertion_elevation_clamping_and_swapping_change_nothing(random_curve, seed):
    surface = make_surface(random_curve, seed)
    rng = np.random.default_rng(seed)
    us, vs = (rng.uniform(*ends, 3) for ends in surface.domain)
    for other in (
        surface.with_knots(us, vs),
        surface.with_knots(vs=vs),
        surface.elevated(1, 2).clamped(),
        surface.swapped().swapped(),
    ):
        check_same(surface, other)
    u, v = places_of(surface)
    np.testing.assert_allclose(surface.swapped().at(v, u), surface.at(u, v), rtol=0, atol=SAME)
    assert surface.with_knots(us).points.shape[0] == surface.points.shape[0] + 3
    assert surface.elevated(2).degree_u == surface.degree_u + 2
    backwards, (start, end) = surface.reversed("u"), surface.domain[0]
    assert backwards.domain == surface.domain
    for k, c in enumerate(surface.bezier()[0][[0, -1]]):
        found = backwards.at(end if k == 0 else start, v)
        np.testing.assert_allclose(found, surface.at(c, v), rtol=0, atol=SAME)
    middle = start + 0.5 * (end - start)
    u = np.linspace(start, middle, 5)[1:-1, None]
    np.testing.assert_allclose(backwards.at(end - (u - start), v), surface.at(u, v), atol=1e-10)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_bezier_patches_and_parts_are_the_surface(random_curve, seed):
    surface = make_surface(random_curve, seed)
    ends_u, ends_v, patches = surface.bezier()
    assert patches.shape[:2] == (len(ends_u) - 1, len(ends_v) - 1)
    k, i = len(ends_u) // 2, len(ends_v) // 2
    rows = patches[k - 1, i - 1]
    points, weights = (rows[..., :-1] / rows[..., -1:], rows[..., -1])
    patch = bezier_surface(*((points, weights) if surface.is_rational else (rows,)))
    x = np.linspace(0.05, 0.95, 7)
    u = ends_u[k - 1] + x * (ends_u[k] - ends_u[k - 1])
    v = ends_v[i - 1] + x * (ends_v[i] - ends_v[i - 1])
    wanted = surface.at(u[:, None], v)
    np.testing.assert_allclose(patch.at(x[:, None], x), wanted, rtol=0, atol=1e-11)
    part = surface.part((u[1], u[-1]), (v[0], v[-2]))
    assert part.domain == ((u[1], u[-1]), (v[0], v[-2]))
    np.testing.assert_allclose(part.at(u[1:, None], v[:-1]), wanted[1:, :-1], rtol=0, atol=SAME)
    before, behind = surface.split("v", v[3])
    np.testing.assert_allclose(before.at(u[:, None], v[:4]), wanted[:, :4], rtol=0, atol=SAME)
    np.testing.assert_allclose(behind.at(u[:, None], v[3:]), wanted[:, 3:], rtol=0, atol=SAME)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_isocurves_lie_on_the_surface(random_curve, seed):
    surface = make_surface(random_curve, seed)
    rng = np.random.default_rng(seed)
    u, v = (float(rng.uniform(*ends)) for ends in surface.domain)
    us, vs = (x.ravel() for x in places_of(surface))
    along_u, along_v = surface.along_u(v), surface.along_v(u)
    assert along_u.degree == surface.degree_u
    assert along_u.is_rational == surface.is_rational
    np.testing.assert_allclose(along_u.at(us), surface.at(us, v), rtol=0, atol=SAME)
    np.testing.assert_allclose(along_v.at(vs), surface.at(u, vs), rtol=0, atol=SAME)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_maps_of_the_net_are_maps_of_the_surface(random_curve, seed):
    surface = make_surface(random_curve, seed)
    rng = np.random.default_rng(seed)
    at = places_of(surface)
    affine, projective = np.eye(4), np.eye(4)
    affine[:3] = rng.normal(size=(3, 4))
    projective += 0.1 * rng.uniform(-1.0, 1.0, (4, 4))
    points = surface.at(*at)
    wanted = points @ affine[:3, :3].T + affine[:3, 3]
    np.testing.assert_allclose(surface.mapped(affine).at(*at), wanted, rtol=0, atol=1e-13)
    rows = np.concatenate((points, np.ones((*points.shape[:-1], 1))), axis=-1) @ projective.T
    found = surface.mapped(projective)
    assert found.is_rational
    np.testing.assert_allclose(found.at(*at), rows[..., :3] / rows[..., 3:], rtol=0, atol=1e-13)


def test_a_map_that_sends_a_place_to_infinity_is_refused():
    surface = bezier_surface([[[-1, 0], [-1, 1]], [[1, 0], [1, 1]]])
    with pytest.raises(CurveError, match="infinity"):
        surface.mapped([[1, 0, 0], [0, 1, 0], [1, 0, 0]])


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_a_grid_is_every_u_with_every_v(random_curve, seed):
    surface = make_surface(random_curve, seed)
    rng = np.random.default_rng(seed)
    us, vs = rng.uniform(*surface.domain[0], 6), rng.uniform(*surface.domain[1], 5)
    found = surface.grid(us, vs, 2)
    assert found.shape == (6, 5, 3, 3, 3)
    np.testing.assert_allclose(found, surface.jet(us[:, None], vs, 2), rtol=1e-13, atol=1e-13)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_rings_close_and_stay_rings(random_curve, seed):
    surface = make_surface(random_curve, seed, form=("ring", "clamped"))
    assert is_closed(surface, "u")
    us = np.random.default_rng(seed).uniform(*surface.domain[0], 2)
    for other in (surface.with_knots(us), surface.elevated(1)):
        check_same(surface, other)
        np.testing.assert_allclose(
            other.points[other.points.shape[0] - other.degree_u :],
            other.points[: other.degree_u],
            rtol=0,
            atol=1e-13,
        )


def test_a_net_closed_both_ways_is_a_smooth_ring_of_rings():
    a = 2 * np.pi * np.arange(6) / 6
    ring = np.stack([(3 + np.cos(a)) * np.cos(b) for b in a])
    points = np.stack(
        (ring, np.stack([(3 + np.cos(a)) * np.sin(b) for b in a]), np.tile(np.sin(a), (6, 1))), -1
    )
    knots = (np.arange(7.0), np.arange(7.0))
    surface = closed_surface(knots, points, (3, 2), np.ones((6, 6)), along="uv")
    assert surface.domain == ((0.0, 6.0), (0.0, 6.0))
    start, end = surface.jet([0.0, 2.3], [1.1, 0.0], 1), surface.jet([6.0, 2.3], [1.1, 6.0], 1)
    np.testing.assert_allclose(start, end, rtol=0, atol=1e-14)
    assert is_closed(surface, "v")
    assert not is_closed(surface.part(v=(0.0, 4.0)), "v")
    with pytest.raises(ValueError, match="along"):
        is_closed(surface, "x")
    with pytest.raises(ValueError, match="along"):
        closed_surface(knots, points, (3, 2), along="w")


def test_what_is_no_surface_is_refused():
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    net = np.zeros((2, 2, 3))
    good = BSplineSurface(knots, knots, net, 1, 1)
    for wrong, said in (
        ((knots, knots, np.zeros((2, 3, 3)), 1, 1), "along v.*knots"),
        ((knots[::-1], knots, net, 1, 1), "along u.*never falling"),
        ((knots, knots, np.zeros((2, 2)), 1, 1), "points"),
        ((knots, knots, np.zeros((2, 2, 0)), 1, 1), "coordinate"),
        ((knots, knots, net, 1, 1, np.array([[1.0, 1.0], [0.0, 1.0]])), "weights"),
        ((knots, knots, np.full((2, 2, 3), np.nan), 1, 1), "finite"),
    ):
        with pytest.raises(ValueError, match=said):
            BSplineSurface(*wrong)
    with pytest.raises(ValueError, match="above 0"):
        BSplineSurface.from_homogeneous((knots, knots), net, (1, 1))
    for u, v in ((1.5, 0.0), (0.0, -0.1), (np.nan, 0.5)):
        with pytest.raises(CurveError, match="defined from"):
            good.at(u, v)
    with pytest.raises(CurveError, match="defined from v"):
        good.grid([0.5], [2.0])
    with pytest.raises(ValueError, match="0 or more"):
        good.at(0.5, 0.5, -1)
    with pytest.raises(ValueError, match="grid"):
        good.grid(0.5, [0.5])
    with pytest.raises(ValueError, match="along"):
        good.reversed("w")
    with pytest.raises(CurveError, match="can be split"):
        good.split("u", 1.0)
    with pytest.raises(CurveError, match="not at"):
        good.along_v(2.0)


def test_a_bare_curve_change_may_be_made_to_a_direction():
    points = np.random.default_rng(1).normal(size=(5, 4, 3))
    surface = BSplineSurface(
        np.r_[0, 0, 0, 1, 2, 3, 3, 3], np.r_[0, 0, 0, 0, 1, 1, 1, 1], points, 2, 3
    )
    open_ended = surface.changed("u", BSpline.unclamped)
    assert len(np.unique(open_ended.knots_u)) == 8
    check_same(surface, open_ended)
    moved = surface.over((1.0, 2.0), (0.0, 5.0))
    np.testing.assert_allclose(moved.at(1.5, 2.5), surface.at(1.5, 0.5), rtol=0, atol=SAME)
