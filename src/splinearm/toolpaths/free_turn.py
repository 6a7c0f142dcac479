"""How a tool stands that points in one direction and turns about it as the arm likes."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.kinematics import quaternion
from splinearm.trajectories.turning import SpaceJet, Turning, inside

_STEPS = 4
"""Degree plus one of the curve of turns."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FreeTurn:
    """The orientation of a tool that turns about its pointing axis by a curve."""

    quat: FloatArray
    """Orientation at turn 0, shape (4,)."""
    axis: FloatArray
    """The pointing axis in the fixed frame, of length 1, shape (3,)."""
    turn: BSpline
    """The turn about it, rad, one number a place; C2."""
    domain: tuple[float, float]
    """From where to where it is asked."""

    @property
    def breaks(self) -> FloatArray:
        """Where the curve of turns is no more than C2, and the ends."""
        low, high = self.domain
        inner = self.turn.breaks
        inner = inner[(inner > low) & (inner < high)]
        if not np.ptp(self.turn.points):
            inner = inner[:0]
        return np.concatenate(([low], inner, [high]))

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations at parameters, shape (m,).

        Raises:
            CurveError: If one lies outside the domain.
        """
        u = inside(u, self.domain)
        turn, rate, change = (self.turn.at(u, order) for order in (0, 1, 2))
        turned = quaternion.multiply(quaternion.exp(turn * self.axis), self.quat)
        return Turning(turned, rate * self.axis, change * self.axis)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PanTurn:
    """The orientation of a tool that turns with its place about an axis, as on an arm that pans."""

    quat: FloatArray
    """Orientation where the place is along ``out``, shape (4,)."""
    axis: FloatArray
    """The axis, of length 1, shape (3,)."""
    centre: FloatArray
    """A point of it, shape (3,), m."""
    out: FloatArray
    """A direction at right angles to it, of length 1, shape (3,)."""
    way: SpaceJet
    """Where the tool goes."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return self.way.domain

    @property
    def breaks(self) -> FloatArray:
        """The ends of the way's smooth pieces."""
        return self.way.breaks

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations at parameters, shape (m,)."""
        side = np.cross(self.axis, self.out)
        x, y = ((self.way.at(u) - self.centre) @ v for v in (self.out, side))
        (dx, dy), (ddx, ddy) = (
            [self.way.at(u, order) @ v for v in (self.out, side)] for order in (1, 2)
        )
        square = x * x + y * y
        rate = (x * dy - y * dx) / square
        change = (x * ddy - y * ddx - 2.0 * (x * dx + y * dy) * rate) / square
        turn = np.arctan2(y, x)[:, None]
        turned = quaternion.multiply(quaternion.exp(turn * self.axis), self.quat)
        return Turning(turned, rate[:, None] * self.axis, change[:, None] * self.axis)


def smooth_turn(s: FloatArray, turn: FloatArray, spans: int) -> BSpline:
    """Give a smooth curve (C2) along steps of turn, by local means: it never overshoots.

    Args:
        s: Where, rising, shape (m,).
        turn: The turns there, whole turns counted, shape (m,), rad.
        spans: Of how many pieces the curve is at the most.
    """
    ends = s[0], s[-1]
    if not np.ptp(turn):
        knots = np.repeat(ends, _STEPS)
        return BSpline(knots, np.full((_STEPS, 1), turn[0]), _STEPS - 1)
    inner = np.linspace(*ends, spans + 1)[1:-1]
    knots = np.concatenate((np.repeat(ends[0], _STEPS), inner, np.repeat(ends[1], _STEPS)))
    # Greville's abscissae: control points that are values there vary no more than the values do
    # (Schoenberg 1967)
    count = len(knots) - _STEPS
    at = np.array([knots[i + 1 : i + _STEPS].mean() for i in range(count)])
    return BSpline(knots, np.interp(at, s, turn)[:, None], _STEPS - 1)
