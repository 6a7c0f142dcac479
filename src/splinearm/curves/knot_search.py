"""The fewest knots with which a B-spline comes near enough to points, on bare arrays."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import basis, deviation, knot, least
from .basis import IndexArray
from .bspline import BSpline
from .fit import FitEnds, frame_of, moved_parameters
from .interpolation import interpolate

_ROUNDS = 12
"""How often weights or parameters are changed before knots are said not to do."""

_TRIES = 8
"""How many knots, the least needed first, are tried to be left out before all are kept."""

_EVENLY = 0.02
"""Share of the mean density of knots that there is everywhere."""


class Found(NamedTuple):
    """A curve near enough to its points."""

    inner: FloatArray
    """Its knots without those of the ends."""
    curve: BSpline
    """The curve."""
    u: FloatArray
    """Parameters of the points, of a closed curve with its end."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Search:
    """What is to be approximated, and how near."""

    points: FloatArray
    """Points, shape (k, dim)."""
    u: FloatArray
    """Their parameters, of a closed curve with its end."""
    degree: int
    """Degree."""
    ends: FitEnds
    """What holds at the ends."""
    tolerance: float
    """How far the curve may be from each point."""
    geometric: bool
    """Whether parameters may move along the curve."""

    def fewest(self, start: FloatArray, *, evenly: bool = True) -> Found:
        """Give the curve with the fewest knots that is found.

        Args:
            start: Inner knots to begin with; they may be taken out again.
            evenly: Whether knots may be placed anew, by how much each place needs them.

        Raises:
            CurveError: If not even a curve through all points does.
        """
        if self.geometric:
            # what does without moving the parameters is the start of what may do with it
            found = replace(self, geometric=False).fewest(start, evenly=evenly)
        else:
            found = self._insert(start)
        if evenly:
            for _ in range(3):
                better = self._replace(found)
                if better is None:
                    break
                found = better
        return self._leave_out(found)

    @property
    def _least(self) -> int:
        """The fewest inner knots: a ring needs some."""
        return self.degree if self.ends == "closed" else 0

    def _attempt(self, inner: FloatArray, u: FloatArray) -> tuple[Found | None, FloatArray]:
        """Give the curve over some knots, None if it is too far away, and the misses."""
        count = len(self.points)
        outer = 0 if self.ends == "closed" else self.degree
        start, end = float(self.u[0]), float(self.u[-1])
        knots = np.concatenate((np.full(outer + 1, start), inner, np.full(outer + 1, end)))
        weights = np.full(count, 1.0 / count)
        misses = np.full(count, np.inf)
        for rounds in range(_ROUNDS):
            frame = frame_of(self.points, self.u, knots, self.degree, self.ends)
            if frame.unknowns < 1 or frame.unknowns > count:
                rows = frame.all_points(np.empty((0, self.points.shape[1])))
                if frame.unknowns < 0 or frame.unknowns > count:
                    return None, misses
            else:
                near = least.equations(frame, u[:count], self.points)
                try:
                    rows = frame.all_points(least.solve(frame, near.scaled(np.sqrt(weights))).found)
                except CurveError:
                    return None, misses
            curve = BSpline(frame.knots, rows, self.degree)
            gap = basis.evaluate(curve.knots, curve.points, self.degree, u[:count]) - self.points
            now = np.sqrt((gap * gap).sum(axis=1))
            if now.max() <= self.tolerance:
                return Found(inner, curve, u), now
            misses = now if rounds == 0 else misses
            # Lawson, Contributions to the theory of linear least maximum approximation, thesis,
            # 1961: weights that follow the misses lead to the least largest miss, which the
            # weighted mean of squares is never above
            if self.geometric:
                jets = curve.jet(u[:count], 2)
                moved = moved_parameters(jets, self.points, u[:count], (start, end))
                u = np.append(moved, end) if self.ends == "closed" else moved
            elif np.sqrt((weights * now * now).sum()) > self.tolerance:
                return None, misses
            weights = weights * now
            weights /= weights.sum()
        return None, misses

    def _insert(self, inner: FloatArray) -> Found:
        """Put knots in where the curve is too far away, until it no longer is."""
        while True:
            found, misses = self._attempt(inner, self.u)
            if found is not None:
                return found
            more = self._where_needed(inner, misses)
            if not more.size:
                return self._through_all()
            inner = np.sort(np.concatenate((inner, more)))

    def _where_needed(self, inner: FloatArray, misses: FloatArray) -> FloatArray:
        if not np.isfinite(misses).all():
            return np.empty(0)
        u = self.u[: len(self.points)]
        edges = np.unique(np.concatenate((self.u[:1], inner, self.u[-1:])))
        span = np.clip(np.searchsorted(edges, u, side="right") - 1, 0, len(edges) - 2)
        more: list[float] = []
        for i in np.unique(span[misses > self.tolerance]):
            inside = np.flatnonzero(span == i)
            worst = float(misses[inside].max()) / self.tolerance
            parts = min(int(np.ceil(worst ** (1.0 / (self.degree + 1)))), 4, len(inside) // 2)
            for j in range(1, max(parts, 2)):
                at = inside[0] + j * len(inside) // max(parts, 2)
                if inside[0] < at <= inside[-1]:
                    more.append(0.5 * float(u[at - 1] + u[at]))
        if len(inner) + len(more) + self.degree + 1 > len(u):
            return np.empty(0)
        return np.array(more)

    def _through_all(self) -> Found:
        """Give a curve through all points."""
        closed = self.ends == "closed"
        if closed and self.degree % 2 == 0:
            raise CurveError(
                f"no closed curve of degree {self.degree} was found; take an odd degree",
                "approximation",
            )
        curve = interpolate(
            self.points,
            degree=self.degree,
            parameters=self.u,
            ends="closed" if closed else "free",
        )
        gap = curve.at(self.u[: len(self.points)]) - self.points
        if not np.sqrt((gap * gap).sum(axis=1)).max() <= self.tolerance:
            raise CurveError(
                f"rounding is larger than the tolerance of {self.tolerance}", "approximation"
            )
        start, end = curve.domain
        return Found(curve.knots[(curve.knots > start) & (curve.knots < end)], curve, self.u)

    def _replace(self, found: Found) -> Found | None:
        """Give a curve whose fewer knots are where it needs them, or None if there is none."""
        place = _density(found.curve)
        low, high, best = self._least, len(found.inner), None
        while low < high:
            middle = (low + high) // 2
            trial, _ = self._attempt(place(middle), found.u)
            if trial is None:
                low = middle + 1
            else:
                high, best = middle, trial
        return best

    def _leave_out(self, found: Found) -> Found:
        """Take out one knot after another for as long as the curve stays near enough."""
        while len(found.inner) > self._least:
            for i in _needed_least(found)[:_TRIES]:
                trial, _ = self._attempt(np.delete(found.inner, i), found.u)
                if trial is not None:
                    found = trial
                    break
            else:
                break
        return found


def _needed_least(found: Found) -> IndexArray:
    """Give the inner knots' numbers, first those whose removal moves the curve least."""
    curve = found.curve
    moved = []
    for u in found.inner:
        change = knot.remove(curve.knots, curve.points, curve.degree, float(u))[2]
        moved.append(deviation.bound(curve.points, curve.points + change, rational=False))
    return np.argsort(np.array(moved), kind="stable")


class _Placing:
    """Where so many knots are best placed."""

    def __init__(self, edges: FloatArray, total: FloatArray) -> None:
        self.edges, self.total = edges, total

    def __call__(self, count: int) -> FloatArray:
        shares = self.total[-1] * np.arange(1, count + 1) / (count + 1)
        return np.asarray(np.interp(shares, self.total, self.edges), dtype=np.float64)


def _density(curve: BSpline) -> _Placing:
    """Give where knots belong by the derivative that a spline of this degree cannot follow."""
    # de Boor, Good approximation by splines with variable knots II, 1974 (NEWKNOT): the derivative
    # of order degree + 1 from the jumps of that before, its root of this order the density
    edges = curve.breaks
    middles = 0.5 * (edges[:-1] + edges[1:])
    flat = curve.at(middles, curve.degree)
    jump = np.linalg.norm(np.diff(flat, axis=0), axis=1)
    slope = np.divide(jump, edges[2:] - edges[:-2])
    if not slope.size:
        slope = np.ones(1)
    around = np.concatenate((slope[:1], slope, slope[-1:]))[: len(middles) + 1]
    density = (around[:-1] + around[1:]) ** (1.0 / (curve.degree + 1))
    width = np.diff(edges)
    mean = float((density * width).sum() / width.sum())
    density = np.maximum(density, _EVENLY * mean) if mean > 0.0 else np.ones_like(density)
    return _Placing(edges, np.concatenate(([0.0], np.cumsum(density * width))))
