import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.orientation import interpolate_orientations
from splinearm.trajectories.rotation_approximation import approximate_orientations


def noisy(make_chain, seed, m, noise):
    rng = np.random.default_rng(seed)
    u, quats = make_chain(seed, 7, 1.0)
    curve = interpolate_orientations(u[:-1], quats)
    at = np.linspace(*curve.domain, m)
    turns = noise * rng.uniform(-1.0, 1.0, (m, 3)) / np.sqrt(3.0)
    quats = quaternion.multiply(curve.at(at).quat, quaternion.exp(turns))
    return at, quats * rng.choice([-1.0, 1.0], m)[:, None], curve


@pytest.mark.property
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 999), st.integers(1, 5), st.sampled_from([0.3, 0.03, 0.01]))
def test_it_stays_within_the_tolerance_with_few_controls(make_chain, seed, degree, tolerance):
    u, quats, _ = noisy(make_chain, seed, 150, 0.005)
    curve = approximate_orientations(u, quats, tolerance, degree=degree)
    assert quaternion.angle_between(curve.at(u).quat, quats).max() <= tolerance
    assert curve.degree == degree
    assert len(curve.quats) <= (110 if degree == 1 else 60)


def test_a_looser_tolerance_takes_fewer_controls(make_chain):
    u, quats, _ = noisy(make_chain, 1, 200, 0.0)
    counts = [len(approximate_orientations(u, quats, t).quats) for t in (1.0, 0.1, 1e-2, 1e-3)]
    assert counts == sorted(counts)
    assert counts[0] <= 8


def test_noise_is_smoothed_away(make_chain):
    u, quats, true = noisy(make_chain, 3, 400, 0.02)
    curve = approximate_orientations(u, quats, 0.025)
    given = quaternion.angle_between(true.at(u).quat, quats)
    left = quaternion.angle_between(true.at(u).quat, curve.at(u).quat)
    assert np.mean(left**2) < 0.25 * np.mean(given**2)


def test_turning_the_orientations_turns_the_curve(make_chain):
    u, quats, _ = noisy(make_chain, 4, 80, 0.01)
    turn = quaternion.exp(np.array([0.4, -1.0, 2.0]))
    plain = approximate_orientations(u, quats, 0.03).at(u)
    moved = approximate_orientations(u, quaternion.multiply(turn, quats), 0.03).at(u)
    want = quaternion.multiply(turn, plain.quat)
    assert quaternion.angle_between(moved.quat, want).max() < 1e-10


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_equal_orientations_take_the_fewest_controls(degree):
    quats = np.tile(quaternion.exp(np.array([0.1, 0.2, 0.3])), (9, 1))
    curve = approximate_orientations(np.arange(9.0), quats, 1e-9, degree=degree)
    assert len(curve.quats) == degree + 1
    assert np.abs(curve.at(np.arange(9.0)).omega).max() < 1e-12


def test_what_cannot_be_met_is_refused(make_chain):
    quats = quaternion.random(np.random.default_rng(0), 40)
    with pytest.raises(CurveError, match=r"orientations: no curve of degree 3 .* within 1e-12 rad"):
        approximate_orientations(np.arange(40.0), quats, 1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"u": [0.0, 1.0, 1.0, 2.0]}, "u: want rising"),
        ({"u": [0.0, 1.0]}, "u: want shape"),
        ({"quats": np.ones((4, 4))}, "quats: want unit"),
        ({"tolerance": 0.0}, "tolerance: want between"),
        ({"tolerance": float("nan")}, "tolerance: want between"),
        ({"degree": 6}, "degree: want 1 to 5"),
        ({"degree": 4}, "degree: want 1 to 5 and fewer than the 4"),
    ],
)
def test_what_does_not_fit_is_refused(change, message):
    quats = quaternion.exp(np.arange(12.0).reshape(4, 3) / 20.0)
    fields = {"u": np.arange(4.0), "quats": quats, "tolerance": 0.1}
    with pytest.raises(ValueError, match=message):
        approximate_orientations(**(fields | change))
