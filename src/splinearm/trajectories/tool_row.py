"""What limits of the tool mean on a path: its speed, its turning, and their changes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits
from splinearm.kinematics.arm import Arm

from .constraint import SpeedCap, on_cells
from .joint_path import JointPath
from .limit import MotionLimits
from .sampled_row import CAP_SHARES, SHARES, Lines, SampledLimit, lines_of, motion
from .torque_row import Torque

_LOOKS = np.linspace(0.0, 1.0, 11)
"""Where in each cell speeds are looked at."""

_FEW_LOOKS = np.array([0.0, 0.12, 0.23, 0.5, 0.77, 0.88, 1.0])
"""Where in each cell accelerations are looked at."""

_SIDES = 24
"""So many sides stand for half a circle of accelerations: inside it, by 0.2 % at most."""

_ANGLES = (np.arange(_SIDES) + 0.5) * (np.pi / _SIDES)


@dataclass(frozen=True, slots=True, eq=False)
class Speed:
    """A highest speed, or angular speed, of the tool."""

    names: tuple[tuple[str, str], ...]
    """Tool and quantity."""
    used: Callable[[FloatArray, FloatArray], FloatArray]
    """Gives at nodes s and shares of cells how much of it ds/dt = 1 uses, (cells, shares)."""

    def on(self, s: FloatArray) -> "TakenSpeed":
        """Give it on the cells between nodes s."""
        return TakenSpeed(self, s)


class TakenSpeed:
    """A highest speed on a grid."""

    def __init__(self, speed: Speed, s: FloatArray) -> None:
        self._s = s
        self.squares: FloatArray | None = speed.used(s, CAP_SHARES)[:, :, None] ** 2
        self._looked_at = speed.used(s, _LOOKS)

    def lines(self, ease: FloatArray, ceiling: FloatArray) -> Lines | None:
        """Give nothing: a speed is a cap."""
        return None

    def follow(self, x: FloatArray) -> bool:
        """Give False: it is the same near every law."""
        return False

    def use(self, x: FloatArray) -> FloatArray:
        """Give the largest share of it that is used in each cell, shape (cells, 1)."""
        square, _ = motion(self._s, x, _LOOKS)
        used: FloatArray = (self._looked_at * np.sqrt(square)).max(axis=1, keepdims=True)
        return used


@dataclass(frozen=True, slots=True, eq=False)
class ToolAcceleration:
    """A highest acceleration, or angular acceleration, of the tool."""

    path: JointPath
    """The way of the joints."""
    arm: Arm
    """What carries the tool."""
    most: float
    """The acceleration, m/s2, or rad/s2."""
    first: int
    """First of the three rows of the Jacobian: 0 of the place, 3 of the turning."""
    names: tuple[tuple[str, str], ...]
    """Tool and quantity."""

    def on(self, s: FloatArray) -> "TakenAcceleration":
        """Give it on the cells between nodes s."""
        return TakenAcceleration(self, s)

    def derivatives(self, s: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give first and second derivatives by s in shares of it, each (cells, shares, 3)."""
        q, slope, bend = on_cells(self.path, s, shares)
        J = self.arm.jacobian(q)
        rows = slice(self.first, self.first + 3)
        change = np.einsum("cmij,cmj->cmi", J[..., rows, :], bend)
        change += _bent(J * slope[..., None, :])[..., rows]
        along = np.einsum("cmij,cmj->cmi", J[..., rows, :], slope)
        return along / self.most, change / self.most


