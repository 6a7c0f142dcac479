import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.orientation import (
    ConstantOrientation,
    RotationPolyline,
    interpolate_orientations,
)
from splinearm.trajectories.squad import Squad
from splinearm.trajectories.turn_rate import EvenTurn, TurnLength

chains = st.tuples(st.integers(0, 2**32 - 1), st.integers(3, 7), st.floats(0.1, 2.5))


def make_curves(u, quats):
    return (
        interpolate_orientations(u[:-1], quats),
        interpolate_orientations(u, quats, closed=True),
        Squad(u[:-1], quats),
    )


@pytest.mark.property
@settings(max_examples=8, deadline=None)
@given(chains)
def test_parameter_and_angle_are_each_others_inverse(make_chain, chain):
    for curve in make_curves(*make_chain(*chain)):
        length = TurnLength(curve)
        angles = np.linspace(0.0, length.angle, 60)
        u = length.parameter(angles)
        assert (np.diff(u) > 0.0).all()
        assert np.allclose(length.at(u), angles, rtol=0, atol=1e-12 * length.angle)


@pytest.mark.property
@settings(max_examples=8, deadline=None)
@given(chains)
def test_the_angle_is_that_of_many_small_turns(make_chain, chain):
    for curve in make_curves(*make_chain(*chain)):
        at = curve.at(np.linspace(*curve.domain, 1501)).quat
        steps = quaternion.angle_between(at[:-1], at[1:])
        assert TurnLength(curve).angle == pytest.approx(float(steps.sum()), rel=1e-3)


@pytest.mark.property
@settings(max_examples=8, deadline=None)
@given(chains)
def test_the_even_curve_turns_at_one_rate(make_chain, orientation_differences, chain):
    u, quats = make_chain(*chain)
    even = EvenTurn(TurnLength(interpolate_orientations(u[:-1], quats)))
    at = np.linspace(*even.domain, 60)[1:-1]
    here = even.at(at)
    assert np.allclose(np.linalg.norm(here.omega, axis=1), 1.0, atol=1e-14)
    bent = np.linalg.norm(here.alpha, axis=1)
    assert (np.abs(np.sum(here.omega * here.alpha, axis=1)) < 1e-10 * (1.0 + bent)).all()
    # where a curve nearly rests it bends sharply: differences are right elsewhere
    step = 2e-4 * even.domain[1]
    calm = (bent < 5.0) & (np.abs(at[:, None] - even.breaks).min(axis=1) > 4.0 * step)
    omega, alpha = orientation_differences(even, at[calm], step)
    assert np.allclose(here.omega[calm], omega, rtol=0, atol=1e-5)
    assert np.allclose(here.alpha[calm], alpha, rtol=0, atol=1e-3)


def test_a_chain_of_slerps_travels_the_sum_of_its_angles(make_chain):
    u, quats = make_chain(2, 6, 1.3)
    length = TurnLength(RotationPolyline(u[:-1], quats, np.zeros(6)))
    assert length.angle == pytest.approx(5 * 1.3, rel=1e-14)
    assert np.allclose(length.parameter(1.3 * np.arange(6.0)), u[:-1], atol=1e-13)
    assert np.allclose(EvenTurn(length).breaks, 1.3 * np.arange(6.0), atol=1e-13)


def test_a_curve_that_starts_and_ends_at_rest_has_no_direction_there(make_chain):
    u, quats = make_chain(2, 4, 1.0)
    rest = np.zeros(3)
    curve = interpolate_orientations(u[:-1], quats, omega_start=rest, omega_end=rest)
    length = TurnLength(curve)
    angles = np.linspace(0.0, length.angle, 40)
    assert np.allclose(length.at(length.parameter(angles)), angles, rtol=0, atol=1e-12)
    even = EvenTurn(length)
    assert np.allclose(np.linalg.norm(even.at(angles[1:-1]).omega, axis=1), 1.0)
    with pytest.raises(CurveError, match="orientation: rests at 0 rad"):
        even.at([0.0])


def test_what_lies_outside_is_refused(make_chain):
    u, quats = make_chain(2, 4, 1.0)
    length = TurnLength(interpolate_orientations(u[:-1], quats))
    for angle in (-0.1, length.angle + 0.1, float("nan")):
        with pytest.raises(CurveError, match="orientation: defined from 0"):
            length.parameter([angle])
    with pytest.raises(CurveError, match="orientation: defined from"):
        length.at([u[-2] + 0.1])
    with pytest.raises(CurveError, match="one orientation travels no angle"):
        TurnLength(ConstantOrientation(quats[0], (1.0, 1.0)))
