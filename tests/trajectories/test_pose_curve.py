import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.kinematics.pose import Pose
from splinearm.trajectories.orientation import ConstantOrientation
from splinearm.trajectories.pose_curve import PoseCurve, interpolate_poses

seeds = st.integers(0, 999)


def make_poses(make_chain, seed, m=5):
    u, quats = make_chain(seed, m, 1.0)
    points = np.random.default_rng(seed).normal(size=(m, 3))
    return u, [Pose(p, quat) for p, quat in zip(points, quats, strict=True)]


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seeds, st.sampled_from([3, 5]), st.booleans())
def test_it_passes_all_poses(make_chain, seed, degree, closed):
    u, poses = make_poses(make_chain, seed)
    curve = interpolate_poses(u if closed else u[:-1], poses, degree=degree, closed=closed)
    T = curve.at(u[:-1]).matrices()
    assert np.allclose(T, [pose.matrix() for pose in poses], rtol=0, atol=1e-11)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seeds, st.sampled_from([3, 5]))
def test_given_twists_hold_at_the_ends(make_chain, seed, degree):
    u, poses = make_poses(make_chain, seed)
    start, end = np.random.default_rng(seed).normal(size=(2, 6))
    curve = interpolate_poses(u[:-1], poses, degree=degree, twist_start=start, twist_end=end)
    at = curve.at(u[:-1])
    assert np.allclose(at.twist[[0, -1]], [start, end], rtol=0, atol=1e-10)
    assert np.allclose(at.matrices(), [pose.matrix() for pose in poses], rtol=0, atol=1e-11)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seeds)
def test_twists_are_those_of_differences(make_chain, orientation_differences, seed):
    u, poses = make_poses(make_chain, seed)
    curve = interpolate_poses(u[:-1], poses)
    at = np.linspace(*curve.domain, 50)[1:-1]
    at = at[np.abs(at[:, None] - curve.breaks).min(axis=1) > 0.016]
    omega, alpha = orientation_differences(curve, at, 5e-3)
    here = curve.at(at)
    assert np.allclose(here.twist[:, 3:], omega, rtol=0, atol=1e-8)
    assert np.allclose(here.twist_rate[:, 3:], alpha, rtol=0, atol=1e-6)
    step = 1e-4
    before, behind = curve.at(at - step), curve.at(at + step)
    assert np.allclose(here.twist[:, :3], (behind.p - before.p) / (2 * step), atol=1e-6)
    slope = (behind.twist - before.twist)[:, :3] / (2 * step)
    assert np.allclose(here.twist_rate[:, :3], slope, atol=1e-6)


def test_a_closed_curve_goes_on_where_it_ends(make_chain):
    u, poses = make_poses(make_chain, 1)
    ends = interpolate_poses(u, poses, closed=True).at(u[[0, -1]])
    for part in (ends.p, ends.twist, ends.twist_rate):
        assert np.allclose(part[0], part[1], rtol=0, atol=1e-11)


def test_breaks_are_those_of_both(make_chain):
    u, poses = make_poses(make_chain, 1)
    assert np.allclose(interpolate_poses(u[:-1], poses).breaks, u[:-1])


def test_what_does_not_fit_is_refused(make_chain):
    u, poses = make_poses(make_chain, 1)
    still = ConstantOrientation(np.array([1.0, 0.0, 0.0, 0.0]), (0.0, 1.0))
    line = BSpline([0.0, 0.0, 1.0, 1.0], np.zeros((2, 3)), 1)
    with pytest.raises(ValueError, match="orientation: want the domain of the position"):
        PoseCurve(line, ConstantOrientation(still.quat, (0.0, 2.0)))
    with pytest.raises(ValueError, match="position: want a curve in space, got 2"):
        PoseCurve(BSpline([0.0, 0.0, 1.0, 1.0], np.zeros((2, 2)), 1), still)
    with pytest.raises(CurveError):
        PoseCurve(line, still).at([1.5])
    with pytest.raises(ValueError, match="want at least 2, got 1"):
        interpolate_poses([0.0], poses[:1])
    with pytest.raises(ValueError, match="twist_start, twist_end: want both or none"):
        interpolate_poses(u[:-1], poses, twist_start=np.zeros(6))
    with pytest.raises(ValueError, match="a closed curve has no ends"):
        interpolate_poses(u, poses, closed=True, twist_start=np.zeros(6), twist_end=np.zeros(6))


def test_an_unturned_frame_keeps_its_quaternion():
    poses = [Pose([x, x * x, 0.0], [1.0, 0.0, 0.0, 0.0]) for x in (0.0, 1.0, 2.0)]
    at = interpolate_poses([0.0, 1.0, 2.0], poses).at(np.linspace(0.0, 2.0, 9))
    assert quaternion.angle_between(at.quat, poses[0].quat).max() == 0.0
    assert not at.twist[:, 3:].any()
