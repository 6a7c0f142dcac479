"""Seven turning joints with the swivel of the elbow given.

The first three axes meet in the shoulder S, the fifth and sixth in the wrist W; the elbow E is the
point of the fourth axis that is nearest to the third. The swivel is the angle, about the way from S
to W, from the half plane that holds the way and the first axis to the one that holds the way and E.

Where the wrist is known, its distance gives the fourth joint, the swivel then places the elbow, and
two times three turns remain. With all of the last three axes through W the pose alone places it.
Else it moves on a circle about the last axis: whether the angle between the fifth and sixth axis is
right is one equation in the last joint, whose zeros are looked for on a grid over the arcs that the
elbow's bend allows; beyond an end the miss goes on smoothly as that of the other elbow.

The swivel as parameter of redundancy: K. Kreutz-Delgado, M. Long and H. Seraji, Kinematic analysis
of 7-DOF manipulators, International Journal of Robotics Research 11, 1992. An arm comes as one
array ``G``, shape (14, 6), as in module six_kernel.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .elbow_kernel import angle_miss, elbows, lower, three_turns, two_turns, upper, wrist
from .subproblem_kernel import circle, product, wrap

GRID = 240
"""Places of the last joint that are tried on an arc."""
MOST = 32
"""Room for branches."""

_HALVINGS = 60
_GOLDEN = 0.3819660112501051
_SAME = 1e-6


@kernel
def _place(arc: FloatArray, t: float) -> float:
    """Give the last joint at place t of an arc; at its ends the arc turns round."""
    place: float = arc[0] + (t if arc[1] == 0.0 else -arc[1] * math.cos(t))
    return place


@kernel
def _at(P: FloatArray, B: FloatArray, arc: FloatArray, t: float, room: FloatArray) -> float:
    """Give by how much the elbow of an arc misses the angle at t; beyond its ends the other's."""
    k, swivel = int(arc[2]), arc[3]
    if arc[1] != 0.0 and (t < 0.0 or t > math.pi):
        k, swivel = 1 - k, arc[4 if t < 0.0 else 5]
    return angle_miss(P, B, swivel, _place(arc, t), k, room)


@kernel
def _zero(
    P: FloatArray,
    B: FloatArray,
    arc: FloatArray,
    ends: tuple[float, float, float, float],
    room: FloatArray,
) -> float:
    """Give a zero between two places (low, its value, high, its value) of different signs."""
    low, f_low, high, f_high = ends
    for i in range(_HALVINGS):
        t = low - f_low * (high - low) / (f_high - f_low)
        if i % 3 == 2 or not low < t < high:
            t = 0.5 * (low + high)
        f = _at(P, B, arc, t, room)
        if f == 0.0 or high - low < 4e-16:
            return t
        if f * f_low < 0.0:
            high, f_high = t, f
        else:
            low, f_low = t, f
    return 0.5 * (low + high)


@kernel
def _dip(
    P: FloatArray,
    B: FloatArray,
    arc: FloatArray,
    ends: tuple[float, float, float, float],
    room: FloatArray,
) -> tuple[float, float]:
    """Give where the miss is smallest between two places, and its value, by golden sections."""
    low, f_low, high, _ = ends
    sign = 1.0 if f_low > 0.0 else -1.0
    a, b = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    fa, fb = sign * _at(P, B, arc, a, room), sign * _at(P, B, arc, b, room)
    for _ in range(40):
        if not (fa > 0.0 and fb > 0.0):
            break
        if fa < fb:
            high, b, fb = b, a, fa
            a = low + _GOLDEN * (high - low)
            fa = sign * _at(P, B, arc, a, room)
        else:
            low, a, fa = a, b, fb
            b = high - _GOLDEN * (high - low)
            fb = sign * _at(P, B, arc, b, room)
    return (a, sign * fa) if fa < fb else (b, sign * fb)


