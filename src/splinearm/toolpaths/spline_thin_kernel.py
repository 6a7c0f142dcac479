"""Fewer control points of a cubic spline within a band beside a chain, compiled.

Knots are taken out one by one. The control points and knots about each are then moved until the
largest deviation there is least, and it stays out if that keeps within the band: a joint of which
only the direction was common becomes one with a common bend.

Along a curve points may lie nearly anywhere, and the last digit tells where they stop. So this and
what it stands on is compiled with the arithmetic that stands in the source, and gives the same
everywhere.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .spline_jet_kernel import foot
from .spline_press_kernel import looks_at, point, pressed, shares_of, solved, stray

_REACHES = (6, 10, 16)
"""So many control points on each side of a knot are moved, at first and where that nearly did."""
_NEARLY = 1.3
"""Which is so if it strayed by no more than so many halves of the band."""
_LOOKS = 9
"""Places of a span that are looked at while points are moved."""
_MORE_LOOKS = 18
"""And if those were too few."""
_CLOSE_LOOKS = 40
"""And when they fit there."""
_HOPELESS = 260.0
"""Knots without which it strays by more than so many halves of the band are left."""
_GOAL = 0.97
"""A share of the band's half within which all must be at these places."""
_SWEEPS = 2
"""So many times all knots are tried, if the first time some were taken out."""


