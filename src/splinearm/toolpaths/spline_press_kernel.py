"""Control points and knots of a cubic spline moved until it strays least, compiled.

The largest deviation from the middle of a band beside a chain is made least: the deviation is taken
as linear in points and knots, the best step is found by least squares that are weighted anew by
what is left (Lawson 1961), and steps that did not help are shortened (Levenberg 1944).
"""

import math

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .spline_jet_kernel import foot, jet_at

IntArray = npt.NDArray[np.int64]

_ROUNDS = 20
_EARLY, _FAR = 14, 4.0
"""What strays farther after so many rounds is given up."""
_WEIGHTINGS = 6
_OPEN, _CORNER = 1.0, 2.0
"""Ends that may be moved across their direction, and such that may change it."""


@kernel
def shares_of(k: FloatArray, i: int, t: float) -> tuple[float, float, float, float]:
    """Give the shares of four control points, i - 3 to i, in a point of the span behind knot i."""
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, A2.2
    l1, l2, l3 = t - k[i], t - k[i - 1], t - k[i - 2]
    r1, r2, r3 = k[i + 1] - t, k[i + 2] - t, k[i + 3] - t
    a = 1.0 / (r1 + l1)
    b, c = r1 * a / (r1 + l2), l1 * a / (r2 + l1)
    p, q, s = r1 * b / (r1 + l3), (l2 * b + r2 * c) / (r2 + l2), l1 * c / (r3 + l1)
    return r1 * p, l3 * p + r2 * q, l2 * q + r3 * s, l1 * s


@kernel
def point(X: FloatArray, k: FloatArray, i: int, t: float) -> tuple[float, float]:
    """Give a point of the span behind knot i."""
    a, b, c, d = shares_of(k, i, t)
    return (
        a * X[i - 3, 0] + b * X[i - 2, 0] + c * X[i - 1, 0] + d * X[i, 0],
        a * X[i - 3, 1] + b * X[i - 2, 1] + c * X[i - 1, 1] + d * X[i, 1],
    )


@kernel
def looks_at(k: FloatArray, F: FloatArray, low: int, high: int, each: int) -> FloatArray:
    """Give places of the spans behind knots low to high: knot, share of the span, about the foot.

    The rows have room for the deviation from the band's middle, the normal, and a weight.
    """
    spans = 0
    for i in range(low, high + 1):
        if k[i + 1] > k[i]:
            spans += 1
    P = np.empty((spans * each, 7))
    n = 0
    for i in range(low, high + 1):
        if k[i + 1] > k[i]:
            for j in range(each):
                s = 0.5 - 0.5 * math.cos(math.pi * (j + 0.5) / each)
                P[n, 0], P[n, 1], P[n, 2] = i, s, F[i] + s * (F[i + 1] - F[i])
                P[n, 6] = 1.0
                n += 1
    return P


@kernel
def stray(
    S: FloatArray,
    chain: tuple[float, float],
    X: FloatArray,
    k: FloatArray,
    band: tuple[float, float],
    P: FloatArray,
) -> float:
    """Write deviations in halves of the band, and normals by such; give the largest."""
    worst, U = 0.0, -math.inf
    middle, half = 0.5 * (band[0] + band[1]), 0.5 * (band[1] - band[0])
    for n in range(P.shape[0]):
        i = int(P[n, 0])
        x, y = point(X, k, i, k[i] + P[n, 1] * (k[i + 1] - k[i]))
        P[n, 2] = foot(S, chain[0], chain[1], P[n, 2], x, y)
        px, py, dx, dy, _, _ = jet_at(S, chain[0], chain[1], P[n, 2])
        v = math.sqrt(dx * dx + dy * dy)
        P[n, 4], P[n, 5] = -dy / v / half, dx / v / half
        P[n, 3] = (x - px) * P[n, 4] + (y - py) * P[n, 5] - middle / half
        worst = max(worst, abs(P[n, 3]))
        if P[n, 2] + 1e-9 < U:
            return math.inf
        U = P[n, 2]
    return worst


@kernel
def solved(A: FloatArray, b: FloatArray) -> bool:
    """Solve A x = b for a positive definite A, both of which are overwritten, b by x.

    Of each row only what is behind its leading zeros is looked at.
    """
    n = len(b)
    first = np.empty(n, np.int64)
    for i in range(n):
        begin = 0
        while begin < i and A[i, begin] == 0.0:
            begin += 1
        first[i] = begin
        for j in range(begin, i + 1):
            total = A[i, j]
            for q in range(max(begin, first[j]), j):
                total -= A[i, q] * A[j, q]
            if i == j:
                if not total > 0.0:
                    return False
                A[i, i] = math.sqrt(total)
            else:
                A[i, j] = total / A[j, j]
    for i in range(n):
        for q in range(first[i], i):
            b[i] -= A[i, q] * b[q]
        b[i] /= A[i, i]
    for i in range(n - 1, -1, -1):
        b[i] /= A[i, i]
        for q in range(first[i], i):
            b[q] -= A[i, q] * b[i]
    return True


