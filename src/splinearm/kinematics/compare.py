"""How two models of what should be the same arm differ, in words.

The two may stand on other bases, hold other tools, count their joints from elsewhere or the other
way round, and their links may be of other lengths. Frames on the common normals of the axes do not
know of the first four, so what they show of the links is real; what is left between the frames of
the two is base, tool, offsets and signs.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.joints import JointKind

from . import body, quaternion, space
from .arm import Arm
from .compare_words import (
    LENGTH,
    TURN,
    as_motion,
    first_axis,
    inertia_words,
    last_axis,
    limit_words,
    link_words,
    motion_words,
    name_words,
    placing_words,
)
from .dh_conversion import any_x, common_normals, frame_at
from .home import Home, home_of
from .link import Inertia

_EXACT, _PARALLEL = 1e-9, 5e-3
"""Axes of less than this apart, rad, count as parallel: at first, and as real arms have them."""
_PREFER = 1e-6
"""What a sign or a turn that need not be costs, beside m and rad that do not fit."""
_SAMPLES = 64


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Comparison:
    """How arm B differs from arm A. Both move alike where q_b = signs * q_a + offsets."""

    differences: tuple[str, ...]
    """What differs, a sentence each; empty: nothing does."""
    signs: FloatArray
    """1 or, where a joint of B counts the other way round, -1; shape (n,)."""
    offsets: FloatArray
    """Where B's joints are when A's are at zero, rad or m, shape (n,)."""
    T_base_b_base_a: FloatArray
    """Pose of A's base in B's base, shape (4, 4)."""
    T_tool_a_tool_b: FloatArray
    """Pose of B's tool in A's tool, shape (4, 4)."""
    position_off: float
    """How far the tools are apart at most when all this is taken into account, m."""
    orientation_off: float
    """How far they are turned against each other at most, rad."""

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.differences

    @property
    def same_motion(self) -> bool:
        """Whether base, tool, signs and offsets explain all that differs in how they move."""
        return self.position_off < LENGTH and self.orientation_off < TURN

    def q_b(self, q_a: ArrayInput) -> FloatArray:
        """Give the joint positions of B, shape (..., n), where it is as A is at ``q_a``."""
        moved: FloatArray = self.signs * np.asarray(q_a, dtype=np.float64) + self.offsets
        return moved


def compare(arm_a: Arm, arm_b: Arm) -> Comparison:
    """Say how two models of an arm differ.

    What cannot be told apart is said once: a base turned about the first joint's axis is a first
    joint that counts from elsewhere, and so it is with the tool and the last joint.

    Args:
        arm_a: One model.
        arm_b: The other, with as many joints.

    Raises:
        ValueError: If they have not the same number of joints or the joints do not move alike.
    """
    if arm_a.n != arm_b.n:
        raise ValueError(
            f"arms: want as many joints, got {arm_a.n} of {arm_a.name!r} and {arm_b.n} of "
            f"{arm_b.name!r}"
        )
    for i, (a, b) in enumerate(zip(arm_a.limits.kinds, arm_b.limits.kinds, strict=True)):
        if a is not b:
            raise ValueError(
                f"arms: want joints that move alike, but joint {i + 1} is {a.value} in "
                f"{arm_a.name!r} and {b.value} in {arm_b.name!r}"
            )
    exact = _compared(arm_a, arm_b, _EXACT)
    if exact.same_motion:
        return exact
    # axes that are parallel in one model and hardly off in the other have no near normals
    return min(exact, _compared(arm_a, arm_b, _PARALLEL), key=_left)


def _left(found: Comparison) -> float:
    """Give how much a comparison leaves unexplained; 1 rad counts as 0.1 m."""
    return found.position_off + 0.1 * found.orientation_off


def _compared(arm_a: Arm, arm_b: Arm, parallel: float) -> Comparison:
    """Compare two arms; axes of less than ``parallel`` rad apart count as parallel."""
    kinds = arm_a.limits.kinds
    home_a, home_b = home_of(arm_a), home_of(arm_b)
    frames_a, frames_b = (_frames(home, kinds, parallel) for home in (home_a, home_b))
    flips = _best_flips(frames_a, frames_b, kinds, home_a, home_b)
    frames_b = np.array([T @ _flip(*flip) for T, flip in zip(frames_b, flips, strict=True)])
    signs = np.array([-1.0 if z else 1.0 for z, _ in flips])
    rows_a, rows_b = _rows(frames_a), _rows(frames_b)
    offsets = _offsets(rows_a, rows_b, kinds, signs)
    base, tool = _outside(frames_a, frames_b, home_a, home_b)
    base, tool, offsets = _told_by_limits(arm_a, arm_b, base, tool, (signs, offsets))
    off = _left_over(arm_a, arm_b, (signs, offsets), base, tool)
    differences = [
        *name_words(arm_a, arm_b),
        *placing_words(arm_a, arm_b, base, tool),
        *motion_words(arm_a, signs, offsets),
        *link_words(arm_a, rows_a, rows_b, off),
        *limit_words(arm_a, arm_b, signs, offsets),
        *inertia_words(arm_a, _in_frames(home_a, frames_a), _in_frames(home_b, frames_b)),
    ]
    return Comparison(
        differences=tuple(differences),
        signs=signs,
        offsets=offsets,
        T_base_b_base_a=base,
        T_tool_a_tool_b=tool,
        position_off=off[0],
        orientation_off=off[1],
    )


def _frames(home: Home, kinds: tuple[JointKind, ...], parallel: float) -> FloatArray:
    """Give a frame on each axis that knows nothing of base and tool, shape (n, 4, 4)."""
    normals = common_normals(home, kinds, parallel)
    axes = home.joints[:, :3, 2]
    if len(axes) == 1:
        return frame_at(axes[0], any_x(axes[0]), normals.start)[None]
    feet = [*normals.near, normals.far[-1]]
    directions = [*normals.directions, normals.directions[-1]]
    return np.array([frame_at(*part) for part in zip(axes, directions, feet, strict=True)])


def _flip(z: int, x: int) -> FloatArray:
    """Give a half turn about x (which turns z round) and one about z (which turns x round)."""
    about_x = np.array((1.0, -1.0, -1.0, 1.0) if z else (1.0, 1.0, 1.0, 1.0))
    about_z = np.array((-1.0, -1.0, 1.0, 1.0) if x else (1.0, 1.0, 1.0, 1.0))
    return np.diag(about_x * about_z)


def _rows(frames: FloatArray) -> FloatArray:
    """Give alpha, a, theta, d that lead to each frame but the first, shape (n - 1, 4)."""
    T = space.rigid_inverse(frames[:-1]) @ frames[1:]
    alpha = np.arctan2(-T[:, 1, 2], T[:, 2, 2])
    theta = np.arctan2(-T[:, 0, 1], T[:, 0, 0])
    d = np.cos(alpha) * T[:, 2, 3] - np.sin(alpha) * T[:, 1, 3]
    return np.column_stack((alpha, T[:, 0, 3], theta, d))


def _best_flips(
    frames_a: FloatArray,
    frames_b: FloatArray,
    kinds: tuple[JointKind, ...],
    home_a: Home,
    home_b: Home,
) -> list[tuple[int, int]]:
    """Give for each frame of B whether to turn z and x round, so that it fits A best.

    Neighbours decide together what fits, so the best of all is the shortest path through them.
    """
    choices = list(product((0, 1), (0, 1)))
    rows_a = _rows(frames_a)
    turned = np.array([[T @ _flip(*choice) for choice in choices] for T in frames_b])
    cost = np.array([_turn(T @ space.rigid_inverse(frames_a[0])) for T in turned[0]])
    cost = cost + _PREFER * np.array([float(z) for z, _ in choices])
    came: list[list[int]] = []
    for i in range(1, len(frames_a)):
        ways = np.empty((4, 4))
        for here, there in product(range(4), range(4)):
            row = _rows(np.array([turned[i - 1, here], turned[i, there]]))[0]
            ways[here, there] = cost[here] + _misfit(row - rows_a[i - 1], kinds[i])
        came.append([int(k) for k in ways.argmin(axis=0)])
        cost = ways.min(axis=0) + _PREFER * np.array([float(z) for z, _ in choices])
    T_tool_a = space.rigid_inverse(frames_a[-1]) @ home_a.tool
    tools = [space.rigid_inverse(T) @ home_b.tool for T in turned[-1]]
    cost = cost + [_turn(space.rigid_inverse(T_tool_a) @ T) for T in tools]
    best = [int(np.argmin(cost))]
    for ways_back in reversed(came):
        best.append(ways_back[best[-1]])
    return [choices[k] for k in reversed(best)]


def _turn(T: FloatArray) -> float:
    """Give what a turn of base or tool costs."""
    quat = quaternion.from_matrix(T[:3, :3])
    return _PREFER * float(quaternion.to_axis_angle(quat)[1])


def _misfit(row: FloatArray, kind: JointKind) -> float:
    """Give how badly two rows fit, m and rad: what a joint's own motion changes hardly counts."""
    alpha, a, theta, d = np.abs((_wrapped(row[0]), row[1], _wrapped(row[2]), row[3]))
    fixed, free = (d, theta) if kind is JointKind.REVOLUTE else (theta, d)
    return float(alpha + a + fixed + _PREFER * free)


