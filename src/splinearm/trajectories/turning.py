"""What orientation curves give and share: orientations with their angular rates."""

from typing import NamedTuple, Protocol

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion


class Turning(NamedTuple):
    """Orientations and how they change with the parameter."""

    quat: FloatArray
    """Unit quaternions w x y z, shape (m, 4)."""
    omega: FloatArray
    """Angular velocity in the fixed frame, rad per unit of the parameter, shape (m, 3)."""
    alpha: FloatArray
    """Angular acceleration in the fixed frame, rad per unit squared, shape (m, 3)."""

    def in_body(self) -> tuple[FloatArray, FloatArray]:
        """Give angular velocity and acceleration written in the turning frame, each (m, 3)."""
        back = quaternion.conjugate(self.quat)
        return quaternion.rotate(back, self.omega), quaternion.rotate(back, self.alpha)


class SpaceJet(Protocol):
    """A curve in space, C2, with its derivatives."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        ...

    @property
    def breaks(self) -> FloatArray:
        """Where the curve is no more than C2, and the ends of the domain."""
        ...

    def at(self, u: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give places, or a derivative by the parameter, at parameters of shape (m,), (m, 3)."""
        ...


class OrientationCurve(Protocol):
    """An orientation for every parameter of a domain."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        ...

    @property
    def breaks(self) -> FloatArray:
        """Where the curve is no more than C2, and the ends of the domain."""
        ...

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations at parameters, shape (m,)."""
        ...


def checked_quats(quats: ArrayInput, name: str = "quats") -> FloatArray:
    """Give unit quaternions, shape (m, 4), after checking them; at least one.

    Raises:
        ValueError: If they are not of that shape or not of length 1 to 1e-6.
    """
    given = frozen_array(quats, (None, 4), name)
    if given.size == 0 or (np.abs(np.linalg.norm(given, axis=1) - 1.0) > 1e-6).any():
        raise ValueError(f"{name}: want unit quaternions w x y z, got {given.tolist()}")
    unit = quaternion.normalize(given)
    unit.flags.writeable = False
    return unit


def equal_signs(quats: FloatArray) -> FloatArray:
    """Give the same rotations, each quaternion on the side of the one before it."""
    dots = np.sum(quats[:-1] * quats[1:], axis=1)
    flips = np.concatenate(([1.0], np.cumprod(np.where(dots < 0.0, -1.0, 1.0))))
    return quats * flips[:, None]


def inside(u: ArrayInput, domain: tuple[float, float]) -> FloatArray:
    """Give parameters, shape (m,), as an array if they lie in the domain.

    Raises:
        CurveError: If one does not.
    """
    array = np.asarray(u, dtype=np.float64)
    outside = ~((array >= domain[0]) & (array <= domain[1]))
    if outside.any():
        where = float(array[int(np.argmax(outside))])
        raise CurveError(f"defined from {domain[0]} to {domain[1]}, not at {where}", "orientation")
    return array
