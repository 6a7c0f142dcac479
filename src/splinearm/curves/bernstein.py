"""Polynomials in Bernstein form, many at a time, each with a bound on the error of its numbers.

The bound is what makes it possible to say that a polynomial has no root somewhere: a sign counts
only where it is larger than all rounding that led to it.
"""

from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np

from splinearm.arrays import FloatArray

EPS = float(np.finfo(np.float64).eps)
"""Distance from 1 to the next number."""


@cache
def binomials(degree: int) -> FloatArray:
    """Give the binomial coefficients of a degree, shape (degree + 1,)."""
    row = np.array([comb(degree, i) for i in range(degree + 1)], dtype=np.float64)
    row.flags.writeable = False
    return row


def bezier_pieces(
    knots: FloatArray, rows: FloatArray, degree: int
) -> tuple[FloatArray, FloatArray]:
    """Give the k + 1 ends of the pieces of a B-spline and their points, (k, degree + 1, dim)."""
    # point j of a piece is the blossom of degree - j times its start and j times its end
    # (Ramshaw, Blossoms are polar forms, 1989): de Boor's recurrence, with one of the two a step
    ends = np.unique(knots[degree : knots.size - degree])
    spans = np.searchsorted(knots, ends[:-1], side="right")[:, None] - 1
    # axes: how often the end was taken, piece, point, coordinate
    local = rows[spans + np.arange(-degree, 1)][None]
    for d in range(degree, 0, -1):
        low, high = knots[spans + np.arange(1 - d, 1)], knots[spans + np.arange(1, d + 1)]
        share = ((ends[:-1, None] - low) / (high - low))[..., None]
        last = ((ends[1:, None] - low) / (high - low))[..., None]
        first, second = local[:, :, :-1], local[:, :, 1:]
        local = np.concatenate(
            (
                first * (1.0 - share) + second * share,
                first[-1:] * (1.0 - last) + second[-1:] * last,
            )
        )
    return ends, np.ascontiguousarray(local[:, :, 0].swapaxes(0, 1))


def multiply(f: FloatArray, g: FloatArray) -> FloatArray:
    """Give products of polynomials, coefficients on the last axis."""
    # Farouki and Rajan, Algorithms for polynomials in Bernstein form, CAGD 5 (1988) eq. 44
    m, n = f.shape[-1] - 1, g.shape[-1] - 1
    scaled = g * binomials(n)
    shape = np.broadcast_shapes(f.shape[:-1], g.shape[:-1])
    out = np.zeros((*shape, m + n + 1))
    for i in range(m + 1):
        out[..., i : i + n + 1] += (f[..., i, None] * binomials(m)[i]) * scaled
    out /= binomials(m + n)
    return out


def differentiate(f: FloatArray) -> FloatArray:
    """Give derivatives by a parameter from 0 to 1, coefficients on the last axis."""
    degree = f.shape[-1] - 1
    return np.diff(f, axis=-1) * degree if degree else np.zeros_like(f)


def values(f: FloatArray, t: FloatArray) -> FloatArray:
    """Give the value of each polynomial at its own parameter from 0 to 1, shape (k,).

    Args:
        f: Coefficients, shape (k, n + 1).
        t: Parameters, shape (k,).
    """
    # de Casteljau
    local = f
    share = t[:, None]
    for _ in range(f.shape[-1] - 1):
        local = local[:, :-1] * (1.0 - share) + local[:, 1:] * share
    return local[:, 0]


@dataclass(frozen=True, slots=True, eq=False)
class Bounded:
    """Polynomials, one of each piece of a curve, and by how much their numbers may be wrong."""

    c: FloatArray
    """Coefficients, shape (k, n + 1)."""
    error: FloatArray
    """Bound on the error of each coefficient, shape (k,)."""

    @property
    def size(self) -> FloatArray:
        """The largest coefficient of each, shape (k,)."""
        largest: FloatArray = np.abs(self.c).max(axis=1)
        return largest

    def derivative(self) -> "Bounded":
        """Give the derivatives."""
        degree = self.c.shape[1] - 1
        if degree == 0:
            return Bounded(np.zeros_like(self.c), np.zeros_like(self.error))
        return Bounded(
            differentiate(self.c), 2.0 * degree * self.error + 2.0 * EPS * degree * self.size
        )

    def times(self, factor: "float | FloatArray") -> "Bounded":
        """Give multiples, one factor for all or one for each."""
        each = np.broadcast_to(np.asarray(factor, dtype=np.float64), self.error.shape)
        error = np.abs(each) * (self.error + EPS * self.size)
        return Bounded(self.c * each[:, None], error)

    def __mul__(self, other: "Bounded") -> "Bounded":
        terms = self.c.shape[1] + other.c.shape[1]
        error = self.size * other.error + other.size * self.error + self.error * other.error
        return Bounded(
            multiply(self.c, other.c), error + (terms + 2) * EPS * self.size * other.size
        )

    def __add__(self, other: "Bounded") -> "Bounded":
        degree = max(self.c.shape[1], other.c.shape[1]) - 1
        a, b = self._raised(degree), other._raised(degree)
        total = a.c + b.c
        return Bounded(total, a.error + b.error + EPS * np.abs(total).max(axis=1))

    def __neg__(self) -> "Bounded":
        return Bounded(-self.c, self.error)

    def __sub__(self, other: "Bounded") -> "Bounded":
        return self + (-other)

    def _raised(self, degree: int) -> "Bounded":
        """Give the same polynomials in the basis of a higher degree."""
        more = degree - (self.c.shape[1] - 1)
        if more == 0:
            return self
        one = Bounded(np.ones((len(self.c), more + 1)), np.zeros_like(self.error))
        return self * one
