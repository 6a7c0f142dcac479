import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.orientation import (
    ConstantOrientation,
    interpolate_orientations,
)


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
    u = np.concatenate(([0.0], np.cumsum(rng.uniform(0.4, 1.2, m))))
    return u, np.array(quats) * rng.choice([-1.0, 1.0], m)[:, None]


def rates_by_differences(curve, u, step):
    before, behind = curve.at(u - step), curve.at(u + step)
    turned = quaternion.multiply(behind.quat, quaternion.conjugate(before.quat))
    return quaternion.log(turned) / (2 * step), (behind.omega - before.omega) / (2 * step)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
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
@settings(max_examples=25, deadline=None)
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
@settings(max_examples=25, deadline=None)
@given(chains(least=3))
def test_the_curve_is_c2_across_its_knots(chain):
    u, quats = chain
    curve = interpolate_orientations(u[:-1], quats)
    step = 1e-9
    before, behind = curve.at(u[1:-2] - step), curve.at(u[1:-2] + step)
    assert np.allclose(before.omega, behind.omega, atol=1e-6)
    assert np.allclose(before.alpha, behind.alpha, atol=1e-5)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(chains(least=2))
def test_a_closed_curve_comes_back_with_velocity_and_acceleration(chain):
    u, quats = chain
    curve = interpolate_orientations(u, quats, closed=True)
    first, last = (curve.at(np.array([x])) for x in curve.domain)
    assert quaternion.angle_between(first.quat, last.quat)[0] < 1e-13
    assert np.allclose(first.omega, last.omega, atol=1e-10)
    assert np.allclose(first.alpha, last.alpha, atol=1e-9)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
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
@settings(max_examples=25, deadline=None)
@given(chains(least=3))
def test_open_ends_have_no_angular_acceleration(chain):
    u, quats = chain
    curve = interpolate_orientations(u[:-1], quats)
    assert np.abs(curve.at(np.array(curve.domain)).alpha).max() < 1e-9


@pytest.mark.property
@settings(max_examples=25, deadline=None)
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
        state = np.ones(10)
        curve.into(0.0, state)
        assert np.allclose(state, [*at.quat[0], *np.zeros(6)], rtol=0, atol=0)
        with pytest.raises(ValueError, match="state: want shape"):
            curve.into(0.0, np.ones(9))
        with pytest.raises(CurveError, match="orientation: defined from"):
            curve.into(-0.1, state)


def test_two_orientations_are_an_even_turn():
    start = quaternion.exp(np.array([0.3, -0.2, 0.9]))
    turn = np.array([0.0, 1.2, 0.0])
    curve = interpolate_orientations(
        [1.0, 3.0], [start, quaternion.multiply(start, quaternion.exp(turn))]
    )
    at = curve.at(np.array([1.0, 2.0, 3.0]))
    assert np.allclose(at.omega, quaternion.rotate(start, turn) / 2.0)
    assert np.abs(at.alpha).max() < 1e-14
    half = quaternion.multiply(start, quaternion.exp(0.5 * turn))
    assert quaternion.angle_between(at.quat[1], half) < 1e-15


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(st.integers(0, 999), st.integers(3, 8), st.sampled_from([3, 5]))
def test_given_velocities_hold_at_the_ends(make_chain, seed, m, degree):
    u, quats = make_chain(seed, m, 1.5)
    start, end = np.random.default_rng(seed).normal(size=(2, 3))
    curve = interpolate_orientations(u[:-1], quats, degree=degree, omega_start=start, omega_end=end)
    assert quaternion.angle_between(curve.at(u[:-1]).quat, quats).max() < 1e-11
    omega = curve.at(np.array(curve.domain)).omega
    assert np.allclose(omega, [start, end], rtol=0, atol=1e-10)


def test_one_end_may_be_given_and_a_curve_may_start_from_rest_and_return():
    quat = quaternion.exp(np.array([0.1, 0.2, 0.3]))
    curve = interpolate_orientations(
        [0.0, 1.0], [quat, -quat], omega_start=[0.0, 0.0, 2.0], omega_end=None
    )
    ends = curve.at(np.array([0.0, 1.0]))
    assert np.allclose(ends.omega[0], [0.0, 0.0, 2.0], atol=1e-12)
    assert np.abs(ends.alpha[1]).max() < 1e-12
    assert quaternion.angle_between(ends.quat, quat).max() < 1e-14


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(st.integers(0, 999))
def test_a_quintic_curve_has_a_jerk_that_does_not_jump(make_chain, seed):
    u, quats = make_chain(seed, 6, 1.0)
    curve = interpolate_orientations(u[:-1], quats, degree=5)
    assert quaternion.angle_between(curve.at(u[:-1]).quat, quats).max() < 1e-11
    step, inner = 1e-5, u[1:-2]
    at, before, behind = (curve.at(inner + k * step).alpha for k in (0, -1, 1))
    assert np.allclose(behind - at, at - before, rtol=0, atol=1e-3 * step * np.abs(at).max() + 1e-6)


@pytest.mark.parametrize("apart", [1e-12, 1e-6, 3.1, 3.1415, np.pi])
@pytest.mark.parametrize("closed", [False, True])
def test_it_passes_orientations_that_are_nearly_one_or_half_a_turn_apart(make_chain, apart, closed):
    for seed in range(10):
        u, quats = make_chain(seed, 7, apart)
        curve = interpolate_orientations(u if closed else u[:-1], quats, closed=closed)
        here = curve.at(u[:-1])
        assert quaternion.angle_between(here.quat, quats).max() < 1e-11
        if not closed:
            largest = np.abs(curve.at(np.linspace(*curve.domain, 300)).omega).max()
            assert largest < 12.0 * apart / np.diff(u).min()


