import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import BSpline, interpolate
from splinearm.curves.bezier import Bezier
from splinearm.curves.conic import arc, circle, ellipse, line
from splinearm.curves.meeting import meet_curves, meet_itself, meet_line, meet_plane
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel


def moved(curve, shift, scale=1.0, angle=0.0):
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    return curve.mapped([[c, -s, shift[0]], [s, c, shift[1]], [0.0, 0.0, 1.0]])


def chebyshev(*, swapped=False):
    """The curve y = 4 x^3 - 3 x for x from -1 to 1, or with x and y exchanged."""
    powers = np.array([[-1.0, -1.0], [2.0, 18.0], [0.0, -48.0], [0.0, 32.0]])
    return Bezier.from_power(powers[:, ::-1] if swapped else powers).to_bspline()


def crossings(a, b, *, itself=False, count=1500):
    """How often two fine polylines cross."""
    P, Q = (c.at(np.linspace(*c.domain, count)) for c in (a, b))
    p, q = np.diff(P, axis=0)[:, None], np.diff(Q, axis=0)[None]
    gap = Q[None, :-1] - P[:-1, None]

    def across(x, y):
        return x[..., 0] * y[..., 1] - x[..., 1] * y[..., 0]

    with np.errstate(all="ignore"):
        s, t = across(gap, q) / across(p, q), across(gap, p) / across(p, q)
        hit = (s >= 0.0) & (s < 1.0) & (t >= 0.0) & (t < 1.0)
    return int(np.triu(hit, 2).sum() if itself else hit.sum())


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(st.floats(-1.5, 1.5), st.floats(0.0, 6.28))
def test_a_line_meets_a_circle_where_it_should(distance, angle):
    normal = np.array([np.cos(angle), np.sin(angle)])
    found = meet_line(circle(1.0), distance * normal, [-normal[1], normal[0]])
    if abs(distance) > 1.0 + 1e-12:
        assert len(found.u) == 0
    elif abs(distance) < 1.0 - 1e-12:
        places = circle(1.0).at(found.u)
        half = np.sqrt(1.0 - distance**2)
        assert np.allclose(places @ normal, distance, atol=1e-13)
        assert np.allclose(np.sort(places @ [-normal[1], normal[0]]), [-half, half], atol=1e-7)
        assert len(found.u) == 2


def test_a_tangent_touches_once_and_a_line_along_a_curve_is_a_stretch():
    assert np.allclose(meet_line(circle(2.0), [5.0, 2.0], [1.0, 0.0]).u, [0.25], atol=1e-7)
    path = BSpline([0, 0, 1, 2, 3, 4, 4], [[0, 1], [1, 0], [2, 0], [3, 0], [4, -1]], 1)
    found = meet_line(path, [9.0, 0.0], [1.0, 0.0])
    assert np.allclose(found.stretches, [[1.0, 3.0]])
    assert len(found.u) == 0
    assert np.allclose(meet_line(circle(1.0), [0.0, 0.0], [1.0, 0.0]).u, [0.0, 0.5])


def test_a_plane_meets_a_space_curve_where_the_height_is_0(random_curve):
    for seed in range(12):
        curve = random_curve(seed, dim=3, form="clamped")
        rng = np.random.default_rng(seed)
        base, normal = 0.3 * rng.normal(size=3), rng.normal(size=3)
        found = meet_plane(curve, base, normal)
        assert np.abs((curve.at(found.u) - base) @ normal).max(initial=0.0) <= 1e-12
        jumps = np.unique(curve.knots, return_counts=True)[1][1:-1] > curve.degree
        if not jumps.any():
            height = (curve.at(np.linspace(*curve.domain, 4001)) - base) @ normal
            assert len(found.u) == (height[1:] * height[:-1] < 0.0).sum()


@pytest.mark.parametrize("distance", [0.3, 1.0, 1.99, 2.0 - 1e-6])
def test_two_circles_meet_twice(distance):
    found = meet_curves(circle(1.0), moved(circle(1.0), (distance, 0.0)))
    height = np.sqrt(1.0 - 0.25 * distance**2)
    assert np.allclose(found.points[:, 0], 0.5 * distance, atol=1e-9)
    assert np.allclose(np.abs(found.points[:, 1]), height, atol=1e-9)
    assert len(found.u) == 2
    assert not found.touching.any()
    assert found.gaps.max() < 1e-14


def test_two_cubics_meet_nine_times():
    found = meet_curves(chebyshev(), chebyshev(swapped=True))
    # T3(T3(x)) = T9(x) = x
    x = np.cos(np.concatenate((np.arange(0, 5) * np.pi / 4, np.arange(1, 5) * np.pi / 5)))
    assert np.allclose(np.sort(found.points[:, 0]), np.sort(np.unique(x.round(14))), atol=1e-13)
    assert not found.touching.any()


