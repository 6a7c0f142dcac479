"""``splinearm run JOB`` for jobs of pieces, with a gripper, or in a loop."""

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.config import Cell, Job
    from splinearm.control.cycle import Cycle
    from splinearm.sequence import PlannedSequence, SequenceResult, Step, StepRun

    from .run import Files


def run_job(job: "Job", cell: "Cell", where: str, files: "Files", *, realtime: bool = False) -> int:
    """Plan, move, report; give the exit code."""
    from splinearm.sequence import plan_sequence

    from .run import exit_code

    return exit_code(carry_out(plan_sequence(job, cell), where, files, realtime=realtime))


def carry_out(
    planned: "PlannedSequence", where: str, files: "Files", *, realtime: bool = False
) -> "SequenceResult":
    """Carry out a sequence with its progress and print what came of it."""
    from splinearm.backends import open_arm
    from splinearm.sequence import carry_out_sequence, resume_sequence

    from .motion_bar import MotionBar
    from .motion_words import watching
    from .output import console
    from .run import Files, is_taken_up, shall_go_on

    job, cell = planned.job, planned.cell
    with (
        watching(files.udp, cell) as send,
        open_arm(
            cell, where, realtime=realtime, rate=job.rate, feedforward=job.feedforward
        ) as station,
    ):
        console.print(f"{job.title} on {cell.arm.name}, {station.where}: {_plan_words(planned)}")

        def show(step: "Step", cycle: "Cycle") -> None:
            bar.show(step, step.name, step.duration, cycle)

        with MotionBar(send) as bar:
            result = carry_out_sequence(
                planned,
                station,
                csv=files.csv,
                mcap=files.mcap,
                observe=show,
                announce=console.print,
            )
        _report(result, files)
        while shall_go_on(result):
            if not is_taken_up(result, station):
                continue
            with MotionBar(send) as bar:
                result = resume_sequence(result, station, observe=show, announce=console.print)
            _report(result, Files(json=files.json))
    return result


def _report(result: "SequenceResult", files: "Files") -> None:
    """Print what came of each step of the last round and of all; for programs write it."""
    from splinearm.control.ending import Outcome

    from .output import console, table

    rows = [_row(run) for run in result.runs]
    if rows:
        columns = ("step", "s", "tool off its path, mm", "cycles", "missed", "outcome")
        title = "" if result.planned.job.times == 1 else f"round {result.runs[-1].place.round + 1}"
        console.print(table(columns, rows, title or None))
    totals = result.totals
    console.print(
        f"in all: {_counted(result.rounds, 'round')}, {_counted(totals.motions, 'motion')}, "
        f"{totals.cycles} cycles, "
        f"{totals.missed} missed, {totals.unanswered} unanswered, late by "
        f"{totals.latest * 1e3:.3f} ms at worst; {result.seconds:.1f} s"
    )
    reason = result.ending.reason
    console.print(f"outcome: {result.outcome.value} ({reason.name}, {int(reason)})")
    if result.outcome is not Outcome.FINISHED:
        stopped = result.ending.stopped
        at = "" if stopped is None else f", {stopped.t:.3f} s of {stopped.trajectory.duration:.3f}"
        console.print(f"rests in {result.step.name!r}{at}")
    if files.csv is not None and files.csv.exists():
        console.print(f"rows: {files.csv}")
    if files.json is not None:
        files.json.write_text(json.dumps(result.document(), indent=2) + "\n", encoding="utf-8")


def _plan_words(planned: "PlannedSequence") -> str:
    times = planned.job.times
    often = {None: ", without end", 1: ""}.get(times, f", {times} times")
    motions = _counted(sum(step.planned is not None for step in planned.steps), "motion")
    besides = " and what the gripper takes" if planned.uses_gripper else ""
    return f"{motions}, {planned.duration:.2f} s{besides}{often}"


def _counted(count: int, word: str) -> str:
    return f"{count} {word}" if count == 1 else f"{count} {word}s"


def _row(run: "StepRun") -> tuple[str, ...]:
    from splinearm.units import MM

    state = run.grip
    said = run.ending.outcome.value
    if state is not None:
        said = f"{said}: {state.words}"
    motion = run.motion
    if motion is None or not motion.recorder.cycles:
        return (run.step.name, f"{run.seconds:.2f}", "", "", "", said)
    worst = motion.tracking.path_measured.worst
    loop = motion.loop
    return (
        run.step.name,
        f"{run.seconds:.2f}",
        f"{worst / MM:.3f}",
        str(loop.cycles),
        str(loop.missed),
        said,
    )
