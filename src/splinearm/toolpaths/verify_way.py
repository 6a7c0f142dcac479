"""Ways of a tool and outlines of a part as pieces to be measured: lines and short arcs."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, pi

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline

from .action import ArcFeed, Feed, Move, Rapid
from .contour import Contour

BOUND = 1e-9
"""How far pieces may stray from a spline or an arc that is not level, m."""

_QUARTER = 0.5 * pi * (1.0 - 1e-12)
_MOST = 1 << 14
_LOOKS = np.array([0.25, 0.75])


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Track:
    """Pieces of ways one after the other."""

    pieces: FloatArray
    """Rows as ``verify_kernel`` has them, shape (m, 8)."""
    heights: FloatArray
    """Where the tip begins and ends, shape (m, 2), m."""
    owners: FloatArray
    """Which of the moves each piece is of, shape (m,)."""
    bound: float
    """How far the pieces are from the ways at the most, m."""

    def where(self, kept: npt.NDArray[np.bool_]) -> "Track":
        """Give some of the pieces."""
        return Track(
            pieces=self.pieces[kept],
            heights=self.heights[kept],
            owners=self.owners[kept],
            bound=self.bound,
        )

    def below(self, level: float) -> "Track":
        """Give what is lower than a level; pieces that pass through it end there."""
        kept = self.where(self.heights.min(axis=1) < level)
        first, last = kept.heights[:, 0], kept.heights[:, 1]
        rise = np.where(first == last, 1.0, last - first)
        at = np.clip((level - first) / rise, 0.0, 1.0)
        begin, end = np.where(first > level, at, 0.0), np.where(last > level, at, 1.0)
        return kept.parts(begin, end, np.arange(len(first)))

    def gaps(self, places: FloatArray, near: float = 0.0) -> FloatArray:
        """Give how far places are from the nearest piece, shape (m,), m; inf where there is none.

        Args:
            places: The places, shape (m, 2), m.
            near: What is nearer than this need not be known better, m.
        """
        from .verify_kernel import gaps

        far = np.full(len(places), np.inf)
        if len(self.pieces):
            gaps(np.ascontiguousarray(self.pieces), np.ascontiguousarray(places), near, far)
        return far

    def fine(self, longest: float, steepest: float = np.inf) -> "Track":
        """Give the same in pieces up to a length and a rise, m."""
        ends = self.pieces[:, :4]
        chords = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1])
        rises = np.abs(self.heights[:, 1] - self.heights[:, 0])
        counts = np.ceil(np.maximum(1.2 * chords / longest, rises / steepest))
        counts = np.clip(counts, 1, _MOST).astype(int)
        which = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
        return self.parts(number / counts[which], (number + 1) / counts[which], which)

    def parts(self, begin: FloatArray, end: FloatArray, which: IndexArray) -> "Track":
        """Give parts of pieces between two shares of each."""
        rows, heights = self.pieces[which], self.heights[which]
        way, turn = rows[:, 2:4] - rows[:, :2], rows[:, 7]
        places = [rows[:, :2] + _grown(way, turn, share) for share in (begin, end)]
        places[0][begin == 0.0] = rows[begin == 0.0, :2]
        places[1][end == 1.0] = rows[end == 1.0, 2:4]
        rise = heights[:, 1] - heights[:, 0]
        return Track(
            pieces=rows_of(np.hstack(places), turn * (end - begin)),
            heights=np.column_stack((heights[:, 0] + begin * rise, heights[:, 0] + end * rise)),
            owners=self.owners[which],
            bound=self.bound,
        )


def track_of(moves: Sequence[Move]) -> Track:
    """Give the pieces of moves in the plane; those of a plunge are points."""
    ends: list[FloatArray] = []
    turns: list[FloatArray] = []
    heights: list[FloatArray] = []
    owners: list[int] = []
    bound = 0.0
    for k, move in enumerate(moves):
        places, turn, off = _pieces(move)
        bound = max(bound, off)
        ends.append(np.hstack((places[:-1, :2], places[1:, :2])))
        heights.append(np.column_stack((places[:-1, 2], places[1:, 2])))
        turns.append(turn)
        owners += [k] * len(turn)
    if not owners:
        empty = np.empty((0, 8)), np.empty((0, 2))
        return Track(pieces=empty[0], heights=empty[1], owners=np.empty(0), bound=0.0)
    return Track(
        pieces=rows_of(np.concatenate(ends), np.concatenate(turns)),
        heights=np.concatenate(heights),
        owners=np.array(owners, dtype=np.float64),
        bound=bound,
    )


def outline_of(contours: Iterable[Contour]) -> FloatArray:
    """Give contours as pieces of at most a quarter turn, shape (m, 8)."""
    ends, turns = list[FloatArray](), list[FloatArray]()
    for contour in contours:
        kept = (contour.starts != contour.ends).any(axis=1)
        starts, stops = contour.starts[kept], contour.ends[kept]
        bulges = contour.bulges[kept]
        turn = 4.0 * np.arctan(bulges)
        for count in (1, 2, 4):
            few = np.ceil(np.abs(turn) / _QUARTER) <= count
            more = np.ceil(np.abs(turn) / _QUARTER) > count // 2 if count > 1 else np.ones_like(few)
            chosen = np.flatnonzero(few & more)
            places = _along_arcs(starts[chosen], stops[chosen], turn[chosen], count)
            for a, b in pairwise(places):
                ends.append(np.hstack((a, b)))
                turns.append(turn[chosen] / count)
    if not ends:
        return np.empty((0, 8))
    rows = rows_of(np.concatenate(ends), np.concatenate(turns))
    # neighbours in the plane become neighbours in the list again
    return rows[_along_a_snake(rows)]


def rows_of(ends: FloatArray, turns: FloatArray) -> FloatArray:
    """Give rows of pieces from their ends, shape (m, 4), and turns, at most a quarter each."""
    way = ends[:, 2:] - ends[:, :2]
    chord = np.hypot(way[:, 0], way[:, 1])
    safe = np.where(chord > 0.0, chord, 1.0)
    rows = np.empty((len(ends), 8))
    rows[:, :4] = ends
    rows[:, 4] = np.where(chord > 0.0, 2.0 * np.sin(0.5 * turns) / safe, 0.0)
    co, si = np.cos(0.5 * turns), np.sin(0.5 * turns)
    # the tangent is the chord turned back by half the turn
    rows[:, 5] = (co * way[:, 0] + si * way[:, 1]) / safe
    rows[:, 6] = (-si * way[:, 0] + co * way[:, 1]) / safe
    rows[:, 7] = np.where(chord > 0.0, turns, 0.0)
    return rows


def _pieces(move: Move) -> tuple[FloatArray, FloatArray, float]:
    """Give the places where the pieces of a move meet, their turns, and how far they stray."""
    if isinstance(move, Rapid | Feed):
        return np.array([move.start, move.end]), np.zeros(1), 0.0
    if isinstance(move, ArcFeed):
        if move.axis == 2:
            count = max(1, ceil(abs(move.turn) / _QUARTER))
            places = move.at(np.linspace(0.0, 1.0, count + 1))
            off = abs(move.radius_at_start - float(np.hypot(*(move.end - move.centre)[:2])))
            return _shut(places, move), np.full(count, move.turn / count), off
        count = max(2, ceil(abs(move.turn) * (move.radius_at_start / (8.0 * 1e-7)) ** 0.5))
        count = min(count, _MOST)
        off = move.radius_at_start * (move.turn / count) ** 2 / 8.0
        return _shut(move.at(np.linspace(0.0, 1.0, count + 1)), move), np.zeros(count), off
    return _of_spline(move.curve)


def _shut(places: FloatArray, move: ArcFeed) -> FloatArray:
    """Let places begin and end where their arc does."""
    places[0], places[-1] = move.start, move.end
    return places


def _of_spline(curve: BSpline) -> tuple[FloatArray, FloatArray, float]:
    """Give arcs through three places of a spline each, so many that they are close to it."""
    places, turns, worst = [curve.at(curve.domain[0])[None]], list[FloatArray](), 0.0
    for a, b in pairwise(curve.breaks):
        count = 4
        while True:
            u = np.linspace(a, b, 2 * count + 1)
            p = curve.at(u)
            begin, middle, end = p[:-1:2], p[1::2], p[2::2]
            turn = _turns(begin, middle, end)
            rows = rows_of(np.hstack((begin[:, :2], end[:, :2])), turn)
            off = 0.0
            for look in _LOOKS:
                between = curve.at(u[:-1:2] + look * (u[2::2] - u[:-1:2]))
                off = max(off, float(_beside(rows, between).max()))
            # the misfit is a quartic with its zeros at the three places: its peaks are near
            if 1.5 * off <= BOUND or count >= _MOST:
                break
            count *= 2
        places.append(end)
        turns.append(turn)
        worst = max(worst, 1.5 * off)
    return np.concatenate(places), np.concatenate(turns), worst


def _turns(begin: FloatArray, middle: FloatArray, end: FloatArray) -> FloatArray:
    """Give how far arcs through three places turn."""
    v, w = middle[:, :2] - begin[:, :2], end[:, :2] - middle[:, :2]
    bend = np.arctan2(v[:, 0] * w[:, 1] - v[:, 1] * w[:, 0], (v * w).sum(axis=1))
    turns: FloatArray = np.clip(2.0 * bend, -_QUARTER, _QUARTER)
    return turns


def _beside(rows: FloatArray, points: FloatArray) -> FloatArray:
    """Give how far points are from the circles of rows, one each."""
    k = rows[:, 4]
    p = points[:, :2] - rows[:, :2]
    left = -p[:, 0] * rows[:, 6] + p[:, 1] * rows[:, 5]
    power = k * (p * p).sum(axis=1) - 2.0 * left
    far = np.hypot(k * p[:, 0] + rows[:, 6], k * p[:, 1] - rows[:, 5])
    away: FloatArray = np.abs(power / (1.0 + far))
    return away


def _along_arcs(
    starts: FloatArray, stops: FloatArray, turns: FloatArray, count: int
) -> list[FloatArray]:
    """Give the places that part arcs into so many, ends and all."""
    way = stops - starts
    places = [starts]
    places += [starts + _grown(way, turns, np.full(len(way), k / count)) for k in range(1, count)]
    places.append(stops)
    return places


def _grown(ways: FloatArray, turns: FloatArray, shares: FloatArray) -> FloatArray:
    """Give how far the places at shares of arcs are from their starts."""
    bent = turns != 0.0
    half = np.where(bent, 0.5 * turns, 1.0)
    grown = np.where(bent, np.sin(shares * half) / np.sin(half), shares)
    bend = np.where(bent, (shares - 1.0) * half, 0.0)
    co, si = grown * np.cos(bend), grown * np.sin(bend)
    x, y = ways[:, 0], ways[:, 1]
    return np.stack((co * x - si * y, si * x + co * y), axis=1)


def _along_a_snake(rows: FloatArray) -> IndexArray:
    """Give an order of pieces in which neighbours are near each other: band after band."""
    middle = 0.5 * (rows[:, :2] + rows[:, 2:4])
    low = middle.min(axis=0)
    size = float(np.ptp(middle, axis=0).max()) or 1.0
    bands = max(1.0, np.sqrt(len(rows)) / 3.0)
    spot = np.floor((middle - low) / size * bands)
    forth = np.where(spot[:, 0] % 2.0 == 0.0, middle[:, 1], -middle[:, 1])
    return np.lexsort((forth, spot[:, 0]))
