"""What limits allow on a path, as linear inequalities that hold on whole cells, not at points.

Along a path q(s) let x be the square of ds/dt. On a cell from s[i] to s[i + 1] x is linear, so
that d2s/dt2 is constant. Then a limit is an inequality for a polynomial in s whose coefficients
are linear in (x[i], x[i + 1])::

    acceleration  q'(s) x'/2 + q''(s) x(s) <= qdd_max   (and >= -qdd_max)

A polynomial on an interval is never above the largest of its Bernstein coefficients. So the limits
hold everywhere on the cell if they hold for these: rows a x[i] + b x[i + 1] <= 1.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import comb
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits

from .joint_path import JointPath


class Rows(NamedTuple):
    """Inequalities a x[i] + b x[i + 1] <= 1 of each cell."""

    a: FloatArray
    """Shape (cells, rows)."""
    b: FloatArray
    """Shape (cells, rows)."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SpeedCap:
    """How fast the tool may be along a path."""

    edges: FloatArray
    """Where the speed changes, rising from the path's start to its end, shape (k + 1,)."""
    speeds: FloatArray
    """Highest speed between them, m/s, shape (k,); infinity where there is none."""
    rate: Callable[[FloatArray], FloatArray]
    """Gives the tool's speed by s, |dp/ds|, shape (m,), at s of shape (m,)."""

    def between(self, s: FloatArray) -> FloatArray:
        """Give the speed of each cell between nodes s, shape (m - 1,), m/s."""
        return self.at(0.5 * (s[:-1] + s[1:]))

    def at(self, s: FloatArray) -> FloatArray:
        """Give the speed at s, shape (m,), m/s; where it changes that from there on."""
        cell = np.searchsorted(self.edges[1:-1], s, side="right")
        speed: FloatArray = self.speeds[cell]
        return speed

    def used(self, s: FloatArray, shares: FloatArray) -> FloatArray:
        """Give how much of the speed ds/dt = 1 uses at shares of cells, shape (cells, shares)."""
        at = places(s, shares)
        rate = self.rate(at.ravel()).reshape(at.shape)
        share: FloatArray = rate / self.between(s)[:, None]
        return share


def acceleration_rows(path: JointPath, limits: JointLimits, s: FloatArray) -> Rows:
    """Give the inequalities of the joints' accelerations on the cells between nodes s.

    Args:
        path: The path; no cell may reach over an end of its pieces.
        limits: What the joints may do.
        s: Nodes, rising, shape (m,).
    """
    degree = max(path.curve.degree - 1, 1)
    shares = np.linspace(0.0, 1.0, degree + 1)
    _, slope, bend = on_cells(path, s, shares)
    # x' / 2 = (x[i + 1] - x[i]) / (2 h), x(s) = (1 - share) x[i] + share x[i + 1]
    steady = slope / (2.0 * np.diff(s)[:, None, None])
    a = _bernstein(bend * (1.0 - shares)[:, None] - steady) / limits.qdd_max
    b = _bernstein(bend * shares[:, None] + steady) / limits.qdd_max
    cells = len(s) - 1
    a, b = a.reshape(cells, -1), b.reshape(cells, -1)
    return Rows(np.hstack((a, -a)), np.hstack((b, -b)))


def places(s: FloatArray, shares: FloatArray) -> FloatArray:
    """Give places at shares of each cell, shape (cells, shares)."""
    at: FloatArray = s[:-1, None] + np.diff(s)[:, None] * shares
    if shares[-1] == 1.0:
        at[:, -1] = s[1:]
    return at


def on_cells(
    path: JointPath, s: FloatArray, shares: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give q, q' and q'' at shares of each cell, each of shape (cells, shares, n)."""
    pieces = path.pieces_of(0.5 * (s[:-1] + s[1:]))
    at = s[:-1, None] + np.diff(s)[:, None] * shares
    sampled = path.sample(at.ravel(), np.repeat(pieces, shares.size))
    q, slope, bend = (values.reshape(*at.shape, path.n) for values in sampled)
    return q, slope, bend


def _bernstein(values: FloatArray) -> FloatArray:
    """Give Bernstein coefficients of polynomials with values at even shares, axis 1."""
    coefficients: FloatArray = np.einsum(
        "jk,ckn->cjn", from_even_values(values.shape[1] - 1), values
    )
    return coefficients


@cache
def from_even_values(degree: int) -> FloatArray:
    """Give the matrix from values at 0, 1/d ... 1 to Bernstein coefficients of degree d."""
    t = np.linspace(0.0, 1.0, degree + 1)[:, None]
    k = np.arange(degree + 1)
    binomials = np.array([comb(degree, i) for i in k], dtype=np.float64)
    values = binomials * t**k * (1.0 - t) ** (degree - k)
    return np.asarray(np.linalg.inv(values), dtype=np.float64)
