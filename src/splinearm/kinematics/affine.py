"""What affine transforms of the plane (3x3) and of space (4x4) have in common.

Homogeneous matrices on column vectors with 0 ... 0 1 as last row; bare arrays.
"""

from functools import reduce

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray


def from_parts(linear: ArrayInput, offset: ArrayInput) -> FloatArray:
    """Give the transform ``p -> linear p + offset``.

    Args:
        linear: Shape (d, d).
        offset: Shape (d,), m.
    """
    offset = np.asarray(offset, dtype=np.float64)
    T = np.eye(len(offset) + 1)
    T[:-1, :-1] = linear
    T[:-1, -1] = offset
    return T


def about(linear: FloatArray, point: ArrayInput) -> FloatArray:
    """Give the transform with a linear part (d, d) that leaves a point (d,) where it is."""
    point = np.asarray(point, dtype=np.float64)
    return from_parts(linear, point - linear @ point)


def concatenate(first: FloatArray, *then: FloatArray) -> FloatArray:
    """Give the one transform that carries out the given ones in the order named."""
    return reduce(lambda done, following: following @ done, then, first)


def inverse(T: FloatArray) -> FloatArray:
    """Give the inverse of transforms, shape (..., d + 1, d + 1).

    Raises:
        ValueError: If one flattens its space, so that there is no way back.
    """
    try:
        linear = np.linalg.inv(T[..., :-1, :-1])
    except np.linalg.LinAlgError as error:
        raise ValueError(f"want a transform that flattens nothing, got {T.tolist()}") from error
    inverted = np.zeros_like(T)
    inverted[..., :-1, :-1] = linear
    inverted[..., :-1, -1] = -(linear @ T[..., :-1, -1, None])[..., 0]
    inverted[..., -1, -1] = 1.0
    return inverted


def apply(T: FloatArray, points: ArrayInput) -> FloatArray:
    """Give the images of points, shape (..., d), m, under one transform."""
    return apply_to_directions(T, points) + T[:-1, -1]


def apply_to_directions(T: FloatArray, directions: ArrayInput) -> FloatArray:
    """Give the images of directions, shape (..., d), which no translation moves."""
    images: FloatArray = np.asarray(directions, dtype=np.float64) @ T[:-1, :-1].T
    return images


def measure_factor(T: FloatArray) -> float:
    """Give by what a transform multiplies areas (volumes in space); below zero: it mirrors."""
    return float(np.linalg.det(T[:-1, :-1]))


def unit(vector: ArrayInput, name: str) -> FloatArray:
    """Give the direction of a vector as a vector of length 1.

    Raises:
        ValueError: If it has no length; ``name`` is what the error calls it.
    """
    vector = np.asarray(vector, dtype=np.float64)
    length = np.linalg.norm(vector)
    if not length > 0.0:
        raise ValueError(f"{name}: want a vector of some length, got {vector.tolist()}")
    direction: FloatArray = vector / length
    return direction
