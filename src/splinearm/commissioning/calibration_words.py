"""What a person is told to do with an arm: its poses and the directions of its joints, in words.

Forward is along x of the world, left along y, up along z: as an arm stands that is told so.
"""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics import Arm, DHConvention

_AXES = (("forward", "backward"), ("left", "right"), ("up", "down"))
_SEEN_FROM = (("the front", "behind"), ("its left", "its right"), ("above", "below"))

_MUCH, _LITTLE = 0.6, 0.2
"""A direction is named beside the main one if it is that much of it."""

_VISIBLE = 0.03
"""From that much motion of the tool on, m/rad, it is what a person watches."""

_SHORTEST = 0.01
"""A link shorter than that points nowhere, m."""


def direction_words(v: FloatArray) -> str:
    """Give a direction in the world in words, as in "up, a little forward"; ``v`` of any length."""
    order = np.argsort(-np.abs(v), kind="stable")
    names = [_AXES[axis][int(v[axis] < 0.0)] for axis in order]
    main, second = (abs(float(v[axis])) for axis in order[:2])
    if second > _MUCH * main:
        return f"{names[0]} and {names[1]}"
    return f"{names[0]}, a little {names[1]}" if second > _LITTLE * main else names[0]


def growth_words(arm: Arm, q: FloatArray, i: int) -> str:
    """Give in words how to turn a joint so that its angle grows.

    Args:
        arm: The arm.
        q: Where it is, shape (n,), rad.
        i: Number of the joint.
    """
    R_world_base = arm.T_world_base[:3, :3]
    J = arm.jacobian(q)
    v, axis = R_world_base @ J[:3, i], R_world_base @ J[3:, i]
    if float(np.linalg.norm(v)) > _VISIBLE:
        return f"so that the tool goes {direction_words(v)}"
    k = int(np.argmax(np.abs(axis)))
    # who looks against an axis sees a positive turn about it go counter-clockwise
    turn = "counter-clockwise" if axis[k] > 0.0 else "clockwise"
    return f"{turn}, seen from {_SEEN_FROM[k][0]}"


def pose_words(arm: Arm, q: FloatArray, i: int) -> str:
    """Give in words where a joint is in a pose: where what it moves points.

    Args:
        arm: The arm.
        q: The pose, shape (n,), rad.
        i: Number of the joint.
    """
    R = arm.T_world_base[:3, :3]
    J, ends = arm.jacobian(q), _points(arm, q)
    # frame i of the standard convention stands at the far end of link i, else at its near end
    first = i if arm.convention is DHConvention.STANDARD else i + 1
    link, axis = R @ (ends[first + 1] - ends[first]), R @ J[3:, i]
    length = float(np.linalg.norm(link))
    if length >= _SHORTEST and abs(float(link @ axis)) < 0.9 * length:
        to = arm.joint_names[i + 1] if i + 1 < arm.n else "the tool"
        return f"from it to {to}: {direction_words(link)}"
    out = np.cross(R @ J[:3, i], axis)  # from the axis to the tool
    if float(np.linalg.norm(out)) >= _SHORTEST:
        return f"from it to the tool: {direction_words(out)}"
    if i + 1 < arm.n:
        across = direction_words(R @ J[3:, i + 1])
        return f"the axis of {arm.joint_names[i + 1]} points {across}, or the other way"
    return f"the tool's y axis points {direction_words(R @ arm.fk(q)[:3, 1])}"


def _points(arm: Arm, q: FloatArray) -> list[FloatArray]:
    """Give the origins of base frame, link frames and tool in base, each of shape (3,), m."""
    frames = [frame[:3, 3] for frame in arm.frames(q)]
    return [arm.T_base_first[:3, 3], *frames, arm.fk(q)[:3, 3]]
