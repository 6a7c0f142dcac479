"""A tree of boxes over pieces in the order in which they follow each other, compiled.

Pieces that follow each other lie near each other, so that runs of them make good boxes and nothing
needs to be sorted. Node 1 is the root, node j has the children 2 j and 2 j + 1, and the last half
of the nodes are runs of `RUN` pieces. A node is a row: least x and y, largest x and y.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .arc_kernel import box_of, distance

RUN = 4
_FEW = 160
"""Loops of no more pieces are searched quickly enough anyway."""
_TURNED = 0.5
"""Three sides that turn less from each other are touched by discs too large to be known well."""

Disc = tuple[float, float, float]
"""The centre (x, y), and the radius."""


@fast_kernel
def tree_of(P: FloatArray, count: int, slack: float) -> FloatArray:
    """Give the tree over the first pieces, each box wider by a slack to all sides."""
    leaves = 1
    while leaves * RUN < count:
        leaves *= 2
    T = np.empty((2 * leaves, 4))
    for leaf in range(leaves):
        x0, y0, x1, y1 = math.inf, math.inf, -math.inf, -math.inf
        for i in range(leaf * RUN, min(count, leaf * RUN + RUN)):
            bx0, by0, bx1, by1 = box_of(P, i)
            x0, y0, x1, y1 = min(x0, bx0), min(y0, by0), max(x1, bx1), max(y1, by1)
        node = leaves + leaf
        T[node, 0], T[node, 1], T[node, 2], T[node, 3] = (
            x0 - slack,
            y0 - slack,
            x1 + slack,
            y1 + slack,
        )
    for node in range(leaves - 1, 0, -1):
        left, right = 2 * node, 2 * node + 1
        T[node, 0], T[node, 1] = min(T[left, 0], T[right, 0]), min(T[left, 1], T[right, 1])
        T[node, 2], T[node, 3] = max(T[left, 2], T[right, 2]), max(T[left, 3], T[right, 3])
    return T


@bare_kernel
def _box_distance2(T: FloatArray, node: int, x: float, y: float) -> float:
    """Give the square of how far a point is from a box."""
    dx = max(T[node, 0] - x, 0.0, x - T[node, 2])
    dy = max(T[node, 1] - y, 0.0, y - T[node, 3])
    far2: float = dx * dx + dy * dy
    return far2


@bare_kernel
def nearest(
    P: FloatArray,
    count: int,
    T: FloatArray,
    point: tuple[float, float],
    bounds: tuple[float, float],
    stack: FloatArray,
) -> tuple[float, int]:
    """Give the nearest piece that is nearer than a bound, and how far it is.

    Args:
        P: Pieces.
        count: How many there are.
        T: Their tree.
        point: The point.
        bounds: What a piece must be nearer than, and what is near enough to stop looking.
        stack: Room, shape (128, 2).

    Returns:
        The distance, and the piece; the bound and -1 if there is none.
    """
    x, y = point
    best, enough = bounds
    found = -1
    leaves = T.shape[0] // 2
    stack[0, 0], stack[0, 1] = 1.0, _box_distance2(T, 1, x, y)
    top = 1
    while top > 0:
        top -= 1
        node = int(stack[top, 0])
        if stack[top, 1] >= best * best:
            continue
        if node >= leaves:
            first = (node - leaves) * RUN
            for i in range(first, min(count, first + RUN)):
                far = distance(P, i, x, y)
                if far < best:
                    best, found = far, i
            if best < enough:
                return best, found
            continue
        left = 2 * node
        dl, dr = _box_distance2(T, left, x, y), _box_distance2(T, left + 1, x, y)
        # the nearer child on top
        if dl <= dr:
            stack[top, 0], stack[top, 1] = left + 1, dr
            stack[top + 1, 0], stack[top + 1, 1] = left, dl
        else:
            stack[top, 0], stack[top, 1] = left, dl
            stack[top + 1, 0], stack[top + 1, 1] = left + 1, dr
        top += 2
    return best, found


@bare_kernel
def heart_of(P: FloatArray, T: FloatArray, loops: FloatArray, stack: FloatArray) -> Disc:
    """Give a disc that no piece reaches into, about the middle of the longest loop.

    Where many sides are all but equally far from one place, as those of a circle of chords are
    from its middle, boxes do not tell which are nearer to a point there, and all would be asked
    for each. The disc answers for all of them, if it is large enough.
    """
    first, size = 0, 0
    for loop in range(loops.shape[0] - 1):
        if int(loops[loop + 1] - loops[loop]) > size:
            first, size = int(loops[loop]), int(loops[loop + 1] - loops[loop])
    if size <= _FEW:
        return 0.0, 0.0, 0.0
    # the point as far from three of its sides
    i, j, k = first, first + size // 3, first + 2 * size // 3
    b = P[i, 5] * P[i, 0] + P[i, 6] * P[i, 1]
    ux, uy = P[j, 5] - P[i, 5], P[j, 6] - P[i, 6]
    vx, vy = P[k, 5] - P[i, 5], P[k, 6] - P[i, 6]
    u = P[j, 5] * P[j, 0] + P[j, 6] * P[j, 1] - b
    v = P[k, 5] * P[k, 0] + P[k, 6] * P[k, 1] - b
    det = ux * vy - uy * vx
    if abs(det) < _TURNED:
        return 0.0, 0.0, 0.0
    x, y = (u * vy - v * uy) / det, (ux * v - vx * u) / det
    return x, y, nearest(P, P.shape[0], T, (x, y), (math.inf, 0.0), stack)[0]


@bare_kernel
def is_clear(heart: Disc, x: float, y: float, far: float) -> bool:
    """Say whether a disc without pieces shows that none is nearer to a point than so much."""
    room = heart[2] - far
    clear: bool = room >= 0.0 and (x - heart[0]) ** 2 + (y - heart[1]) ** 2 <= room * room
    return clear


@bare_kernel
def overlapping(
    T: FloatArray, box: tuple[float, float, float, float], after: int, runs: FloatArray
) -> int:
    """Write the runs of pieces whose boxes overlap a box and that go on beyond a piece.

    Returns:
        How many there are; ``runs`` has room for all and 128 more, which are used as a stack.
    """
    x0, y0, x1, y1 = box
    leaves = T.shape[0] // 2
    base = runs.shape[0] - 128
    runs[base] = 1.0
    top, count = 1, 0
    while top > 0:
        top -= 1
        node = int(runs[base + top])
        if T[node, 0] > x1 or T[node, 2] < x0 or T[node, 1] > y1 or T[node, 3] < y0:
            continue
        if node >= leaves:
            if (node - leaves) * RUN + RUN > after:
                runs[count] = node - leaves
                count += 1
        else:
            runs[base + top], runs[base + top + 1] = 2 * node, 2 * node + 1
            top += 2
    return count
