"""How near an arm is to losing a direction, which one, and which joints bring it about."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from .arm import Arm
from .differential import hessian

_ALIKE = 1.5
"""Singular values within this factor of the smallest, or below `_GONE`, are lost together."""
_GONE = 1e-6
_TAKES_PART = 0.3
"""Share of the largest part from which on a joint counts as taking part."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Singularity:
    """The singularity that a posture is nearest to. Lengths count in reaches of the arm."""

    nearness: float
    """Smallest singular value of the Jacobian; 0: the arm is singular there."""
    direction: FloatArray
    """The motion of the tool that needs the fastest joints, or is lost: linear velocity in
    reaches, angular velocity, in base, shape (6,), length 1."""
    causes: tuple[str, ...]
    """The joints whose positions bring it about: moving them leads away from it."""
    opposed: tuple[str, ...]
    """The joints that work against each other: moved together they hardly move the tool."""

    def __str__(self) -> str:
        return (
            f"smallest singular value {self.nearness:.3g}: {', '.join(self.opposed)} nearly undo "
            f"each other, because of the position of {', '.join(self.causes) or 'no joint'}"
        )


def reach(arm: Arm) -> float:
    """Give the sum of the distances from joint to joint to tool, m: no point is farther away."""
    lengths = np.linalg.norm(arm.packed.fixed[1:, :3, 3], axis=1)
    return float(lengths.sum())


def nearest_singularity(arm: Arm, q: ArrayInput) -> Singularity:
    """Say how near a posture is to a singularity and why.

    For an arm of fewer than six joints it is singular where its joints no longer move the tool
    independently; for one of more, where the tool loses a direction.

    Args:
        arm: The arm.
        q: Joint positions, shape (n,), rad (m where a joint slides).

    Raises:
        ValueError: If ``q`` is not of that shape or a number is not finite.
    """
    q = arm.joint_array(q)
    if q.ndim != 1:
        raise ValueError(f"q: want shape ({arm.n},), got {q.shape}")
    size = reach(arm) or 1.0
    # comparable numbers: lengths in reaches, so that a slide of one reach counts as a turn of 1 rad
    rows = np.array([1.0 / size] * 3 + [1.0] * 3)[:, None]
    columns = np.where(arm.packed.turns == 1.0, 1.0, size)
    U, sigma, Vt = np.linalg.svd(rows * arm.jacobian(q) * columns)
    lost = np.flatnonzero(sigma <= max(_ALIKE * sigma[-1], _GONE))
    # of fewer than six joints the directions beyond the n-th are never there, of more than six the
    # self-motions beyond the sixth always are: a way out may lead through either
    left = U[:, [*lost, *range(len(sigma), 6)]]
    right = Vt[[*lost, *range(len(sigma), arm.n)]].T
    changes = rows * hessian(arm, q) * columns * columns[:, None, None]
    parts = np.linalg.norm(np.einsum("ra,jrc,cb->jab", left, changes, right), axis=(1, 2))
    return Singularity(
        nearness=float(sigma[-1]),
        direction=U[:, len(sigma) - 1],
        causes=_taking_part(arm, parts),
        opposed=_taking_part(arm, np.linalg.norm(Vt[lost], axis=0)),
    )


def _taking_part(arm: Arm, parts: FloatArray) -> tuple[str, ...]:
    least = max(_TAKES_PART * float(parts.max()), 1e-9)
    return tuple(name for name, part in zip(arm.joint_names, parts, strict=True) if part >= least)
