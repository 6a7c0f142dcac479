import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.plane import Plane
from splinearm.errors import CurveError

U = np.linspace(0.0, 1.0, 2001)
TILTED = Plane.facing([1.0, -2.0, 0.5], [1.0, 2.0, 3.0])


def coordinates(curve, plane, u=U):
    """What a plane's own x and y say, and how far the curve is off the plane."""
    away = curve.at(u) - plane.origin
    x, y = away @ plane.x, away @ plane.y
    return x, y, np.abs(away - np.outer(x, plane.x) - np.outer(y, plane.y)).max()


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.floats(1e-6, 1e6))
def test_a_circle_has_its_radius_everywhere(radius):
    curve = conic.circle(radius)
    assert np.abs(np.linalg.norm(curve.at(U), axis=1) / radius - 1.0).max() <= 1e-15
    assert curve.is_closed(1)
    assert curve.weights.min() == pytest.approx(np.sqrt(0.5))


def test_a_circle_is_the_nine_point_square_of_the_nurbs_book():
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, sec. 7.5
    curve = conic.circle(1.0)
    square = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]]
    assert np.allclose(curve.points, square, atol=1e-15)
    assert np.array_equal(curve.knots * 4.0, [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4])
    assert np.allclose(curve.weights, [1, *[np.sqrt(0.5), 1] * 4], atol=1e-15)


def test_a_circle_in_space_lies_in_its_plane():
    x, y, off = coordinates(conic.circle(2.0, TILTED), TILTED)
    assert np.abs(np.hypot(x, y) / 2.0 - 1.0).max() < 1e-15
    assert off < 2e-15
    # from x towards y
    assert y[1] > 0.0
    normal = np.cross(TILTED.x, TILTED.y)
    assert np.allclose(normal, np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0), atol=1e-15)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(st.floats(-7.0, 7.0), st.floats(-6.28, 6.28), st.floats(0.1, 3.0))
def test_an_arc_starts_and_ends_at_its_angles(start, sweep, radius):
    if abs(sweep) < 1e-3:
        return
    curve = conic.arc(radius, start, start + sweep)
    x, y = curve.at(U).T
    assert np.abs(np.hypot(x, y) / radius - 1.0).max() < 1e-15
    angles = np.unwrap(np.arctan2(y, x))
    assert np.allclose(angles - angles[0], (angles[-1] - angles[0]) * U, atol=0.04)
    assert angles[-1] - angles[0] == pytest.approx(sweep, abs=1e-14)
    assert (np.diff(angles) * np.sign(sweep) > 0.0).all()
    # pieces of a quarter turn at most
    assert len(curve.breaks) - 1 == np.ceil(abs(sweep) / (np.pi / 2) - 1e-9)


