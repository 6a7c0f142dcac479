"""A program as stages: smooth ways of the tool from rest to rest, and what is done between them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.hermite import Jet, quintic_spline

from .action import Action, ArcFeed, Dwell, Feed, Message, Move, Rapid, SplineFeed
from .corner import FREE, half_widths
from .short_line import JOINT, smooth_runs
from .stroke import Strokes, bends, strokes_of

_NOTHING = 1e-9
"""A shorter way is none, m."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Stage:
    """A smooth way from rest to rest."""

    position: BSpline
    """Where the tool goes, by the way from the program's start, m."""
    edges: FloatArray
    """Where on it the program's ways begin and end, shape (k + 1,), m."""
    moves: tuple[Move, ...]
    """Which move each of them is of, k."""
    before: tuple[Action, ...]
    """What is done before it, besides moving."""
    within: tuple[tuple[int, Action], ...]
    """What is said on the way, where each of these ways begins."""

    names: tuple[str, ...]
    """What messages call each of them: by the line of the program, else by its number."""

    @property
    def lines(self) -> tuple[int, ...]:
        """The line of the program that each way is of; 0: none."""
        return tuple(move.line for move in self.moves)

    @property
    def speeds(self) -> FloatArray:
        """How fast the tool shall go on each way, m/s, shape (k,); inf: as fast as it can."""
        return np.array([speed_of(move) for move in self.moves])


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Itinerary:
    """All stages of a program."""

    stages: tuple[Stage, ...]
    """The stages; the tool rests between them."""
    after: tuple[Action, ...]
    """What is done after the last."""
    length: float
    """How long the whole way is, m."""
    notes: tuple[str, ...] = ()
    """What was changed, for people."""


@dataclass(slots=True)
class _Read:
    """Moves and what is done between them."""

    moves: list[Move] = field(default_factory=list)
    before: dict[int, list[Action]] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)
    joints: frozenset[int] = frozenset()
    """Moves that go on from the one before them without a corner, one of both a fitted spline."""
    dropped: int = 0
    comes_down: bool = False

    def name(self, first: int, count: int = 1) -> str:
        """Say which moves they are."""
        if self.comes_down and first == 0:
            return "the way down to the start"
        begin = self.moves[first].line
        what = "line" if begin else "move"
        begin = begin or first + 1 - self.comes_down
        if count == 1:
            return f"{what} {begin}"
        end = self.moves[first + count - 1].line or begin + count - 1
        return f"{what}s {begin} to {end}"

    def smoothed(self) -> "_Read":
        """Give the same with short lines as splines."""
        runs = smooth_runs(self.moves, self.before)
        begins = [run.first for run in runs] + [len(self.moves)]
        return replace(
            self,
            moves=[run.move for run in runs],
            before={i: self.before[k] for i, k in enumerate(begins) if k in self.before},
            names=[self.name(run.first, run.count) for run in runs],
            joints=frozenset(i for i, run in enumerate(runs) if run.goes_on),
        )


def speed_of(move: Move) -> float:
    """Give how fast the tool shall go, m/s; inf: as fast as it can."""
    if isinstance(move, Rapid):
        return inf
    if move.time is not None:
        return move.length / move.time
    return inf if move.feed is None else move.feed


def itinerary_of(
    actions: Sequence[Action],
    T_base_work: FloatArray,
    *,
    lift: FloatArray | None = None,
    flat: bool = False,
) -> Itinerary:
    """Give what a machine does as stages in the arm's base frame.

    The way begins where the first rapid way ends: how the tool gets there is the arm's affair.

    Args:
        actions: What is done, in coordinates of the work.
        T_base_work: Where the work is, shape (4, 4).
        lift: From where the tool comes to its first place, in coordinates of the work, shape (3,),
            m; None: it starts there.
        flat: Whether the arm has no height: what is above or below is then left out.

    Raises:
        ValueError: If no action moves the tool.
    """
    read = _read(actions, lift, flat=flat)
    if not read.moves:
        raise ValueError("actions: want some that move the tool, got none")
    read = read.smoothed()
    strokes = strokes_of(read.moves).moved(T_base_work)
    widths, stops = _roundings(strokes, read)
    begins = [0, *np.flatnonzero(stops).tolist()]
    ends = [*begins[1:], len(strokes.owners)]
    stages = tuple(
        Stage(
            position=_position(strokes, widths, begin, end),
            edges=strokes.edges[begin : end + 1],
            moves=tuple(read.moves[owner] for owner in strokes.owners[begin:end]),
            names=tuple(read.names[owner] for owner in strokes.owners[begin:end]),
            before=_done_before(strokes, read, begin),
            within=tuple(
                (way - begin, action)
                for way in range(begin + 1, end)
                for action in _done_before(strokes, read, way)
            ),
        )
        for begin, end in zip(begins, ends, strict=True)
    )
    dropped = f"this arm has no height: {read.dropped} ways up or down are left out"
    return Itinerary(
        stages=stages,
        after=tuple(read.before.get(len(read.moves), ())),
        length=float(strokes.edges[-1]),
        notes=(dropped,) if read.dropped else (),
    )


