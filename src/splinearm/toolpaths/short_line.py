"""Runs of short lines as the smooth ways that they stand for.

A program made for controllers without splines says a curve by thousands of lines. Where it lets
corners be cut (G64 P) by so much that their roundings would touch, one spline within that tolerance
says the same, with far fewer pieces. Ends of lines that crowd together within a small share of the
tolerance count as one: which way a line of a micrometre points is rounding.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.approximation import approximate
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError

from .action import Feed, Move, SplineFeed
from .corner import DEVIATION, FREE

_FEWEST = 8
"""Fewer lines are left as they are."""

_MOST_TURN = 30.0
"""A spline turns about so much at most, rad: what takes long to fit is fitted in parts."""

_STRAIGHT = 0.6
"""Where unit directions differ by more there is a corner, however short its lines are."""

_FINEST = 5e-6
"""Tolerances below this are near what programs round to, m: a spline would follow the rounding."""

_CRUMB = 0.1
"""Ends of lines nearer to each other than this share of the tolerance are one."""

_SAGITTA = 1.3 / 8.0
"""Between its ends an arc is off a line by 1/8 of length times turn, and a spline by some more."""

JOINT = 0.2
"""Share of the tolerance that is kept for roundings where a spline goes over into what follows."""

_LEAST = 0.1
"""At the ends of lines a spline is given at least this share of the tolerance."""

_ONWARD = 0.5
"""A spline goes on along its lines by at least this share of its pace, or it is none: where a
figure turns back within the tolerance it would stand still."""

_BETWEEN = np.array([0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9])


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One way, and which of the given moves it stands for."""

    move: Move
    """The way."""
    first: int
    """The first of the moves."""
    count: int = 1
    """How many they are."""
    goes_on: bool = False
    """Whether one of it and the way before it is a spline, and no corner is between them."""


def smooth_runs(moves: Sequence[Move], begins: Collection[int]) -> list[Run]:
    """Give moves with runs of short lines as splines, each within the tolerance of its lines.

    Args:
        moves: The moves, each beginning where the one before it ends, none of length 0.
        begins: Moves before which something else is done: no run goes on there.
    """
    splines = {first: (last, move) for first, last, move in _splines(moves, begins)}
    found = list[Run]()
    k = 0
    while k < len(moves):
        last, move = splines.get(k, (k + 1, moves[k]))
        curved = last - k > 1 or bool(found and found[-1].count > 1)
        found.append(Run(move, k, last - k, curved and _goes_on(moves, k)))
        k = last
    return found


def _goes_on(moves: Sequence[Move], k: int) -> bool:
    """Say whether lines go on without a corner."""
    one, other = moves[k - 1], moves[k]
    if k == 0 or not (isinstance(one, Feed) and isinstance(other, Feed)):
        return False
    points = np.array([one.start, one.end, other.end])
    return bool(_turns(points)[1][0] <= _STRAIGHT)


def _splines(
    moves: Sequence[Move], begins: Collection[int]
) -> Iterator[tuple[int, int, SplineFeed]]:
    """Give splines with the first move that each stands for and the one behind the last."""
    for first, last in _alike_ones(moves, begins):
        lines = [move for move in moves[first:last] if isinstance(move, Feed)]
        points = np.array([lines[0].start, *(line.end for line in lines)])
        tolerance = _tolerance(lines[0])
        ends = _apart(points, _CRUMB * tolerance)
        crumbs = _CRUMB * (len(ends) < len(points))
        own = tolerance * (1.0 - JOINT - crumbs)
        for a, b in _smooth_parts(points[ends], own):
            for i, j, curve in _fitted(points[ends[a : b + 1]], own):
                one, other = int(ends[a + i]), int(ends[a + j])
                yield first + one, first + other, _as_move(lines[one:other], curve)


def _alike_ones(moves: Sequence[Move], begins: Collection[int]) -> list[tuple[int, int]]:
    """Give the first of lines that are alike, and the one behind their last."""
    goes_on = [_alike(*pair) for pair in pairwise(moves)]
    for i in begins:
        if 0 < i < len(moves):
            goes_on[i - 1] = False
    ends = [0, *(k + 1 for k, on in enumerate(goes_on) if not on), len(moves)]
    return [(a, b) for a, b in pairwise(ends) if b - a >= _FEWEST]