@kernel
def _scan(
    P: FloatArray, B: FloatArray, arc: FloatArray, found: FloatArray, count: int, room: FloatArray
) -> int:
    """Add the values of the last joint that serve along an arc to ``found``; give their number."""
    whole = arc[1] == 0.0
    step = (2.0 if whole else 1.0) * math.pi / GRID
    t, f, zeros = np.empty(GRID + 4), np.empty(GRID + 4), np.empty(2)
    for i in range(GRID + 4):
        # two places before and two behind, so that nothing is missed at the ends or the seam
        t[i] = (i - 1.5) * step
        f[i] = _at(P, B, arc, t[i], room)
    for i in range(1, GRID + 3):
        n = 0
        if f[i] * f[i + 1] <= 0.0:
            zeros[0], n = _zero(P, B, arc, (t[i], f[i], t[i + 1], f[i + 1]), room), 1
        elif f[i] * f[i - 1] > 0.0 and abs(f[i]) <= min(abs(f[i - 1]), abs(f[i + 1])):
            at, value = _dip(P, B, arc, (t[i - 1], f[i - 1], t[i + 1], f[i + 1]), room)
            if value * f[i] < 0.0:
                zeros[0] = _zero(P, B, arc, (t[i - 1], f[i - 1], at, value), room)
                zeros[1], n = _zero(P, B, arc, (at, value, t[i + 1], f[i + 1]), room), 2
            elif abs(value) < 1e-9:
                zeros[0], n = at, 1
        for j in range(n):
            # the ends of an arc belong to both elbows
            if count < len(found) and (whole or -1e-6 < zeros[j] < math.pi + 1e-6):
                found[count] = _place(arc, zeros[j])
                count += 1
    return count


@kernel
def _ends(P: FloatArray, B: FloatArray, room: FloatArray, ends: FloatArray) -> int:
    """Give where the wrist's distance is the farthest or nearest the elbow allows; how many."""
    v, axis = room[0, 0], room[0, 1]
    squares = np.empty(3)
    for i in range(3):
        wrist(P, B, 2.0 * math.pi / 3.0 * i, v, axis)
        squares[i] = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    middle = (squares[0] + squares[1] + squares[2]) / 3.0
    even, odd = squares[0] - middle, (squares[1] - squares[2]) / math.sqrt(3.0)
    a2, d2, ca2, sa2 = P[2, 0], P[2, 1], P[2, 2], P[2, 3]
    wx, wy, wz = P[3, 0], -P[3, 3] * P[4, 1], P[3, 1] + P[3, 2] * P[4, 1]
    fixed = a2 * a2 + d2 * d2 + wx * wx + wy * wy + wz * wz + 2.0 * ca2 * d2 * wz
    room_to_bend = 2.0 * math.sqrt((a2 * a2 + sa2 * sa2 * d2 * d2) * (wx * wx + wy * wy))
    n = 0
    for i in range(2):
        edge = fixed + (room_to_bend if i else -room_to_bend) - middle
        roots, c, s, cb, sb = circle(even, odd, edge, fixed, 0.0)
        if roots == 2:
            ends[n], ends[n + 1] = math.atan2(s, c), math.atan2(sb, cb)
            n += 2
    for i in range(n):
        for j in range(i):
            if ends[i] < ends[j]:
                ends[i], ends[j] = ends[j], ends[i]
    return n


@kernel
def search(
    P: FloatArray, B: FloatArray, swivel: float, k: int, found: FloatArray, room: FloatArray
) -> int:
    """Give values of the last joint with which elbow k serves in ``found``, and their number."""
    ends, arc = np.empty(5), np.empty(6)
    arc[2], arc[3] = k, swivel
    n = _ends(P, B, room, ends)
    if n == 0:
        # off the places where arms like to stand
        arc[0], arc[1] = 0.3137, 0.0
        return _scan(P, B, arc, found, 0, room)
    ends[n] = ends[0] + 2.0 * math.pi
    count = 0
    for i in range(n):
        arc[0], arc[1] = 0.5 * (ends[i] + ends[i + 1]), 0.5 * (ends[i + 1] - ends[i])
        wrist(P, B, arc[0], room[0, 0], room[0, 1])
        if elbows(P, room[0, 0], room[1, :2, :2], 0.0) < 2:
            continue
        for j in range(2):
            # where the arm is straight the elbow changes sides; else both are one there
            t = math.pi * j + (1e-5 if j == 0 else -1e-5)
            here, x = _at(P, B, arc, t, room), _place(arc, t)
            same = abs(angle_miss(P, B, swivel, x, 1 - k, room) - here)
            turned = abs(angle_miss(P, B, swivel + math.pi, x, 1 - k, room) - here)
            arc[4 + j] = swivel if same <= turned else swivel + math.pi
        count = _scan(P, B, arc, found, count, room)
    return count


