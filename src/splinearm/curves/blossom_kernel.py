"""The same curve over other knots or of a higher degree, on bare arrays.

A control point is the blossom of its polynomial at the knots between the ends of its basis
function (Ramshaw, Blossoms are polar forms, CAGD 6 (1989) 323), so new control points follow from
new knots. ``rows`` are control points of any number of columns, of rational curves homogeneous.
"""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel


@fast_kernel
def add_blossom(
    knots: FloatArray, span: int, at: FloatArray, share_of_all: float, shares: FloatArray
) -> None:
    """Add to shares[0] what the points of a span count in the blossom at some numbers.

    ``at`` holds as many numbers as the degree; shares has two rows of degree + 1.
    """
    # de Boor's recurrence, from the end: with equal numbers these are the basis functions
    degree = at.shape[0]
    mine = shares[1]
    mine[0] = share_of_all
    for d in range(1, degree + 1):
        u, carried = at[degree - d], 0.0
        for j in range(d):
            low = knots[span + 1 - d + j]
            part = (u - low) / (knots[span + 1 + j] - low) * mine[j]
            mine[j] += carried - part
            carried = part
        mine[d] = carried
    for j in range(degree + 1):
        shares[0, j] += mine[j]


@fast_kernel
def mix(rows: FloatArray, shares: FloatArray, out: FloatArray) -> None:
    """Write the sum of rows times their shares into ``out``."""
    for c in range(out.shape[0]):
        total = 0.0
        for j in range(shares.shape[0]):
            total += shares[j] * rows[j, c]
        out[c] = total


@fast_kernel
def span_of(knots: FloatArray, degree: int, new: FloatArray, new_degree: int, point: int) -> int:
    """Give the old span that a new control point is computed on."""
    # any span of the basis function would do; on the widest the others are never far away
    first, last = new_degree, new.shape[0] - new_degree - 2
    interval = min(max(point + (new_degree + 1) // 2, first), last)
    widest = 0.0
    for i in range(max(point, first), min(point + new_degree, last) + 1):
        if new[i + 1] - new[i] > widest:
            interval, widest = i, new[i + 1] - new[i]
    low, high = degree, knots.shape[0] - degree - 1
    while high - low > 1:
        halfway = (low + high) >> 1
        if knots[halfway] <= new[interval]:
            low = halfway
        else:
            high = halfway
    # of several equal knots at the end of the domain the first ends the last span
    while low > degree and knots[low] == knots[low + 1]:
        low -= 1
    return low


@fast_kernel
def far_first(at: FloatArray, middle: float) -> None:
    """Sort numbers, the farthest from the middle first: those meet the widest steps of knots."""
    for i in range(1, at.shape[0]):
        value = at[i]
        j = i
        while j > 0 and abs(at[j - 1] - middle) < abs(value - middle):
            at[j] = at[j - 1]
            j -= 1
        at[j] = value


@fast_kernel
def over_knots(knots: FloatArray, rows: FloatArray, new: FloatArray, out: FloatArray) -> None:
    """Write the control points over other knots into ``out``, shape (m', columns).

    ``new`` holds every inner knot at least as often as the curve needs it.
    """
    degree = knots.shape[0] - rows.shape[0] - 1
    at, shares = np.empty(degree), np.empty((2, degree + 1))
    for i in range(out.shape[0]):
        span = span_of(knots, degree, new, degree, i)
        for k in range(degree):
            at[k] = new[i + 1 + k]
        far_first(at, 0.5 * (knots[span] + knots[span + 1]))
        shares[0] = 0.0
        add_blossom(knots, span, at, 1.0, shares)
        mix(rows[span - degree :], shares[0], out[i])


@fast_kernel
def elevate(knots: FloatArray, rows: FloatArray, new: FloatArray, out: FloatArray) -> None:
    """Write the control points of one degree more over ``new`` knots into ``out``."""
    # the blossom of degree p + 1 is the mean of those of degree p that leave one argument out
    degree = knots.shape[0] - rows.shape[0] - 1
    at, shares = np.empty(degree), np.empty((2, degree + 1))
    for i in range(out.shape[0]):
        span = span_of(knots, degree, new, degree + 1, i)
        middle = 0.5 * (knots[span] + knots[span + 1])
        shares[0] = 0.0
        j = i + 1
        while j <= i + degree + 1:
            # leaving out one of several equal knots is the same for each of them
            same = 1
            while j + same <= i + degree + 1 and new[j + same] == new[j]:
                same += 1
            for k in range(degree):
                at[k] = new[i + 1 + k + (i + 1 + k >= j)]
            far_first(at, middle)
            add_blossom(knots, span, at, same / (degree + 1.0), shares)
            j += same
        mix(rows[span - degree :], shares[0], out[i])


@fast_kernel
def remove(knots: FloatArray, rows: FloatArray, index: FloatArray, out: FloatArray) -> None:
    """Write the best control points without one knot, and how they miss the curve.

    Args:
        knots: Knots.
        rows: Control points, shape (m, columns).
        index: Degree, index of the last of the equal knots, how often it is there.
        out: Shape (2 m - 1, columns): the m - 1 new points, then for each of the old ones what it
            would be if the knot were put in again, minus what it is.
    """
    degree, last_knot, times = int(index[0]), int(index[1]), int(index[2])
    m, columns = rows.shape
    u = knots[last_knot]
    # putting the knot in again mixes neighbours: P[i] = a[i] Q[i] + (1 - a[i]) Q[i - 1] for
    # first <= i <= last (Boehm 1980), one equation more than unknown points. The numbers that
    # eliminate all unknowns give the smallest error that the worst equation can have
    first, last = last_knot - degree, last_knot - times
    count = last - first + 1
    share, null = np.empty(count), np.empty(count)
    null[0] = 1.0
    total = 1.0
    for k in range(count):
        low, high = knots[first + k], knots[first + k + degree + 1]
        share[k] = (u - low) / (high - low)
        if k > 0:
            null[k] = -null[k - 1] * share[k - 1] / (1.0 - share[k])
            total += abs(null[k])
    for i in range(m - 1):
        for c in range(columns):
            out[i, c] = rows[i if i < first else i + 1, c]
    out[m - 1 :] = 0.0
    for c in range(columns):
        miss = 0.0
        for k in range(count):
            right = rows[first + k, c]
            if k == 0:
                right -= (1.0 - share[0]) * rows[first - 1, c]
            if k == count - 1:
                right -= share[k] * rows[last + 1, c]
            miss += null[k] * right
        miss /= total
        for k in range(count):
            out[m - 1 + first + k, c] = -miss if null[k] > 0.0 else miss
    # with that error given to it the system is solved from both sides, each as long as it damps
    low, high = 0, count - 1
    while low < high:
        if share[low] >= 1.0 - share[high]:
            i = first + low
            for c in range(columns):
                right = rows[i, c] + out[m - 1 + i, c]
                before = rows[i - 1, c] if low == 0 else out[i - 1, c]
                out[i, c] = (right - (1.0 - share[low]) * before) / share[low]
            low += 1
        else:
            i = first + high
            for c in range(columns):
                right = rows[i, c] + out[m - 1 + i, c]
                behind = rows[i + 1, c] if high == count - 1 else out[i, c]
                out[i - 1, c] = (right - share[high] * behind) / (1.0 - share[high])
            high -= 1