@pytest.mark.parametrize(("shift", "scale"), [((2.0, 0.0), 1.0), ((0.5, 0.0), 0.5)])
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_tangent_circles_touch_once(shift, scale, angle):
    turned = np.array([np.cos(angle), np.sin(angle)]) * shift[0]
    found = meet_curves(circle(1.0), moved(circle(1.0), turned, scale, 0.4))
    assert len(found.u) == 1
    assert found.touching.all()
    assert np.allclose(found.points, [[np.cos(angle), np.sin(angle)]], atol=1e-9)
    assert found.gaps.max() < 1e-15


def test_the_tolerance_says_what_touches():
    near = moved(circle(1.0), (2.0 + 1e-6, 0.0))
    assert len(meet_curves(circle(1.0), near).u) == 0
    found = meet_curves(circle(1.0), near, tolerance=2e-6)
    assert len(found.u) == 1
    assert np.isclose(found.gaps[0], 1e-6, rtol=1e-3)
    assert found.touching.all()


def test_equal_curves_are_one_stretch():
    whole = circle(1.0)
    for other, ends in ((whole, [0.0, 1.0, 0.0, 1.0]), (whole.reversed(), [0.0, 1.0, 1.0, 0.0])):
        found = meet_curves(whole, other)
        assert np.allclose(found.stretches, [ends])
        assert len(found.u) == 0


def test_curves_that_turn_much_and_are_the_same_are_one_stretch():
    curve = BSpline([0, 0, 0, 0, 1, 2, 2, 2, 2], [[0, 0], [3, 4], [-2, 3], [4, -1], [1, 0]], 3)
    loop = Bezier([[0, 0], [3, 2], [-2, 2], [1, 0]]).to_bspline()
    for one in (curve, loop):
        start, end = one.domain
        found = meet_curves(one, one.over(0.0, 7.0).reversed())
        assert np.allclose(found.stretches, [[start, end, 7.0, 0.0]], atol=1e-7)
    # the loop also crosses the other one where it crosses itself
    assert len(found.u) == 2
    assert np.allclose(found.u + found.v / 7.0, 2.0 * found.u, atol=1e-9)


def test_overlapping_arcs_have_their_common_part_and_no_more():
    found = meet_curves(arc(1.0, 0.0, 2.0), arc(1.0, 1.0, 3.0))
    assert np.allclose(found.stretches, [[0.5, 1.0, 0.0, 0.5]], atol=1e-9)
    assert len(found.u) == 0
    lines = meet_curves(line([0, 0], [2, 0]), line([3, 0], [1, 0]))
    assert np.allclose(lines.stretches, [[0.5, 1.0, 1.0, 0.5]], atol=1e-9)


def test_parts_of_a_spline_over_other_knots_are_the_same(random_curve):
    curve = random_curve(3, degree=3, form="clamped", dim=3, rational=False)
    low, high = curve.domain
    a, b = low + 0.2 * (high - low), low + 0.6 * (high - low)
    found = meet_curves(
        curve.part(low, b), curve.part(a, high).with_knots([low + 0.45 * (high - low)])
    )
    assert np.allclose(found.stretches, [[a, b, a, b]], atol=1e-8)
    assert len(found.u) == 0


@pytest.mark.parametrize("seed", range(12))
def test_random_curves_meet_as_often_as_fine_polylines(random_curve, seed):
    a = random_curve(100 + seed, form="clamped", degree=2 + seed % 3)
    b = random_curve(200 + seed, form="clamped", degree=2 + (seed + 1) % 3)
    if any((np.unique(c.knots, return_counts=True)[1][1:-1] >= c.degree).any() for c in (a, b)):
        a, b = (interpolate(np.random.default_rng(k + seed).normal(size=(7, 2))) for k in (5, 50))
    found = meet_curves(a, b)
    assert len(found.u) == crossings(a, b)
    assert np.allclose(a.at(found.u), b.at(found.v), atol=1e-13)
    own = meet_itself(a)
    assert len(own.u) == crossings(a, a, itself=True)
    assert (own.u < own.v).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(50))
def test_many_random_walks_meet_as_often_as_fine_polylines(seed):
    rng = np.random.default_rng(seed)
    a, b = (interpolate(rng.normal(size=(9, 2)), ends=e) for e in ("natural", "closed"))
    assert len(meet_curves(a, b).u) == crossings(a, b, count=3000)
    assert len(meet_itself(a).u) == crossings(a, a, itself=True, count=3000)


def test_a_loop_meets_itself_where_it_closes():
    curve = Bezier([[0, 0], [3, 2], [-2, 2], [1, 0]]).to_bspline()
    found = meet_itself(curve)
    # it is symmetric, so the loop closes on its axis: x = 9 u - 24 u^2 + 16 u^3 = 1 / 2
    assert np.allclose(found.u + found.v, 1.0)
    assert np.allclose(9.0 * found.u - 24.0 * found.u**2 + 16.0 * found.u**3, 0.5)
    assert len(found.u) == 1


