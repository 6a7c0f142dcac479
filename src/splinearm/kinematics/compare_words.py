"""The sentences in which two models of an arm differ; lengths in mm, angles in degrees."""

from collections.abc import Iterator, Sequence
from math import inf

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.units import DEG, MM

from . import quaternion, space
from .arm import Arm
from .link import Inertia

LENGTH = 1e-8
"""Lengths that differ by less, m, are the same."""
TURN = 1e-8
"""Angles that differ by less, rad, are the same."""
_SHARE = 1e-6
"""Speeds, masses and the like that differ by a smaller share are the same."""


def name_words(arm_a: Arm, arm_b: Arm) -> Iterator[str]:
    """Say which joints have other names."""
    for i, (a, b) in enumerate(zip(arm_a.joint_names, arm_b.joint_names, strict=True)):
        if a != b:
            yield f"joint {i + 1} is called {a!r} in A and {b!r} in B"


def placing_words(arm_a: Arm, arm_b: Arm, base: FloatArray, tool: FloatArray) -> Iterator[str]:
    """Say how base and tool differ, and where the arms stand."""
    if not _is_identity(base):
        yield f"base: A's base, seen from B's, is {transform_words(base)}" + _alike(
            base, first_axis(arm_a), arm_a.joint_names[0], arm_a.limits.kinds[0]
        )
    if not _is_identity(tool):
        yield f"tool: B's tool, seen from A's, is {transform_words(tool)}" + _alike(
            tool, last_axis(arm_a), arm_a.joint_names[-1], arm_a.limits.kinds[-1]
        )
    world = space.rigid_inverse(arm_a.T_world_base) @ arm_b.T_world_base
    if not _is_identity(world):
        yield f"world: B's base stands elsewhere: seen from A's it is {transform_words(world)}"


def motion_words(arm_a: Arm, signs: FloatArray, offsets: FloatArray) -> Iterator[str]:
    """Say which joints count the other way round or from elsewhere."""
    for i, (name, kind) in enumerate(zip(arm_a.joint_names, arm_a.limits.kinds, strict=True)):
        moves = "turns" if kind is JointKind.REVOLUTE else "slides"
        if signs[i] < 0.0:
            yield f"{name}: sign: it {moves} the other way round in B"
        if abs(offsets[i]) > (TURN if kind is JointKind.REVOLUTE else LENGTH):
            formula = f"q_B = {'-' if signs[i] < 0.0 else ''}q_A"
            yield f"{name}: offset: {formula} {_signed(offsets[i], kind)}"


def link_words(
    arm_a: Arm, rows_a: FloatArray, rows_b: FloatArray, off: tuple[float, float]
) -> Iterator[str]:
    """Say which lengths and angles between neighbouring axes differ."""
    said = False
    kinds = arm_a.limits.kinds
    for i, (a, b) in enumerate(zip(rows_a, rows_b, strict=True)):
        pair = f"from {arm_a.joint_names[i]} to {arm_a.joint_names[i + 1]}"
        slides = kinds[i + 1] is JointKind.PRISMATIC
        rest = (
            ("the turn about the sliding axis (theta)", 2, JointKind.REVOLUTE)
            if slides
            else ("the offset along the axis (d)", 3, JointKind.PRISMATIC)
        )
        for what, column, kind in (
            ("the distance of the axes (a)", 1, JointKind.PRISMATIC),
            ("the angle between the axes (alpha)", 0, JointKind.REVOLUTE),
            rest,
        ):
            apart = b[column] - a[column]
            if kind is JointKind.REVOLUTE:
                apart = np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi
            if abs(apart) > (TURN if kind is JointKind.REVOLUTE else LENGTH):
                said = True
                have, other = _value(a[column], kind), _value(a[column] + apart, kind)
                yield f"link {pair}: {what} is {have} in A and {other} in B"
    if off[0] > LENGTH or off[1] > TURN:
        cause = "by these links" if said else "though no length between the axes differs"
        apart = f"{round(off[0] / MM, 6):.4g} mm and {round(off[1] / DEG, 6):.4g} deg"
        yield f"motion: {cause} the tools come apart by up to {apart}"


def limit_words(arm_a: Arm, arm_b: Arm, signs: FloatArray, offsets: FloatArray) -> Iterator[str]:
    """Say which limits differ, in B's own counting."""
    a, b = arm_a.limits, arm_b.limits
    ends = np.array([signs * a.q_min + offsets, signs * a.q_max + offsets])
    for i, (name, kind) in enumerate(zip(a.names, a.kinds, strict=True)):
        for what, have, other in (
            ("lowest", ends[:, i].min(), b.q_min[i]),
            ("highest", ends[:, i].max(), b.q_max[i]),
        ):
            if have != other and not abs(have - other) <= TURN:
                yield (
                    f"{name}: limit: the {what} position is {_value(have, kind)} in A "
                    f"{_counted(signs[i], offsets[i])}and {_value(other, kind)} in B"
                )
    for what, key, per in (
        ("speed", "qd_max", "/s"),
        ("acceleration", "qdd_max", "/s2"),
        ("jerk", "qddd_max", "/s3"),
        ("torque", "torque_max", None),
    ):
        yield from _rate_words(arm_a, what, getattr(a, key), getattr(b, key), per)


