"""Forward kinematics and Jacobian at many joint vectors, compiled.

The vectors are worked on in blocks of `BLOCK`. A block is one flat array in which each number of
the running transform has `BLOCK` places of its own, one a vector (structure of arrays): "row" r is
the places from r BLOCK on. The inner loops run over whole rows, of a length that is known when
they are compiled, which is what lets them become vector instructions; where the last block is not
full, they work on what the block before left there.

Rows 0 to 8 hold the rotation row-major, rows 9 to 11 the translation, rows 12 and 13 sine and
cosine of the joint at hand (its position, and nothing, where it slides).
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .sine_kernel import LARGEST, sincos

BLOCK = 64
"""Joint vectors worked on at a time, so that all of a block stays in the nearest cache."""

ROWS = 14
"""Rows of the running transform."""


@fast_kernel
def fk_batch_into(O: FloatArray, Q: FloatArray, out: FloatArray) -> None:
    """Write T_base_tool, shape (m, 4, 4), at joint vectors ``Q``, shape (m, n)."""
    m, n = Q.shape
    W = np.zeros(ROWS * BLOCK)
    for start in range(0, m, BLOCK):
        width = min(BLOCK, m - start)
        begin(W)
        for k in range(n):
            load(O[k, 12], Q[start : start + width, k], W)
            move(O[k], W)
        step(O[n], W)
        for i in range(width):
            _store(W, i, out[start + i])


@fast_kernel
def frames_batch_into(O: FloatArray, L: FloatArray, Q: FloatArray, out: FloatArray) -> None:
    """Write the pose of each link frame, shape (m, n, 4, 4).

    ``L``, shape (n, 12), is each link frame in its moved joint frame, laid out as rows of O are.
    """
    m, n = Q.shape
    W, V = np.zeros(ROWS * BLOCK), np.zeros(ROWS * BLOCK)
    for start in range(0, m, BLOCK):
        width = min(BLOCK, m - start)
        begin(W)
        for k in range(n):
            load(O[k, 12], Q[start : start + width, k], W)
            move(O[k], W)
            for i in range(12 * BLOCK):
                V[i] = W[i]
            step(L[k], V)
            for i in range(width):
                _store(V, i, out[start + i, k])


@fast_kernel
def jacobian_batch_into(O: FloatArray, Q: FloatArray, out: FloatArray) -> None:
    """Write the Jacobian in base, shape (m, 6, n), at joint vectors ``Q``, shape (m, n)."""
    m, n = Q.shape
    W = np.zeros(ROWS * BLOCK)
    J = np.zeros((n, 6 * BLOCK))
    for start in range(0, m, BLOCK):
        width = min(BLOCK, m - start)
        begin(W)
        for k in range(n):
            load(O[k, 12], Q[start : start + width, k], W)
            move(O[k], W)
            _keep(W, J[k])
        step(O[n], W)
        for k in range(n):
            _column(O[k, 12], W, J[k])
        for i in range(width):
            for r in range(6):
                for k in range(n):
                    out[start + i, r, k] = J[k, r * BLOCK + i]


@fast_kernel
def begin(W: FloatArray) -> None:
    """Write the identity for every vector of a block."""
    W[: 12 * BLOCK] = 0.0
    W[:BLOCK] = 1.0
    W[4 * BLOCK : 5 * BLOCK] = 1.0
    W[8 * BLOCK : 9 * BLOCK] = 1.0


@fast_kernel
def load(kind: float, q: FloatArray, W: FloatArray) -> None:
    """Write sine and cosine of a joint's positions in a block, or the positions if it slides."""
    largest = 0.0
    for i in range(q.shape[0]):
        W[12 * BLOCK + i] = q[i]
        largest = max(largest, abs(q[i]))
    if kind != 0.0:
        return
    if largest < LARGEST:
        for i in range(BLOCK):
            W[12 * BLOCK + i], W[13 * BLOCK + i] = sincos(W[12 * BLOCK + i])
    else:
        for i in range(q.shape[0]):
            W[12 * BLOCK + i], W[13 * BLOCK + i] = math.sin(q[i]), math.cos(q[i])


