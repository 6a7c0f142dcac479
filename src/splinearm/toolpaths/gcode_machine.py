"""What a machine knows besides the program: its tools, and where its coordinate systems begin."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from splinearm.arrays import FloatArray, frozen_array

SYSTEMS = 9
"""Coordinate systems G54 to G59.3."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NcTool:
    """A tool of the machine's table."""

    diameter: float = 0.0
    """Diameter, m."""
    length: float = 0.0
    """How far its tip is below the spindle's nose, m."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class NcMachine:
    """A machine on which a program runs."""

    tools: Mapping[int, NcTool] = field(default_factory=lambda: MappingProxyType({}))
    """Its tools by number."""
    origins: FloatArray = field(default_factory=lambda: np.zeros((SYSTEMS, 3)))
    """Where G54 to G59.3 have their origins, shape (9, 3), m."""
    homes: FloatArray = field(default_factory=lambda: np.zeros((2, 3)))
    """Where G28 and G30 go, shape (2, 3), m."""
    start: FloatArray = field(default_factory=lambda: np.zeros(3))
    """Where the tool is when the program begins, shape (3,), m."""
    inches: bool = False
    """Whether programs are in inches until they say otherwise."""
    feed_in_new_unit: bool = False
    """Whether an F word beside a change of the unit is in the new one, as GRBL has it; LinuxCNC and
    the standard take the old one."""
    optional_stop: bool = True
    """Whether M1 pauses."""
    block_delete: bool = False
    """Whether lines that begin with / are left out."""

    def __post_init__(self) -> None:
        for name, shape in (("origins", (SYSTEMS, 3)), ("homes", (2, 3)), ("start", (3,))):
            object.__setattr__(self, name, frozen_array(getattr(self, name), shape, name))
