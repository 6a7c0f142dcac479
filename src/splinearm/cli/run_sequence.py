"""``splinearm run JOB`` for jobs of pieces, with a gripper, or in a loop."""

import json
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from splinearm.backends import Station
    from splinearm.config import Cell, Job
    from splinearm.control.cycle import Cycle
    from splinearm.sequence import PlannedSequence, SequenceResult, Step, StepRun

    from .run import Files

_SHOWN = 0.25
"""Time of a motion between two pictures of its progress, s."""


def run_job(job: "Job", cell: "Cell", where: str, files: "Files", *, realtime: bool = False) -> int:
    """Plan, move, report; give the exit code."""
    from splinearm.sequence import plan_sequence

    result = carry_out(plan_sequence(job, cell), where, files, realtime=realtime)
    return exit_code(result)


def carry_out(
    planned: "PlannedSequence", where: str, files: "Files", *, realtime: bool = False
) -> "SequenceResult":
    """Carry out a sequence with its progress and print what came of it."""
    from splinearm.backends import open_arm
    from splinearm.sequence import carry_out_sequence, resume_sequence

    from .motion_words import watching
    from .output import console
    from .run import Files

    job, cell = planned.job, planned.cell
    with (
        watching(files.udp, cell) as send,
        open_arm(
            cell, where, realtime=realtime, rate=job.rate, feedforward=job.feedforward
        ) as station,
    ):
        console.print(f"{job.title} on {cell.arm.name}, {station.where}: {_plan_words(planned)}")
        with _Bar(send) as bar:
            result = carry_out_sequence(
                planned,
                station,
                csv=files.csv,
                mcap=files.mcap,
                observe=bar.show,
                announce=console.print,
            )
        report(result, files)
        while _shall_go_on(result):
            if not _is_taken_up(result, station):
                continue
            with _Bar(send) as bar:
                result = resume_sequence(result, station, observe=bar.show, announce=console.print)
            report(result, Files(json=files.json))
    return result


def exit_code(result: "SequenceResult") -> int:
    """Give 0 for a finished sequence, 130 for one that a person stopped; raise what failed."""
    from splinearm.control.ending import Outcome

    if result.ending.fault is not None:
        raise result.ending.fault
    return 0 if result.outcome is Outcome.FINISHED else 130


def report(result: "SequenceResult", files: "Files") -> None:
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
        console.print(f"rests in {result.step.name!r}{at}", markup=False)
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


def _shall_go_on(result: "SequenceResult") -> bool:
    """Ask a person, if there is one, whether a stopped sequence shall go on."""
    from splinearm.control.ending import Outcome

    is_person = sys.stdin.isatty() and sys.stdout.isatty()
    if result.outcome is Outcome.FINISHED or not is_person:
        return False
    if result.ending.fault is not None:
        print(f"splinearm: {result.ending.fault}")
    try:
        answer = input("go on from where it rests? [y/N] ")
    except (EOFError, KeyboardInterrupt):
        return False
    return answer.strip().lower() in ("y", "yes")


def _is_taken_up(result: "SequenceResult", station: "Station") -> bool:
    """Take up the arm and its gripper again; if that cannot be done yet, say why."""
    from splinearm.control.comeback import take_up
    from splinearm.errors import BusError

    gripper = station.gripper
    try:
        take_up(station.driver, result.ending.fault)
        if gripper is not None and gripper.ready and result.ending.fault is not None:
            for fault in gripper.recover():
                print(f"recovered: {fault}")
    except BusError as error:
        print(f"splinearm: {error}")
        return False
    return True


class _Bar:
    """A progress bar of the motion that is under way, drawn only when it is told of a cycle."""

    def __init__(self, send: "Callable[[Cycle], object]") -> None:
        from .output import progress

        self._send = send

        self._bar = progress()
        self._bar.live.auto_refresh = False
        self._task = self._bar.add_task("moving", total=1.0)
        self._step: Step | None = None
        self._shown = 0.0

    def __enter__(self) -> "_Bar":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.refresh()
        self._bar.stop()

    def show(self, step: "Step", cycle: "Cycle") -> None:
        """Be as far as a cycle of a step, and pass it on."""
        self._send(cycle)
        t = cycle.setpoint.t
        if step is not self._step:
            self._step, self._shown = step, 0.0
            self._bar.update(self._task, description=step.name, total=step.duration, completed=0.0)
        if t - self._shown < _SHOWN:
            return
        self._shown = t
        self._bar.update(self._task, completed=min(t, step.duration))
        self._bar.refresh()