@pytest.mark.parametrize("unit", [1e-7, 1e6])
@pytest.mark.parametrize("degree", [3, 5])
def test_the_unit_of_the_parameter_does_not_matter(make_chain, unit, degree):
    u, quats = make_chain(8, 9, 1.5)
    u, omega = u[:-1], np.array([0.5, -1.0, 0.2])
    plain = interpolate_orientations(u, quats, degree=degree, omega_end=omega)
    scaled = interpolate_orientations(u * unit, quats, degree=degree, omega_end=omega / unit)
    at = np.linspace(u[0], u[-1] * (1.0 - 1e-12), 50)
    here, there = plain.at(at), scaled.at(at * unit)
    assert quaternion.angle_between(here.quat, there.quat).max() < 1e-11
    assert np.allclose(there.omega * unit, here.omega, rtol=0, atol=1e-10)
    assert np.allclose(there.alpha * unit**2, here.alpha, rtol=0, atol=1e-9)


def test_half_a_turn_is_taken_one_of_the_two_ways():
    quats = [[1.0, 0, 0, 0], [0.0, 1.0, 0, 0], [1.0, 0, 0, 0]]
    at = interpolate_orientations([0.0, 1.0, 2.0], quats).at(np.linspace(0.0, 2.0, 21))
    assert np.abs(at.omega[:, 1:]).max() < 1e-12
    assert np.abs(at.omega[:, 0]).max() > 3.0


def test_a_curve_that_would_turn_wildly_is_refused_with_the_place():
    # a step that is long beside short ones with great turns
    quats = quaternion.random(np.random.default_rng(4), 4)
    with pytest.raises(CurveError, match=r"degree 3 was found: .* between orientations 1 and 2 \("):
        interpolate_orientations([0.0, 0.01, 1.0, 1.01], quats)


def test_it_swings_out_no_farther_than_a_spline_of_vectors_would():
    # steps of a tool that sometimes moves and sometimes turns
    for seed in range(60):
        rng = np.random.default_rng(seed)
        turns = rng.normal(size=(7, 3))
        angles = rng.choice([0.01, 0.3, 1.0, 3.1], 7)
        turns *= (angles / np.linalg.norm(turns, axis=1))[:, None]
        quats = [quaternion.random(rng)]
        for turn in turns:
            quats.append(quaternion.multiply(quats[-1], quaternion.exp(turn)))
        steps = np.maximum(np.exp(rng.uniform(np.log(1e-3), 0.0, 7)), 0.1 * angles)
        curve = interpolate_orientations(np.append(0.0, np.cumsum(steps)), np.array(quats))
        speeds = np.linalg.norm(curve.at(np.linspace(*curve.domain, 500)).omega, axis=1)
        assert speeds.max() < 40.0, "the quickest pair alone turns at 10"


@pytest.mark.slow
@pytest.mark.parametrize("uneven", [1.0, 3.0])
def test_any_orientations_at_rather_even_parameters_have_a_cubic_curve(uneven):
    for seed in range(1000):
        rng = np.random.default_rng(seed)
        m = int(rng.integers(2, 20))
        quats = quaternion.random(rng, m)
        u = np.concatenate(([0.0], np.cumsum(rng.uniform(1.0, uneven, m - 1))))
        curve = interpolate_orientations(u, quats)
        assert quaternion.angle_between(curve.at(u).quat, quats).max() < 1e-10


@pytest.mark.slow
def test_neighbours_within_two_radians_have_a_quintic_curve(make_chain):
    for seed in range(100):
        _, quats = make_chain(seed, 2 + seed % 15, 2.0)
        u = np.arange(float(len(quats)))
        curve = interpolate_orientations(u, quats, degree=5)
        assert quaternion.angle_between(curve.at(u).quat, quats).max() < 1e-10


def test_the_acceleration_is_no_more_than_that_of_rotation_vectors():
    transform = pytest.importorskip("scipy.spatial.transform")
    ratios = []
    for seed in range(10):
        quats = quaternion.random(np.random.default_rng(seed), 12)
        u = np.arange(12.0)
        peer = transform.RotationSpline(u, transform.Rotation.from_quat(quaternion.to_xyzw(quats)))
        at = np.linspace(0.0, 11.0, 400)
        ours = interpolate_orientations(u, quats).at(at).alpha
        ratios.append(np.linalg.norm(ours) / np.linalg.norm(peer(at, 2)))
    assert max(ratios) < 1.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"degree": 4}, "degree: want 3 or 5, got 4"),
        ({"omega_start": [1.0, 2.0]}, "omega_start: want shape"),
        ({"omega_end": [0.0, 0.0, float("nan")]}, "omega_end: want finite"),
        ({"closed": True, "omega_end": [0.0, 0.0, 1.0]}, "a closed curve and one"),
    ],
)
def test_options_that_do_not_fit_are_refused(options, message):
    quats = quaternion.exp(np.arange(4.0)[:, None] * np.array([[0.1, 0.2, 0.3]]))
    u = np.arange(4.0 + options.get("closed", False))
    with pytest.raises(ValueError, match=message):
        interpolate_orientations(u, quats, **options)


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
