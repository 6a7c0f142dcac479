import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.curvature import curvature
from splinearm.curves.feature import (
    curvature_extrema,
    cusps,
    inflections,
    where_curvature_is,
)
from splinearm.curves.plane import Plane
from splinearm.errors import CurveError

KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]
CUSP = BSpline([-1, -1, -1, -1, 1, 1, 1, 1], [[1, -1], [-1 / 3, 1], [-1 / 3, -1], [1, 1]], 3)
ESS = BSpline(KNOTS, [[0, 0], [1, 1], [1, -1], [2, 0]], 3)
SPACE = Plane.facing([1.0, 2.0, 3.0], [1.0, -2.0, 0.5])


def lifted(curve):
    """A curve of the plane laid into space."""
    return BSpline(curve.knots, SPACE.points(curve.points), curve.degree, curve.weights)


@st.composite
def curves(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    dim, degree = draw(st.integers(2, 3)), draw(st.integers(3, 5))
    m = 12
    inner = np.linspace(0.0, 1.0, m - degree + 1)
    knots = np.concatenate((np.zeros(degree), inner, np.ones(degree)))
    points = np.cumsum(rng.normal(size=(m, dim)), axis=0)
    weights = rng.uniform(0.5, 2.0, m) if draw(st.booleans()) else None
    return BSpline(knots, points, degree, weights)


def changes(values):
    return np.flatnonzero(values[:-1] * values[1:] < 0.0)


def each_holds_one(u, cells, places, width=1):
    """Every cell of u in which a sign was seen to change holds a place."""
    cells = np.asarray(cells, dtype=int)
    at = np.searchsorted(places, u[cells] - 1e-12)
    ends = u[cells + width] + 1e-12
    return all(k < len(places) and places[k] <= end for k, end in zip(at, ends, strict=True))


def turning(k):
    """Where steps of k change their sign beyond rounding."""
    steps = np.diff(k)
    noise = 1e-10 * np.abs(k).max()
    return [i for i in changes(steps) if min(abs(steps[i]), abs(steps[i + 1])) > noise]


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(curves(), st.floats(0.1, 3.0))
def test_no_place_is_missed(curve, value):
    u = np.linspace(0.0, 1.0, 4001)
    k = curvature(curve, u)
    if curve.dim == 2:
        assert each_holds_one(u, changes(k), inflections(curve).u)
    extrema = curvature_extrema(curve).u
    assert each_holds_one(u, turning(k), extrema, 2)
    found = where_curvature_is(curve, value).u
    assert each_holds_one(u, changes(k - value), found)
    # and what is found is right
    assert np.allclose(curvature(curve, found), value, rtol=1e-7)
    if curve.dim == 2:
        scale = np.abs(k).max()
        assert np.abs(curvature(curve, inflections(curve).u)).max(initial=0.0) <= 1e-9 * scale
    inside = extrema[(extrema > 1e-3) & (extrema < 1.0 - 1e-3)]
    h = 1e-5
    around = [curvature(curve, inside + x) for x in (-h, 0.0, h)]
    peak = np.maximum(around[0], around[2]) - around[1]
    dip = np.minimum(around[0], around[2]) - around[1]
    slack = 1e-9 * (1.0 + np.abs(around[1]))
    assert ((peak <= slack) | (dip >= -slack)).all()


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(curves(), st.floats(0.01, 100.0))
def test_places_know_no_direction_and_no_unit(curve, scale):
    other = BSpline(
        5.0 - 3.0 * curve.knots[::-1],
        scale * (curve.points[::-1] + 4.0),
        curve.degree,
        None if curve.weights is None else curve.weights[::-1],
    )
    for find in (inflections, curvature_extrema, lambda c: where_curvature_is(c, 0.0)):
        there = find(other).u
        here = (5.0 - 3.0 * find(curve).u)[::-1]
        assert len(there) == len(here)
        assert np.allclose(there, here, rtol=0, atol=1e-5)


def test_an_ellipse_has_four_extrema_and_no_inflection():
    for curve in (conic.ellipse(3.0, 1.0), lifted(conic.ellipse(3.0, 1.0))):
        assert np.allclose(curvature_extrema(curve).u, [0.0, 0.25, 0.5, 0.75], atol=1e-12)
        assert len(inflections(curve).u) == len(cusps(curve).u) == 0
        found = where_curvature_is(curve, 1.0).u
        assert len(found) == 4
        assert np.allclose(curvature(curve, found), 1.0, rtol=1e-11)
        # the largest curvature is only touched, at both ends of the long axis
        assert np.allclose(where_curvature_is(curve, 3.0).u, [0.0, 0.5, 1.0], atol=1e-6)
        assert len(where_curvature_is(curve, 3.0001).u) == 0
    assert len(where_curvature_is(conic.ellipse(3.0, 1.0), -1.0).u) == 0


def test_a_parabola_turns_most_at_its_vertex():
    places = curvature_extrema(conic.parabola(0.5, -1.0, 3.0))
    assert np.allclose(places.u, 0.25, atol=1e-14)


def test_circles_have_the_same_curvature_everywhere():
    curve = conic.arc(2.0, 0.0, np.pi)
    quarters = [[0.0, 0.5], [0.5, 1.0]]
    for places in (curvature_extrema(curve), where_curvature_is(curve, 0.5)):
        assert len(places.u) == 0
        assert np.array_equal(places.stretches, quarters)
    assert np.array_equal(where_curvature_is(lifted(curve), 0.5).stretches, quarters)
    for value in (-0.5, 0.51):
        places = where_curvature_is(curve, value)
        assert len(places.u) == len(places.stretches) == 0


def test_an_ess_has_its_inflection_in_the_middle():
    assert np.allclose(inflections(ESS).u, 0.5, atol=1e-14)
    assert np.allclose(inflections(lifted(ESS)).u, 0.5, atol=1e-11)
    assert np.allclose(where_curvature_is(ESS, 0.0).u, 0.5, atol=1e-14)
    extrema = curvature_extrema(ESS).u
    assert len(extrema) == 2
    assert extrema.sum() == pytest.approx(1.0, abs=1e-12)


def test_an_undulation_is_no_inflection_but_has_no_curvature():
    # y = x^4 is level at 0 without turning to the other side
    points = [[-1, 1], [-0.5, -1], [0, 1], [0.5, -1], [1, 1]]
    curve = BSpline([-1] * 5 + [1] * 5, points, 4)
    assert np.allclose(curve.at(0.3), [0.3, 0.0081])
    assert len(inflections(curve).u) == 0
    assert np.allclose(where_curvature_is(curve, 0.0).u, 0.0, atol=1e-6)
    assert np.allclose(inflections(lifted(curve)).u, 0.0, atol=1e-6)


def test_straight_pieces_are_stretches():
    line = conic.line([0.0, 0.0], [1.0, 2.0])
    assert np.array_equal(inflections(line).stretches, [[0.0, 1.0]])
    assert np.array_equal(where_curvature_is(line, 0.0).stretches, [[0.0, 1.0]])
    assert len(where_curvature_is(line, 1.0).u) == 0


def test_a_cusp_is_found_and_has_no_curvature():
    for curve in (CUSP, lifted(CUSP)):
        assert np.allclose(cusps(curve).u, 0.0, atol=1e-12)
        assert len(inflections(curve).u) == 0
        assert len(curvature_extrema(curve).u) == 0
        # (u^2, u^3) has curvature 6 u^2 / (|u|^3 (4 + 9 u^2)^(3/2))
        found = where_curvature_is(curve, 0.5).u
        expected = 6.0 / (np.abs(found) * (4.0 + 9.0 * found**2) ** 1.5)
        assert np.allclose(expected, 0.5, rtol=1e-10)
        # in the plane it turns to the left on both sides
        assert len(found) == 2
    assert len(cusps(ESS).u) == 0


def test_a_piece_that_stands_still_is_a_stretch():
    points = np.repeat([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]], [1, 4, 2], axis=0)
    curve = BSpline([0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4], points, 3)
    assert np.array_equal(cusps(curve).stretches, [[1.0, 2.0]])
    with pytest.raises(CurveError, match="one point"):
        inflections(BSpline([0, 0, 1, 1], np.ones((2, 2)), 1))


