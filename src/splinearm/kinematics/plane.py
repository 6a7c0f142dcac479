"""Homogeneous transforms of the plane: 3x3 matrices on column vectors.

Functions on bare arrays; they refuse only what has no answer. Angles in rad, anticlockwise;
lengths in m. Matrices that a book writes for row vectors are the transposes of these.
"""

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from .affine import about as about_point
from .affine import apply as apply
from .affine import apply_to_directions as apply_to_directions
from .affine import concatenate as concatenate
from .affine import from_parts as from_parts
from .affine import inverse as inverse
from .affine import measure_factor, unit

ORIGIN = (0.0, 0.0)


def translation(offset: ArrayInput) -> FloatArray:
    """Give the 3x3 transform that moves by ``offset``, shape (2,), m."""
    return from_parts(np.eye(2), offset)


def scaling(factors: ArrayInput, about: ArrayInput = ORIGIN) -> FloatArray:
    """Give the 3x3 transform that scales along x and y and leaves a point where it is.

    Args:
        factors: One for each axis, shape (2,), or one number for both.
        about: The point that stays, shape (2,), m.
    """
    return about_point(np.diag(np.broadcast_to(np.asarray(factors, dtype=np.float64), 2)), about)


def rotation(angle: float, about: ArrayInput = ORIGIN) -> FloatArray:
    """Give the 3x3 rotation by ``angle``, rad, about a point, shape (2,), m."""
    c, s = np.cos(angle), np.sin(angle)
    return about_point(np.array([[c, -s], [s, c]]), about)


def reflection_in_x_axis() -> FloatArray:
    """Give the 3x3 reflection that turns y round."""
    return np.diag((1.0, -1.0, 1.0))


def reflection_in_y_axis() -> FloatArray:
    """Give the 3x3 reflection that turns x round."""
    return np.diag((-1.0, 1.0, 1.0))


def reflection(line: ArrayInput) -> FloatArray:
    """Give the 3x3 reflection in the line A x + B y + C = 0, shape (3,): A, B, C.

    Raises:
        ValueError: If A and B are both zero.
    """
    A, B, C = np.asarray(line, dtype=np.float64)
    normal = np.array([A, B])
    square = float(normal @ normal)
    if square == 0.0:
        raise ValueError(f"line: want a normal (A, B) of some length, got {line!r}")
    mirror = np.eye(2) - (2.0 / square) * np.outer(normal, normal)
    return from_parts(mirror, (-2.0 * C / square) * normal)


def shear_along_x(factor: float) -> FloatArray:
    """Give the 3x3 shear (x, y) -> (x + factor y, y)."""
    return from_parts([[1.0, factor], [0.0, 1.0]], ORIGIN)


def shear_along_y(factor: float) -> FloatArray:
    """Give the 3x3 shear (x, y) -> (x, y + factor x)."""
    return from_parts([[1.0, 0.0], [factor, 1.0]], ORIGIN)


def shear(direction: ArrayInput, factor: float, about: ArrayInput = ORIGIN) -> FloatArray:
    """Give the 3x3 shear that moves points along a direction by factor times their height.

    Height is counted from the line through ``about`` along the direction, to its left. Along x
    this is ``shear_along_x(factor)``; along y, with x to the right, ``shear_along_y(-factor)``.

    Args:
        direction: Where points move, shape (2,), of any length but zero.
        factor: Way per height.
        about: A point of the line that stays, shape (2,), m.

    Raises:
        ValueError: If the direction has no length.
    """
    x, y = unit(direction, "direction")
    return about_point(np.eye(2) + factor * np.outer((x, y), (-y, x)), about)


def area_factor(T: FloatArray) -> float:
    """Give by what an affine transform multiplies areas; below zero: it mirrors."""
    return measure_factor(T)
