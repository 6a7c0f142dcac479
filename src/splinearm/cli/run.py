"""``splinearm run JOB``: carry out a job, or a motion that was saved."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.runner import PlannedJob, RunResult


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "run",
        help="carry out a job on a simulated or a real arm",
        description="Carry out a job, or a motion that was saved. Ctrl-C slows the arm down along "
        "its path; it then holds.",
    )
    parser.add_argument("job", help="the job's TOML file, or a motion (.json, .ros.json, .csv)")
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
        "--realtime", action="store_true", help="let the MuJoCo arm keep pace with the clock"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Plan, move, report."""
    from .files import require_new

    require_new(rows=args.csv, picture=args.plot)
    require_new(rows=args.mcap)
    is_job = Path(args.job).suffix.lower() == ".toml"
    planned = planned_job(args) if is_job else saved_motion(args)
    result = carry_out(planned, args.on, csv=args.csv, mcap=args.mcap, realtime=args.realtime)
    if args.plot is not None and result.recorder.cycles:
        draw(result, args.plot)
    return exit_code(result)


def planned_job(args: argparse.Namespace) -> "PlannedJob":
    """Read a job and plan it."""
    from splinearm.config import load_cell, load_job
    from splinearm.runner import plan_job

    from .words import rate_of

    job = load_job(args.job, arm=args.arm)
    if args.rate is not None:
        job = replace(job, rate=rate_of(args.rate))
    return plan_job(job, load_cell(job.arm))


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
    planned: "PlannedJob",
    where: str,
    *,
    csv: Path | None,
    realtime: bool,
    mcap: Path | None = None,
) -> "RunResult":
    """Carry out a job with a progress bar and print what came of it."""
    from splinearm.backends import open_arm
    from splinearm.errors import MotionError
    from splinearm.runner import run_job

    from .output import console, progress
    from .report import print_report

    job, cell = planned.job, planned.cell
    duration = planned.plan.trajectory.duration
    with open_arm(cell, where, realtime=realtime) as station:
        console.print(f"{job.title} on {cell.arm.name}, {station.where}: {duration:.2f} s")
        with progress() as bar:
            task = bar.add_task("moving", total=duration)
            try:
                result = run_job(
                    planned,
                    station,
                    csv=csv,
                    mcap=mcap,
                    observe=lambda cycle: bar.update(task, completed=min(cycle.t, duration)),
                    announce=console.print,
                )
            except MotionError:
                if csv is not None:
                    console.print(f"rows up to the fault: {csv}")
                raise
    print_report(result, csv)
    return result


def draw(result: "RunResult", file: Path) -> None:
    """Draw a run into a PNG and say so."""
    from splinearm.viewer.plot import plot_run

    from .output import console

    plot_run(file, result)
    console.print(f"picture: {file}")


def exit_code(result: "RunResult") -> int:
    """Give 0 for a finished motion, 130 for one that was stopped by a person."""
    from splinearm.control.follow import Outcome

    return 0 if result.outcome is Outcome.FINISHED else 130
