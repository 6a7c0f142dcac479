import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.removal import reduce_degree, remove_knots
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)


def distance(curve, other, u):
    return np.linalg.norm(other.at(u) - curve.at(u), axis=1).max()


def changed_or_none(change, *arguments):
    """What a change gives, or nothing where small rings and weights forbid it."""
    try:
        return change(*arguments)
    except CurveError as refused:
        if "none to spare" in refused.what or "weight" in refused.what:
            return None, 0.0
        raise


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_knots_that_were_put_in_come_out_again(random_curve, places, seed):
    curve = random_curve(seed, form="clamped")
    us = np.random.default_rng(seed).uniform(*curve.domain, 4)
    again, error = remove_knots(curve.with_knots(us), us, 1e-9)
    assert np.array_equal(again.knots, curve.knots)
    assert error < 1e-12
    assert distance(curve, again, places(curve)) < 1e-12


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_no_curve_moves_farther_than_its_bound(random_curve, places, seed):
    curve = random_curve(seed)
    inner = curve.breaks[1:-1]
    if not inner.size:
        return
    u = np.random.default_rng(seed).choice(inner)
    other, error = changed_or_none(remove_knots, curve, [u], 1e9)
    if other is None:
        return
    assert len(other.points) == len(curve.points) - 1
    assert other.is_periodic == curve.is_periodic
    moved = distance(curve, other, places(curve, 20))
    assert moved <= error + 1e-12
    if not curve.is_rational:
        # a bound from control points is not far above what happens
        assert error <= 100.0 * moved + 1e-12


def test_the_least_change_of_control_points_is_made():
    # without its knot the parabola pair is one parabola: every old point then misses by the same
    curve = BSpline([0, 0, 0, 1, 2, 2, 2], [[0.0], [0.0], [1.0], [0.0]], 2)
    parabola, error = remove_knots(curve, [1.0], 10.0)
    misses = np.abs(parabola.with_knots([1.0]).points - curve.points).ravel()
    assert misses[1:3] == pytest.approx([error, error], rel=1e-14)
    assert misses[[0, 3]].tolist() == [0.0, 0.0]


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_a_ring_stays_one_without_a_knot(random_curve, places, seed):
    ring = random_curve(seed, form="ring")
    us = np.random.default_rng(seed).uniform(*ring.domain, 20)
    finer = ring.with_knots(us)
    if np.count_nonzero(ring.knots == ring.domain[1]) < ring.degree:
        finer = finer.with_knots([ring.domain[1]])
        us = np.append(us[:6], ring.domain[0])
    back, error = remove_knots(finer, us[-4:], 1e-8)
    assert back.is_periodic
    assert len(back.points) == len(finer.points) - 4
    assert error < 1e-11
    assert distance(ring, back, places(ring)) < 1e-11


def test_what_cannot_be_removed_is_refused(circle):
    curve = BSpline([0, 0, 0, 1, 2, 2, 2], [[0.0], [0.0], [1.0], [0.0]], 2)
    with pytest.raises(CurveError, match=r"would move by up to 0\.5, allowed 0\.01"):
        remove_knots(curve, [1.0], 0.01)
    for u in (0.0, 2.0, 0.5, 3.0):
        with pytest.raises(CurveError, match="no such knot inside the curve"):
            remove_knots(curve, [u], 1.0)
    with pytest.raises(CurveError, match="no such knot"):
        remove_knots(curve, [1.0, 1.0], 10.0)
    torn = BSpline([0, 0, 1, 1, 2, 2], [[0.0], [1.0], [3.0], [0.0]], 1)
    with pytest.raises(CurveError, match="jumps there: split it"):
        remove_knots(torn, [1.0], 10.0)
    with pytest.raises(ValueError, match="tolerance: want 0 or more"):
        remove_knots(curve, [1.0], float("nan"))
    with pytest.raises(CurveError, match="would move"):
        remove_knots(circle, [1.0, 1.0], 1e-6)
    square = BSpline.closed([0.0, 1.0, 2.0, 3.0, 4.0], np.eye(4)[:, :2], 1)
    with pytest.raises(CurveError, match="the seam of a ring needs a knot"):
        remove_knots(square, [0.0], 1.0)
    with pytest.raises(CurveError, match="none to spare"):
        remove_knots(BSpline.closed(np.arange(5.0), np.eye(4)[:, :2], 3), [1.0], 1.0)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_an_elevated_curve_is_reduced_exactly(random_curve, places, seed):
    curve = random_curve(seed)
    lower, error = reduce_degree(curve.elevated(), 1e-8)
    assert lower.degree == curve.degree
    assert len(lower.points) == len(curve.clamped().points)
    assert error < 1e-11
    assert distance(curve, lower, places(curve)) < 1e-11


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_a_reduced_curve_keeps_its_bound_and_its_ends(random_curve, places, seed):
    curve = random_curve(seed)
    if curve.degree < 2:
        return
    lower, error = changed_or_none(reduce_degree, curve, 1e9)
    if lower is None:
        assert curve.is_rational
        return
    assert lower.degree == curve.degree - 1
    assert distance(curve, lower, places(curve, 20)) <= error + 1e-12
    ends = np.array(curve.domain)
    np.testing.assert_allclose(lower.at(ends), curve.at(ends), rtol=0, atol=1e-12)
    with pytest.raises(CurveError, match="degree reduction: the curve would move by up to"):
        reduce_degree(BSpline([0] * 4 + [1] * 4, [[0.0], [0.0], [0.0], [1.0]], 3), 0.01)


def test_what_has_no_lower_degree_is_refused():
    line = BSpline([0, 0, 1, 1], [[0.0], [1.0]], 1)
    with pytest.raises(ValueError, match="degree: want at least 2"):
        reduce_degree(line, 1.0)
    torn = BSpline([0, 0, 0, 1, 1, 1, 2, 2, 2], np.arange(6.0)[:, None], 2)
    with pytest.raises(CurveError, match="split it first"):
        reduce_degree(torn, 1.0)
    with pytest.raises(ValueError, match="tolerance"):
        reduce_degree(torn, -1.0)
