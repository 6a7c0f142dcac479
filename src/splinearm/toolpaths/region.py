"""Regions: what an outer contour encloses, without islands."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import ContourError

from .contour import Contour, joined

_TINY = 1e-10
"""Pieces that meet nearer to their ends than this share of the size do not cross there."""


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """What a closed contour encloses, without what its islands enclose.

    The outer contour runs to the left, islands to the right, so that the region lies to the left of
    all of them; given the other way they are turned about.
    """

    outer: Contour
    """The outer contour, closed."""
    islands: tuple[Contour, ...] = ()
    """Contours of what is left out, closed, inside of the outer one and outside of each other."""

    def __post_init__(self) -> None:
        for name, contour in (("outer", self.outer), *(("island", i) for i in self.islands)):
            if not contour.closed:
                raise ValueError(f"{name}: want a closed contour, this one is open")
        outer = self.outer if self.outer.area > 0.0 else self.outer.reversed()
        islands = tuple(i if i.area < 0.0 else i.reversed() for i in self.islands)
        object.__setattr__(self, "outer", outer)
        object.__setattr__(self, "islands", islands)
        _check(self)

    @classmethod
    def made(cls, outer: Contour, islands: tuple[Contour, ...] = ()) -> "Region":
        """Give a region of contours that are known to be right; nothing is checked or turned."""
        region = object.__new__(cls)
        object.__setattr__(region, "outer", outer)
        object.__setattr__(region, "islands", islands)
        return region

    @property
    def contours(self) -> tuple[Contour, ...]:
        """All contours, the outer one first."""
        return (self.outer, *self.islands)

    @property
    def area(self) -> float:
        """Its area, m2."""
        return sum(contour.area for contour in self.contours)

    @property
    def length(self) -> float:
        """The length of all its contours, m."""
        return sum(contour.length for contour in self.contours)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least x and y, largest x and y, m."""
        return self.outer.bounds

    def contains(self, points: ArrayInput) -> npt.NDArray[np.bool_]:
        """Say which points lie in it, shape (...) of booleans, for points of shape (..., 2), m."""
        inside = self.outer.contains(points)
        for island in self.islands:
            inside = inside & ~island.contains(points)
        return inside

    def distance(self, points: ArrayInput) -> FloatArray:
        """Give how far points, shape (..., 2), are from the nearest contour, m, shape (...)."""
        found: FloatArray = np.min([c.distance(points) for c in self.contours], axis=0)
        return found

    def transformed(
        self,
        *,
        scale: float = 1.0,
        angle: float = 0.0,
        shift: ArrayInput = (0.0, 0.0),
        mirrored: bool = False,
    ) -> "Region":
        """Give it mirrored, scaled, turned and shifted, in that order; see `Contour`."""
        moved = [
            contour.transformed(scale=scale, angle=angle, shift=shift, mirrored=mirrored)
            for contour in self.contours
        ]
        if mirrored:
            moved = [contour.reversed() for contour in moved]
        return Region.made(moved[0], tuple(moved[1:]))


def _check(region: Region) -> None:
    """Raise unless no two segments cross and islands lie where islands can be."""
    from .contour_along_kernel import first_crossing_along
    from .contour_kernel import first_crossing, first_shared
    from .offset_kernel import pieces_of

    vertices, bulges, starts = joined(region.contours)
    size = float(np.ptp(vertices, axis=0).max())
    P, segment, loops = pieces_of(vertices, bulges, starts, 0.0)
    i, j, x, y = first_crossing(P, loops, _TINY * size)
    if i >= 0:
        first, second = (_name(starts, int(segment[k])) for k in (i, j))
        raise ContourError(f"{first} crosses {second}", (x, y))
    i, j, x, y = first_crossing_along(P, loops, _TINY * size)
    if i >= 0:
        first, second = (_name(starts, int(segment[k])) for k in (i, j))
        raise ContourError(f"{first} runs along {second} and crosses it", (x, y))
    i, j, x, y = first_shared(P, loops, _TINY * size)
    if i >= 0:
        first, second = (_name(starts, int(segment[k])) for k in (i, j))
        raise ContourError(f"{first} lies along {second}", (x, y))
    for k, island in enumerate(region.islands):
        spot = island.vertices[:1]
        inside = region.outer.contains(spot)[0] or region.outer.distance(spot)[0] < _TINY * size
        if not inside:
            raise ContourError(
                f"island {k} is not inside of the outer contour", tuple(spot[0].tolist())
            )
        for other, contour in enumerate(region.islands):
            if (
                other != k
                and contour.contains(spot)[0]
                and contour.distance(spot)[0] > _TINY * size
            ):
                raise ContourError(
                    f"island {k} is inside of island {other}", tuple(spot[0].tolist())
                )


def _name(starts: FloatArray, segment: int) -> str:
    for k, (first, end) in enumerate(pairwise(starts.astype(int).tolist())):
        if first <= segment < end:
            where = "the outer contour" if k == 0 else f"island {k - 1}"
            return f"segment {segment - first} of {where}"
    return f"segment {segment}"
