"""Wires with splines from which the middle of a cutter keeps away, proven by bounds."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self

from splinearm.arrays import FloatArray
from splinearm.errors import GougeError, OffsetError

from .piece import ArcPiece, LinePiece, Piece
from .spline_check import check_clear
from .spline_source import Source, source_of
from .wire import Wire

_STRAIGHT = 1e-12
"""A bulge below this is a line."""
_REMEDY = "parts may be nearer to each other than the cutter is wide: take a smaller one"


@dataclass(frozen=True, slots=True, eq=False)
class SplineWall:
    """Wires of lines, arcs and splines from which the middle of a cutter keeps away."""

    source: Source
    """The wires."""
    distance: float
    """How far away it keeps, m."""

    @classmethod
    def of(cls, wires: Iterable[Wire], distance: float) -> Self:
        """Give the wall that wires are."""
        return cls(source_of([wire.pieces for wire in wires], distance), distance)

    def is_clear(self, start: FloatArray, end: FloatArray, bulge: float = 0.0) -> bool:
        """Say whether a line or an arc is proven to keep its distance."""
        way: Piece = LinePiece(start, end)
        if abs(bulge) > _STRAIGHT:
            way = ArcPiece.bulging(start, end, bulge)
        try:
            self.require_clear([way])
        except (GougeError, OffsetError):
            return False
        return True

    def require_clear(self, pieces: Sequence[Piece]) -> None:
        """Refuse pieces that come too near.

        Raises:
            GougeError: With the place where one of them is nearest.
            OffsetError: If it is not proven that they keep their distance.
        """
        check_clear(self.source, pieces, self.distance, _REMEDY)
