"""Inverse dynamics of many motions, compiled, in blocks laid out as in `batch_kernel`.

A block W holds the motion of the body at hand: rows 0 to 2 its angular velocity, 3 to 5 its angular
acceleration, 6 to 8 the acceleration of its origin; on the way back rows 0 to 2 hold the force, 3
to 5 the moment. A block K of each joint holds sine and cosine (its position where it slides),
velocity, acceleration, and the body's force (rows 4 to 6) and moment (rows 7 to 9).
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .batch_kernel import BLOCK
from .dynamics_kernel import (
    BODY,
    DRIVE,
    about,
    coriolis_into,
    cross,
    forward_into,
    into,
    mass_matrix_into,
    to_parent,
)
from .sine_kernel import LARGEST, sincos


@fast_kernel
def inverse_batch_into(
    A: FloatArray,
    Q: FloatArray,
    Qd: FloatArray,
    Qdd: FloatArray,
    out: FloatArray,
) -> None:
    """Write the torques of motions whose arrays are all of shape (m, n); see `dynamics_kernel`."""
    m, n = Q.shape
    W = np.zeros(9 * BLOCK)
    K = np.zeros((n, 10 * BLOCK))
    for start in range(0, m, BLOCK):
        stop = min(start + BLOCK, m)
        W[: 6 * BLOCK] = 0.0
        for r in range(3):
            W[(6 + r) * BLOCK : (7 + r) * BLOCK] = -A[n, BODY + r]
        for k in range(n):
            _load(A[k, 12], Q[start:stop, k], Qd[start:stop, k], Qdd[start:stop, k], K[k])
            _carry(A[k], W)
            _move(A[k, 12], K[k], W)
            _wrench(A[k, BODY:DRIVE], W, K[k])
        W[: 6 * BLOCK] = 0.0
        for k in range(n - 1, -1, -1):
            for i in range(6 * BLOCK):
                W[i] += K[k, 4 * BLOCK + i]
            _torque(A[k, 12], A[k, DRIVE:], W, K[k])
            for i in range(stop - start):
                out[start + i, k] = K[k, 4 * BLOCK + i]
            _return(A[k], K[k], W)


@fast_kernel
def _load(kind: float, q: FloatArray, qd: FloatArray, qdd: FloatArray, K: FloatArray) -> None:
    """Write what a joint does in a block of motions."""
    largest = 0.0
    for i in range(q.shape[0]):
        K[i], K[2 * BLOCK + i], K[3 * BLOCK + i] = q[i], qd[i], qdd[i]
        largest = max(largest, abs(q[i]))
    if kind != 0.0:
        return
    if largest < LARGEST:
        for i in range(BLOCK):
            K[i], K[BLOCK + i] = sincos(K[i])
    else:
        for i in range(q.shape[0]):
            K[i], K[BLOCK + i] = math.sin(q[i]), math.cos(q[i])


@fast_kernel
def _carry(o: FloatArray, W: FloatArray) -> None:
    """Carry the motion of a body to the joint frame of the next, through a constant transform."""
    r0, r1, r2, r3, r4, r5, r6, r7, r8 = o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], o[8]
    px, py, pz = o[9], o[10], o[11]
    R = (r0, r1, r2, r3, r4, r5, r6, r7, r8)
    for i in range(BLOCK):
        wx, wy, wz = W[i], W[BLOCK + i], W[2 * BLOCK + i]
        bx, by, bz = W[3 * BLOCK + i], W[4 * BLOCK + i], W[5 * BLOCK + i]
        ux, uy, uz = cross(wx, wy, wz, px, py, pz)
        tx, ty, tz = cross(wx, wy, wz, ux, uy, uz)
        sx, sy, sz = cross(bx, by, bz, px, py, pz)
        ax = W[6 * BLOCK + i] + sx + tx
        ay = W[7 * BLOCK + i] + sy + ty
        az = W[8 * BLOCK + i] + sz + tz
        W[i], W[BLOCK + i], W[2 * BLOCK + i] = into(R, wx, wy, wz)
        W[3 * BLOCK + i], W[4 * BLOCK + i], W[5 * BLOCK + i] = into(R, bx, by, bz)
        W[6 * BLOCK + i], W[7 * BLOCK + i], W[8 * BLOCK + i] = into(R, ax, ay, az)


@fast_kernel
def _move(kind: float, K: FloatArray, W: FloatArray) -> None:
    """Carry the motion at a joint frame to the body that the joint moves."""
    if kind == 0.0:
        for i in range(BLOCK):
            s, c, v = K[i], K[BLOCK + i], K[2 * BLOCK + i]
            x, y = W[i], W[BLOCK + i]
            wx, wy = c * x + s * y, c * y - s * x
            W[i], W[BLOCK + i] = wx, wy
            W[2 * BLOCK + i] += v
            x, y = W[3 * BLOCK + i], W[4 * BLOCK + i]
            W[3 * BLOCK + i] = c * x + s * y + wy * v
            W[4 * BLOCK + i] = c * y - s * x - wx * v
            W[5 * BLOCK + i] += K[3 * BLOCK + i]
            x, y = W[6 * BLOCK + i], W[7 * BLOCK + i]
            W[6 * BLOCK + i] = c * x + s * y
            W[7 * BLOCK + i] = c * y - s * x
        return
    for i in range(BLOCK):
        slid, v = K[i], K[2 * BLOCK + i]
        wx, wy, wz = W[i], W[BLOCK + i], W[2 * BLOCK + i]
        W[6 * BLOCK + i] += (W[4 * BLOCK + i] + wx * wz) * slid + 2.0 * wy * v
        W[7 * BLOCK + i] += (wy * wz - W[3 * BLOCK + i]) * slid - 2.0 * wx * v
        W[8 * BLOCK + i] += K[3 * BLOCK + i] - (wx * wx + wy * wy) * slid


@fast_kernel
def _wrench(d: FloatArray, W: FloatArray, K: FloatArray) -> None:
    """Write the force and the moment that a body's motion needs at its frame's origin."""
    m, hx, hy, hz = d[0], d[1], d[2], d[3]
    inertia = (0.0, 0.0, 0.0, 0.0, d[4], d[5], d[6], d[7], d[8], d[9])
    for i in range(BLOCK):
        wx, wy, wz = W[i], W[BLOCK + i], W[2 * BLOCK + i]
        bx, by, bz = W[3 * BLOCK + i], W[4 * BLOCK + i], W[5 * BLOCK + i]
        ax, ay, az = W[6 * BLOCK + i], W[7 * BLOCK + i], W[8 * BLOCK + i]
        ux, uy, uz = cross(wx, wy, wz, hx, hy, hz)
        tx, ty, tz = cross(wx, wy, wz, ux, uy, uz)
        sx, sy, sz = cross(bx, by, bz, hx, hy, hz)
        K[4 * BLOCK + i] = m * ax + sx + tx
        K[5 * BLOCK + i] = m * ay + sy + ty
        K[6 * BLOCK + i] = m * az + sz + tz
        ux, uy, uz = about(inertia, wx, wy, wz)
        tx, ty, tz = cross(wx, wy, wz, ux, uy, uz)
        sx, sy, sz = cross(hx, hy, hz, ax, ay, az)
        ux, uy, uz = about(inertia, bx, by, bz)
        K[7 * BLOCK + i] = ux + sx + tx
        K[8 * BLOCK + i] = uy + sy + ty
        K[9 * BLOCK + i] = uz + sz + tz


@fast_kernel
def _torque(kind: float, p: FloatArray, W: FloatArray, K: FloatArray) -> None:
    """Write the torque of a joint, with what its drive adds, where its body's force stood."""
    inertia, viscous, coulomb = p[0], p[1], p[2]
    row = 5 if kind == 0.0 else 2
    for i in range(BLOCK):
        v = K[2 * BLOCK + i]
        sign = (1.0 if v > 0.0 else 0.0) - (1.0 if v < 0.0 else 0.0)
        K[4 * BLOCK + i] = inertia * K[3 * BLOCK + i] + viscous * v + coulomb * sign
    for i in range(BLOCK):
        K[4 * BLOCK + i] += W[row * BLOCK + i]