def _wrapped(angle: FloatArray) -> FloatArray:
    wrapped: FloatArray = np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
    return wrapped


def _offsets(
    rows_a: FloatArray, rows_b: FloatArray, kinds: tuple[JointKind, ...], signs: FloatArray
) -> FloatArray:
    """Give where B's joints are when A's are at zero; the first and the last are there as well."""
    offsets = np.zeros(len(signs))
    difference = rows_a - rows_b
    turning = np.array([kind is JointKind.REVOLUTE for kind in kinds[1:]], dtype=bool)
    offsets[1:] = np.where(turning, _wrapped(difference[:, 2]), difference[:, 3])
    offsets = signs * offsets
    offsets[np.abs(offsets) < 1e-14] = 0.0
    return np.asarray(offsets, dtype=np.float64)


def _outside(
    frames_a: FloatArray, frames_b: FloatArray, home_a: Home, home_b: Home
) -> tuple[FloatArray, FloatArray]:
    """Give the pose of A's base in B's, and of B's tool in A's."""
    base = frames_b[0] @ space.rigid_inverse(frames_a[0])
    T_tool_a_frame = space.rigid_inverse(home_a.tool) @ frames_a[-1]
    return base, T_tool_a_frame @ space.rigid_inverse(frames_b[-1]) @ home_b.tool