@kernel
def _ways(X: FloatArray, low: int, high: int, ends: FloatArray) -> FloatArray:
    """Give how control points may move, rows: from which to which, and the direction."""
    m = len(X)
    found, n = np.empty((2 * (high - low + 1), 4)), 0
    for j in range(low, high + 1):
        side = 0 if j < 2 else 1
        first = j == 0 or j == m - 1
        if 1 < j < m - 2 or (not first and ends[side, 2] == _CORNER):
            found[n, 0], found[n, 1], found[n, 2], found[n, 3] = j, j, 1.0, 0.0
            found[n + 1, 0], found[n + 1, 1], found[n + 1, 2], found[n + 1, 3] = j, j, 0.0, 1.0
            n += 2
        elif not first:
            # only along the direction in which it begins or ends
            found[n, 0], found[n, 1], found[n, 2], found[n, 3] = j, j, ends[side, 0], ends[side, 1]
            n += 1
        elif ends[side, 2] == _OPEN and low < high:
            # and both across it
            a = 0 if j == 0 else m - 2
            found[n, 0], found[n, 1] = a, a + 1
            found[n, 2], found[n, 3] = -ends[side, 1], ends[side, 0]
            n += 1
    return found[:n]


@kernel
def _movable(k: FloatArray, m: int, low: int, high: int) -> IntArray:
    """Give first and last of the equal knots that change nothing outside of some control points."""
    found, n = np.empty((high - low + 4, 2), np.int64), 0
    i = max(4, low + 3)
    last = min(m - 1, high + 1)
    while i <= last:
        j = i
        while j + 1 < m and k[j + 1] == k[i]:
            j += 1
        if j <= last and k[i - 1] < k[i]:
            found[n, 0], found[n, 1] = i, j
            n += 1
        i = j + 1
    return found[:n]


@kernel
def _slopes(
    X: FloatArray, k: FloatArray, P: FloatArray, ways: FloatArray, groups: IntArray, J: FloatArray
) -> None:
    """Write how deviations change by what may be moved."""
    w = len(ways)
    for n in range(len(P)):
        i = int(P[n, 0])
        B = shares_of(k, i, k[i] + P[n, 1] * (k[i + 1] - k[i]))
        for c in range(w):
            J[n, c] = 0.0
            for j in range(max(0, int(ways[c, 0]) - i + 3), min(3, int(ways[c, 1]) - i + 3) + 1):
                J[n, c] += B[j] * (ways[c, 2] * P[n, 4] + ways[c, 3] * P[n, 5])
    moved_ = k.copy()
    for c in range(len(groups)):
        a, b = groups[c, 0], groups[c, 1]
        h = 1e-5 * min(k[a] - k[a - 1], k[b + 1] - k[b])
        for j in range(a, b + 1):
            moved_[j] = k[j] + h
        for n in range(len(P)):
            i = int(P[n, 0])
            J[n, w + c] = 0.0
            if a - 4 < i < b + 4:
                x, y = point(X, k, i, k[i] + P[n, 1] * (k[i + 1] - k[i]))
                p, q = point(X, moved_, i, moved_[i] + P[n, 1] * (moved_[i + 1] - moved_[i]))
                J[n, w + c] = ((p - x) * P[n, 4] + (q - y) * P[n, 5]) / h
        for j in range(a, b + 1):
            moved_[j] = k[j]


@kernel
def _in_order(J: FloatArray) -> IntArray:
    """Give columns by the first places that they move, so that few rows of J^T J are long."""
    n, v = J.shape
    order, first = np.empty(v, np.int64), np.empty(v, np.int64)
    for c in range(v):
        i, j = 0, c
        while i < n and J[i, c] == 0.0:
            i += 1
        while j > 0 and first[j - 1] > i:
            first[j], order[j] = first[j - 1], order[j - 1]
            j -= 1
        first[j], order[j] = i, c
    return order