@fast_kernel
def _return(o: FloatArray, K: FloatArray, W: FloatArray) -> None:
    """Carry force and moment at a moved joint frame to its parent's."""
    o0, o1, o2, o3, o4, o5, o6, o7, o8 = o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], o[8]
    R = (o0, o1, o2, o3, o4, o5, o6, o7, o8, o[9], o[10], o[11], o[12])
    for i in range(BLOCK):
        fx, fy, fz = W[i], W[BLOCK + i], W[2 * BLOCK + i]
        nx, ny, nz = W[3 * BLOCK + i], W[4 * BLOCK + i], W[5 * BLOCK + i]
        fx, fy, fz, nx, ny, nz = to_parent(R, K[i], K[BLOCK + i], fx, fy, fz, nx, ny, nz)
        W[i], W[BLOCK + i], W[2 * BLOCK + i] = fx, fy, fz
        W[3 * BLOCK + i], W[4 * BLOCK + i], W[5 * BLOCK + i] = nx, ny, nz


@fast_kernel
def mass_matrix_batch_into(A: FloatArray, Q: FloatArray, out: FloatArray) -> None:
    """Write the mass matrices, shape (m, n, n), at joint vectors ``Q``, shape (m, n)."""
    for i in range(Q.shape[0]):
        mass_matrix_into(A, Q[i], out[i])


@fast_kernel
def coriolis_batch_into(A: FloatArray, Q: FloatArray, Qd: FloatArray, out: FloatArray) -> None:
    """Write the Coriolis matrices, shape (m, n, n), of states of shape (m, n)."""
    for i in range(Q.shape[0]):
        coriolis_into(A, Q[i], Qd[i], out[i])


@fast_kernel
def forward_batch_into(
    A: FloatArray,
    Q: FloatArray,
    Qd: FloatArray,
    Tau: FloatArray,
    out: FloatArray,
) -> bool:
    """Write the accelerations that torques cause, shape (m, n); False if a body has no inertia."""
    done = True
    for i in range(Q.shape[0]):
        done = done and forward_into(A, Q[i], Qd[i], Tau[i], out[i])
    return done