@kernel
def _complete(
    G: FloatArray,
    B: FloatArray,
    swivel: float,
    x: float,
    k: int,
    seed: FloatArray,
    q: FloatArray,
    n: int,
) -> int:
    """Add the branches of elbow k with the last joint at x; give their number."""
    round_wrist = G[13, 0] == 0.0
    room = np.empty((7, 3, 3))
    v, axis, roots = np.empty(3), np.empty(3), np.empty((2, 2))
    wrist(G, B, x, v, axis)
    if elbows(G, v, roots, seed[3]) <= k:
        return n
    c, s = roots[k, 0], roots[k, 1]
    if not upper(G, v, swivel, c, s, room[0], room[1:4]):
        return n
    lower(G, room[0], c, s, room[4])
    F, M = room[4], room[5]
    shoulders, wrists = np.empty((2, 6)), np.empty((2, 6))
    for i in range(3):
        for j in range(3):
            M[i, j] = F[0, i] * B[0, j] + F[1, i] * B[1, j] + F[2, i] * B[2, j]
    bends = three_turns(M, G, 4, seed, wrists) if round_wrist else two_turns(G, M, x, seed, wrists)
    angles = np.empty(7)
    angles[3] = math.atan2(s, c)
    for i in range(three_turns(room[0], G, 0, seed, shoulders)):
        for j in range(bends):
            for m in range(3):
                angles[m] = math.atan2(shoulders[i, 2 * m + 1], shoulders[i, 2 * m])
                angles[4 + m] = math.atan2(wrists[j, 2 * m + 1], wrists[j, 2 * m])
            n = _add(G, angles, 4.0 * i + 2.0 * k + j, q, n)
    return n


@kernel
def _add(G: FloatArray, angles: FloatArray, code: float, q: FloatArray, n: int) -> int:
    """Add joint angles to the answers unless they are there; give their number."""
    if n == MOST:
        return n
    for m in range(7):
        q[n, m] = wrap(G[m, 5] * (angles[m] - G[m, 4]))
    q[n, 7] = code
    for i in range(n):
        apart = 0.0
        for m in range(7):
            apart = max(apart, abs(math.sin(0.5 * (q[i, m] - q[n, m]))))
        if apart < _SAME:
            return n
    return n + 1


@kernel
def _all(G: FloatArray, T: FloatArray, seed: FloatArray, swivel: float, q: FloatArray) -> int:
    """Give all branches of a pose, and what they are, in ``q`` (32, 8), and their number."""
    A, B, angles = np.empty((3, 4)), np.empty((3, 4)), np.empty(7)
    product(G[7:10], T, A)
    product(A, G[10:13], B)
    for k in range(7):
        angles[k] = G[k, 4] + G[k, 5] * seed[k]
    found, room = np.empty(MOST), np.empty((7, 3, 3))
    n = 0
    for k in range(2):
        if G[13, 0] == 0.0:
            n = _complete(G, B, swivel, angles[6], k, angles, q, n)
            continue
        for i in range(search(G, B, swivel, k, found, room)):
            n = _complete(G, B, swivel, found[i], k, angles, q, n)
    return n


@kernel
def solve_batch(
    G: FloatArray,
    T: FloatArray,
    seed: FloatArray,
    swivel: float,
    q: FloatArray,
    count: FloatArray,
) -> None:
    """Give all branches of poses (m, 4, 4): in ``q`` (m, 32, 8), how many in ``count`` (m,).

    The last column of ``q`` says what branches they are.
    """
    room = np.empty((MOST, 8))
    for k in range(len(T)):
        n = _all(G, T[k], seed, swivel, room)
        for i in range(MOST):
            for j in range(8):
                q[k, i, j] = room[i, j] if i < n else np.nan
        count[k] = n


def solve(
    G: FloatArray, T: FloatArray, seed: FloatArray, swivel: float
) -> tuple[FloatArray, FloatArray]:
    """Give all branches of a pose T_base_tool, shape (4, 4), with the swivel of the elbow given.

    Returns:
        Joint positions, shape (m, 7), rad, and what branches they are, shape (m,).
    """
    q, count = np.empty((1, MOST, 8)), np.empty(1)
    solve_batch(G, T[None], seed, swivel, q, count)
    n = int(count[0])
    return q[0, :n, :7], q[0, :n, 7]
