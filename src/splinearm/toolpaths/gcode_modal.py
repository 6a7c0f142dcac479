"""Codes of NC programs and the groups of which one is in force at a time.

Source: Kramer, Proctor, Messina, NISTIR 6556, 2000, table 4; LinuxCNC, "G-code overview", "Modal
groups".
"""

from collections.abc import Mapping
from types import MappingProxyType

Code = int
"""Ten times the number of a code: G5.2 is 52, M3 is 30."""


def written(letter: str, code: Code) -> str:
    """Give a code as it is written."""
    whole, tenth = divmod(code, 10)
    return f"{letter.upper()}{whole}.{tenth}" if tenth else f"{letter.upper()}{whole}"


def _members(groups: Mapping[str, tuple[float, ...]]) -> Mapping[Code, str]:
    return MappingProxyType(
        {round(10 * number): name for name, numbers in groups.items() for number in numbers}
    )


MOTION = "motion"
G_GROUPS = _members(
    {
        "once": (4, 10, 28, 28.1, 30, 30.1, 52, 92, 92.1, 92.2, 92.3),
        MOTION: (0, 1, 2, 3, 5, 5.1, 5.2, 5.3, 73, 80, 81, 82, 83, 84, 85, 86, 87, 88, 89),
        "machine": (53,),
        "plane": (17, 18, 19),
        "distance": (90, 91),
        "arc distance": (90.1, 91.1),
        "feed mode": (93, 94, 95),
        "unit": (20, 21),
        "compensation": (40, 41, 41.1, 42, 42.1),
        "tool length": (43, 43.1, 43.2, 49),
        "retract": (98, 99),
        "coordinates": (54, 55, 56, 57, 58, 59, 59.1, 59.2, 59.3),
        "path": (61, 61.1, 64),
        "spindle mode": (97,),
        "diameter": (8,),
    }
)
"""Group of each G code that is understood."""

M_GROUPS = _members(
    {
        "pause": (0, 1, 2, 30, 60),
        "spindle": (3, 4, 5, 19),
        "tool change": (6, 61),
        "mist": (7,),
        "flood": (8,),
        "coolant off": (9,),
        "override": (48, 49, 50, 51, 52, 53),
        "output": (62, 63, 64, 65, 67, 68),
        "state": (70, 71, 72, 73),
    }
)
"""Group of each M code that is understood."""

UNKNOWN_BECAUSE: Mapping[str, str] = MappingProxyType(
    {
        "G7": "diameters of a lathe are not understood; write radii",
        "G18.1": "planes of slanted axes are not understood",
        "G33": "threading needs a spindle that is followed; it cannot be planned",
        "G33.1": "tapping needs a spindle that is followed; use G84 or drill",
        "G38.2": "probing needs a machine; measure first and write the place",
        "G38.3": "probing needs a machine; measure first and write the place",
        "G38.4": "probing needs a machine; measure first and write the place",
        "G38.5": "probing needs a machine; measure first and write the place",
        "G76": "threading needs a spindle that is followed; it cannot be planned",
        "G96": "constant surface speed is of lathes; write G97 and a speed",
        "M66": "waiting for an input needs a machine",
        "M98": "write an O word: o<name> call",
        "M99": "write an O word: o<name> return",
    }
)
"""Why some codes are not understood, and what would help."""
