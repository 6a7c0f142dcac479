"""Which time law a path gets: that of the limits."""

from dataclasses import replace

from splinearm.joints import JointLimits

from . import timing
from .constraint import SpeedCap
from .joint_path import JointPath
from .limit import MotionLimits
from .section import Law
from .smooth_timing import quickest_smooth


def quickest_law(
    path: JointPath,
    limits: JointLimits | MotionLimits,
    span: tuple[float, float] | None = None,
    cap: SpeedCap | None = None,
) -> Law:
    """Give the quickest time law on a path, from rest to rest; smooth if jerk is limited.

    Args:
        path: The way of the joints.
        limits: What joints, torques and tool may do.
        span: From where to where, by default the whole path.
        cap: How fast the tool may be along the path; with a limit of jerk the only limit of the
            tool that can be held.

    Raises:
        ValueError: If a limit of jerk comes with limits that no smooth law holds yet.
        TrajectoryError: As ``timing.quickest`` and ``smooth_timing.quickest_smooth``.
    """
    every = limits if isinstance(limits, MotionLimits) else MotionLimits(joints=limits)
    if every.joints.qddd_max is None:
        return timing.quickest(path, every, span, cap)
    require_smooth(every)
    return quickest_smooth(path, every.joints, span, cap)


def require_smooth(limits: MotionLimits) -> None:
    """Refuse limits that a law with limited jerk cannot hold.

    Raises:
        ValueError: Naming the limit.
    """
    if limits.joints.qddd_max is None:
        return
    rest = replace(limits, tool_speed=None)
    for name in ("tool_acceleration", "tool_turn_rate", "tool_turn_acceleration", "dynamics"):
        if getattr(rest, name) is not None:
            what = "torques" if name == "dynamics" else name
            raise ValueError(
                f"limits: {what} cannot be limited together with jerk (qddd_max); leave one out"
            )
