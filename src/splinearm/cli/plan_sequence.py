"""``splinearm plan`` of a job of pieces: its steps, how long they take and what they use."""

import argparse
import json
from typing import TYPE_CHECKING, Any

from .plan_document import SCHEMA

if TYPE_CHECKING:
    from splinearm.config import Cell, Job
    from splinearm.sequence import PlannedSequence, Step
    from splinearm.trajectories.plan import LimitPeak


def run(args: argparse.Namespace, job: "Job", cell: "Cell") -> int:
    """Plan all steps and print them."""
    from splinearm.errors import ConfigError
    from splinearm.sequence import plan_sequence

    for word, file in (("--save", args.save), ("--plot", args.plot)):
        if file is not None:
            reason = "is for one motion; this job is carried out step by step"
            raise ConfigError(word, "", reason)
    planned = plan_sequence(job, cell)
    if args.json:
        print(json.dumps(_document(planned, args.job), indent=2))
    else:
        _print(planned)
    return 0


def _print(planned: "PlannedSequence") -> None:
    from .output import console, table

    job = planned.job
    console.print(f"{job.title} on {planned.cell.arm.name}")
    rows = [
        (str(i + 1), step.name, step.kind.value, f"{step.duration:.3f}", _use(step))
        for i, step in enumerate(planned.every_step)
    ]
    console.print(table(("step", "what", "kind", "s", "uses most"), rows))
    often = "again and again" if job.times is None else f"{job.times} times"
    words = "" if job.times == 1 else f"; {often}"
    gripper = ", besides what the gripper takes" if planned.uses_gripper else ""
    console.print(f"duration: {planned.duration:.3f} s{gripper}{words}")


def _use(step: "Step") -> str:
    peak = _highest(step)
    if peak is None:
        return ""
    return f"{abs(peak.value / peak.limit):.0%} {peak.quantity} of {peak.joint}"


def _highest(step: "Step") -> "LimitPeak | None":
    """Give where a motion is nearest to the limit of a rate that the arm has."""
    from splinearm.trajectories.limit import MotionLimits
    from splinearm.trajectories.peak import peaks

    if step.planned is None:
        return None
    limits = MotionLimits(joints=step.planned.cell.arm.limits)
    rates = peaks(step.planned.plan.trajectory, limits)
    return max(
        (peak for peak in rates if peak.quantity != "position"),
        key=lambda peak: abs(peak.value / peak.limit),
    )


def _document(planned: "PlannedSequence", job: str) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "job": job,
        "arm": planned.cell.name,
        "duration_s": planned.duration,
        "times": planned.job.times,
        "steps": [_step(step) for step in planned.steps],
        "back": None if planned.back is None else _step(planned.back),
    }


def _step(step: "Step") -> dict[str, Any]:
    peak = _highest(step)
    most = None
    if peak is not None:
        share = abs(peak.value / peak.limit)
        most = {"joint": peak.joint, "quantity": peak.quantity, "share": share, "at_s": peak.t}
    return {
        "name": step.name,
        "kind": step.kind.value,
        "duration_s": step.duration,
        "uses_most": most,
    }