@fast_kernel
def move(o: FloatArray, W: FloatArray) -> None:
    """Carry a block of transforms through one constant transform and the motion of its joint."""
    if o[12] != 0.0:
        step(o, W)
        for i in range(BLOCK):
            slid = W[12 * BLOCK + i]
            W[9 * BLOCK + i] += slid * W[2 * BLOCK + i]
            W[10 * BLOCK + i] += slid * W[5 * BLOCK + i]
            W[11 * BLOCK + i] += slid * W[8 * BLOCK + i]
        return
    o0, o1, o2, o3, o4, o5, o6, o7, o8 = o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], o[8]
    px, py, pz = o[9], o[10], o[11]
    for i in range(BLOCK):
        s, c = W[12 * BLOCK + i], W[13 * BLOCK + i]
        for r in range(3):
            row = 3 * r * BLOCK + i
            x, y, z = W[row], W[row + BLOCK], W[row + 2 * BLOCK]
            W[(9 + r) * BLOCK + i] += x * px + y * py + z * pz
            u, v = x * o0 + y * o3 + z * o6, x * o1 + y * o4 + z * o7
            W[row] = u * c + v * s
            W[row + BLOCK] = v * c - u * s
            W[row + 2 * BLOCK] = x * o2 + y * o5 + z * o8


@fast_kernel
def step(o: FloatArray, W: FloatArray) -> None:
    """Carry a block of transforms through one constant transform."""
    o0, o1, o2, o3, o4, o5, o6, o7, o8 = o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], o[8]
    px, py, pz = o[9], o[10], o[11]
    for i in range(BLOCK):
        for r in range(3):
            row = 3 * r * BLOCK + i
            x, y, z = W[row], W[row + BLOCK], W[row + 2 * BLOCK]
            W[(9 + r) * BLOCK + i] += x * px + y * py + z * pz
            W[row] = x * o0 + y * o3 + z * o6
            W[row + BLOCK] = x * o1 + y * o4 + z * o7
            W[row + 2 * BLOCK] = x * o2 + y * o5 + z * o8


@fast_kernel
def _store(W: FloatArray, i: int, T: FloatArray) -> None:
    """Write one transform of a block, shape (4, 4)."""
    for r in range(3):
        T[r, 0] = W[3 * r * BLOCK + i]
        T[r, 1] = W[(3 * r + 1) * BLOCK + i]
        T[r, 2] = W[(3 * r + 2) * BLOCK + i]
        T[r, 3] = W[(9 + r) * BLOCK + i]
    T[3, 0], T[3, 1], T[3, 2], T[3, 3] = 0.0, 0.0, 0.0, 1.0


@fast_kernel
def _keep(W: FloatArray, J: FloatArray) -> None:
    """Write the origin (rows 0 to 2) and axis (rows 3 to 5) of the joint the block stands at."""
    for i in range(3 * BLOCK):
        J[i] = W[9 * BLOCK + i]
    for i in range(BLOCK):
        J[3 * BLOCK + i] = W[2 * BLOCK + i]
        J[4 * BLOCK + i] = W[5 * BLOCK + i]
        J[5 * BLOCK + i] = W[8 * BLOCK + i]


@fast_kernel
def _column(kind: float, W: FloatArray, J: FloatArray) -> None:
    """Make the columns of a joint of its origins and axes in ``J`` and the tool points."""
    if kind != 0.0:
        for i in range(3 * BLOCK):
            J[i] = J[3 * BLOCK + i]
            J[3 * BLOCK + i] = 0.0
        return
    for i in range(BLOCK):
        x = W[9 * BLOCK + i] - J[i]
        y = W[10 * BLOCK + i] - J[BLOCK + i]
        z = W[11 * BLOCK + i] - J[2 * BLOCK + i]
        ax, ay, az = J[3 * BLOCK + i], J[4 * BLOCK + i], J[5 * BLOCK + i]
        J[i] = ay * z - az * y
        J[BLOCK + i] = az * x - ax * z
        J[2 * BLOCK + i] = ax * y - ay * x
