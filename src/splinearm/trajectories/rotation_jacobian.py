"""What rotation vectors do to rotations: rates of their exponential, its Jacobian and the inverse.

Bare functions on batches that check nothing. Rates are written in the turning frame.
"""

import numpy as np

from splinearm.arrays import FloatArray


def body_rates(f: FloatArray, fd: FloatArray, fdd: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give angular velocity and acceleration of exp(f), each of shape (m, 3).

    Args:
        f: Rotation vectors, shape (m, 3), and
        fd: their first and
        fdd: second derivatives.
    """
    # omega = J f' with the right Jacobian J = I - a [f] + b [f]^2 of SO(3) (Chirikjian, Stochastic
    # Models, Information Theory, and Lie Groups 2, 2012, eq. 10.86); alpha is its derivative
    a, b, a_slope, b_slope = _jacobian_factors(np.sum(f * f, axis=1, keepdims=True))
    growth = np.sum(f * fd, axis=1, keepdims=True)
    c1, c2 = np.cross(f, fd), np.cross(f, fdd)
    d1, d2 = np.cross(f, c1), np.cross(f, c2)
    omega = fd - a * c1 + b * d1
    alpha = fdd - a * c2 + b * (d2 + np.cross(fd, c1)) + growth * (b_slope * d1 - a_slope * c1)
    return omega, alpha


def _jacobian_factors(
    square: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Give a, b and da/dx / x, db/dx / x at angles x, of whose squares they are functions."""
    small = square < 0.09
    x = np.sqrt(np.where(small, 1.0, square))
    sine, cosine = np.sin(x), np.cos(x)
    z = np.where(small, square, 0.0)
    powers = np.stack((np.ones_like(z), -z, z**2, -(z**3), z**4))
    # a = sum (-z)^k / (2 k + 2)!, b = sum (-z)^k / (2 k + 3)!
    a = np.tensordot(_SERIES[0], powers, 1)
    b = np.tensordot(_SERIES[1], powers, 1)
    a_slope = np.tensordot(_SERIES[2], powers, 1)
    b_slope = np.tensordot(_SERIES[3], powers, 1)
    return (
        np.where(small, a, (1.0 - cosine) / x**2),
        np.where(small, b, (x - sine) / x**3),
        np.where(small, a_slope, (x * sine - 2.0 * (1.0 - cosine)) / x**4),
        np.where(small, b_slope, (3.0 * sine - x * cosine - 2.0 * x) / x**5),
    )


def _series(first: int) -> tuple[list[float], list[float]]:
    """Give five terms of sum (-z)^k / (2 k + first)! and of twice its derivative by z."""
    terms = [1.0]
    for i in range(2, 2 * 5 + first + 1):
        terms.append(terms[-1] / i)
    factorials = [terms[2 * k + first - 1] for k in range(6)]
    return factorials[:5], [-2.0 * (k + 1) * factorials[k + 1] for k in range(5)]


_A, _A_SLOPE = _series(2)
_B, _B_SLOPE = _series(3)
_SERIES = np.array((_A, _B, _A_SLOPE, _B_SLOPE))


def jacobian(f: FloatArray) -> FloatArray:
    """Give the right Jacobian of SO(3), shape (m, 3, 3), at rotation vectors: omega = J f'."""
    a, b, _, _ = _jacobian_factors(np.sum(f * f, axis=1, keepdims=True))
    cross = cross_matrix(f)
    matrix: FloatArray = np.eye(3) - a[:, :, None] * cross + b[:, :, None] * (cross @ cross)
    return matrix


def inverse_jacobian(f: FloatArray) -> FloatArray:
    """Give the inverse of ``jacobian``, shape (m, 3, 3), at rotation vectors up to a half turn."""
    square = np.sum(f * f, axis=1)
    x = np.sqrt(square)
    # (1 - x/2 cot(x/2)) / x^2, at and near 0 by its series
    small = square < 1e-4
    safe = np.where(small, 1.0, x)
    c = np.where(
        small, 1.0 / 12.0 + square / 720.0, (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2
    )
    cross = cross_matrix(f)
    inverse: FloatArray = np.eye(3) + 0.5 * cross + c[:, None, None] * (cross @ cross)
    return inverse


def cross_matrix(f: FloatArray) -> FloatArray:
    """Give the matrices, shape (m, 3, 3), that take cross products with vectors."""
    matrix = np.zeros((len(f), 3, 3))
    matrix[:, 2, 1], matrix[:, 0, 2], matrix[:, 1, 0] = f.T
    return matrix - np.swapaxes(matrix, 1, 2)
