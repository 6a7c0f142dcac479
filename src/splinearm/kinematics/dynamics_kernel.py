"""Rigid-body dynamics at one joint vector, compiled.

The model is one array A, shape (n + 1, 26). Its first 13 columns are the chain as in array O (see
`packed`), so that A stands wherever O does. Row k then holds

- in columns 13 to 22 the body that joint k moves, in its moved joint frame: its mass, its first
  moment m c (x y z) and its inertia about the frame's origin (xx xy xz yy yz zz);
- in columns 23 to 25 the joint's drive: reflected inertia, viscous and Coulomb friction.

In the last row columns 13 to 15 are the gravity in base.

Functions whose names end in ``_into`` answer whether they have: False where the arrays do not fit
the arm or a number is not finite, and what they wrote is then not to be used.
"""

import math
from typing import TypeAlias

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .forward_kernel import joint
from .sine_kernel import sine_and_cosine

BODY = 13
"""First column of a body; in the last row, of the gravity."""
DRIVE = 23
"""First column of a joint's drive."""

Numbers: TypeAlias = FloatArray | tuple[float, ...]
"""Constants of a joint or a body: a row of an array, or its numbers taken out of a hot loop."""


@fast_kernel
def inverse_into(
    A: FloatArray,
    q: FloatArray,
    qd: FloatArray,
    qdd: FloatArray,
    tau: FloatArray,
) -> bool:
    """Write the torques (forces where a joint slides) that a motion needs, shape (n,)."""
    n = A.shape[0] - 1
    if q.shape[0] != n or qd.shape[0] != n or qdd.shape[0] != n or tau.shape[0] != n:
        return False
    for k in range(n):
        if not abs(q[k]) + abs(qd[k]) + abs(qdd[k]) < math.inf:
            return False
    F = np.empty((n, 8))
    sines(A, q, F)
    newton_euler(A, (A[n, BODY], A[n, BODY + 1], A[n, BODY + 2]), qd, qdd, tau, F)
    for k in range(n):
        sign = 1.0 if qd[k] > 0.0 else (-1.0 if qd[k] < 0.0 else 0.0)
        tau[k] += A[k, DRIVE] * qdd[k] + A[k, DRIVE + 1] * qd[k] + A[k, DRIVE + 2] * sign
    return True


@fast_kernel
def mass_matrix_into(A: FloatArray, q: FloatArray, M: FloatArray) -> bool:
    """Write the mass matrix with the drives' inertia on its diagonal, shape (n, n)."""
    n = A.shape[0] - 1
    if q.shape[0] != n or M.shape[0] != n or M.shape[1] != n:
        return False
    for k in range(n):
        if not abs(q[k]) < math.inf:
            return False
    composite_bodies(A, q, M)
    for k in range(n):
        M[k, k] += A[k, DRIVE]
    return True


@fast_kernel
def forward_into(
    A: FloatArray,
    q: FloatArray,
    qd: FloatArray,
    tau: FloatArray,
    qdd: FloatArray,
) -> bool:
    """Write the accelerations that torques cause, shape (n,)."""
    n = A.shape[0] - 1
    if tau.shape[0] != n or qdd.shape[0] != n:
        return False
    for k in range(n):
        if not abs(tau[k]) < math.inf:
            return False
    bias = np.empty(n)
    if not inverse_into(A, q, qd, np.zeros(n), bias):
        return False
    M = np.empty((n, n))
    mass_matrix_into(A, q, M)
    for k in range(n):
        qdd[k] = tau[k] - bias[k]
    return solve_symmetric(M, qdd)


@fast_kernel
def coriolis_into(A: FloatArray, q: FloatArray, qd: FloatArray, C: FloatArray) -> bool:
    """Write the Coriolis matrix of Christoffel symbols, shape (n, n)."""
    n = A.shape[0] - 1
    if q.shape[0] != n or qd.shape[0] != n or C.shape[0] != n or C.shape[1] != n:
        return False
    largest = 0.0
    for k in range(n):
        if not abs(q[k]) + abs(qd[k]) < math.inf:
            return False
        largest = max(largest, abs(qd[k]))
    if largest == 0.0:
        C[:] = 0.0
        return True
    # C(q, qd) qd is quadratic in qd with symmetric symbols, so that by polarisation
    # C(q, u) v = (h(u + v) - h(u - v)) / 4 with h(u) = C(q, u) u; v is one joint at a time
    still, none, F = np.zeros(n), (0.0, 0.0, 0.0), np.empty((n, 8))
    u, over, under = qd.copy(), np.empty(n), np.empty(n)
    sines(A, q, F)
    for k in range(n):
        u[k] = qd[k] + largest
        newton_euler(A, none, u, still, over, F)
        u[k] = qd[k] - largest
        newton_euler(A, none, u, still, under, F)
        u[k] = qd[k]
        for j in range(n):
            C[j, k] = (over[j] - under[j]) / (4.0 * largest)
    return True


