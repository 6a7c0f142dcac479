"""All branches of six turning joints, from pose to joint positions: single and batch.

An arm comes as one array ``G``, shape (13, 6), made by module structure: rows 0 to 5 a, d,
cos(alpha), sin(alpha), offset and sign of each joint; rows 6 to 8 and 9 to 11 the inverses of
``first`` and ``last``; row 12 the class, the kind of base, whether the chain runs from the tool to
the base, and the tolerance.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel, kernel

from .angle_kernel import arctan2
from .parallel_kernel import ur
from .six_block_kernel import ANGLES, WIDTH, enter, shoulder, spherical, three_parallel
from .subproblem_kernel import inverse, product, wrap
from .wrist_kernel import centre, orient, place

SPHERICAL = 0.0
PARALLEL = 1.0
MOST = 8
"""The most branches that these classes have."""
_ROWS = 16
_WIDTH = 14


@kernel
def _branches(
    G: FloatArray,
    T: FloatArray,
    seed: FloatArray,
    work: FloatArray,
    A: FloatArray,
    B: FloatArray,
    angles: FloatArray,
) -> int:
    """Give rows of cosines and sines in ``work`` (16, 14); A, B (3, 4) and angles (6) are room."""
    reverse = G[12, 2] != 0.0
    for k in range(6):
        angles[k] = G[k, 4] + G[k, 5] * seed[5 - k if reverse else k]
    if reverse:
        inverse(T, B)
        product(G[6:9], B, A)
    else:
        product(G[6:9], T, A)
    product(A, G[9:12], B)
    if G[12, 0] == SPHERICAL:
        wx, wy, wz = centre(G)
        found = place(G, int(G[12, 1]), wx, wy, wz, B, angles, work)
        return orient(G, B, angles, work, found, G[12, 3])
    return ur(G, B, angles, work, G[12, 3])


@kernel
def _angles(G: FloatArray, row: FloatArray, q: FloatArray) -> None:
    reverse = G[12, 2] != 0.0
    for k in range(6):
        angle = arctan2(row[2 * k + 1], row[2 * k])
        q[5 - k if reverse else k] = wrap(G[k, 5] * (angle - G[k, 4]))


@fast_kernel
def _directions(X: FloatArray, Y: FloatArray, size: int) -> None:
    """Put the angles of directions (X, Y) in place of X."""
    for i in range(size):
        X[i] = arctan2(Y[i], X[i])


@kernel
def _solve(
    G: FloatArray, T: FloatArray, seed: FloatArray, q: FloatArray, code: FloatArray, first: int
) -> int:
    """Give the number of branches; joint positions in ``q`` (8, ...) from column ``first`` on."""
    work, room = np.empty((_ROWS, _WIDTH)), np.empty(126)
    A, B = room[:12].reshape(3, 4), room[12:24].reshape(3, 4)
    X, Y = room[30:78], room[78:126]
    n = 0
    for i in range(_branches(G, T, seed, work, A, B, room[24:30])):
        row = work[i]
        if row[13] == 0.0:
            for k in range(6):
                X[6 * n + k], Y[6 * n + k] = row[2 * k], row[2 * k + 1]
            code[n] = row[12]
            n += 1
    _directions(X, Y, 6 * n)
    reverse = G[12, 2] != 0.0
    for k in range(6):
        to = first + (5 - k if reverse else k)
        offset, sign = G[k, 4], G[k, 5]
        for i in range(n):
            q[i, to] = wrap(sign * (X[6 * i + k] - offset))
    return n


@kernel
def solve(G: FloatArray, T: FloatArray, seed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give all branches of a pose T_base_tool, shape (4, 4).

    Returns:
        Joint positions, shape (m, 6), rad, and what branches they are, shape (m,). A branch counts
        only if forward kinematics from its cosines and sines gives the pose back.
    """
    q, code = np.empty((MOST, 6)), np.empty(MOST)
    n = _solve(G, T, seed, q, code, 0)
    return q[:n], code[:n]


@kernel
def solve_given(
    G: FloatArray, T: FloatArray, seed: FloatArray, still: FloatArray, given: float, last: bool
) -> tuple[FloatArray, FloatArray]:
    """Give all branches of seven joints, the first or last of them given, as ``solve`` does.

    ``G`` is the arm of the other six; ``still``, shape (4, 4), the inverse of the constant
    transform at the end of the given joint: behind it if it is the ``last``, else before it.
    """
    c, s = math.cos(given), math.sin(given)
    room = np.empty((6, 4))
    B, T6 = room[:3], room[3:]
    if last:
        product(T, still, B)
        # times Rz(-given)
        for i in range(3):
            x, y = B[i, 0], B[i, 1]
            T6[i, 0], T6[i, 1], T6[i, 2], T6[i, 3] = c * x - s * y, c * y + s * x, B[i, 2], B[i, 3]
    else:
        product(still, T, B)
        for j in range(4):
            x, y = B[0, j], B[1, j]
            T6[0, j], T6[1, j], T6[2, j] = c * x + s * y, c * y - s * x, B[2, j]
    q, code = np.empty((MOST, 7)), np.empty(MOST)
    first = 0 if last else 1
    n = _solve(G, T6, seed[first : first + 6], q, code, first)
    for i in range(n):
        q[i, 6 if last else 0] = given
    return q[:n], code[:n]


