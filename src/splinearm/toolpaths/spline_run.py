"""What of each piece is left in an offset, and where these parts join, to rounding.

Which parts those are is seen with arcs in place of splines; where they begin and end is then
polished on the true offsets. Splines meet in the middle of the band in which they will be fitted,
where they stray to both sides alike; lines, arcs and corners meet others at its near edge.
"""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atan2, inf, pi

import numpy as np

from splinearm.arrays import FloatArray

from .piece import SplinePiece
from .spline_rough import Rough, RoughOffset, UnclearError
from .spline_source import Source

_SMOOTH = 1e-6
"""Directions that differ by less, rad, are one."""
_GAP = 1e-10
"""Offsets that come this near to each other, of the size of the part, meet."""
_LOOKS = 48
"""Places on each side of a loop at which it is sought where it closes."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A part of the offset of one chain, or of the circle about the corner behind it."""

    chain: int
    """The chain."""
    corner: bool
    """Whether it is about the corner at the end of the chain."""
    start: float
    """From which place of the chain, or angle about the corner."""
    end: float
    """To which."""
    first: FloatArray
    """Where it begins, shape (2,), scaled."""
    last: FloatArray
    """Where it ends, shape (2,), scaled."""


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Runs one after the other."""

    runs: tuple[Run, ...]
    """The runs."""
    closed: bool
    """Whether the last is followed by the first."""


def is_spline(source: Source, run: Run | Rough) -> bool:
    """Say whether a run is beside a spline."""
    return not run.corner and isinstance(source.chains[run.chain].piece, SplinePiece)


class Outline:
    """Wires of which one side is offset.

    Args:
        source: The wires.
        band: How far to the left the offset begins and ends that splines may keep to, scaled.
        cusps: Places of each chain where its offset by the middle of that turns back, by chain.
        closed: Whether they are closed; if not, there is only one.
    """

    def __init__(
        self,
        source: Source,
        band: tuple[float, float],
        cusps: Sequence[FloatArray],
        *,
        closed: bool,
    ) -> None:
        self.source, self.cusps, self.closed = source, cusps, closed
        self.near, self.distance = band[0], 0.5 * (band[0] + band[1])
        self._backwards = [self._backward(c) for c in range(len(source.chains))]

    def tracks(self, tolerance: float) -> list[Track]:
        """Give the offset as tracks.

        Args:
            tolerance: How far arcs may be from splines, scaled.

        Raises:
            UnclearError: If these arcs do not show it.
        """
        rough = RoughOffset(self.source, self.distance, tolerance, closed=self.closed)
        return [self._polished(rough, runs, closed=closed) for runs, closed in rough.tracks()]

    def _polished(self, offset: RoughOffset, rough: list[Rough], *, closed: bool) -> Track:
        rough = self._mended(rough, closed=closed)
        count = len(rough)
        pairs = [(k, (k + 1) % count) for k in range(count if closed else count - 1)]
        places: dict[int, FloatArray] = {}
        for a, b in pairs:
            places[a] = self._join(offset, rough[a], rough[b])
        runs = []
        for k, run in enumerate(rough):
            first = places.get((k - 1) % count)
            last = places.get(k)
            if first is None:
                first = self.source.beside(run.chain, run.start, self._reach(run))[:2]
            if last is None:
                last = self.source.beside(run.chain, run.end, self._reach(run))[:2]
            if not (run.corner or run.start < run.end):
                raise UnclearError("a part of it runs backwards", first)
            runs.append(Run(run.chain, run.corner, run.start, run.end, first, last))
        return Track(tuple(runs), closed)

    def _mended(self, rough: list[Rough], *, closed: bool) -> list[Rough]:
        """Give runs cut where the true offset turns back, and joined where it does not."""
        runs: list[Rough] = []
        for run in rough:
            if not (runs and self._goes_on(runs[-1], run)):
                runs.append(run)
        if closed and len(runs) > 1 and self._goes_on(runs[-1], runs[0]):
            runs[0] = runs.pop()
        cut: list[Rough] = []
        for run in runs:
            start = run
            backwards = [] if run.corner else self._backwards[run.chain]
            for c1, c2 in backwards[bisect_left(backwards, (run.start, inf)) :]:
                if c2 >= run.end:
                    break
                if start.start < c1:
                    first, second = self._loop_at(start, c1, c2)
                    cut.append(replace(start, numbers=(start.numbers[0], -4), end=first))
                    start = replace(run, numbers=(-8, run.numbers[1]), start=second)
            cut.append(start)
        return cut

    def _goes_on(self, before: Rough, run: Rough) -> bool:
        """Join a run to the one before it if nothing lies between them but what arcs made up.

        Also where they end while the true offset runs backwards: it is then cut anew.
        """
        if run.corner or before.corner or before.chain != run.chain or before.end > run.start:
            return False
        backwards = self._backwards[run.chain]
        k = bisect_left(backwards, (before.end,))
        if k < len(backwards) and backwards[k][1] <= run.start:
            return False
        before.end, before.last = run.end, run.last
        before.numbers = before.numbers[0], run.numbers[1]
        return True

    def _backward(self, c: int) -> list[tuple[float, float]]:
        """Give from where to where the offset of a chain runs backwards, rising."""
        from .spline_jet_kernel import moved

        lo, hi = self.source.limits(c)
        found = []
        for c1, c2 in pairwise([lo, *self.cusps[c].tolist(), hi]):
            if c1 < c2:
                bend = moved(self.source.segments, lo, hi, 0.5 * (c1 + c2), 0.0)[4]
                if bend * self.distance > 1.0:
                    found.append((c1, c2))
        return found

    def _loop_at(self, run: Rough, c1: float, c2: float) -> tuple[float, float]:
        """Give where the loop between two cusps crosses itself."""
        from .spline_jet_kernel import meet, moved

        S, (lo, hi) = self.source.segments, self.source.limits(run.chain)
        for width in (1.0, 4.0, 16.0, 64.0):
            reach = width * (c2 - c1)
            sides = np.linspace(0.0, 1.0, _LOOKS)[:, None] * (
                np.array([max(run.start, c1 - reach) - c1, min(run.end, c2 + reach) - c2])
            ) + np.array([c1, c2])
            a, b = (
                np.array([moved(S, lo, hi, U, self.distance)[:2] for U in side.tolist()])
                for side in sides.T
            )
            hit = _first_crossing(a, b)
            if hit is None:
                continue
            first = np.array([lo, hi, np.interp(hit[0], np.arange(_LOOKS), sides[:, 0]), 0.0])
            second = np.array([lo, hi, np.interp(hit[1], np.arange(_LOOKS), sides[:, 1]), 0.0])
            u, v, _, _, gap = meet(S, first, second, self.distance)
            if gap < _GAP and run.start < u < c1 and c2 < v < run.end:
                return u, v
        raise UnclearError(
            "a loop of it does not close", self.source.beside(run.chain, c1, 0.0)[:2]
        )

    def _join(self, offset: RoughOffset, a: Rough, b: Rough) -> FloatArray:
        """Give where one run goes over into the next, and set both ends."""
        from .spline_jet_kernel import meet

        distance = self._reach(a, b)
        if offset.touch(a, b) and (a.corner or b.corner or self._smooth(a, b)):
            own = np.empty(4)
            if not a.corner:
                a.end = self.source.limits(a.chain)[1]
                own = self.source.beside(a.chain, a.end, distance)
                if b.corner:
                    b.start = atan2(own[2], -own[3])
                    b.end = b.start - (b.start - b.end) % (2.0 * pi)
            if not b.corner:
                b.start = self.source.limits(b.chain)[0]
                own = self.source.beside(b.chain, b.start, distance)
                if a.corner:
                    angle = atan2(own[2], -own[3])
                    a.end = a.start - (a.start - angle) % (2.0 * pi)
            place: FloatArray = own[:2]
            return place
        ways = []
        for run, at in ((a, a.end), (b, b.start)):
            head = self.source.corner(run.chain) if run.corner else self.source.limits(run.chain)
            ways.append(np.array([*head, at, float(run.corner)]))
        u, v, x, y, gap = meet(self.source.segments, ways[0], ways[1], distance)
        if gap > _GAP:
            raise UnclearError("two parts of it do not meet", np.array([x, y]))
        a.end, b.start = u, v
        return np.array([x, y])

    def _reach(self, *runs: Rough) -> float:
        """Give how far to the left runs begin, end or meet."""
        splines = all(is_spline(self.source, run) for run in runs)
        return self.distance if splines else self.near

    def _smooth(self, a: Rough, b: Rough) -> bool:
        """Say whether two chains, the second behind the first, meet without a corner."""
        there = self.source.beside(a.chain, self.source.limits(a.chain)[1], 0.0)
        here = self.source.beside(b.chain, self.source.limits(b.chain)[0], 0.0)
        bend = there[2] * here[3] - there[3] * here[2]
        return bool(abs(bend) < _SMOOTH and there[2:] @ here[2:] > 0.0)


def _first_crossing(a: FloatArray, b: FloatArray) -> tuple[float, float] | None:
    """Give where two chains of points cross, counted in points, next to their beginnings."""
    p, q = a[:-1, None], b[None, :-1]
    u, v = np.diff(a, axis=0)[:, None], np.diff(b, axis=0)[None]
    gap = q - p
    cross = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (gap[..., 0] * v[..., 1] - gap[..., 1] * v[..., 0]) / cross
        t = (gap[..., 0] * u[..., 1] - gap[..., 1] * u[..., 0]) / cross
    i, j = np.nonzero((s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0))
    kept = i + j > 0  # they may begin in one place
    if not kept.any():
        return None
    k = int(np.argmin((i + j)[kept]))
    i, j = i[kept][k], j[kept][k]
    return float(i + s[i, j]), float(j + t[i, j])
