"""Forward kinematics and Jacobian at one joint vector, compiled; see `packed` for the array O.

Each function answers whether it has: False where the arrays do not fit the arm or a joint
position is not finite, and what it wrote is then not to be used.
"""

import math
from typing import TypeAlias

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel
from splinearm.direct import MODEL, WRITE, answer, matrix, vector

from .sine_kernel import sine_and_cosine

Sweep: TypeAlias = tuple[
    bool, float, float, float, float, float, float, float, float, float, float, float, float
]
"""Whether a sweep over the joints has got through, and twelve numbers: position, then rotation."""


@fast_kernel
def fk_into(O: FloatArray, q: FloatArray, T: FloatArray) -> bool:
    """Write T_base_tool, shape (4, 4), at joint vector ``q``, shape (n,)."""
    n = O.shape[0] - 1
    if q.shape[0] != n or T.shape[0] != 4 or T.shape[1] != 4:
        return False
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    px, py, pz = 0.0, 0.0, 0.0
    for k in range(n):
        o = joint(O, k)
        px, py, pz = (
            px + (xx * o[9] + xy * o[10] + xz * o[11]),
            py + (yx * o[9] + yy * o[10] + yz * o[11]),
            pz + (zx * o[9] + zy * o[10] + zz * o[11]),
        )
        xx, xy, xz = _row(o, xx, xy, xz)
        yx, yy, yz = _row(o, yx, yy, yz)
        zx, zy, zz = _row(o, zx, zy, zz)
        angle = q[k]
        if not abs(angle) < math.inf:
            return False
        if o[12] == 0.0:
            s, c = sine_and_cosine(angle)
            xx, xy = xx * c + xy * s, xy * c - xx * s
            yx, yy = yx * c + yy * s, yy * c - yx * s
            zx, zy = zx * c + zy * s, zy * c - zx * s
        else:
            px, py, pz = px + angle * xz, py + angle * yz, pz + angle * zz
    o = joint(O, n)
    T[0, 3] = px + (xx * o[9] + xy * o[10] + xz * o[11])
    T[1, 3] = py + (yx * o[9] + yy * o[10] + yz * o[11])
    T[2, 3] = pz + (zx * o[9] + zy * o[10] + zz * o[11])
    T[0, 0], T[0, 1], T[0, 2] = _row(o, xx, xy, xz)
    T[1, 0], T[1, 1], T[1, 2] = _row(o, yx, yy, yz)
    T[2, 0], T[2, 1], T[2, 2] = _row(o, zx, zy, zz)
    T[3, 0], T[3, 1], T[3, 2], T[3, 3] = 0.0, 0.0, 0.0, 1.0
    return True


@fast_kernel
def fk_and_jacobian_into(O: FloatArray, q: FloatArray, T: FloatArray, J: FloatArray) -> bool:
    """Write T_base_tool, shape (4, 4), and the Jacobian in base, shape (6, n)."""
    if T.shape[0] != 4 or T.shape[1] != 4:
        return False
    done, px, py, pz, xx, xy, xz, yx, yy, yz, zx, zy, zz = _sweep(O, q, J)
    o = joint(O, O.shape[0] - 1)
    T[0, 0], T[0, 1], T[0, 2] = _row(o, xx, xy, xz)
    T[1, 0], T[1, 1], T[1, 2] = _row(o, yx, yy, yz)
    T[2, 0], T[2, 1], T[2, 2] = _row(o, zx, zy, zz)
    T[0, 3], T[1, 3], T[2, 3] = px, py, pz
    T[3, 0], T[3, 1], T[3, 2], T[3, 3] = 0.0, 0.0, 0.0, 1.0
    return done


@fast_kernel
def jacobian_into(O: FloatArray, q: FloatArray, J: FloatArray) -> bool:
    """Write the Jacobian in base, shape (6, n)."""
    return _sweep(O, q, J)[0]


