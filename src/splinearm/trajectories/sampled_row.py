"""Limits that are no polynomials by s: taken at some places of each cell, then looked at between.

Torques and what the tool does are of the form, at each place of a path,

    push d2s/dt2 + bend x <= room,    x = (ds/dt)^2

On a cell they are replaced by polynomials through a few places. What that misses is found by
looking at the finished law, and the limit of that cell is then tightened by as much.
"""

from typing import NamedTuple, Protocol

import numpy as np

from splinearm.arrays import FloatArray

from .constraint import from_even_values

SHARES = np.array([0.0, 0.5, 1.0])
"""Where in each cell rows are taken."""

CAP_SHARES = np.linspace(0.0, 1.0, 8)
"""Where in each cell speeds are taken."""

_ROUNDING = 1e-12
_STEEPEST = 4.0
_STILL = 1e-28


class Lines(NamedTuple):
    """What a limit says of neighbours, as `reachability_kernel` takes it."""

    above: FloatArray
    """Shape (cells, 2, k)."""
    below: FloatArray
    """Shape (cells, 2, k)."""
    alone: FloatArray
    """The largest x[i] of each cell, shape (cells,)."""


class Taken(Protocol):
    """A limit as it is taken on a grid."""

    @property
    def squares(self) -> FloatArray | None:
        """Factors of x in its caps, factor x <= 1; None: it has no caps.

        They are at even shares of each cell, shape (cells, shares, uses).
        """
        ...

    def lines(self, ease: FloatArray, ceiling: FloatArray) -> Lines | None:
        """Give what it says of neighbours; None: nothing, it has caps only.

        Args:
            ease: By how much each of its uses is tightened, 1 or more, shape (cells, uses).
            ceiling: No x of a cell is above this, shape (cells,).
        """
        ...

    def follow(self, x: FloatArray) -> bool:
        """Take it anew near the law x if it is taken near a law; tell whether that moved it."""
        ...

    def use(self, x: FloatArray) -> FloatArray:
        """Give the largest share of it that the law x uses in each cell, shape (cells, uses)."""
        ...


class SampledLimit(Protocol):
    """A limit along a path that is taken at places."""

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """Joint (or "tool") and quantity of each of its uses."""
        ...

    def on(self, s: FloatArray) -> Taken:
        """Give it on the cells between nodes s."""
        ...


def motion(s: FloatArray, x: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give x, shape (cells, shares), and d2s/dt2 of each cell, shape (cells, 1)."""
    square = x[:-1, None] * (1.0 - shares) + x[1:, None] * shares
    return square, (np.diff(x) / (2.0 * np.diff(s)))[:, None]


def lines_of(push: FloatArray, bend: FloatArray, room: FloatArray, s: FloatArray) -> Lines:
    """Give the lines of push u + bend x <= room on the cells between nodes s.

    Args:
        push: At ``SHARES`` of each cell, shape (cells, 3, rows).
        bend: As ``push``.
        room: Shape (cells, rows), above 0.
        s: Nodes, shape (cells + 1,).
    """
    push = push * (0.5 / np.diff(s))[:, None, None]
    a, b = bend * (1.0 - SHARES)[:, None] - push, bend * SHARES[:, None] + push
    cells = len(s) - 1
    a = (_quadratic(a) / room[:, None]).reshape(cells, -1)
    b = (_quadratic(b) / room[:, None]).reshape(cells, -1)
    lone = np.abs(b) <= _ROUNDING * np.abs(a)
    inverse = 1.0 / np.where(lone, np.inf, b)
    above, below = np.zeros((2, cells, 2, a.shape[1]))
    for lines, here in ((above, inverse > 0.0), (below, inverse < 0.0)):
        lines[:, 0] = np.where(here, -a * inverse, 0.0)
        lines[:, 1] = np.where(here, np.abs(inverse), np.inf)
    return Lines(above, below, 1.0 / np.where(lone, a, 0.0).max(axis=1, initial=1e-300))


def lower_caps(square: FloatArray, cap: FloatArray) -> None:
    """Lower the caps of nodes so that no straight x is above 1 / square within a cell.

    Args:
        square: Factors of x at even shares of each cell, shape (cells, shares, uses).
        cap: Shape (cells + 1,).
    """
    first, last = square[:, 0].max(axis=1), square[:, -1].max(axis=1)
    floor = max(_STILL * float(square.max(initial=0.0)), 1e-300)
    y = 1.0 / np.maximum(np.stack((first, last)), floor)
    y = np.minimum(y, _STEEPEST * y[::-1])
    shares = np.linspace(0.0, 1.0, square.shape[1])
    straight = y[0][:, None] * (1.0 - shares) + y[1][:, None] * shares
    values = square * straight[:, :, None]
    coefficients = np.einsum("jk,ckn->cjn", from_even_values(len(shares) - 1), values)
    y = y / np.maximum(coefficients.max(axis=(1, 2)), 1.0)
    cap[:-1] = np.minimum(cap[:-1], y[0])
    cap[1:] = np.minimum(cap[1:], y[1])


def _quadratic(values: FloatArray) -> FloatArray:
    """Give Bernstein coefficients of parabolas through values at 0, 1/2 and 1, axis 1."""
    coefficients = values.copy()
    coefficients[:, 1] = 2.0 * values[:, 1] - 0.5 * (values[:, 0] + values[:, 2])
    return coefficients
