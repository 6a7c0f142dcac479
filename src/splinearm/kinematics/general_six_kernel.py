"""All branches of six turning joints of any kind: eigenvalues, then steps that polish.

D. Manocha and J. Canny, Efficient inverse kinematics for general 6R manipulators, IEEE
Transactions on Robotics and Automation 10, 1994: where the matrix of module pencil_kernel is
singular is an eigenvalue problem of 24 rows. What lies near the real line is taken for a joint
angle; the other five follow linearly; steps of least squares bring the joints to the pose, and
what does not get there was none. An arm comes as one array ``G``: rows 0 to 12 as in module
six_kernel, row 13 six shifts, and a row for each of the ways that serve it, the best first.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .eigenvalue_kernel import eigenvalues, eliminate, triangulate
from .pencil_kernel import EQUATIONS, SIZE, joint_of, pencil, three_joints, turned
from .subproblem_kernel import inverse, product, wrap

MOST = 16
"""The most branches of six turning joints (E. Primrose, 1986)."""
WAYS = 14
"""The first row with a way."""

_OFF = 0.05
_FLAT = 1e-12
_STEPS = 40
_TWO = 1e-5
_SAME = 1e-6
_ROOM = 96
_STARTS = 64
_SINGULAR = 1e-7
"""Below this regularity eigenvalues that find nothing say nothing."""
_GOLDEN = 1.0 / 1.1127756842787055


@kernel
def enter(G: FloatArray, T: FloatArray, K: FloatArray, B: FloatArray) -> None:
    """Give the constants of the loop and the pose of the last row's frame in the first's."""
    A = np.empty((3, 4))
    product(G[6:9], T, A)
    product(A, G[9:12], B)
    for k in range(5):
        a, d, ca, sa = G[k, 0], G[k, 1], G[k, 2], G[k, 3]
        K[k, 0, 0], K[k, 0, 1], K[k, 0, 2], K[k, 0, 3] = 1.0, 0.0, 0.0, a
        K[k, 1, 0], K[k, 1, 1], K[k, 1, 2], K[k, 1, 3] = 0.0, ca, -sa, 0.0
        K[k, 2, 0], K[k, 2, 1], K[k, 2, 2], K[k, 2, 3] = 0.0, sa, ca, d
    inverse(B, K[5])


@kernel
def spectrum(M: FloatArray, real: FloatArray, imaginary: FloatArray) -> float:
    """Give the half angles' tangents where ``M`` is singular; and how regular the problem is."""
    A, C = np.empty((SIZE, SIZE)), np.empty((SIZE, 2 * SIZE))
    for i in range(SIZE):
        for j in range(SIZE):
            A[i, j] = M[2, i, j]
            C[i, j], C[i, SIZE + j] = -M[0, i, j], -M[1, i, j]
    regular = eliminate(A, C)
    if not regular > _FLAT:
        return 0.0
    L = np.zeros((2 * SIZE, 2 * SIZE))
    for i in range(SIZE):
        L[i, SIZE + i] = 1.0
        for j in range(2 * SIZE):
            L[SIZE + i, j] = C[i, j]
    eigenvalues(L, real, imaginary)
    return regular


@kernel
def _monomials(M: FloatArray, half: float, y: FloatArray, z: FloatArray) -> int:
    """Give tangents of the half angles of the other two joints where one has ``half`` an angle."""
    u, v = math.cos(half), math.sin(half)
    S, Q, order = np.empty((SIZE, SIZE)), np.empty((SIZE, SIZE)), np.empty(SIZE)
    for i in range(SIZE):
        for j in range(SIZE):
            # columns, so that what is left over at the end of the triangle is the null space
            S[i, j] = M[0, i, j] * u * u + M[1, i, j] * u * v + M[2, i, j] * v * v
    triangulate(S, Q, order)
    two = 2 if abs(S[SIZE - 2, SIZE - 2]) < _TWO * abs(S[0, 0]) else 1
    V = np.zeros((SIZE, 2))
    for c in range(two):
        x = np.zeros(SIZE)
        x[SIZE - 1 - c] = 1.0
        for i in range(SIZE - two - 1, -1, -1):
            total = 0.0
            for j in range(i + 1, SIZE):
                total += S[i, j] * x[j]
            x[i] = -total / S[i, i]
        for i in range(SIZE):
            V[int(order[i]), c] = x[i]
    if two == 1:
        y[0], z[0] = _ratio(V[:, 0], 3), _ratio(V[:, 0], 1)
        return 1
    return _pair(V, y, z)


