"""Ways that run along each other and then part to the other side, compiled."""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .arc_kernel import at_share, box_of, distance, share
from .contour_kernel import shared
from .tree_kernel import RUN, overlapping, tree_of

_BACK = 1e-6
"""A way that turns by half a turn but for this turns straight back."""
_NEAR = 0.05
"""So small a share of them the places are at which ways are compared."""

Pair = tuple[int, int, float]
"""Two pieces that lie along each other, and 1 if in one direction, -1 if against each other."""


@fast_kernel
def first_crossing_along(
    P: FloatArray, loops: FloatArray, tiny: float
) -> tuple[int, int, float, float]:
    """Give the first two pieces along which ways cross, and where they meet; -1: none do.

    Args:
        P: Pieces of closed loops.
        loops: The first piece of each loop and how many there are.
        tiny: What is nothing.
    """
    n = P.shape[0]
    T = tree_of(P, n, tiny)
    runs = np.empty(T.shape[0] + 128)
    behind, before = np.arange(1.0, n + 1.0), np.arange(-1.0, n - 1.0)
    for loop in range(loops.shape[0] - 1):
        first, end = int(loops[loop]), int(loops[loop + 1])
        if end > first:
            behind[end - 1], before[first] = first, end - 1
    order = (behind, before)
    for i in range(n):
        count = overlapping(T, box_of(P, i), i + 1, runs)
        for r in range(count):
            start = int(runs[r]) * RUN
            for j in range(max(start, i + 1), min(n, start + RUN)):
                along, x, y = shared(P, i, j, tiny)
                if not along:
                    continue
                ux, uy = _onwards(P, i, (x, y), 1.0, math.inf)
                vx, vy = _onwards(P, j, (x, y), 1.0, math.inf)
                same = 1.0 if ux * vx + uy * vy > 0.0 else -1.0
                # from where they come together, which is found from there alone
                on, side, x, y = _parted(P, order, (i, j, same), -1.0, tiny)
                if on[0] >= 0 or side == 0.0:
                    continue
                pair, other = (i, j, same), 0.0
                for _ in range(n):
                    on, other, _, _ = _parted(P, order, pair, 1.0, tiny)
                    if on[0] < 0:
                        break
                    pair = on
                if on[0] < 0 and side * other > 0.0:
                    return i, j, x, y
    return -1, -1, 0.0, 0.0


@bare_kernel
def _parted(
    P: FloatArray, order: tuple[FloatArray, FloatArray], pair: Pair, ahead: float, tiny: float
) -> tuple[Pair, float, float, float]:
    """Follow two pieces along each other to where one of them ends.

    Args:
        P: Pieces.
        order: The piece behind each, and the one before.
        pair: The pieces.
        ahead: 1 along the first piece, -1 against it.
        tiny: What is nothing.

    Returns:
        The next pair along each other, or of -1 if they part there; then 1 if the second way goes
        to the left of the first, as it is followed, -1 if to the right, 0 if it cannot be said; and
        where that is.
    """
    i, j, same = pair
    to_i, to_j = 2 if ahead > 0.0 else 0, 2 if ahead * same > 0.0 else 0
    x, y = P[i, to_i], P[i, to_i + 1]
    u, v = P[j, to_j], P[j, to_j + 1]
    i_on = int(order[0 if ahead > 0.0 else 1][i])
    j_on = int(order[0 if ahead * same > 0.0 else 1][j])
    none = (-1, -1, 0.0)
    if max(abs(x - u), abs(y - v)) > 2.0 * tiny:
        if distance(P, j, x, y) <= tiny:
            j_on = j
        else:
            x, y, i_on = u, v, i
    if i_on in (j_on, j) or j_on == i:
        return none, 0.0, x, y  # the tip of a spike: both are one way
    if shared(P, i_on, j_on, tiny)[0]:
        # it goes on, if it is from here that they do
        sx, sy = _onwards(P, i_on, (x, y), ahead, math.inf)
        tx, ty = _onwards(P, j_on, (x, y), ahead * same, math.inf)
        if sx * tx + sy * ty > 0.0:
            return (i_on, j_on, same), 0.0, x, y
    h = min(_room(P, i_on, (x, y), ahead), _room(P, j_on, (x, y), ahead * same))
    # all of them equally far from there, and near: ways that do not cross keep their order
    h = _NEAR * min(h, _room(P, i, (x, y), -ahead))
    bx, by = _onwards(P, i, (x, y), -ahead, h)
    sx, sy = _onwards(P, i_on, (x, y), ahead, h)
    tx, ty = _onwards(P, j_on, (x, y), ahead * same, h)
    first = math.atan2(-bx * sy + by * sx, -bx * sx - by * sy)
    second = math.atan2(-bx * ty + by * tx, -bx * tx - by * ty)
    level = 4.0 * tiny / max(h, 1e-300) + 1e-12
    back = max(abs(first), abs(second)) > math.pi - _BACK
    if back or abs(second - first) <= level:
        return none, 0.0, x, y
    return none, 1.0 if second > first else -1.0, x, y


@bare_kernel
def _room(P: FloatArray, i: int, spot: tuple[float, float], ahead: float) -> float:
    """Give how far it is from a place of a piece to its end, or to its start, along the chord."""
    end = 2 if ahead > 0.0 else 0
    return math.hypot(P[i, end] - spot[0], P[i, end + 1] - spot[1])


@bare_kernel
def _onwards(
    P: FloatArray, i: int, spot: tuple[float, float], ahead: float, h: float
) -> tuple[float, float]:
    """Give the way from a place of a piece to another on it, farther on by about so much."""
    c = math.hypot(P[i, 2] - P[i, 0], P[i, 3] - P[i, 1])
    u = share(P, i, spot[0], spot[1])
    x, y = at_share(P, i, max(0.0, min(1.0, u + ahead * min(2.0, h / c))))
    return x - spot[0], y - spot[1]