@kernel
def _without(
    X: FloatArray, k: FloatArray, F: FloatArray, r: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give a spline without its knot r, near to what it was."""
    m = len(X)
    Y, l, G = np.empty((m - 1, 2)), np.empty(m + 3), np.empty(m + 3)
    for i in range(m + 3):
        l[i], G[i] = k[i if i < r else i + 1], F[i if i < r else i + 1]
    # points r - 3 to r - 1 of the new are sought, those before are kept and those behind follow
    for j in range(m - 1):
        Y[j] = X[j if j < r - 1 else j + 1]
    low, high = max(2, r - 4), min(m - 4, r)
    v = max(0, high - low + 1)
    A, b, c = np.zeros((v, v)), np.zeros(v), np.zeros(v)
    for i in range(max(3, low), min(m - 2, high + 3) + 1):
        if l[i + 1] <= l[i]:
            continue
        for q in range(5):
            t = l[i] + (l[i + 1] - l[i]) * (q + 0.5) / 5.0
            old = i
            if i >= r - 1 and t >= k[r]:
                old = i + 1
            x, y = point(X, k, old, t)
            B = shares_of(l, i, t)
            for e in range(4):
                j = i - 3 + e
                if j < low or j > high:
                    x -= B[e] * Y[j, 0]
                    y -= B[e] * Y[j, 1]
            for e in range(4):
                j = i - 3 + e - low
                if 0 <= j < v:
                    b[j] += B[e] * x
                    c[j] += B[e] * y
                    for f in range(4):
                        h = i - 3 + f - low
                        if 0 <= h < v:
                            A[j, h] += B[e] * B[f]
    D = A.copy()
    if solved(A, b) and solved(D, c):
        for j in range(v):
            Y[low + j, 0], Y[low + j, 1] = b[j], c[j]
    return Y, l, G


@kernel
def _set_feet(
    S: FloatArray, chain: tuple[float, float], spline: tuple[FloatArray, FloatArray, FloatArray]
) -> None:
    """Set the places of the chain that are nearest to the knots."""
    X, k, F = spline
    for i in range(4, len(X)):
        if k[i + 1] > k[i]:
            x, y = point(X, k, i, k[i])
            F[i] = foot(S, chain[0], chain[1], F[i], x, y)
            j = i - 1
            while k[j] == k[i]:
                F[j] = F[i]
                j -= 1


@kernel
def _settled(
    S: FloatArray,
    chain: tuple[float, float],
    spline: tuple[FloatArray, FloatArray, FloatArray],
    low: int,
    high: int,
    band: tuple[float, float],
) -> float:
    """Set the places beside the knots, and give how far a spline strays about some of its points.

    That is in halves of the band, closely looked at, from control point ``low`` to ``high``.
    """
    _set_feet(S, chain, spline)
    last = min(len(spline[0]) - 1, high + 3)
    P = looks_at(spline[1], spline[2], max(3, low), last, _CLOSE_LOOKS)
    return stray(S, chain, spline[0], spline[1], band, P)


@kernel
def _cost(
    S: FloatArray,
    chain: tuple[float, float],
    spline: tuple[FloatArray, FloatArray, FloatArray],
    r: int,
    band: tuple[float, float],
) -> float:
    """Give how far a spline strays, in halves of the band, if it merely loses knot r."""
    X, k, F = _without(spline[0], spline[1], spline[2], r)
    P = looks_at(k, F, max(3, r - 4), min(len(X) - 1, r + 3), 5)
    return stray(S, chain, X, k, band, P)


@kernel
def _tried(
    S: FloatArray,
    chain: tuple[float, float],
    spline: tuple[FloatArray, FloatArray, FloatArray],
    r: int,
    band: tuple[float, float],
    ends: FloatArray,
    reach: int,
) -> tuple[float, tuple[FloatArray, FloatArray, FloatArray]]:
    """Give a spline without knot r, and how far it strays, in halves of the band."""
    found = _without(spline[0], spline[1], spline[2], r)
    m, worst = len(found[0]), 0.0
    low, high = max(0, r - 2 - reach), min(m - 1, r - 2 + reach)
    for looks in (_LOOKS, _MORE_LOOKS):
        worst = pressed(S, chain, found, (low, high, looks, _GOAL), band, ends)
        if worst > 1.0:
            break
        worst = _settled(S, chain, found, low, high, band)
        if worst <= 1.0:
            break
    return worst, found


@kernel
def _evened(
    S: FloatArray,
    chain: tuple[float, float],
    spline: tuple[FloatArray, FloatArray, FloatArray],
    c: int,
    band: tuple[float, float],
    ends: FloatArray,
    reach: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give a spline that strays less about control point c, if it can."""
    found = spline[0].copy(), spline[1].copy(), spline[2].copy()
    m = len(found[0])
    low, high = max(0, c - reach), min(m - 1, c + reach)
    pressed(S, chain, found, (low, high, _MORE_LOOKS, 0.0), band, ends)
    return found if _settled(S, chain, found, low, high, band) <= 1.0 else spline


@kernel
def _swept(
    S: FloatArray,
    chain: tuple[float, float],
    spline: tuple[FloatArray, FloatArray, FloatArray],
    band: tuple[float, float],
    ends: FloatArray,
    reach: int,
    missed: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give a spline without the knots that it does without, the cheapest first.

    ``missed`` has how far it strayed without each knot at last; those that are hopeless are left.
    """
    for c in range(reach // 2, len(spline[0]), reach):
        spline = _evened(S, chain, spline, c, band, ends, reach)
    cost = np.full(len(spline[1]), -1.0)
    for _ in range(4 * len(spline[0])):
        k, m = spline[1], len(spline[0])
        best, r = _HOPELESS, -1
        for i in range(4, m):
            if k[i + 1] > k[i] and missed[i] < _NEARLY:
                if cost[i] < 0.0:
                    cost[i] = _cost(S, chain, spline, i, band)
                if cost[i] < best:
                    best, r = cost[i], i
        if r < 0 or m < 7:
            break
        worst, found = _tried(S, chain, spline, r, band, ends, reach)
        if worst <= 1.0:
            spline = found
            for i in range(r, m + 3):
                cost[i], missed[i] = cost[i + 1], missed[i + 1]
            for i in range(max(0, r - 6), min(m + 3, r + 6)):
                cost[i], missed[i] = -1.0, 0.0
        else:
            cost[r], missed[r] = math.inf, worst
    return spline


@kernel
def thinned(
    S: FloatArray,
    chain: tuple[float, float],
    spline: tuple[FloatArray, FloatArray, FloatArray],
    band: tuple[float, float],
    ends: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give a cubic spline with as few control points as are found to do.

    Args:
        S: Segments.
        chain: Where the chain begins and ends.
        spline: Control points, shape (m, 2); knots, shape (m + 4,); places of the chain beside the
            knots.
        band: Distances of the near and the far edge.
        ends: How it begins and ends, shape (2, 3): the direction; and 0 if neither it nor the end
            may change, 1 if the end may be moved across it, 2 if the direction may change.
    """
    _set_feet(S, chain, spline)
    missed = np.zeros(len(spline[1]))
    for reach in _REACHES:
        for _ in range(_SWEEPS):
            count = len(spline[0])
            spline = _swept(S, chain, spline, band, ends, reach, missed)
            if len(spline[0]) == count:
                break
            if reach == _REACHES[0]:
                missed[:] = 0.0
    return spline
