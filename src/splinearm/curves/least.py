"""Control points by least squares: what fitting and smoothing share, on bare arrays."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import basis


class Frame(NamedTuple):
    """The curves among which the best is looked for."""

    knots: FloatArray
    """Knots, shape (m + degree + 1,); of a closed curve those of a ring of points."""
    degree: int
    """Degree."""
    first: FloatArray
    """Control points at the start that are given, shape (a, dim)."""
    last: FloatArray
    """Control points at the end that are given, shape (b, dim)."""
    closed: bool = False
    """Whether the control points are a ring."""

    @property
    def unknowns(self) -> int:
        """Number of control points to find."""
        m = len(self.knots) - self.degree - 1
        return m - self.degree if self.closed else m - len(self.first) - len(self.last)

    def all_points(self, found: FloatArray) -> FloatArray:
        """Give the control points of the curve from those that were found."""
        if self.closed:
            return found[np.arange(len(found) + self.degree) % len(found)]
        return np.vstack((self.first, found, self.last))


class Equations(NamedTuple):
    """What a curve is to come near to: a derivative at a parameter in each row."""

    first: FloatArray
    """Number of the first unknown of each row, shape (k,)."""
    rows: FloatArray
    """What the unknowns count, shape (k, degree + 1)."""
    values: FloatArray
    """What is wanted of them, shape (k, dim)."""

    def scaled(self, factors: FloatArray) -> "Equations":
        """Give the equations times factors, shape (k,)."""
        return Equations(self.first, self.rows * factors[:, None], self.values * factors[:, None])


class Solved(NamedTuple):
    """Least squares, solved."""

    found: FloatArray
    """The unknowns, shape (unknowns, dim)."""
    triangle: FloatArray
    """What the equations became, as module ``least_kernel`` describes it."""


def equations(frame: Frame, u: FloatArray, values: FloatArray, order: int = 0) -> Equations:
    """Give the equations C(u) = values, or of a derivative; rising u need no sorting."""
    spans = basis.find_spans(frame.knots, frame.degree, u)
    rows = basis.basis_values(frame.knots, frame.degree, spans, u, order)
    column = spans - frame.degree
    if frame.closed:
        return Equations(column.astype(np.float64), rows, values)
    m = len(frame.knots) - frame.degree - 1
    a, b = len(frame.first), len(frame.last)
    # what given points contribute goes to the other side
    for given, start in ((frame.first, 0), (frame.last, m - b)):
        touched = np.flatnonzero(
            (column < start + len(given)) & (column + frame.degree >= start) & (len(given) > 0)
        )
        if touched.size:
            at = column[touched, None] + np.arange(frame.degree + 1) - start
            inside = (at >= 0) & (at < len(given))
            share = np.where(inside, rows[touched], 0.0)
            values = values.copy()
            values[touched] -= np.einsum("kj,kjd->kd", share, given[np.clip(at, 0, len(given) - 1)])
    return Equations((column - a).astype(np.float64), rows, values)


def solve(frame: Frame, *parts: Equations) -> Solved:
    """Give the unknowns that miss the equations by the least sum of squares.

    Raises:
        CurveError: If the equations do not determine them.
    """
    first = np.concatenate([part.first for part in parts])
    width, m = frame.degree + 1, frame.unknowns
    # rows in the order of their unknowns leave the triangle small
    key = np.where(first + frame.degree >= m, -1.0, first) if frame.closed else first
    order = np.argsort(key, kind="stable")
    rows = np.concatenate([part.rows for part in parts])[order]
    right_sides = np.concatenate([part.values for part in parts])[order]
    border = min(frame.degree, m) if frame.closed else 0
    triangle = np.zeros((m, width + border))
    right = np.zeros((m, right_sides.shape[1]))
    wrong = _kernels()[0](first[order], rows, right_sides, triangle, right)
    if wrong >= 0:
        at = frame.knots[wrong + (0 if frame.closed else len(frame.first))]
        raise CurveError(
            f"too few points behind parameter {at:.6g} for so many control points there", "fit"
        )
    _kernels()[1](triangle, np.array([float(width)]), right)
    return Solved(right, triangle)


def influence(solved: Solved, part: Equations) -> FloatArray:
    """Give how much the value of each equation decides about its own fit, 0 to 1, shape (k,)."""
    out = np.empty(len(part.rows))
    _kernels()[2](part.first, part.rows, solved.triangle, np.zeros_like(solved.triangle), out)
    return out


@functools.cache
def _kernels() -> tuple[Callable[..., Any], ...]:
    """Give the kernels, compiled for their arguments."""
    from splinearm.compiled import entry, inputs, outputs

    from . import least_kernel

    return (
        entry(least_kernel.factor, *inputs(1, 2, 2), *outputs(2, 2)),
        entry(least_kernel.substitute, *inputs(2, 1), *outputs(2)),
        entry(least_kernel.leverages, *inputs(1, 2, 2), *outputs(2, 1)),
    )
