"""Whether a written NC program means what was planned: it is read again and compared."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from math import pi

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GcodeError, ToolpathError

from .action import Action, ArcFeed, Cutting, Feed, Move, Rapid, SplineFeed
from .gcode_dialect import Dialect
from .gcode_interpreter import run_gcode_text
from .gcode_machine import NcMachine, NcTool
from .gcode_state import MM
from .gcode_writer import write_gcode

_LOOKS = np.linspace(0.0, 1.0, 17)
_FEED_SHARE = 1e-2
"""Share by which a feed may differ: it is written with two digits behind the point."""


def write_checked(actions: Iterable[Action], dialect: Dialect, title: str = "") -> str:
    """Give the program of what a machine shall do, read again and found to mean the same.

    Args:
        actions: What it shall do.
        dialect: What the controller takes.
        title: What the program says of itself.

    Raises:
        GcodeError: If the controller cannot be told something.
        ToolpathError: If the program read again is another than the plan; it is not given out.
    """
    plan = tuple(actions)
    text = write_gcode(plan, dialect, title)
    require_same(plan, text, dialect)
    return text


def require_same(plan: Iterable[Action], text: str, dialect: Dialect) -> None:
    """Refuse a program whose ways are not those of a plan.

    Args:
        plan: What was planned.
        text: The program.
        dialect: How exactly it is written.

    Raises:
        ToolpathError: With the line and how far it is off.
    """
    tools = {number: NcTool() for number in range(1000)}
    try:
        read = run_gcode_text(text, NcMachine(tools=tools))
    except GcodeError as error:
        raise ToolpathError(f"the written program cannot be read again: {error}") from error
    wanted, found = _Trail.of(plan, dialect), _Trail.of(read, dialect)
    tolerance = 4.0 * dialect.resolution
    for way, again in zip_longest(wanted, found):
        if way is None or again is None:
            raise ToolpathError(f"the written program has {len(found)} ways, {len(wanted)} planned")
        way.require(again, tolerance)


@dataclass(frozen=True, slots=True, eq=False)
class _Trail:
    """One way: places along it, whether it cuts, how fast, and the line that says it."""

    places: FloatArray
    cuts: bool
    feed: float | None
    line: int

    @classmethod
    def of(cls, actions: Iterable[Action], dialect: Dialect) -> "list[_Trail]":
        """Give the ways of actions, without those too short to be written."""
        trails: list[_Trail] = []
        place: FloatArray | None = None
        for action in actions:
            if not isinstance(action, Rapid | Cutting):
                continue
            for part in _parts(action):
                start = part[0] if place is None else place
                if _is_crumb(start, part, dialect):
                    place = part[-1]
                    continue
                cuts = isinstance(action, Cutting)
                feed = action.feed if isinstance(action, Cutting) else None
                trails.append(cls(part, cuts, feed, action.line))
                place = part[-1]
        return trails

    def require(self, again: "_Trail", tolerance: float) -> None:
        """Refuse another way than this.

        Raises:
            ToolpathError: With the line.
        """
        if self.cuts != again.cuts:
            raise ToolpathError(f"line {again.line} of the written program cuts where it must not")
        if self.places.shape != again.places.shape:
            raise ToolpathError(f"line {again.line} of the written program is another kind of way")
        off = float(np.abs(self.places[1:] - again.places[1:]).max())
        if off > tolerance:
            raise ToolpathError(
                f"line {again.line} of the written program is {off * 1e3:.3g} mm beside the plan"
            )
        wanted, found = self.feed or 0.0, again.feed or 0.0
        if abs(found - wanted) > _FEED_SHARE * wanted:
            raise ToolpathError(f"line {again.line} of the written program has another feed")


def _is_crumb(start: FloatArray, part: FloatArray, dialect: Dialect) -> bool:
    """Say whether a way ends, as it is written, where it begins, and is no way around."""
    ends = np.round(np.array([start, part[-1]]) / MM, dialect.decimals)
    short = np.abs(part[1:] - start).max() <= 4.0 * dialect.resolution
    return bool(short and (ends[0] == ends[1]).all())


def _parts(move: Move) -> list[FloatArray]:
    """Give places along a way: of a line its ends, of others many, in the pieces written."""
    match move:
        case Rapid() | Feed():
            return [np.array([move.start, move.end])]
        case ArcFeed():
            count = max(1, int(np.ceil(abs(move.turn) / (1.5 * pi))))
            return [move.at((i + _LOOKS) / count) for i in range(count)]
        case SplineFeed():
            return [
                move.curve.at((1.0 - _LOOKS) * a + _LOOKS * b)
                for a, b in pairwise(move.curve.breaks)
            ]