def _told_by_limits(
    arm_a: Arm,
    arm_b: Arm,
    base: FloatArray,
    tool: FloatArray,
    mapping: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give base, tool and offsets, a turn of base or tool laid to a joint if its limits say so.

    About its axis they can only be told apart by the limits, which move along with an offset.
    """
    signs, offsets = mapping
    offsets = offsets.copy()
    found = [base, tool]
    for place, i, T_joint in ((0, 0, first_axis(arm_a)), (1, arm_a.n - 1, last_axis(arm_a))):
        motion = as_motion(found[place], T_joint, arm_a.limits.kinds[i])
        if motion is None:
            continue
        moved = offsets[i] - signs[i] * motion
        if _limits_agree(arm_a, arm_b, i, signs[i], moved) and not _limits_agree(
            arm_a, arm_b, i, signs[i], offsets[i]
        ):
            offsets[i], found[place] = moved, np.eye(4)
    return found[0], found[1], offsets


def _limits_agree(arm_a: Arm, arm_b: Arm, i: int, sign: float, offset: float) -> bool:
    a, b = arm_a.limits, arm_b.limits
    low, high = sorted((sign * a.q_min[i] + offset, sign * a.q_max[i] + offset))
    return bool(np.isclose(low, b.q_min[i], 0.0, TURN) and np.isclose(high, b.q_max[i], 0.0, TURN))


def _left_over(
    arm_a: Arm,
    arm_b: Arm,
    mapping: tuple[FloatArray, FloatArray],
    base: FloatArray,
    tool: FloatArray,
) -> tuple[float, float]:
    """Give how far the tools are apart at most, m and rad, at many positions of the joints."""
    low = np.maximum(arm_a.limits.q_min, -np.pi)
    high = np.maximum(np.minimum(arm_a.limits.q_max, np.pi), low)
    q_a = np.random.default_rng(1).uniform(low, high, (_SAMPLES, arm_a.n))
    wanted = base @ arm_a.fk(q_a) @ tool
    got = arm_b.fk(mapping[0] * q_a + mapping[1])
    quats = (quaternion.from_matrix(T[:, :3, :3]) for T in (wanted, got))
    position = np.linalg.norm(wanted[:, :3, 3] - got[:, :3, 3], axis=-1).max()
    return float(position), float(quaternion.angle_between(*quats).max())


def _in_frames(home: Home, frames: FloatArray) -> list[Inertia | None]:
    """Give each link's inertia in its own frame of the comparison."""
    return [
        None if known is None else body.moved(known, space.rigid_inverse(T))
        for known, T in zip(home.inertias, frames, strict=True)
    ]
