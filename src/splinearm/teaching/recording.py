"""What was measured while a hand led an arm."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray, frozen_array
from splinearm.joints import JointKind
from splinearm.kinematics.arm import Arm


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Recording:
    """Joint positions by time."""

    names: tuple[str, ...]
    """The joints, base to tool."""
    t: FloatArray
    """When, rising, shape (k,), s."""
    q: FloatArray
    """Joint positions, shape (k, n), rad or m."""
    lost: int = 0
    """How many readings were lost between them."""

    def __post_init__(self) -> None:
        t = frozen_array(self.t, (None,), "t")
        if (np.diff(t) <= 0.0).any():
            raise ValueError("t: want times that rise")
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "q", frozen_array(self.q, (len(t), len(self.names)), "q"))

    @property
    def duration(self) -> float:
        """How long it is, s."""
        return float(self.t[-1] - self.t[0]) if len(self.t) else 0.0

    def between(self, start: float, end: float) -> "Recording":
        """Give what was measured from one time to another, both s since its beginning.

        Raises:
            ValueError: If the times do not rise, or are not within.
        """
        if not 0.0 <= start < end <= self.duration + 1e-9:
            raise ValueError(
                f"want two rising times from 0 to {self.duration:.3f} s, got {start:g} and {end:g}"
            )
        since = self.t - self.t[0]
        inside = (since >= start - 1e-9) & (since <= end + 1e-9)
        return Recording(names=self.names, t=self.t[inside], q=self.q[inside], lost=self.lost)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Nearness:
    """How near a motion is to its recording."""

    tool: float = 1e-3
    """Of the tool, m."""
    joint: float = float(np.radians(0.5))
    """Of each joint that turns, rad; joints that slide have that of the tool."""

    def __post_init__(self) -> None:
        for name in ("tool", "joint"):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise ValueError(f"{name}: want a number above 0, got {value}")


class Ruler:
    """Measures how far joints are off, in shares of what they may be.

    Args:
        arm: The arm.
        nearness: What they may be.
    """

    def __init__(self, arm: Arm, nearness: Nearness) -> None:
        self._arm = arm
        self._tool = nearness.tool
        self.joint = np.array(
            [
                nearness.joint if kind is JointKind.REVOLUTE else nearness.tool
                for kind in arm.limits.kinds
            ]
        )
        """How far each joint may be off, shape (n,), rad or m."""

    def parts(self, q: FloatArray, wanted: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give how far the tool, m, and the joint that is farthest, as a share, are off, (k,)."""
        fk = self._arm.fk
        tool = np.linalg.norm(fk(q)[:, :3, 3] - fk(wanted)[:, :3, 3], axis=1)
        return tool, (np.abs(q - wanted) / self.joint).max(axis=1)

    def misses(self, q: FloatArray, wanted: FloatArray) -> FloatArray:
        """Give how far joints, (k, n), are off those wanted: 1 is as far as they may be, (k,)."""
        tool, joints = self.parts(q, wanted)
        return np.maximum(tool / self._tool, joints)

    def near(self, wanted: FloatArray) -> "NearRuler":
        """Give the same, quick, for joints near those wanted, shape (k, n)."""
        return NearRuler(wanted, self._arm.jacobian(wanted)[:, :3] / self._tool, self.joint)


class NearRuler:
    """Measures as ``Ruler`` does, but for what bends over the small ways between."""

    def __init__(self, wanted: FloatArray, jacobian: FloatArray, joint: FloatArray) -> None:
        self._wanted, self._jacobian, self._joint = wanted, jacobian, joint

    def misses(self, q: FloatArray, part: slice = slice(None)) -> FloatArray:
        """Give how far joints, shape (k, n), are off a part of those wanted, shape (k,)."""
        gap = q - self._wanted[part]
        way = (self._jacobian[part] @ gap[..., None])[..., 0]
        tool = np.sqrt((way * way).sum(axis=1))
        found: FloatArray = np.maximum(tool, (np.abs(gap) / self._joint).max(axis=1))
        return found