@kernel
def _ratio(m: FloatArray, step: int) -> float:
    """Give the ratio of monomials one power apart: 3 for the one tangent, 1 for the other."""
    top, bottom = 0.0, 1e-300
    for i in range(SIZE - step):
        if step == 3 or i % 3 != 2:
            top += m[i + step] * m[i]
            bottom += m[i] * m[i]
    return top / bottom


@kernel
def _pair(V: FloatArray, y: FloatArray, z: FloatArray) -> int:
    """Tell two answers with one angle in common apart: V (12, 2) spans their monomials."""
    # least squares for V[3:] = V[:9] B, whose eigenvalues are the tangents
    a, b, c = 0.0, 0.0, 0.0
    r = np.zeros((2, 2))
    for i in range(SIZE - 3):
        a += V[i, 0] * V[i, 0]
        b += V[i, 0] * V[i, 1]
        c += V[i, 1] * V[i, 1]
        for j in range(2):
            r[0, j] += V[i, 0] * V[i + 3, j]
            r[1, j] += V[i, 1] * V[i + 3, j]
    det = a * c - b * b
    if det == 0.0:
        return 0
    b00, b01 = (c * r[0, 0] - b * r[1, 0]) / det, (c * r[0, 1] - b * r[1, 1]) / det
    b10, b11 = (a * r[1, 0] - b * r[0, 0]) / det, (a * r[1, 1] - b * r[0, 1]) / det
    middle = 0.5 * (b00 + b11)
    way = math.sqrt(max(middle * middle - (b00 * b11 - b01 * b10), 0.0))
    m = np.empty(SIZE)
    for k in range(2):
        y[k] = middle + (way if k else -way)
        p, q = b01, y[k] - b00
        if abs(p) + abs(q) < abs(b10) + abs(y[k] - b11):
            p, q = y[k] - b11, b10
        for i in range(SIZE):
            m[i] = V[i, 0] * p + V[i, 1] * q
        z[k] = _ratio(m, 1)
    return 2


@kernel
def _rest(
    K: FloatArray,
    way: FloatArray,
    shifts: FloatArray,
    R: FloatArray,
    Q: FloatArray,
    N: FloatArray,
    order: FloatArray,
    t: FloatArray,
    angles: FloatArray,
) -> None:
    """Give all six angles from those of the three joints, which are ``t``."""
    ahead = way[1] != 0.0
    three, two = (0, 3) if ahead else (2, 0)
    values = np.empty(EQUATIONS)
    three_joints(K, way, t[0], t[1], t[2], values)
    x, m = np.zeros(8), np.zeros(8)
    for i in range(7, -1, -1):
        total = 0.0
        for r in range(EQUATIONS):
            total += N[r, i] * (values[r] - R[0, 0, r])
        for j in range(i + 1, 8):
            total -= Q[i, j] * x[j]
        if abs(Q[i, i]) > _SAME * abs(Q[0, 0]):
            x[i] = total / Q[i, i]
    for i in range(8):
        m[int(order[i])] = x[i]
    j0, j1 = joint_of(way, two), joint_of(way, two + 1)
    angles[j0] = shifts[j0] + math.atan2(m[5], m[2])
    angles[j1] = shifts[j1] + math.atan2(m[1], m[0])
    for k in range(3):
        angles[joint_of(way, three + k)] = t[k]
    X, Y, Z = np.empty((3, 4)), np.empty((3, 4)), np.empty((3, 4))
    turned(angles[joint_of(way, 0)], K[joint_of(way, 0)], X)
    for k in range(1, 5):
        turned(angles[joint_of(way, k)], K[joint_of(way, k)], Y)
        product(X, Y, Z)
        X, Z = Z, X
    # behind these five the last joint closes the loop: X Rz K = 1
    product(K[int(way[0])], X, Y)
    angles[int(way[0])] = math.atan2(Y[0, 1] - Y[1, 0], Y[0, 0] + Y[1, 1])