class TakenAcceleration:
    """A highest acceleration on a grid."""

    squares: FloatArray | None = None

    def __init__(self, limit: ToolAcceleration, s: FloatArray) -> None:
        self._s = s
        along, change = limit.derivatives(s, SHARES)
        ahead = _unit(along[:, 1])
        across = change[:, 1] - np.sum(change[:, 1] * ahead, axis=1, keepdims=True) * ahead
        # the part of the acceleration across the way points to one side only: half a circle does
        normals = np.cos(_ANGLES)[:, None] * ahead[:, None]
        normals = normals + np.sin(_ANGLES)[:, None] * _unit(across)[:, None]
        self._push = np.einsum("cmi,cki->cmk", along, normals)
        self._bend = np.einsum("cmi,cki->cmk", change, normals)
        self._looked_at = limit.derivatives(s, _FEW_LOOKS)

    def lines(self, ease: FloatArray, ceiling: FloatArray) -> Lines | None:
        """Give the sides of a figure within the circle of allowed accelerations."""
        room = np.repeat(np.cos(0.5 * np.pi / _SIDES) / ease, _SIDES, axis=1)
        return lines_of(self._push, self._bend, room, self._s)

    def follow(self, x: FloatArray) -> bool:
        """Give False: it is the same near every law."""
        return False

    def use(self, x: FloatArray) -> FloatArray:
        """Give the largest share of it that is used in each cell, shape (cells, 1)."""
        along, change = self._looked_at
        square, push = motion(self._s, x, _FEW_LOOKS)
        total = along * push[:, :, None] + change * square[:, :, None]
        used: FloatArray = np.linalg.norm(total, axis=2).max(axis=1, keepdims=True)
        return used


def sampled_limits(
    path: JointPath, limits: JointLimits | MotionLimits, cap: SpeedCap | None
) -> list[SampledLimit]:
    """Give all limits on a path but velocities and accelerations of the joints."""
    found: list[SampledLimit] = []
    if cap is not None and np.isfinite(cap.speeds).any():
        found.append(Speed((("tool", "speed"),), cap.used))
    if not isinstance(limits, MotionLimits):
        return found
    full = limits.joints.torque_max
    if limits.dynamics is not None and full is not None:
        found.append(Torque(path, limits, limits.dynamics, full))
    arm = limits.arm
    if arm is None:
        return found
    for most, first, quantity in (
        (limits.tool_speed, 0, "speed"),
        (limits.tool_turn_rate, 3, "turn rate"),
    ):
        if most is not None:
            found.append(Speed((("tool", quantity),), _rate(path, arm, most, first)))
    for most, first, quantity in (
        (limits.tool_acceleration, 0, "acceleration"),
        (limits.tool_turn_acceleration, 3, "turn acceleration"),
    ):
        if most is not None:
            found.append(ToolAcceleration(path, arm, most, first, (("tool", quantity),)))
    return found


def _rate(
    path: JointPath, arm: Arm, most: float, first: int
) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Give what gives the tool's speed by s, in shares of the highest, at shares of cells."""

    def used(s: FloatArray, shares: FloatArray) -> FloatArray:
        q, slope, _ = on_cells(path, s, shares)
        J = arm.jacobian(q)[..., first : first + 3, :]
        rate: FloatArray = np.linalg.norm(np.einsum("cmij,cmj->cmi", J, slope), axis=2) / most
        return rate

    return used


def _bent(carried: FloatArray) -> FloatArray:
    """Give what turning joints add to second derivatives by s, shape (..., 6).

    Args:
        carried: What each joint adds to the first, the columns of J q', shape (..., 6, n).
    """
    # a joint's column is turned by the joints up to it, and changed by what those behind it move
    moved, turned = carried[..., :3, :], carried[..., 3:, :]
    turning = np.cumsum(turned, axis=-1)
    behind = np.sum(moved, axis=-1, keepdims=True) - np.cumsum(moved, axis=-1)
    linear = _summed_cross(turning, moved) + _summed_cross(turned, behind)
    return np.concatenate((linear, _summed_cross(turning, turned)), axis=-1)


def _summed_cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Give the sum over joints of vector products, shape (..., 3), of arrays (..., 3, n)."""
    (ax, ay, az), (bx, by, bz) = np.moveaxis(a, -2, 0), np.moveaxis(b, -2, 0)
    parts = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
    return np.stack([part.sum(axis=-1) for part in parts], axis=-1)


def _unit(v: FloatArray) -> FloatArray:
    """Give directions, shape (m, 3); of nothing, none."""
    length = np.linalg.norm(v, axis=1, keepdims=True)
    direction: FloatArray = v / np.where(length > 0.0, length, 1.0)
    return direction
