"""How work lies before an arm, and which way the arm's tool points."""

from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.kinematics import chain, space, structure
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.structure import ArmClass

TURNS = 72
"""So many turns of the tool about its axis are tried."""

CLEARANCE = 0.02
"""From how high above its first place the tool comes, m."""

_MOST_TURNS = 1000


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Setting:
    """How work lies before an arm."""

    T_base_work: FloatArray
    """Pose of the work's coordinates in the arm's base, shape (4, 4)."""
    direction: ArrayInput = (0.0, 0.0, -1.0)
    """Where the tool points, in coordinates of the work, shape (3,), of any length."""
    tool_axis: ArrayInput | None = None
    """Which direction of the tool frame that is, shape (3,), of any length; None: that of the axis
    of the last joint, if it turns the tool about itself, else x."""
    turn: float | None = None
    """Turn about it that is kept, rad; None: it is free."""
    turns: int = TURNS
    """How many turns are tried if it is free."""
    clearance: float = CLEARANCE
    """From how high above its first place the tool comes, m; 0: it starts there."""

    def __post_init__(self) -> None:
        work = space.frozen_rigid(self.T_base_work, "T_base_work")
        object.__setattr__(self, "T_base_work", work)
        object.__setattr__(self, "direction", _unit(self.direction, "direction"))
        if self.tool_axis is not None:
            object.__setattr__(self, "tool_axis", _unit(self.tool_axis, "tool_axis"))
        if self.turn is not None and not isfinite(self.turn):
            raise ValueError(f"turn: want a number, got {self.turn}")
        if not 1 <= self.turns <= _MOST_TURNS:
            raise ValueError(f"turns: want 1 to {_MOST_TURNS}, got {self.turns}")
        if not 0.0 <= self.clearance < inf:
            raise ValueError(f"clearance: want a length of at least 0, got {self.clearance}")

    @property
    def points(self) -> FloatArray:
        """Where the tool points in base, of length 1, shape (3,)."""
        points: FloatArray = self.T_base_work[:3, :3] @ np.asarray(self.direction)
        return points

    @property
    def lift(self) -> FloatArray | None:
        """From where the tool comes to its first place, in coordinates of the work, m."""
        return -self.clearance * np.asarray(self.direction) if self.clearance > 0.0 else None


@lru_cache(maxsize=64)
def class_of(arm: Arm) -> ArmClass:
    """Give the class of an arm."""
    return structure.find(arm.packed).kind


def tool_axis_of(arm: Arm, setting: Setting) -> FloatArray:
    """Give the tool's pointing axis in the tool frame, of length 1, shape (3,)."""
    if setting.tool_axis is not None:
        return np.asarray(setting.tool_axis)
    if class_of(arm) is ArmClass.PAN:
        return np.array([1.0, 0.0, 0.0])
    q = np.zeros(arm.n)
    frames = chain.joint_frames(arm.packed, q)
    T = arm.fk(q)
    axis = arm.jacobian(q)[3:, -1]
    towards = T[:3, 3] - frames[max(arm.n - 2, 0)][:3, 3]
    pointing: FloatArray = T[:3, :3].T @ (-axis if axis @ towards < -1e-9 else axis)
    # what is an axis of the frame but for rounding is that axis
    return _unit(np.round(pointing, 12), "tool_axis")


def standing(axis: FloatArray, points: FloatArray, turn: float) -> FloatArray:
    """Give how a tool stands whose axis points somewhere, by the turn about it, shape (3, 3).

    At turn 0 it is turned as little as can be from the base, about a level axis.
    """
    cross, cos = np.cross(axis, points), float(axis @ points)
    if np.linalg.norm(cross) > 1e-9:
        K = _cross(cross)
        R = np.eye(3) + K + K @ K / (1.0 + cos) if cos > -1.0 + 1e-12 else np.eye(3)
    elif cos > 0.0:
        R = np.eye(3)
    else:
        # turned over about any axis at right angles
        other = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        other /= np.linalg.norm(other)
        R = 2.0 * np.outer(other, other) - np.eye(3)
    turned: FloatArray = R @ rotations_about(axis, np.array([turn]))[0]
    return turned


def rotations_about(axis: FloatArray, angles: FloatArray) -> FloatArray:
    """Give the rotations about an axis of length 1 by angles, shape (m, 3, 3)."""
    K = _cross(axis)
    # Rodrigues' formula
    sin, cos = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    turned: FloatArray = np.eye(3) + sin * K + (1.0 - cos) * (K @ K)
    return turned


def _cross(v: FloatArray) -> FloatArray:
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _unit(value: ArrayInput, name: str) -> FloatArray:
    vector = frozen_array(value, (3,), name)
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        raise ValueError(f"{name}: want a direction, got {vector.tolist()}")
    unit: FloatArray = vector / length
    unit.flags.writeable = False
    return unit
