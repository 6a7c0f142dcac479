import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.rotation_bspline import RotationBSpline

seeds = st.integers(0, 2**32 - 1)
degrees = st.integers(1, 5)


def clamped_knots(rng, m, degree):
    inner = np.cumsum(rng.uniform(0.2, 1.0, m - degree))
    edge = np.ones(degree)
    return np.concatenate((edge * 0.0, [0.0], inner, edge * inner[-1]))


def make_curve(seed, degree, *, closed=False, m=9, apart=1.0):
    rng = np.random.default_rng(seed)
    quats = [quaternion.random(rng)]
    for turn in rng.normal(size=(m - 1, 3)):
        step = turn * apart / np.linalg.norm(turn)
        quats.append(quaternion.multiply(quats[-1], quaternion.exp(step)))
    quats = np.array(quats) * rng.choice([-1.0, 1.0], m)[:, None]
    if closed:
        return RotationBSpline.closed(np.cumsum(rng.uniform(0.2, 1.0, m + 1)), quats, degree)
    return RotationBSpline.from_controls(clamped_knots(rng, m, degree), quats, degree)


def away_from_breaks(curve, count, gap):
    u = np.linspace(*curve.domain, count)[1:-1]
    return u[np.abs(u[:, None] - curve.breaks).min(axis=1) > gap]


@pytest.mark.kernel
@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(seeds, degrees, st.booleans(), st.sampled_from([1e-9, 0.1, 1.0, 2.0, 3.1]))
def test_rates_are_those_of_differences(orientation_differences, seed, degree, closed, apart):
    curve = make_curve(seed, degree, closed=closed, apart=apart)
    # steps in which it turns little
    speed = np.linalg.norm(curve.at(np.linspace(*curve.domain, 200)).omega, axis=1).max()
    step = 0.02 / max(4.0, speed)
    u = away_from_breaks(curve, 60, 4.0 * step)
    omega, alpha = orientation_differences(curve, u, step)
    here = curve.at(u)
    assert np.allclose(here.omega, omega, rtol=0, atol=1e-8)
    assert np.allclose(here.alpha, alpha, rtol=0, atol=1e-6 * max(1.0, speed))


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(seeds, degrees)
def test_acceleration_is_the_derivative_of_velocity(seed, degree):
    curve = make_curve(seed, degree)
    u, step = away_from_breaks(curve, 60, 0.004), 1e-3
    weights = (3 / 4, -3 / 20, 1 / 60)
    ahead = [curve.at(u + k * step).omega - curve.at(u - k * step).omega for k in (1, 2, 3)]
    slope = sum(w * d for w, d in zip(weights, ahead, strict=True)) / step
    assert np.allclose(curve.at(u).alpha, slope, rtol=0, atol=1e-8)


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(seeds, st.integers(3, 5), st.booleans())
def test_it_is_unit_keeps_its_sign_and_is_c2(seed, degree, closed):
    curve = make_curve(seed, degree, closed=closed, apart=2.5)
    quat = curve.at(np.linspace(*curve.domain, 400)).quat
    assert np.abs(np.linalg.norm(quat, axis=1) - 1.0).max() < 1e-15
    assert (np.sum(quat[1:] * quat[:-1], axis=1) > 0.0).all(), "no sign flips"
    inner = curve.breaks[1:-1]
    before, behind = curve.at(np.nextafter(inner, -1.0)), curve.at(inner)
    assert quaternion.angle_between(before.quat, behind.quat).max() < 1e-13
    assert np.allclose(before.omega, behind.omega, rtol=0, atol=1e-11)
    assert np.allclose(before.alpha, behind.alpha, rtol=0, atol=1e-9)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seeds, degrees)
def test_turning_the_controls_turns_the_curve(seed, degree):
    curve = make_curve(seed, degree)
    turn = quaternion.random(np.random.default_rng(seed + 1))
    u = np.linspace(*curve.domain, 40)
    plain = curve.at(u)
    moved = RotationBSpline.from_controls(
        curve.knots, quaternion.multiply(turn, curve.quats), degree
    )
    for turned in (moved.at(u), curve.turned(turn).at(u)):
        want = quaternion.multiply(turn, plain.quat)
        assert quaternion.angle_between(turned.quat, want).max() < 1e-14
        assert np.allclose(turned.omega, quaternion.rotate(turn, plain.omega), atol=1e-12)
        assert np.allclose(turned.alpha, quaternion.rotate(turn, plain.alpha), atol=1e-11)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seeds, degrees)
def test_a_control_orientation_and_its_negative_are_one(seed, degree):
    curve = make_curve(seed, degree)
    flipped = curve.quats * np.random.default_rng(seed).choice([-1.0, 1.0], 9)[:, None]
    again = RotationBSpline.from_controls(curve.knots, flipped, degree)
    u = np.linspace(*curve.domain, 40)
    assert quaternion.angle_between(curve.at(u).quat, again.at(u).quat).max() < 1e-14
    assert np.allclose(curve.at(u).omega, again.at(u).omega, atol=1e-13)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seeds, degrees)
