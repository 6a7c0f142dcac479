"""Verification: what a program does to its stock, measured by code that did not make it.

Two ways, independent of each other and of what plans toolpaths: in the plane the exact distances
of the ways to the part and of the part to the ways (`verify_plane`), and by depth the removal of
material from a map of heights (`verify_depth`). The first sees a nanometre and knows walls and
floors only; the second knows any shape of tool, what stands when, and rapid ways through it, and
sees what is larger than a cell.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from .action import Action, ArcFeed, Cutting, Feed, Move, Rapid, SplineFeed, ToolChange
from .cutter import Cutter
from .gcode_compensation import Unreached, compensate
from .gcode_dialect import Dialect
from .gcode_flow import read_program
from .gcode_interpreter import run_gcode
from .gcode_lint import lint
from .gcode_machine import NcMachine
from .stock import HeightMap, cell_for
from .verify_depth import height_faults, way_faults
from .verify_line import off_lines
from .verify_part import Task
from .verify_plane import Cuts, gouges, leftovers, too_deep
from .verify_report import Fault, Verification, worst
from .verify_way import track_of

Cutters = Cutter | Mapping[int, Cutter]
"""The cutter of a whole program, or cutters by the number that it takes them by."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Allowance:
    """What may differ from the part, and how finely it is looked at."""

    gouge: float = 1e-6
    """How far ways may cut into the part, m."""
    left: float = 1e-5
    """How much may be left of what shall go, m: what is left for later is added to it."""
    beside: float = 0.0
    """How much farther from walls than its radius a cutter may keep, m: what is reached from nearer
    to them only, in narrow corners and necks, may stay."""
    cell: float | None = None
    """Size of the cells of the map of heights, m; None: about 400 000 of them."""


def verify(
    actions: Iterable[Action],
    task: Task,
    cutters: Cutters,
    allowed: Allowance | None = None,
    *,
    faults: Iterable[Fault] = (),
) -> Verification:
    """Give what a program does to its stock.

    Args:
        actions: What the machine does, without marks of cutter compensation, in the coordinates
            of the task.
        task: The stock and what shall be made of it.
        cutters: The cutter, or several by number.
        allowed: What may differ.
        faults: What is known to be wrong already.

    Raises:
        ValueError: If ways are marked (G41), or a cutter is not known.
    """
    allowed = allowed or Allowance()
    moves, tools = _moves(actions, cutters)
    cuts = _cuts(moves, tools)
    beside = cuts.with_track(off_lines(cuts.track, task.lines, allowed.gouge))
    deepest, found = gouges(task, beside, allowed.gouge)
    found += too_deep(task, beside, allowed.gouge)
    rests = [leftovers(task, zone, cuts, (allowed.left, allowed.beside)) for zone in task.zones]
    found += [fault for rest in rests for fault in rest.faults]
    missed = [lines.left(cuts.track, allowed.gouge) for lines in task.lines]
    found += [fault for _, faults in missed for fault in faults]
    blank = HeightMap.of(task.stock, allowed.cell or cell_for(task.stock))
    left, done = blank.carved(moves, tools, track_of(moves))
    wanted = task.floors(blank)
    found += way_faults(moves, tools, done, task.top)
    if task.zones or task.lines:
        asked = task.floors(blank, cleared=True)
        limits = allowed.gouge, allowed.left, allowed.beside
        found += height_faults(task, left, (wanted, asked), cuts, limits)
    return Verification(
        faults=worst([*faults, *found]),
        gouge=deepest,
        left=max((*(rest.left for rest in rests), *(far for far, _ in missed)), default=0.0),
        unreachable=max((rest.unreachable for rest in rests), default=0.0),
        removed=float(done[:, 3].sum()),
        bound=cuts.track.bound,
        map=left,
        wanted=wanted,
    )


def verify_file(
    file: str | PathLike[str],
    task: Task,
    cutters: Cutters,
    allowed: Allowance | None = None,
    *,
    machine: NcMachine | None = None,
    dialect: Dialect | None = None,
) -> Verification:
    """Give what an NC file does to its stock; see `verify`.

    Ways with G41 and G42 are moved aside first; what the tool cannot reach there is told.

    Args:
        file: The program.
        task: The stock and what shall be made of it, in coordinates of the machine.
        cutters: The cutter, or several by number.
        allowed: What may differ.
        machine: What the machine knows; None: as `run_gcode` has it.
        dialect: The controller, if it shall be told what that does not take.

    Raises:
        GcodeError: If the program cannot be read.
        GougeError: If the tool does not fit along a contour with G41 or G42.
    """
    compensated = compensate(run_gcode(file, machine))
    known = [_unreached(each) for each in compensated.unreached]
    if dialect is not None:
        known += _lint(Path(file), dialect)
    return verify(compensated.actions, task, cutters, allowed, faults=known)


def _moves(actions: Iterable[Action], cutters: Cutters) -> tuple[list[Move], list[Cutter]]:
    """Give the moves and the cutter of each."""
    moves, tools = list[Move](), list[Cutter]()
    one = cutters if isinstance(cutters, Cutter) else None
    cutter = one
    for action in actions:
        if isinstance(action, ToolChange) and not isinstance(cutters, Cutter):
            if action.tool and action.tool not in cutters:
                raise ValueError(
                    f"cutters: line {action.line} takes number {action.tool}; there are "
                    f"{', '.join(map(str, sorted(cutters))) or 'none'}"
                )
            cutter = cutters.get(action.tool)
        if not isinstance(action, Rapid | Feed | ArcFeed | SplineFeed):
            continue
        if isinstance(action, Cutting) and action.side:
            raise ValueError(f"actions: line {action.line} is marked by G41 or G42; `compensate`")
        if cutter is None and not isinstance(cutters, Cutter) and len(cutters) == 1:
            cutter = next(iter(cutters.values()))
        if cutter is None:
            if isinstance(action, Rapid):
                continue  # no tool is in the machine yet
            raise ValueError(f"actions: line {action.line} cuts before a tool is taken")
        moves.append(action)
        tools.append(cutter)
    return moves, tools


def _cuts(moves: list[Move], tools: list[Cutter]) -> Cuts:
    """Give the moves that cut."""
    pairs = [(m, t) for m, t in zip(moves, tools, strict=True) if not isinstance(m, Rapid)]
    own = [move for move, _ in pairs]
    return Cuts(own, [tool for _, tool in pairs], track_of(own))


def _unreached(each: Unreached) -> Fault:
    says = f"the tool cannot touch this way: {each.left * 1e3:.6g} mm are left"
    where = (*each.where, 0.0)
    return Fault(kind="unreached", line=each.line, where=where, amount=each.left, says=says)


def _lint(file: Path, dialect: Dialect) -> list[Fault]:
    text = file.read_text(encoding="utf-8", errors="replace")
    return [
        Fault(
            kind="dialect",
            line=each.line,
            where=(0.0, 0.0, 0.0),
            amount=0.0,
            says=f"{each.word + ': ' if each.word else ''}{each.reason}",
        )
        for each in lint(read_program(text, str(file)), text, dialect)
    ]
