"""Pieces of a drawing joined end to end."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from splinearm.arrays import FloatArray

from .piece import ArcPiece, Piece, is_full_circle
from .wire import Wire

_Spot = tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Chaining:
    """What became of the pieces of a drawing."""

    wires: tuple[Wire, ...]
    """The wires, closed and open ones, in the order of their first pieces."""
    open_ends: FloatArray
    """Where wires end without meeting anything, shape (k, 2), m."""
    branches: FloatArray
    """Where more than two pieces meet, shape (k, 2), m; wires end there."""
    duplicates: FloatArray
    """Middles of pieces that were drawn more than once, shape (k, 2), m; they are kept once."""
    widest_gap: float
    """The widest gap between ends that was closed, m."""


def chain(pieces: Iterable[Piece], tolerance: float) -> Chaining:
    """Join pieces whose ends meet.

    Args:
        pieces: The pieces, in any order and direction.
        tolerance: Ends nearer than this are one place, m. Ends that are joined move to the middle
            of them.

    Raises:
        ValueError: If the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance: want a distance above zero, got {tolerance}")
    given, duplicates = _without_duplicates(list(pieces), tolerance)
    rings = [i for i, piece in enumerate(given) if is_full_circle(piece)]
    net = _Net(given, rings, tolerance)
    wires = [(i, Wire((given[i],), closed=True)) for i in rings]
    wires += [(min(i for i, _ in path), net.wire(path)) for path in net.paths()]
    wires.sort(key=lambda pair: pair[0])
    return Chaining(
        wires=tuple(wire for _, wire in wires),
        open_ends=net.places_where(lambda count: count == 1),
        branches=net.places_where(lambda count: count > 2),
        duplicates=_rows([piece.middle for piece in duplicates]),
        widest_gap=net.widest_gap,
    )


@dataclass(slots=True)
class _Net:
    """Pieces as the edges of a graph, the places where their ends meet as its nodes."""

    pieces: Sequence[Piece]
    skipped: Sequence[int]
    tolerance: float
    places: list[FloatArray] = field(init=False)
    ends: dict[int, tuple[int, int]] = field(init=False)
    at_node: dict[int, list[int]] = field(init=False)
    widest_gap: float = field(init=False, default=0.0)

    def __post_init__(self) -> None:
        used = [i for i in range(len(self.pieces)) if i not in set(self.skipped)]
        points = _rows([p for i in used for p in (self.pieces[i].start, self.pieces[i].end)])
        nodes = _clusters(points, self.tolerance)
        count = max(nodes, default=-1) + 1
        members: list[list[int]] = [[] for _ in range(count)]
        for end, node in enumerate(nodes):
            members[node].append(end)
        self.places = [points[ends].mean(axis=0) for ends in members]
        for ends in members:
            gaps = np.linalg.norm(points[ends] - points[ends[0]], axis=1)
            self.widest_gap = max(self.widest_gap, float(gaps.max()))
        self.ends = {}
        self.at_node = defaultdict(list)
        for k, i in enumerate(used):
            pair = (nodes[2 * k], nodes[2 * k + 1])
            if pair[0] == pair[1] and self.pieces[i].length <= 2.0 * self.tolerance:
                continue  # a crumb: its place is one with its neighbours'
            self.ends[i] = pair
            for node in pair:
                self.at_node[node].append(i)

    def paths(self) -> Iterator[list[tuple[int, bool]]]:
        """Give the longest chains of pieces without branches; each piece, and if it runs on."""
        left = dict.fromkeys(self.ends)
        forks = [node for node, there in self.at_node.items() if len(there) != 2]
        for node in forks:
            for i in self.at_node[node]:
                if i in left:
                    yield self._walk(i, node, left)
        while left:
            i = next(iter(left))
            yield self._walk(i, self.ends[i][0], left)

    def _walk(self, i: int, node: int, left: dict[int, None]) -> list[tuple[int, bool]]:
        path: list[tuple[int, bool]] = []
        while True:
            onward = self.ends[i][0] == node
            path.append((i, onward))
            del left[i]
            node = self.ends[i][1 if onward else 0]
            following = [k for k in self.at_node[node] if k in left]
            if len(self.at_node[node]) != 2 or not following:
                return path
            i = following[0]

    def wire(self, path: Sequence[tuple[int, bool]]) -> Wire:
        """Give the pieces of a path, all running on, each moved to the places of its ends."""
        if not path[0][1] and all(not onward for _, onward in path):
            path = [(i, True) for i, _ in reversed(path)]  # as it was drawn
        pieces: list[Piece] = []
        for i, onward in path:
            piece = self.pieces[i] if onward else self.pieces[i].reversed()
            first, last = self.ends[i] if onward else self.ends[i][::-1]
            start, end = self.places[first], self.places[last]
            moved = not ((piece.start == start).all() and (piece.end == end).all())
            pieces.append(piece.between(start, end) if moved else piece)
        first = self.ends[path[0][0]][0 if path[0][1] else 1]
        last = self.ends[path[-1][0]][1 if path[-1][1] else 0]
        return Wire(tuple(pieces), closed=first == last)

    def places_where(self, wanted: Callable[[int], bool]) -> FloatArray:
        """Give the places at which a number of ends meet that is wanted."""
        return _rows([self.places[n] for n, there in self.at_node.items() if wanted(len(there))])


