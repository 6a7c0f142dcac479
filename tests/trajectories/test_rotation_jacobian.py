import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import quaternion
from splinearm.trajectories.rotation_jacobian import body_rates, inverse_jacobian, jacobian


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


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.integers(0, 9999), st.floats(0.0, 3.14))
def test_the_jacobian_takes_slopes_to_rates_and_back(seed, angle):
    f, fd = np.random.default_rng(seed).normal(size=(2, 1, 3))
    f *= angle / np.linalg.norm(f)
    omega, _ = body_rates(f, fd, np.zeros_like(fd))
    assert np.allclose(np.einsum("mij,mj->mi", jacobian(f), fd), omega, atol=1e-13)
    assert np.allclose(np.einsum("mij,mj->mi", inverse_jacobian(f), omega), fd, atol=1e-12)
