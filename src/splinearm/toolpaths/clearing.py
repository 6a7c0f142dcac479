"""What pockets have in common, however they are cleared: part by part, the sides at last."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from .lead_in import with_leads
from .mill import Mill
from .operation import Milled, Milling, Run
from .pocket_side import Sides, along_walls, tell_narrow


def clear(
    parts: Sequence[Sides], setting: Milling, runs_within: Callable[[Sides, Mill], list[Run]]
) -> Milled:
    """Clear what lies within sides, level by level, and take off what was left on the sides.

    Args:
        parts: What is cleared.
        setting: The cutter and how it is used.
        runs_within: Gives the ways that clear a part; none where the cutter has no room.

    Raises:
        ValueError: If there are no parts.
    """
    if not parts:
        raise ValueError("parts: want at least one")
    mill = Mill(setting)
    for sides in parts:
        mill.wall = sides.wall(setting)
        runs = runs_within(sides, mill)
        if not runs:
            tell_narrow(sides, mill.notes)
            continue
        mill.cut(runs, setting.levels)
        if setting.finish:
            _finish(mill, sides)
    return mill.milled()


def _finish(mill: Mill, sides: Sides) -> None:
    """Take off what was left on the sides of a pocket, at full depth."""
    setting = mill.setting
    mill.setting = fine = replace(setting, stock=0.0, finish=False)
    mill.wall = sides.wall(fine)
    ways = along_walls(sides, fine, mill.notes)
    sides.require_clear(ways, fine)
    runs = [with_leads(way, mill.wall, setting.lead, mill.notes) for way in ways]
    mill.cut(runs, setting.levels[-1:], whole=True)
    mill.setting = setting