@kernel
def _least_step(
    P: FloatArray, J: FloatArray, limits: FloatArray, damping: float, step: FloatArray
) -> float:
    """Write the step after which the largest deviation is least, about; give that."""
    n, v = J.shape
    A, b, best = np.empty((v, v)), np.empty(v), math.inf
    order, size = _in_order(J), np.zeros(v)
    # a place is moved by few of them
    by, own, count = np.empty((n, v), np.int64), np.empty((n, v)), np.zeros(n, np.int64)
    for i in range(n):
        for r in range(v):
            slope = J[i, order[r]]
            if slope != 0.0:
                by[i, count[i]], own[i, count[i]] = r, slope
                size[r] += slope * slope
                count[i] += 1
    for _ in range(_WEIGHTINGS):
        A[:] = 0.0
        b[:] = 0.0
        total = 0.0
        for i in range(n):
            total += P[i, 6]
        for i in range(n):
            w = P[i, 6] / total
            for k in range(count[i]):
                r, g = by[i, k], w * own[i, k]
                b[r] -= g * P[i, 3]
                for h in range(k + 1):
                    A[r, by[i, h]] += g * own[i, h]
        for r in range(v):
            limit = limits[order[r]]
            A[r, r] += 1e-9 * size[r] / n + damping / (limit * limit)
        if not solved(A, b):
            break
        worst = 0.0
        for i in range(n):
            left = P[i, 3]
            for k in range(count[i]):
                left += own[i, k] * b[by[i, k]]
            worst = max(worst, abs(left))
            P[i, 6] *= abs(left) + 1e-6
        for i in range(n):
            P[i, 6] = P[i, 6] / worst + 1e-9
        if worst < best:
            best = worst
            for r in range(v):
                step[order[r]] = b[r]
    return best


@kernel
def _limits(X: FloatArray, k: FloatArray, ways: FloatArray, groups: IntArray) -> FloatArray:
    """Give how far each point and knot may go at once."""
    m, w = len(X), len(ways)
    found = np.empty(w + len(groups))
    for c in range(w):
        j = min(int(ways[c, 0]), m - 2)
        found[c] = 0.3 * math.sqrt((X[j + 1, 0] - X[j, 0]) ** 2 + (X[j + 1, 1] - X[j, 1]) ** 2)
    for c in range(len(groups)):
        a, b = groups[c, 0], groups[c, 1]
        found[w + c] = 0.4 * min(k[a] - k[a - 1], k[b + 1] - k[b])
    return found


@kernel
def _stepped(
    spline: tuple[FloatArray, FloatArray],
    ways: FloatArray,
    groups: IntArray,
    step: FloatArray,
    limits: FloatArray,
    new: tuple[FloatArray, FloatArray],
) -> None:
    """Write points and knots after a step, which is shortened where it is too far."""
    shrink = 1.0
    for c in range(len(step)):
        shrink = min(shrink, limits[c] / max(abs(step[c]), 1e-300))
    Y, l = new
    Y[:] = spline[0]
    l[:] = spline[1]
    w = len(ways)
    for c in range(w):
        for j in range(int(ways[c, 0]), int(ways[c, 1]) + 1):
            Y[j, 0] += shrink * step[c] * ways[c, 2]
            Y[j, 1] += shrink * step[c] * ways[c, 3]
    for c in range(len(groups)):
        for j in range(groups[c, 0], groups[c, 1] + 1):
            l[j] += shrink * step[w + c]


@kernel
def pressed(
    S: FloatArray,
    chain: tuple[float, float],
    spline: tuple[FloatArray, FloatArray, FloatArray],
    window: tuple[int, int, int, float],
    band: tuple[float, float],
    ends: FloatArray,
) -> float:
    """Move some control points and knots until the largest deviation is in the band or least.

    Args:
        S: Segments.
        chain: Where the chain begins and ends.
        spline: Control points, knots and places of the chain beside these; the first two are
            changed.
        window: The first and the last of the points that are moved, looks a span, and the share of
            the band's half that is good enough.
        band: Distances of the near and the far edge.
        ends: How it begins and ends, see ``thinned``.

    Returns:
        The largest deviation in halves of the band; inf if it runs backwards.
    """
    X, k, F = spline
    m, (low, high, looks, enough) = len(X), window
    P = looks_at(k, F, max(3, low), min(m - 1, high + 3), looks)
    worst = stray(S, chain, X, k, band, P)
    ways, groups = _ways(X, low, high, ends), _movable(k, m, low, high)
    J, step = np.empty((len(P), len(ways) + len(groups))), np.zeros(len(ways) + len(groups))
    Y, l, Q = np.empty_like(X), np.empty_like(k), P.copy()
    damping, failed, fresh = 1e-4, 0, True
    limits = np.zeros(len(step))
    for turn in range(_ROUNDS):
        if worst <= enough or worst == math.inf or (turn > _EARLY and worst > _FAR):
            break
        if fresh:
            _slopes(X, k, P, ways, groups, J)
            limits = _limits(X, k, ways, groups)
        hoped = _least_step(P, J, limits, damping * worst * worst, step)
        if hoped > 0.99 * worst:
            if damping < 1e-7:
                break
            damping, fresh, failed = 0.01 * damping, False, failed + 1
            continue
        _stepped((X, k), ways, groups, step, limits, (Y, l))
        Q[:] = P
        after = stray(S, chain, Y, l, band, Q)
        if after < worst:
            slow = after > 0.97 * worst
            fresh, failed, damping = True, failed + 1 if slow else 0, 0.2 * damping
            worst = after
            X[:] = Y
            k[:] = l
            P[:] = Q
        else:
            fresh, failed, damping = False, failed + 1, 30.0 * damping
        if failed > 3:
            break
    return worst
