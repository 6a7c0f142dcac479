"""``splinearm arms``: the arms that are shipped; one of them in full, compared, or mapped."""

import argparse
import json
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.kinematics import Arm
    from splinearm.kinematics.reach import ReachMap

_ARM = "a shipped arm, or a file: TOML, URDF (.urdf) or MJCF (.xml)"


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "arms",
        help="list the shipped arms; show, compare or map one",
        description="List the shipped arms, or look at one.",
    )
    parser.add_argument("--json", action="store_true", help="print it for programs")
    parser.set_defaults(run=run)
    looks = parser.add_subparsers(title="looks", metavar="LOOK")
    show = looks.add_parser(
        "show",
        help="its DH table, limits and reach",
        description="Show an arm: its DH table, its limits and how far it reaches.",
    )
    show.add_argument("arm", help=_ARM)
    show.add_argument(
        "--convention",
        choices=("standard", "modified"),
        default=None,
        help="of the DH table (default: the arm's own, or standard)",
    )
    _add_tip(show)
    show.add_argument("--plot", type=Path, default=None, metavar="FILE", help="draw a PNG")
    _add_json(show)
    show.set_defaults(run=run_show)
    compare = looks.add_parser(
        "compare",
        help="say how two models of an arm differ",
        description="Say in words how two models of the same arm differ. "
        "Exit code 0: not at all; 1: somehow.",
    )
    compare.add_argument("arm", metavar="A", help=_ARM)
    compare.add_argument("other", metavar="B", help="another")
    _add_tip(compare)
    compare.add_argument("--tip-b", default=None, metavar="NAME", help="the same for B")
    _add_json(compare)
    compare.set_defaults(run=run_compare)
    _add_reach(looks)


def _add_json(parser: argparse.ArgumentParser) -> None:
    # where it is not said here, what was said before the look stays
    parser.add_argument(
        "--json", action="store_true", default=argparse.SUPPRESS, help="print it for programs"
    )


def _add_tip(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--tip",
        default=None,
        metavar="NAME",
        help="of a URDF or MJCF: the link, body or site that is the tool",
    )


def _add_reach(looks: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    reach = looks.add_parser(
        "reach",
        help="map where it reaches",
        description="Map where an arm's tool can be, and in how many orientations.",
    )
    reach.add_argument("arm", help=_ARM)
    _add_tip(reach)
    reach.add_argument(
        "--spacing-mm", type=float, default=None, metavar="MM", help="of the points (default: 1/10)"
    )
    reach.add_argument(
        "--orientations", type=int, default=0, metavar="N", help="to try at each (default: none)"
    )
    reach.add_argument(
        "--processes", type=int, default=None, metavar="N", help="default: all cores"
    )
    reach.add_argument("--out", type=Path, default=None, metavar="FILE", help="write .npz or .csv")
    reach.add_argument("--plot", type=Path, default=None, metavar="FILE", help="draw a PNG")
    _add_json(reach)
    reach.set_defaults(run=run_reach)


def run(args: argparse.Namespace) -> int:
    """Print a row for each shipped arm."""
    from splinearm.config import load_cell, shipped_arms

    from .output import console, table

    cells = [load_cell(name) for name in shipped_arms()]
    if args.json:
        from .arm_document import list_document

        print(json.dumps(list_document(cells), indent=2))
        return 0
    rows = []
    for name, cell in zip(shipped_arms(), cells, strict=True):
        servos = cell.chain.servos if cell.chain is not None else ()
        models = sorted({servo.model for servo in servos})
        convention = cell.arm.convention.value if cell.arm.convention is not None else "frames"
        rows.append(
            (name, cell.title, str(cell.arm.n), str(len(servos)), ", ".join(models), convention)
        )
    console.print(
        table(("arm", "what it is", "joints", "servos", "servo models", "described by"), rows)
    )
    console.print("An arm of your own is one more TOML file: give its path where a name is asked.")
    return 0


def run_show(args: argparse.Namespace) -> int:
    """Print an arm's tables; draw it."""
    from splinearm.config import load_cell

    from .arm_report import print_arm
    from .files import require_new
    from .output import console

    require_new(picture=args.plot)
    cell = load_cell(args.arm, tip=args.tip)
    if args.json:
        from .arm_document import arm_document

        print(json.dumps(arm_document(cell, args.convention), indent=2))
    else:
        print_arm(cell, args.convention)
    if args.plot is not None:
        from splinearm.viewer.arm import plot_arm

        plot_arm(args.plot, cell.arm, cell.poses["home"], f"{cell.title}, at home")
        if not args.json:
            console.print(f"picture: {args.plot}")
    return 0


def run_compare(args: argparse.Namespace) -> int:
    """Print how two arms differ."""
    from splinearm.config import load_cell
    from splinearm.errors import ConfigError
    from splinearm.kinematics.compare import compare

    from .output import console

    a, b = load_cell(args.arm, tip=args.tip), load_cell(args.other, tip=args.tip_b)
    try:
        found = compare(a.arm, b.arm)
    except ValueError as error:
        raise ConfigError(args.other, "", str(error).removeprefix("arms: ")) from error
    if args.json:
        from .arm_document import comparison_document

        print(json.dumps(comparison_document(a, b, found), indent=2))
        return 0 if found.same else 1
    console.print(f"A: {a.title} ({a.file.name})\nB: {b.title} ({b.file.name})", highlight=False)
    for words in found.differences:
        console.print(f"  - {words}", highlight=False, markup=False)
    if found.same:
        console.print("They are the same.")
    elif found.same_motion:
        console.print("Base, tool, signs and offsets explain all that differs in how they move.")
    return 0 if found.same else 1


def run_reach(args: argparse.Namespace) -> int:
    """Compute a map with progress; write and draw it."""
    from splinearm.config import load_cell
    from splinearm.errors import ConfigError
    from splinearm.viewer.reach import plot_reach, write_reach

    from .arm_report import print_reach
    from .files import require_new
    from .output import console

    require_new(rows=args.out, picture=args.plot)
    if args.out is not None and args.out.suffix not in (".npz", ".csv"):
        raise ConfigError(args.out, "", "want a name that ends in .npz or .csv")
    found = _reach_map(load_cell(args.arm, tip=args.tip).arm, args)
    if args.json:
        from .arm_document import reach_document

        print(json.dumps(reach_document(found), indent=2))
    else:
        print_reach(found)
    if args.out is not None:
        write_reach(args.out, found)
    if args.plot is not None:
        plot_reach(args.plot, found)
    for what, file in (("map", args.out), ("picture", args.plot)):
        if file is not None and not args.json:
            console.print(f"{what}: {file}")
    return 0


def _reach_map(arm: "Arm", args: argparse.Namespace) -> "ReachMap":
    """Compute the map; a person sees how far it is."""
    import os

    from splinearm.errors import ConfigError
    from splinearm.kinematics.reach import reach_map
    from splinearm.units import MM

    from .output import progress

    with progress() if not args.json else nullcontext() as bar:
        task = None if bar is None else bar.add_task(f"where {arm.name} reaches", total=1.0)

        def tell(share: float) -> None:
            if bar is not None and task is not None:
                bar.update(task, completed=share)

        try:
            return reach_map(
                arm,
                spacing=None if args.spacing_mm is None else args.spacing_mm * MM,
                orientations=args.orientations,
                processes=args.processes if args.processes is not None else os.cpu_count() or 1,
                progress=tell,
            )
        except ValueError as error:
            raise ConfigError("reach", "", str(error)) from error
