"""``splinearm toolpath``: a drawing becomes an NC program, read again and verified."""

import argparse
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from splinearm.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Callable

    from splinearm.config.toolpath_job import ToolpathJob
    from splinearm.toolpaths.action import Action
    from splinearm.toolpaths.drawing import Drawing
    from splinearm.toolpaths.operation import Milling
    from splinearm.toolpaths.verify_report import Verification
    from splinearm.toolpaths.work import Done

_T = TypeVar("_T")
_KINDS = ("profile", "pocket", "zigzag", "spiral", "facing", "drill", "engrave")
_MM = 1e3
_RPM = 10_000.0


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "toolpath",
        help="make an NC program of a drawing",
        description="Make an NC program of a drawing (DXF or SVG) or of a job file (TOML). The "
        "program is read again and compared with the plan, and what it cuts is verified, before "
        "it is written. Lengths are in mm, feeds in mm/min.",
    )
    parser.add_argument("file", type=Path, help="the drawing, or a job file")
    parser.add_argument("-o", "--output", type=Path, default=None, help="the program to write")
    parser.add_argument("--preview", type=Path, default=None, help="a picture to draw")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--no-verify", action="store_true", help="do not verify what it cuts")
    one = parser.add_argument_group("one operation", "without a job file")
    one.add_argument("--operation", choices=_KINDS, default="profile", help="what is done")
    one.add_argument("--tool", type=float, default=None, help="diameter, with --tools its number")
    one.add_argument("--tools", type=Path, default=None, help="table of cutters (TOML)")
    one.add_argument("--side", choices=("outside", "inside", "on"), default="outside")
    one.add_argument("--layers", default="", help="names of layers, with commas between them")
    one.add_argument("--unit", default=None, help="unit of the drawing where it says none")
    one.add_argument("--dialect", default="linuxcnc", help="the controller: linuxcnc or grbl")
    one.add_argument("--tolerance", type=float, default=0.01, help="for splines and joining ends")
    _add_cutting(parser.add_argument_group("cutting"))
    parser.set_defaults(run=run_toolpath)


def _add_cutting(group: "argparse._ArgumentGroup") -> None:
    group.add_argument("--depth", type=float, default=None, help="how deep")
    group.add_argument("--step-down", type=float, default=None, help="depth of a pass")
    group.add_argument("--step-over", type=float, default=None, help="percent of the diameter")
    way = group.add_mutually_exclusive_group()
    way.add_argument("--climb", dest="climb", action="store_true", default=True)
    way.add_argument("--conventional", dest="climb", action="store_false")
    down = group.add_mutually_exclusive_group()
    down.add_argument("--ramp", type=float, default=None, metavar="DEG", help="enter on ramps")
    down.add_argument("--helix", type=float, default=None, metavar="DEG", help="enter on helices")
    group.add_argument("--lead", type=float, default=0.0, help="radius of lead-in and lead-out")
    group.add_argument("--blend", type=float, default=None, help="how far corners may be cut")
    group.add_argument("--stock", type=float, default=0.0, help="what is left on the sides")
    group.add_argument("--finish", action="store_true", help="take that off in a last pass")
    group.add_argument("--tabs", type=int, default=0, help="how many tabs a contour has")
    group.add_argument("--tab-length", type=float, default=5.0)
    group.add_argument("--tab-height", type=float, default=1.5)
    group.add_argument("--angle", type=float, default=0.0, help="direction of lines, degrees")
    group.add_argument("--peck", type=float, default=None, help="depth of a drill's step")
    group.add_argument("--feed", type=float, default=600.0, help="without --tools")
    group.add_argument("--plunge", type=float, default=200.0, help="without --tools")
    group.add_argument("--spindle", type=float, default=_RPM, help="turns per minute, as --feed")


def run_toolpath(args: argparse.Namespace) -> int:
    """Plan, check, write and tell."""
    from splinearm.toolpaths.checking import verified
    from splinearm.toolpaths.drawing import read_drawing
    from splinearm.toolpaths.fitting import fitted
    from splinearm.toolpaths.gcode_check import write_checked
    from splinearm.toolpaths.work import carry_out

    from .files import require_new

    require_new(rows=args.output, picture=args.preview)
    job = _job(args)
    with _steps(len(job.works) + 3, quiet=args.json) as step:
        drawing = _asked("--unit", lambda: read_drawing(job.drawing, job.unit))
        step("read")
        actions, done = _asked(
            "",
            lambda: carry_out(
                drawing, job.works, job.exactness, each=lambda one: step(str(one.work.kind))
            ),
        )
        actions = fitted(actions, job.dialect)
        program = write_checked(actions, job.dialect, f"{job.drawing.name} by splinearm")
        step("written and read again")
        found = None if args.no_verify else verified(actions, done, job.exactness.tolerance)
        step("verified")
    if found is None or found.ok:
        _write(args, program, actions, job.drawing.name)
    _tell(args, job, drawing, actions, done, found)
    return 0 if found is None or found.ok else 1


