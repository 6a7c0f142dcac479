"""What a tool path asks of an arm, in numbers of one kind: bare arrays.

Misses of position (m) and orientation (rad) stand in one vector; a turn counts as the way of a
point 0.1 m from the tool. Where the orientation is free there are three rows, otherwise six.
"""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics import quaternion
from splinearm.kinematics.arm import Arm

from .path import TURN_ARM, ToolState

_RANK = 1e-9
"""Directions of the tool below this share of the best one count as lost."""

_SOUND = 1e5
"""A product of the norms of a matrix and its inverse up to which the inverse is good."""

_STEP = 1e-5
"""Change of the joints, rad, by which the change of the Jacobian is measured."""

_SWEEPS = 12

_SLOW = 0.02
"""A step that leaves more than this share of a miss asks for a new inverse."""

_EPS = float(np.finfo(np.float64).eps)


class Corrected(NamedTuple):
    """Joint positions moved onto a tool path."""

    q: FloatArray
    """Shape (m, n)."""
    position_error: FloatArray
    """What is left of the miss, shape (m,), m."""
    orientation_error: FloatArray
    """The same, rad; 0 where the orientation is free."""


def misses(arm: Arm, q: FloatArray, wanted: ToolState) -> FloatArray:
    """Give the weighted misses of the tool, shape (m, 3) or (m, 6)."""
    T = arm.fk(q)
    off = wanted.p - T[:, :3, 3]
    if wanted.quat is None:
        return off
    return np.hstack((off, TURN_ARM * _turns(T[:, :3, :3], wanted.quat)))


def errors(miss: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give position errors, m, and orientation errors, rad, of weighted misses, each (m,)."""
    turn = np.linalg.norm(miss[:, 3:], axis=1) / TURN_ARM
    return np.linalg.norm(miss[:, :3], axis=1), turn


def correct(arm: Arm, q: FloatArray, wanted: ToolState) -> Corrected:
    """Move joint positions, shape (m, n), by Newton's method to where the tool is as wanted."""
    rows = wanted.slope.shape[1]
    miss = misses(arm, q, wanted)
    size = np.abs(miss).max(axis=1)
    rounding = _EPS * np.abs(wanted.p).max(axis=1)
    inverse = None
    for _ in range(_SWEEPS):
        if not (size > rounding).any():
            break
        fresh = inverse is None
        if inverse is None:
            inverse = _inverse(jacobian(arm, q, rows))
        tried = q + np.einsum("mij,mj->mi", inverse, miss)
        new = misses(arm, tried, wanted)
        new_size = np.abs(new).max(axis=1)
        better = new_size < size
        gained = (size - new_size > 1e-3 * size)[better]
        # an inverse is good for more than one step as long as these shrink the miss fast
        slow = bool(((new_size > _SLOW * size) & (size > rounding)).any())
        q = np.where(better[:, None], tried, q)
        miss = np.where(better[:, None], new, miss)
        size = np.where(better, new_size, size)
        if fresh and not gained.any():
            break
        if slow:
            inverse = None
    return Corrected(q, *errors(miss))


def slopes(arm: Arm, q: FloatArray, wanted: ToolState) -> FloatArray:
    """Give the joints' first derivative by s, shape (m, n): of all the one of least length."""
    inverse = _inverse(jacobian(arm, q, wanted.slope.shape[1]))
    slope: FloatArray = np.einsum("mij,mj->mi", inverse, _weigh(wanted.slope))
    return slope


def slopes_and_bends(arm: Arm, q: FloatArray, wanted: ToolState) -> tuple[FloatArray, FloatArray]:
    """Give the joints' first two derivatives by s, each of shape (m, n)."""
    rows = wanted.slope.shape[1]
    J = jacobian(arm, q, rows)
    inverse = _inverse(J)
    slope = np.einsum("mij,mj->mi", inverse, _weigh(wanted.slope))
    step = _STEP / np.maximum(np.abs(slope).max(axis=1), 1e-300)[:, None]
    ahead, behind = jacobian(arm, q + step * slope, rows), jacobian(arm, q - step * slope, rows)
    change = (ahead - behind) / (2.0 * step[:, :, None])
    rest = _weigh(wanted.bend) - np.einsum("mij,mj->mi", change, slope)
    bend = np.einsum("mij,mj->mi", inverse, rest)
    # where joints are left over, the derivative of the pseudoinverse itself (Golub and Pereyra,
    # SIAM J. Numer. Anal. 10 (1973) 413, eq. 4.12, for a slope in its row space)
    pulled = np.einsum("mji,mj->mi", change, np.einsum("mji,mj->mi", inverse, slope))
    spare = pulled - np.einsum("mij,mj->mi", inverse, np.einsum("mij,mj->mi", J, pulled))
    return slope, bend + spare


def jacobian(arm: Arm, q: FloatArray, rows: int) -> FloatArray:
    """Give the weighted Jacobian, shape (m, 3, n) or (m, 6, n)."""
    J = arm.jacobian(q)[:, :rows]
    J[:, 3:] *= TURN_ARM
    return J


def _turns(R: FloatArray, quat: FloatArray) -> FloatArray:
    """Give the rotation vectors, shape (m, 3), that lead from rotations to wanted orientations."""
    between = quaternion.to_matrix(quat) @ R.mT
    cos = 0.5 * (between[:, 0, 0] + between[:, 1, 1] + between[:, 2, 2] - 1.0)
    if (cos <= 0.0).any():
        return quaternion.log(quaternion.from_matrix(between))
    # below a right angle: the odd part of the rotation is the axis by the sine, exact near zero
    turn = 0.5 * np.stack(
        (
            between[:, 2, 1] - between[:, 1, 2],
            between[:, 0, 2] - between[:, 2, 0],
            between[:, 1, 0] - between[:, 0, 1],
        ),
        axis=1,
    )
    sin = np.sqrt(np.sum(turn * turn, axis=1))
    scale = np.arctan2(sin, cos) / np.where(sin > 0.0, sin, 1.0)
    return turn * np.where(sin > 0.0, scale, 1.0)[:, None]


def _inverse(J: FloatArray) -> FloatArray:
    """Give the inverses, shape (m, n, rows), of least length where joints are left over."""
    if J.shape[1] == J.shape[2]:
        inverse = _plain_inverse(J)
        if inverse is not None:
            return inverse
    U, size, Vt = np.linalg.svd(J, full_matrices=False)
    kept = size > _RANK * size[:, :1]
    shares = np.where(kept, 1.0, 0.0) / np.where(kept, size, 1.0)
    shortest: FloatArray = (Vt.mT * shares[:, None]) @ U.mT
    return shortest


def _plain_inverse(J: FloatArray) -> FloatArray | None:
    """Give the inverses of square matrices, None if one of them is near to having none."""
    try:
        inverse = np.asarray(np.linalg.inv(J), dtype=np.float64)
    except np.linalg.LinAlgError:
        return None
    square = (J * J).sum(axis=(1, 2)) * (inverse * inverse).sum(axis=(1, 2))
    return inverse if float(square.max()) < _SOUND * _SOUND else None


def _weigh(rates: FloatArray) -> FloatArray:
    if rates.shape[1] == 3:
        return rates
    weighed = rates.copy()
    weighed[:, 3:] *= TURN_ARM
    return weighed
