"""What ``splinearm gcode check --part`` asks: whether a program cuts the part it should."""

import argparse
from math import inf, pi
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.toolpaths.cutter import Cutter
    from splinearm.toolpaths.gcode_machine import NcMachine
    from splinearm.toolpaths.verify_part import Task
    from splinearm.toolpaths.verify_report import Verification

_MARGIN = 2.0
"""The block reaches so many diameters beyond the part."""

_BELOW = 1e-3


def add_words(check: argparse.ArgumentParser) -> None:
    """Declare the words of a verification."""
    group = check.add_argument_group(
        "verification", "compare what the program cuts with a part; all lengths in mm"
    )
    group.add_argument("--part", type=Path, metavar="FILE", help="drawing of the part (DXF or SVG)")
    group.add_argument("--layer", action="append", metavar="NAME", help="of that layer only")
    group.add_argument(
        "--side", choices=("outside", "inside", "pocket"), default="outside",
        help="cut along the outside or the inside of the outlines, or all that is inside "
        "(default: outside)",
    )  # fmt: skip
    group.add_argument("--depth", type=float, metavar="MM", help="how deep it is cut")
    group.add_argument("--top", type=float, default=0.0, metavar="MM", help="the surface")
    group.add_argument(
        "--tool", type=float, metavar="MM", help="diameter of the cutter, if no --tools are given"
    )
    group.add_argument(
        "--tabs", type=float, default=0.0, metavar="MM", help="how high tabs may be that are left"
    )
    group.add_argument(
        "--leave", type=float, default=0.01, metavar="MM", help="what may be left (default: 0.01)"
    )
    group.add_argument(
        "--gouge", type=float, default=0.001, metavar="MM",
        help="how far it may cut into the part (default: 0.001)",
    )  # fmt: skip
    group.add_argument("--cell", type=float, metavar="MM", help="how finely depth is looked at")


def verified(
    args: argparse.Namespace, machine: "NcMachine", cutters: "dict[int, Cutter]"
) -> "Verification | None":
    """Give what the program does to the part; None: no part is given.

    Raises:
        ConfigError: If a word is missing or makes no sense.
        ToolpathError: If the drawing or the program cannot be read.
    """
    from splinearm.errors import ConfigError
    from splinearm.toolpaths.verify import Allowance, verify_file

    if args.part is None:
        return None
    for name in ("depth", "tool"):
        given = getattr(args, name)
        if given is None and not (name == "tool" and cutters):
            raise ConfigError(f"--{name}", "", "is missing: --part wants it, in mm")
        if given is not None and not 0.0 < given < inf:
            raise ConfigError(f"--{name}", "", f"want a length above zero, got {given:g}")
    tools: Cutter | dict[int, Cutter] = cutters
    widest = max((cutter.diameter for cutter in cutters.values()), default=0.0)
    if args.tool is not None:
        tools, widest = _plain_cutter(args.tool * 1e-3), args.tool * 1e-3
    allowed = Allowance(
        gouge=args.gouge * 1e-3,
        left=args.leave * 1e-3,
        cell=None if args.cell is None else args.cell * 1e-3,
    )
    try:
        return verify_file(
            args.file,
            _task(args, widest),
            tools,
            allowed,
            machine=machine,
        )
    except ValueError as error:
        raise ConfigError(args.file, "", str(error)) from error


def _plain_cutter(diameter: float) -> "Cutter":
    """Give a cutter of which nothing but its diameter is known: it may do anything else."""
    from splinearm.toolpaths.cutter import Cutter

    most = 1e9
    return Cutter(
        number=0, name="cutter", diameter=diameter, feed=most, plunge=most, speed=2.0 * pi,
        step_down=most, step_over=diameter,
    )  # fmt: skip


def _task(args: argparse.Namespace, diameter: float) -> "Task":
    """Give the block about the part of a drawing and what shall be cut of it."""
    import numpy as np

    from splinearm.errors import DrawingError
    from splinearm.toolpaths.chain import chain
    from splinearm.toolpaths.drawing import read_drawing
    from splinearm.toolpaths.nesting import nested
    from splinearm.toolpaths.stock import Stock
    from splinearm.toolpaths.verify_part import Task, Zone

    drawing = read_drawing(args.part)
    if args.layer:
        drawing = drawing.on_layers(*args.layer)
    closed = [wire for wire in chain(drawing.pieces, 1e-5).wires if wire.closed]
    if not closed:
        raise DrawingError(str(args.part), "", "holds no closed outline")
    regions = nested(closed, 1e-6).regions
    top, depth, margin = args.top * 1e-3, args.depth * 1e-3, _MARGIN * diameter
    bounds = [region.bounds for region in regions]
    low = [min(b[i] for b in bounds) - margin for i in (0, 1)]
    high = [max(b[i] for b in bounds) + margin for i in (2, 3)]
    zone = Zone(
        regions=regions,
        floor=top - depth,
        side="outside" if args.side == "outside" else "inside",
        cleared=args.side == "pocket",
        tab_height=args.tabs * 1e-3,
    )
    stock = Stock(np.array([*low, top - depth - _BELOW]), np.array([*high, top]))
    return Task(stock, (zone,))
