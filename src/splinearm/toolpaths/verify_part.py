"""What a program shall make of its stock: zones that may be cut, lines to follow, how deep."""

from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

from .contour import Contour
from .region import Region
from .stock import HeightMap, Stock
from .verify_line import Lines
from .verify_way import outline_of

_SAME = 1e-9
"""Edges nearer than this are one, m."""

_BESIDE = 1e-7
"""So far beside an edge it is looked what is free, m."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Zone:
    """Where material may be cut away, and how deep."""

    regions: tuple[Region, ...]
    """Regions of the plane, apart from each other."""
    floor: float
    """How low, m."""
    side: Literal["inside", "outside"] = "inside"
    """Whether what is inside of the regions goes, or what is outside of all, and they stay."""
    cleared: bool = True
    """Whether all of it shall go (a pocket), or only what is along its edge (a profile)."""
    tab_height: float = 0.0
    """How high tabs may be that hold what a profile cuts out, along half of its edge at most, m."""
    open: bool = False
    """Whether what is beside it may be cut as deep: facing goes beyond the edges."""

    def __post_init__(self) -> None:
        if not self.regions:
            raise ValueError("regions: want at least one")
        if self.side not in ("inside", "outside"):
            raise ValueError(f"side: want inside or outside, got {self.side!r}")
        if not 0.0 <= self.tab_height < inf:
            raise ValueError(f"tab_height: want 0 or more, got {self.tab_height}")
        if not np.isfinite(self.floor):
            raise ValueError(f"floor: want a finite height, got {self.floor}")
        if self.cleared and self.side == "outside":
            raise ValueError("cleared: what is outside of a region has no end; clear an inside")

    @property
    def contours(self) -> tuple[Contour, ...]:
        """Every contour of its regions."""
        return tuple(contour for region in self.regions for contour in region.contours)


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """A block of material and the zones of it that shall be cut.

    Zones lie apart or within each other; their edges must not cross.
    """

    stock: Stock
    """The block."""
    zones: tuple[Zone, ...] = ()
    """The zones."""
    lines: tuple[Lines, ...] = ()
    """Lines on which cutters go, whatever zones there are."""

    def __post_init__(self) -> None:
        for floor in self.floors_asked():
            if not floor < self.stock.high[2]:
                raise ValueError(
                    f"floor: want it below the surface, {self.stock.high[2]:g}, got {floor:g}"
                )

    @property
    def top(self) -> float:
        """The surface, m."""
        return float(self.stock.high[2])

    def floors_asked(self) -> list[float]:
        """Give the floors of zones and lines."""
        return [zone.floor for zone in self.zones] + [line.floor for line in self.lines]

    def levels(self) -> list[float]:
        """Give the heights at which there is something to be spared: the surface and floors."""
        return sorted({self.top, *(zone.floor for zone in self.zones)})

    def free_below(self, level: float) -> "Free":
        """Give where a tool may be below a level."""
        zones = [zone for zone in self.zones if zone.floor < level - _SAME]
        if any(zone.open for zone in zones):
            return Free(np.empty((0, 8)), (), np.empty(0), everywhere=True)
        outlines = tuple(outline_of(zone.contours) for zone in zones)
        outside = np.array([float(zone.side == "outside") for zone in zones])
        free = Free(np.empty((0, 8)), outlines, outside)
        kept = np.empty((0, 8))
        for own in outlines:
            # an edge has what is free on one side; between two zones there is none
            middle, left = _middles(own)
            edge = free.holds(middle + _BESIDE * left) != free.holds(middle - _BESIDE * left)
            if len(kept):  # what two zones share is there once
                edge &= Free(kept, (), outside).gaps(middle) > _SAME
            kept = np.ascontiguousarray(np.concatenate((kept, own[edge])))
        return Free(kept, outlines, outside)

    def surface_of(self, zone: Zone) -> float:
        """Give how high the material along the edge of a zone is, m."""
        spot = zone.regions[0].outer.vertices[:1]
        about = [
            other.floor
            for other in self.zones
            if other is not zone and other.floor > zone.floor and self._frees(other, spot)
        ]
        return min(about, default=self.top)

    @staticmethod
    def _frees(zone: Zone, spot: FloatArray) -> bool:
        if zone.open:
            return True
        outside = np.array([float(zone.side == "outside")])
        rows = outline_of(zone.contours)
        return bool(Free(rows, (rows,), outside).holds(spot)[0])

    def floors(self, blank: HeightMap, *, cleared: bool = False) -> HeightMap:
        """Give how low the material may be cut, or how low it must be (``cleared``)."""
        heights = blank.heights.copy()
        for zone in self.zones:
            if cleared and not zone.cleared:
                continue
            inside = blank.covered(zone.contours)
            gone = inside if zone.side == "inside" else ~inside
            if zone.open and not cleared:
                gone = np.ones_like(inside)
            heights[gone] = np.minimum(heights[gone], zone.floor)
        found = HeightMap(heights=heights, corner=blank.corner, cell=blank.cell)
        for lines in () if cleared else self.lines:
            found, _ = found.carved(lines.moves, [lines.cutter] * len(lines.moves), lines.track)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Free:
    """Where a tool may be."""

    outline: FloatArray
    """Its edge: pieces as ``verify_kernel`` has them."""
    outlines: tuple[FloatArray, ...]
    """The outlines of what it is made of."""
    outside: FloatArray
    """1 for those of which the outside is free, else 0."""
    everywhere: bool = False
    """Whether it has no edge at all."""

    def holds(self, points: FloatArray) -> npt.NDArray[np.bool_]:
        """Say which points are in it, shape (m,)."""
        from .verify_kernel import frees

        if self.everywhere:
            return np.ones(len(points), dtype=bool)
        found = np.empty(len(points))
        frees(*self._joined(), np.ascontiguousarray(points[:, :2]), found)
        free: npt.NDArray[np.bool_] = found == 1.0
        return free

    def gaps(self, points: FloatArray) -> FloatArray:
        """Give how far points are from its edge, shape (m,), m."""
        from .verify_kernel import gaps

        found = np.empty(len(points))
        gaps(self.outline, np.ascontiguousarray(points[:, :2]), 0.0, found)
        return found

    def reachable(self, points: FloatArray, radius: float) -> npt.NDArray[np.bool_]:
        """Say which points a disc in it is proven to cover, shape (m,)."""
        from .verify_kernel import rooms

        if self.everywhere:
            return np.ones(len(points), dtype=bool)
        found = np.empty(len(points))
        spots = np.ascontiguousarray(points[:, :2])
        rooms(self.outline, *self._joined(), spots, radius, found)
        covered: npt.NDArray[np.bool_] = found >= radius * (1.0 - 1e-9) - 1e-12
        return covered

    def _joined(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give all outlines in one array, where each begins, and which are free outside."""
        starts = np.cumsum([0.0] + [len(rows) for rows in self.outlines])
        rows = np.concatenate(self.outlines) if self.outlines else np.empty((0, 8))
        return np.ascontiguousarray(rows), starts, self.outside


