"""Unit quaternions: w x y z, Hamilton, shape (..., 4). Bare functions that check nothing.

A quaternion and its negative are one rotation; functions that must choose take w >= 0. Angles in
rad. Everything is batched and broadcasts over the leading axes.
"""

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

_LOCK = 1e-12
"""Nearer than this to gimbal lock (half of the middle angle, rad) a rotation counts as locked."""


def multiply(a: ArrayInput, b: ArrayInput) -> FloatArray:
    """Give the Hamilton product ``a b``, shape (..., 4): first b, then a."""
    aw, ax, ay, az = _parts(a)
    bw, bx, by, bz = _parts(b)
    return np.stack(
        (
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ),
        axis=-1,
    )


def conjugate(quat: ArrayInput) -> FloatArray:
    """Give w, -x, -y, -z, shape (..., 4); of a unit quaternion this is the inverse."""
    return np.asarray(quat, dtype=np.float64) * (1.0, -1.0, -1.0, -1.0)


def inverse(quat: ArrayInput) -> FloatArray:
    """Give the inverse of any quaternion but zero, shape (..., 4)."""
    quat = np.asarray(quat, dtype=np.float64)
    inverted: FloatArray = conjugate(quat) / np.sum(quat * quat, axis=-1, keepdims=True)
    return inverted


def normalize(quat: ArrayInput) -> FloatArray:
    """Give the quaternion of length 1 along ``quat``, shape (..., 4), which is not zero."""
    quat = np.asarray(quat, dtype=np.float64)
    unit: FloatArray = quat / np.linalg.norm(quat, axis=-1, keepdims=True)
    return unit


def to_xyzw(quat: ArrayInput) -> FloatArray:
    """Give the same quaternion with its w last, shape (..., 4), for libraries that want it so."""
    return np.roll(np.asarray(quat, dtype=np.float64), -1, axis=-1)


def from_xyzw(xyzw: ArrayInput) -> FloatArray:
    """Give w x y z of a quaternion written with its w last, shape (..., 4)."""
    return np.roll(np.asarray(xyzw, dtype=np.float64), 1, axis=-1)


def rotate(quat: ArrayInput, vectors: ArrayInput) -> FloatArray:
    """Give vectors, shape (..., 3), turned by unit quaternions, shape (..., 4)."""
    quat = np.asarray(quat, dtype=np.float64)
    vectors = np.asarray(vectors, dtype=np.float64)
    w, u = quat[..., :1], quat[..., 1:]
    t = 2.0 * np.cross(u, vectors)
    turned: FloatArray = vectors + w * t + np.cross(u, t)
    return turned