def _alike(one: Move, other: Move) -> bool:
    return (
        isinstance(one, Feed)
        and isinstance(other, Feed)
        and one.time is None
        and other.time is None
        and (one.feed, one.blend) == (other.feed, other.blend)
        and _tolerance(one) >= _FINEST
    )


def _tolerance(line: Feed) -> float:
    """Give how far the tool may be off a line, m; 0 where corners are kept."""
    return 0.0 if line.blend is None else min(line.blend, FREE)


def _apart(points: FloatArray, crumb: float) -> IndexArray:
    """Give which places to keep so that none are nearer to each other."""
    if np.linalg.norm(np.diff(points, axis=0), axis=1).min() > crumb:
        return np.arange(len(points))
    kept = [0]
    rows = points.tolist()
    for k in range(1, len(rows) - 1):
        if dist(rows[k], rows[kept[-1]]) > crumb:
            kept.append(k)
    if len(kept) > 1 and dist(rows[kept[-1]], rows[-1]) <= crumb:
        kept.pop()
    return np.array([*kept, len(rows) - 1])


def _smooth_parts(points: FloatArray, tolerance: float) -> list[tuple[int, int]]:
    """Give the first and the last place of each part without a corner that is too sharp."""
    lengths, turn = _turns(points)
    longest = np.maximum(lengths[:-1], lengths[1:])
    smooth = turn <= _STRAIGHT
    smooth &= max(0.5 * DEVIATION, _SAGITTA / (1.0 - _LEAST)) * turn * longest <= tolerance
    turned = np.cumsum(turn * smooth)
    smooth[np.flatnonzero(np.diff(turned // _MOST_TURN)) + 1] = False
    ends = [0, *(np.flatnonzero(~smooth) + 1).tolist(), len(points) - 1]
    return [(a, b) for a, b in pairwise(ends) if b - a >= _FEWEST]


def _turns(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the lengths of lines and by how much their unit directions differ."""
    ways = np.diff(points, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    return lengths, np.linalg.norm(np.diff(ways / lengths[:, None], axis=0), axis=1)


def _fitted(points: FloatArray, tolerance: float) -> Iterator[tuple[int, int, BSpline]]:
    """Give curves, each with its first and last place; parts that have none are halved."""
    todo = [(0, len(points) - 1)]
    while todo:
        i, j = todo.pop()
        if j - i < _FEWEST:
            continue
        curve = _curve(points[i : j + 1], tolerance)
        if curve is not None:
            yield i, j, curve
        else:
            todo += [((i + j) // 2, j), (i, (i + j) // 2)]


def _curve(points: FloatArray, tolerance: float) -> BSpline | None:
    """Give the curve that lines stand for; None if there is none within their tolerance."""
    ways = np.diff(points, axis=0)
    lengths, turn = _turns(points)
    u = np.concatenate(([0.0], np.cumsum(lengths)))
    bulge = _SAGITTA * float((np.maximum(lengths[1:], lengths[:-1]) * turn).max())
    if tolerance - bulge < _LEAST * tolerance:
        return None
    try:
        curve, _ = approximate(points, tolerance - bulge, parameters=u)
    except CurveError:
        return None
    at = (u[:-1, None] + _BETWEEN * lengths[:, None]).ravel()
    wanted = (points[:-1, None] + _BETWEEN[:, None] * ways[:, None]).reshape(-1, points.shape[1])
    if np.linalg.norm(curve.at(at) - wanted, axis=1).max() > tolerance:
        return None
    pace = curve.at(at, 1)
    along = np.repeat(ways / lengths[:, None], len(_BETWEEN), axis=0)
    return curve if float((pace * along).sum(axis=1).min()) >= _ONWARD else None


def _as_move(lines: Sequence[Feed], curve: BSpline) -> SplineFeed:
    first, last = lines[0], lines[-1]
    return SplineFeed(
        line=first.line, start=first.start, end=last.end, feed=first.feed, blend=first.blend,
        curve=curve,
    )  # fmt: skip