def _middles(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the middles of pieces and the unit vectors to their left there."""
    way = rows[:, 2:4] - rows[:, :2]
    chord = np.hypot(way[:, 0], way[:, 1])[:, None]
    right = np.column_stack((way[:, 1], -way[:, 0]))
    middle = 0.5 * (rows[:, :2] + rows[:, 2:4]) + 0.5 * np.tan(0.25 * rows[:, 7:8]) * right
    return middle, -right / chord


def edge_places(zone: Zone, apart: float, most: int) -> tuple[FloatArray, FloatArray]:
    """Give places within the pieces of a zone's edge and the way from each into the zone.

    Args:
        zone: The zone.
        apart: How far they are from each other, m.
        most: How many there are at the most, but for one a piece.

    Returns:
        Places and unit vectors, each of shape (m, 2).
    """
    rows = outline_of(zone.contours)
    chords = np.hypot(*(rows[:, 2:4] - rows[:, :2]).T)
    apart = max(apart, float(chords.sum()) / most)
    counts = np.maximum(1, np.ceil(chords / apart)).astype(int)
    which = np.repeat(np.arange(len(rows)), counts)
    number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    angle = rows[which, 7] * (number + 0.5) / counts[which]
    share = (number + 0.5) / counts[which]
    k, t = rows[which, 4], rows[which, 5:7]
    safe = np.where(k == 0.0, 1.0, k)
    grown = np.where(k == 0.0, share * chords[which], 2.0 * np.sin(0.5 * angle) / safe)
    places = rows[which, :2] + grown[:, None] * _turned(t, 0.5 * angle)
    tangent = _turned(t, angle)
    # a region lies to the left of its contours
    left = np.column_stack((-tangent[:, 1], tangent[:, 0]))
    return places, left if zone.side == "inside" else -left


def _turned(ways: FloatArray, angles: FloatArray) -> FloatArray:
    co, si = np.cos(angles), np.sin(angles)
    x, y = ways[:, 0], ways[:, 1]
    return np.column_stack((co * x - si * y, si * x + co * y))


def interior_places(zone: Zone, apart: float, most: int) -> FloatArray:
    """Give places of a grid within a zone, shape (m, 2), m."""
    bounds = np.array([region.bounds for region in zone.regions])
    (x0, y0), (x1, y1) = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    apart = max(apart, float(np.sqrt((x1 - x0) * (y1 - y0) / most)))
    x, y = (np.arange(a + 0.5 * apart, b, apart) for a, b in ((x0, x1), (y0, y1)))
    grid = np.column_stack([v.ravel() for v in np.meshgrid(x, y)])
    rows = outline_of(zone.contours)
    free = Free(rows, (rows,), np.zeros(1))
    return grid[free.holds(grid)]
