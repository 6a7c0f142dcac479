"""Six joints of which only the last two axes meet: a search along the fourth joint.

With the fourth joint given, the point where the last two axes meet is brought to its place by the
first three joints, in closed form; whether the fifth axis then has the right angle to the last is
one equation in the fourth joint. All its zeros are looked for on a grid: changes of sign, dips
that touch zero, and the ends of branches, where two of them become one. A branch that exists on
less than a grid's step, with no other that begins or ends beside it, can be missed. After A. Elias
and J. Wen, IK-Geo, 2025, section 5 (two axes that meet: a search in one dimension).
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .angle_kernel import arctan2
from .subproblem_kernel import inverse, product, turn, wrap
from .wrist_kernel import place

GRID = 360
"""Places of the fourth joint that are tried, evenly round the circle."""
PLACES = GRID + 3
"""These, and three of them once more behind the last, so that nothing is missed at the seam."""
MOST = 16
"""The most branches of six turning joints (E. Primrose, 1986)."""

_FINE = 6
_LEVELS = 3
_PARTS = 8
_SMALL = 0.02
_TOUCH = 1e-7
_HALVINGS = 60
_GOLDEN = 0.3819660112501051
_DIPS = 44
_SAME = 1e-6


@kernel
def angle_miss(
    P: FloatArray,
    kind: int,
    T: FloatArray,
    seed: FloatArray,
    x: float,
    rows: FloatArray,
    miss: FloatArray,
) -> None:
    """Give in ``miss`` (4) by how much each branch of the first three joints is off; NaN: none."""
    c, s = math.cos(x), math.sin(x)
    ca2, sa2, ca3, sa3 = P[2, 2], P[2, 3], P[3, 2], P[3, 3]
    ex, ey, ez = P[3, 0], -sa3 * P[4, 1], P[3, 1] + ca3 * P[4, 1]
    fx, fy = c * ex - s * ey, s * ex + c * ey
    wx, wy, wz = P[2, 0] + fx, ca2 * fy - sa2 * ez, P[2, 1] + sa2 * fy + ca2 * ez
    miss[:] = np.nan
    for k in range(place(P, kind, wx, wy, wz, T, seed, rows)):
        row = rows[k]
        # the last axis, seen from the frame behind the third joint
        nx, ny, nz = T[0, 2], T[1, 2], T[2, 2]
        for i in range(3):
            ci, si, ca, sa = row[2 * i], row[2 * i + 1], P[i, 2], P[i, 3]
            nx, ny = ci * nx + si * ny, ci * ny - si * nx
            ny, nz = ca * ny + sa * nz, ca * nz - sa * ny
        miss[int(row[12]) // 2] = s * sa3 * nx - c * sa3 * ny + ca3 * nz - P[4, 2]


@kernel
def _coarse(values: FloatArray, i: int, finest: bool) -> bool:
    """Say whether something may hide between places i and i + 1: an end, or a wave near zero."""
    for k in range(4):
        here, after = values[i, k], values[i + 1, k]
        if math.isnan(here) != math.isnan(after):
            return True
        if not finest and min(abs(here), abs(after)) < _SMALL:
            return True
    return False


@kernel
def _survey(
    P: FloatArray, kind: int, T: FloatArray, seed: FloatArray, rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give places of the fourth joint, finer where branches end or come near to zero, and misses.

    Shapes are (m,) and (m, 4).
    """
    # off the places where arms like to stand
    xs: FloatArray = np.empty(PLACES)
    for i in range(PLACES):
        xs[i] = -math.pi + 2.0 * math.pi / GRID * (i + 0.3137)
    values: FloatArray = np.empty((PLACES, 4))
    for i in range(PLACES):
        angle_miss(P, kind, T, seed, xs[i], rows, values[i])
    for level in range(_LEVELS):
        more = 0
        for i in range(len(xs) - 1):
            more += 1 if _coarse(values, i, level > 0) else 0
        x, v = np.empty(len(xs) + more * (_PARTS - 1)), np.empty((len(xs) + more * (_PARTS - 1), 4))
        n = 0
        for i in range(len(xs)):
            x[n], v[n] = xs[i], values[i]
            n += 1
            if i < len(xs) - 1 and _coarse(values, i, level > 0):
                for j in range(1, _PARTS):
                    x[n] = xs[i] + (xs[i + 1] - xs[i]) * j / _PARTS
                    angle_miss(P, kind, T, seed, x[n], rows, v[n])
                    n += 1
        xs, values = x, v
    return xs, values


@kernel
def _at(
    P: FloatArray,
    kind: int,
    T: FloatArray,
    seed: FloatArray,
    x: float,
    rows: FloatArray,
    miss: FloatArray,
    k: int,
) -> float:
    angle_miss(P, kind, T, seed, x, rows, miss)
    return float(miss[k])