def test_jumps_where_pieces_meet_count():
    # two parabolas, C1, that turn to different sides
    wave = BSpline([0, 0, 0, 1, 2, 2, 2], [[0, 0], [1, 1], [2, -1], [3, 0]], 2)
    assert np.allclose(inflections(wave).u, 1.0, atol=0)
    assert np.allclose(where_curvature_is(wave, 0.0).u, 1.0, atol=0)
    before, behind = curvature(wave, 1.0 - 1e-9), curvature(wave, 1.0 + 1e-9)
    between = 0.3 * before + 0.7 * behind
    assert 1.0 in where_curvature_is(wave, float(between)).u
    # the curvature rises before, in and behind the jump
    assert np.allclose(curvature_extrema(wave).u, [10 / 17, 24 / 17])
    # here it falls, jumps up and falls again
    hook = BSpline([0, 0, 0, 1, 2, 2, 2], [[0, 0], [0.1, 0], [1, 1], [0.5, 3]], 2)
    k = curvature(hook, [0.9, 1.0 - 1e-9, 1.0, 1.1])
    assert k[0] > k[1] < k[2] > k[3]
    assert 1.0 in curvature_extrema(hook).u


def test_places_of_a_closed_curve_do_not_depend_on_where_it_begins():
    # a ring whose curvature has kinks at its knots
    ring = np.array([[2.0, 0.0], [1.0, 1.0], [0.0, 2.0], [-1.0, 0.5], [-2.0, -1.0], [0.5, -0.2]])
    for degree in (2, 3):
        wanted = None
        for first in range(6):
            curve = BSpline.closed(np.arange(7.0), np.roll(ring, -first, axis=0), degree)
            found = [
                np.unique((find(curve).u + first) % 6.0)
                for find in (inflections, curvature_extrema, lambda c: where_curvature_is(c, 0.5))
            ]
            wanted = wanted or found
            for here, there in zip(found, wanted, strict=True):
                assert len(here) == len(there)
                assert np.allclose(here, there, atol=1e-9)