@fast_kernel
def sines(A: FloatArray, q: FloatArray, S: FloatArray) -> None:
    """Write sine and cosine of each joint, its position where it slides, into columns 0 and 1."""
    for k in range(len(q)):
        if A[k, 12] == 0.0:
            S[k, 0], S[k, 1] = sine_and_cosine(q[k])
        else:
            S[k, 0], S[k, 1] = q[k], 0.0


@fast_kernel
def newton_euler(
    A: FloatArray,
    g: tuple[float, float, float],
    qd: FloatArray,
    qdd: FloatArray,
    tau: FloatArray,
    F: FloatArray,
) -> None:
    """Write the torques of a motion without what the drives add; F is what `sines` wrote."""
    # Luh, Walker and Paul, On-line computational scheme for mechanical manipulators, 1980, with
    # the wrench of each body at its frame's origin instead of its centre of mass
    n = A.shape[0] - 1
    wx, wy, wz, bx, by, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ax, ay, az = -g[0], -g[1], -g[2]
    for k in range(n):
        o, d = joint(A, k), _body(A, k)
        px, py, pz = o[9], o[10], o[11]
        sx, sy, sz = cross(bx, by, bz, px, py, pz)
        ux, uy, uz = cross(wx, wy, wz, px, py, pz)
        tx, ty, tz = cross(wx, wy, wz, ux, uy, uz)
        ax, ay, az = into(o, ax + sx + tx, ay + sy + ty, az + sz + tz)
        wx, wy, wz = into(o, wx, wy, wz)
        bx, by, bz = into(o, bx, by, bz)
        v, vv, s, c = qd[k], qdd[k], F[k, 0], F[k, 1]
        if o[12] == 0.0:
            ax, ay = c * ax + s * ay, c * ay - s * ax
            wx, wy = c * wx + s * wy, c * wy - s * wx
            bx, by = c * bx + s * by + wy * v, c * by - s * bx - wx * v
            wz, bz = wz + v, bz + vv
        else:
            ax += (by + wx * wz) * s + 2.0 * wy * v
            ay += (wy * wz - bx) * s - 2.0 * wx * v
            az += vv - (wx * wx + wy * wy) * s
        m, hx, hy, hz = d[0], d[1], d[2], d[3]
        ux, uy, uz = cross(wx, wy, wz, hx, hy, hz)
        sx, sy, sz = cross(bx, by, bz, hx, hy, hz)
        tx, ty, tz = cross(wx, wy, wz, ux, uy, uz)
        F[k, 2], F[k, 3], F[k, 4] = m * ax + sx + tx, m * ay + sy + ty, m * az + sz + tz
        ux, uy, uz = about(d, wx, wy, wz)
        tx, ty, tz = cross(wx, wy, wz, ux, uy, uz)
        sx, sy, sz = cross(hx, hy, hz, ax, ay, az)
        ux, uy, uz = about(d, bx, by, bz)
        F[k, 5], F[k, 6], F[k, 7] = ux + sx + tx, uy + sy + ty, uz + sz + tz
    fx, fy, fz, nx, ny, nz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(n - 1, -1, -1):
        o = joint(A, k)
        fx, fy, fz, nx, ny, nz = (
            fx + F[k, 2],
            fy + F[k, 3],
            fz + F[k, 4],
            nx + F[k, 5],
            ny + F[k, 6],
            nz + F[k, 7],
        )
        tau[k] = nz if o[12] == 0.0 else fz
        fx, fy, fz, nx, ny, nz = to_parent(o, F[k, 0], F[k, 1], fx, fy, fz, nx, ny, nz)


@fast_kernel
def composite_bodies(A: FloatArray, q: FloatArray, M: FloatArray) -> None:
    """Write the mass matrix without what the drives add."""
    # Walker and Orin, Efficient dynamic computer simulation of robotic mechanisms, 1982, method 3
    n = A.shape[0] - 1
    S = np.empty((n, 2))
    B = A[:n, BODY:DRIVE].copy()
    sines(A, q, S)
    for k in range(n - 1, -1, -1):
        b = B[k]
        if A[k, 12] == 0.0:
            fx, fy, fz, nx, ny, nz = -b[2], b[1], 0.0, b[6], b[8], b[9]
            M[k, k] = nz
        else:
            fx, fy, fz, nx, ny, nz = 0.0, 0.0, b[0], b[2], -b[1], 0.0
            M[k, k] = fz
        for j in range(k, 0, -1):
            fx, fy, fz, nx, ny, nz = to_parent(A[j], S[j, 0], S[j, 1], fx, fy, fz, nx, ny, nz)
            M[k, j - 1] = M[j - 1, k] = nz if A[j - 1, 12] == 0.0 else fz
        if k > 0:
            _add_to_parent(A[k], S[k, 0], S[k, 1], b, B[k - 1])