@kernel
def _between(
    P: FloatArray,
    kind: int,
    T: FloatArray,
    seed: FloatArray,
    low: float,
    f_low: float,
    high: float,
    rows: FloatArray,
    miss: FloatArray,
    k: int,
) -> float:
    """Give a zero between two places where branch k has different signs."""
    for _ in range(_HALVINGS):
        x = 0.5 * (low + high)
        f = _at(P, kind, T, seed, x, rows, miss, k)
        if not (f * f_low <= 0.0):
            low, f_low = x, f
        else:
            high = x
    return 0.5 * (low + high)


@kernel
def _dip(
    P: FloatArray,
    kind: int,
    T: FloatArray,
    seed: FloatArray,
    low: float,
    high: float,
    sign: float,
    rows: FloatArray,
    miss: FloatArray,
    k: int,
) -> float:
    """Give where sign times branch k is smallest, by golden sections, or where it turns round."""
    a, b = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    fa = sign * _at(P, kind, T, seed, a, rows, miss, k)
    fb = sign * _at(P, kind, T, seed, b, rows, miss, k)
    for _ in range(_DIPS):
        if not (fa > 0.0 and fb > 0.0):
            break
        if fa < fb:
            high, b, fb = b, a, fa
            a = low + _GOLDEN * (high - low)
            fa = sign * _at(P, kind, T, seed, a, rows, miss, k)
        else:
            low, a, fa = a, b, fb
            b = high - _GOLDEN * (high - low)
            fb = sign * _at(P, kind, T, seed, b, rows, miss, k)
    return a if not (fa >= fb) else b


@kernel
def _end(
    P: FloatArray,
    kind: int,
    T: FloatArray,
    seed: FloatArray,
    inside: float,
    outside: float,
    rows: FloatArray,
    miss: FloatArray,
    k: int,
) -> float:
    """Give the last place where branch k exists on the way to one where it does not."""
    for _ in range(_HALVINGS):
        x = 0.5 * (inside + outside)
        if math.isnan(_at(P, kind, T, seed, x, rows, miss, k)):
            outside = x
        else:
            inside = x
    return inside


@kernel
def _zeros(
    P: FloatArray,
    kind: int,
    T: FloatArray,
    seed: FloatArray,
    xs: FloatArray,
    f: FloatArray,
    n: int,
    rows: FloatArray,
    miss: FloatArray,
    k: int,
    found: FloatArray,
    count: int,
) -> int:
    """Add the zeros of branch k on a run of n places ``xs`` where it exists with values ``f``."""
    for i in range(n - 1):
        if count >= len(found):
            return count
        if f[i] == 0.0 or f[i] * f[i + 1] < 0.0:
            found[count] = _between(P, kind, T, seed, xs[i], f[i], xs[i + 1], rows, miss, k)
            if f[i] == 0.0:
                found[count] = xs[i]
            count += 1
    for i in range(1, n - 1):
        sign = 1.0 if f[i] > 0.0 else -1.0
        same = sign * f[i - 1] > 0.0 and sign * f[i + 1] > 0.0
        small = sign * f[i] <= sign * f[i - 1] and sign * f[i] <= sign * f[i + 1]
        if not (same and small) or count + 1 >= len(found):
            continue
        x = _dip(P, kind, T, seed, xs[i - 1], xs[i + 1], sign, rows, miss, k)
        low = _at(P, kind, T, seed, x, rows, miss, k)
        if sign * low < 0.0:
            found[count] = _between(P, kind, T, seed, xs[i - 1], f[i - 1], x, rows, miss, k)
            found[count + 1] = _between(P, kind, T, seed, x, low, xs[i + 1], rows, miss, k)
            count += 2
        elif sign * low < 1e-9:
            found[count] = x
            count += 1
    return count


@kernel
def _run(
    P: FloatArray,
    kind: int,
    T: FloatArray,
    seed: FloatArray,
    inside: float,
    outside: float,
    rows: FloatArray,
    miss: FloatArray,
    k: int,
    xs: FloatArray,
    f: FloatArray,
) -> int:
    """Lay a finer run from a place inside to the end of branch k: dense at the end."""
    end = _end(P, kind, T, seed, inside, outside, rows, miss, k)
    # one place more on the inside, so that a dip at the last of the grid is seen
    before = 2.0 * inside - outside
    value = _at(P, kind, T, seed, before, rows, miss, k)
    n = 0
    if not math.isnan(value):
        xs[0], f[0] = before, value
        n = 1
    for i in range(_FINE + 1):
        # values near an end go as the root of the distance from it
        share = 1.0 - i / _FINE
        x = end + (inside - end) * share * share
        value = _at(P, kind, T, seed, x, rows, miss, k)
        if not math.isnan(value):
            xs[n], f[n] = x, value
            n += 1
    return n


