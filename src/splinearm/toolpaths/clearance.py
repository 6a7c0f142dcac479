"""How near ways come to what must stay: exact distances, by code that made none of the ways."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import frexp, inf, ldexp
from typing import Self

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GougeError

from .contour import Contour, joined
from .stretch import there_and_back

ROUNDING = 1e-10
"""What a distance may be off by, as a share of the size of the part."""


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """Contours from which the middle of a cutter keeps away."""

    rows: FloatArray
    """Their segments, moved to the origin and scaled to about 1."""
    origin: FloatArray
    """Where the origin was, shape (2,), m."""
    unit: float
    """What is 1, m."""
    distance: float
    """How far the middle of the cutter keeps away, m."""

    @classmethod
    def of(cls, contours: Iterable[Contour], distance: float) -> Self:
        """Give the wall that contours are."""
        from .offset_check_kernel import segments_of

        vertices, bulges, starts = joined(tuple(contours))
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        origin = 0.5 * (low + high)
        # a power of two: scaling by it is exact
        unit = ldexp(1.0, frexp(max(float((high - low).max()), distance))[1])
        rows = segments_of((vertices - origin) / unit, bulges, starts)
        return cls(rows, origin, unit, distance)

    def is_clear(self, start: FloatArray, end: FloatArray, bulge: float = 0.0) -> bool:
        """Say whether a line or an arc keeps its distance."""
        return self._least(np.array([start, end]), np.array([bulge, -bulge]))[0] >= self._needed

    def require_clear(self, ways: Iterable[Contour]) -> None:
        """Refuse ways that come too near.

        Raises:
            GougeError: With the place where one of them is nearest.
        """
        several = tuple(ways)
        if not several:
            return
        least, x, y = self._least(*joined(w if w.closed else there_and_back(w) for w in several))
        if least < self._needed:
            where = np.array([x, y]) * self.unit + self.origin
            depth = self.distance - least * self.unit
            raise GougeError(
                (float(where[0]), float(where[1])),
                depth,
                "parts may be nearer to each other than the cutter is wide: take a smaller one",
            )

    @property
    def _needed(self) -> float:
        return self.distance / self.unit - ROUNDING

    def _least(
        self, vertices: FloatArray, bulges: FloatArray, starts: FloatArray | None = None
    ) -> tuple[float, float, float]:
        from .offset_check_kernel import segments_of
        from .offset_touch_kernel import measured

        if starts is None:
            starts = np.array([0.0, float(len(vertices))])
        R = segments_of((vertices - self.origin) / self.unit, bulges, starts)
        if not len(R):  # a way without length
            R = np.array([[*(vertices[0] - self.origin) / self.unit] * 2 + [0.0, 0.0, 0.0, inf]])
            R[0, 2] += 1e-15
        found = np.full(6, inf)
        measured(R, self.rows, self.distance / self.unit, 1e-6, found)
        least, x, y = found[:3].tolist()
        return least, x, y