@pytest.mark.parametrize(("a", "b"), [(3, 4), (2, 5), (3, 2)])
def test_a_lissajous_figure_meets_itself_as_often_as_known(a, b):
    t = np.linspace(0.0, 2.0 * np.pi, 121)[:-1]
    curve = interpolate(np.column_stack((np.sin(a * t), np.sin(b * t + 0.3))), ends="closed")
    assert len(meet_itself(curve).u) == 2 * a * b - a - b


def test_what_only_goes_on_does_not_meet_itself():
    cusp = Bezier([[0, 0], [1, 1], [0, 1], [1, 0]]).to_bspline()
    corner = BSpline([0, 0, 1, 2, 2], [[0, 0], [1, 0], [0.0, 0.01]], 1)
    for curve in (circle(1.0), ellipse(3.0, 0.1), cusp, corner):
        found = meet_itself(curve)
        assert len(found.u) == len(found.stretches) == 0


def test_pieces_beside_a_jump_may_meet():
    jump = BSpline([0, 0, 1, 1, 2, 2], [[0, 0], [2, 0], [1, -1], [1, 1]], 1)
    found = meet_itself(jump)
    assert np.allclose([found.u, found.v], [[0.5], [1.5]])


def test_curves_that_touch_where_both_have_knots_touch_once():
    whole = circle(1.0)
    for shift in (0.0, 1e-10, 3e-6):
        other = moved(whole, (0.0, 2.0), angle=shift)
        found = meet_curves(whole, other.reversed())
        assert len(found.stretches) == 0
        assert len(found.u) == 1
        assert np.allclose(found.points, [[0.0, 1.0]], atol=1e-8)


def test_a_way_back_along_itself_is_a_stretch():
    found = meet_itself(BSpline([0, 0, 1, 2, 2], [[0, 0], [1, 0], [0, 0]], 1))
    assert np.allclose(found.stretches, [[0.0, 1.0, 2.0, 1.0]])


def test_curves_in_space_meet_within_the_tolerance():
    low, high = line([0, 0, 0], [1, 1, 0]), line([0, 1, 1e-8], [1, 0, 1e-8])
    assert len(meet_curves(low, high).u) == 0
    found = meet_curves(low, high, tolerance=2e-8)
    assert np.allclose([found.u, found.v], 0.5)
    assert np.isclose(found.gaps[0], 1e-8)
    helix = interpolate([[np.cos(t), np.sin(t), 0.1 * t] for t in np.linspace(0, 12, 60)])
    axis = line([2.0, 0.0, 0.0], [-2.0, 0.0, 1.2])
    assert len(meet_curves(helix, axis).u) == 0
    mark, way = helix.at(7.3), np.array([0.0, 1.0, 2.0])
    assert np.allclose(meet_curves(helix, line(mark - way, mark + way)).u, [7.3])


def test_ends_that_meet_count():
    first = line([0, 0], [2, 0])
    for other, u in (
        (line([1, 0], [1, 1]), 0.5),
        (line([2, 0], [3, 1]), 1.0),
        (line([2, 0], [3, 0]), 1.0),
    ):
        found = meet_curves(first, other)
        assert np.allclose(found.u, [u])
        assert np.allclose(found.v, [0.0])


def test_meetings_do_not_depend_on_units():
    rng = np.random.default_rng(7)
    a, b = rng.normal(size=(2, 8, 2))
    plain = meet_curves(*(interpolate(p, parameters="uniform") for p in (a, b)))
    for unit in (1e-7, 1e5):
        other = meet_curves(*(interpolate(unit * p, parameters="uniform") for p in (a, b)))
        assert np.allclose(other.u, plain.u, atol=1e-10)


def test_a_tolerance_far_too_small_for_curves_side_by_side_is_refused():
    inner = interpolate([[np.cos(t), np.sin(t)] for t in np.linspace(0.0, 3.0, 9)])
    outer = BSpline(inner.knots, inner.points * (1.0 + 1e-14), 3)
    assert len(meet_curves(inner, outer).stretches) == 1
    with pytest.raises(CurveError, match="side by side"):
        meet_curves(inner, outer, tolerance=1e-16)


def test_what_does_not_fit_is_refused():
    with pytest.raises(CurveError, match="one place"):
        meet_itself(BSpline([0, 0, 1, 1], np.ones((2, 2)), 1))
    with pytest.raises(ValueError, match="the same for both"):
        meet_curves(circle(1.0), line([0, 0, 0], [1, 1, 1]))
    with pytest.raises(ValueError, match="above 0"):
        meet_itself(circle(1.0), tolerance=0.0)
    with pytest.raises(ValueError, match="direction"):
        meet_plane(circle(1.0), [0.0, 0.0], [0.0, 0.0])
    with pytest.raises(ValueError, match="direction"):
        meet_line(circle(1.0), [0.0, 0.0], [0.0, 0.0])
    with pytest.raises(ValueError, match="plane"):
        meet_line(line([0, 0, 0], [1, 1, 1]), [0.0, 0.0], [1.0, 0.0])