def to_matrix(quat: ArrayInput) -> FloatArray:
    """Give rotation matrices, shape (..., 3, 3), of unit quaternions, shape (..., 4)."""
    w, x, y, z = _parts(quat)
    R = np.empty((*w.shape, 3, 3))
    R[..., 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    R[..., 0, 1] = 2.0 * (x * y - w * z)
    R[..., 0, 2] = 2.0 * (x * z + w * y)
    R[..., 1, 0] = 2.0 * (x * y + w * z)
    R[..., 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    R[..., 1, 2] = 2.0 * (y * z - w * x)
    R[..., 2, 0] = 2.0 * (x * z - w * y)
    R[..., 2, 1] = 2.0 * (y * z + w * x)
    R[..., 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    return R


def from_matrix(R: ArrayInput) -> FloatArray:
    """Give unit quaternions with w >= 0, shape (..., 4), of rotation matrices (..., 3, 3)."""
    # Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978) 223: each row of
    # 4 q q^T is a multiple of the quaternion; the one with the largest diagonal is the exact one
    R = np.asarray(R, dtype=np.float64)
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    wx, wy, wz = (
        R[..., 2, 1] - R[..., 1, 2],
        R[..., 0, 2] - R[..., 2, 0],
        R[..., 1, 0] - R[..., 0, 1],
    )
    xy, xz, yz = (
        R[..., 0, 1] + R[..., 1, 0],
        R[..., 0, 2] + R[..., 2, 0],
        R[..., 1, 2] + R[..., 2, 1],
    )
    rows = np.stack(
        (
            np.stack((1.0 + xx + yy + zz, wx, wy, wz), axis=-1),
            np.stack((wx, 1.0 + xx - yy - zz, xy, xz), axis=-1),
            np.stack((wy, xy, 1.0 - xx + yy - zz, yz), axis=-1),
            np.stack((wz, xz, yz, 1.0 - xx - yy + zz), axis=-1),
        ),
        axis=-2,
    )
    best = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)[..., None, None]
    return _upper(normalize(np.take_along_axis(rows, best, axis=-2)[..., 0, :]))


def from_axis_angle(axis: ArrayInput, angle: ArrayInput) -> FloatArray:
    """Give the rotation by ``angle`` (...), rad, about ``axis`` (..., 3) of any length but zero."""
    axis = np.asarray(axis, dtype=np.float64)
    half = 0.5 * np.asarray(angle, dtype=np.float64)[..., None]
    vector = np.sin(half) * axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    quat = np.empty((*vector.shape[:-1], 4))
    quat[..., :1] = np.cos(half)
    quat[..., 1:] = vector
    return quat


def to_axis_angle(quat: ArrayInput) -> tuple[FloatArray, FloatArray]:
    """Give axis, shape (..., 3), and angle, shape (...), between 0 and pi, of unit quaternions.

    No rotation has no axis: z is given for it. A half turn has two: either may be given.
    """
    quat = _upper(quat)
    length = np.linalg.norm(quat[..., 1:], axis=-1, keepdims=True)
    turned = length > 0.0
    axis = np.where(turned, quat[..., 1:] / np.where(turned, length, 1.0), (0.0, 0.0, 1.0))
    return axis, 2.0 * np.arctan2(length[..., 0], quat[..., 0])


def exp(vector: ArrayInput) -> FloatArray:
    """Give the unit quaternion, shape (..., 4), of rotation vectors (axis times angle), rad."""
    vector = np.asarray(vector, dtype=np.float64)
    half = 0.5 * np.linalg.norm(vector, axis=-1, keepdims=True)
    # np.sinc(x) is sin(pi x) / (pi x), exact at and near zero
    return np.concatenate((np.cos(half), 0.5 * np.sinc(half / np.pi) * vector), axis=-1)


def log(quat: ArrayInput) -> FloatArray:
    """Give the rotation vector, shape (..., 3), of length at most pi, of unit quaternions."""
    quat = _upper(quat)
    length = np.linalg.norm(quat[..., 1:], axis=-1, keepdims=True)
    small = length < 1e-150
    scale = np.arctan2(length, quat[..., :1]) / np.where(small, 1.0, length)
    vector: FloatArray = 2.0 * np.where(small, 1.0, scale) * quat[..., 1:]
    return vector


def angle_between(a: ArrayInput, b: ArrayInput) -> FloatArray:
    """Give the angle of the rotation that leads from ``a`` to ``b``, shape (...), 0 to pi rad."""
    between = multiply(conjugate(a), b)
    length = np.linalg.norm(between[..., 1:], axis=-1)
    angle: FloatArray = 2.0 * np.arctan2(length, np.abs(between[..., 0]))
    return angle


def slerp(a: ArrayInput, b: ArrayInput, share: ArrayInput) -> FloatArray:
    """Give the rotation at ``share`` (...) of the shorter way from ``a`` to ``b``, shape (..., 4).

    At share 0 it is a, at 1 it is b or -b. Between rotations half a turn apart there are two
    shortest ways: one of them is taken.
    """
    # Shoemake, Animating rotation with quaternion curves, SIGGRAPH 1985, as a exp(u log(a^-1 b))
    step = log(multiply(conjugate(a), b)) * np.asarray(share, dtype=np.float64)[..., None]
    return multiply(a, exp(step))


def squad(
    a: ArrayInput, a_control: ArrayInput, b_control: ArrayInput, b: ArrayInput, share: ArrayInput
) -> FloatArray:
    """Give the rotation at ``share`` (...) of a smooth way from ``a`` to ``b``, shape (..., 4).

    Pieces that share their ends and, there, their control rotations (``squad_controls``) join
    without a jump of the angular velocity, where the shares run equally fast.
    """
    # Shoemake, Quaternion calculus and fast animation, SIGGRAPH course notes 10, 1987
    share = np.asarray(share, dtype=np.float64)
    inner = slerp(a_control, b_control, share)
    return slerp(slerp(a, b, share), inner, 2.0 * share * (1.0 - share))


def squad_controls(quats: ArrayInput) -> FloatArray:
    """Give the control rotations, shape (..., m, 4), that lead ``squad`` smoothly through m.

    The first and the last are the rotations themselves.
    """
    quats = np.asarray(quats, dtype=np.float64)
    here, back = quats[..., 1:-1, :], conjugate(quats[..., 1:-1, :])
    bend = log(multiply(back, quats[..., 2:, :])) + log(multiply(back, quats[..., :-2, :]))
    controls = quats.copy()
    controls[..., 1:-1, :] = multiply(here, exp(-0.25 * bend))
    return controls


def average(quats: ArrayInput, weights: ArrayInput | None = None) -> FloatArray:
    """Give the mean rotation of m, shape (..., 4), with w >= 0.

    It is the one with the least sum of squared distances, as matrices, to the given ones; their
    signs do not matter.

    Args:
        quats: Unit quaternions, shape (..., m, 4).
        weights: How much each counts, shape (..., m), at least zero; None: all the same.

    Raises:
        ValueError: If no one rotation is the mean, as of two that are half a turn apart.
    """
    # Markley et al., Averaging quaternions, J. Guidance, Control, and Dynamics 30 (2007), eq. 12
    quats = np.asarray(quats, dtype=np.float64)
    weights = np.ones(quats.shape[-2]) if weights is None else np.asarray(weights, np.float64)
    scatter = np.einsum("...m,...mi,...mj->...ij", weights, quats, quats)
    values, vectors = np.linalg.eigh(scatter)
    if np.any(values[..., 3] - values[..., 2] <= _LOCK * values[..., 3]):
        raise ValueError("quats: want rotations that have one mean, got some that have several")
    return _upper(vectors[..., 3])


def random(rng: np.random.Generator, *batch: int) -> FloatArray:
    """Give rotations drawn uniformly from all, shape (*batch, 4), with w >= 0."""
    # Muller, A note on a method for generating points uniformly on n-dimensional spheres,
    # Comm. ACM 2 (1959) 19
    return _upper(normalize(rng.normal(size=(*batch, 4))))


def spread(count: int) -> FloatArray:
    """Give rotations spread evenly over all, the same at every call, shape (count, 4)."""
    # Alexa, Super-Fibonacci spirals: fast, low-discrepancy sampling of SO(3), CVPR 2022, alg. 1
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    alpha, beta = 2.0 * np.pi * s / np.sqrt(2.0), 2.0 * np.pi * s / 1.533751168755204288118041413
    parts = inner * np.sin(alpha), inner * np.cos(alpha), outer * np.sin(beta), outer * np.cos(beta)
    return _upper(np.stack(parts, axis=-1))


def from_euler(angles: ArrayInput, sequence: str) -> FloatArray:
    """Give unit quaternions, shape (..., 4), of three turns about coordinate axes.

    Args:
        angles: In the order of the sequence, shape (..., 3), rad.
        sequence: Three axes, neighbours different. Lower case ("xyz"): each about the fixed axis
            (extrinsic). Upper case ("ZYX"): each about the moved axis (intrinsic).

    Raises:
        ValueError: If the sequence is not one of these.
    """
    axes, intrinsic = _axes(sequence)
    angles = np.asarray(angles, dtype=np.float64)
    turns = [from_axis_angle(np.eye(3)[axis], angles[..., i]) for i, axis in enumerate(axes)]
    if not intrinsic:
        turns.reverse()
    return multiply(multiply(turns[0], turns[1]), turns[2])


def to_euler(quat: ArrayInput, sequence: str) -> FloatArray:
    """Give the three turns, shape (..., 3), rad, that make up unit quaternions, shape (..., 4).

    First and third lie in -pi to pi; the second in 0 to pi where the first axis is also the third
    ("zyz"), in -pi/2 to pi/2 otherwise. In gimbal lock, where only the sum or the difference of
    first and third is known, the third is 0.

    Args:
        quat: Unit quaternions, shape (..., 4).
        sequence: As in ``from_euler``.

    Raises:
        ValueError: If the sequence is none.
    """
    # Bernardes and Viollet, Quaternion to Euler angles conversion, PLoS ONE 17 (2022) e0276302
    axes, intrinsic = _axes(sequence)
    i, j, k = reversed(axes) if intrinsic else axes
    proper = i == k
    if proper:
        k = 3 - i - j
    sign = float((i - j) * (j - k) * (k - i) // 2)
    quat = np.asarray(quat, dtype=np.float64)
    a, b, c, d = quat[..., 0], quat[..., 1 + i], quat[..., 1 + j], quat[..., 1 + k] * sign
    if not proper:
        a, b, c, d = a - c, b + d, c + a, d - b
    half_middle = np.arctan2(np.hypot(c, d), np.hypot(a, b))
    half_sum, half_difference = np.arctan2(b, a), np.arctan2(d, c)
    inner, outer = half_sum - half_difference, half_sum + half_difference
    if intrinsic:
        inner, outer = outer, inner
    known = np.where(half_middle < _LOCK, half_sum, half_difference * (1.0 if intrinsic else -1.0))
    locked = (half_middle < _LOCK) | (half_middle > 0.5 * np.pi - _LOCK)
    first, third = np.where(locked, 2.0 * known, inner), np.where(locked, 0.0, outer)
    middle = 2.0 * half_middle
    if not proper:
        middle = middle - 0.5 * np.pi
        if intrinsic:
            first = first * sign
        else:
            third = third * sign
    return np.stack((_wrap(first), middle, _wrap(third)), axis=-1)


def _axes(sequence: str) -> tuple[list[int], bool]:
    """Give the three axes as numbers, and whether they move along."""
    axes = ["xyz".find(letter) for letter in sequence.lower()]
    one_case = sequence in (sequence.lower(), sequence.upper())
    if len(axes) != 3 or -1 in axes or not one_case or axes[1] in (axes[0], axes[2]):
        raise ValueError(
            "sequence: want three of x y z (fixed axes) or X Y Z (moving axes), "
            f"neighbours different, got {sequence!r}"
        )
    return axes, sequence.isupper()


def _wrap(angle: FloatArray) -> FloatArray:
    """Give the same angle between -pi and pi."""
    return np.where(
        np.abs(angle) > np.pi, angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)), angle
    )


def _upper(quat: ArrayInput) -> FloatArray:
    """Give the same rotation with w >= 0."""
    quat = np.asarray(quat, dtype=np.float64)
    return np.where(quat[..., :1] < 0.0, -quat, quat)


def _parts(quat: ArrayInput) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    quat = np.asarray(quat, dtype=np.float64)
    return quat[..., 0], quat[..., 1], quat[..., 2], quat[..., 3]
