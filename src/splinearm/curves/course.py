"""Segments one after the other with rounded corners, as one C2 curve in space."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .hermite import Jet, quintic_pieces
from .segment import Segment

_CRUMB = 1e-9
"""A way below this share of the whole is none: the roundings on both sides touch."""

_LOOKS = np.linspace(0.0, 1.0, 33)


class _Piece(Protocol):
    def jet(self, s: FloatArray, derivative: int) -> FloatArray:
        """Give places or a derivative by s, shape (m, 3)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class _Straight:
    """A segment by a parameter that goes from ``start`` on and grows by ``span`` along it."""

    segment: Segment
    start: float
    span: float

    def jet(self, s: FloatArray, derivative: int) -> FloatArray:
        x = (s - self.start) / self.span
        return self.segment.at(x, derivative) / self.span**derivative


@dataclass(frozen=True, slots=True, eq=False)
class _Corner:
    """A quintic between two segments."""

    start: float
    coefficients: FloatArray

    def jet(self, s: FloatArray, derivative: int) -> FloatArray:
        x = (s - self.start)[:, None]
        value = np.zeros((len(s), 3))
        for j in range(5, derivative - 1, -1):
            factor = float(np.prod(np.arange(j - derivative + 1, j + 1)))
            value = value * x + factor * self.coefficients[j]
        return value


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A way through places, C2 where its segments are joined by roundings or go on smoothly."""

    segments: Sequence[Segment]
    """The segments, each beginning where the one before it ends."""
    s: FloatArray
    """Parameter of their ends, rising, shape (k + 1,); each is run through evenly."""
    half_widths: FloatArray
    """How far before and behind a corner it is rounded, in the parameter, shape (k + 1,), 0 at the
    ends; where it is 0 inside, the two segments are one to second order. No two may overlap."""
    breaks: FloatArray = field(init=False)
    """Ends of the smooth pieces."""
    _pieces: list[_Piece] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        edges, pieces = [float(self.s[0])], list[_Piece]()
        crumb = _CRUMB * float(self.s[-1] - self.s[0])
        for i, segment in enumerate(self.segments):
            straight = _Straight(segment, float(self.s[i]), float(self.s[i + 1] - self.s[i]))
            end = float(self.s[i + 1] - self.half_widths[i + 1])
            if end - edges[-1] > crumb:
                pieces.append(straight)
                edges.append(end)
            if self.half_widths[i + 1] > 0.0:
                pieces.append(self._corner(i + 1))
                edges.append(float(self.s[i + 1] + self.half_widths[i + 1]))
        edges[-1] = float(self.s[-1])
        object.__setattr__(self, "breaks", np.array(edges))
        object.__setattr__(self, "_pieces", pieces)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.s[0]), float(self.s[-1])

    def at(self, u: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give places, or a derivative by the parameter, shape (m, 3).

        Raises:
            CurveError: If a parameter lies outside the domain.
        """
        s = np.asarray(u, dtype=np.float64)
        outside = ~((s >= self.s[0]) & (s <= self.s[-1]))
        if outside.any():
            where = float(s[int(np.argmax(outside))])
            raise CurveError(f"defined from {self.s[0]} to {self.s[-1]}, not at {where}", "course")
        which = np.searchsorted(self.breaks[1:-1], s, side="right")
        values = np.empty((len(s), 3))
        for k in np.unique(which):
            here = which == k
            values[here] = self._pieces[k].jet(s[here], derivative)
        return values

    def farthest_from_corner(self, i: int) -> float:
        """Give how far the rounding of a corner gets from it, m."""
        if self.half_widths[i] <= 0.0:
            return 0.0
        width = self.half_widths[i]
        s = np.clip(self.s[i] + width * (2.0 * _LOOKS - 1.0), self.s[0], self.s[-1])
        corner = self.segments[i].at(np.zeros(1))[0]
        return float(np.linalg.norm(self.at(s) - corner, axis=1).max())

    def _corner(self, i: int) -> _Corner:
        """Give the quintic around corner i: place, direction and bend of both segments there."""
        begin, end = self.s[i] - self.half_widths[i], self.s[i] + self.half_widths[i]
        before, behind = (
            _Straight(self.segments[k], float(self.s[k]), float(self.s[k + 1] - self.s[k]))
            for k in (i - 1, i)
        )

        def jet(piece: _Straight, at: float) -> Jet:
            first, second, third = (piece.jet(np.array([at]), order) for order in (0, 1, 2))
            return first, second, third

        pieces = quintic_pieces(np.array([end - begin]), jet(before, begin), jet(behind, end))
        return _Corner(float(begin), pieces[0])


def goes_on(before: Segment, behind: Segment, spans: tuple[float, float]) -> bool:
    """Tell whether one segment goes on into the next to second order: no corner is between them.

    Args:
        before: The first.
        behind: The second, which begins where the first ends.
        spans: How much the parameter grows along each.
    """
    end, begin = np.ones(1), np.zeros(1)
    for order, tolerance in ((1, 1e-9), (2, 1e-6)):
        gap = (
            before.at(end, order) / spans[0] ** order - behind.at(begin, order) / spans[1] ** order
        )
        if np.abs(gap).max() * min(spans) ** (order - 1) > tolerance:
            return False
    return True
