"""The angle that an orientation curve travels, and the same curve at a constant rate."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .turning import OrientationCurve, Turning, inside

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)

_ACCURACY = 1e-14
"""Relative change of the angle of a piece, when it is halved, that is rounding."""

_MOST_HALVINGS = 40

_STEPS = 60
"""Most steps to a parameter; halving alone would take 53."""


@dataclass(frozen=True, slots=True, eq=False)
class TurnLength:
    """The angle that a curve has travelled at each parameter, and back from it; exact to rounding.

    It is the integral of the angular speed: at a constant rate it grows evenly.
    """

    curve: OrientationCurve
    """The curve."""
    _edges: FloatArray = field(init=False, repr=False)
    _angles: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        edges = self.curve.breaks
        if len(edges) < 2:
            raise CurveError("one orientation travels no angle", "orientation")
        starts, ends = edges[:-1], edges[1:]
        angles = self._quadrature(starts, ends)
        least = _ACCURACY * float(angles.sum())
        kept: list[tuple[FloatArray, FloatArray]] = []
        for _ in range(_MOST_HALVINGS):
            middles = 0.5 * (starts + ends)
            first, second = self._quadrature(starts, middles), self._quadrature(middles, ends)
            open_ = np.abs(first + second - angles) > np.maximum(least, _ACCURACY * angles)
            kept.append((starts[~open_], angles[~open_]))
            starts, middles, ends = starts[open_], middles[open_], ends[open_]
            starts, ends = np.append(starts, middles), np.append(middles, ends)
            angles = np.append(first[open_], second[open_])
            if len(starts) == 0:
                break
        kept.append((starts, angles))
        all_starts, all_angles = (np.concatenate(parts) for parts in zip(*kept, strict=True))
        order = np.argsort(all_starts)
        object.__setattr__(self, "_edges", np.append(all_starts[order], edges[-1]))
        object.__setattr__(self, "_angles", np.append(0.0, np.cumsum(all_angles[order])))

    @property
    def angle(self) -> float:
        """The angle of the whole curve, rad."""
        return float(self._angles[-1])

    def at(self, u: ArrayInput) -> FloatArray:
        """Give the angles travelled up to parameters, shape (m,), rad.

        Raises:
            CurveError: If a parameter lies outside the domain.
        """
        u = inside(u, self.curve.domain)
        piece = np.clip(np.searchsorted(self._edges, u, side="right") - 1, 0, len(self._edges) - 2)
        angles: FloatArray = self._angles[piece] + self._quadrature(self._edges[piece], u)
        return angles

    def parameter(self, angle: ArrayInput) -> FloatArray:
        """Give the parameters at which angles have been travelled, shape (m,).

        Where the curve rests the first such parameter is as right as any after it: one is given.

        Raises:
            CurveError: If an angle lies outside 0 to that of the curve.
        """
        wanted = inside(angle, (0.0, self.angle))
        last = len(self._edges) - 2
        piece = np.clip(np.searchsorted(self._angles, wanted, side="right") - 1, 0, last)
        start, rest = self._edges[piece], wanted - self._angles[piece]
        low, high = start.copy(), self._edges[piece + 1].copy()
        whole = self._angles[piece + 1] - self._angles[piece]
        u = low + (high - low) * np.clip(rest / np.where(whole > 0.0, whole, 1.0), 0.0, 1.0)
        # Newton's method, and halving where it leaves what is known to hold the answer
        for _ in range(_STEPS):
            miss = self._quadrature(start, u) - rest
            low, high = np.where(miss <= 0.0, u, low), np.where(miss >= 0.0, u, high)
            speed = np.linalg.norm(self.curve.at(u).omega, axis=1)
            step = miss / np.where(speed > 0.0, speed, 1.0)
            new = np.where(speed > 0.0, u - step, low)
            new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
            done = np.abs(new - u) <= 2.0 * np.spacing(np.abs(u))
            u = new
            if done.all():
                break
        return u

    def _quadrature(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        """Give the angles travelled on stretches, each by one rule of Gauss."""
        half = 0.5 * (ends - starts)
        at = (0.5 * (starts + ends))[:, None] + half[:, None] * _NODES
        omega = self.curve.at(np.clip(at, *self.curve.domain).ravel()).omega
        speeds = np.linalg.norm(omega, axis=1).reshape(at.shape)
        angles: FloatArray = half * (speeds @ _WEIGHTS)
        return angles


@dataclass(frozen=True, slots=True, eq=False)
class EvenTurn:
    """A curve run through at a constant angular speed: its parameter is the angle travelled."""

    length: TurnLength
    """The curve and the angle it travels."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter, rad."""
        return 0.0, self.length.angle

    @property
    def breaks(self) -> FloatArray:
        """The breaks of the curve, as angles travelled, rad."""
        return np.unique(self.length.at(self.length.curve.breaks))

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities of length 1, and accelerations.

        Args:
            u: Angles travelled, shape (m,), rad.

        Raises:
            CurveError: If one lies outside the domain, or the curve rests there.
        """
        angles = inside(u, self.domain)
        turning = self.length.curve.at(self.length.parameter(angles))
        speed = np.linalg.norm(turning.omega, axis=1, keepdims=True)
        resting = speed[:, 0] <= 0.0
        if resting.any():
            where = float(angles[int(np.argmax(resting))])
            raise CurveError(f"rests at {where:.6g} rad and has no direction there", "orientation")
        # of alpha du^2 + omega d2u the part along omega vanishes, so that the speed stays
        omega = turning.omega / speed
        along = np.sum(turning.alpha * omega, axis=1, keepdims=True)
        return Turning(turning.quat, omega, (turning.alpha - along * omega) / speed**2)
