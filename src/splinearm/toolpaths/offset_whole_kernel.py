"""What is wrong with an offset, if something is, compiled.

Its loops are measured, walked along (``offset_walk_kernel``), and looked at from both sides. What
is proven: all of the result is as far from the part as it should be; each region that is left is
in it, but for such as have no side longer than a millionth of the size; no contour of the part is
enclosed, and each loop has on its left what is left and on its right what is not. Where corners are
not round, sides and corners are probed at steps of an eighth of their length instead.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .offset_check_kernel import loops_of_segments, middle, tree_about
from .offset_touch_kernel import touching
from .offset_walk_kernel import DEEPER, SPANS, Scene, missing
from .offset_within_kernel import encloses, nearest

GOUGE, FAR, MISSING = 1.0, 2.0, 3.0


@bare_kernel
def _misplaced(
    owners: tuple[FloatArray, FloatArray], scene: Scene, d: float
) -> tuple[bool, float, float]:
    """Say whether a contour is enclosed, or a loop does not have what is left on its left side.

    Args:
        owners: The first segment of each loop of the part, and of each of the result.
        scene: As `_left_over` takes it.
        d: The distance.
    """
    Q, T, R, TR, _, outside, room, _ = scene
    outward = outside > 0.0
    for loop in range(owners[0].shape[0] - 1):
        i = int(owners[0][loop])
        if i < owners[0][loop + 1] and encloses(R, TR, Q[i, 0], Q[i, 1], room) != outward:
            return True, Q[i, 0], Q[i, 1]
    for loop in range(owners[1].shape[0] - 1):
        best, longest = -1, 0.0
        for r in range(int(owners[1][loop]), int(owners[1][loop + 1])):
            c2 = (R[r, 2] - R[r, 0]) ** 2 + (R[r, 3] - R[r, 1]) ** 2
            if c2 > longest:
                best, longest = r, c2
        if best < 0:
            continue
        x, y = middle(R, best)
        if encloses(Q, T, x, y, room) == outward:
            return True, x, y
        off = min(1e-7, 1e-3 * math.sqrt(longest)) / math.sqrt(longest)
        for side in (1.0, -1.0):
            u = x - side * off * (R[best, 3] - R[best, 1])
            v = y + side * off * (R[best, 2] - R[best, 0])
            far, _ = nearest(Q, T, (u, v), (math.inf, 0.0), room)
            # where it lies elsewhere, something else is as near
            clear = far > d + 1e-9 if side > 0.0 else far < d - 1e-9
            if clear and (encloses(R, TR, u, v, room) != outward) != (side > 0.0):
                return True, u, v
    return False, 0.0, 0.0


@fast_kernel
def part_of(
    vertices: FloatArray, bulges: FloatArray, starts: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give what results are compared with: segments, the first of each loop, and the tree."""
    Q, firsts = loops_of_segments(vertices, bulges, starts)
    return Q, firsts, tree_about(Q)


@fast_kernel
def verdict(
    result: tuple[FloatArray, FloatArray, FloatArray],
    part: tuple[FloatArray, FloatArray, FloatArray],
    reaches: tuple[float, float],
    tolerance: float,
    outward: float,
) -> tuple[float, float, float, float]:
    """Say what is wrong with an offset to the left.

    Args:
        result: Vertices, bulges and first vertices of its loops.
        part: What `part_of` gives.
        reaches: The distance, and how far corners may be as a multiple of it.
        tolerance: What is rounding.
        outward: 1 if what is offset is what the loops do not enclose, else 0.

    Returns:
        0, `GOUGE`, `FAR` or `MISSING`; where (x, y); and by how much.
    """
    d, reach = reaches
    Q, firsts, T = part
    R, begins = loops_of_segments(result[0], result[1], result[2])
    found = np.zeros(6)
    slack = max(reach - 1.0, 1e-6) * d + 4.0 * tolerance
    pairs, count = touching(R, Q, T, (d, slack), found)
    if not found[0] >= d - tolerance:
        return GOUGE, found[1], found[2], d - found[0]
    if not found[3] <= reach * d + tolerance:
        return FAR, found[4], found[5], found[3] - d
    beyond = d if reach == 1.0 else reach * d * (1.0 + 1e-6)
    scene = (
        Q,
        T,
        R,
        tree_about(R),
        beyond + max(10.0 * tolerance, min(DEEPER, 1e-3 * d)),
        outward,
        np.empty((128, 2)),
        np.empty((SPANS, 2)),
    )
    lost, x, y = _misplaced((firsts, begins), scene, d)
    if not lost:
        lost, x, y = missing(pairs, count, firsts, scene, reaches)
    return (MISSING if lost else 0.0), x, y, 0.0
