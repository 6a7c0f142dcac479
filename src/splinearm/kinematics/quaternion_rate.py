"""How fast rotations change: angular velocity and acceleration, and derivatives of quaternions.

Bare functions on batches that check nothing but the word for the frame. Of a quaternion quat_a_b
the "fixed" frame is a and the "moving" one is b; the angular velocity (rad/s) and acceleration
(rad/s2) of b against a may be written in either. Quaternions are w x y z.
"""

from typing import Literal, TypeAlias

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from .quaternion import conjugate, multiply

Frame: TypeAlias = Literal["fixed", "moving"]
"""In which frame an angular velocity is written: the one turned against, or the turning one."""

# omega = 2 qd q* in the fixed frame, 2 q* qd in the moving one; Diebel, Representing attitude,
# Stanford 2006, eq. 157 and 159 (there for the inverse rotation)


def angular_velocity(quat: ArrayInput, quat_d: ArrayInput, frame: Frame) -> FloatArray:
    """Give the angular velocity, shape (..., 3), rad/s, of a quaternion and its derivative.

    Args:
        quat: Unit quaternions, shape (..., 4).
        quat_d: Their first derivatives, shape (..., 4), 1/s.
        frame: "fixed" or "moving": in which frame it is written.
    """
    return 2.0 * _divided(quat_d, quat, frame)[..., 1:]


def angular_acceleration(quat: ArrayInput, quat_dd: ArrayInput, frame: Frame) -> FloatArray:
    """Give the angular acceleration, shape (..., 3), rad/s2.

    The first derivative is not asked for: of a unit quaternion it adds nothing but a scalar.

    Args:
        quat: Unit quaternions, shape (..., 4).
        quat_dd: Their second derivatives, shape (..., 4), 1/s2.
        frame: "fixed" or "moving": in which frame it is written.
    """
    return 2.0 * _divided(quat_dd, quat, frame)[..., 1:]


def derivative(quat: ArrayInput, omega: ArrayInput, frame: Frame) -> FloatArray:
    """Give the first derivative, shape (..., 4), 1/s, of a turning frame's quaternion.

    Args:
        quat: Unit quaternions, shape (..., 4).
        omega: Angular velocities, shape (..., 3), rad/s.
        frame: "fixed" or "moving": in which frame they are written.
    """
    return 0.5 * _times(_pure(omega), quat, frame)


def second_derivative(
    quat: ArrayInput, omega: ArrayInput, alpha: ArrayInput, frame: Frame
) -> FloatArray:
    """Give the second derivative, shape (..., 4), 1/s2, of a turning frame's quaternion.

    Args:
        quat: Unit quaternions, shape (..., 4).
        omega: Angular velocities, shape (..., 3), rad/s.
        alpha: Angular accelerations, shape (..., 3), rad/s2.
        frame: "fixed" or "moving": in which frame both are written.
    """
    omega = np.asarray(omega, dtype=np.float64)
    square = np.sum(omega * omega, axis=-1, keepdims=True)
    along = np.asarray(quat, dtype=np.float64)
    bent: FloatArray = 0.5 * _times(_pure(alpha), quat, frame) - 0.25 * square * along
    return bent


def _pure(vector: ArrayInput) -> FloatArray:
    vector = np.asarray(vector, dtype=np.float64)
    return np.concatenate((np.zeros((*vector.shape[:-1], 1)), vector), axis=-1)


def _times(pure: FloatArray, quat: ArrayInput, frame: Frame) -> FloatArray:
    """Give the rate put before the quaternion (fixed frame) or behind it (moving frame)."""
    if frame == "fixed":
        return multiply(pure, quat)
    if frame == "moving":
        return multiply(quat, pure)
    raise ValueError(f"frame: want 'fixed' or 'moving', got {frame!r}")


def _divided(rate: ArrayInput, quat: ArrayInput, frame: Frame) -> FloatArray:
    return _times(np.asarray(rate, dtype=np.float64), conjugate(quat), frame)
