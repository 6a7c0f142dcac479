"""What is in force while an NC program runs: modes, offsets, where the tool is."""

from copy import deepcopy
from dataclasses import dataclass, field
from math import inf, pi

import numpy as np

from splinearm.arrays import FloatArray

from .gcode_machine import NcMachine, NcTool
from .gcode_modal import Code

MM = 1e-3
INCH = 0.0254
_MINUTE = 60.0

AXES = "xyz"
"""The axes that are understood; rotary ones are not."""

OFFSET_LETTERS = "ijk"
"""Words that lead to centres and control points, one for each axis."""


@dataclass(slots=True, eq=False)
class Modes:
    """What codes have put in force; M70 keeps it and M72 brings it back."""

    unit: float = MM
    """Length of a program's unit, m."""
    axis: int = 2
    """The axis at right angles to the plane of arcs."""
    absolute: bool = True
    """Whether coordinates are places (G90) or ways (G91)."""
    arc_absolute: bool = False
    """Whether centres are places (G90.1) or ways from the start (G91.1)."""
    feed_mode: int = 94
    """93: inverse time, 94: per minute, 95: per turn of the spindle."""
    feed: float = 0.0
    """The F word: m/s, 1/s or m/turn, by the mode; 0: none was given."""
    retract_to_start: bool = True
    """Whether cycles go back to where they began (G98) or to R (G99)."""
    blend: float | None = inf
    """How far corners may be cut, m."""
    speed: float = 0.0
    """The S word, rad/s."""
    spindle: int = 0
    """1 clockwise, -1 counterclockwise, 0 stands."""
    side: int = 0
    """Side of the tool: 1 left (G41), -1 right (G42), 0 on the way (G40)."""
    radius: float = 0.0
    """Radius of the tool that is beside the way, m."""


@dataclass(slots=True, eq=False)
class State:
    """A machine while it runs a program."""

    machine: NcMachine
    """The machine."""
    modes: Modes = field(default_factory=Modes)
    """What is in force."""
    motion: Code | None = None
    """The code that words without one are for; None: after G80."""
    position: FloatArray = field(init=False)
    """Where the tool's tip is in machine coordinates, shape (3,), m."""
    origins: FloatArray = field(init=False)
    """Origins of G54 to G59.3, shape (9, 3), m."""
    homes: FloatArray = field(init=False)
    """Where G28 and G30 go, shape (2, 3), m."""
    system: int = 0
    """Which of the coordinate systems is in force."""
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))
    """The offset of G92 or G52, shape (3,), m."""
    kept_shift: FloatArray = field(default_factory=lambda: np.zeros(3))
    """That of G92 before G92.2, which G92.3 brings back, shape (3,), m."""
    tool: int = 0
    """The tool in the spindle."""
    selected: int = 0
    """The tool that M6 takes."""
    tools: dict[int, NcTool] = field(init=False)
    """The table of tools."""
    tool_offset: FloatArray = field(default_factory=lambda: np.zeros(3))
    """How far the tip is from the spindle's nose, shape (3,), m."""
    kept: list[Modes] = field(default_factory=list)
    """Modes that M70 has kept."""

    def __post_init__(self) -> None:
        self.position = np.array(self.machine.start)
        self.origins = np.array(self.machine.origins)
        self.homes = np.array(self.machine.homes)
        self.tools = dict(self.machine.tools)
        self.modes.unit = INCH if self.machine.inches else MM

    @property
    def offset(self) -> FloatArray:
        """From program coordinates to those of the machine, shape (3,), m."""
        total: FloatArray = self.origins[self.system] + self.shift + self.tool_offset
        return total

    @property
    def place(self) -> FloatArray:
        """Where the tool is in program coordinates, shape (3,), m."""
        here: FloatArray = self.position - self.offset
        return here

    @property
    def cutting_speed(self) -> float:
        """Feed per time, m/s; 0: none was given."""
        if self.modes.feed_mode == 95:
            return self.modes.feed * self.modes.speed / (2.0 * pi)
        return self.modes.feed if self.modes.feed_mode == 94 else 0.0

    def keep(self) -> None:
        """Keep the modes."""
        self.kept.append(deepcopy(self.modes))

    def set_feed(self, value: float) -> None:
        """Take an F word."""
        match self.modes.feed_mode:
            case 93:
                self.modes.feed = value / _MINUTE
            case 94:
                self.modes.feed = value * self.modes.unit / _MINUTE
            case _:
                self.modes.feed = value * self.modes.unit

    def set_speed(self, value: float) -> None:
        """Take an S word, turns a minute."""
        self.modes.speed = value * 2.0 * pi / _MINUTE