@fast_kernel
def _sweep(O: FloatArray, q: FloatArray, J: FloatArray) -> Sweep:
    """Write the Jacobian and give the tool point and the rotation behind the last joint."""
    n = O.shape[0] - 1
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    px, py, pz = 0.0, 0.0, 0.0
    if q.shape[0] != n or J.shape[0] != 6 or J.shape[1] != n:
        return False, px, py, pz, xx, xy, xz, yx, yy, yz, zx, zy, zz
    finite = True
    for k in range(n):
        o = joint(O, k)
        px, py, pz = (
            px + (xx * o[9] + xy * o[10] + xz * o[11]),
            py + (yx * o[9] + yy * o[10] + yz * o[11]),
            pz + (zx * o[9] + zy * o[10] + zz * o[11]),
        )
        xx, xy, xz = _row(o, xx, xy, xz)
        yx, yy, yz = _row(o, yx, yy, yz)
        zx, zy, zz = _row(o, zx, zy, zz)
        # the joint's origin and axis wait here until the tool point is known
        J[0, k], J[1, k], J[2, k] = px, py, pz
        J[3, k], J[4, k], J[5, k] = xz, yz, zz
        angle = q[k]
        if not abs(angle) < math.inf:
            finite = False
            break
        if o[12] == 0.0:
            s, c = sine_and_cosine(angle)
            xx, xy = xx * c + xy * s, xy * c - xx * s
            yx, yy = yx * c + yy * s, yy * c - yx * s
            zx, zy = zx * c + zy * s, zy * c - zx * s
        else:
            px, py, pz = px + angle * xz, py + angle * yz, pz + angle * zz
    o = joint(O, n)
    px, py, pz = (
        px + (xx * o[9] + xy * o[10] + xz * o[11]),
        py + (yx * o[9] + yy * o[10] + yz * o[11]),
        pz + (zx * o[9] + zy * o[10] + zz * o[11]),
    )
    if finite:
        for k in range(n):
            ax, ay, az = J[3, k], J[4, k], J[5, k]
            if O[k, 12] == 0.0:
                lx, ly, lz = px - J[0, k], py - J[1, k], pz - J[2, k]
                # Siciliano et al., Robotics: Modelling, Planning and Control, 2009, eq. 3.30
                J[0, k], J[1, k], J[2, k] = ay * lz - az * ly, az * lx - ax * lz, ax * ly - ay * lx
            else:
                J[0, k], J[1, k], J[2, k] = ax, ay, az
                J[3, k], J[4, k], J[5, k] = 0.0, 0.0, 0.0
    return finite, px, py, pz, xx, xy, xz, yx, yy, yz, zx, zy, zz


@fast_kernel
def joint(O: FloatArray, k: int) -> tuple[float, ...]:
    """Give what stands before joint k and its kind as numbers: a view would be counted."""
    return (
        O[k, 0],
        O[k, 1],
        O[k, 2],
        O[k, 3],
        O[k, 4],
        O[k, 5],
        O[k, 6],
        O[k, 7],
        O[k, 8],
        O[k, 9],
        O[k, 10],
        O[k, 11],
        O[k, 12],
    )


@fast_kernel
def _row(o: tuple[float, ...], x: float, y: float, z: float) -> tuple[float, float, float]:
    """Give one row of a rotation times the constant rotation in ``o``."""
    return (
        x * o[0] + y * o[3] + z * o[6],
        x * o[1] + y * o[4] + z * o[7],
        x * o[2] + y * o[5] + z * o[8],
    )


def fk_call(model: int, arguments: int, count: int) -> int:
    """Do as `fk_into` does with (q, T), for the arm it is bound to; see `direct.bind`."""
    given = model, arguments
    return answer(
        count == 2 and fk_into(matrix(given, MODEL), vector(given, 0), matrix(given, 1, WRITE))
    )


def jacobian_call(model: int, arguments: int, count: int) -> int:
    """Do as `jacobian_into` does with (q, J), for the arm it is bound to."""
    given = model, arguments
    return answer(
        count == 2
        and jacobian_into(matrix(given, MODEL), vector(given, 0), matrix(given, 1, WRITE))
    )
