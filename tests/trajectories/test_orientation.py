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
from splinearm.trajectories.rotation_spline import body_rates


@st.composite
def chains(draw, least=2):
    """Parameters and orientations; neighbours up to 2.9 rad apart, signs at random."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    m = draw(st.integers(least, 9))
    turns = rng.normal(size=(m, 3))
    turns *= draw(st.floats(1e-6, 2.9)) / np.linalg.norm(turns, axis=1, keepdims=True)
    quats = [quaternion.exp(rng.normal(size=3))]
    for turn in turns[1:]:
        quats.append(quaternion.multiply(quats[-1], quaternion.exp(turn)))
    u = np.concatenate(([0.0], np.cumsum(rng.uniform(0.3, 1.5, m))))
    return u, np.array(quats) * rng.choice([-1.0, 1.0], m)[:, None]


def rates_by_differences(curve, u, step):
    before, behind = curve.at(u - step), curve.at(u + step)
    turned = quaternion.multiply(behind.quat, quaternion.conjugate(before.quat))
    return quaternion.log(turned) / (2 * step), (behind.omega - before.omega) / (2 * step)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains(), st.booleans())
def test_the_curve_is_unit_and_passes_all_orientations(chain, closed):
    u, quats = chain
    u = u if closed else u[:-1]
    curve = interpolate_orientations(u, quats, closed=closed)
    assert quaternion.angle_between(curve.at(u[: len(quats)]).quat, quats).max() < 1e-13
    at = curve.at(np.linspace(*curve.domain, 200))
    assert np.abs(np.linalg.norm(at.quat, axis=1) - 1.0).max() < 1e-15
    assert (np.sum(at.quat[1:] * at.quat[:-1], axis=1) > 0.0).all(), "no sign flips"


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains(least=3), st.booleans())
def test_angular_velocity_and_acceleration_are_those_of_differences(chain, closed):
    u, quats = chain
    u = u if closed else u[:-1]
    curve = interpolate_orientations(u, quats, closed=closed)
    at = np.linspace(u[0], u[-1], 63)[1:-1]
    at = at[np.abs(at[:, None] - u).min(axis=1) > 1e-3]
    omega, alpha = rates_by_differences(curve, at, 1e-5)
    here = curve.at(at)
    assert np.allclose(here.omega, omega, atol=1e-7)
    assert np.allclose(here.alpha, alpha, atol=1e-6)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains(least=3))
def test_the_curve_is_c2_across_its_knots(chain):
    u, quats = chain
    curve = interpolate_orientations(u[:-1], quats)
    step = 1e-9
    before, behind = curve.at(u[1:-2] - step), curve.at(u[1:-2] + step)
    assert np.allclose(before.omega, behind.omega, atol=1e-6)
    assert np.allclose(before.alpha, behind.alpha, atol=1e-5)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains(least=2))
def test_a_closed_curve_comes_back_with_velocity_and_acceleration(chain):
    u, quats = chain
    curve = interpolate_orientations(u, quats, closed=True)
    first, last = (curve.at(np.array([x])) for x in curve.domain)
    assert quaternion.angle_between(first.quat, last.quat)[0] < 1e-13
    assert np.allclose(first.omega, last.omega, atol=1e-10)
    assert np.allclose(first.alpha, last.alpha, atol=1e-9)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains(least=2), st.integers(0, 999))
def test_the_curve_turns_with_the_frame_it_is_written_in(chain, seed):
    u, quats = chain
    turn = quaternion.exp(np.random.default_rng(seed).normal(size=3))
    at = np.linspace(0.0, u[-2], 50)
    curve = interpolate_orientations(u[:-1], quats).at(at)
    turned = interpolate_orientations(u[:-1], quaternion.multiply(turn, quats)).at(at)
    want = quaternion.multiply(turn, curve.quat)
    assert quaternion.angle_between(turned.quat, want).max() < 1e-12
    assert np.allclose(turned.omega, quaternion.rotate(turn, curve.omega), atol=1e-11)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains(least=3))
def test_open_ends_have_no_angular_acceleration(chain):
    u, quats = chain
    curve = interpolate_orientations(u[:-1], quats)
    assert np.abs(curve.at(np.array(curve.domain)).alpha).max() < 1e-9


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(0, 999))
def test_turns_about_one_axis_are_a_natural_cubic_of_the_angle(seed):
    scipy_interpolate = pytest.importorskip("scipy.interpolate")
    rng = np.random.default_rng(seed)
    u = np.concatenate(([0.0], np.cumsum(rng.uniform(0.3, 1.0, 6))))
    angles = np.cumsum(rng.uniform(-2.5, 2.5, 7))
    axis = np.array([0.6, 0.0, 0.8])
    curve = interpolate_orientations(u, quaternion.exp(angles[:, None] * axis))
    peer = scipy_interpolate.CubicSpline(u, angles, bc_type="natural")
    at = np.linspace(0.0, u[-1], 80)
    here = curve.at(at)
    want = quaternion.exp(peer(at)[:, None] * axis)
    assert quaternion.angle_between(here.quat, want).max() < 1e-9
    assert np.allclose(here.omega, peer(at, 1)[:, None] * axis, atol=1e-8)


def test_one_orientation_or_equal_ones_give_a_constant():
    quat = quaternion.exp(np.array([0.3, -0.2, 0.9]))
    for u, quats in (([0.0], [quat]), ([0.0, 1.0, 2.0], [quat, -quat, quat])):
        curve = interpolate_orientations(u, quats)
        assert isinstance(curve, ConstantOrientation)
        at = curve.at(np.linspace(*curve.domain, 5))
        assert quaternion.angle_between(at.quat, quat).max() == 0.0
        assert not at.omega.any()
        assert not at.alpha.any()


def test_two_orientations_are_an_even_turn():
    start = quaternion.exp(np.array([0.3, -0.2, 0.9]))
    turn = np.array([0.0, 1.2, 0.0])
    curve = interpolate_orientations(
        [1.0, 3.0], [start, quaternion.multiply(start, quaternion.exp(turn))]
    )
    at = curve.at(np.array([1.0, 2.0, 3.0]))
    assert np.allclose(at.omega, quaternion.rotate(start, turn) / 2.0)
    assert np.abs(at.alpha).max() < 1e-15
    half = quaternion.multiply(start, quaternion.exp(0.5 * turn))
    assert quaternion.angle_between(at.quat[1], half) < 1e-15


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(chains(least=3), st.floats(0.1, 1.0))
def test_a_rounded_chain_of_turns_is_c2(chain, share):
    u, quats = chain
    u = u[:-1]
    steps = np.diff(u)
    widths = np.zeros(len(u))
    widths[1:-1] = 0.5 * share * np.minimum(steps[:-1], steps[1:])
    curve = RotationPolyline(u, quats, widths)
    at = np.linspace(u[0], u[-1], 97)[1:-1]
    at = at[np.abs(at[:, None] - curve.breaks).min(axis=1) > 1e-4]
    omega, alpha = rates_by_differences(curve, at, 1e-6)
    here = curve.at(at)
    assert np.allclose(here.omega, omega, atol=1e-5)
    assert np.allclose(here.alpha, alpha, atol=1e-3)
    step = 1e-9
    inner = curve.breaks[1:-1]
    before, behind = curve.at(inner - step), curve.at(inner + step)
    assert np.allclose(before.omega, behind.omega, atol=1e-4)
    assert np.allclose(before.alpha, behind.alpha, atol=1e-3)
    assert quaternion.angle_between(curve.at(u[[0, -1]]).quat, quats[[0, -1]]).max() < 1e-14


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(0, 9999), st.floats(1e-9, 6.0))
def test_body_rates_are_those_of_differences_at_any_angle(seed, angle):
    rng = np.random.default_rng(seed)
    f, fd, fdd = rng.normal(size=(3, 1, 3))
    f *= angle / np.linalg.norm(f)
    step = 1e-4

    def rotation(x):
        return quaternion.exp(f + x * fd + 0.5 * x * x * fdd)

    here, back, ahead = rotation(0.0), rotation(-step), rotation(step)
    inverse = quaternion.conjugate(here)
    forth = quaternion.log(quaternion.multiply(inverse, ahead))
    behind = quaternion.log(quaternion.multiply(inverse, back))
    omega, alpha = body_rates(f, fd, fdd)
    assert np.allclose((forth - behind) / (2 * step), omega, atol=1e-5)
    assert np.allclose((forth + behind) / step**2, alpha, atol=1e-4)


@pytest.mark.parametrize(
    ("u", "quats"),
    [
        ([0.0], np.zeros((0, 4))),
        ([0.0, 1.0], [[1.0, 0, 0, 0], [1.0, 0.1, 0, 0]]),
        ([0.0, 0.0], [[1.0, 0, 0, 0], [0.0, 1.0, 0, 0]]),
        ([0.0, 1.0, 2.0], [[1.0, 0, 0, 0], [0.0, 1.0, 0, 0]]),
        ([0.0, float("nan")], [[1.0, 0, 0, 0], [0.0, 1.0, 0, 0]]),
        ([0.0, 1.0], [[1.0, 0, 0, 0], [float("nan"), 1.0, 0, 0]]),
    ],
)
def test_what_does_not_fit_is_refused(u, quats):
    with pytest.raises(ValueError, match=r"quats|u: want"):
        interpolate_orientations(u, quats)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_nothing_is_extrapolated(count):
    u = np.arange(float(count))
    quats = quaternion.exp(np.arange(count)[:, None] * np.array([[0.1, 0.2, 0.3]]))
    curve = interpolate_orientations(u, quats)
    for beyond in (-0.1, count - 0.9, float("nan")):
        with pytest.raises(CurveError, match="orientation: defined from"):
            curve.at(np.array([0.0, beyond]))
