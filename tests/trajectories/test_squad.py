import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.squad import Squad

chains = st.tuples(st.integers(0, 2**32 - 1), st.integers(2, 8), st.floats(1e-6, 2.8))


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains)
def test_it_passes_all_orientations_at_any_parameters(make_chain, chain):
    u, quats = make_chain(*chain)
    at = Squad(u[:-1], quats).at(u[:-1])
    assert quaternion.angle_between(at.quat, quats).max() < 1e-14
    assert np.abs(np.linalg.norm(at.quat, axis=1) - 1.0).max() < 1e-15


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains)
def test_rates_are_those_of_differences(make_chain, orientation_differences, chain):
    u, quats = make_chain(*chain)
    curve = Squad(u[:-1], quats)
    at = np.linspace(*curve.domain, 60)
    at = at[np.abs(at[:, None] - curve.breaks).min(axis=1) > 0.004]
    omega, alpha = orientation_differences(curve, at, 1e-3)
    here = curve.at(at)
    assert np.allclose(here.omega, omega, rtol=1e-8, atol=1e-8)
    assert np.allclose(here.alpha, alpha, rtol=1e-5, atol=1e-5)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains)
def test_the_angular_velocity_does_not_jump_at_uneven_parameters(make_chain, chain):
    u, quats = make_chain(*chain)
    curve = Squad(u[:-1], quats)
    inner = curve.breaks[1:-1]
    before, behind = curve.at(np.nextafter(inner, -1.0)), curve.at(inner)
    assert np.allclose(before.omega, behind.omega, rtol=0, atol=1e-11)


def test_the_angular_acceleration_does_jump(make_chain):
    u, quats = make_chain(3, 5, 1.0)
    curve = Squad(u[:-1], quats)
    inner = curve.breaks[1:-1]
    before, behind = curve.at(np.nextafter(inner, -1.0)), curve.at(inner)
    assert np.abs(before.alpha - behind.alpha).max() > 0.1


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(chains)
def test_at_even_parameters_it_is_shoemakes(make_chain, chain):
    _, quats = make_chain(chain[0], chain[1], min(chain[2], 1.0))
    quats = quats * np.sign(np.cumprod(np.append(1.0, np.sum(quats[1:] * quats[:-1], 1))))[:, None]
    curve = Squad(np.arange(float(len(quats))), quats)
    controls = quaternion.squad_controls(quats)
    for share in (0.2, 0.7):
        want = quaternion.squad(quats[:-1], controls[:-1], controls[1:], quats[1:], share)
        at = curve.at(np.arange(len(quats) - 1) + share)
        assert quaternion.angle_between(at.quat, want).max() < 1e-13


@pytest.mark.parametrize(
    ("u", "message"),
    [([0.0, 0.0, 1.0], "u: want at least 2 rising"), ([0.0, 1.0], "u: want shape")],
)
def test_what_does_not_fit_is_refused(u, message):
    with pytest.raises(ValueError, match=message):
        Squad(u, quaternion.exp(np.eye(3)))


def test_nothing_is_extrapolated():
    with pytest.raises(CurveError, match="orientation: defined from"):
        Squad([0.0, 1.0, 2.0], quaternion.exp(np.eye(3))).at([2.1])
