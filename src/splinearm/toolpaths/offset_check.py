"""The check of offsets by code that did not make them: exact distances, and nothing lost."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GougeError, OffsetError

_PROBES = 32
"""Beside about so many segments it is looked whether a region is missing."""


@dataclass(frozen=True, slots=True, eq=False)
class Loops:
    """Closed loops of lines and arcs, one after the other, as bare arrays."""

    vertices: FloatArray
    """Where segments begin, shape (m, 2)."""
    bulges: FloatArray
    """Their bulges, shape (m,)."""
    starts: FloatArray
    """The first vertex of each loop and m, shape (loops + 1,)."""


def check_offset(
    result: Loops,
    part: Loops,
    distance: float,
    *,
    outward: bool,
    reach: float = 1.0,
    tolerance: float,
) -> None:
    """Raise unless an offset to the left is as far from the part as it should be, and complete.

    Args:
        result: What was made; what it encloses lies to its left.
        part: What it was made from; what is offset lies to its left.
        distance: The distance.
        outward: Whether what is offset is what the loops do not enclose.
        reach: How far corners may be, as a multiple of the distance: 1 where they are round.
        tolerance: What is rounding.

    Raises:
        GougeError: If it is nearer to the part somewhere.
        OffsetError: If it is farther than that, or a region is missing or too much.
    """
    from .offset_check_kernel import lost, measured, segments_of

    R = segments_of(result.vertices, result.bulges, result.starts)
    Q = segments_of(part.vertices, part.bulges, part.starts)
    if len(R):
        found = np.empty(6)
        slack = max(reach - 1.0, 1e-6) * distance + 4.0 * tolerance
        measured(R, Q, distance, slack, found)
        least, x, y, most, u, v = found.tolist()
        if not least >= distance - tolerance:
            raise GougeError((x, y), distance - least, "this is a fault of the offset: report it")
        if not most <= reach * distance + tolerance:
            raise OffsetError(distance, f"{most - distance:.3g} m too far from the part", (u, v))
    missed, x, y = lost(R, Q, (distance, reach * distance), _PROBES, outward)
    if missed:
        raise OffsetError(distance, "a region is missing or too much", (x, y))