@fast_kernel
def _turned(
    X: FloatArray, Y: FloatArray, width: int, offset: float, sign: float, rows: slice
) -> None:
    """Put joint positions in place of the cosines in some rows of ``X``."""
    for row in range(rows.start, rows.stop):
        for w in range(width):
            X[row, w] = wrap(sign * (arctan2(Y[row, w], X[row, w]) - offset))


@kernel
def _all_turned(G: FloatArray, X: FloatArray, Y: FloatArray, width: int) -> None:
    if G[12, 0] == SPHERICAL:
        joints, begins = (0, 1, 2, 3, 4, 5), (0, 2, 6, 10, 18, 26, 34)
    else:
        joints, begins = (0, 4, 5, 1, 2, 3), (0, 2, 6, 10, 18, 26, 34)
    for i in range(6):
        k = joints[i]
        _turned(X, Y, width, G[k, 4], G[k, 5], slice(begins[i], begins[i + 1]))


@kernel
def _in_blocks(G: FloatArray) -> bool:
    """Say whether the arm is of the kinds that module six_block_kernel solves."""
    if G[3, 2] != 0.0 or G[4, 2] != 0.0 or G[12, 2] != 0.0:
        return False
    return bool(G[12, 0] == PARALLEL or G[12, 1] == 0.0)


@kernel
def _row(spherical_wrist: bool, branch: int, joint: int) -> int:
    """Give the row of angles that a branch takes a joint from; branches as ``solve`` has them."""
    if spherical_wrist:
        wrist, arm = branch // 4, branch % 4
        if joint == 0:
            return arm // 2
        if joint < 3:
            return 4 * joint - 2 + arm
        return 8 * joint - 14 + 2 * arm + wrist
    if joint == 0:
        return branch // 4
    if joint > 3:
        return 4 * joint - 14 + branch // 2
    return 8 * joint + 2 + branch


@kernel
def _one(
    G: FloatArray,
    T: FloatArray,
    seed: FloatArray,
    work: FloatArray,
    room: FloatArray,
    q: FloatArray,
) -> int:
    """Give all branches of one pose in ``q`` (8, 6), NaN behind the last, and their number."""
    A, B = room[:2].reshape(-1).reshape(3, 4), room[2:4].reshape(-1).reshape(3, 4)
    n = 0
    for i in range(_branches(G, T, seed, work, A, B, room[4])):
        if work[i, 13] == 0.0:
            _angles(G, work[i], q[n])
            n += 1
    q[n:] = np.nan
    return n


@kernel
def solve_batch(
    G: FloatArray, T: FloatArray, seed: FloatArray, q: FloatArray, count: FloatArray
) -> None:
    """Give all branches of poses (m, 4, 4): in ``q`` (m, 8, 6), how many in ``count`` (m,)."""
    work, room = np.empty((_ROWS, _WIDTH)), np.empty((5, 6))
    if not _in_blocks(G):
        for k in range(len(T)):
            count[k] = _one(G, T[k], seed, work, room, q[k])
        return
    round_wrist = G[12, 0] == SPHERICAL
    t, v = np.empty((12, WIDTH)), np.empty((2, 3, WIDTH))
    X, Y = np.empty((ANGLES, WIDTH)), np.empty((ANGLES, WIDTH))
    miss, lost, redo = np.empty((MOST, WIDTH)), np.empty(WIDTH), np.empty(WIDTH)
    table = np.empty((MOST, 6), dtype=np.int64)
    for i in range(MOST):
        for j in range(6):
            table[i, j] = _row(round_wrist, i, j)
    height = G[1, 1] + G[2, 1] + (G[2, 2] * G[3, 1] if round_wrist else G[3, 1])
    for start in range(0, len(T), WIDTH):
        width = min(WIDTH, len(T) - start)
        enter(G, T, start, width, t)
        shoulder(G, height, width, t, X, Y, v, lost, redo)
        if round_wrist:
            spherical(G, width, t, X, Y, v, lost, redo, miss)
        else:
            three_parallel(G, width, t, X, Y, v, lost, redo, miss)
        _all_turned(G, X, Y, width)
        for w in range(width):
            k = start + w
            if redo[w] != 0.0:
                count[k] = _one(G, T[k], seed, work, room, q[k])
                continue
            n = 0
            for i in range(MOST):
                # rows of miss: arm and wrist of a spherical wrist, else branches as they come
                row = 2 * (i % 4) + i // 4 if round_wrist else i
                if miss[row, w] < G[12, 3]:
                    for j in range(6):
                        q[k, n, j] = X[table[i, j], w]
                    n += 1
            for i in range(n, MOST):
                for j in range(6):
                    q[k, i, j] = np.nan
            count[k] = n