@fast_kernel
def _add_to_parent(o: FloatArray, s: float, c: float, b: FloatArray, parent: FloatArray) -> None:
    """Add a composite body in its moved joint frame to that of its parent's."""
    px, py, pz = o[9], o[10], o[11]
    if o[12] != 0.0:
        px, py, pz = px + s * o[2], py + s * o[5], pz + s * o[8]
        s, c = 0.0, 1.0
    R = (
        (o[0] * c + o[1] * s, o[1] * c - o[0] * s, o[2]),
        (o[3] * c + o[4] * s, o[4] * c - o[3] * s, o[5]),
        (o[6] * c + o[7] * s, o[7] * c - o[6] * s, o[8]),
    )
    m = b[0]
    hx = R[0][0] * b[1] + R[0][1] * b[2] + R[0][2] * b[3]
    hy = R[1][0] * b[1] + R[1][1] * b[2] + R[1][2] * b[3]
    hz = R[2][0] * b[1] + R[2][1] * b[2] + R[2][2] * b[3]
    parent[0] += m
    parent[1] += hx + m * px
    parent[2] += hy + m * py
    parent[3] += hz + m * pz
    # about the parent's origin: R I R' + (2 p.h + m p.p) 1 - (p h' + h p') - m p p'
    trace = 2.0 * (px * hx + py * hy + pz * hz) + m * (px * px + py * py + pz * pz)
    at = 4
    p, h = (px, py, pz), (hx, hy, hz)
    for r in range(3):
        x, y, z = about(b, R[r][0], R[r][1], R[r][2])
        for t in range(r, 3):
            turned = R[t][0] * x + R[t][1] * y + R[t][2] * z
            moved = p[r] * h[t] + h[r] * p[t] + m * p[r] * p[t]
            parent[at] += turned - moved + (trace if r == t else 0.0)
            at += 1


@fast_kernel
def solve_symmetric(M: FloatArray, b: FloatArray) -> bool:
    """Solve M x = b in place by Cholesky's method; False if M is not positive definite."""
    n = M.shape[0]
    for j in range(n):
        pivot = M[j, j]
        for k in range(j):
            pivot -= M[j, k] * M[j, k]
        if not pivot > 0.0:
            return False
        root = math.sqrt(pivot)
        M[j, j] = root
        for i in range(j + 1, n):
            total = M[i, j]
            for k in range(j):
                total -= M[i, k] * M[j, k]
            M[i, j] = total / root
    for i in range(n):
        for k in range(i):
            b[i] -= M[i, k] * b[k]
        b[i] /= M[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= M[k, i] * b[k]
        b[i] /= M[i, i]
    return True


@fast_kernel
def _body(A: FloatArray, k: int) -> tuple[float, ...]:
    """Give the body that joint k moves as numbers."""
    return (
        A[k, 13],
        A[k, 14],
        A[k, 15],
        A[k, 16],
        A[k, 17],
        A[k, 18],
        A[k, 19],
        A[k, 20],
        A[k, 21],
        A[k, 22],
    )


@fast_kernel
def cross(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float
) -> tuple[float, float, float]:
    """Give the vector product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@fast_kernel
def into(o: Numbers, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Give a vector of the parent frame in the frame behind the constant rotation in ``o``."""
    return (
        o[0] * x + o[3] * y + o[6] * z,
        o[1] * x + o[4] * y + o[7] * z,
        o[2] * x + o[5] * y + o[8] * z,
    )


@fast_kernel
def about(d: Numbers, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Give the inertia of a body times a vector."""
    return (
        d[4] * x + d[5] * y + d[6] * z,
        d[5] * x + d[7] * y + d[8] * z,
        d[6] * x + d[8] * y + d[9] * z,
    )


@fast_kernel
def to_parent(
    o: Numbers,
    s: float,
    c: float,
    fx: float,
    fy: float,
    fz: float,
    nx: float,
    ny: float,
    nz: float,
) -> tuple[float, float, float, float, float, float]:
    """Give a force and a moment at a moved joint frame at its parent's, in the parent's axes."""
    if o[12] == 0.0:
        fx, fy = c * fx - s * fy, s * fx + c * fy
        nx, ny = c * nx - s * ny, s * nx + c * ny
    else:
        nx, ny = nx - s * fy, ny + s * fx
    fx, fy, fz = (
        o[0] * fx + o[1] * fy + o[2] * fz,
        o[3] * fx + o[4] * fy + o[5] * fz,
        o[6] * fx + o[7] * fy + o[8] * fz,
    )
    nx, ny, nz = (
        o[0] * nx + o[1] * ny + o[2] * nz,
        o[3] * nx + o[4] * ny + o[5] * nz,
        o[6] * nx + o[7] * ny + o[8] * nz,
    )
    mx, my, mz = cross(o[9], o[10], o[11], fx, fy, fz)
    return fx, fy, fz, nx + mx, ny + my, nz + mz
