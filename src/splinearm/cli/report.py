"""What a run has to say for itself, as tables."""

from pathlib import Path
from typing import TYPE_CHECKING

from splinearm.units import DEG, MM

from .output import console, table

if TYPE_CHECKING:
    from splinearm.control.report import LoopReport, Spread
    from splinearm.joints import JointLimits
    from splinearm.runner import PlannedJob, RunResult
    from splinearm.trajectories.plan import Binding, LimitPeak

_PER_TIME = {"position": "", "velocity": "/s", "acceleration": "/s2", "jerk": "/s3"}


def print_report(result: "RunResult", csv: Path | None) -> None:
    """Print the errors of a run, the loop's timing, and where the rows are."""
    if not result.recorder.cycles:
        word = "failed" if result.ending.fault is not None else "stopped"
        console.print(f"outcome: {word} on the way to the start; there is nothing to report")
        return
    tracking, loop = result.tracking, result.loop
    rows = [
        ("tool off its path, commanded", *_in(tracking.path_commanded, MM), "mm"),
        ("tool off its path, measured", *_in(tracking.path_measured, MM), "mm"),
        ("tool behind its time", *_in(tracking.tool_lag, MM), "mm"),
        ("tool turned", *_in(tracking.tool_turn, DEG), "deg"),
        *(_joint_row(name, spread, result) for name, spread in tracking.joints),
    ]
    console.print(table(("tracking error", "rms", "worst", "unit"), rows))
    _print_loop(loop)
    reason = result.ending.reason
    console.print(f"outcome: {result.outcome.value} ({reason.name}, {int(reason)})")
    if result.ending.stopped is not None:
        console.print(f"rests on its path where it would have been at {_stopped_at(result)} s")
    if csv is not None:
        console.print(f"rows: {csv}")


def _stopped_at(result: "RunResult") -> str:
    stopped = result.ending.stopped
    return "" if stopped is None else f"{stopped.t:.3f} of {stopped.trajectory.duration:.3f}"


def _print_loop(loop: "LoopReport") -> None:
    """Print how well the loop kept its time and which servos made trouble."""
    late, busy = loop.lateness, loop.busy
    console.print(
        f"loop: {loop.cycles} cycles at {loop.rate:g} Hz, {loop.missed} missed, "
        f"{loop.unanswered} unanswered; late by {late.rms * 1e3:.3f} ms rms, "
        f"{late.p99 * 1e3:.3f} p99, {late.worst * 1e3:.3f} ms at worst; "
        f"busy {busy.rms * 1e3:.3f} ms rms, {busy.p99 * 1e3:.3f} p99, {busy.worst * 1e3:.3f} worst"
    )
    rows = [
        (
            *(str(one.servo_id), one.name, one.joint, str(one.reads)),
            *(str(one.timeouts), str(one.crc_errors), str(one.retries)),
        )
        for one in loop.servos
        if one.timeouts or one.crc_errors or one.retries
    ]
    if rows:
        columns = ("servo", "name", "joint", "asked", "no answer", "damaged", "asked again")
        console.print(table(columns, rows))


def _joint_row(name: str, spread: "Spread", result: "RunResult") -> tuple[str, ...]:
    unit, per = unit_of(result.planned.cell.arm.limits, name)
    return (f"joint {name}", *_in(spread, per), unit)


def print_plan(planned: "PlannedJob") -> None:
    """Print the duration of a plan and how much of each limit it uses at its peaks."""
    plan, limits = planned.plan, planned.cell.arm.limits
    console.print(f"duration: {plan.trajectory.duration:.3f} s")
    rows = [_peak_row(peak, limits) for peak in plan.peaks()]
    console.print(table(("joint", "quantity", "peak", "limit", "unit", "used", "at s"), rows))
    bound = [_binding_row(binding) for binding in plan.bindings()]
    if bound:
        console.print(table(("from s", "to s", "what holds it back", "used"), bound))


def _peak_row(peak: "LimitPeak", limits: "JointLimits") -> tuple[str, ...]:
    unit, per = _peak_unit(peak, limits)
    return (
        peak.joint,
        peak.quantity,
        f"{peak.value / per:.4g}",
        f"{peak.limit / per:.4g}",
        unit,
        f"{abs(peak.value / peak.limit):.1%}" if peak.limit else "-",
        f"{peak.t:.3f}",
    )


def _peak_unit(peak: "LimitPeak", limits: "JointLimits") -> tuple[str, float]:
    """Give the unit in which people read a peak, and how much of SI it is."""
    unit, per = unit_of(limits, peak.joint)
    if peak.quantity == "torque":
        return ("N" if unit == "mm" else "N m"), 1.0
    return unit + _PER_TIME[peak.quantity], per


def _binding_row(binding: "Binding") -> tuple[str, ...]:
    what = binding.quantity or "nothing that is looked at"
    if binding.joint is not None:
        what = f"{what} of {binding.joint}"
    return (f"{binding.start:.3f}", f"{binding.end:.3f}", what, f"{binding.share:.1%}")


def unit_of(limits: "JointLimits", joint: str) -> tuple[str, float]:
    """Give the unit in which people read a joint's position, and how much of SI it is."""
    linear = limits.kinds[limits.names.index(joint)].value == "prismatic"
    return ("mm", MM) if linear else ("deg", DEG)


def _in(spread: "Spread", unit: float) -> tuple[str, str]:
    return f"{spread.rms / unit:.4f}", f"{spread.worst / unit:.4f}"
