"""``splinearm run PROGRAM.ngc``: carry out an NC program on an arm."""

import argparse
import json
import sys
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.arrays import FloatArray
    from splinearm.config import Cell, Job
    from splinearm.control.cycle import Cycle
    from splinearm.machining import PlannedProgram
    from splinearm.runner import RunResult

_AUTO = "auto"

_SHOWN = 0.25
"""Time of the motion between two pictures of its progress, s."""


def add_words(parser: argparse.ArgumentParser) -> None:
    """Declare the words that only NC programs take."""
    group = parser.add_argument_group("NC programs (.ngc, .nc, .gcode, .tap, .cnc)")
    group.add_argument(
        "--place",
        default=None,
        metavar="X,Y,Z[,RX,RY,RZ]",
        help="where the program's coordinates are in the arm's base, mm and deg, or 'auto'; write "
        "--place=-100,0,50 where x is below 0",
    )
    group.add_argument(
        "--tools", type=Path, default=None, metavar="FILE", help="table of cutters (TOML)"
    )
    group.add_argument(
        "--tool-length-mm",
        type=float,
        default=0.0,
        metavar="MM",
        help="how far the tip is beyond the tool frame of the arm's file",
    )
    group.add_argument(
        "--turn-deg",
        type=float,
        default=None,
        metavar="DEG",
        help="keep the tool at this turn about its own axis (default: it is free)",
    )
    group.add_argument(
        "--limits-percent",
        type=float,
        default=100.0,
        metavar="PERCENT",
        help="share of the arm's speed limits that the program may use",
    )


def is_program(file: str) -> bool:
    """Tell whether a file is an NC program by its name."""
    # as in machining.SUFFIXES, which would load the planner
    return Path(file).suffix.lower() in (".ngc", ".nc", ".gcode", ".tap", ".cnc")


def run(args: argparse.Namespace) -> int:
    """Read a program, place, plan, move, report."""
    from splinearm.config import load_cell
    from splinearm.errors import ConfigError

    if args.arm is None:
        raise ConfigError("--arm", "", "an NC program says no arm; name one")
    if args.place is None:
        raise ConfigError(
            "--place", "", "an NC program says not where it lies; give x,y,z in mm, or auto"
        )
    cell = load_cell(args.arm)
    return run_job(_job(args, cell), cell, args)


def run_job(job: "Job", cell: "Cell", args: argparse.Namespace) -> int:
    """Carry out a job with a toolpath."""
    from .files import require_new

    require_new(rows=args.csv, picture=args.plot)
    require_new(rows=args.mcap)
    require_new(rows=args.json)
    planned = plan(job, cell, find=args.place == _AUTO)
    results = carry_out(planned, args)
    if args.plot is not None and results and results[0].recorder.cycles:
        from .run import draw

        draw(results[0], args.plot)
    return _code(planned, results)


def plan(job: "Job", cell: "Cell", *, find: bool) -> "PlannedProgram":
    """Plan a job with a toolpath, with a progress bar."""
    from splinearm.machining import plan_nc_job
    from splinearm.toolpaths.feed_report import report_feeds

    from .output import console, progress

    with progress() as bar:
        task = bar.add_task("planning", total=1.0)
        planned = plan_nc_job(
            job, cell, find=find, progress=lambda share: bar.update(task, completed=share)
        )
        bar.update(task, completed=1.0)
    for note in planned.placed.itinerary.notes:
        console.print(note)
    console.print(report_feeds(planned.placed, planned.parts).words)
    if find:
        console.print(f"placed: --place={_said(planned.placed.setting.T_base_work)}")
    return planned