def _clusters(points: FloatArray, tolerance: float) -> list[int]:
    """Give for each point the number of its cluster: points nearer than the tolerance share one."""
    parent = list(range(len(points)))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    spots: dict[_Spot, list[int]] = defaultdict(list)
    for i, point in enumerate(points):
        x, y = (int(v) for v in np.floor(point / tolerance))
        for dx, dy in product((-1, 0, 1), repeat=2):
            for k in spots.get((x + dx, y + dy), ()):
                if np.hypot(*(points[k] - point)) <= tolerance:
                    parent[root(i)] = root(k)
        spots[x, y].append(i)
    numbers: dict[int, int] = {}
    return [numbers.setdefault(root(i), len(numbers)) for i in range(len(points))]


def _without_duplicates(pieces: list[Piece], tolerance: float) -> tuple[list[Piece], list[Piece]]:
    """Give the pieces once each, and those that were there again."""
    kept: list[Piece] = []
    again: list[Piece] = []
    spots: dict[_Spot, list[Piece]] = defaultdict(list)
    for piece in pieces:
        x, y = (int(v) for v in np.floor(_mark(piece) / tolerance))
        near = (
            other
            for dx, dy in product((-1, 0, 1), repeat=2)
            for other in spots.get((x + dx, y + dy), ())
        )
        if any(_same(piece, other, tolerance) for other in near):
            again.append(piece)
        else:
            kept.append(piece)
            spots[x, y].append(piece)
    return kept, again


def _same(a: Piece, b: Piece, tolerance: float) -> bool:
    """Say whether two pieces lie on each other, in either direction."""
    if abs(a.length - b.length) > 2.0 * tolerance:
        return False
    if np.hypot(*(_mark(a) - _mark(b))) > tolerance or is_full_circle(a) != is_full_circle(b):
        return False
    if is_full_circle(a):
        return True  # wherever they begin
    gaps = [
        max(np.hypot(*(a.start - start)), np.hypot(*(a.end - end)))
        for start, end in ((b.start, b.end), (b.end, b.start))
    ]
    return bool(min(gaps) <= tolerance)


def _mark(piece: Piece) -> FloatArray:
    """Give a place by which a piece is known, whichever way it runs."""
    if isinstance(piece, ArcPiece) and is_full_circle(piece):
        return piece.centre
    return piece.middle


def _rows(points: Sequence[FloatArray]) -> FloatArray:
    return np.array(points, dtype=np.float64).reshape(-1, 2)
