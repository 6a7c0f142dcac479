"""Rigid motions as a group: exponential, logarithm, adjoint and ways between two poses.

Bare functions on batches of 4x4 transforms that check nothing. A twist is linear first, then
angular, shape (..., 6): the motion along a screw by one unit of time, m and rad. Near no turn and
near a half turn the numbers are as exact as elsewhere.
"""

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from . import quaternion
from .space import rigid_inverse

_SMALL = 0.3
"""Below this angle, rad, differences of near numbers give way to their series."""


def exp(twist: ArrayInput) -> FloatArray:
    """Give the rigid transforms, shape (..., 4, 4), that twists, shape (..., 6), lead to."""
    # Lynch and Park, Modern Robotics, 2017, eq. 3.88
    twist = np.asarray(twist, dtype=np.float64)
    v, phi = twist[..., :3], twist[..., 3:]
    angle = np.linalg.norm(phi, axis=-1, keepdims=True)
    turned = np.cross(phi, v)
    T = np.zeros((*twist.shape[:-1], 4, 4))
    T[..., :3, :3] = quaternion.to_matrix(quaternion.exp(phi))
    # (1 - cos x) / x^2 without its difference; np.sinc(x) is sin(pi x) / (pi x)
    bend = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2
    T[..., :3, 3] = v + bend * turned + _lag(angle) * np.cross(phi, turned)
    T[..., 3, 3] = 1.0
    return T


def log(T: ArrayInput) -> FloatArray:
    """Give the twists, shape (..., 6), of the shortest turn that lead to transforms (..., 4, 4).

    A half turn has two: either may be given.
    """
    # Lynch and Park, Modern Robotics, 2017, eq. 3.92; the turn by way of its quaternion, which is
    # exact at every angle
    T = np.asarray(T, dtype=np.float64)
    phi = quaternion.log(quaternion.from_matrix(T[..., :3, :3]))
    p = T[..., :3, 3]
    angle = np.linalg.norm(phi, axis=-1, keepdims=True)
    turned = np.cross(phi, p)
    v = p - 0.5 * turned + _lead(angle) * np.cross(phi, turned)
    return np.concatenate((v, phi), axis=-1)


def adjoint(T: ArrayInput) -> FloatArray:
    """Give the matrices, shape (..., 6, 6), that write twists of frame b in frame a.

    Args:
        T: Poses of frame b in frame a, shape (..., 4, 4).
    """
    # Lynch and Park, Modern Robotics, 2017, def. 3.20, with the linear part first
    T = np.asarray(T, dtype=np.float64)
    R = T[..., :3, :3]
    matrix = np.zeros((*T.shape[:-2], 6, 6))
    matrix[..., :3, :3] = matrix[..., 3:, 3:] = R
    matrix[..., :3, 3:] = np.cross(T[..., None, :3, 3], np.swapaxes(R, -1, -2)).swapaxes(-1, -2)
    return matrix


def interpolate_screw(a: ArrayInput, b: ArrayInput, share: ArrayInput) -> FloatArray:
    """Give the pose at ``share`` (...) of the screw motion from a to b, shape (..., 4, 4).

    The frame turns about and slides along one line, evenly; its origin runs on a helix.
    """
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    share = np.asarray(share, dtype=np.float64)[..., None]
    return a @ exp(share * log(rigid_inverse(a) @ b))


def interpolate_apart(a: ArrayInput, b: ArrayInput, share: ArrayInput) -> FloatArray:
    """Give the pose at ``share`` (...) of the way from a to b, shape (..., 4, 4).

    The origin runs on the straight line and the frame turns evenly about one direction, each by
    itself.
    """
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    share = np.asarray(share, dtype=np.float64)
    quats = [quaternion.from_matrix(T[..., :3, :3]) for T in (a, b)]
    R = quaternion.to_matrix(quaternion.slerp(quats[0], quats[1], share))
    p = (1.0 - share)[..., None] * a[..., :3, 3] + share[..., None] * b[..., :3, 3]
    T = np.zeros((*R.shape[:-2], 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, p, 1.0
    return T


def _lag(angle: FloatArray) -> FloatArray:
    """Give (x - sin x) / x^3."""
    square = angle * angle
    series = _polynomial(square, (1 / 6, -1 / 120, 1 / 5040, -1 / 362880, 1 / 39916800))
    x = np.where(angle < _SMALL, 1.0, angle)
    return np.where(angle < _SMALL, series, (x - np.sin(x)) / x**3)


def _lead(angle: FloatArray) -> FloatArray:
    """Give (1 - (x/2) cot(x/2)) / x^2."""
    square = angle * angle
    series = _polynomial(
        square, (1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160, 691 / 1307674368000)
    )
    x = np.where(angle < _SMALL, 1.0, angle)
    return np.where(angle < _SMALL, series, (1.0 - 0.5 * x / np.tan(0.5 * x)) / x**2)


def _polynomial(x: FloatArray, coefficients: tuple[float, ...]) -> FloatArray:
    value = np.zeros_like(x)
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value
