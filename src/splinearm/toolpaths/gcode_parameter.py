"""Parameters that the machine keeps itself: places, offsets, tools, modes.

Source: LinuxCNC, "G-code overview", "Numbered Parameters" and "Predefined Named Parameters".
Lengths are in the program's unit where they are places, else in the machine's.
"""

from collections.abc import Callable
from math import pi

from splinearm.arrays import FloatArray

from .gcode_machine import SYSTEMS, NcTool
from .gcode_state import AXES, INCH, MM, State

_HOMES, _SHIFT, _ORIGIN, _TOOL, _PLACE = (5161, 5181), 5211, 5221, 5401, 5420
_APART = 20
"""Numbers from one coordinate system to the next."""

Source = Callable[[], float]
"""Gives the value of a parameter when it is asked for."""


def computed_parameters(
    state: State, returned: Callable[[], tuple[float, bool]]
) -> dict[int | str, Source]:
    """Give what works out each parameter that the machine keeps.

    Args:
        state: The machine.
        returned: Gives what the last subroutine gave back, and whether it gave anything.
    """
    unit = INCH if state.machine.inches else MM
    table: dict[int | str, Source] = {
        5220: lambda: state.system + 1.0,
        5400: lambda: float(state.tool),
        5410: lambda: state.tools.get(state.tool, NcTool()).diameter / unit,
        "_metric": lambda: float(state.modes.unit == MM),
        "_imperial": lambda: float(state.modes.unit == INCH),
        "_absolute": lambda: float(state.modes.absolute),
        "_incremental": lambda: float(not state.modes.absolute),
        "_current_tool": lambda: float(state.tool),
        "_selected_tool": lambda: float(state.selected),
        "_feed": lambda: state.modes.feed * 60.0 / state.modes.unit,
        "_rpm": lambda: state.modes.speed * 60.0 / (2.0 * pi),
        "_value": lambda: returned()[0],
        "_value_returned": lambda: float(returned()[1]),
    }
    for axis, letter in enumerate(AXES):
        for index, first in enumerate(_HOMES):
            table[first + axis] = _row(state, "homes", index, axis, unit)
        for index in range(SYSTEMS):
            table[_ORIGIN + _APART * index + axis] = _row(state, "origins", index, axis, unit)
        table[_SHIFT + axis] = _coordinate(lambda: state.shift, axis, lambda: unit)
        table[_TOOL + axis] = _coordinate(lambda: state.tool_offset, axis, lambda: unit)
        place = _coordinate(lambda: state.place, axis, lambda: state.modes.unit)
        table[_PLACE + axis] = table[f"_{letter}"] = place
    return table


def _row(state: State, name: str, index: int, axis: int, unit: float) -> Source:
    return lambda: float(getattr(state, name)[index, axis] / unit)


def _coordinate(values: Callable[[], FloatArray], axis: int, unit: Source) -> Source:
    return lambda: float(values()[axis] / unit())
