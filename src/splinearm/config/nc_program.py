"""Toolpaths in job files: which NC program, where its work lies, with which tool.

::

    toolpath = "part.ngc"       as seen from the job file
    [place]
        xyz_mm                  where the program's coordinates are in the arm's base
        rpy_deg or quat_wxyz    how they are turned (default: not)
        direction               where the tool points in them (default [0, 0, -1])
        turn_deg                turn of the tool about its own axis, kept (default: it is free)
        clearance_mm            from how high above its first place the tool comes (default 20)
        tool_length_mm          how far the tip is beyond the tool frame of the arm's file
        tools                   table of cutters, as seen from the job file
        inches                  whether the program is in inches until it says otherwise
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.toolpaths.cutter import Cutter

from .frame import read_axis, read_transform
from .reader import Table
from .tool_table import load_tools

_CLEARANCE = 0.02


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class NcProgram:
    """What a job file says of an NC program."""

    file: Path
    """The program."""
    T_base_work: FloatArray
    """Where its coordinates are, shape (4, 4)."""
    direction: FloatArray
    """Where the tool points in them, of length 1, shape (3,)."""
    turn: float | None
    """Turn of the tool about its own axis that is kept, rad; None: it is free."""
    clearance: float
    """From how high above its first place the tool comes, m."""
    tool_length: float
    """How far the tip is beyond the tool frame of the arm's file, m."""
    tools: Mapping[int, Cutter]
    """Cutters by number."""
    inches: bool
    """Whether the program is in inches until it says otherwise."""


def read_program(root: Table, file: Path) -> NcProgram | None:
    """Give the toolpath of a job file; None if it has none.

    Raises:
        ConfigError: With the key, if the program or its table of cutters is not there.
    """
    if "toolpath" not in root:
        return None
    program = file.parent / root.text("toolpath")
    if not program.is_file():
        raise root.refuse("toolpath", f"{program} is no file")
    place = root.table("place")
    tools = place.text("tools", "")
    found = NcProgram(
        file=program,
        T_base_work=read_transform(place),
        direction=read_axis(place, "direction")
        if "direction" in place
        else np.array([0.0, 0.0, -1.0]),
        turn=place.number("turn_deg") if "turn_deg" in place else None,
        clearance=place.number("clearance_mm", _CLEARANCE, low=0.0),
        tool_length=place.number("tool_length_mm", 0.0, low=0.0),
        tools=load_tools(file.parent / tools) if tools else {},
        inches=place.flag("inches"),
    )
    place.finish()
    return found