@kernel
def _finish(P: FloatArray, T: FloatArray, seed: FloatArray, row: FloatArray, x: float) -> float:
    """Add the last three joints to a row; give by how much the orientation is missed."""
    c3, s3 = math.cos(x), math.sin(x)
    M = np.empty((3, 3))
    for j in range(3):
        nx, ny, nz = T[0, j], T[1, j], T[2, j]
        for i in range(4):
            ci, si = (row[2 * i], row[2 * i + 1]) if i < 3 else (c3, s3)
            ca, sa = P[i, 2], P[i, 3]
            nx, ny = ci * nx + si * ny, ci * ny - si * nx
            ny, nz = ca * ny + sa * nz, ca * nz - sa * ny
        M[0, j], M[1, j], M[2, j] = nx, ny, nz
    ca4, sa4 = P[4, 2], P[4, 3]
    c4, s4 = turn(0.0, -sa4, M[0, 2], M[1, 2], 1.0, seed[4])
    c5, s5 = turn(M[2, 0], M[2, 1], 0.0, sa4, 1.0, seed[5])
    row[6], row[7], row[8], row[9], row[10], row[11] = c3, s3, c4, s4, c5, s5
    off = abs(s4 * sa4 - M[0, 2]) + abs(c4 * sa4 + M[1, 2]) + abs(ca4 - M[2, 2])
    off += abs(s5 * sa4 - M[2, 0]) + abs(c5 * sa4 - M[2, 1])
    return float(off + abs(c4 * c5 - s4 * s5 * ca4 - M[0, 0]))


@kernel
def solve(G: FloatArray, T: FloatArray, seed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give all branches of a pose T_base_tool that the search finds, as six_kernel.solve does."""
    reverse, kind = G[12, 2] != 0.0, int(G[12, 1])
    A, B, angles = np.empty((3, 4)), np.empty((3, 4)), np.empty(6)
    for k in range(6):
        angles[k] = G[k, 4] + G[k, 5] * seed[5 - k if reverse else k]
    if reverse:
        inverse(T, B)
        product(G[6:9], B, A)
    else:
        product(G[6:9], T, A)
    product(A, G[9:12], B)
    rows, miss = np.zeros((8, 14)), np.empty(4)
    places, values = _survey(G, kind, B, angles, rows)
    q, code = np.empty((MOST, 6)), np.empty(MOST)
    found, xs, f = np.empty(4 * MOST), np.empty(_FINE + 2), np.empty(_FINE + 2)
    n = 0
    for k in range(4):
        count = 0
        begin = 0
        for i in range(len(places)):
            gone = math.isnan(values[i, k])
            last = i == len(places) - 1
            if gone or last:
                # a whole run of places where the branch exists
                end = i if gone else i + 1
                if end > begin:
                    count = _zeros(
                        G, kind, B, angles, places[begin:end], values[begin:end, k], end - begin,
                        rows, miss, k, found, count,
                    )  # fmt: skip
                begin = i + 1
            if last or gone == math.isnan(values[i + 1, k]):
                continue
            inside, outside = places[i + gone], places[i + 1 - gone]
            m = _run(G, kind, B, angles, inside, outside, rows, miss, k, xs, f)
            count = _zeros(G, kind, B, angles, xs, f, m, rows, miss, k, found, count)
            if m and count < len(found) and abs(f[m - 1]) < _TOUCH:
                found[count] = xs[m - 1]
                count += 1
        for i in range(count):
            angle_miss(G, kind, B, angles, found[i], rows, miss)
            for j in range(4):
                if rows[j, 12] != 2 * k or math.isnan(miss[k]):
                    continue
                if _finish(G, B, angles, rows[j], found[i]) < G[12, 3] and n < MOST:
                    n = _add(G, rows[j], reverse, q, code, n)
                break
    return q[:n], code[:n]


@kernel
def _add(
    G: FloatArray, row: FloatArray, reverse: bool, q: FloatArray, code: FloatArray, n: int
) -> int:
    """Add a row to the answers unless it is there; give their number."""
    wrists = 0
    for k in range(6):
        angle = arctan2(row[2 * k + 1], row[2 * k])
        q[n, 5 - k if reverse else k] = wrap(G[k, 5] * (angle - G[k, 4]))
    for i in range(n):
        apart = 0.0
        for k in range(6):
            apart = max(apart, abs(math.sin(0.5 * (q[i, k] - q[n, k]))))
        if apart < _SAME:
            return n
        if code[i] % 8.0 == row[12]:
            wrists += 1
    code[n] = row[12] + 8.0 * wrists
    return n + 1
