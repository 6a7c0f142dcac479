"""``splinearm plan JOB``: what a job's motion would be; nothing moves."""

import argparse
import json
from pathlib import Path


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "plan",
        help="show what a job's motion would be",
        description="Plan a job and show its duration and how much of each limit it uses. "
        "Nothing moves.",
    )
    parser.add_argument("job", help="the job's TOML file")
    parser.add_argument(
        "--plot", type=Path, default=None, metavar="FILE", help="draw it (PNG, SVG, PDF)"
    )
    parser.add_argument(
        "--save",
        type=Path,
        default=None,
        metavar="FILE",
        help="keep the motion: .json without loss, .ros.json as a ROS message, .csv as a table",
    )
    parser.add_argument(
        "--rate", type=float, default=None, metavar="HZ", help="rows a second in .ros.json and .csv"
    )
    parser.add_argument("--json", action="store_true", help="print it for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Plan and print."""
    from splinearm.config import load_cell, load_job, save_motion
    from splinearm.config.motion import check_motion_file
    from splinearm.runner import plan_job
    from splinearm.sequence import is_sequence

    from . import plan_sequence
    from .files import require_new
    from .output import console
    from .report import print_plan
    from .words import rate_of

    require_new(rows=args.save, picture=args.plot)
    if args.save is not None:
        check_motion_file(args.save)
    job = load_job(args.job)
    rate = job.rate if args.rate is None else rate_of(args.rate)
    cell = load_cell(job.arm)
    if is_sequence(job):
        return plan_sequence.run(args, job, cell)
    planned = plan_job(job, cell)
    if args.json:
        from .plan_document import plan_document

        print(json.dumps(plan_document(planned, args.job), indent=2))
    else:
        console.print(f"{job.title} on {planned.cell.arm.name}")
        print_plan(planned)
    if args.save is not None:
        save_motion(args.save, planned.plan.trajectory, arm=planned.cell.name, rate=rate)
    if args.plot is not None:
        from splinearm.viewer.plot import plot_plan

        plot_plan(args.plot, planned)
    for what, file in (("motion", args.save), ("picture", args.plot)):
        if file is not None and not args.json:
            console.print(f"{what}: {file}")
    return 0
