"""Job files of toolpaths: a drawing, its operations and the cutters for them.

The keys of a job file (``schema = "splinearm-toolpath/1"``)::

    drawing                 a DXF or SVG file, as seen from the job file
    unit                    the unit of its numbers where it says none ("mm")
    tools                   a table of cutters ("splinearm-tools/1"), as seen from the job file
    dialect                 "linuxcnc" (default) or "grbl"
    joining_tolerance_mm    ends nearer than this are one place (default 0.01)
    tolerance_mm            how far ways may be off because of splines (default 0.01)
    [[operation]]           in order
        kind                profile, pocket, zigzag, spiral, facing, drill or engrave
        tool                number of a cutter in the table
        layers              names of layers, with commas between them; without it all
        depth_mm            how deep, from top_mm
        top_mm              where the material begins (default 0, the top of the stock)
        step_down_mm, step_over_percent     without them as the cutter's table says
        side                outside (default), inside or on: of a profile
        direction           "climb" (default) or "conventional"
        entry               "plunge" (default), "ramp" or "helix"
        ramp_deg            how steep ramps and helices are (default 3)
        lead_mm             radius of lead-in and lead-out (default 0: none)
        blend_mm            how far corners may be cut to keep the pace (without it not at all)
        stock_mm            what is left on the sides (default 0)
        finish              true: it is taken off in a last pass
        tabs, tab_length_mm, tab_height_mm  of a profile (default 0; 5 and 1.5)
        angle_deg           direction of lines to and fro (default 0)
        peck_mm             after so much depth a drill comes out
        safe_mm, gap_mm     where rapid ways go, and end above the material (default 5 and 0.5)
"""

from dataclasses import dataclass
from math import pi
from os import PathLike
from pathlib import Path

from splinearm.toolpaths.cutter import Cutter
from splinearm.toolpaths.drawing import UNITS
from splinearm.toolpaths.gcode_dialect import DIALECTS, Dialect, dialect_of
from splinearm.toolpaths.operation import Entry, Milling, Side
from splinearm.toolpaths.tab import Tabs
from splinearm.toolpaths.work import Exactness, Kind, Work

from .reader import Table, read_file
from .tool_table import load_tools

SCHEMA = "splinearm-toolpath/1"
"""What the file says it is."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ToolpathJob:
    """What a job file says."""

    drawing: Path
    """The drawing."""
    unit: str | None
    """The unit of its numbers where it says none; None: as is usual for such files."""
    dialect: Dialect
    """The controller."""
    exactness: Exactness
    """How the drawing is taken."""
    works: tuple[Work, ...]
    """The operations."""


def load_toolpath_job(file: str | PathLike[str]) -> ToolpathJob:
    """Read a job file.

    Raises:
        ConfigError: With the key, if something is missing, wrong or unknown.
    """
    table = read_file(file, SCHEMA)
    folder = Path(file).parent
    dialect = dialect_of(table.choice("dialect", list(DIALECTS), "linuxcnc"))
    tools = load_tools(folder / table.text("tools"))
    drawing = folder / table.text("drawing")
    unit = table.choice("unit", list(UNITS)) if "unit" in table else None
    exactness = Exactness(
        joining=table.number("joining_tolerance_mm", 1e-5, above=0.0),
        tolerance=table.number("tolerance_mm", 1e-5, above=0.0),
        splines=dialect.splines,
    )
    works = tuple(_read_work(row, tools) for row in table.tables("operation"))
    if not works:
        raise table.refuse("operation", "is missing; give at least one table [[operation]]")
    table.finish()
    return ToolpathJob(
        drawing=drawing, unit=unit, dialect=dialect, exactness=exactness, works=works
    )


def _read_work(row: Table, tools: dict[int, Cutter]) -> Work:
    kind = Kind(row.choice("kind", [kind.value for kind in Kind]))
    number = row.integer("tool", low=1)
    if number not in tools:
        there = ", ".join(map(str, sorted(tools))) or "none"
        raise row.refuse("tool", f"{number} is not in the table of cutters; there are {there}")
    work = Work(
        kind=kind,
        milling=_read_milling(row, tools[number]),
        layers=layer_names(row.text("layers")) if "layers" in row else (),
        side=Side(row.choice("side", [side.value for side in Side], Side.OUTSIDE.value)),
        tabs=_read_tabs(row),
        angle=row.number("angle_deg", 0.0),
        peck=row.number("peck_mm", above=0.0) if "peck_mm" in row else None,
    )
    row.finish()
    return work


def layer_names(text: str) -> tuple[str, ...]:
    """Give the names of layers in a list with commas between them."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _read_milling(row: Table, cutter: Cutter) -> Milling:
    over = (
        row.number("step_over_percent", above=0.0, high=1.0) if "step_over_percent" in row else None
    )
    with row.blaming("depth_mm"):
        return Milling(
            cutter=cutter,
            depth=row.number("depth_mm", above=0.0),
            top=row.number("top_mm", 0.0, high=0.0),
            step_down=row.number("step_down_mm", above=0.0) if "step_down_mm" in row else None,
            step_over=None if over is None else over * cutter.diameter,
            climb=row.choice("direction", ["climb", "conventional"], "climb") == "climb",
            safe=row.number("safe_mm", 5e-3, above=0.0),
            gap=row.number("gap_mm", 0.5e-3, above=0.0),
            entry=Entry(row.choice("entry", [e.value for e in Entry], Entry.PLUNGE.value)),
            ramp_angle=row.number("ramp_deg", 3.0 * pi / 180.0, above=0.0),
            blend=row.number("blend_mm", above=0.0) if "blend_mm" in row else None,
            lead=row.number("lead_mm", 0.0, low=0.0),
            stock=row.number("stock_mm", 0.0, low=0.0),
            finish=row.flag("finish"),
        )


def _read_tabs(row: Table) -> Tabs | None:
    count = row.integer("tabs", 0, low=0)
    length = row.number("tab_length_mm", 5e-3, above=0.0)
    height = row.number("tab_height_mm", 1.5e-3, above=0.0)
    return Tabs(count=count, length=length, height=height) if count else None
