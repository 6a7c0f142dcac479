"""What a tool path asks of an arm, in numbers of one kind: bare arrays.

Misses of position (m) and orientation (rad) stand in one vector; a turn counts as the way of a
point 0.1 m from the tool. Where the orientation is free there are three rows, otherwise six.
"""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics import chain, quaternion
from splinearm.kinematics.arm import Arm

from .path import TURN_ARM, ToolState

_RANK = 1e-9
"""Directions of the tool below this share of the best one count as lost."""

_STEP = 1e-5
"""Change of the joints, rad, by which the change of the Jacobian is measured."""

_SWEEPS = 8


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
    T = chain.fk_batch(arm.packed, q)
    off = wanted.p - T[:, :3, 3]
    if wanted.quat is None:
        return off
    have = quaternion.from_matrix(T[:, :3, :3])
    turn = quaternion.log(quaternion.multiply(wanted.quat, quaternion.conjugate(have)))
    return np.hstack((off, TURN_ARM * turn))


def errors(miss: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give position errors, m, and orientation errors, rad, of weighted misses, each (m,)."""
    turn = np.linalg.norm(miss[:, 3:], axis=1) / TURN_ARM
    return np.linalg.norm(miss[:, :3], axis=1), turn


def correct(arm: Arm, q: FloatArray, wanted: ToolState) -> Corrected:
    """Move joint positions, shape (m, n), by Newton's method to where the tool is as wanted."""
    rows = wanted.slope.shape[1]
    miss = misses(arm, q, wanted)
    size = np.abs(miss).max(axis=1)
    for _ in range(_SWEEPS):
        if not (size > 0.0).any():
            break
        step = np.einsum("mij,mj->mi", _inverse(jacobian(arm, q, rows)), miss)
        tried = q + step
        new = misses(arm, tried, wanted)
        new_size = np.abs(new).max(axis=1)
        better = new_size < size
        if not better.any():
            break
        q = np.where(better[:, None], tried, q)
        miss = np.where(better[:, None], new, miss)
        gained = (size - new_size)[better] > 1e-3 * size[better]
        size = np.where(better, new_size, size)
        if not gained.any():
            break
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
    if len(q) == 1:
        J = chain.fk_and_jacobian(arm.packed, q[0])[1][None]
    else:
        J = chain.jacobian_batch(arm.packed, q)
    J = J[:, :rows]
    J[:, 3:] *= TURN_ARM
    return J


def _inverse(J: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.pinv(J, rcond=_RANK), dtype=np.float64)


def _weigh(rates: FloatArray) -> FloatArray:
    if rates.shape[1] == 3:
        return rates
    weighed = rates.copy()
    weighed[:, 3:] *= TURN_ARM
    return weighed
