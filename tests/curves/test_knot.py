"""Changes that change nothing: knots, degree, ends."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import basis, knot
from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)
SAME = 1e-13  # rounding where knots are very uneven; the benchmark shows 4e-16 where they are not


def check_same(curve, other, u):
    assert curve.domain == other.domain
    assert curve.is_rational == other.is_rational
    np.testing.assert_allclose(other.at(u), curve.at(u), rtol=0, atol=SAME)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_insertion_elevation_and_forms_change_nothing(random_curve, places, seed):
    curve = random_curve(seed)
    u = places(curve)
    us = np.random.default_rng(seed).uniform(*curve.domain, 4)
    for other in (curve.with_knots(us), curve.elevated(), curve.clamped(), curve.elevated(2)):
        check_same(curve, other, u)
    assert len(curve.with_knots(us).points) == len(curve.points) + 4
    assert curve.elevated().degree == curve.degree + 1
    clamped = curve.clamped()
    p = curve.degree
    assert (clamped.knots[: p + 1] == curve.domain[0]).all()
    assert (clamped.knots[-p - 1 :] == curve.domain[1]).all()


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_a_ring_stays_a_ring(random_curve, places, seed):
    ring = random_curve(seed, form="ring")
    u = places(ring)
    us = np.random.default_rng(seed).uniform(*ring.domain, 3)
    seam = np.count_nonzero(ring.knots == ring.domain[1])
    changed = [ring.with_knots(us), ring.elevated(), ring.over(*ring.domain)]
    if seam < ring.degree:
        changed += [ring.with_knots([ring.domain[0]]), ring.with_knots([ring.domain[1]])]
    for other in changed:
        assert other.is_periodic
        check_same(ring, other, u)
    again = ring.clamped().periodic(1e-10)
    assert again.is_periodic
    # a seam that happens to be smoother than its knots say is closed to the tolerance
    np.testing.assert_allclose(again.at(u), ring.at(u), rtol=0, atol=1e-9)
    assert ring.reversed().is_periodic
    assert not ring.clamped().is_periodic


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_bezier_pieces_share_their_ends(random_curve, seed):
    curve = random_curve(seed)
    ends, pieces = curve.bezier()
    assert np.array_equal(ends, curve.breaks)
    assert pieces.shape == (len(ends) - 1, curve.degree + 1, curve.dim + curve.is_rational)
    assert np.array_equal(pieces[1:, 0], pieces[:-1, -1])
    rows = curve.homogeneous if curve.is_rational else curve.points
    middles = 0.5 * (ends[:-1] + ends[1:])
    wanted = basis.evaluate(curve.knots, rows, curve.degree, middles)
    while pieces.shape[1] > 1:
        pieces = 0.5 * (pieces[:, :-1] + pieces[:, 1:])
    # the middle of a narrow piece is known to rounding of its parameter
    np.testing.assert_allclose(pieces[:, 0], wanted, rtol=0, atol=1e-12)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(SEEDS, st.floats(0.05, 0.45), st.floats(0.55, 0.95))
def test_parts_are_the_curve(random_curve, seed, low, high):
    curve = random_curve(seed)
    start, end = curve.domain
    low, high = start + low * (end - start), start + high * (end - start)
    part = curve.part(low, high)
    assert part.domain == (low, high)
    u = np.linspace(low, high, 20)
    np.testing.assert_allclose(part.at(u), curve.at(u), rtol=0, atol=SAME)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_reversing_and_another_domain(random_curve, seed):
    curve = random_curve(seed, form="clamped")
    u = np.linspace(0.0, 1.0, 33)
    plain = curve.over(0.0, 1.0)
    start, end = curve.domain
    at = np.minimum(start + u * (end - start), end)
    np.testing.assert_allclose(plain.at(u), curve.at(at), rtol=0, atol=1e-12)
    np.testing.assert_allclose(plain.reversed().at(1.0 - u), plain.at(u), rtol=0, atol=1e-12)
    assert np.array_equal(curve.reversed().at(start), curve.at(end))
    back = curve.reversed().reversed()
    np.testing.assert_allclose(back.knots, curve.knots, rtol=1e-15, atol=1e-15)
    assert curve.over(-2.0, 5.5).domain == (-2.0, 5.5)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_maps_of_control_points_map_the_curve(random_curve, places, seed):
    curve = random_curve(seed)
    rng = np.random.default_rng(seed)
    T = np.eye(3)
    T[:2] += rng.normal(size=(2, 3))
    u = places(curve)
    wanted = curve.at(u) @ T[:2, :2].T + T[:2, 2]
    for matrix in (T, 2.0 * T):
        moved = curve.mapped(matrix)
        assert moved.is_rational == curve.is_rational
        np.testing.assert_allclose(moved.at(u), wanted, rtol=0, atol=1e-13)
    T[2, :2] = rng.uniform(-0.2, 0.2, 2)
    far = np.column_stack((curve.at(u), np.ones(len(u)))) @ T.T
    for matrix in (T, -T):
        np.testing.assert_allclose(
            curve.mapped(matrix).at(u), far[:, :2] / far[:, 2:], rtol=0, atol=1e-12
        )
    assert curve.mapped(T).is_rational


def test_what_cannot_be_mapped_is_refused(circle):
    with pytest.raises(CurveError, match="infinity"):
        circle.mapped([[1, 0, 0], [0, 1, 0], [1, 0, 0.5]])
    with pytest.raises(ValueError, match="matrix"):
        circle.mapped(np.eye(4))


def test_ends_that_do_not_meet_make_no_ring(circle):
    with pytest.raises(CurveError, match="not closed: its ends are"):
        circle.part(0.0, 3.0).periodic()
    ring = circle.periodic()
    assert len(ring.points) == 8 + 2
    assert np.abs(np.linalg.norm(ring.at(np.linspace(0, 4, 99)), axis=1) - 1.0).max() < 1e-15


def test_an_unclamped_form_is_the_curve(places):
    curve = BSpline([0, 0, 0, 0, 1, 3, 4, 4, 4, 4], np.eye(6)[:, :3], 3)
    free = curve.unclamped()
    assert free.knots.tolist() == [-4.0, -3.0, -1.0, 0.0, 1.0, 3.0, 4.0, 5.0, 7.0, 8.0]
    np.testing.assert_allclose(free.at(places(curve)), curve.at(places(curve)), rtol=0, atol=1e-14)
    assert not free.is_periodic


def test_an_unclamped_form_with_a_negative_weight_is_refused():
    curve = BSpline([0, 0, 0, 1, 1, 1], [[0.0], [1.0], [2.0]], 2, [1.0, 5.0, 1.0])
    with pytest.raises(CurveError, match="a weight would become -3, not above 0"):
        curve.unclamped()


@pytest.mark.parametrize("us", [[0.0], [1.0, 1.0], [2.0]])
def test_no_knot_is_there_more_often_than_the_degree(us):
    curve = BSpline([0, 0, 0, 1, 2, 2, 2], [[0.0], [1.0], [2.0], [0.0]], 2)
    with pytest.raises(ValueError, match="more than 2 times"):
        curve.with_knots(us)
    with pytest.raises(ValueError, match="times: want 0 or more"):
        curve.elevated(-1)
    with pytest.raises(ValueError, match="start below end"):
        curve.over(1.0, 1.0)


def exact_basis(knots, i, degree, u):
    """The Cox-de Boor recurrence in fractions, 0 / 0 taken as 0."""
    if degree == 0:
        return Fraction(int(knots[i] <= u < knots[i + 1]))
    total = Fraction(0)
    if knots[i + degree] > knots[i]:
        share = (u - knots[i]) / (knots[i + degree] - knots[i])
        total += share * exact_basis(knots, i, degree - 1, u)
    if knots[i + degree + 1] > knots[i + 1]:
        share = (knots[i + degree + 1] - u) / (knots[i + degree + 1] - knots[i + 1])
        total += share * exact_basis(knots, i + 1, degree - 1, u)
    return total


def test_basis_values_of_the_nurbs_book():
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, ex. 2.3: at u = 5/2 the functions N2,2 ...
    # N4,2 are 1/8, 6/8 and 1/8; ex. 2.4: their derivatives -1/2, 0, 1/2
    knots = np.array([0, 0, 0, 1, 2, 3, 4, 4, 5, 5, 5], dtype=float)
    u = np.array([2.5])
    spans = basis.find_spans(knots, 2, u)
    assert spans.tolist() == [4]
    assert basis.basis_values(knots, 2, spans, u).tolist() == [[0.125, 0.75, 0.125]]
    assert basis.basis_values(knots, 2, spans, u, 1).tolist() == [[-0.5, 0.0, 0.5]]
    for degree in range(1, 5):
        whole = [0] * degree + [0, 1, 2, 3, 4, 4, 5] + [5] * degree
        own = np.array(whole, dtype=float)
        for x in (Fraction(1, 3), Fraction(5, 2), Fraction(17, 4)):
            at = np.array([float(x)])
            span = int(basis.find_spans(own, degree, at)[0])
            exact = [exact_basis(whole, span - degree + j, degree, x) for j in range(degree + 1)]
            values = basis.basis_values(own, degree, np.array([span]), at)[0]
            np.testing.assert_allclose(values, [float(v) for v in exact], rtol=1e-14, atol=0)


def test_insertion_factors_of_the_nurbs_book():
    # Piegl and Tiller, ex. 5.1: u = 5/2 into a cubic mixes with 5/6, 1/2 and 1/6
    knots = np.array([0, 0, 0, 0, 1, 2, 3, 4, 5, 5, 5, 5], dtype=float)
    points = np.eye(8)
    _, rows = knot.refine(knots, points, 3, np.array([2.5]))
    wanted = np.zeros((9, 8))
    wanted[:3, :3] = np.eye(3)
    for i, share in ((3, 5 / 6), (4, 1 / 2), (5, 1 / 6)):
        wanted[i, i], wanted[i, i - 1] = share, 1.0 - share
    wanted[6:, 5:] = np.eye(3)
    np.testing.assert_allclose(rows, wanted, rtol=0, atol=1e-16)
    # ex. 5.2: u = 2, already a knot: 2/3 and 1/3
    _, rows = knot.refine(knots, points, 3, np.array([2.0]))
    assert rows[3, 2:4] == pytest.approx([1 / 3, 2 / 3], abs=2e-16)
    assert rows[4, 3:5] == pytest.approx([2 / 3, 1 / 3], abs=2e-16)
    assert rows[5].tolist() == points[4].tolist()


def test_elevation_of_a_parabola_is_exact_arithmetic():
    parabola = BSpline([0, 0, 0, 1, 1, 1], [[0.0], [1.0], [4.0]], 2)
    cubic = parabola.elevated()
    assert cubic.points[:, 0] == pytest.approx([0.0, 2 / 3, 2.0, 4.0], abs=1e-15)
    assert BSpline([0, 1, 2], [[3.0], [4.0]], 0).elevated().at([0.5, 1.5]).ravel().tolist() == [
        3,
        4,
    ]


def test_steps_are_cut_where_they_stand():
    steps = BSpline([0, 1, 2, 4], [[3.0], [4.0], [5.0]], 0)
    part = steps.part(0.5, 3.0)
    assert part.knots.tolist() == [0.5, 1.0, 2.0, 3.0]
    assert part.points.ravel().tolist() == [3.0, 4.0, 5.0]
    assert steps.bezier()[1].ravel().tolist() == [3.0, 4.0, 5.0]
    assert not steps.is_periodic


def test_maps_of_marsh():
    # Marsh, Applied Geometry for Computer Graphics and CAD, 2nd ed. 2005, ch. 1: the images of a
    # quadrilateral
    file = Path(__file__).parents[1] / "data" / "marsh_examples.json"
    book = json.loads(file.read_text(encoding="utf-8"))
    images = {case["id"]: case.get("images") for case in book["cases"]}
    corners = [book["quadrilateral"][name] for name in "ABCD"]
    polygon = BSpline([0, 0, 1, 2, 3, 3], corners, 1)
    for name, matrix in (
        ("1.8", [[1, 0, 2], [0, 1, 1], [0, 0, 1]]),
        ("1.11", [[2, 0, 0], [0, 0.5, 0], [0, 0, 1]]),
        ("1.14", [[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    ):
        assert polygon.mapped(matrix).at(np.arange(4.0)).tolist() == images[name]
    # example 2.1: homogeneous points, those of positive weight
    rows = [[1, 2, 3], [2, 4, 6], [6, 4, 2]]
    found = BSpline.from_homogeneous([0, 0, 1, 2, 2], rows, 1).points
    assert found.tolist() == [[1 / 3, 2 / 3], [1 / 3, 2 / 3], [3.0, 2.0]]


@pytest.mark.slow
def test_a_thousand_random_curves_do_not_drift(random_curve, places):
    worst = np.zeros(4)
    for seed in range(1000):
        curve = random_curve(seed)
        u = places(curve)
        us = np.random.default_rng(seed).uniform(*curve.domain, 9)
        changed = (curve.with_knots(us), curve.elevated(), curve.clamped(), curve.elevated(3))
        wanted = curve.at(u)
        worst = np.maximum(worst, [np.abs(other.at(u) - wanted).max() for other in changed])
    assert (worst < 1e-14).all(), worst
