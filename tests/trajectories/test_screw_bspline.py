import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion, se3
from splinearm.kinematics.pose import Pose
from splinearm.trajectories.screw_bspline import ScrewBSpline

seeds = st.integers(0, 999)
degrees = st.integers(1, 5)


def make_curve(make_chain, seed, degree, m=8):
    _, quats = make_chain(seed, m, 1.2)
    rng = np.random.default_rng(seed)
    poses = [Pose(p, quat) for p, quat in zip(rng.normal(size=(m, 3)), quats, strict=True)]
    inner = np.cumsum(rng.uniform(0.4, 1.0, m - degree))
    knots = np.concatenate((np.zeros(degree + 1), inner, np.full(degree, inner[-1])))
    return ScrewBSpline(knots, poses, degree)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seeds, degrees)
def test_twists_are_those_of_differences(make_chain, orientation_differences, seed, degree):
    curve = make_curve(make_chain, seed, degree)
    u, step = np.linspace(*curve.domain, 50)[1:-1], 1e-3
    u = u[np.abs(u[:, None] - curve.breaks).min(axis=1) > 4 * step]
    here = curve.at(u)
    omega, alpha = orientation_differences(curve, u, step)
    assert np.allclose(here.twist[:, 3:], omega, rtol=0, atol=1e-8)
    assert np.allclose(here.twist_rate[:, 3:], alpha, rtol=0, atol=1e-5)
    weights = (3 / 4, -3 / 20, 1 / 60)
    ahead = [(curve.at(u + k * step), curve.at(u - k * step)) for k in (1, 2, 3)]
    velocity = sum(w * (b.p - a.p) for w, (b, a) in zip(weights, ahead, strict=True)) / step
    rate = sum(w * (b.twist - a.twist) for w, (b, a) in zip(weights, ahead, strict=True)) / step
    assert np.allclose(here.twist[:, :3], velocity, rtol=0, atol=1e-8)
    assert np.allclose(here.twist_rate, rate, rtol=0, atol=1e-7)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seeds, st.integers(3, 5))
def test_it_is_c2_and_clamped(make_chain, seed, degree):
    curve = make_curve(make_chain, seed, degree)
    inner = curve.breaks[1:-1]
    before, behind = curve.at(np.nextafter(inner, -1.0)), curve.at(inner)
    for a, b in zip(before, behind, strict=True):
        assert np.allclose(a, b, rtol=0, atol=1e-8)
    quat = curve.at(np.linspace(*curve.domain, 200)).quat
    assert (np.sum(quat[1:] * quat[:-1], axis=1) > 0.0).all(), "no sign flips"
    ends = curve.at(np.array(curve.domain)).matrices()
    assert np.allclose(ends, [curve.poses[0].matrix(), curve.poses[-1].matrix()], atol=1e-13)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seeds, degrees)
def test_moving_all_control_poses_moves_the_curve(make_chain, seed, degree):
    curve = make_curve(make_chain, seed, degree)
    rng = np.random.default_rng(seed + 1)
    move = Pose(rng.normal(size=3), quaternion.random(rng))
    moved = ScrewBSpline(curve.knots, [move @ pose for pose in curve.poses], degree)
    u = np.linspace(*curve.domain, 30)
    want = move.matrix() @ curve.at(u).matrices()
    assert np.allclose(moved.at(u).matrices(), want, rtol=0, atol=1e-12)


def test_of_degree_1_it_goes_by_screws(make_chain):
    curve = make_curve(make_chain, 3, 1)
    a, b = (pose.matrix() for pose in curve.poses[:2])
    u = curve.breaks[0] + 0.3 * (curve.breaks[1] - curve.breaks[0])
    assert np.allclose(curve.at([u]).matrices()[0], se3.interpolate_screw(a, b, 0.3), atol=1e-14)


def test_without_turns_it_is_a_bspline_of_points():
    points = np.random.default_rng(0).normal(size=(7, 3))
    knots = np.concatenate((np.zeros(4), [0.3, 0.5, 0.6], np.ones(4)))
    curve = ScrewBSpline(knots, [Pose(p, [1.0, 0.0, 0.0, 0.0]) for p in points], 3)
    plain = BSpline(knots, points, 3)
    u = np.linspace(0.0, 1.0, 40)
    at = curve.at(u)
    assert np.allclose(at.p, plain.at(u), atol=1e-14)
    assert np.allclose(at.twist[:, :3], plain.at(u, 1), atol=1e-12)
    assert np.allclose(at.twist_rate[:, :3], plain.at(u, 2), atol=1e-10)
    assert not at.twist[:, 3:].any()


def test_what_does_not_fit_is_refused(make_chain):
    curve = make_curve(make_chain, 1, 3)
    with pytest.raises(ValueError, match="degree: want at least 1"):
        ScrewBSpline(curve.knots, curve.poses, 0)
    with pytest.raises(ValueError, match="knots: want shape"):
        ScrewBSpline(curve.knots[1:], curve.poses, 3)
    with pytest.raises(CurveError, match="orientation: defined from"):
        curve.at([curve.domain[1] + 0.1])
