"""How an offset runs, seen with arcs in place of splines.

Arcs and lines are offset exactly; a number a segment leads back from what is left to the places of
the chains that it comes from.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import atan2, pi

import numpy as np

from splinearm.arrays import FloatArray

from .piece import ArcPiece, LinePiece
from .spline_source import Source

_NUDGES = (0.0, 1e-12, -1e-12, 3e-12, -1e-11)
"""Shares of the size by which the distance is changed in turn if no loops close."""

_ASIDE = 1e-10
"""Pieces that meet nearer to their ends than this do not cross there."""


class UnclearError(Exception):
    """Arcs in place of splines did not show how the offset runs; finer ones may."""

    def __init__(self, what: str, where: FloatArray) -> None:
        """Take the facts: what is not clear, and the place, shape (2,), scaled."""
        self.what = what
        self.where = where
        super().__init__(what)


@dataclass(slots=True)
class Rough:
    """A part of the offset of one chain or corner, about as the arcs show it."""

    chain: int
    """The chain."""
    corner: bool
    """Whether it is about the corner at the end of the chain."""
    numbers: tuple[int, int]
    """First and last arc of the part; corners are odd; below 0 where there is none."""
    first: FloatArray
    """Where it begins, shape (2,), scaled."""
    last: FloatArray
    """Where it ends, shape (2,), scaled."""
    start: float = 0.0
    """From which place of the chain, or angle about the corner."""
    end: float = 0.0
    """To which."""


class RoughOffset:
    """The offset of wires to their left, with arcs in place of splines.

    Args:
        source: The wires.
        distance: How far to the left, scaled.
        tolerance: How far arcs may be from splines, scaled.
        closed: Whether the wires are closed; if not, there is only one.
    """

    def __init__(self, source: Source, distance: float, tolerance: float, *, closed: bool) -> None:
        self.source, self.distance, self.closed = source, distance, closed
        self._tolerance = tolerance
        self._ways: list[tuple[int, float, float]] = []  # chain, from, to of each arc
        self._follower: dict[int, int] = {}
        self._forward = 0

    def tracks(self) -> list[tuple[list[Rough], bool]]:
        """Give the parts of each loop or open way, and whether it is a loop.

        Raises:
            UnclearError: If loops do not close.
        """
        return [(self._grouped(rows, closed=closed), closed) for rows, closed in self._loops()]

    def touch(self, a: Rough, b: Rough) -> bool:
        """Say whether a part ends where the next begins, where chains meet or a corner begins."""
        last, first = a.numbers[1], b.numbers[0]
        if last < 0 or first < 0:
            return False
        j, k = last // 2, first // 2
        if a.corner:
            return not b.corner and k == self._follower.get(j)
        if not self._ends_chain(j):
            return False
        return j == k if b.corner else k == self._follower.get(j)

    def _ends_chain(self, j: int) -> bool:
        return self._ways[j][2] == self.source.limits(self._ways[j][0])[1]

    def _loops(self) -> list[tuple[FloatArray, bool]]:
        """Give rows (x, y, bulge, number) and where the last ends, of each loop or open way."""
        from .contour_kernel import first_crossing
        from .loop_kernel import offset_loops
        from .offset_kernel import pieces_of
        from .tree_kernel import tree_of

        vertices, bulges, starts = self._arcs()
        P, segment, firsts = pieces_of(vertices, bulges, starts, 0.0)
        if self.closed:
            i, _, x, y = first_crossing(P, firsts, _ASIDE)
            if i >= 0:
                raise UnclearError("the outline crosses itself", np.array([x, y]))
        tree = tree_of(P, len(P), 0.0)
        wrong = rows = begins = np.zeros(3)
        for nudge in _NUDGES:
            rows, begins, _, wrong = offset_loops(
                P, segment, firsts, tree, self.distance + nudge, (0.0, 1.0, 0.0, -1.0), -1.0
            )
            if wrong[0] < 0.0:
                break
        else:
            raise UnclearError("its pieces do not close", wrong[1:])
        loops: list[tuple[FloatArray, bool]] = []
        for first, last in pairwise(begins.astype(int).tolist()):
            own = rows[first:last]
            if self.closed:
                loops.append((own, True))
            else:
                loops += self._ahead(own)
        return loops

    def _ahead(self, own: FloatArray) -> list[tuple[FloatArray, bool]]:
        """Give the parts of a loop around an open wire that lie to its left."""
        kept = own[:, 3] < 2 * self._forward - 1
        if kept.all():
            return [(own, True)]
        shift = int(np.argmin(kept))
        own, kept = np.roll(own, -shift, axis=0), np.roll(kept, -shift)
        edges = np.flatnonzero(np.diff(np.concatenate(([False], kept, [False])).astype(int)))
        ways = []
        for a, b in edges.reshape(-1, 2).tolist():
            part = own[np.arange(a, b + 1) % len(own)].copy()
            part[-1, 3] = -1.0
            ways.append((part, False))
        return sorted(ways, key=lambda way: float(way[0][0, 3]))

    def _arcs(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give vertices, bulges and first vertices of the wires as arcs."""
        vertices: list[FloatArray] = []
        bulges: list[FloatArray] = []
        starts = [0]
        for first, end in self.source.loops:
            begun = len(self._ways)
            for c in range(first, end):
                places, bends = self._chain_arcs(c)
                vertices.append(places)
                bulges.append(bends)
            count = len(self._ways)
            for j in range(begun, count):
                self._follower[j] = j + 1 if j + 1 < count else begun
            starts.append(count)
        if not self.closed:
            return self._there_and_back(np.concatenate(vertices), np.concatenate(bulges))
        return np.concatenate(vertices), np.concatenate(bulges), np.array(starts, dtype=float)

    def _chain_arcs(self, c: int) -> tuple[FloatArray, FloatArray]:
        from .biarc_kernel import arcs_along

        chain, source = self.source.chains[c], self.source
        lo, hi = float(chain.first), float(chain.end)
        piece = chain.piece
        if isinstance(piece, LinePiece):
            self._ways.append((c, lo, hi))
            return (piece.start[None] - source.origin) / source.unit, np.zeros(1)
        if isinstance(piece, ArcPiece):
            parts = chain.end - chain.first
            self._ways += [(c, lo + k, lo + k + 1.0) for k in range(parts)]
            angles = piece.turn * np.arange(parts) / parts
            arm = (piece.start - piece.centre) / source.unit
            co, si = np.cos(angles), np.sin(angles)
            turned = np.stack((co * arm[0] - si * arm[1], si * arm[0] + co * arm[1]), axis=1)
            places = (piece.centre - source.origin) / source.unit + turned
            return places, np.full(parts, np.tan(0.25 * piece.turn / parts))
        arcs = arcs_along(source.segments, (lo, hi), (lo, hi), self._tolerance)
        if not len(arcs):
            raise UnclearError("a spline takes too many arcs", source.corner(c))
        self._ways += [(c, float(a), float(b)) for a, b in arcs[:, 3:5]]
        return arcs[:, :2], arcs[:, 2]

    def _there_and_back(
        self, vertices: FloatArray, bulges: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        self._forward = len(bulges)
        last = self.source.chains[-1]
        end = self.source.beside(len(self.source.chains) - 1, float(last.end), 0.0)[:2]
        vertices = np.concatenate((vertices, end[None], vertices[:0:-1]))
        bulges = np.concatenate((bulges, -bulges[::-1]))
        return vertices, bulges, np.array([0.0, len(bulges)])

    def _grouped(self, rows: FloatArray, *, closed: bool) -> list[Rough]:
        """Give rows as runs."""
        count = len(rows) if closed else len(rows) - 1
        runs: list[Rough] = []
        for i in range(count):
            number = int(rows[i, 3])
            j = number // 2
            corner = number % 2 == 1 and self._ends_chain(j)
            chain, first, last = self._ways[j][0], rows[i, :2], rows[(i + 1) % len(rows), :2]
            before = runs[-1] if runs else None
            if (
                before is not None
                and before.chain == chain
                and before.corner == corner
                and (corner or 0 <= number - before.numbers[1] <= 2)
            ):
                before.numbers = before.numbers[0], number
                before.last = last
            else:
                runs.append(Rough(chain, corner, (number, number), first, last))
        if closed and len(runs) > 1:
            a, b = runs[-1], runs[0]
            if a.chain == b.chain and a.corner == b.corner:
                step = b.numbers[0] - a.numbers[1]
                if a.corner or 0 <= step <= 2:
                    runs[0] = Rough(
                        a.chain, a.corner, (a.numbers[0], b.numbers[1]), a.first, b.last
                    )
                    runs.pop()
        for run in runs:
            self._place(run)
        return runs

    def _place(self, run: Rough) -> None:
        """Set where a run begins and ends, about."""
        from .spline_jet_kernel import foot

        if run.corner:
            a, b = (
                run.first - self.source.corner(run.chain),
                run.last - self.source.corner(run.chain),
            )
            run.start = atan2(a[1], a[0])
            run.end = run.start - (run.start - atan2(b[1], b[0])) % (2.0 * pi)
            return
        S, (lo, hi) = self.source.segments, self.source.limits(run.chain)
        guess = [self._ways[run.numbers[k] // 2][1 + k] for k in range(2)]
        run.start = foot(S, lo, hi, guess[0], *run.first)
        run.end = foot(S, lo, hi, guess[1], *run.last)
