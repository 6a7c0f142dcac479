import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.kinematics.home import frame_on

VECTORS = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).filter(
    lambda v: np.linalg.norm(v) > 1e-3
)


@pytest.mark.property
@given(VECTORS)
def test_a_frame_on_an_axis_is_a_rotation_with_its_z_there(vector):
    axis = np.array(vector) / np.linalg.norm(vector)
    R = frame_on(axis)[:3, :3]
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_array_equal(R[:, 2], axis)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("along", [0, 1, 2])
def test_a_frame_on_a_coordinate_axis_is_exact(along, sign):
    R = frame_on(sign * np.eye(3)[along])[:3, :3]
    assert set(np.abs(R).ravel()) == {0.0, 1.0}
    np.testing.assert_array_equal(R.T @ R, np.eye(3))


def test_a_frame_stands_at_its_origin():
    np.testing.assert_array_equal(frame_on(np.eye(3)[0], [1.0, 2.0, 3.0])[:3, 3], [1.0, 2.0, 3.0])
