"""Orientation curves through given orientations, with exact angular velocity and acceleration.

None depends on the frame in which the orientations are written.
"""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.kinematics import quaternion

from . import rotation_interpolation
from .rotation_polyline import RotationPolyline as RotationPolyline
from .turning import OrientationCurve as OrientationCurve
from .turning import Turning, checked_quats, equal_signs, inside

_SAME = 1e-15
"""Quaternions nearer than this are equal."""


def interpolate_orientations(
    u: ArrayInput,
    quats: ArrayInput,
    *,
    closed: bool = False,
    degree: int = 3,
    omega_start: ArrayInput | None = None,
    omega_end: ArrayInput | None = None,
) -> OrientationCurve:
    """Give the smooth orientation curve through orientations at their parameters.

    It is a cumulative B-spline (``RotationBSpline``), of degree 3 C2 and of degree 5 C4, with
    knots at the parameters. Between neighbours it takes the shorter way; half a turn apart there
    are two, and one of them is taken. Turns about one direction are the interpolating spline of
    the angle. Where no velocity is given, open cubic curves begin and end without angular
    acceleration; quintic ones are there as natural splines, up to products of rates. One
    orientation, or equal ones, give a constant; two are an even turn.

    Args:
        u: Parameters, rising, shape (m,), of a closed curve (m + 1,).
        quats: Orientations, unit quaternions w x y z of either sign, shape (m, 4).
        closed: Whether the curve returns to the first orientation as smoothly as it passes it.
        degree: 3, or 5 where jerk must not jump; that swings farther out between orientations,
            and is sometimes refused where neighbours are more than 2 rad apart.
        omega_start: Angular velocity at the start of an open curve, in the fixed frame, rad per
            unit of the parameter, shape (3,).
        omega_end: The same at its end.

    Raises:
        CurveError: If no such curve was found, as between long steps that hardly turn beside
            short ones that turn much.
        ValueError: If numbers, order or lengths do not fit.
    """
    given = equal_signs(checked_quats(quats))
    parameters = frozen_array(u, (len(given) + closed,), "u")
    if (np.diff(parameters) <= 0.0).any():
        raise ValueError(f"u: want rising parameters, got {parameters.tolist()}")
    if degree not in (3, 5):
        raise ValueError(f"degree: want 3 or 5, got {degree!r}")
    given_rates = omega_start is not None or omega_end is not None
    if given_rates and (closed or len(given) == 1):
        raise ValueError("omega_start, omega_end: a closed curve and one orientation have no ends")
    rates = rotation_interpolation.EndRates(
        _in_body(omega_start, given[0], "omega_start"), _in_body(omega_end, given[-1], "omega_end")
    )
    if not given_rates and np.abs(given - given[0]).max() <= _SAME:
        return ConstantOrientation(given[0], (float(parameters[0]), float(parameters[-1])))
    if not given_rates and len(given) == 2 and not closed:
        return RotationPolyline(parameters, given, np.zeros(2))
    return rotation_interpolation.fit(parameters, given, degree, closed=closed, rates=rates)


def _in_body(omega: ArrayInput | None, quat: FloatArray, name: str) -> FloatArray | None:
    if omega is None:
        return None
    return quaternion.rotate(quaternion.conjugate(quat), frozen_array(omega, (3,), name))


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

    def into(self, u: float, state: FloatArray) -> None:
        """Write the orientation, and zero rates, at one parameter, for tight loops.

        Arguments and errors are those of ``RotationBSpline.into``, but that any array will do.
        """
        inside(np.array([u]), self.domain)
        if state.shape != (10,):
            raise ValueError(f"state: want shape (10,), got {state.shape}")
        state[:4] = self.quat
        state[4:] = 0.0
