"""Which limit holds a time law back, and where."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.joints import JointLimits

from .constraint import SpeedCap
from .joint_path import JointPath
from .limit import MotionLimits
from .time_law import TimeLaw
from .timing_entry import torque_kernels
from .tool_row import sampled_limits

_LOOKS = np.linspace(0.0, 1.0, 5)
"""Where in each cell joints are looked at."""

_DIGITS = 3
"""Shares that agree to so many digits are alike."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LimitUse:
    """How much of each limit a time law uses in each of its cells."""

    law: TimeLaw
    """The law; its cells lie between ``law.s[i]`` and ``law.s[i + 1]``, ``law.t`` likewise."""
    limits: tuple[tuple[str, str], ...]
    """Joint, or "tool", and quantity of each limit: "acceleration", "torque", "velocity"; of the
    tool "speed", "turn rate", "acceleration", "turn acceleration"."""
    shares: FloatArray
    """Largest share of each limit in each cell, shape (cells, limits)."""

    @property
    def binding(self) -> IndexArray:
        """Which limit is used most in each cell, as an index, shape (cells,).

        Of those that are used alike it is what pushes, not the speed that is reached by it.
        """
        most: IndexArray = self.shares.round(_DIGITS).argmax(axis=1)
        return most

    def name(self, cell: int) -> tuple[str, str]:
        """Give joint (or "tool") and quantity of the limit that is used most in a cell."""
        return self.limits[int(self.shares[cell].round(_DIGITS).argmax())]


def limit_use(
    path: JointPath,
    limits: JointLimits | MotionLimits,
    law: TimeLaw,
    cap: SpeedCap | None = None,
) -> LimitUse:
    """Give how much of each limit a time law uses, cell by cell.

    Args:
        path: The way of the joints.
        limits: What limits the motion.
        law: How it is run through, as ``quickest`` gives it on this path.
        cap: How fast the tool may be along the path, if that was limited.

    Raises:
        HoldError: As of ``quickest``.
        ValueError: If the limits are of other joints.
    """
    joints = limits.joints if isinstance(limits, MotionLimits) else limits
    if joints.n != path.n:
        raise ValueError(f"limits: want those of {path.n} joints, got those of {joints.n}")
    sampled = sampled_limits(path, limits, cap)
    names = [(joint, "acceleration") for joint in joints.names]
    names += [name for limit in sampled for name in limit.names]
    names += [(joint, "velocity") for joint in joints.names]
    cells = len(law.s) - 1
    if cells == 0:
        return LimitUse(law=law, limits=tuple(names), shares=np.zeros((0, len(names))))
    motion = np.empty((3, cells, len(_LOOKS), path.n))
    torque_kernels().motion(path.breaks, path.coefficients, law.s, law.x, _LOOKS, motion)
    _, qd, qdd = np.abs(motion).max(axis=2)
    shares = [qdd / joints.qdd_max]
    shares += [limit.on(law.s).use(law.x) for limit in sampled]
    shares.append(qd / joints.qd_max)
    return LimitUse(law=law, limits=tuple(names), shares=np.concatenate(shares, axis=1))
