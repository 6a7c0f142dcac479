"""An arm at q = 0 with everything seen from its base: what every description of it agrees on.

Denavit-Hartenberg tables, screws, URDF and MJCF choose link frames each in their own way. Where
the joints are at q = 0, which way they move, what hangs on them and where the tool is, they share:
each is read into this form, and written from it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import copysign

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.joints import JointLimits

from . import body, chain, space
from .arm import Arm
from .link import Inertia, Link


@dataclass(frozen=True, slots=True, eq=False)
class Home:
    """Where the parts of an arm are in base at q = 0."""

    joints: FloatArray
    """Poses of the joints, each acting on its z axis, shape (n, 4, 4)."""
    tool: FloatArray
    """Pose of the tool, shape (4, 4)."""
    inertias: tuple[Inertia | None, ...]
    """Of the n links, about their centres of mass along the axes of base; None: not known."""


def home_of(arm: Arm) -> Home:
    """Give an arm at q = 0."""
    frames = chain.joint_frames(arm.packed, np.zeros(arm.n))
    links = [T @ link.T_joint_link for T, link in zip(frames[:-1], arm.links, strict=True)]
    inertias = tuple(
        None if link.inertia is None else body.moved(link.inertia, T)
        for link, T in zip(arm.links, links, strict=True)
    )
    return Home(frames[:-1], frames[-1], inertias)


def arm_at(
    name: str,
    home: Home,
    limits: JointLimits,
    *,
    T_world_base: ArrayInput | None = None,
    T_base_first: ArrayInput | None = None,
) -> Arm:
    """Give the arm that has this home; its link frames are those of the joints.

    Args:
        name: Name of the arm.
        home: Where its joints and its tool are in base at q = 0.
        limits: Names, kinds and limits of its joints.
        T_world_base: Where the arm stands in the world, shape (4, 4); None: identity.
        T_base_first: Pose of the first joint's parent frame in base, shape (4, 4); None: identity.
    """
    T_parent = np.eye(4) if T_base_first is None else np.asarray(T_base_first, dtype=np.float64)
    T_first, links = T_parent, []
    for i, T in enumerate(home.joints):
        known = home.inertias[i]
        inertia = None if known is None else body.moved(known, space.rigid_inverse(T))
        T_parent_joint = space.rigid_inverse(T_parent) @ T
        links.append(Link(limits.names[i], limits.kinds[i], T_parent_joint, np.eye(4), inertia))
        T_parent = T
    return Arm(
        name,
        tuple(links),
        limits,
        T_world_base=np.eye(4) if T_world_base is None else np.asarray(T_world_base, np.float64),
        T_base_first=T_first,
        T_flange_tool=space.rigid_inverse(T_parent) @ home.tool,
    )


def frame_on(
    axis: FloatArray, origin: Sequence[float] | FloatArray = (0.0, 0.0, 0.0)
) -> FloatArray:
    """Give a frame, shape (4, 4), with its z axis along a unit vector, at a point (the origin).

    Along the axes x, y and z, and against them, its numbers are exact.
    """
    # Duff et al., Building an orthonormal basis, revisited, J. Computer Graphics Techniques 6
    # (2017), listing 3
    x, y, z = (float(part) for part in axis)
    sign = copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    T = np.eye(4)
    T[:3, 0] = 1.0 + sign * x * x * a, sign * b, -sign * x
    T[:3, 1] = b, sign + y * y * a, -y
    T[:3, 2] = x, y, z
    T[:3, 3] = origin
    return T
