"""The fewest knots with which a B-spline stays near enough to a recording, on bare arrays."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves import basis, least
from splinearm.curves.bspline import BSpline
from splinearm.curves.fit import frame_of
from splinearm.errors import CurveError

Misses = Callable[[FloatArray, slice], FloatArray]
"""Gives how far joints are off at each of some parameters, 1 being as far as they may: of (k, n),
at a slice of all parameters, (k,)."""

_WINDOW = 1500
"""Of longer recordings so many samples are looked at together: the time is that of their length,
not of its square."""

_ROUNDS = 30
"""How often weights are changed before knots are said not to do ..."""

_HOPE, _GAIN = 5, 0.9
"""... or fewer: if the excess over so many rounds does not fall to that share."""

_HOPELESS, _NEARLY = 1.6, 1.25
"""Farther off than this no weights help, or are not worth their time."""

_EVENLY = 0.02
"""Share of the mean density of knots that there is everywhere."""

_SHARES = 0.5, 0.2, 0.8
"""Where between two knots one is tried in their place."""

_FEW = 80
"""So many knots are few: of more, to try hard takes minutes."""

_PLACINGS = 4
"""So often knots are placed anew by how much each place needs them."""


class Found(NamedTuple):
    """A curve near enough."""

    inner: FloatArray
    """Its knots without those of the ends."""
    curve: BSpline
    """The curve."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class KnotChoice:
    """What is to be approximated, and how near."""

    u: FloatArray
    """Parameters, never falling, shape (k,)."""
    q: FloatArray
    """What the curve is near to there, shape (k, n)."""
    misses: Misses
    """How far off it is."""
    degree: int
    """Degree."""
    low: FloatArray
    """Lowest control points, shape (n,)."""
    high: FloatArray
    """Highest control points, shape (n,)."""
    grain: float = 1e-4
    """Knots are multiples of that."""
    part: slice = field(default_factory=lambda: slice(None))
    """Which of all parameters these are."""

    def fewest(self) -> Found:
        """Give the curve with the fewest knots that is found.

        Raises:
            CurveError: If not even a knot for every sample does.
        """
        windows = len(np.unique(self.u)) // _WINDOW
        if windows > 2:
            return self._by_windows(windows)
        found = self._leave_out(self._insert(np.empty(0)))
        for _ in range(_PLACINGS):
            better = self._place(found)
            if better is None:
                break
            found = self._leave_out(better)
        return self._merge(found)

    def attempt(
        self, inner: FloatArray, hopeless: float = _HOPELESS, *, at_its_nearest: bool = False
    ) -> tuple[Found | None, FloatArray]:
        """Give the curve over some knots, None if it is too far away, and the misses.

        These are those of least squares, or those of the curve that was nearest.
        """
        start, end, ends = float(self.u[0]), float(self.u[-1]), self.degree + 1
        inner = self._grid(inner, start, end)
        knots = np.concatenate((np.full(ends, start), inner, np.full(ends, end)))
        frame = frame_of(self.q, self.u, knots, self.degree, "free")
        nothing = np.full(len(self.u), np.inf)
        if frame.unknowns > len(self.u):
            return None, nothing
        near = least.equations(frame, self.u, self.q)
        weights, first, nearest = np.ones(len(self.u)), nothing, nothing
        excess: list[float] = []
        for rounds in range(_ROUNDS):
            try:
                found = least.solve(frame, near.scaled(np.sqrt(weights))).found
            except CurveError:
                return None, first
            points = np.clip(frame.all_points(found), self.low, self.high)
            curve = BSpline(knots, points, self.degree)
            now = self.misses(basis.evaluate(knots, points, self.degree, self.u), self.part)
            if now.max() <= 1.0:
                return Found(inner, curve), now
            if now.max() < nearest.max():
                nearest = now
            if rounds == 0:
                first = now
                if now.max() > hopeless:
                    break
            excess.append(min([float(now.max()) - 1.0, *excess[-1:]]))
            if rounds >= _HOPE and excess[-1] > _GAIN * excess[-1 - _HOPE]:
                break
            # Lawson, Contributions to the theory of linear least maximum approximation, thesis,
            # 1961: weights that follow the misses lead to the least largest miss
            weights = weights * (0.05 + now / now.max()) ** 2
            weights /= weights.mean()
        return None, nearest if at_its_nearest else first

    def _by_windows(self, count: int) -> Found:
        """Give the curve with the knots that windows need, and few more where they meet."""
        edges = np.searchsorted(self.u, np.linspace(self.u[0], self.u[-1], count + 1))
        seams, inner = self.u[edges[1:-1]], []
        for begin, end in pairwise(edges.tolist()):
            part = slice(begin, end + 1)
            inner.append(replace(self, u=self.u[part], q=self.q[part], part=part).fewest().inner)
        found = self._insert(self._joined(np.sort(np.concatenate((*inner, seams)))))
        for seam in seams:
            at = int(np.argmin(np.abs(found.inner - seam)))
            found = self._leave_out(found, around=at)
        return found

    def _joined(self, inner: FloatArray) -> FloatArray:
        """Give knots of windows with those that are wanting where they meet."""
        while True:
            found, misses = self.attempt(inner, np.inf, at_its_nearest=True)
            more = np.empty(0) if found is not None else self._where_needed(inner, misses)
            if not more.size:
                return inner
            inner = np.sort(np.concatenate((inner, more)))

    def _grid(self, inner: FloatArray, start: float, end: float) -> FloatArray:
        """Give knots as a file has them, each once."""
        knots = np.unique(np.round(np.round(inner / self.grain) * self.grain, 9))
        return knots[(knots > start) & (knots < end)]

    def _insert(self, inner: FloatArray) -> Found:
        """Put knots in where the curve is too far away, until it no longer is."""
        while True:
            found, misses = self.attempt(inner)
            if found is not None:
                return found
            more = self._where_needed(inner, misses)
            if not more.size:
                raise CurveError(
                    "cannot be followed that closely, not even with a control point for every "
                    "sample; allow more",
                    "recording",
                )
            inner = np.sort(np.concatenate((inner, more)))

    def _where_needed(self, inner: FloatArray, misses: FloatArray) -> FloatArray:
        """Give the middles, by samples, of the pieces on which the curve is too far away."""
        if not np.isfinite(misses).all():
            return np.empty(0)
        edges = np.concatenate((self.u[:1], inner, self.u[-1:]))
        piece = np.clip(np.searchsorted(edges, self.u, side="right") - 1, 0, len(edges) - 2)
        more: list[float] = []
        for i in np.unique(piece[misses > 1.0]):
            inside = np.unique(self.u[piece == i])
            if len(inside) > 2:
                at = len(inside) // 2
                more.append(0.5 * float(inside[at - 1] + inside[at]))
        return np.array(more)

    def _place(self, found: Found) -> Found | None:
        """Give a curve whose fewer knots are where it needs them, or None if there is none."""
        place = _placing(found.curve)
        low, high, best = 0, len(found.inner), None
        while low < high:
            middle = (low + high) // 2
            trial, _ = self.attempt(place(middle))
            if trial is None:
                low = middle + 1
            else:
                high, best = middle, trial
        return best

    def _leave_out(self, found: Found, around: int | None = None) -> Found:
        """Take out knots, the least needed first, for as long as the curve stays near enough.

        A knot that was needed once is tried again only after its neighbours were taken out. Around
        one knot only those near it are tried.
        """
        kept = np.zeros(len(found.inner), dtype=np.bool_)
        if around is not None:
            kept = np.abs(np.arange(len(kept)) - around) > 2
        while not kept.all():
            open_ = np.flatnonzero(~kept)
            i = int(open_[np.argmin(_needs(found)[open_])])
            trial, _ = self.attempt(np.delete(found.inner, i))
            if trial is None:
                kept[i] = True
                continue
            found, kept = trial, np.delete(kept, i)
            kept[max(i - 2, 0) : i + 2] = False
        return found

    def _merge(self, found: Found) -> Found:
        """Put one knot in the place of two neighbours, for as long as that does."""
        i, hopeless = 0, _HOPELESS if len(found.inner) <= _FEW else _NEARLY
        while i + 1 < len(found.inner):
            first, second = found.inner[i : i + 2]
            for share in _SHARES:
                one = first + share * (second - first)
                inner = np.concatenate((found.inner[:i], [one], found.inner[i + 2 :]))
                trial, _ = self.attempt(inner, hopeless)
                if trial is not None:
                    found = self._leave_out(trial, around=i)
                    i = max(i - 3, 0)
                    break
            else:
                i += 1
        return found