@kernel
def _miss(G: FloatArray, B: FloatArray, angles: FloatArray, e: FloatArray, J: FloatArray) -> float:
    """Give how far joint angles are from the pose; as a twist in ``e``, with the Jacobian ``J``."""
    X, Y, S = np.zeros((3, 4)), np.empty((3, 4)), np.empty((3, 4))
    for i in range(3):
        X[i, i] = 1.0
    n = len(angles)
    for k in range(n):
        for i in range(3):
            J[i, k], J[3 + i, k] = X[i, 3], X[i, 2]
        a, d, ca, sa = G[k, 0], G[k, 1], G[k, 2], G[k, 3]
        c, s = math.cos(angles[k]), math.sin(angles[k])
        S[0, 0], S[0, 1], S[0, 2], S[0, 3] = c, -s * ca, s * sa, a * c
        S[1, 0], S[1, 1], S[1, 2], S[1, 3] = s, c * ca, -c * sa, a * s
        S[2, 0], S[2, 1], S[2, 2], S[2, 3] = 0.0, sa, ca, d
        product(X, S, Y)
        X, Y = Y, X
    off = 0.0
    for i in range(3):
        for j in range(4):
            off += abs(X[i, j] - B[i, j])
        e[i] = B[i, 3] - X[i, 3]
        e[3 + i] = 0.0
        for j in range(3):
            y, z = (i + 1) % 3, (i + 2) % 3
            e[3 + i] += 0.5 * (X[y, j] * B[z, j] - X[z, j] * B[y, j])
    for k in range(n):
        x, y, z = X[0, 3] - J[0, k], X[1, 3] - J[1, k], X[2, 3] - J[2, k]
        J[0, k] = J[4, k] * z - J[5, k] * y
        J[1, k] = J[5, k] * x - J[3, k] * z
        J[2, k] = J[3, k] * y - J[4, k] * x
    return off


@kernel
def polish(G: FloatArray, B: FloatArray, angles: FloatArray) -> float:
    """Bring joint angles to the pose by damped steps of least squares; give what is missed."""
    e, J, tried = np.empty(6), np.empty((6, 6)), np.empty(6)
    A, x = np.empty((6, 6)), np.empty((6, 1))
    n = len(angles)
    size = (G[12, 3] * 1e9) ** 2
    off = _miss(G, B, angles, e, J)
    damping = 1e-14 + 1e-3 * min(off, 1.0) ** 2
    for _ in range(_STEPS):
        if off < 1e-5 * G[12, 3]:
            break
        for i in range(n):
            x[i, 0] = 0.0
            for r in range(n):
                x[i, 0] += J[r, i] * e[r] * (1.0 if r < 3 else size)
            for j in range(n):
                total = damping * size if i == j else 0.0
                for r in range(n):
                    total += J[r, i] * J[r, j] * (1.0 if r < 3 else size)
                A[i, j] = total
        eliminate(A, x)
        for i in range(n):
            tried[i] = angles[i] + min(max(x[i, 0], -0.5), 0.5)
        now = _miss(G, B, tried, e, J)
        if now < off:
            # what no longer gets smaller has arrived
            end = now > 0.5 * off and now < 1e-3 * G[12, 3]
            for i in range(n):
                angles[i] = tried[i]
            off, damping = now, 0.05 * damping + 1e-16
            if end:
                break
        else:
            if off < 1e-2 * G[12, 3] or damping > 1.0:
                break
            damping = 10.0 * damping + 1e-10
            _miss(G, B, angles, e, J)
    return off


@kernel
def _add(G: FloatArray, angles: FloatArray, q: FloatArray, n: int) -> int:
    """Add joint angles to the answers unless they are there; give their number."""
    if n == len(q):
        return n
    for k in range(6):
        q[n, k] = wrap(G[k, 5] * (angles[k] - G[k, 4]))
    for i in range(n):
        apart = 0.0
        for k in range(6):
            apart = max(apart, abs(math.sin(0.5 * (q[i, k] - q[n, k]))))
        if apart < _SAME:
            return n
    return n + 1


