"""A position and an orientation: one frame seen from another."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from . import quaternion, space

_UNIT_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """A rigid transform: where frame b is and how it is turned, seen from frame a."""

    p: FloatArray
    """Position, shape (3,), m."""
    quat: FloatArray
    """Orientation, unit quaternion w x y z, shape (4,)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "p", frozen_array(self.p, (3,), "p"))
        quat = frozen_array(self.quat, (4,), "quat")
        norm = float(np.linalg.norm(quat))
        if abs(norm - 1.0) > _UNIT_TOLERANCE:
            raise ValueError(
                f"quat: want a unit quaternion w x y z, got {quat.tolist()} of length {norm:.9g}"
            )
        object.__setattr__(self, "quat", frozen_array(quat / norm, (4,), "quat"))

    @classmethod
    def identity(cls) -> Self:
        """Give the pose of a frame in itself."""
        return cls(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))

    @classmethod
    def from_matrix(cls, T: ArrayInput) -> Self:
        """Give the pose of a rigid 4x4 transform on column vectors.

        Raises:
            ValueError: If it is not of that shape, not finite, or not rigid.
        """
        checked = space.frozen_rigid(T, "T")
        return cls(checked[:3, 3], quaternion.from_matrix(checked[:3, :3]))

    def matrix(self) -> FloatArray:
        """Give the same as a 4x4 transform on column vectors."""
        T = np.eye(4)
        T[:3, :3] = quaternion.to_matrix(self.quat)
        T[:3, 3] = self.p
        return T

    def inverse(self) -> Self:
        """Give the pose of frame a seen from frame b."""
        quat = quaternion.conjugate(self.quat)
        return type(self)(-quaternion.rotate(quat, self.p), quat)

    def apply(self, points: ArrayInput) -> FloatArray:
        """Give points of frame b, shape (..., 3), m, in frame a."""
        return self.p + quaternion.rotate(self.quat, points)

    def __matmul__(self, other: "Pose") -> "Pose":
        """Give pose ac of poses ab and bc."""
        if not isinstance(other, Pose):
            return NotImplemented
        return Pose(self.apply(other.p), quaternion.multiply(self.quat, other.quat))