def inertia_words(
    arm_a: Arm, bodies_a: Sequence[Inertia | None], bodies_b: Sequence[Inertia | None]
) -> Iterator[str]:
    """Say which links have other masses, centres of mass or inertias."""
    for name, a, b in zip(arm_a.joint_names, bodies_a, bodies_b, strict=True):
        if a is None or b is None:
            if a is not b:
                yield f"{name}: mass: its link's is known in {'B' if a is None else 'A'} only"
            continue
        if abs(a.mass - b.mass) > _SHARE * max(a.mass, b.mass):
            yield f"{name}: mass: its link has {a.mass:.6g} kg in A and {b.mass:.6g} kg in B"
        apart = float(np.linalg.norm(a.com - b.com))
        if apart > 1e-6:
            yield f"{name}: mass: the centre of its link's mass is {apart / MM:.4g} mm away in B"
        largest = max(float(np.abs(a.tensor).max()), float(np.abs(b.tensor).max()))
        off = float(np.abs(a.tensor - b.tensor).max())
        if off > 1e-3 * largest:
            yield f"{name}: inertia: its link's differs by up to {100.0 * off / largest:.3g} %"


def transform_words(T: FloatArray) -> str:
    """Give a rigid transform in words."""
    parts = []
    p = T[:3, 3]
    if np.abs(p).max() > LENGTH:
        moves = [
            f"{value / MM:.6g} mm along {axis}"
            for value, axis in zip(p, "xyz", strict=True)
            if abs(value) > LENGTH
        ]
        parts.append("moved by " + ", ".join(moves))
    axis, angle = quaternion.to_axis_angle(quaternion.from_matrix(T[:3, :3]))
    if angle > TURN:
        main = int(np.argmax(np.abs(axis)))
        if abs(axis[main]) > 1.0 - 1e-9:
            sign = 1.0 if axis[main] > 0.0 or angle > np.pi - TURN else -1.0
            about = f"its {'xyz'[main]} axis"
            parts.append(f"turned by {sign * float(angle) / DEG:.6g} deg about {about}")
        else:
            about = ", ".join(f"{round(value, 6) + 0.0:.4g}" for value in axis)
            parts.append(f"turned by {float(angle) / DEG:.6g} deg about the direction ({about})")
    return " and ".join(parts) if parts else "where it is"


def first_axis(arm: Arm) -> FloatArray:
    """Give the pose of the first joint in base."""
    T: FloatArray = arm.packed.fixed[0]
    return T


def last_axis(arm: Arm) -> FloatArray:
    """Give the pose of the last joint in the tool."""
    return space.rigid_inverse(arm.packed.fixed[-1])


def as_motion(T: FloatArray, T_joint: FloatArray, kind: JointKind) -> float | None:
    """Give by how much a joint would move things as a transform does; None if it cannot.

    Args:
        T: The transform, shape (4, 4).
        T_joint: Pose of the joint where the transform is applied, shape (4, 4).
        kind: How it moves.
    """
    motion = space.rigid_inverse(T_joint) @ T @ T_joint
    if kind is JointKind.REVOLUTE:
        straight = np.abs(motion[:3, 2] - (0.0, 0.0, 1.0)).max() <= TURN
        if not straight or np.abs(motion[:3, 3]).max() > LENGTH:
            return None
        return float(np.arctan2(motion[1, 0], motion[0, 0]))
    turned = np.abs(motion[:3, :3] - np.eye(3)).max() > TURN
    if turned or np.abs(motion[:2, 3]).max() > LENGTH:
        return None
    return float(motion[2, 3])


def _alike(T: FloatArray, T_joint: FloatArray, name: str, kind: JointKind) -> str:
    """Say so if a joint could do the same: its zero and the frame beyond it are then one."""
    if as_motion(T, T_joint, kind) is None:
        return ""
    return f" (or {name} counts from elsewhere: the two are one)"


def _is_identity(T: FloatArray) -> bool:
    turned = np.abs(T[:3, :3] - np.eye(3)).max() > TURN
    return not turned and bool(np.abs(T[:3, 3]).max() <= LENGTH)


def _rate_words(
    arm: Arm, what: str, a: FloatArray | None, b: FloatArray | None, per: str | None
) -> Iterator[str]:
    if a is None or b is None:
        if a is not b:
            yield f"limits: {what} is limited in {'B' if a is None else 'A'} only"
        return
    for i, (name, kind) in enumerate(zip(arm.joint_names, arm.limits.kinds, strict=True)):
        if abs(a[i] - b[i]) > _SHARE * max(a[i], b[i]):
            turning = kind is JointKind.REVOLUTE
            if per is None:
                unit, scale = ("N m" if turning else "N"), 1.0
            else:
                unit, scale = ("deg" if turning else "mm") + per, DEG if turning else MM
            yield (
                f"{name}: limit: {what} {a[i] / scale:.6g} {unit} in A and "
                f"{b[i] / scale:.6g} {unit} in B"
            )


def _counted(sign: float, offset: float) -> str:
    return "" if sign > 0.0 and offset == 0.0 else "(counted as B does) "


def _value(value: float, kind: JointKind) -> str:
    if abs(value) == inf:
        return "without end"
    unit, per = ("deg", DEG) if kind is JointKind.REVOLUTE else ("mm", MM)
    return f"{value / per + 0.0:.7g} {unit}"


def _signed(value: float, kind: JointKind) -> str:
    return f"{'-' if value < 0.0 else '+'} {_value(abs(value), kind)}"
