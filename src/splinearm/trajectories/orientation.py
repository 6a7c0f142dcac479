"""Orientation curves through given orientations, with exact angular velocity and acceleration.

None depends on the frame in which the orientations are written; all are C2.
"""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.corner import ramp
from splinearm.kinematics import quaternion

from . import rotation_spline
from .turning import OrientationCurve as OrientationCurve
from .turning import Turning, equal_signs, inside

_SAME = 1e-15
"""Quaternions nearer than this are equal."""


def interpolate_orientations(
    u: ArrayInput, quats: ArrayInput, *, closed: bool = False
) -> OrientationCurve:
    """Give the C2 orientation curve through orientations at their parameters.

    Between neighbours it takes the shorter way. Open curves begin and end without angular
    acceleration. One orientation, or equal ones, give a constant; two are an even turn.

    Args:
        u: Parameters, rising, shape (m,), of a closed curve (m + 1,).
        quats: Orientations, unit quaternions w x y z of either sign, shape (m, 4).
        closed: Whether the curve returns to the first orientation as smoothly as it passes it.

    Raises:
        ValueError: If numbers, order or lengths do not fit.
    """
    given = frozen_array(quats, (None, 4), "quats")
    if given.size == 0 or (np.abs(np.linalg.norm(given, axis=1) - 1.0) > 1e-6).any():
        raise ValueError(f"quats: want unit quaternions w x y z, got {given.tolist()}")
    parameters = frozen_array(u, (len(given) + closed,), "u")
    if (np.diff(parameters) <= 0.0).any():
        raise ValueError(f"u: want rising parameters, got {parameters.tolist()}")
    given = equal_signs(quaternion.normalize(given))
    if np.abs(given - given[0]).max() <= _SAME:
        return ConstantOrientation(given[0], (float(parameters[0]), float(parameters[-1])))
    if len(given) == 2 and not closed:
        return RotationPolyline(parameters, given, np.zeros(2))
    return rotation_spline.fit(parameters, given, closed=closed)


@dataclass(frozen=True, slots=True, eq=False)
class ConstantOrientation:
    """One orientation for all parameters."""

    quat: FloatArray
    """Unit quaternion, shape (4,)."""
    domain: tuple[float, float]
    """First and last parameter."""

    @property
    def breaks(self) -> FloatArray:
        """The ends of the domain."""
        return np.unique(self.domain)

    def at(self, u: ArrayInput) -> Turning:
        """Give the orientation, and zero rates, at parameters, shape (m,).

        Raises:
            CurveError: If one lies outside the domain.
        """
        u = inside(u, self.domain)
        still = np.zeros((u.size, 3))
        return Turning(np.tile(self.quat, (u.size, 1)), still, still.copy())


@dataclass(frozen=True, slots=True, eq=False)
class RotationPolyline:
    """Even turns from orientation to orientation, with rounded corners between them."""

    u: FloatArray
    """Parameters of the orientations, rising, shape (k + 1,)."""
    quats: FloatArray
    """The orientations, unit quaternions, shape (k + 1, 4)."""
    half_widths: FloatArray
    """How far before and behind a corner it is rounded, shape (k + 1,), 0 at the ends."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.u[0]), float(self.u[-1])

    @property
    def breaks(self) -> FloatArray:
        """Where rounding begins and ends, and the ends of the domain."""
        return np.unique(np.concatenate((self.u - self.half_widths, self.u + self.half_widths)))

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations.

        Args:
            u: Parameters in the domain, shape (m,).

        Raises:
            CurveError: If one lies outside.
        """
        u = inside(u, self.domain)
        quats = equal_signs(self.quats)
        turns = quaternion.log(quaternion.multiply(quaternion.conjugate(quats[:-1]), quats[1:]))
        rates = turns / np.diff(self.u)[:, None]
        rates = np.concatenate((rates[:1], rates, rates[-1:]))
        # each parameter belongs to one corner; they meet in the even parts between them
        begin, end = self.u - self.half_widths, self.u + self.half_widths
        corner = np.searchsorted(0.5 * (end[:-1] + begin[1:]), u, side="right")
        x = u - self.u[corner]
        value, slope, bend = (order[:, None] for order in ramp(x, self.half_widths[corner]))
        before, behind = rates[corner], rates[corner + 1]
        first = quaternion.exp((x[:, None] - value) * before)
        last = quaternion.exp(value * behind)
        # rates in the body: the last factor turns those of the first, and drags them along
        back = quaternion.conjugate(last)
        early = quaternion.rotate(back, (1.0 - slope) * before)
        omega = early + slope * behind
        alpha = quaternion.rotate(back, -bend * before) + bend * behind
        alpha += np.cross(early, slope * behind)
        quat = quaternion.multiply(quaternion.multiply(quats[corner], first), last)
        quat = quaternion.normalize(quat)
        return Turning(quat, quaternion.rotate(quat, omega), quaternion.rotate(quat, alpha))
