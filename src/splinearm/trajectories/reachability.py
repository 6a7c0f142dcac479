"""The quickest x(s) under linear inequalities between neighbours, on bare arrays.

x is the square of ds/dt at nodes; rows a x[i] + b x[i + 1] <= 1 of each cell say what is allowed.
Standing still is always allowed and the allowed pairs of a cell are convex, so every profile may
be slowed down: from below any allowed one there is always a way on.
"""

import numpy as np

from splinearm.arrays import FloatArray

from .constraint import Rows

_TINY = 1e-200

_ROUNDING = 1e-12
"""Below this share of its other factor a factor of a row is rounding."""

_NOTHING = 1e-60
"""Rows below this share of the largest of their cell never count."""

_GO_ON = 0.02
"""A cell inside the path never ends below this share of its x: nothing comes to a halt there."""

_PASSES = 100


def fastest(rows: Rows) -> FloatArray:
    """Give the largest x at all nodes, shape (cells + 1,), at rest at both ends."""
    # Pham and Pham, A new approach to time-optimal path parameterization based on reachability
    # analysis, IEEE T-RO 34 (2018) 645: backward, the largest x from which the end can be reached;
    # forward, as fast as allowed below that. The linear programs are in one variable here: of the
    # largest x[i] for which what x[i + 1] must be at least is not more than what it may be
    lines = _Lines(rows)
    cells = len(rows.a)
    most = np.zeros(cells + 1)
    for i in range(cells - 1, -1, -1):
        most[i] = lines.largest_before(i, most[i + 1], _GO_ON if i + 1 < cells else 0.0)
    x = np.zeros(cells + 1)
    for i in range(cells):
        x[i + 1] = min(lines.highest_behind(i, x[i]), most[i + 1])
    x[-1] = 0.0
    return x


def lowest_behind(a: FloatArray, b: FloatArray, x: float) -> float:
    """Give the least x[i + 1], 0 or more, that the rows of one cell allow behind x[i] = x.

    It is told by the rows that ask for more; that others allow it is for the caller to know.
    """
    down = b < 0.0
    return max(0.0, float(((1.0 - a[down] * x) / b[down]).max(initial=0.0)))


class _Lines:
    """The rows as lines c + m x[i] that bound x[i + 1] from above and from below."""

    def __init__(self, rows: Rows) -> None:
        # rows that hardly know of x[i + 1] limit x[i] alone; as lines they would be all rounding
        lone = np.abs(rows.b) <= _ROUNDING * np.abs(rows.a)
        size = np.maximum(np.abs(rows.a), np.abs(rows.b))
        felt = size > _NOTHING * size.max(axis=1, keepdims=True)
        upper, lower = felt & ~lone & (rows.b > 0.0), felt & ~lone & (rows.b < 0.0)
        b = np.where(upper | lower, rows.b, 1.0)
        offset, slope = 1.0 / b, -rows.a / b
        self.offset_above = np.where(upper, offset, np.inf)
        self.slope_above = np.where(upper, slope, 0.0)
        self.offset_below = np.where(lower, offset, -np.inf)
        self.slope_below = np.where(lower, slope, 0.0)
        # where x[i + 1] only adds to a row, x[i] alone must stay below 1 / a
        alone = felt & (rows.a > 0.0) & (upper | lone)
        self.cap = 1.0 / np.where(alone, rows.a, _TINY).max(axis=1)

    def highest_behind(self, i: int, x: float) -> float:
        """Give the largest x[i + 1] that x[i] = x allows."""
        return float((self.offset_above[i] + self.slope_above[i] * x).min())

    def largest_before(self, i: int, most: float, share: float) -> float:
        """Give the largest x[i] from which x[i + 1] can be in [share x[i], most]."""
        above, above_slope = self.offset_above[i], self.slope_above[i]
        below, below_slope = self.offset_below[i], self.slope_below[i]
        x = float(self.cap[i])
        # Newton's method from above on a concave function made of straight pieces
        for _ in range(_PASSES):
            highs = above + above_slope * x
            lows = below + below_slope * x
            j, k = int(highs.argmin()), int(lows.argmax())
            high, high_slope = float(highs[j]), float(above_slope[j])
            low, low_slope = float(lows[k]), float(below_slope[k])
            if high > most:
                high, high_slope = most, 0.0
            if low < share * x:
                low, low_slope = share * x, share
            gap = high - low
            if gap >= -1e-14 * (abs(high) + abs(low)):
                return max(x, 0.0)
            slope = high_slope - low_slope
            x -= gap / slope
        return max(x, 0.0)