@pytest.mark.parametrize(
    ("ask", "why"),
    [
        (lambda: inflections(conic.line([0.0], [1.0])), "2 or 3 coordinates, got 1 and 1"),
        (lambda: cusps(BSpline([0, 1], [[0.0]], 0)), "degree 1 or more"),
        (lambda: where_curvature_is(ESS, float("nan")), "got nan"),
        (lambda: where_curvature_is(lifted(ESS), -1.0), r"got -1\.0"),
    ],
)
def test_what_cannot_be_asked_is_refused(ask, why):
    with pytest.raises(ValueError, match=why):
        ask()


@pytest.mark.slow
def test_many_curves_have_all_their_places():
    for seed in range(100):
        rng = np.random.default_rng(seed)
        m, degree = 20, 2 + seed % 4
        inner = np.linspace(0.0, 1.0, m - degree + 1)
        knots = np.concatenate((np.zeros(degree), inner, np.ones(degree)))
        weights = rng.uniform(0.3, 3.0, m) if seed % 2 else None
        curve = BSpline(knots, np.cumsum(rng.normal(size=(m, 2)), axis=0), degree, weights)
        u = np.linspace(0.0, 1.0, 40_001)
        k = curvature(curve, u)
        assert each_holds_one(u, changes(k), inflections(curve).u)
        assert each_holds_one(u, turning(k), curvature_extrema(curve).u, 2)
        for value in (-1.0, 0.2, 2.0):
            assert each_holds_one(u, changes(k - value), where_curvature_is(curve, value).u)
