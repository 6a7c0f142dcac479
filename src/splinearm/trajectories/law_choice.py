"""Which time law a path gets: that of the limits."""

from splinearm.joints import JointLimits

from . import timing
from .constraint import SpeedCap
from .joint_path import JointPath
from .limit import MotionLimits
from .section import Law
from .smooth_timing import quickest_smooth

CELLS = 200
"""On about so many cells a smooth law is sought."""


def quickest_law(
    path: JointPath,
    limits: JointLimits | MotionLimits,
    span: tuple[float, float] | None = None,
    cap: SpeedCap | None = None,
    cells: int = CELLS,
) -> Law:
    """Give the quickest time law on a path, from rest to rest; smooth if jerk is limited.

    Args:
        path: The way of the joints.
        limits: What joints, torques and tool may do.
        span: From where to where, by default the whole path.
        cap: How fast the tool may be along the path.
        cells: On about how many cells a smooth law is sought.

    Raises:
        TrajectoryError: As ``timing.quickest`` and ``smooth_timing.quickest_smooth``.
    """
    joints = limits.joints if isinstance(limits, MotionLimits) else limits
    if joints.qddd_max is None:
        return timing.quickest(path, limits, span, cap)
    return quickest_smooth(path, limits, span, cap, cells=cells)
