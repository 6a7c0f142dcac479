"""Arms as products of exponentials: a screw for each joint and the pose of the tool at q = 0.

``T_base_tool(q) = exp(S1 q1) ... exp(Sn qn) T_base_tool(0)`` with the screws S in base, or
``T_base_tool(0) exp(B1 q1) ... exp(Bn qn)`` with the screws B in the tool frame. A screw is linear
first, then angular, shape (6,): (p x u, u) of a joint that turns about the unit vector u through
the point p, (u, 0) of one that slides along u. Some books and libraries write the angular part
first: ``to_angular_first`` and ``from_angular_first`` are the border to them.
"""

from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.joints import JointKind, JointLimits

from . import se3, space
from .arm import Arm
from .home import Home, arm_at, frame_on, home_of
from .link import Inertia

Frame: TypeAlias = Literal["base", "tool"]
"""In which frame screws are written, at q = 0."""

_UNIT_TOLERANCE = 1e-6


def screws_of(arm: Arm, frame: Frame = "base") -> FloatArray:
    """Give the screws of an arm's joints at q = 0, shape (n, 6), linear first, m and rad.

    Args:
        arm: The arm.
        frame: "base" or "tool": in which frame they are written.
    """
    home = home_of(arm)
    axes, points = home.joints[:, :3, 2], home.joints[:, :3, 3]
    turns = arm.packed.turns[:, None]
    linear = turns * np.cross(points, axes) + (1.0 - turns) * axes
    screws = np.concatenate((linear, turns * axes), axis=-1)
    return screws if _in_base(frame) else screws @ se3.adjoint(space.rigid_inverse(home.tool)).T


def product(screws: ArrayInput, T_base_tool: ArrayInput, q: ArrayInput) -> FloatArray:
    """Give the product of exponentials of screws in base, shape (..., 4, 4).

    Args:
        screws: In base at q = 0, shape (n, 6), linear first.
        T_base_tool: Pose of the tool at q = 0, shape (4, 4).
        q: Joint positions, shape (..., n), rad or m.
    """
    # Brockett, Robotic manipulators and the product of exponentials formula, 1984
    motions = se3.exp(np.asarray(screws, dtype=np.float64) * np.asarray(q, np.float64)[..., None])
    T = motions[..., 0, :, :]
    for i in range(1, motions.shape[-3]):
        T = T @ motions[..., i, :, :]
    return T @ np.asarray(T_base_tool, dtype=np.float64)


def from_screws(  # noqa: PLR0913 - all that is said of an arm this way
    name: str,
    screws: ArrayInput,
    T_base_tool: ArrayInput,
    limits: JointLimits,
    *,
    frame: Frame = "base",
    inertias: Sequence[Inertia | None] | None = None,
    T_world_base: ArrayInput | None = None,
) -> Arm:
    """Give the arm of a product of exponentials. Its link frames are on the joints' axes.

    Args:
        name: Name of the arm.
        screws: One a joint, base to tool, shape (n, 6), linear first, m and rad.
        T_base_tool: Pose of the tool at q = 0, shape (4, 4).
        limits: Names, kinds and limits of the joints.
        frame: "base" or "tool": in which frame the screws are written.
        inertias: Of each link at q = 0 in base, or None where not known.
        T_world_base: Where the arm stands in the world, shape (4, 4); None: identity.

    Raises:
        ValueError: If a screw is not of length 1, has a pitch, or does not do what its kind says.
    """
    array = frozen_array(screws, (limits.n, 6), "screws")
    tool = space.frozen_rigid(T_base_tool, "T_base_tool")
    known = (None,) * limits.n if inertias is None else tuple(inertias)
    if len(known) != limits.n:
        raise ValueError(f"inertias: want {limits.n} of them, one a joint, got {len(known)}")
    in_base = array if _in_base(frame) else array @ se3.adjoint(tool).T
    joints = [
        _joint_frame(screw, kind, joint)
        for screw, kind, joint in zip(in_base, limits.kinds, limits.names, strict=True)
    ]
    return arm_at(name, Home(np.array(joints), tool, known), limits, T_world_base=T_world_base)


def inertias_of(arm: Arm) -> tuple[Inertia | None, ...]:
    """Give the inertia of each link at q = 0 in base: what ``from_screws`` takes."""
    return home_of(arm).inertias


def to_angular_first(twist: ArrayInput) -> FloatArray:
    """Give twists or screws with their angular part first, shape (..., 6)."""
    return np.roll(np.asarray(twist, dtype=np.float64), 3, axis=-1)


def from_angular_first(twist: ArrayInput) -> FloatArray:
    """Give twists or screws, linear first, of ones with their angular part first (..., 6)."""
    return np.roll(np.asarray(twist, dtype=np.float64), 3, axis=-1)


def _in_base(frame: Frame) -> bool:
    if frame not in ("base", "tool"):
        raise ValueError(f"frame: want 'base' or 'tool', got {frame!r}")
    return frame == "base"


def _joint_frame(screw: FloatArray, kind: JointKind, name: str) -> FloatArray:
    """Give a frame with its z axis on the axis of a screw."""
    linear, angular = screw[:3], screw[3:]
    turning = kind is JointKind.REVOLUTE
    axis = angular if turning else linear
    length = float(np.linalg.norm(axis))
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        part = "angular" if turning else "linear"
        raise ValueError(
            f"joint {name!r}: want a screw with a {part} part of length 1, got {screw.tolist()}"
        )
    axis = axis / length
    rest = abs(axis @ linear) if turning else float(np.abs(angular).max())
    if rest > _UNIT_TOLERANCE:
        says = "one that turns without sliding" if turning else "one that slides without turning"
        raise ValueError(f"joint {name!r}: want {says}, got screw {screw.tolist()}")
    return frame_on(axis, np.cross(axis, linear) if turning else np.zeros(3))
