"""Homogeneous transforms of space: 4x4 matrices on column vectors.

Functions on bare arrays; they refuse only what has no answer. Angles in rad, lengths in m,
rotations anticlockwise seen from the tip of their axis.
"""

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from .affine import about as about_point
from .affine import apply as apply
from .affine import apply_to_directions as apply_to_directions
from .affine import concatenate as concatenate
from .affine import from_parts as from_parts
from .affine import inverse as inverse
from .affine import measure_factor, unit

RIGID_TOLERANCE = 1e-6
"""How far from orthonormal a rotation may be written down and still be meant as one."""

_ROUNDING = 1e-13


def translation(offset: ArrayInput) -> FloatArray:
    """Give the 4x4 transform that moves by ``offset``, shape (3,), m."""
    return from_parts(np.eye(3), offset)


def scaling(factors: ArrayInput, about: ArrayInput = (0.0, 0.0, 0.0)) -> FloatArray:
    """Give the 4x4 transform that scales along x, y, z and leaves a point where it is.

    Args:
        factors: One for each axis, shape (3,), or one number for all.
        about: The point that stays, shape (3,), m.
    """
    return about_point(np.diag(np.broadcast_to(np.asarray(factors, dtype=np.float64), 3)), about)


def rotation_x(angle: float) -> FloatArray:
    """Give the 4x4 rotation about the x axis by ``angle``, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        [[1.0, 0.0, 0.0, 0.0], [0.0, c, -s, 0.0], [0.0, s, c, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )


def rotation_y(angle: float) -> FloatArray:
    """Give the 4x4 rotation about the y axis by ``angle``, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        [[c, 0.0, s, 0.0], [0.0, 1.0, 0.0, 0.0], [-s, 0.0, c, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )


def rotation_z(angle: float) -> FloatArray:
    """Give the 4x4 rotation about the z axis by ``angle``, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )


def rotation(axis: ArrayInput, angle: float, about: ArrayInput = (0.0, 0.0, 0.0)) -> FloatArray:
    """Give the 4x4 rotation about any line.

    Args:
        axis: Direction of the line, shape (3,), of any length but zero.
        angle: rad.
        about: A point of the line, shape (3,), m.

    Raises:
        ValueError: If the axis has no length.
    """
    u = unit(axis, "axis")
    c, s = np.cos(angle), np.sin(angle)
    cross = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
    # Rodrigues' formula, Siciliano et al., Robotics, 2009, eq. 2.25
    return about_point(c * np.eye(3) + s * cross + (1.0 - c) * np.outer(u, u), about)


def reflection(plane: ArrayInput) -> FloatArray:
    """Give the 4x4 reflection in the plane A x + B y + C z + D = 0, shape (4,): A, B, C, D.

    The coordinate planes are (1, 0, 0, 0), (0, 1, 0, 0) and (0, 0, 1, 0).

    Raises:
        ValueError: If A, B and C are all zero.
    """
    A, B, C, D = np.asarray(plane, dtype=np.float64)
    normal = np.array([A, B, C])
    square = float(normal @ normal)
    if square == 0.0:
        raise ValueError(f"plane: want a normal (A, B, C) of some length, got {plane!r}")
    mirror = np.eye(3) - (2.0 / square) * np.outer(normal, normal)
    return from_parts(mirror, (-2.0 * D / square) * normal)


def shear(
    direction: ArrayInput,
    normal: ArrayInput,
    factor: float,
    about: ArrayInput = (0.0, 0.0, 0.0),
) -> FloatArray:
    """Give the 4x4 shear that moves points along ``direction`` by factor times their height.

    Args:
        direction: Where points move, shape (3,), at right angles to ``normal``.
        normal: Of the plane that stays, shape (3,); heights are counted along it.
        factor: Way per height.
        about: A point of the plane that stays, shape (3,), m.

    Raises:
        ValueError: If a vector has no length or the two are not at right angles.
    """
    along, up = unit(direction, "direction"), unit(normal, "normal")
    if abs(along @ up) > RIGID_TOLERANCE:
        raise ValueError(
            f"direction: want it at right angles to the normal {normal!r}, got {direction!r}"
        )
    return about_point(np.eye(3) + factor * np.outer(along, up), about)


def rigid_inverse(T: FloatArray) -> FloatArray:
    """Give the inverse of rigid transforms, shape (..., 4, 4), exactly: R^T and -R^T p."""
    R_inverse = np.swapaxes(T[..., :3, :3], -1, -2)
    inverted = np.zeros_like(T)
    inverted[..., :3, :3] = R_inverse
    inverted[..., :3, 3] = -(R_inverse @ T[..., :3, 3, None])[..., 0]
    inverted[..., 3, 3] = 1.0
    return inverted


def volume_factor(T: FloatArray) -> float:
    """Give by what an affine transform multiplies volumes; below zero: it mirrors."""
    return measure_factor(T)


def frozen_rigid(values: ArrayInput, name: str) -> FloatArray:
    """Give a read-only copy of a rigid transform after checking that it is one.

    A rotation written down with few digits (off by up to ``RIGID_TOLERANCE``) becomes the nearest
    exact one.

    Args:
        values: Shape (4, 4): a rotation without mirroring, a position in m, last row 0 0 0 1.
        name: What the transform is called in the error.

    Raises:
        ValueError: If it is not of that shape, not finite, or not rigid.
    """
    T = frozen_array(values, (4, 4), name)
    if not np.array_equal(T[3], (0.0, 0.0, 0.0, 1.0)):
        raise ValueError(f"{name}: want 0 0 0 1 as last row, got {T[3].tolist()}")
    R = T[:3, :3]
    error = float(np.abs(R.T @ R - np.eye(3)).max())
    if error > RIGID_TOLERANCE or np.linalg.det(R) < 0.0:
        raise ValueError(
            f"{name}: want a rotation (R^T R = 1, det R = 1) in the upper left, got {R.tolist()}"
        )
    if error <= _ROUNDING:
        return T
    # nearest rotation: polar factor of R, Higham, Functions of Matrices, 2008, section 8.1
    u, _, vt = np.linalg.svd(R)
    exact = T.copy()
    exact[:3, :3] = u @ vt
    return frozen_array(exact, (4, 4), name)