def _needs(found: Found) -> FloatArray:
    """Give how much each inner knot is needed: the jump there, over the space it has, (m,)."""
    # the jump of the derivative of order p at a knot, as Lyche and Mørken weigh knots,
    # A data-reduction strategy for splines, IMA J. Numer. Anal. 8 (1988) 185
    curve, p = found.curve, found.curve.degree
    edges = curve.breaks
    flat = curve.at(0.5 * (edges[:-1] + edges[1:]), p)
    jump = np.linalg.norm(np.diff(flat, axis=0), axis=1)
    need: FloatArray = jump * (edges[2:] - edges[:-2]) ** p
    return need


def _placing(curve: BSpline) -> Callable[[int], FloatArray]:
    """Give where so many knots belong, by the derivative that such a spline cannot follow."""
    # de Boor, Good approximation by splines with variable knots II, 1974 (NEWKNOT)
    edges, width = curve.breaks, np.diff(curve.breaks)
    flat = curve.at(0.5 * (edges[:-1] + edges[1:]), curve.degree)
    jump = np.linalg.norm(np.diff(flat, axis=0), axis=1)
    slope = jump / (edges[2:] - edges[:-2]) if len(jump) else np.ones(1)
    around = np.concatenate((slope[:1], slope, slope[-1:]))[: len(width) + 1]
    density = (around[:-1] + around[1:]) ** (1.0 / (curve.degree + 1))
    mean = float((density * width).sum() / width.sum())
    density = np.maximum(density, _EVENLY * mean) if mean > 0.0 else np.ones_like(density)
    total = np.concatenate(([0.0], np.cumsum(density * width)))

    def place(count: int) -> FloatArray:
        shares = total[-1] * np.arange(1, count + 1) / (count + 1)
        return np.asarray(np.interp(shares, total, edges), dtype=np.float64)

    return place
