"""Dialects of NC programs: what a controller takes.

Sources: LinuxCNC, "G-code overview" and "G-Codes"; GRBL 1.1, wiki pages "Commands" and "Interface",
and its ``config.h`` and ``gcode.c``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

MM = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """What a controller takes."""

    name: str
    """Its name, as on the command line."""
    decimals: int
    """Digits behind the point of a length in mm."""
    longest_line: int
    """Characters in a line."""
    splines: bool
    """Whether it knows G5 and G5.2."""
    tool_changes: bool
    """Whether it knows M6 and G43; else a person changes the tool at M0."""
    blends: bool
    """Whether it knows G64 P."""
    arc_slack: float = 5e-3 * MM
    """By how much both ends of an arc may differ in their distance to its centre, m."""
    arc_share: float = 1e-3
    """The same as a share of the radius; the larger of both counts."""
    largest_radius: float = 100.0
    """Arcs of larger radii are written as lines where nobody could tell the difference, m."""
    program_marks: bool = False
    """Whether a program begins and ends with %."""
    codes: frozenset[str] | None = None
    """The codes that it takes, as in "G2"; None: all that are understood here."""
    language: bool = True
    """Whether it knows parameters, expressions and O words."""

    @property
    def resolution(self) -> float:
        """The least length that it can say, m."""
        return float(MM * 10.0**-self.decimals)


_LINUXCNC = Dialect(
    name="linuxcnc",
    decimals=6,
    longest_line=255,
    splines=True,
    tool_changes=True,
    blends=True,
    program_marks=True,
)
_GRBL_MODES = """G17 G18 G19 G20 G21 G40 G54 G55 G56 G57 G58 G59 G61 G90 G91 G91.1 G93 G94"""
_GRBL_DOES = """G0 G1 G2 G3 G4 G10 G28 G28.1 G30 G30.1 G43.1 G49 G53 G80 G92 G92.1
    M0 M1 M2 M3 M4 M5 M7 M8 M9 M30"""

_GRBL = Dialect(
    name="grbl",
    decimals=4,
    longest_line=79,
    splines=False,
    tool_changes=False,
    blends=False,
    codes=frozenset(f"{_GRBL_MODES} {_GRBL_DOES}".split()),
    language=False,
    largest_radius=10.0,  # it reckons with 24 bits: a micrometre in that
)

DIALECTS: Mapping[str, Dialect] = MappingProxyType(
    {dialect.name: dialect for dialect in (_LINUXCNC, _GRBL)}
)
"""Every dialect by name."""


def dialect_of(name: str) -> Dialect:
    """Give the dialect of a name.

    Raises:
        ValueError: If there is none; its message lists those there are.
    """
    if name not in DIALECTS:
        raise ValueError(f"dialect: want one of {', '.join(DIALECTS)}, got {name!r}")
    return DIALECTS[name]
