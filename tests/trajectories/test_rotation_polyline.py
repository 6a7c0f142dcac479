import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.rotation_polyline import RotationPolyline

chains = st.tuples(st.integers(0, 2**32 - 1), st.integers(3, 8), st.floats(1e-6, 3.1))


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(chains, st.floats(0.1, 1.0))
def test_a_rounded_chain_of_turns_is_c2(make_chain, orientation_differences, chain, share):
    u, quats = make_chain(*chain)
    u = u[:-1]
    steps = np.diff(u)
    widths = np.zeros(len(u))
    widths[1:-1] = 0.5 * share * np.minimum(steps[:-1], steps[1:])
    curve = RotationPolyline(u, quats, widths)
    at = np.linspace(u[0], u[-1], 97)[1:-1]
    at = at[np.abs(at[:, None] - curve.breaks).min(axis=1) > 4e-3]
    omega, alpha = orientation_differences(curve, at, 1e-3)
    here = curve.at(at)
    assert np.allclose(here.omega, omega, rtol=0, atol=1e-8)
    assert np.allclose(here.alpha, alpha, rtol=0, atol=1e-5)
    inner = curve.breaks[1:-1]
    before, behind = curve.at(np.nextafter(inner, -1.0)), curve.at(inner)
    assert np.allclose(before.omega, behind.omega, rtol=0, atol=1e-10)
    assert np.allclose(before.alpha, behind.alpha, rtol=0, atol=1e-8 / share)
    assert quaternion.angle_between(curve.at(u[[0, -1]]).quat, quats[[0, -1]]).max() < 1e-14


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(chains)
def test_without_rounding_it_is_a_chain_of_slerps(make_chain, chain):
    u, quats = make_chain(*chain)
    u = u[:-1]
    curve = RotationPolyline(u, quats, np.zeros(len(u)))
    assert quaternion.angle_between(curve.at(u).quat, quats).max() < 1e-14
    for share in (0.25, 0.5):
        want = quaternion.slerp(quats[:-1], quats[1:], np.full(len(u) - 1, share))
        at = curve.at(u[:-1] + share * np.diff(u))
        assert quaternion.angle_between(at.quat, want).max() < 1e-13
        assert np.allclose(np.linalg.norm(at.omega, axis=1) * np.diff(u), chain[2], rtol=1e-9)
        assert not at.alpha.any() or np.abs(at.alpha).max() < 1e-12
    assert np.array_equal(curve.breaks, u)


@pytest.mark.kernel
def test_one_sample_is_written_into_a_given_array(make_chain):
    u, quats = make_chain(4, 4, 1.0)
    curve = RotationPolyline(u[:-1], quats, np.array([0.0, 0.1, 0.15, 0.0]))
    state = np.empty(10)
    for x in (u[0], u[1], u[1] + 0.09, u[2] - 0.2, u[3]):
        curve.into(float(x), state)
        assert np.allclose(state, np.hstack(curve.at([x]))[0], rtol=0, atol=1e-14)
    with pytest.raises(CurveError, match="orientation: defined from"):
        curve.at([u[3] + 0.1])


@pytest.mark.parametrize("share", [0.5, 0.5 - 1e-13, 0.5 + 1e-13])
def test_roundings_that_touch_leave_no_crumb_between_them(share):
    quats = quaternion.exp(np.cumsum(np.eye(3)[[0, 1, 2, 0]], axis=0))
    curve = RotationPolyline(np.arange(4.0), quats, np.array([0.0, share, share, 0.0]))
    assert np.diff(curve.breaks).min() > 0.4
    before, behind = curve.at([1.5 - 1e-9]), curve.at([1.5 + 1e-9])
    assert np.allclose(before.omega, behind.omega, atol=1e-7)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"u": [0.0, 1.0, 1.0]}, "u: want at least 2 rising"),
        ({"u": [0.0, 1.0]}, "u: want shape"),
        ({"quats": np.ones((3, 4))}, "quats: want unit"),
        ({"half_widths": [0.1, 0.0, 0.0]}, "half_widths: want 0 at the ends"),
        ({"half_widths": [0.0, 1.1, 0.0]}, "half_widths: .* room"),
        ({"half_widths": [0.0, -0.1, 0.0]}, "half_widths: want"),
    ],
)
def test_what_does_not_fit_is_refused(change, message):
    quats = quaternion.exp(np.eye(3))
    fields = {"u": [0.0, 1.0, 2.0], "quats": quats, "half_widths": np.zeros(3)}
    with pytest.raises(ValueError, match=message):
        RotationPolyline(**(fields | change))
