import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.hermite import quintic_pieces, quintic_spline
from splinearm.curves.interpolation import interpolate
from splinearm.errors import CurveError
from splinearm.trajectories.joint_path import JointPath


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(2, 9), st.integers(1, 7), st.sampled_from([1, 3]), st.integers(0, 999))
def test_a_joint_path_is_its_curve(m, n, degree, seed):
    points = np.random.default_rng(seed).normal(size=(m if degree == 3 else 2, n))
    curve = interpolate(points, degree=degree, parameters="uniform")
    path = JointPath(curve)
    s = np.linspace(*curve.domain, 41)
    for order, values in enumerate(path.sample(s)):
        assert np.allclose(values, curve.at(s, order), atol=1e-12)
    for x in s:
        assert np.allclose(path.at(x), [values[0] for values in path.sample(np.array([x]))])
    assert path.is_straight or degree == 3
    assert not path.is_still


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(2, 8), st.integers(0, 999))
def test_a_quintic_spline_has_the_values_slopes_and_bends_it_was_given(m, seed):
    rng = np.random.default_rng(seed)
    u = np.concatenate(([0.0], np.cumsum(rng.uniform(0.1, 2.0, m - 1))))
    jet = tuple(rng.normal(size=(3, m, 4)))
    curve = quintic_spline(u, jet)
    for order, values in enumerate(jet):
        assert np.allclose(curve.at(u, order), values, atol=1e-10)
        # right-hand values above; from the left the same
        assert np.allclose(curve.at(u[1:] - 1e-12, order), values[1:], atol=1e-6)
    pieces = quintic_pieces(np.diff(u), tuple(v[:-1] for v in jet), tuple(v[1:] for v in jet))
    for i, c in enumerate(pieces):
        x = np.linspace(0.0, u[i + 1] - u[i], 7)[:-1]
        value = sum(c[j] * x[:, None] ** j for j in range(6))
        assert np.allclose(value, curve.at(u[i] + x), atol=1e-10)


def test_a_corner_is_refused():
    with pytest.raises(CurveError, match=r"s = 1: the joints' direction jumps"):
        JointPath(interpolate([[0.0, 0], [1, 0], [1, 1]], degree=1, parameters="uniform"))


def test_joints_that_stay_are_told():
    assert JointPath(interpolate(np.full((5, 2), 0.3), parameters="uniform")).is_still
    assert JointPath(BSpline([0.0, 1.0], [[0.1, 0.2]], 0)).is_still