def _write(
    args: argparse.Namespace, program: str, actions: "tuple[Action, ...]", title: str
) -> None:
    if args.output is not None:
        args.output.write_text(program, encoding="ascii")
    if args.preview is not None:
        from splinearm.viewer.toolpath_plot import plot_toolpath

        plot_toolpath(args.preview, actions, title)


def _asked(option: str, call: "Callable[[], _T]") -> _T:
    """Turn what a wrong number is complained of into one line."""
    try:
        return call()
    except ValueError as error:
        raise ConfigError(option or "toolpath", "", str(error)) from error


@contextmanager
def _steps(count: int, *, quiet: bool) -> "Iterator[Callable[[str], None]]":
    """Give what is told of each step that is done, as a bar where somebody looks."""
    from .output import console, progress

    if quiet or not console.is_terminal:
        yield lambda name: None
        return
    with progress() as bar:
        task = bar.add_task("toolpath", total=count)
        yield lambda name: bar.update(task, advance=1, description=name)


def _job(args: argparse.Namespace) -> "ToolpathJob":
    """Give the job of a file, or the one operation that was asked for."""
    from splinearm.config.toolpath_job import ToolpathJob, layer_names, load_toolpath_job
    from splinearm.toolpaths.gcode_dialect import dialect_of
    from splinearm.toolpaths.operation import Side
    from splinearm.toolpaths.tab import Tabs
    from splinearm.toolpaths.work import Exactness, Kind, Work
    from splinearm.units import DEG, MM

    if args.file.suffix.lower() == ".toml":
        return load_toolpath_job(args.file)
    for name in ("tool", "depth"):
        if getattr(args, name) is None:
            raise ConfigError(f"--{name}", "", "is missing; give it, or a job file (TOML)")
    dialect = _asked("--dialect", lambda: dialect_of(args.dialect))

    def work() -> Work:
        tabs = None
        if args.tabs:
            tabs = Tabs(count=args.tabs, length=args.tab_length * MM, height=args.tab_height * MM)
        return Work(
            kind=Kind(args.operation),
            milling=_milling(args),
            layers=layer_names(args.layers),
            side=Side(args.side),
            tabs=tabs,
            angle=args.angle * DEG,
            peck=None if args.peck is None else args.peck * MM,
        )

    exactness = Exactness(
        joining=args.tolerance * MM, tolerance=args.tolerance * MM, splines=dialect.splines
    )
    works = (_asked("toolpath", work),)
    return ToolpathJob(
        drawing=args.file, unit=args.unit, dialect=dialect, exactness=exactness, works=works
    )


def _milling(args: argparse.Namespace) -> "Milling":
    from splinearm.config.tool_table import load_tools
    from splinearm.toolpaths.cutter import Cutter
    from splinearm.toolpaths.operation import Entry, Milling
    from splinearm.units import DEG, MM, RPM

    if args.tools is not None:
        tools = load_tools(args.tools)
        if args.tool not in tools:
            there = ", ".join(map(str, sorted(tools)))
            raise ConfigError("--tool", "", f"{args.tool:g} is not in the table; there are {there}")
        cutter = tools[int(args.tool)]
    else:
        diameter = args.tool * MM
        cutter = Cutter(
            number=0,
            name=f"{args.tool:g} mm",
            diameter=diameter,
            feed=args.feed * MM / 60.0,
            plunge=args.plunge * MM / 60.0,
            speed=args.spindle * RPM,
            step_down=0.5 * diameter if args.step_down is None else args.step_down * MM,
            step_over=0.4 * diameter,
        )
    steep = args.ramp if args.ramp is not None else args.helix
    entry = Entry.PLUNGE
    if steep is not None:
        entry = Entry.RAMP if args.ramp is not None else Entry.HELIX
    return Milling(
        cutter=cutter,
        depth=args.depth * MM,
        step_down=None if args.step_down is None else args.step_down * MM,
        step_over=None if args.step_over is None else 0.01 * args.step_over * cutter.diameter,
        climb=args.climb,
        entry=entry,
        ramp_angle=(3.0 if steep is None else steep) * DEG,
        lead=args.lead * MM,
        blend=None if args.blend is None else args.blend * MM,
        stock=args.stock * MM,
        finish=args.finish,
    )


def _tell(
    args: argparse.Namespace,
    job: "ToolpathJob",
    drawing: "Drawing",
    actions: "tuple[Action, ...]",
    done: "tuple[Done, ...]",
    found: "Verification | None",
) -> None:
    from .toolpath_report import document, print_report

    if args.json:
        print(json.dumps(document(job, drawing, actions, done, found), indent=2))
    else:
        print_report(job, drawing, actions, done, found)
        if args.output is not None and (found is None or found.ok):
            from .output import console

            console.print(f"written: {args.output}", markup=False, highlight=False)