def test_turns_about_one_axis_are_a_bspline_of_the_angle(seed, degree):
    rng = np.random.default_rng(seed)
    angles = np.cumsum(rng.uniform(-3.1, 3.1, 8))
    knots, axis = clamped_knots(rng, 8, degree), np.array([0.6, 0.0, 0.8])
    curve = RotationBSpline.from_controls(knots, quaternion.exp(angles[:, None] * axis), degree)
    plain = BSpline(knots, angles[:, None], degree)
    u = np.linspace(*curve.domain, 50)
    here = curve.at(u)
    assert quaternion.angle_between(here.quat, quaternion.exp(plain.at(u) * axis)).max() < 1e-13
    assert np.allclose(here.omega, plain.at(u, 1) * axis, atol=1e-11)
    assert np.allclose(here.alpha, plain.at(u, 2) * axis, atol=1e-9)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seeds, degrees)
def test_rates_in_the_body_are_those_a_passenger_feels(seed, degree):
    curve = make_curve(seed, degree)
    at = curve.at(np.linspace(*curve.domain, 20))
    omega, alpha = at.in_body()
    assert np.allclose(quaternion.rotate(at.quat, omega), at.omega, atol=1e-12)
    assert np.allclose(quaternion.rotate(at.quat, alpha), at.alpha, atol=1e-11)
    # at a clamped start the first control orientation turns to the second
    rate = degree / (curve.knots[degree + 1] - curve.knots[1])
    assert np.allclose(omega[0], rate * curve.turns[0], atol=1e-11)


@pytest.mark.kernel
def test_a_closed_curve_goes_on_where_it_ends():
    for degree in (3, 4, 5):
        curve = make_curve(5, degree, closed=True, apart=2.0)
        first, last = (curve.at(np.array([end])) for end in curve.domain)
        assert quaternion.angle_between(first.quat, last.quat)[0] < 1e-14
        assert np.allclose(first.omega, last.omega, atol=1e-12)
        assert np.allclose(first.alpha, last.alpha, atol=1e-10)


@pytest.mark.kernel
def test_only_the_pieces_near_a_control_orientation_move_with_it():
    curve = make_curve(1, 3, m=12)
    quats = curve.quats
    quats[8] = quaternion.multiply(quats[8], quaternion.exp(np.array([0.3, 0.1, 0.0])))
    moved = RotationBSpline.from_controls(curve.knots, quats, 3)
    for u, same in (
        (curve.knots[8] - 1e-9, True),
        (0.5 * (curve.knots[9] + curve.knots[10]), False),
    ):
        apart = quaternion.angle_between(curve.at([u]).quat, moved.at([u]).quat)[0]
        assert (apart < 1e-14) == same


@pytest.mark.kernel
def test_one_sample_is_written_into_a_given_array():
    curve = make_curve(2, 3)
    state = np.empty(10)
    u = np.linspace(*curve.domain, 7)
    want = np.hstack(curve.at(u))
    for x, row in zip(u, want, strict=True):
        curve.into(float(x), state)
        assert np.allclose(state, row, rtol=0, atol=1e-14)
    with pytest.raises(CurveError, match="orientation: defined from"):
        curve.into(float("nan"), state)
    with pytest.raises(ValueError, match=r"state: want shape \(10,\), got \(9,\)"):
        curve.into(0.5, np.empty(9))
    with pytest.raises(TypeError):
        curve.into(0.5, [0.0] * 10)
    for wrong in ([u[0] - 1.0], [0.1, u[-1] + 1e-9], [float("nan")]):
        with pytest.raises(CurveError, match="orientation: defined from"):
            curve.at(wrong)


def test_a_long_chain_of_turns_stays_unit_and_exact():
    turns = np.tile([0.0, 0.0, 0.5], (4000, 1))
    knots = np.arange(4001 + 4.0)
    curve = RotationBSpline(knots, np.array([1.0, 0.0, 0.0, 0.0]), turns, 3)
    want = quaternion.exp(np.arange(4001)[:, None] * turns[:1])
    assert quaternion.angle_between(curve.quats, want).max() < 1e-12
    assert np.abs(np.linalg.norm(curve.quats, axis=1) - 1.0).max() < 1e-15


KNOTS = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
ONE = [1.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"knots": KNOTS[:-1]}, "knots: want shape"),
        ({"knots": KNOTS[::-1]}, "knots: want them never falling"),
        ({"start": [1.0, 0.1, 0.0, 0.0]}, "start: want unit"),
        ({"turns": np.zeros((3, 2))}, "turns: want shape"),
        ({"turns": np.full((3, 3), np.nan)}, "turns: want finite"),
        ({"degree": 0}, "degree: want at least 1"),
    ],
)
def test_what_does_not_fit_is_refused(change, message):
    fields = {"knots": KNOTS, "start": ONE, "turns": np.zeros((3, 3)), "degree": 3}
    with pytest.raises(ValueError, match=message):
        RotationBSpline(**(fields | change))


KERNELS = """
import numpy as np
from splinearm.kinematics import quaternion
from splinearm.trajectories.orientation import RotationPolyline, interpolate_orientations
rng = np.random.default_rng(3)
quats, u = quaternion.random(rng, 7), np.cumsum(rng.uniform(0.5, 1.0, 7))
found = []
for curve in (
    interpolate_orientations(u, quats), interpolate_orientations(u, quats, degree=5),
    RotationPolyline(u, quats, np.array([0, 0.1, 0.2, 0.0, 0.2, 0.1, 0.0])),
):
    state = np.empty(10)
    curve.into(2.0, state)
    found += [state, np.hstack(curve.at(np.linspace(*curve.domain, 30)))]
"""


def test_compiled_and_plain_sampling_agree(compiled_as_plain):
    compiled_as_plain(KERNELS, 6)
