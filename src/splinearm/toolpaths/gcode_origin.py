"""Where coordinates begin, and how long tools are, as programs set them: G10, G52, G92."""

import numpy as np

from .gcode_line import Line
from .gcode_machine import SYSTEMS, NcTool
from .gcode_modal import Code
from .gcode_state import State


def set_table(line: Line, state: State) -> None:
    """Do G10: set a coordinate system or a tool.

    Raises:
        GcodeError: If it says what is not understood.
    """
    kind = line.whole("l", 0, "G10 wants L")
    number = line.whole("p", 0, "G10 wants P")
    unit = state.modes.unit
    if "r" in line.values and kind in (2, 20):
        raise line.refuse("R", "coordinate systems that are turned are not understood")
    if kind in (2, 20):
        if number > SYSTEMS:
            raise line.refuse("P", f"coordinate systems go from 1 to 9, got {number}")
        index = state.system if number == 0 else number - 1
        for axis, value in line.places(unit).items():
            if kind == 2:
                state.origins[index, axis] = value
            else:
                others = state.shift[axis] + state.tool_offset[axis]
                state.origins[index, axis] = state.position[axis] - others - value
    elif kind in (1, 10, 11):
        old = state.tools.get(number, NcTool())
        given = line.places(unit)
        length = given.get(2, old.length)
        if kind != 1 and 2 in given:
            length = state.position[2] - state.origins[state.system, 2] - given[2]
        radius = line.take("r")
        diameter = old.diameter if radius is None else 2.0 * radius * unit
        state.tools[number] = NcTool(diameter=diameter, length=length)
    else:
        raise line.refuse("L", f"G10 has L1, L2, L10, L11 and L20, got L{kind}")


def shift_origin(line: Line, state: State, code: Code) -> None:
    """Do G52 and G92 to G92.3: move the origin for a while.

    Raises:
        GcodeError: If G92 has no coordinates.
    """
    given = line.places(state.modes.unit) if code in (520, 920) else {}
    if code == 920 and not given:
        raise line.refuse("G92", "wants the coordinates that this place shall have")
    for axis, value in given.items():
        here = state.place[axis] + state.shift[axis]
        state.shift[axis] = here - value if code == 920 else value
    if code in (921, 922):
        state.shift = np.zeros(3)
    if code in (920, 921):
        state.kept_shift = state.shift.copy()
    if code == 923:
        state.shift = state.kept_shift.copy()
