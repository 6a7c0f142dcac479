"""``splinearm run JOB``: carry out a job, a motion that was saved, or an NC program."""

import argparse
import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from . import run_program
from .motion_words import add_udp

if TYPE_CHECKING:
    from splinearm.backends import Station
    from splinearm.config import Cell, Job
    from splinearm.control.cycle import Cycle
    from splinearm.runner import PlannedJob, RunResult
    from splinearm.sequence import SequenceResult

_CODES = """exit codes, and error_code of the report as control_msgs/FollowJointTrajectory has it:
    0  SUCCESSFUL (0)                 the arm arrived within its goal tolerance
    1  PATH_TOLERANCE_VIOLATED (-4)   a joint left its path, or a fault stopped the arm on it
    1  GOAL_TOLERANCE_VIOLATED (-5)   a joint did not settle within its goal tolerance
    2  INVALID_GOAL (-1), INVALID_JOINTS (-2)   refused; nothing moved, no report is written
  130  GOAL_TOLERANCE_VIOLATED (-5)   stopped by Ctrl-C or SIGTERM, outcome "stopped\""""


@dataclass(frozen=True, slots=True, kw_only=True)
class Files:
    """What a run is written to."""

    csv: Path | None = None
    """Every cycle."""
    mcap: Path | None = None
    """Every cycle, for Foxglove and PlotJuggler."""
    json: Path | None = None
    """The report."""
    udp: str | None = None
    """HOST:PORT where every cycle is sent."""

    def require_new(self, picture: Path | None = None) -> None:
        """Refuse what could not be written in the end, before anything moves.

        Args:
            picture: Where the run is drawn.

        Raises:
            ConfigError: With a file that is there already, or is to hold two things.
        """
        from splinearm.errors import ConfigError

        from .files import require_new

        named = [file for file in (self.csv, self.mcap, self.json, picture) if file is not None]
        for file in named:
            if named.count(file) > 1:
                raise ConfigError(file, "", "cannot hold both; name two files")
        require_new(rows=self.csv, picture=picture)
        require_new(rows=self.mcap)
        require_new(rows=self.json)


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "run",
        help="carry out a job on a simulated or a real arm",
        description="Carry out a job, of one motion or of pieces with a gripper, or a motion that "
        "was saved. Ctrl-C slows the arm down along "
        "its path; it then holds. A person at a terminal is asked whether to go on from there.",
        epilog=_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "job",
        help="the job's TOML file, a motion (.json, .ros.json, .csv) or an NC program (.ngc)",
    )
    parser.add_argument(
        "--on",
        default="mujoco",
        metavar="WHERE",
        help="mujoco, virtual (servos on a virtual bus), or a serial port such as /dev/ttyUSB0 "
        "(default: mujoco)",
    )
    parser.add_argument(
        "--arm",
        default=None,
        help="use this arm file; it must be the job's arm. Motions in rows need it",
    )
    parser.add_argument("--rate", type=float, default=None, metavar="HZ", help="setpoints a second")
    parser.add_argument("--csv", type=Path, default=None, metavar="FILE", help="write every cycle")
    parser.add_argument(
        "--mcap",
        type=Path,
        default=None,
        metavar="FILE",
        help="write every cycle for Foxglove and PlotJuggler",
    )
    parser.add_argument(
        "--plot", type=Path, default=None, metavar="FILE", help="draw it (PNG, SVG, PDF)"
    )
    parser.add_argument(
        "--json", type=Path, default=None, metavar="FILE", help="write the report for programs"
    )
    parser.add_argument(
        "--realtime", action="store_true", help="let the MuJoCo arm keep pace with the clock"
    )
    add_udp(parser)
    run_program.add_words(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Plan, move, report."""
    from splinearm.config import load_cell
    from splinearm.runner import plan_job
    from splinearm.sequence import is_sequence

    if run_program.is_program(args.job):
        return run_program.run(args)
    files = Files(csv=args.csv, mcap=args.mcap, json=args.json, udp=args.udp)
    files.require_new(picture=args.plot)
    if Path(args.job).suffix.lower() == ".toml":
        job = read_job(args)
        cell = load_cell(job.arm)
        if job.program is not None:
            return run_program.run_job(job, cell, args)
        if is_sequence(job):
            return _run_sequence(job, cell, args, files)
        planned = plan_job(job, cell)
    else:
        planned = saved_motion(args)
    result = carry_out(planned, args.on, files, realtime=args.realtime)
    if args.plot is not None and result.recorder.cycles:
        draw(result, args.plot)
    return exit_code(result)


def _run_sequence(job: "Job", cell: "Cell", args: argparse.Namespace, files: Files) -> int:
    """Carry out a job of more than one motion."""
    from splinearm.errors import ConfigError

    from .run_sequence import run_job

    if args.plot is not None:
        raise ConfigError("--plot", "", "draws one motion, and this job is more; leave it out")
    return run_job(job, cell, args.on, files, realtime=args.realtime)


def read_job(args: argparse.Namespace) -> "Job":
    """Read a job with what the command line says besides."""
    from splinearm.config import load_job

    from .words import rate_of

    job = load_job(args.job, arm=args.arm)
    return job if args.rate is None else replace(job, rate=rate_of(args.rate))


def saved_motion(args: argparse.Namespace) -> "PlannedJob":
    """Read a motion that was saved and the arm that it is for."""
    from splinearm.config import load_cell, load_motion
    from splinearm.errors import ConfigError
    from splinearm.runner import plan_motion

    from .words import rate_of

    cell = None if args.arm is None else load_cell(args.arm)
    saved = load_motion(args.job, None if cell is None else cell.arm.limits)
    if cell is None and not saved.arm:
        raise ConfigError(args.job, "arm", "says no arm; name one with --arm")
    rate = 100.0 if args.rate is None else rate_of(args.rate)
    return plan_motion(saved, cell or load_cell(saved.arm), Path(args.job), rate)


def carry_out(
    planned: "PlannedJob", where: str, files: Files, *, realtime: bool = False
) -> "RunResult":
    """Carry out a job with a progress bar and print what came of it."""
    from splinearm.backends import open_arm
    from splinearm.runner import carry_out_job, resume

    from .motion_bar import MotionBar
    from .motion_words import watching
    from .output import console

    job, cell = planned.job, planned.cell
    with (
        watching(files.udp, cell) as send,
        open_arm(
            cell, where, realtime=realtime, rate=job.rate, feedforward=job.feedforward
        ) as station,
    ):
        left = planned.plan.trajectory.duration
        console.print(f"{job.title} on {cell.arm.name}, {station.where}: {left:.2f} s")

        def show(cycle: "Cycle") -> None:
            bar.show(planned, "moving", left, cycle)

        with MotionBar(send) as bar:
            result = carry_out_job(
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
            rest = result.ending.stopped
            left = 0.0 if rest is None else rest.trajectory.duration - rest.t
            with MotionBar(send) as bar:
                result = resume(result, station, observe=show, announce=console.print)
            _report(result, Files(json=files.json))
    return result


def _report(result: "RunResult", files: Files) -> None:
    """Print what came of a run; for programs write it."""
    from .report import print_report

    print_report(result, files.csv)
    if files.json is not None:
        files.json.write_text(json.dumps(result.document(), indent=2) + "\n", encoding="utf-8")


def shall_go_on(result: "RunResult | SequenceResult") -> bool:
    """Ask a person, if there is one, whether what was stopped shall go on."""
    from splinearm.control.ending import Outcome

    # of a stream that was closed from the begin there is nothing
    is_person = sys.stdin is not None and sys.stdin.isatty() and sys.stdout.isatty()
    if result.outcome is Outcome.FINISHED or not is_person:
        return False
    if result.ending.fault is not None:
        print(f"splinearm: {result.ending.fault}")
    try:
        answer = input("go on from where it rests? [y/N] ")
    except (EOFError, KeyboardInterrupt):
        return False
    return answer.strip().lower() in ("y", "yes")


def is_taken_up(result: "RunResult | SequenceResult", station: "Station") -> bool:
    """Take up the arm and its gripper again; if that cannot be done yet, say why."""
    from splinearm.control.comeback import take_up
    from splinearm.errors import BusError

    gripper, fault = station.gripper, result.ending.fault
    try:
        take_up(station.driver, fault)
        if gripper is not None and gripper.ready and fault is not None:
            for mended in gripper.recover():
                print(f"recovered: {mended}")
    except BusError as error:
        print(f"splinearm: {error}")
        return False
    return True


def draw(result: "RunResult", file: Path) -> None:
    """Draw a run and say where; the ending of the file says of which kind the picture is."""
    from splinearm.viewer.plot import plot_run

    from .output import console

    plot_run(file, result)
    console.print(f"picture: {file}")


def exit_code(result: "RunResult | SequenceResult") -> int:
    """Give 0 for what was finished, 130 for what a person stopped; raise what failed."""
    from splinearm.control.ending import Outcome

    if result.ending.fault is not None:
        raise result.ending.fault
    return 0 if result.outcome is Outcome.FINISHED else 130
