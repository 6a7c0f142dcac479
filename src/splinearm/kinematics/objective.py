"""What a redundant arm may do with the freedom that a target leaves it."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from splinearm.arrays import FloatArray, frozen_array

from . import chain, solver
from .arm import Arm
from .differential import hessian_of

_GONE = 1e-12
"""Singular values below this count as this."""


class Objective(Protocol):
    """What is to be small, with its slopes."""

    def cost(self, arm: Arm, q: FloatArray) -> float:
        """Give what is to be small at joint positions q, shape (n,)."""
        ...

    def gradient(self, arm: Arm, q: FloatArray) -> FloatArray:
        """Give its slopes, shape (n,)."""
        ...


@dataclass(frozen=True, slots=True)
class AwayFromLimits:
    """Joints in the middle of their limits: the mean square of their share of the way to them."""

    # Liegeois, Automatic supervisory control of the configuration and behavior of multibody
    # mechanisms, IEEE Trans. SMC 7 (1977) 868, eq. 19

    def cost(self, arm: Arm, q: FloatArray) -> float:
        """Give the mean square of the joints' shares of the way to their limits; 1: all there."""
        middle, half = _middle_and_half(arm)
        return float(np.mean(((q - middle) / half) ** 2))

    def gradient(self, arm: Arm, q: FloatArray) -> FloatArray:
        """Give its slopes, shape (n,)."""
        middle, half = _middle_and_half(arm)
        slopes: FloatArray = 2.0 / len(q) * (q - middle) / half**2
        return slopes


@dataclass(frozen=True, slots=True, eq=False)
class NearPosture:
    """Joints near given ones: the sum of squares of what they are off, lengths of the arm as 1."""

    q: FloatArray
    """The posture, shape (n,), rad or m."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen_array(self.q, (None,), "q"))

    def cost(self, arm: Arm, q: FloatArray) -> float:
        """Give the sum of squares of what joints are off."""
        return float(np.sum(((q - self._posture(arm)) / solver.model_of(arm).bounds[2]) ** 2))

    def gradient(self, arm: Arm, q: FloatArray) -> FloatArray:
        """Give its slopes, shape (n,)."""
        slopes: FloatArray = 2.0 * (q - self._posture(arm)) / solver.model_of(arm).bounds[2] ** 2
        return slopes

    def _posture(self, arm: Arm) -> FloatArray:
        if len(self.q) != arm.n:
            raise ValueError(f"q: want a posture of {arm.n} joints, got {len(self.q)}")
        return self.q


@dataclass(frozen=True, slots=True)
class Manipulability:
    """The tool movable in all ways: minus the logarithm of the volume of its velocities."""

    # Yoshikawa, Manipulability of robotic mechanisms, Int. J. Robotics Research 4 (1985) 3
    position_only: bool = field(default=False, kw_only=True)
    """Whether only velocities count, not turns."""

    def cost(self, arm: Arm, q: FloatArray) -> float:
        """Give minus the logarithm of the product of the Jacobian's singular values.

        Lengths count in the length of the arm that stands for a radian in searches.
        """
        model = solver.model_of(arm)
        J = chain.fk_and_jacobian(arm.packed, q)[1] * model.weights * model.bounds[2]
        values = np.linalg.svd(J[:3] if self.position_only else J, compute_uv=False)
        return -float(np.log(np.maximum(values, _GONE)).sum())

    def gradient(self, arm: Arm, q: FloatArray) -> FloatArray:
        """Give its slopes, shape (n,)."""
        # the slope of a singular value is u' dJ v, and of the sum of logarithms that over the value
        model = solver.model_of(arm)
        units, rows = model.bounds[2], slice(0, 3 if self.position_only else 6)
        weights = model.weights[rows]
        J = chain.fk_and_jacobian(arm.packed, q)[1]
        U, values, Vt = np.linalg.svd(J[rows] * weights * units, full_matrices=False)
        changes = hessian_of(J)[:, rows] * weights * units
        parts = np.einsum("rk,jrc,kc->jk", U, changes, Vt)
        slopes: FloatArray = -(parts / np.maximum(values, _GONE)).sum(axis=1)
        return slopes


def _middle_and_half(arm: Arm) -> tuple[FloatArray, FloatArray]:
    """Give middle and half width of the limits; a joint without limits counts nothing."""
    lower, upper = arm.limits.q_min, arm.limits.q_max
    half = 0.5 * (upper - lower)
    return solver.model_of(arm).middle, np.where(half > 0.0, half, 1.0)
