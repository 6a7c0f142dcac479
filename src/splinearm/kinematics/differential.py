"""What follows from an arm's Jacobian: its derivatives, analytic forms, and manipulability.

Velocities are of the tool point, linear (m/s) above angular (rad/s); everything takes one joint
vector or many.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import KinematicsError

from . import quaternion
from .arm import Arm, Frame
from .forward import LOADED

Part: TypeAlias = Literal["all", "position", "orientation"]
"""Which rows of a Jacobian: all six, the linear three or the angular three."""

_GIMBAL_LOCK = 1e-9
"""Volume spanned by the three Euler axes below which they count as lying in a plane."""


def hessian(arm: Arm, q: ArrayInput, *, frame: Frame = "base") -> FloatArray:
    """Give the derivative of the Jacobian by each joint, shape (..., n, 6, n).

    ``H[..., j, :, k]`` is how column k changes per rad (m where it slides) of joint j.

    Args:
        arm: The arm.
        q: Joint positions, shape (..., n), rad (m where a joint slides).
        frame: Along whose axes the Jacobian is written: "base" or "tool". In the tool frame the
            turning of the axes is part of the change.

    Raises:
        ValueError: If the last axis of ``q`` is not n long or a number is not finite, or if
            ``frame`` is neither word.
    """
    return hessian_of(arm.jacobian(q, frame=frame), frame=frame)


def hessian_of(J: FloatArray, *, frame: Frame = "base") -> FloatArray:
    """Give the derivative of a Jacobian by each joint, (..., n, 6, n), from itself, (..., 6, n)."""
    # Bruyninckx and De Schutter, Symbolic differentiation of the velocity mapping for a serial
    # kinematic chain, Mechanism and Machine Theory 31 (1996) 135: a joint turns the columns of all
    # that follow it, and moves the tool point under the columns of all before it
    columns = J.mT
    v, w = columns[..., :3], columns[..., 3:]
    j, k = np.indices((J.shape[-1],) * 2)
    linear = np.cross(w[..., np.minimum(j, k), :], v[..., np.maximum(j, k), :])
    turned = np.cross(w[..., j, :], w[..., k, :])
    angular = np.where((j < k)[..., None], turned, 0.0)
    if frame == "tool":
        linear = linear - np.cross(w[..., j, :], v[..., k, :])
        angular = angular - turned
    return np.concatenate((linear, angular), axis=-1).mT


def jacobian_rate(arm: Arm, q: ArrayInput, qd: ArrayInput, *, frame: Frame = "base") -> FloatArray:
    """Give the time derivative of the Jacobian, shape (..., 6, n).

    With it the acceleration of the tool is ``J @ qdd + J_rate @ qd`` (in the tool frame: the
    derivative of the components of its velocity along the turning axes).

    Args:
        arm: The arm.
        q: Joint positions, shape (..., n), rad (m where a joint slides).
        qd: Joint velocities, shape (..., n), rad/s (m/s).
        frame: As in `hessian`.

    Raises:
        ValueError: As in `hessian`; for ``qd`` too.
    """
    if frame == "base" and LOADED.single is not None:
        rate = np.empty((6, arm.n))
        if _calls(arm).rate(q, qd, rate):
            return rate
    rates = arm.joint_array(qd, "qd")
    change: FloatArray = np.einsum("...j,...jrk->...rk", rates, hessian(arm, q, frame=frame))
    return change


def quaternion_jacobian(arm: Arm, q: ArrayInput) -> FloatArray:
    """Give the analytic Jacobian for the tool's quaternion, shape (..., 7, n).

    Rows: velocity of the tool point in base (m/s), then the rates of w x y z of the quaternion of
    the tool in base that has w >= 0.

    Args:
        arm: The arm.
        q: Joint positions, shape (..., n), rad (m where a joint slides).

    Raises:
        ValueError: If the last axis is not n long or a number is not finite.
    """
    J = arm.jacobian(q)
    quat = quaternion.from_matrix(arm.fk(q)[..., :3, :3])
    # the rate is half the product of (0, omega) and the quaternion: Siciliano et al., Robotics:
    # Modelling, Planning and Control, 2009, eq. 3.94 and 3.95
    omega = np.concatenate((np.zeros_like(J[..., :1, :]), J[..., 3:, :]), axis=-2)
    rates = 0.5 * quaternion.multiply(omega.mT, quat[..., None, :]).mT
    return np.concatenate((J[..., :3, :], rates), axis=-2)


def euler_jacobian(arm: Arm, q: ArrayInput, sequence: str) -> FloatArray:
    """Give the analytic Jacobian for Euler angles of the tool, shape (..., 6, n).

    Rows: velocity of the tool point in base (m/s), then the rates of the three angles (rad/s) that
    `quaternion.to_euler` gives for the tool in base.

    Args:
        arm: The arm.
        q: Joint positions, shape (..., n), rad (m where a joint slides).
        sequence: The three axes, as in `quaternion.from_euler`: "xyz" about fixed axes, "ZYX" about
            moving ones.

    Raises:
        KinematicsError: Where the angles have no rates (gimbal lock).
        ValueError: If the sequence is not one, the last axis of ``q`` is not n long or a number is
            not finite.
    """
    J = arm.jacobian(q)
    angles = quaternion.to_euler(quaternion.from_matrix(arm.fk(q)[..., :3, :3]), sequence)
    axes = _euler_axes(angles, sequence)
    volume = np.abs(np.linalg.det(axes))
    if (volume < _GIMBAL_LOCK).any():
        worst = angles.reshape(-1, 3)[int(np.argmin(volume))]
        raise KinematicsError(
            f"the Euler angles {sequence!r} have no rates where the second is "
            f"{np.degrees(worst[1]):.6g} deg (gimbal lock); take another sequence or the quaternion"
        )
    return np.concatenate((J[..., :3, :], np.linalg.solve(axes, J[..., 3:, :])), axis=-2)


def manipulability(arm: Arm, q: ArrayInput, *, part: Part = "all") -> FloatArray:
    """Give how far from singular an arm is, as a volume, shape (...); 0 where it is singular.

    The product of the Jacobian's singular values (Yoshikawa 1985), of as many as there are joints
    or rows, whichever are fewer. For ``part="all"`` it mixes lengths and angles, so that it
    compares postures of one arm, not arms.

    Args:
        arm: The arm.
        q: Joint positions, shape (..., n), rad (m where a joint slides).
        part: Which rows count: "all", "position" or "orientation".

    Raises:
        ValueError: If the last axis of ``q`` is not n long or a number is not finite, or if
            ``part`` is none of these words.
    """
    rows = _rows(part)
    if LOADED.single is not None:
        one = np.empty(1)
        if _calls(arm).volume(q, _SPANS[part], one, _NONE):
            return one.reshape(())
    volume: FloatArray = np.linalg.svd(arm.jacobian(q)[..., rows, :], compute_uv=False).prod(
        axis=-1
    )
    return volume


def manipulability_gradient(arm: Arm, q: ArrayInput, *, part: Part = "all") -> FloatArray:
    """Give the derivative of the manipulability by each joint, shape (..., n).

    At a singularity, where the manipulability has a kink, it is one of the two slopes there.

    Args:
        arm: The arm.
        q: Joint positions, shape (..., n), rad (m where a joint slides).
        part: As in `manipulability`.

    Raises:
        ValueError: As in `manipulability`.
    """
    rows = _rows(part)
    if LOADED.single is not None:
        slopes = np.empty(arm.n)
        if _calls(arm).volume(q, _SPANS[part], np.empty(1), slopes):
            return slopes
    U, sigma, Vt = np.linalg.svd(arm.jacobian(q)[..., rows, :], full_matrices=False)
    # the derivative of a singular value is u' dJ v; of their product, that times all the others,
    # which unlike w tr(J+ dJ) holds where one of them is zero
    changes = np.einsum("...rk,...jrc,...kc->...jk", U, hessian(arm, q)[..., rows, :], Vt)
    others = np.stack(
        [np.delete(sigma, k, axis=-1).prod(axis=-1) for k in range(sigma.shape[-1])], axis=-1
    )
    gradient: FloatArray = np.einsum("...jk,...k->...j", changes, others)
    return gradient


class _Calls(NamedTuple):
    """The kernels of one arm for one joint vector; see `differential_kernel`."""

    rate: Callable[..., bool]
    volume: Callable[..., bool]


@lru_cache(maxsize=16)
def _calls(arm: Arm) -> _Calls:
    from splinearm.direct import bind

    from . import differential_kernel as kernel

    return _Calls(bind(kernel.rate_call, arm.numbers), bind(kernel.volume_call, arm.numbers))


_SPANS = {
    "all": np.array((0.0, 6.0)),
    "position": np.array((0.0, 3.0)),
    "orientation": np.array((3.0, 6.0)),
}
_NONE = np.empty(0)


def _rows(part: Part) -> slice:
    rows = {"all": slice(0, 6), "position": slice(0, 3), "orientation": slice(3, 6)}
    if part not in rows:
        raise ValueError(f"part: want 'all', 'position' or 'orientation', got {part!r}")
    return rows[part]


def _euler_axes(angles: FloatArray, sequence: str) -> FloatArray:
    """Give the axes in base about which three Euler angles turn, as columns, (..., 3, 3)."""
    first_to_last = ["xyz".index(letter) for letter in sequence.lower()]
    order = (0, 1, 2) if sequence.isupper() else (2, 1, 0)
    axes = np.empty((*angles.shape, 3))
    carried = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), (*angles.shape[:-1], 4))
    for i in order:
        axis = np.eye(3)[first_to_last[i]]
        axes[..., :, i] = quaternion.rotate(carried, np.broadcast_to(axis, angles.shape))
        carried = quaternion.multiply(carried, quaternion.from_axis_angle(axis, angles[..., i]))
    return axes