def _read(actions: Sequence[Action], lift: FloatArray | None, *, flat: bool) -> _Read:
    """Take moves and what is between them apart."""
    read = _Read()
    begun = False
    for action in actions:
        if not isinstance(action, Rapid | Feed | ArcFeed | SplineFeed):
            read.before.setdefault(len(read.moves), []).append(action)
            continue
        move: Move = _flattened(action) if flat else action
        if not begun:
            begun = True
            first = move.end if isinstance(move, Rapid) else move.start
            if lift is not None and not flat:
                read.moves.append(Rapid(line=0, start=first + lift, end=first))
                read.comes_down = True
            if isinstance(move, Rapid):
                continue
        if isinstance(move, Rapid | Feed) and read.moves:
            move = replace(move, start=read.moves[-1].end)
        if move.length <= _NOTHING:
            read.dropped += flat
            continue
        read.moves.append(move)
    return read


def _flattened(move: Move) -> Move:
    if isinstance(move, ArcFeed):
        if move.axis != 2:
            raise ValueError(f"line {move.line}: this arm has no height for an arc in G18 or G19")
        return replace(
            move,
            start=move.start * (1.0, 1.0, 0.0),
            end=move.end * (1.0, 1.0, 0.0),
            centre=move.centre * (1.0, 1.0, 0.0),
        )
    if isinstance(move, SplineFeed):
        curve = move.curve
        level = BSpline(curve.knots, curve.points * (1.0, 1.0, 0.0), curve.degree, curve.weights)
        return replace(move, curve=level, start=level.points[0], end=level.points[-1])
    return replace(move, start=move.start * (1.0, 1.0, 0.0), end=move.end * (1.0, 1.0, 0.0))


def _roundings(
    strokes: Strokes, read: _Read
) -> tuple[FloatArray, "np.ndarray[tuple[int], np.dtype[np.bool_]]"]:
    """Give half widths of the roundings, (m + 1, 2), and which ways begin at rest, (m,)."""
    m = len(strokes.owners)
    widths, stops = np.zeros((m + 1, 2)), np.zeros(m, dtype=bool)
    if m < 2:
        return widths, stops
    at = np.arange(1, m)
    edge = strokes.edges[1:-1]
    behind, ahead = strokes.jets(edge, at - 1), strokes.jets(edge, at)
    turn, bent = bends(behind, ahead)
    kink = np.linalg.norm(ahead[2] - behind[2], axis=1)
    tolerance = np.array([_blend(read, int(i), int(j)) for i, j in _pairs(strokes)])
    stops[1:] = tolerance < 0.0
    stops[1:] |= bent & (tolerance == 0.0)
    round_ones = at[bent & ~stops[1:]]
    k = round_ones - 1
    widths[round_ones] = half_widths(strokes, round_ones, tolerance[k], turn[k], kink[k])
    stops[round_ones] |= widths[round_ones, 0] == 0.0
    return widths, stops


def _pairs(strokes: Strokes) -> list[tuple[int, int]]:
    return list(zip(strokes.owners[:-1].tolist(), strokes.owners[1:].tolist(), strict=True))


def _blend(read: _Read, i: int, j: int) -> float:
    """Give how far the tool may be off the corner between two moves, m; below 0: it must rest."""
    before, behind = read.moves[i], read.moves[j]
    if i != j and any(not isinstance(action, Message) for action in read.before.get(j, ())):
        return -1.0
    if isinstance(before, Rapid) or isinstance(behind, Rapid):
        return 0.0 if isinstance(before, Rapid) and isinstance(behind, Rapid) else -1.0
    if before.blend is None or behind.blend is None:
        return 0.0
    blend = min(before.blend, behind.blend, FREE if j in read.joints else inf)
    blend = FREE if blend == inf else blend
    return JOINT * blend if j in read.joints and i != j else blend


def _position(strokes: Strokes, widths: FloatArray, begin: int, end: int) -> BSpline:
    """Give the way from one rest to the next with its corners rounded."""
    nodes, ways = list[FloatArray](), list[IndexArray]()
    for way in range(begin, end):
        low = strokes.edges[way] + (widths[way, 1] if way > begin else 0.0)
        high = strokes.edges[way + 1] - (widths[way + 1, 0] if way + 1 < end else 0.0)
        s = np.concatenate(([low], strokes.inner(low, high, way), [high]))
        if nodes:
            # a way that goes on smoothly, or of which roundings leave nothing, adds no node twice
            s = s[s > nodes[-1][-1] + _NOTHING]
        if s.size:
            nodes.append(s)
            ways.append(np.full(len(s), way, dtype=np.intp))
    at = np.concatenate(nodes)
    jet: Jet = strokes.jets(at, np.concatenate(ways))
    return quintic_spline(at, jet)


def _done_before(strokes: Strokes, read: _Read, way: int) -> tuple[Action, ...]:
    owner = int(strokes.owners[way])
    if way > 0 and strokes.owners[way - 1] == owner:
        return ()
    return tuple(read.before.get(owner, ()))


def rest_of(actions: Sequence[Action]) -> float:
    """Give how long the arm rests for actions, s."""
    return sum(action.time for action in actions if isinstance(action, Dwell))
