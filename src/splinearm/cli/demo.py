"""``splinearm demo``: a 2R arm in MuJoCo draws a figure; no hardware, no files needed."""

import argparse
from pathlib import Path


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "demo",
        help="see an arm follow a B-spline, with nothing attached",
        description="A simulated two-joint arm draws a closed B-spline. Prints its tracking error "
        "and leaves a picture and a CSV in a new folder.",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("splinearm-runs"),
        metavar="FOLDER",
        help="folder in which a new one is made for this run (default: splinearm-runs)",
    )
    parser.add_argument(
        "--realtime", action="store_true", help="move at the pace of a real arm, to watch"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Run the shipped job and leave its picture and rows."""
    from splinearm.config import demo_job, load_cell
    from splinearm.runner import plan_job

    from .files import new_folder
    from .run import Files, carry_out, draw, exit_code

    folder = new_folder(args.out, "demo")
    job = demo_job()
    planned = plan_job(job, load_cell(job.arm))
    result = carry_out(planned, "mujoco", Files(csv=folder / "demo.csv"), realtime=args.realtime)
    if result.recorder.cycles:
        draw(result, folder / "demo.png")
    return exit_code(result)
