"""Which of many loops is nearest to a place, and which loops lie beside each other, compiled."""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel

from .arc_kernel import distance


@bare_kernel
def nearest_loop(
    P: FloatArray, loops: FloatArray, wanted: FloatArray, x: float, y: float, found: FloatArray
) -> None:
    """Write which of the wanted loops is nearest to a point, how far, the piece and the foot.

    Args:
        P: Pieces of all loops.
        loops: The first piece of each loop and the number of all.
        wanted: Above 0 for loops that count.
        x: The point's
        y: coordinates.
        found: Loop, distance, piece, and x and y of the foot, shape (5,); the loop is -1 if none.
    """
    best = math.inf
    found[0] = -1.0
    for loop in range(loops.shape[0] - 1):
        if wanted[loop] > 0.0:
            for i in range(int(loops[loop]), int(loops[loop + 1])):
                far = distance(P, i, x, y)
                if far < best:
                    best = far
                    found[0], found[1], found[2] = loop, far, i
    if found[0] >= 0.0:
        found[3], found[4] = foot(P, int(found[2]), x, y)


@bare_kernel
def foot(P: FloatArray, i: int, x: float, y: float) -> tuple[float, float]:
    """Give the place of a piece that is nearest to a point."""
    qx, qy = x - P[i, 0], y - P[i, 1]
    if qx * P[i, 6] - qy * P[i, 5] <= 0.0:
        return P[i, 0], P[i, 1]
    rx, ry = x - P[i, 2], y - P[i, 3]
    if rx * P[i, 8] - ry * P[i, 7] >= 0.0:
        return P[i, 2], P[i, 3]
    k = P[i, 4]
    gx, gy = P[i, 5] - k * qx, P[i, 6] - k * qy
    g = qx * P[i, 5] + qy * P[i, 6] - 0.5 * k * (qx * qx + qy * qy)
    w = math.sqrt(gx * gx + gy * gy)
    off = 2.0 * g / (1.0 + w)
    return x - off * gx / w, y - off * gy / w


@bare_kernel
def beside(
    P: FloatArray, loops: FloatArray, levels: FloatArray, reach: float, near: FloatArray
) -> None:
    """Write which loops lie beside loops farther out, at most two levels away.

    Args:
        P: Pieces of all loops.
        loops: The first piece of each loop and the number of all.
        levels: The level of each loop; level 0 is the outermost.
        reach: How far a loop may be from one that lies beside it.
        near: Set to 1 where the loop of the first index lies beside that of the second.
    """
    count = loops.shape[0] - 1
    for a in range(count):
        for i in range(int(loops[a]), int(loops[a + 1])):
            x, y = P[i, 0], P[i, 1]
            for b in range(count):
                if levels[a] - 2.0 <= levels[b] < levels[a] and near[a, b] == 0.0:
                    for j in range(int(loops[b]), int(loops[b + 1])):
                        if distance(P, j, x, y) <= reach:
                            near[a, b] = 1.0
                            break
