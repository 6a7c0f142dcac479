import pickle

import numpy as np
import pytest
import scipy.interpolate
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError

pytestmark = pytest.mark.kernel
SEEDS = st.integers(0, 2**32 - 1)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(0, 4))
def test_samples_are_the_curve_and_its_derivatives(random_curve, places, seed, order):
    curve = random_curve(seed)
    u = places(curve, 4)
    wanted = curve.jet(u, order)
    sampler = curve.sampler()
    np.random.default_rng(seed).shuffle(order_of := np.arange(len(u)))
    for some in (np.arange(len(u)), order_of):
        found = sampler.sample(u[some], order)
        assert found.shape == (len(u), order + 1, curve.dim)
        for k in range(order + 1):
            scale = max(1.0, np.abs(wanted[:, k]).max())
            # a parameter on a narrow piece is known to rounding of the parameter
            off = np.abs(found[:, k] - wanted[some, k]).max()
            assert off <= 1e-10 * scale if k else off <= 1e-12
    out = np.empty((order + 1, curve.dim))
    for i in range(0, len(u), 3):
        sampler.into(u[i], out)
        assert np.array_equal(out, sampler.sample(u[i], order))


@pytest.mark.parametrize("degree", [3, 5])
def test_samples_are_those_of_scipy(degree):
    rng = np.random.default_rng(degree)
    inner = np.sort(rng.uniform(0.05, 0.95, 30))
    knots = np.concatenate((np.zeros(degree + 1), inner, np.ones(degree + 1)))
    curve = BSpline(knots, rng.uniform(-1.0, 1.0, (len(inner) + degree + 1, 7)), degree)
    peer = scipy.interpolate.BSpline(knots, curve.points, degree)
    u = np.sort(rng.uniform(0.0, 1.0, 300))
    found = curve.sampler().sample(u)
    for order in range(3):
        theirs = peer(u, nu=order)
        np.testing.assert_allclose(
            found[:, order], theirs, rtol=0, atol=1e-14 * np.abs(theirs).max()
        )


def test_a_circle_is_sampled_round(circle):
    u = np.linspace(0.0, 4.0, 401)
    found = circle.sampler().sample(u)
    assert np.abs(np.linalg.norm(found[:, 0], axis=1) - 1.0).max() < 1e-15
    # the velocity is tangential, and the acceleration is that of the circle
    assert np.abs(np.sum(found[:, 0] * found[:, 1], axis=1)).max() < 1e-14
    speed = np.sum(found[:, 1] ** 2, axis=1)
    assert np.allclose(np.sum(found[:, 0] * found[:, 2], axis=1), -speed, rtol=1e-12)


def test_very_uneven_knots_are_found():
    breaks = np.concatenate((np.linspace(0.0, 1e-6, 40), [1e-3, 1.0, 1e3]))
    line = BSpline(np.concatenate((breaks[:1], breaks, breaks[-1:])), breaks[:, None], 1)
    u = np.concatenate((breaks, 0.5 * (breaks[1:] + breaks[:-1])))
    found = line.sampler().sample(u, 0).ravel()
    # to rounding of the piece that each lies in
    upper = np.append(breaks, np.inf)[np.searchsorted(breaks, u, side="right")]
    assert (np.abs(found - u) <= 1e-15 * np.minimum(upper, 1e3)).all()


def test_shapes_follow_the_parameters():
    line = BSpline([0, 0, 1, 1], [[0.0, 1.0], [1.0, 1.0]], 1)
    sampler = line.sampler()
    assert sampler.dim == 2
    assert sampler.domain == (0.0, 1.0)
    assert sampler.sample(0.5).tolist() == [[0.5, 1.0], [1.0, 0.0], [0.0, 0.0]]
    assert sampler.sample(np.zeros((4, 3)), 1).shape == (4, 3, 2, 2)
    assert sampler.sample([]).shape == (0, 3, 2)
    steps = BSpline([0, 1, 2], [[3.0], [5.0]], 0)
    assert steps.sampler().sample([0.0, 0.9, 1.0, 2.0], 0).ravel().tolist() == [3, 3, 5, 5]


@pytest.mark.parametrize("u", [-1e-12, 1.0000001, float("nan"), float("inf")])
def test_nothing_outside_is_sampled(u):
    sampler = BSpline([0, 0, 1, 1], [[0.0], [1.0]], 1).sampler()
    out = np.full((3, 1), 7.0)
    with pytest.raises(CurveError, match=r"defined from 0\.0 to 1\.0, not at"):
        sampler.into(u, out)
    assert (out == 7.0).all()
    with pytest.raises(CurveError, match=r"defined from 0\.0 to 1\.0, not at"):
        sampler.sample([0.5, u])


def test_an_array_that_does_not_fit_is_refused():
    sampler = BSpline([0, 0, 1, 1], [[0.0], [1.0]], 1).sampler()
    for shape in ((3, 2), (0, 1)):
        with pytest.raises(ValueError, match=r"out: want shape \(order \+ 1, 1\)"):
            sampler.into(0.5, np.zeros(shape))
    for out in (np.zeros((1, 3)).T, np.zeros((3, 1), dtype=np.float32), np.zeros(3)):
        if not out.flags.c_contiguous or out.dtype != float or out.ndim != 2:
            with pytest.raises(TypeError):
                sampler.into(0.5, out)
    with pytest.raises(TypeError):
        sampler.into("0.5", np.zeros((3, 1)))
    with pytest.raises(ValueError, match="order: want 0 or more"):
        sampler.sample([0.5], -1)


def test_a_sampler_can_be_copied(circle):
    again = pickle.loads(pickle.dumps(circle.sampler()))
    assert np.array_equal(again.sample([0.3, 3.9]), circle.sampler().sample([0.3, 3.9]))


def test_a_piece_chooses_the_side_of_a_knot():
    corner = BSpline([0, 0, 1, 2, 2], [[0.0], [1.0], [0.0]], 1)
    sampler = corner.sampler()
    found = sampler.sample_pieces([1.0, 1.0, 2.5], [0, 1, 1], 1)
    assert found[:, :, 0].tolist() == [[1.0, 1.0], [1.0, -1.0], [-0.5, -1.0]]
    assert sampler.sample_pieces([1.0], [0])[0, 2].tolist() == [0.0]
    for pieces in ([2], [-1], [float("nan")]):
        with pytest.raises(ValueError, match="pieces: want 0 to 1"):
            sampler.sample_pieces([1.0], pieces)
    with pytest.raises(ValueError, match="one for each parameter"):
        sampler.sample_pieces([1.0, 2.0], [0])
    with pytest.raises(ValueError, match="us: want finite numbers"):
        sampler.sample_pieces([float("nan")], [0])
    with pytest.raises(ValueError, match="order"):
        sampler.sample_pieces([1.0], [0], -1)


@pytest.mark.slow
def test_a_thousand_random_curves_are_sampled_as_de_boor_says(random_curve, places):
    worst = 0.0
    for seed in range(1000):
        curve = random_curve(seed)
        u = places(curve)
        worst = max(worst, np.abs(curve.sampler().sample(u, 0)[:, 0] - curve.at(u)).max())
    assert worst < 1e-13