@st.composite
def three_points(draw):
    dim = draw(st.integers(2, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return rng.normal(size=(3, dim)) * 10.0 ** draw(st.integers(-6, 6))


@pytest.mark.property
@settings(max_examples=80, deadline=None)
@given(three_points())
def test_an_arc_goes_through_its_three_points_in_order(points):
    p0, p1, p2 = points
    curve = conic.arc_through(p0, p1, p2)
    assert np.array_equal(curve.at(0.0), p0)
    assert np.array_equal(curve.at(1.0), p2)
    # three places of the curve have the circle's centre; the middle point is as far from it
    q = curve.at(U)
    size = np.abs(q - p0).max()
    gaps = np.linalg.norm(q - p1, axis=1)
    nearest = int(np.argmin(gaps))
    step = np.linalg.norm(np.diff(q, axis=0), axis=1).max()
    assert gaps[nearest] <= step
    assert 0 < nearest < len(U) - 1
    # and it is bent evenly: a circle
    first, second = (curve.at(np.array([0.25, 0.75]), 1), curve.at(np.array([0.25, 0.75]), 2))
    bends = [
        np.sqrt((v @ v) * (w @ w) - (v @ w) ** 2) / (v @ v) ** 1.5
        for v, w in zip(first, second, strict=True)
    ]
    assert bends[0] == pytest.approx(bends[1], rel=1e-6)
    assert bends[0] > 1e-3 / size


def test_three_points_on_a_known_circle_give_it():
    curve = conic.arc_through([1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [0.0, -1.0, 5.0])
    q = curve.at(U)
    assert np.abs(np.hypot(q[:, 0], q[:, 1]) - 1.0).max() < 1e-15
    assert np.abs(q[:, 2] - 5.0).max() < 4e-15
    # three quarters of a turn, through (0, 1)
    assert curve.length() == pytest.approx(1.5 * np.pi, rel=1e-14)


@pytest.mark.parametrize(
    ("points", "why"),
    [
        ([[0, 0], [1, 1], [2, 2]], "lie on a line"),
        ([[0, 0], [1, 0], [2, 1e-13]], "lie on a line"),
        ([[0, 0], [0, 0], [2, 1]], "the same"),
        ([[0, 0], [1, 1], [0, 0]], "the same"),
    ],
)
def test_three_points_without_a_circle_are_refused(points, why):
    with pytest.raises(CurveError, match=why):
        conic.arc_through(*points)


def test_an_ellipse_fulfils_its_equation():
    x, y, off = coordinates(conic.ellipse(3.0, 0.5, TILTED), TILTED)
    assert np.abs((x / 3.0) ** 2 + (y / 0.5) ** 2 - 1.0).max() < 5e-15
    assert off < 3e-15
    x, y = conic.elliptic_arc((3.0, 0.5), 0.3, -2.0).at(np.array([0.0, 1.0])).T
    assert np.allclose([x, y], [3.0 * np.cos([0.3, -2.0]), 0.5 * np.sin([0.3, -2.0])], atol=1e-15)


def test_a_parabola_is_as_far_from_its_focus_as_from_its_directrix():
    x, y, off = coordinates(conic.parabola(0.7, -2.0, 1.5, TILTED), TILTED)
    assert np.allclose(np.hypot(x - 0.7, y), x + 0.7, rtol=1e-14)
    assert off < 2e-15
    assert conic.parabola(0.7, -2.0, 1.5).weights is None


@pytest.mark.parametrize(("start", "end"), [(-0.3, 0.2), (0.0, 5.0), (3.0, -3.0)])
def test_points_of_a_hyperbola_differ_by_2a_in_their_ways_to_the_foci(start, end):
    curve = conic.hyperbola((2.0, 1.0), start, end)
    x, y = curve.at(U).T
    focus = np.sqrt(5.0)
    ways = np.hypot(x + focus, y), np.hypot(x - focus, y)
    assert np.allclose(ways[0] - ways[1], 4.0, rtol=0, atol=3e-16 * ways[0].max() + 1e-15)
    ends = 2.0 * np.cosh([start, end]), np.sinh([start, end])
    assert np.allclose(curve.at(np.array([0.0, 1.0])).T, ends, rtol=1e-15, atol=1e-15)


def test_a_line_is_straight():
    curve = conic.line([0.0, 1.0, 2.0], [3.0, 1.0, -2.0])
    assert curve.length() == pytest.approx(5.0)
    assert np.array_equal(curve.at(0.5), [1.5, 1.0, 0.0])


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.floats(0.05, 0.9), st.floats(0.05, 0.9))
def test_a_conic_piece_goes_through_its_point(share, depth):
    p0, p1, p2 = np.array([[0.0, 0.0, 1.0], [1.0, 2.0, 0.0], [3.0, 0.0, -1.0]])
    point = (1.0 - depth) * (p0 + share * (p2 - p0)) + depth * p1
    curve = conic.conic_piece(p0, p1, p2, point)
    # Bernstein shares of the triangle at t: t from those of the ends
    t0, t2 = (1.0 - depth) * (1.0 - share), (1.0 - depth) * share
    t = np.sqrt(t2) / (np.sqrt(t0) + np.sqrt(t2))
    assert np.allclose(curve.at(t), point, atol=1e-14)
    assert np.linalg.norm(np.cross(curve.at(0.0, 1), p1 - p0)) < 1e-12
    assert np.linalg.norm(np.cross(curve.at(1.0, 1), p2 - p1)) < 1e-12


def test_a_quarter_circle_is_the_conic_through_its_middle():
    curve = conic.conic_piece([1, 0], [1, 1], [0, 1], np.sqrt([0.5, 0.5]))
    assert curve.weights[1] == pytest.approx(np.sqrt(0.5), rel=1e-14)


@pytest.mark.parametrize(
    ("make", "error", "why"),
    [
        (lambda: conic.circle(0.0), ValueError, "radius|a: want"),
        (lambda: conic.circle(float("nan")), ValueError, "above 0"),
        (lambda: conic.arc(1.0, 0.5, 0.5), ValueError, "more than 0"),
        (lambda: conic.arc(1.0, 0.0, 7.0), ValueError, "up to one turn"),
        (lambda: conic.ellipse(1.0, -1.0), ValueError, "b: want it above 0"),
        (lambda: conic.parabola(1.0, 2.0, 2.0), ValueError, "some length"),
        (lambda: conic.parabola(-1.0, 0.0, 2.0), ValueError, "focal"),
        (lambda: conic.hyperbola((1.0, 1.0), 0.0, float("inf")), ValueError, "to inf"),
        (lambda: conic.line([1.0], [1.0]), CurveError, "same point"),
        (lambda: conic.line([1.0], [1.0, 2.0]), ValueError, "end: want shape"),
        (lambda: conic.arc_through([1.0], [2.0], [3.0]), ValueError, "start: want at"),
        (lambda: conic.conic_piece([0, 0], [1, 1], [2, 2], [1, 0]), CurveError, "on a line"),
        (lambda: conic.conic_piece([0, 0], [1, 1], [2, 0], [1, 2]), CurveError, "not inside"),
        (lambda: Plane([0.0], [1.0], [1.0]), ValueError, "two coordinates"),
        (lambda: Plane([0, 0], [1, 0], [1, 1]), ValueError, "right angle"),
        (lambda: Plane([0, 0], [0, 0], [0, 1]), ValueError, "x: want a direction"),
        (lambda: Plane.facing([0, 0, 0], [0, 0, 1], [0, 0, 2]), ValueError, "across the normal"),
    ],
)
def test_what_is_no_conic_is_refused(make, error, why):
    with pytest.raises(error, match=why):
        make()
