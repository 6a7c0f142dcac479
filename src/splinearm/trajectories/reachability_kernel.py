"""The quickest x(s) between lines that bound neighbours, compiled.

x is the square of ds/dt at nodes. On cell i the lines say, of x = x[i] and its neighbour x[i + 1],

    c x - e <= x[i + 1] <= c x + e    with (c, e) in ``both[i]``, shape (2, lines)
    x[i + 1] <= c x + e               with (c, e) in ``above[i]``
    x[i + 1] >= c x - e               with (c, e) in ``below[i]``

and x[i] <= cap[i]. Lines that say nothing are (0, inf). Every e is at least 0: standing still is
allowed, the allowed pairs are convex, and so every profile between two rests may be slowed down.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

_GO_ON = 0.02
"""A cell inside the path never ends below this share of its x: nothing comes to a halt there."""

_PASSES = 200


@fast_kernel
def fastest_into(
    both: FloatArray,
    above: FloatArray,
    below: FloatArray,
    cap: FloatArray,
    ends: FloatArray,
    x: FloatArray,
) -> int:
    """Write the largest x at all nodes, shape (m,), from ends[0] to ends[1].

    Returns:
        0; or where there is none: 1 if x[0] is too large, x[0] being the largest then, 2 if x[-1]
        is too large, x[-1] being the largest then, 3 if nothing is possible.
    """
    # Pham and Pham, A new approach to time-optimal path parameterization based on reachability
    # analysis, IEEE T-RO 34 (2018) 645: backward, the x from which the end can be reached; forward,
    # as fast as allowed below that. The linear programs are in one variable here: of the x[i] for
    # which what x[i + 1] must be at least is not more than what it may be
    cells = both.shape[0]
    most, least = x, np.zeros(cells + 1)
    most[cells] = ends[1]
    if ends[1] > cap[cells]:
        most[cells] = cap[cells]
        return 2
    moving = ends[1] > 0.0
    if moving:
        least[cells] = ends[1]
    line = -1
    for i in range(cells - 1, -1, -1):
        share = _GO_ON if i + 1 < cells else 0.0
        start = cap[i]
        if line >= 0:
            # the line that bound the cell behind is tried first: the most it allows is a bound
            c, e = both[i, 0, line], both[i, 1, line]
            if c > 0.0:
                start = min(start, (most[i + 1] + e) / c)
        bounds = (least[i + 1], most[i + 1], share)
        found, line = _meeting(both[i], above[i], below[i], bounds, start, -1.0)
        if moving and not found < math.inf:
            # no x leads on to so large a next one: what can be had is found without that
            least[:] = 0.0
            moving = False
            bounds = (0.0, most[i + 1], share)
            found, line = _meeting(both[i], above[i], below[i], bounds, start, -1.0)
        if not found < math.inf:
            return 3
        most[i] = found
        if moving:
            least[i], _ = _meeting(both[i], above[i], below[i], bounds, 0.0, 1.0)
            if not least[i] <= found:
                least[i] = found
    if ends[0] > most[0]:
        return 1
    x[0] = ends[0]
    for i in range(cells):
        x[i + 1] = max(0.0, min(_highest(both[i], above[i], x[i]), most[i + 1]))
    if x[cells] < ends[1] * (1.0 - 1e-9):
        return 2
    x[cells] = ends[1]
    return 0


@fast_kernel
def _meeting(
    both: FloatArray,
    above: FloatArray,
    below: FloatArray,
    bounds: tuple[float, float, float],
    x: float,
    way: float,
) -> tuple[float, int]:
    """Give the x[i] nearest to ``x`` from which x[i + 1] can be within bounds, and the line below.

    Args:
        both: Lines of the cell.
        above: Lines of the cell.
        below: Lines of the cell.
        bounds: Least and most x[i + 1], and the share of x[i] that it is at least.
        x: Where the search begins.
        way: In which direction it goes, -1 or 1. NaN: no such x there.
    """
    floor, ceiling, share = bounds
    line = -1
    # Newton's method on a concave function made of straight pieces: on to where the lines meet
    # that bind at x; computed from where they begin, since x may be larger by many powers of ten
    for _ in range(_PASSES):
        high, up, top = ceiling, 0.0, ceiling
        low, down, bottom = floor, 0.0, floor
        if share * x > low:
            low, down, bottom = share * x, share, 0.0
        line = -1
        for r in range(both.shape[1]):
            c, e = both[0, r], both[1, r]
            middle = c * x
            if middle + e < high:
                high, up, top = middle + e, c, e
            if middle - e > low:
                low, down, bottom, line = middle - e, c, -e, r
        for r in range(above.shape[1]):
            value = above[0, r] * x + above[1, r]
            if value < high:
                high, up, top = value, above[0, r], above[1, r]
        for r in range(below.shape[1]):
            value = below[0, r] * x - below[1, r]
            if value > low:
                low, down, bottom, line = value, below[0, r], -below[1, r], -1
        if high - low >= -1e-14 * (abs(high) + abs(low) + (abs(up) + abs(down)) * x):
            return x, line
        if (up - down) * way > 0.0:
            x = (top - bottom) / (down - up)
        elif way < 0.0 and floor <= 0.0:
            x *= 0.5  # rounding: standing still is always possible
        else:
            return math.nan, -1
    return (x if way < 0.0 else math.nan), line


@fast_kernel
def _highest(both: FloatArray, above: FloatArray, x: float) -> float:
    """Give the largest x[i + 1] behind x[i] = x."""
    high = math.inf
    for r in range(both.shape[1]):
        high = min(high, both[0, r] * x + both[1, r])
    for r in range(above.shape[1]):
        high = min(high, above[0, r] * x + above[1, r])
    return high


@fast_kernel
def most_used(both: FloatArray, above: FloatArray, below: FloatArray, x: FloatArray) -> float:
    """Give how far beyond its half-width a profile is from any line's centre, as a share; or 1."""
    worst = 1.0
    for i in range(both.shape[0]):
        before, behind = x[i], x[i + 1]
        for r in range(both.shape[2]):
            off = abs(behind - both[i, 0, r] * before)
            if off > worst * both[i, 1, r]:
                worst = off / both[i, 1, r]
        for r in range(above.shape[2]):
            off = behind - above[i, 0, r] * before
            if off > worst * above[i, 1, r]:
                worst = off / above[i, 1, r]
        for r in range(below.shape[2]):
            off = below[i, 0, r] * before - behind
            if off > worst * below[i, 1, r]:
                worst = off / below[i, 1, r]
    return worst
