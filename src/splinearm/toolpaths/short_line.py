"""Runs of short lines as the smooth ways that they stand for.

A program made for controllers without splines says a curve by thousands of lines. Where it lets
corners be cut (G64 P) by so much that their roundings would touch, one spline within that tolerance
says the same, with far fewer pieces.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.curves.approximation import approximate
from splinearm.errors import CurveError

from .action import Feed, Move, SplineFeed
from .corner import DEVIATION, FREE

_FEWEST = 8
"""Fewer lines are left as they are."""

_STRAIGHT = 0.6
"""Where unit directions differ by more there is a corner, however short its lines are."""

_FINEST = 5e-6
"""Tolerances below this are near what programs round to, m: a spline would follow the rounding."""

_SAGITTA = 1.3 / 8.0
"""Between its ends an arc is off a line by 1/8 of length times turn, and a spline by some more."""

_LEAST = 0.1
"""At the ends of lines a spline is given at least this share of the tolerance."""

_BETWEEN = (0.25, 0.5, 0.75)


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One way, and which of the given moves it stands for."""

    move: Move
    """The way."""
    first: int
    """The first of the moves."""
    count: int = 1
    """How many they are."""


def smooth_runs(moves: Sequence[Move], begins: Collection[int]) -> list[Run]:
    """Give moves with runs of short lines as splines, each within the tolerance of its lines.

    Args:
        moves: The moves, each beginning where the one before it ends, none of length 0.
        begins: Moves before which something else is done: no run goes on there.
    """
    found = list[Run]()
    k = 0
    for first, last in _runs(moves, begins):
        found += [Run(moves[i], i) for i in range(k, first)]
        spline = _spline([move for move in moves[first:last] if isinstance(move, Feed)])
        if spline is None:
            found += [Run(moves[i], i) for i in range(first, last)]
        else:
            found.append(Run(spline, first, last - first))
        k = last
    return found + [Run(moves[i], i) for i in range(k, len(moves))]


def _runs(moves: Sequence[Move], begins: Collection[int]) -> list[tuple[int, int]]:
    """Give the first of each run and the one behind its last."""
    if len(moves) < _FEWEST:
        return []
    goes_on = _smooth_corners(moves)
    goes_on[[i - 1 for i in begins if 0 < i < len(moves)]] = False
    breaks = np.flatnonzero(~goes_on) + 1
    ends = [0, *breaks.tolist(), len(moves)]
    return [(a, b) for a, b in pairwise(ends) if b - a >= _FEWEST]


def _smooth_corners(moves: Sequence[Move]) -> npt.NDArray[np.bool_]:
    """Say whether a run may go on from each move to the next, shape (m - 1,)."""
    ways = np.array([move.end - move.start for move in moves])
    lengths = np.linalg.norm(ways, axis=1)
    directions = ways / lengths[:, None]
    turn = np.linalg.norm(np.diff(directions, axis=0), axis=1)
    blend = np.array([_tolerance(move) for move in moves])
    tolerance = np.minimum(blend[:-1], blend[1:])
    touching = tolerance >= DEVIATION * turn * 0.5 * np.maximum(lengths[:-1], lengths[1:])
    alike = np.array([_alike(*pair) for pair in pairwise(moves)])
    smooth: npt.NDArray[np.bool_] = (turn <= _STRAIGHT) & (tolerance >= _FINEST)
    smooth &= touching & alike
    return smooth


def _tolerance(move: Move) -> float:
    """Give how far the tool may be off a move, m; 0 where it is no line or corners are kept."""
    if not isinstance(move, Feed) or move.blend is None or move.time is not None:
        return 0.0
    return min(move.blend, FREE)


def _alike(one: Move, other: Move) -> bool:
    return (
        isinstance(one, Feed)
        and isinstance(other, Feed)
        and (one.feed, one.blend) == (other.feed, other.blend)
    )


def _spline(lines: Sequence[Feed]) -> SplineFeed | None:
    """Give the spline that lines stand for; None if there is none within their tolerance."""
    tolerance = _tolerance(lines[0])
    points = np.array([lines[0].start, *(line.end for line in lines)])
    ways = np.diff(points, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    u = np.concatenate(([0.0], np.cumsum(lengths)))
    turn = np.linalg.norm(np.diff(ways / lengths[:, None], axis=0), axis=1)
    bulge = _SAGITTA * float((np.maximum(lengths[1:], lengths[:-1]) * turn).max())
    if tolerance - bulge < _LEAST * tolerance:
        return None
    try:
        curve, _ = approximate(points, tolerance - bulge, parameters=u)
    except CurveError:
        return None
    for share in _BETWEEN:
        wanted = points[:-1] + share * ways
        if _farthest(curve.at(u[:-1] + share * np.diff(u)) - wanted) > tolerance:
            return None
    first, last = lines[0], lines[-1]
    return SplineFeed(
        line=first.line, start=first.start, end=last.end, feed=first.feed, blend=first.blend,
        curve=curve,
    )  # fmt: skip


def _farthest(gaps: FloatArray) -> float:
    return float(np.linalg.norm(gaps, axis=1).max())
