"""The check of what goes on lines of a drawing: each way on a line, and each line cut."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline

from .action import ArcFeed, Feed, Move, SplineFeed
from .cutter import Cutter
from .piece import ArcPiece, LinePiece, Piece
from .verify_report import Fault
from .verify_way import Track, track_of
from .wire import Wire

_PLACES = 20_000
"""Ways and lines are looked at in about so many places each, and at both ends of every piece."""
_FINEST = 1e-5
"""Places are no nearer to each other, m."""
_SAME = 1e-9


@dataclass(frozen=True, eq=False, kw_only=True)
class Lines:
    """Lines of a drawing on which the middle of a cutter goes."""

    wires: tuple[Wire, ...]
    """The lines."""
    floor: float
    """How low the cutter's tip goes on them, m."""
    cutter: Cutter
    """The cutter."""
    slack: float = 0.0
    """How far ways may be beside them, m."""
    tab_height: float = 0.0
    """How high tabs may be that are left on half of them at most, m."""

    def __post_init__(self) -> None:
        if not self.wires:
            raise ValueError("wires: want at least one")
        if not np.isfinite(self.floor):
            raise ValueError(f"floor: want a finite height, got {self.floor}")

    @cached_property
    def moves(self) -> tuple[Move, ...]:
        """The lines as ways at their floor."""
        return tuple(_way(piece, self.floor) for wire in self.wires for piece in wire.pieces)

    @cached_property
    def track(self) -> Track:
        """The pieces of these ways."""
        return track_of(self.moves)

    def carry(self, track: Track, tolerance: float) -> npt.NDArray[np.bool_]:
        """Say which pieces of ways are on them and not below their floor, shape (m,)."""
        which, places = _looks(track)
        near = self.track.gaps(places, 0.1 * _SAME) <= self.slack + tolerance
        on = np.ones(len(track.pieces), dtype=bool)
        np.logical_and.at(on, which, near)
        shallow: npt.NDArray[np.bool_] = track.heights.min(axis=1) >= self.floor - tolerance
        return on & shallow

    def left(self, cut: Track, tolerance: float) -> tuple[float, Iterator[Fault]]:
        """Give by how much lines are missed at most, and what is wrong.

        Args:
            cut: The pieces of what is cut.
            tolerance: By how much they may be missed, m.
        """
        _, places = _looks(self.track)
        missed = self._missed(cut, places, self.floor)
        if self.tab_height and (missed > self.slack + tolerance).mean() <= 0.5:
            missed = self._missed(cut, places, self.floor + self.tab_height)
        return float(missed.max()), self._faults(places, missed, tolerance)

    def _missed(self, cut: Track, places: FloatArray, height: float) -> FloatArray:
        return cut.below(height + 1e-7).gaps(places, 0.1 * _SAME)

    def _faults(self, places: FloatArray, missed: FloatArray, tolerance: float) -> Iterator[Fault]:
        wrong = missed > self.slack + tolerance
        if not wrong.any():
            return
        i = int(np.argmax(missed))
        x, y = places[i].tolist()
        amount = float(missed[i])
        far = f"the nearest cut is {amount * 1e3:.6g} mm away" if np.isfinite(amount) else "no cut"
        yield Fault(
            kind="left over",
            where=(x, y, self.floor),
            amount=amount,
            count=int(wrong.sum()),
            says=f"leaves a line of the drawing uncut: {far}",
        )


def off_lines(track: Track, lines: Sequence[Lines], tolerance: float) -> Track:
    """Give the pieces of ways that are on no line."""
    kept = np.ones(len(track.pieces), dtype=bool)
    for one in lines:
        rest = np.flatnonzero(kept)
        kept[rest[one.carry(track.where(kept), tolerance)]] = False
    return track.where(kept)


def _looks(track: Track) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Give places within the pieces of ways: of which piece each is, (k,), and where, (k, 2)."""
    rows = track.pieces
    lengths = np.hypot(*(rows[:, 2:4] - rows[:, :2]).T)
    apart = max(_FINEST, float(lengths.sum()) / _PLACES)
    counts = np.maximum(2, np.ceil(lengths / apart)).astype(int) + 1
    which = np.repeat(np.arange(len(rows)), counts)
    number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = number / (counts - 1)[which]
    ends = track.parts(np.zeros(len(which)), share, which).pieces[:, 2:4]
    return which, np.ascontiguousarray(ends)


def _way(piece: Piece, z: float) -> Move:
    start, end = np.array([*piece.start, z]), np.array([*piece.end, z])
    if isinstance(piece, LinePiece):
        return Feed(start=start, end=end, feed=None)
    if isinstance(piece, ArcPiece):
        centre = np.array([*piece.centre, z])
        return ArcFeed(start=start, end=end, feed=None, centre=centre, axis=2, turn=piece.turn)
    flat = piece.curve
    points = np.column_stack((flat.points, np.full(len(flat.points), z)))
    curve = BSpline(flat.knots, points, flat.degree, flat.weights)
    return SplineFeed(start=start, end=end, feed=None, curve=curve)
