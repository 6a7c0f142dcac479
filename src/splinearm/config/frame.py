"""Positions, orientations and axes as files give them, as arrays."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics import Pose, quaternion

from .reader import Table

_UNIT_TOLERANCE = 1e-6
"""How far from 1 rounding in the file may carry the length of a unit vector."""


def read_quat(table: Table) -> FloatArray | None:
    """Give the orientation, w x y z, shape (4,); None if the table gives none.

    It stands as ``quat_wxyz``, or as ``rpy_deg``: roll, pitch and yaw about the fixed axes x, y
    and z in this order, as in a URDF.

    Raises:
        ConfigError: If it stands twice or the quaternion is not of length 1.
    """
    has_quat, has_rpy = "quat_wxyz" in table, "rpy_deg" in table
    if has_quat and has_rpy:
        raise table.refuse("quat_wxyz", "says again what rpy_deg says; take one of them out")
    if has_quat:
        return _unit(table, "quat_wxyz", 4, "[1, 0, 0, 0] is no rotation")
    if has_rpy:
        return quaternion.from_euler(table.numbers("rpy_deg", 3), "xyz")
    return None


def read_transform(table: Table) -> FloatArray:
    """Give the rigid transform of ``xyz_mm`` and an orientation, shape (4, 4).

    What the table does not give is zero or no rotation.
    """
    p = table.numbers("xyz_mm", 3) if "xyz_mm" in table else np.zeros(3)
    quat = read_quat(table)
    return Pose(p, np.array([1.0, 0.0, 0.0, 0.0]) if quat is None else quat).matrix()


def read_axis(table: Table, key: str) -> FloatArray:
    """Give a direction as a unit vector, shape (3,)."""
    return _unit(table, key, 3, "[0, 0, 1] is the z axis")


def _unit(table: Table, key: str, length: int, usual: str) -> FloatArray:
    """Read a vector that must have length 1, but for rounding in the file."""
    vector = table.numbers(key, length)
    norm = float(np.linalg.norm(vector))
    if abs(norm - 1.0) <= _UNIT_TOLERANCE:
        return np.asarray(vector / norm, dtype=np.float64)
    reason = f"wants numbers of length 1, got length {norm:.9g}"
    if norm == 0.0:
        raise table.refuse(key, f"{reason}; {usual}")
    unit = ", ".join(f"{part:.9g}" for part in vector / norm)
    raise table.refuse(key, f"{reason}; if its direction is right, write [{unit}]")