@kernel
def _along(
    G: FloatArray,
    way: FloatArray,
    K: FloatArray,
    B: FloatArray,
    q: FloatArray,
    n: int,
    least: FloatArray,
) -> int:
    """Add the answers that one way finds; give their number, and in ``least`` how regular it is."""
    shifts = G[13]
    M, R = np.empty((3, SIZE, SIZE)), np.empty((3, 3, EQUATIONS))
    Q, N, order = np.empty((EQUATIONS, 8)), np.empty((EQUATIONS, EQUATIONS)), np.empty(8)
    pencil(K, way, shifts, M, R, Q, N, order)
    real, imaginary = np.empty(2 * SIZE), np.empty(2 * SIZE)
    regular = spectrum(M, real, imaginary)
    least[0] = min(least[0], regular)
    if regular == 0.0:
        return n
    y, z, t, angles = np.empty(2), np.empty(2), np.empty(3), np.empty(6)
    which, other = int(way[2]), int(way[3])
    third, first = 3 - which - other, 0 if way[1] != 0.0 else 2
    for i in range(2 * SIZE):
        x, over = real[i], imaginary[i]
        # how far it is from the real line, as an angle
        if not 0.0 <= over <= _OFF * (1.0 + x * x):
            continue
        half = math.atan(x)
        for k in range(_monomials(M, half, y, z)):
            t[which] = shifts[joint_of(way, first + which)] + 2.0 * half
            t[other] = shifts[joint_of(way, first + other)] + 2.0 * math.atan(y[k])
            t[third] = shifts[joint_of(way, first + third)] + 2.0 * math.atan(z[k])
            _rest(K, way, shifts, R, Q, N, order, t, angles)
            if polish(G, B, angles) < G[12, 3]:
                n = _add(G, angles, q, n)
    return n


@kernel
def regularity(G: FloatArray, T: FloatArray, ways: FloatArray, worst: FloatArray) -> None:
    """Give in ``worst`` (k) how far from singular throughout ways (k, 4) stay on poses (m, 4, 4).

    The measure is the smallest pivot over the largest.
    """
    K, B = np.empty((6, 3, 4)), np.empty((3, 4))
    M, R, C = np.empty((3, SIZE, SIZE)), np.empty((3, 3, EQUATIONS)), np.zeros((SIZE, 1))
    Q, N, order = np.empty((EQUATIONS, 8)), np.empty((EQUATIONS, EQUATIONS)), np.empty(8)
    for k in range(len(ways)):
        worst[k] = np.inf
    for i in range(len(T)):
        enter(G, T[i], K, B)
        for k in range(len(ways)):
            pencil(K, ways[k], G[13], M, R, Q, N, order)
            worst[k] = min(worst[k], eliminate(M[2], C))


@kernel
def _from_starts(G: FloatArray, B: FloatArray, q: FloatArray, n: int) -> int:
    """Add the answers that steps from places all over the joints' turns lead to."""
    angles = np.empty(6)
    for i in range(_STARTS):
        for k in range(6):
            # an additive recurrence: M. Roberts, The unreasonable effectiveness of quasirandom
            # sequences, 2018; the number is the root of x^7 = x + 1
            angles[k] = 2.0 * math.pi * ((0.5 + i * _GOLDEN ** (k + 1)) % 1.0)
        if polish(G, B, angles) < G[12, 3]:
            n = _add(G, angles, q, n)
    return n


@kernel
def _all(G: FloatArray, T: FloatArray, seed: FloatArray, q: FloatArray) -> int:
    """Give all branches of a pose in ``q`` and their number."""
    K, B, angles = np.empty((6, 3, 4)), np.empty((3, 4)), np.empty(6)
    least = np.empty(1)
    least[0] = np.inf
    enter(G, T, K, B)
    n = 0
    for i in range(WAYS, len(G)):
        # eigenvalues that lie together lose digits, but seldom along two ways at once
        n = _along(G, G[i, :4], K, B, q, n, least)
    # where joints are free, eigenvalues say nothing of them: they keep to the seed
    for k in range(6):
        angles[k] = G[k, 4] + G[k, 5] * seed[k]
    if polish(G, B, angles) < G[12, 3]:
        n = _add(G, angles, q, n)
    if n == 0 and least[0] < _SINGULAR:
        n = _from_starts(G, B, q, n)
    return n


@kernel
def solve_batch(
    G: FloatArray, T: FloatArray, seed: FloatArray, q: FloatArray, count: FloatArray
) -> None:
    """Give all branches of poses (m, 4, 4): in ``q`` (m, 16, 6), how many in ``count`` (m,)."""
    room = np.empty((_ROOM, 6))
    for k in range(len(T)):
        n = min(_all(G, T[k], seed, room), len(q[k]))
        for i in range(len(q[k])):
            for j in range(6):
                q[k, i, j] = room[i, j] if i < n else np.nan
        count[k] = n


def solve(G: FloatArray, T: FloatArray, seed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give all branches of a pose T_base_tool, shape (4, 4).

    Returns:
        Joint positions, shape (m, 6), rad, and the number of each branch, shape (m,).
    """
    q, count = np.empty((1, MOST, 6)), np.empty(1)
    solve_batch(G, T[None], seed, q, count)
    n = int(count[0])
    return q[0, :n], np.arange(n, dtype=np.float64)
