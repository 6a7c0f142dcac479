"""A plan for programs: values that JSON knows, in the units of files; None: nothing is limited."""

from math import isfinite
from typing import TYPE_CHECKING, Any

from .report import unit_of

if TYPE_CHECKING:
    from splinearm.joints import JointLimits
    from splinearm.runner import PlannedJob
    from splinearm.trajectories.plan import Binding, LimitPeak

SCHEMA = "splinearm-plan/1"
"""What the document says it is."""

_PER_TIME = {"position": "", "velocity": "_s", "acceleration": "_s2", "jerk": "_s3"}


def plan_document(planned: "PlannedJob", job: str) -> dict[str, Any]:
    """Give how long a plan takes, when its waypoints are passed, and what it uses of each limit.

    Args:
        planned: The plan.
        job: The file of the job.
    """
    plan, limits = planned.plan, planned.cell.arm.limits
    return {
        "schema": SCHEMA,
        "job": job,
        "arm": planned.cell.name,
        "duration_s": float(plan.trajectory.duration),
        "waypoint_times_s": [float(t) for t in plan.waypoint_times],
        "peaks": [_peak(peak, limits) for peak in plan.peaks()],
        "bindings": [_binding(binding) for binding in plan.bindings()],
    }


def _peak(peak: "LimitPeak", limits: "JointLimits") -> dict[str, Any]:
    unit, per = unit_of(limits, peak.joint)
    if peak.quantity == "torque":
        unit, per = ("n" if unit == "mm" else "nm"), 1.0
    else:
        unit += _PER_TIME[peak.quantity]
    is_limited = isfinite(peak.limit)
    return {
        "joint": peak.joint,
        "quantity": peak.quantity,
        "peak": float(peak.value / per),
        "limit": float(peak.limit / per) if is_limited else None,
        "unit": unit,
        "share": abs(float(peak.value / peak.limit)) if is_limited and peak.limit else None,
        "at_s": float(peak.t),
    }


def _binding(binding: "Binding") -> dict[str, Any]:
    return {
        "from_s": float(binding.start),
        "to_s": float(binding.end),
        "quantity": binding.quantity,
        "joint": binding.joint,
        "share": float(binding.share),
    }
