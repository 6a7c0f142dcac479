"""Tables of cutters: what is in the machine, and how fast and deep it may go.

::

    schema = "splinearm-tools/1"

    [[tool]]
    number = 1
    name = "6 mm end mill"
    diameter_mm = 6
    feed_mm_min = 900
    plunge_mm_min = 300
    spindle_rpm = 12000
    step_down_mm = 2
    step_over_percent = 40
"""

from math import inf, pi
from os import PathLike

from splinearm.toolpaths.cutter import Cutter, Tip

from .reader import Table, read_file

SCHEMA = "splinearm-tools/1"
"""What the file says it is."""

_STEP_OVER = 0.4
"""Share of its diameter by which passes of a cutter are apart, unless its table says otherwise."""


def load_tools(file: str | PathLike[str]) -> dict[int, Cutter]:
    """Read the cutters of a TOML file, by number.

    Raises:
        ConfigError: With the key, if something is missing, wrong or unknown.
    """
    table = read_file(file, SCHEMA)
    tools: dict[int, Cutter] = {}
    for row in table.tables("tool"):
        tool = _read_tool(row)
        if tool.number in tools:
            raise row.refuse("number", f"{tool.number} is also the number of another tool")
        tools[tool.number] = tool
    table.finish()
    return tools


def _read_tool(row: Table) -> Cutter:
    number = row.integer("number", low=1)
    diameter = row.number("diameter_mm", above=0.0)
    tip = Tip(row.choice("tip", [tip.value for tip in Tip], Tip.FLAT.value))
    angle = row.number("tip_angle_deg", above=0.0, high=pi) if tip is Tip.POINT else pi
    with row.blaming("diameter_mm"):
        tool = Cutter(
            number=number,
            name=row.text("name", f"tool {number}"),
            diameter=diameter,
            tip=tip,
            tip_angle=angle,
            cutting_length=row.number("cutting_length_mm", inf, above=0.0),
            feed=row.number("feed_mm_min", above=0.0),
            plunge=row.number("plunge_mm_min", above=0.0),
            speed=row.number("spindle_rpm", 0.0),
            step_down=row.number("step_down_mm", diameter / 2.0, above=0.0),
            step_over=diameter * row.number("step_over_percent", _STEP_OVER, above=0.0, high=1.0),
        )
    row.finish()
    return tool