def carry_out(planned: "PlannedProgram", args: argparse.Namespace) -> "tuple[RunResult, ...]":
    """Carry out a program with a progress bar and print what came of it."""
    from splinearm.backends import open_arm
    from splinearm.machining import carry_out_program, require_nobody

    from .motion_words import watching
    from .output import console, progress
    from .report import print_report

    job, cell = planned.jobs[0].job, planned.jobs[0].cell
    is_person = sys.stdin is not None and sys.stdin.isatty() and sys.stdout.isatty()
    if not is_person:
        require_nobody(planned)
    with (
        watching(args.udp, cell) as send,
        open_arm(
            cell, args.on, realtime=args.realtime, rate=job.rate, feedforward=job.feedforward
        ) as station,
    ):
        console.print(
            f"{args.job} on {cell.arm.name}, {station.where}: {planned.duration:.2f} s, "
            f"{planned.placed.itinerary.length * 1e3:.0f} mm"
        )
        bar = progress()
        bar.live.auto_refresh = False
        tasks = [
            bar.add_task("moving", total=part.plan.trajectory.duration) for part in planned.parts
        ]

        def show(part: int, cycle: "Cycle") -> None:
            send(cycle)
            if cycle.t - bar.tasks[part].completed >= _SHOWN:
                bar.update(tasks[part], completed=cycle.t)
                bar.refresh()

        with bar:
            results = carry_out_program(
                planned,
                station,
                _Terminal() if is_person else None,
                announce=console.print,
                observe=show,
                files=lambda part, kind: _numbered(getattr(args, kind), part),
            )
        for i, result in enumerate(results):
            print_report(result, _numbered(args.csv, i))
        if args.json is not None:
            documents = [result.document() for result in results]
            value = documents[0] if len(planned.parts) == 1 else {"parts": documents}
            args.json.write_text(json.dumps(value, indent=2) + "\n", encoding="utf-8")
    return results


def _job(args: argparse.Namespace, cell: "Cell") -> "Job":
    """Give what the command line says of a program as a job."""
    import numpy as np

    from splinearm.config.nc_program import NcProgram
    from splinearm.config.tool_table import load_tools
    from splinearm.errors import ConfigError
    from splinearm.machining import nc_job, parse_place
    from splinearm.toolpaths.setting import CLEARANCE
    from splinearm.units import DEG, MM

    from .words import rate_of

    if not 0.0 < args.limits_percent <= 100.0:
        raise ConfigError("--limits-percent", "", f"want 0 to 100, got {args.limits_percent:g}")
    if not 0.0 <= args.tool_length_mm < inf:
        raise ConfigError("--tool-length-mm", "", f"want at least 0, got {args.tool_length_mm:g}")
    if args.turn_deg is not None and not isfinite(args.turn_deg):
        raise ConfigError("--turn-deg", "", f"want a number, got {args.turn_deg:g}")
    try:
        work = np.eye(4) if args.place == _AUTO else parse_place(args.place)
    except ValueError as error:
        raise ConfigError("--place", "", str(error)) from error
    toolpath = NcProgram(
        file=Path(args.job),
        T_base_work=work,
        direction=np.array([0.0, 0.0, -1.0]),
        turn=None if args.turn_deg is None else args.turn_deg * DEG,
        clearance=CLEARANCE,
        tool_length=args.tool_length_mm * MM,
        tools={} if args.tools is None else load_tools(args.tools),
        inches=False,
    )
    rate = 100.0 if args.rate is None else rate_of(args.rate)
    return nc_job(toolpath, cell, rate=rate, limits_share=args.limits_percent / 100.0)


def _said(T: "FloatArray") -> str:
    """Say a pose as --place takes it."""
    from splinearm.kinematics import quaternion
    from splinearm.units import DEG, MM

    turn = quaternion.to_euler(quaternion.from_matrix(T[:3, :3]), "xyz") / DEG
    return ",".join(f"{value:.1f}" for value in (*(T[:3, 3] / MM), *turn))


class _Terminal:
    """The person at the terminal."""

    def ask(self, words: str) -> bool:
        """Have something done, and say whether to go on."""
        try:
            answer = input(f"{words}: go on? [y/N] ")
        except (EOFError, KeyboardInterrupt):
            return False
        return answer.strip().lower() in ("y", "yes")

    def go_on(self, result: "RunResult") -> bool:
        """Say whether a motion that was stopped shall go on from where it rests."""
        from .run import shall_go_on

        return shall_go_on(result)


def _numbered(file: Path | None, part: int) -> Path | None:
    """Give the file of a part: the first has the name that was given."""
    return file if file is None or part == 0 else file.with_stem(f"{file.stem}-{part + 1}")


def _code(planned: "PlannedProgram", results: "tuple[RunResult, ...]") -> int:
    from splinearm.control.ending import Outcome

    if results and results[-1].ending.fault is not None:
        raise results[-1].ending.fault
    finished = len(results) == len(planned.parts) and results[-1].outcome is Outcome.FINISHED
    return 0 if finished else 130
