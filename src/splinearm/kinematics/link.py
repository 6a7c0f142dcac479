"""A rigid link of an arm and the joint that moves it."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray, frozen_array
from splinearm.joints import JointKind

from . import space

_SYMMETRY_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Inertia:
    """How a rigid link resists being moved."""

    mass: float
    """Mass, kg, at least zero."""
    com: FloatArray
    """Centre of mass in the link frame, shape (3,), m."""
    tensor: FloatArray
    """Inertia about the centre of mass along the axes of the link frame, shape (3, 3), kg m2."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.mass) and self.mass >= 0.0):
            raise ValueError(f"mass: want a finite number of at least zero, got {self.mass}")
        object.__setattr__(self, "com", frozen_array(self.com, (3,), "com"))
        tensor = frozen_array(self.tensor, (3, 3), "tensor")
        scale = float(np.abs(tensor).max())
        if np.abs(tensor - tensor.T).max() > _SYMMETRY_TOLERANCE * scale:
            raise ValueError(f"tensor: want a symmetric matrix, got {tensor.tolist()}")
        if np.linalg.eigvalsh(tensor).min() < -_SYMMETRY_TOLERANCE * scale:
            raise ValueError(f"tensor: want no negative principal moment, got {tensor.tolist()}")
        object.__setattr__(self, "tensor", tensor)


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A rigid link and the joint that moves it against its parent.

    ``T_parent_link(q) = T_parent_joint @ motion(q) @ T_joint_link``, where the motion is a turn by
    q about z or a slide by q along z. Denavit-Hartenberg tables of either convention and frames
    from any other description all become links of this kind.
    """

    name: str
    """Name of the joint, by which users know it."""
    kind: JointKind
    """Whether the joint turns or slides."""
    T_parent_joint: FloatArray
    """Pose of the joint at q = 0 in the parent link, shape (4, 4); the joint acts on its z axis."""
    T_joint_link: FloatArray
    """Pose of the link frame in the moved joint frame, shape (4, 4)."""
    inertia: Inertia | None = None
    """Mass and inertia in the link frame; None: not known."""

    def __post_init__(self) -> None:
        for name in ("T_parent_joint", "T_joint_link"):
            T = space.frozen_rigid(getattr(self, name), f"link {self.name!r}: {name}")
            object.__setattr__(self, name, T)

    def matrix(self, q: float) -> FloatArray:
        """Give T_parent_link, shape (4, 4), at joint position ``q`` (rad, or m when it slides)."""
        if self.kind is JointKind.REVOLUTE:
            motion = space.rotation_z(q)
        else:
            motion = space.translation((0.0, 0.0, q))
        return self.T_parent_joint @ motion @ self.T_joint_link
