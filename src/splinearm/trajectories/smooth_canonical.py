"""The same way whatever its units are: by shares of itself, of what joints may do, and of a time.

Joints are measured by how far their highest velocity brings them in a unit of time that goes with
the problem, the path parameter by its share of the way. Numbers that differ by the rounding of
their units alone are then rounded to fewer digits than that, so that they are the same, and so is
all that follows from them.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray

from .constraint import SpeedCap
from .smooth_grid import Way

_BITS = 34
"""So many digits of a number count, to the base of two."""

_PLACE_BITS, _SHORTEST_BITS = 38, 24
"""Places are rounded to this share of the way, and of the shortest piece of the path."""

_PIECE_BITS, _JOINT_BITS = 36, 44
"""Coefficients are rounded to these shares of how far a joint goes on a piece, or on them all."""


@dataclass(frozen=True, slots=True, eq=False)
class SharePath:
    """The way of joints by shares of it, as ``JointPath`` has it, without its positions."""

    breaks: FloatArray
    """Ends of the polynomial pieces, shape (k + 1,)."""
    coefficients: FloatArray
    """Of powers of s - breaks[i] on piece i, shape (k, degree + 1, n)."""

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.coefficients.shape[2])

    def pieces_of(self, s: FloatArray) -> IndexArray:
        """Give the piece that each s lies in, shape (m,)."""
        return np.searchsorted(self.breaks[1:-1], s, side="right")

    def slopes(
        self, s: FloatArray, side: Literal["left", "right"] = "right"
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the first three derivatives of q by s, each of shape (m, n).

        Args:
            s: Where, shape (m,).
            side: "left": places between two pieces belong to the one before.
        """
        pieces = np.searchsorted(self.breaks[1:-1], s, side=side)
        x, taken = (s - self.breaks[pieces])[:, None], self.coefficients[pieces]
        values = np.zeros((4, len(s), self.n))
        # Horner's scheme for a polynomial and its derivatives
        for k in range(taken.shape[1] - 1, -1, -1):
            for order in range(3, 0, -1):
                values[order] = values[order] * x + values[order - 1]
            values[0] = values[0] * x + taken[:, k]
        return values[1], 2.0 * values[2], 6.0 * values[3]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Canonical:
    """A way in its own units, and how to come back from them."""

    way: Way
    """From 0 to 1, within limits of velocity of 1."""
    start: float
    """First s."""
    end: float
    """Last s."""
    unit: float
    """The unit of time, s."""

    @property
    def length(self) -> float:
        """Length of the way by s."""
        return self.end - self.start

    def at(self, share: FloatArray) -> FloatArray:
        """Give s at nodes, shape (m,)."""
        s: FloatArray = self.start + self.length * share
        s[share == 1.0] = self.end
        return s


def canonical(
    breaks: FloatArray,
    coefficients: FloatArray,
    span: tuple[float, float],
    limits: FloatArray,
    cap: SpeedCap | None,
) -> Canonical:
    """Give a part of a path in its own units.

    Args:
        breaks: Ends of the path's pieces, shape (k + 1,).
        coefficients: Of their polynomials, shape (k, degree + 1, n).
        span: First and last s.
        limits: Highest velocity, acceleration and jerk, shape (3, n) or, with those of s itself
            (infinity: none), (3, n + 1).
        cap: How fast the tool may be.
    """
    start, end = span
    length = end - start
    first = int(np.searchsorted(breaks[1:-1], start, side="right"))
    last = int(np.searchsorted(breaks[1:-1], end, side="left"))
    breaks, coefficients = breaks[first : last + 2].copy(), coefficients[first : last + 1].copy()
    coefficients[0] = _shifted(coefficients[0], start - breaks[0])
    breaks[0], breaks[-1] = start, end
    n, h = coefficients.shape[2], np.diff(breaks) / length
    powers = np.arange(coefficients.shape[1])[:, None]
    quantum = 2.0 ** min(-_PLACE_BITS, np.floor(np.log2(h.min())) - _SHORTEST_BITS)
    apart = coefficients * length**powers
    reach = h[:, None, None] ** powers
    moves = np.abs(apart * reach)
    unit = _unit(moves[:, 1:].max(axis=(0, 1), initial=0.0), limits)
    scale = 1.0 / (limits[0, :n] * unit)
    quanta = np.maximum(
        moves[:, 1:].max(axis=1, keepdims=True, initial=0.0) * 2.0**-_PIECE_BITS,
        moves.max(axis=(0, 1)) * 2.0**-_JOINT_BITS,
    )
    steps = _power_of_two(quanta * scale) / _power_of_two(reach)
    path = SharePath(
        np.rint((breaks - start) / length / quantum) * quantum,
        np.ascontiguousarray(np.rint(apart * scale / steps) * steps),
    )
    units = unit ** np.arange(1.0, 4.0)[:, None]
    measured = rounded(limits * units * np.append(scale, 1.0 / length)[: limits.shape[1]])
    if limits.shape[1] > n:
        measured[:, n] = np.where(np.isfinite(limits[:, n]), measured[:, n], np.inf)
    measured[0, :n] = 1.0
    shared_cap = None if cap is None else _shared(cap, span, unit, quantum)
    return Canonical(
        way=Way(path, measured, shared_cap),
        start=start,
        end=end,
        unit=unit,
    )


def rounded(values: FloatArray) -> FloatArray:
    """Give values to the digits that count."""
    mantissa, exponent = np.frexp(values)
    nearly: FloatArray = np.ldexp(np.rint(np.ldexp(mantissa, _BITS)), exponent - _BITS)
    return nearly


def _shifted(coefficients: FloatArray, by: float) -> FloatArray:
    """Give the coefficients of the same polynomials, shape (degree + 1, n), seen from there."""
    shifted, degree = coefficients.copy(), len(coefficients) - 1
    # Horner's scheme again and again
    for k in range(degree):
        for m in range(degree - 1, k - 1, -1):
            shifted[m] += by * shifted[m + 1]
    return shifted


def _unit(moves: FloatArray, limits: FloatArray) -> float:
    """Give a time that goes with joints that move about so far."""
    velocity, acceleration, jerk = limits[:, : moves.size]
    times = moves / velocity, np.sqrt(moves / acceleration), np.cbrt(moves / jerk)
    longest = float(np.max(times))
    return longest if longest > 0.0 else 1.0


def _power_of_two(values: FloatArray) -> FloatArray:
    """Give the powers of two that are about as large, and 1 for 0."""
    # not where one goes over to the next at a power of two itself, which values often are
    exponent = np.floor(np.log2(np.where(values > 0.0, 1.37 * values, 1.0)))
    power: FloatArray = 2.0**exponent
    return power


def _shared(cap: SpeedCap, span: tuple[float, float], unit: float, quantum: float) -> SpeedCap:
    """Give how fast the tool may be by shares of a way and its unit of time."""
    start, length = span[0], span[1] - span[0]
    slowest = float(cap.speeds.min())
    least = slowest if slowest < np.inf else 1.0

    def rate(share: FloatArray) -> FloatArray:
        s = np.clip(start + length * share, *span)
        return rounded(np.abs(cap.rate(s)) * (length / unit / least))

    edges = np.rint((cap.edges - start) / length / quantum) * quantum
    finite = np.isfinite(cap.speeds)
    speeds = np.where(finite, rounded(np.where(finite, cap.speeds, 1.0) / least), np.inf)
    return SpeedCap(edges=edges, speeds=speeds, rate=rate)
