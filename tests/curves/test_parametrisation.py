import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import basis, interpolate
from splinearm.curves.interpolation import choose_parameters
from splinearm.errors import CurveError

KINDS = ["chord", "centripetal", "uniform", "universal", "foley", "nielson"]


def some_points(seed, dim=2):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(int(rng.integers(3, 20)), dim))


@pytest.mark.property
@pytest.mark.kernel
@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS), st.booleans())
def test_parameters_rise_from_zero_and_lead_through_the_points(seed, kind, closed):
    points = some_points(seed)
    u = choose_parameters(points, kind, closed=closed)
    assert len(u) == len(points) + closed
    assert u[0] == 0.0
    assert (np.diff(u) > 0.0).all()
    curve = interpolate(points, parameters=kind, ends="closed" if closed else "natural")
    assert np.allclose(curve.at(u[: len(points)]), points, atol=1e-9)


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.integers(1, 3))
def test_nielson_parameters_are_those_of_any_affine_image(seed, closed, dim):
    points = some_points(seed, dim)
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(dim, dim)))
    image = points @ (turn * rng.uniform(0.1, 10.0, dim)) + rng.normal(size=dim)
    u, v = (choose_parameters(p, "nielson", closed=closed) for p in (points, image))
    assert np.allclose(u, v, rtol=1e-9)


def test_nielson_parameters_of_flat_points_in_space_are_those_in_their_plane():
    points = some_points(5)
    raised = np.column_stack((points, points @ [0.3, -0.2]))
    assert np.allclose(
        choose_parameters(raised, "nielson"), choose_parameters(points, "nielson"), rtol=1e-9
    )


def test_foley_parameters_are_chords_where_points_lie_on_a_line():
    points = np.outer([0.0, 1.0, 1.5, 4.0], [1.0, 2.0])
    assert np.allclose(choose_parameters(points, "foley"), choose_parameters(points, "chord"))


def test_foley_parameters_give_a_right_angle_its_share():
    # a right angle between steps of 1: each of them is longer by 1.5 * pi / 2 * 1 / 2
    u = choose_parameters([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], "foley")
    assert np.allclose(np.diff(u), 1.0 + 0.375 * np.pi)
    # a sharper turn counts no more
    sharp = choose_parameters([[0.0, 0.0], [1.0, 0.0], [0.0, 1e-9]], "foley")
    assert np.allclose(np.diff(sharp), 1.0 + 0.375 * np.pi)


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_universal_parameters_are_where_basis_functions_are_largest(degree):
    count = 9
    u = choose_parameters(
        np.random.default_rng(0).normal(size=(count, 2)), "universal", degree=degree
    )
    spans = count - degree
    knots = np.concatenate((np.zeros(degree), np.arange(spans + 1.0), np.full(degree, spans)))
    for i in range(count):
        peak = basis.evaluate(knots, np.eye(count)[:, [i]], degree, u[[i]])[0, 0]
        at = np.linspace(0.0, spans, 2001)
        assert peak >= basis.evaluate(knots, np.eye(count)[:, [i]], degree, at).max() - 1e-12


def test_equal_neighbours_and_unknown_kinds_are_refused():
    for kind in ("foley", "nielson", "chord"):
        with pytest.raises(CurveError, match="points 1 and 2 are the same"):
            choose_parameters([[0.0], [1.0], [1.0]], kind)
    with pytest.raises(ValueError, match="foley"):
        choose_parameters([[0.0], [1.0]], "chordal")
