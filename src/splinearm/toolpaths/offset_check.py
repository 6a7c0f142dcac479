"""The check of offsets by code that did not make them: exact distances, and nothing lost."""

from dataclasses import dataclass

from splinearm.arrays import FloatArray
from splinearm.errors import GougeError, OffsetError


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
    from .offset_whole_kernel import part_of, verdict

    raise_of(
        verdict(
            (result.vertices, result.bulges, result.starts),
            part_of(part.vertices, part.bulges, part.starts),
            (distance, reach),
            tolerance,
            1.0 if outward else 0.0,
        ),
        distance,
    )


def raise_of(said: tuple[float, float, float, float], distance: float) -> None:
    """Raise what a verdict says, if it says something."""
    kind, x, y, off = said
    if kind == 1.0:
        raise GougeError((x, y), off, "this is a fault of the offset: report it")
    if kind == 2.0:
        raise OffsetError(distance, f"{off:.3g} m too far from the part", (x, y))
    if kind != 0.0:
        raise OffsetError(distance, "a region is missing or too much", (x, y))
