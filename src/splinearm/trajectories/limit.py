"""What limits a motion: joints, torques and the tool."""

from dataclasses import dataclass, replace

import numpy as np

from splinearm.arrays import FloatArray, frozen_array
from splinearm.joints import JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dynamics import Dynamics


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class MotionLimits:
    """All that a time law may have to keep. What is None is not limited."""

    joints: JointLimits
    """Velocities and accelerations of the joints, and the torques that ``dynamics`` ask for."""
    dynamics: Dynamics | None = None
    """The arm with its load and friction: torques then stay within ``joints.torque_max``."""
    no_load_speed: FloatArray | None = None
    """Speed at which a joint's motor has no torque left to drive with, shape (n,), rad/s or m/s;
    below it the torque falls linearly with the speed. Braking it may use all of its torque."""
    arm: Arm | None = None
    """The arm whose tool is limited; None: that of ``dynamics``."""
    tool_speed: float | None = None
    """Highest speed of the tool, m/s."""
    tool_acceleration: float | None = None
    """Highest acceleration of the tool, along and across its way together, m/s2."""
    tool_turn_rate: float | None = None
    """Highest angular speed of the tool, rad/s."""
    tool_turn_acceleration: float | None = None
    """Highest angular acceleration of the tool, rad/s2."""

    def __post_init__(self) -> None:
        if self.dynamics is not None:
            if self.joints.torque_max is None:
                raise ValueError("dynamics: want joints with torque_max, got joints without")
            if self.arm is None:
                object.__setattr__(self, "arm", self.dynamics.arm)
        self._check_no_load_speed()
        for name in _TOOL:
            most = getattr(self, name)
            if most is not None and not 0.0 < most < np.inf:
                raise ValueError(f"{name}: want a finite number above zero, got {most}")
        if self.limits_tool and self.arm is None:
            raise ValueError("arm: limits of the tool need the arm that carries it, got None")
        for arm in (self.arm, None if self.dynamics is None else self.dynamics.arm):
            if arm is not None and arm.n != self.joints.n:
                raise ValueError(f"arm {arm.name!r}: want {self.joints.n} joints, got {arm.n}")

    def _check_no_load_speed(self) -> None:
        if self.no_load_speed is None:
            return
        value = frozen_array(self.no_load_speed, (self.joints.n,), "no_load_speed")
        if (value <= 0.0).any():
            raise ValueError(f"no_load_speed: want numbers above zero, got {value.tolist()}")
        if self.dynamics is None:
            raise ValueError("no_load_speed: it limits torques, which need dynamics")
        object.__setattr__(self, "no_load_speed", value)

    @classmethod
    def of(cls, arm: Arm, limits: "JointLimits | MotionLimits | None") -> "MotionLimits":
        """Give the limits of an arm's motion: the arm's own, or others with the arm's tool.

        Args:
            arm: The arm.
            limits: What its joints, or joints, torques and tool, may do; None: the arm's limits.

        Raises:
            ValueError: If they are of another number of joints.
        """
        joints = limits.joints if isinstance(limits, MotionLimits) else limits
        if joints is not None and joints.n != arm.n:
            raise ValueError(f"limits: want those of {arm.n} joints, got those of {joints.n}")
        if not isinstance(limits, MotionLimits):
            return cls(joints=arm.limits if limits is None else limits, arm=arm)
        return limits if limits.arm is not None else replace(limits, arm=arm)

    @property
    def limits_tool(self) -> bool:
        """Whether anything of the tool is limited."""
        return any(getattr(self, name) is not None for name in _TOOL)


_TOOL = ("tool_speed", "tool_acceleration", "tool_turn_rate", "tool_turn_acceleration")
