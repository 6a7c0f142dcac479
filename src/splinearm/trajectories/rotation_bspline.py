"""Cumulative B-splines of rotations: curves of orientations that control orientations pull at."""

from dataclasses import dataclass, field
from math import factorial
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves import basis
from splinearm.curves.bspline import BSpline
from splinearm.kinematics import quaternion

from . import rotation_table
from .turning import Turning, checked_quats, equal_signs


# Kim, Kim and Shin, A general construction scheme for unit quaternion curves with simple high
# order derivatives, SIGGRAPH 1995: a B-spline is its first control point and increments, each
# times the sum of the basis functions from there on; with rotations for points and products for
# sums that is a curve of rotations
@dataclass(frozen=True, slots=True, eq=False)
class RotationBSpline:
    """A curve of orientations by control orientations and knots, like a ``BSpline`` of points.

    Of degree p it has p - 1 continuous derivatives, fewer by one for each time a knot is repeated.
    It stays near its control orientations and each moves only degree + 1 pieces. Turning all of
    them turns the curve. With end knots of multiplicity degree + 1 (clamped) it starts and ends in
    its outer ones. Of degree 1 it turns evenly from one to the next (slerp).
    """

    knots: FloatArray
    """Knots, shape (m + degree + 1,), never falling."""
    start: FloatArray
    """The first control orientation, a unit quaternion w x y z, shape (4,)."""
    turns: FloatArray
    """From each control orientation to the next, rotation vectors in the frame of the one before,
    shape (m - 1, 3), rad; they may be longer than a half turn."""
    degree: int
    """Degree, at least 1."""
    _table: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        turns = frozen_array(self.turns, (None, 3), "turns")
        if self.degree < 1:
            raise ValueError(f"degree: want at least 1, got {self.degree!r}")
        # the same knots carry a curve of numbers, which checks them
        frame = BSpline(self.knots, np.zeros((len(turns) + 1, 1)), self.degree)
        object.__setattr__(self, "knots", frame.knots)
        object.__setattr__(self, "start", checked_quats(np.asarray(self.start)[None], "start")[0])
        object.__setattr__(self, "turns", turns)
        object.__setattr__(self, "_table", _table_of(self))

    @classmethod
    def from_controls(cls, knots: ArrayInput, quats: ArrayInput, degree: int) -> Self:
        """Give the curve of control orientations, which takes the shorter way between neighbours.

        Between neighbours half a turn apart there are two shortest ways: one of them is taken.

        Args:
            knots: Knots, shape (m + degree + 1,), never falling.
            quats: Unit quaternions w x y z of either sign, shape (m, 4).
            degree: Degree, at least 1.

        Raises:
            ValueError: If the numbers do not fit.
        """
        controls = checked_quats(quats)
        return cls(frozen_array(knots, (None,), "knots"), controls[0], shorter(controls), degree)

    @classmethod
    def closed(cls, knots: ArrayInput, quats: ArrayInput, degree: int) -> Self:
        """Give the closed curve of a ring of control orientations.

        Args:
            knots: The m + 1 different or repeated knots of one turn, first to last.
            quats: The ring, unit quaternions w x y z of either sign, shape (m, 4).
            degree: Degree, at least 1.

        Raises:
            ValueError: If the numbers do not fit.
        """
        ring = checked_quats(quats)
        return cls.of_ring(knots, ring[0], shorter(np.vstack((ring, ring[:1]))), degree)

    @classmethod
    def of_ring(cls, knots: ArrayInput, start: FloatArray, turns: FloatArray, degree: int) -> Self:
        """Give the closed curve of the m turns of a ring; the last leads back to the first."""
        m = len(turns)
        frame = BSpline.closed(knots, np.zeros((m, 1)), degree)
        return cls(frame.knots, start, turns[np.arange(m + degree - 1) % m], degree)

    @property
    def quats(self) -> FloatArray:
        """The control orientations, unit quaternions, shape (m, 4)."""
        return chained(self.start, self.turns)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return rotation_table.domain_of(self._table)

    @property
    def breaks(self) -> FloatArray:
        """The different knots of the domain: the ends of the pieces."""
        return self._table[:, 0].copy()

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations.

        Args:
            u: Parameters in the domain, shape (m,).

        Raises:
            CurveError: If one lies outside.
        """
        return rotation_table.sample(self._table, u)

    def into(self, u: float, state: FloatArray) -> None:
        """Write orientation, angular velocity and acceleration at one parameter, for tight loops.

        Args:
            u: Parameter in the domain.
            state: Contiguous array of float64, shape (10,): quaternion w x y z, angular velocity,
                angular acceleration in the fixed frame.

        Raises:
            CurveError: If the parameter lies outside the domain or is not a number.
            ValueError: If ``state`` has not that shape.
            TypeError: If ``state`` is no such array.
        """
        rotation_table.sample_into(self._table, u, state)

    def turned(self, quat: ArrayInput) -> "RotationBSpline":
        """Give the curve with the fixed frame turned: ``quat`` times each of its orientations.

        Raises:
            ValueError: If ``quat`` is no unit quaternion.
        """
        start = quaternion.multiply(checked_quats(np.asarray(quat)[None], "quat")[0], self.start)
        return RotationBSpline(self.knots, start, self.turns, self.degree)


def chained(start: FloatArray, turns: FloatArray) -> FloatArray:
    """Give orientations, shape (m, 4), from the first and the m - 1 turns between them."""
    # products of ever longer stretches: rounding grows with the logarithm of their number
    quats = np.vstack((start, quaternion.exp(turns)))
    shift = 1
    while shift < len(quats):
        quats[shift:] = quaternion.multiply(quats[:-shift], quats[shift:])
        shift *= 2
    return quaternion.normalize(quats)


def shorter(quats: FloatArray) -> FloatArray:
    """Give the turns from each orientation to the next the shorter way, shape (m - 1, 3)."""
    quats = equal_signs(quats)
    return quaternion.log(quaternion.multiply(quaternion.conjugate(quats[:-1]), quats[1:]))


def cumulative_values(
    knots: FloatArray, degree: int, spans: basis.IndexArray, u: FloatArray, derivative: int = 0
) -> FloatArray:
    """Give a derivative of the cumulative basis functions alive at each u, shape (k, degree).

    Column j belongs to the turn that leads to control orientation ``spans - degree + 1 + j``.
    """
    values = basis.basis_values(knots, degree, spans, u, derivative)
    sums: FloatArray = np.cumsum(values[:, :0:-1], axis=1)[:, ::-1]
    return sums


def _table_of(curve: RotationBSpline) -> FloatArray:
    """Give what samples a curve: the turns alive on each piece and their basis functions."""
    knots, degree = curve.knots, curve.degree
    breaks = np.unique(knots[degree : knots.size - degree])
    spans = basis.find_spans(knots, degree, breaks[:-1])
    alive = spans[:, None] + np.arange(-degree, 0)
    shares = np.stack(
        [
            cumulative_values(knots, degree, spans, breaks[:-1], j) / factorial(j)
            for j in range(degree, -1, -1)
        ],
        axis=2,
    )
    return rotation_table.make(breaks, curve.quats[spans - degree], curve.turns[alive], shares)
