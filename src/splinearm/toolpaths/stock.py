"""Stock: the block of material a program is run on, and what is left of it as heights."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, sqrt, tan

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray, frozen_array

from .action import Feed, Move, Rapid
from .contour import Contour
from .cutter import Cutter, Tip
from .region import Region
from .verify_way import Track

_KINDS = {Tip.FLAT: 0.0, Tip.BALL: 1.0, Tip.POINT: 2.0}
_CHORD = 0.01
"""Share of a cell by which chords may be off their arcs."""
_AIR = 1.0 - 1e-6
"""Rapid ways are looked at with a tool by this thinner: rounding touches nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Stock:
    """A block of material, its sides along the axes."""

    low: FloatArray
    """Its lowest corner, shape (3,), m."""
    high: FloatArray
    """Its highest corner, shape (3,), m; the third is its surface."""

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (3,), name))
        if not (self.low < self.high).all():
            raise ValueError(
                f"high: want it above {self.low.tolist()} in x, y and z, got {self.high.tolist()}"
            )

    @classmethod
    def about(cls, region: Region, *, margin: float, top: float = 0.0, thick: float) -> "Stock":
        """Give the block about a region.

        Args:
            region: The region.
            margin: How far the block reaches beyond it on all sides, m.
            top: Its surface, m.
            thick: How thick it is, m.
        """
        x0, y0, x1, y1 = region.bounds
        low = np.array([x0 - margin, y0 - margin, top - thick])
        return cls(low, np.array([x1 + margin, y1 + margin, top]))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class HeightMap:
    """Heights of the material in the middles of square cells."""

    heights: FloatArray
    """By row (y) and column (x), m."""
    corner: FloatArray
    """x and y of the middle of the first cell, shape (2,), m."""
    cell: float
    """Size of a cell, m."""

    @classmethod
    def of(cls, stock: Stock, cell: float) -> "HeightMap":
        """Give a block that nothing was done to."""
        size = stock.high[:2] - stock.low[:2]
        columns, rows = (max(1, ceil(s / cell)) for s in size.tolist())
        corner = stock.low[:2] + 0.5 * (size - cell * np.array([columns - 1, rows - 1]))
        heights = np.full((rows, columns), float(stock.high[2]))
        return cls(heights=heights, corner=corner, cell=cell)

    @property
    def grid(self) -> tuple[float, float, float]:
        """Where the first cell is, and their size."""
        return float(self.corner[0]), float(self.corner[1]), self.cell

    def place(self, row: int, column: int) -> tuple[float, float, float]:
        """Give where the top of a cell is, m."""
        x, y = self.corner + self.cell * np.array([column, row])
        return float(x), float(y), float(self.heights[row, column])

    def covered(self, contours: Sequence[Contour]) -> npt.NDArray[np.bool_]:
        """Say which cells' middles contours go around an odd number of times."""
        from .stock_kernel import filled

        loops = [contour.flattened(_CHORD * self.cell) for contour in contours]
        starts = np.cumsum([0.0] + [len(loop) for loop in loops])
        found = np.empty_like(self.heights)
        filled(np.concatenate(loops), starts, self.grid, found)
        inside: npt.NDArray[np.bool_] = found == 1.0
        return inside

    def carved(
        self, moves: Sequence[Move], cutters: Sequence[Cutter], track: Track
    ) -> tuple["HeightMap", FloatArray]:
        """Give what is left behind moves, and what each did.

        Args:
            moves: The moves.
            cutters: The cutter of each.
            track: Their pieces.

        Returns:
            The map, and by move how deep it goes into the material, where (x, y), and how much of
            it is taken away, shape (moves, 4).
        """
        from .stock_kernel import carve

        ways, owners = _chords(moves, track, _CHORD * self.cell)
        tools = np.array([_tool(c, _AIR if isinstance(m, Rapid) else 1.0)
                          for c, m in zip(cutters, moves, strict=True)]).reshape(-1, 3)  # fmt: skip
        heights, found = self.heights.copy(), np.empty((len(ways), 4))
        carve(heights, self.grid, ways, np.ascontiguousarray(tools[owners]), found)
        left = HeightMap(heights=heights, corner=self.corner, cell=self.cell)
        return left, _by_move(found, owners, len(moves))


def cell_for(stock: Stock, most: int = 400_000) -> float:
    """Give the size of cells of which a block has about so many, m."""
    x, y, _ = (stock.high - stock.low).tolist()
    return sqrt(x * y / most)


def _tool(cutter: Cutter, share: float) -> tuple[float, float, float]:
    slope = 1.0 / tan(0.5 * cutter.tip_angle) if cutter.tip is Tip.POINT else 0.0
    return _KINDS[cutter.tip], share * cutter.radius, slope


def _chords(
    moves: Sequence[Move], track: Track, tolerance: float
) -> tuple[FloatArray, npt.NDArray[np.intp]]:
    """Give straight ways along pieces, and their moves."""
    k, turn = track.pieces[:, 4], np.abs(track.pieces[:, 7])
    radius = 1.0 / np.where(k == 0.0, 1.0, np.abs(k))
    step = 2.0 * np.arccos(1.0 - np.minimum(1.0, tolerance / radius))
    counts = np.where(k == 0.0, 1, np.ceil(turn / step)).astype(int)
    counts = np.maximum(counts, 1)
    which = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    parts = track.parts(number / counts[which], (number + 1) / counts[which], which)
    begin, end = parts.pieces[:, :2], parts.pieces[:, 2:4]
    ways = np.column_stack((begin, parts.heights[:, 0], end, parts.heights[:, 1]))
    owners = parts.owners.astype(np.intp)
    # a straight move has one way, exactly its own
    straight = np.array([isinstance(move, Rapid | Feed) for move in moves], dtype=bool)
    for i in np.flatnonzero(straight[owners]):
        move = moves[owners[i]]
        ways[i, :3], ways[i, 3:] = move.start, move.end
    return ways, owners


def _by_move(found: FloatArray, owners: npt.NDArray[np.intp], count: int) -> FloatArray:
    """Give of the ways of each move the deepest, and the sum of what they take."""
    done = np.zeros((count, 4))
    order = np.argsort(found[:, 0], kind="stable")
    done[owners[order], :3] = found[order, :3]  # the deepest is written last
    done[:, 3] = np.bincount(owners, weights=found[:, 3], minlength=count)
    return done
