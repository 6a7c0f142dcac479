from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from splinearm.config.frame import read_axis, read_quat, read_transform
from splinearm.config.reader import Table
from splinearm.errors import ConfigError
from splinearm.kinematics import quaternion

ANGLES = st.lists(st.integers(-1800, 1800), min_size=3, max_size=3)


def table(**values: object) -> Table:
    return Table(values, "some.toml", "tool")


@pytest.mark.property
@given(ANGLES)
def test_rpy_turns_about_fixed_axes_x_then_y_then_z(angles):
    quat = read_quat(table(rpy_deg=angles))
    np.testing.assert_allclose(
        quaternion.to_matrix(quat),
        Rotation.from_euler("xyz", angles, degrees=True).as_matrix(),
        atol=1e-14,
    )


def test_what_a_transform_does_not_give_is_zero():
    np.testing.assert_array_equal(read_transform(table()), np.eye(4))
    T = read_transform(table(xyz_mm=[1, 2, 3]))
    np.testing.assert_array_equal(T[:3, 3], [0.001, 0.002, 0.003])
    np.testing.assert_array_equal(T[:3, :3], np.eye(3))
    assert read_quat(table()) is None


def test_a_quaternion_off_by_rounding_is_made_exact():
    quat = read_quat(table(quat_wxyz=[1, 0, 0, Decimal("1e-4")]))
    assert np.linalg.norm(quat) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.property
@given(st.lists(st.integers(-20, 20), min_size=4, max_size=4).filter(any))
def test_a_quaternion_that_is_not_unit_is_refused_with_the_unit_one(values):
    norm = np.linalg.norm(values)
    if norm == 1.0:
        return
    with pytest.raises(ConfigError) as caught:
        read_quat(table(quat_wxyz=values))
    assert caught.value.key == "tool.quat_wxyz"
    assert f"got length {norm:.9g}" in caught.value.reason
    remedy = caught.value.reason.rpartition("write ")[2]
    written = [float(part) for part in remedy.strip("[]").split(",")]
    mended = read_quat(
        table(quat_wxyz=[int(x) if x == int(x) else Decimal(repr(x)) for x in written])
    )
    np.testing.assert_allclose(mended, np.array(values) / norm, atol=1e-8)


def test_a_vector_without_length_has_no_direction():
    with pytest.raises(ConfigError, match=r"got length 0; \[1, 0, 0, 0\] is no rotation"):
        read_quat(table(quat_wxyz=[0, 0, 0, 0]))
    with pytest.raises(ConfigError, match=r"tool.axis: .* got length 0; \[0, 0, 1\]"):
        read_axis(table(axis=[0, 0, 0]), "axis")


def test_an_axis_that_is_not_unit_is_refused_with_the_unit_one():
    with pytest.raises(
        ConfigError, match=r"length 2; if its direction is right, write \[0, 1, 0\]"
    ):
        read_axis(table(axis=[0, 2, 0]), "axis")


def test_an_orientation_stands_once():
    with pytest.raises(ConfigError, match=r"tool\.quat_wxyz: says again what rpy_deg says"):
        read_quat(table(quat_wxyz=[1, 0, 0, 0], rpy_deg=[0, 0, 0]))
