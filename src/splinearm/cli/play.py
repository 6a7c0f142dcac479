"""``splinearm play JOB``: carry out what was taught, at any share of the limits."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.config import Job

_CODES = """exit codes:
    0  all of it was carried out; with --loop: until Ctrl-C
    1  a fault stopped the arm on its path
    2  refused; nothing moved
  130  stopped by Ctrl-C or SIGTERM"""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "play",
        help="carry out what was taught",
        description="Carry out a job's pieces: motions that were taught, what the gripper does,\n"
        "motions that were saved. The way is the one that was led, at any pace. Ctrl-C\n"
        "slows the arm down along its path; it then holds.",
        epilog=_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("job", help="the job's TOML file, as `splinearm teach` writes it")
    parser.add_argument(
        "--on",
        default="mujoco",
        metavar="WHERE",
        help="mujoco, virtual (servos on a virtual bus), or a serial port such as /dev/ttyUSB0 "
        "(default: mujoco)",
    )
    parser.add_argument("--arm", default=None, help="use this arm file; it must be the job's arm")
    parser.add_argument(
        "--limits-percent",
        type=float,
        default=None,
        metavar="P",
        help="share of the arm's speed limits that it may use (default: the job's, or 100)",
    )
    parser.add_argument(
        "--timing",
        choices=("recorded", "fastest"),
        default=None,
        help="recorded: as it was led, slower only where limits want it; fastest: as quick as "
        "they allow (default: the job's)",
    )
    often = parser.add_mutually_exclusive_group()
    often.add_argument(
        "--times", type=int, default=None, metavar="N", help="how often (default: the job's, or 1)"
    )
    often.add_argument("--loop", action="store_true", help="again and again until Ctrl-C")
    parser.add_argument("--rate", type=float, default=None, metavar="HZ", help="setpoints a second")
    parser.add_argument("--csv", type=Path, default=None, metavar="FILE", help="write every cycle")
    parser.add_argument(
        "--json", type=Path, default=None, metavar="FILE", help="write the report for programs"
    )
    parser.add_argument(
        "--realtime", action="store_true", help="let the MuJoCo arm keep pace with the clock"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Plan, move, report."""
    from splinearm.config import load_cell
    from splinearm.sequence import plan_sequence

    from . import run_sequence
    from .run import Files, exit_code

    files = Files(csv=args.csv, json=args.json)
    files.require_new()
    job = _job(args)
    planned = plan_sequence(job, load_cell(job.arm))
    result = run_sequence.carry_out(planned, args.on, files, realtime=args.realtime)
    code = exit_code(result)
    return 0 if args.loop else code


def _job(args: argparse.Namespace) -> "Job":
    """Read the job with what the command line says besides."""
    from splinearm.config import load_job
    from splinearm.errors import ConfigError

    from .words import rate_of

    job = load_job(args.job, arm=args.arm)
    if job.program is not None:
        raise ConfigError(args.job, "toolpath", "is not played; use: splinearm run")
    if args.limits_percent is not None:
        if not 0.1 <= args.limits_percent <= 100.0:
            raise ConfigError(
                "--limits-percent", "", f"want 0.1 to 100, got {args.limits_percent:g}"
            )
        job = replace(job, limits_share=args.limits_percent / 100.0)
    if args.times is not None:
        if args.times < 1:
            raise ConfigError("--times", "", f"want 1 or more, got {args.times}")
        job = replace(job, times=args.times)
    if args.loop:
        job = replace(job, times=None)
    if args.timing is not None:
        job = replace(job, timing=args.timing)
    return job if args.rate is None else replace(job, rate=rate_of(args.rate))
