"""Where along a contour something stays between two rings, compiled: see ``ridge``."""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .offset_kernel import pieces_of
from .tree_kernel import nearest, tree_of

_RAYS = 8
_LEFT = 0.86
"""Something stays where a look is farther from the next ring than so many radii: looks are near
enough to each other that nothing between them is farther than one."""

Loops = tuple[FloatArray, FloatArray, FloatArray]
"""Vertices, bulges, and the first vertex of each loop and how many there are."""


@fast_kernel
def looked_along(
    contours: Loops, part: Loops, inner: Loops, sizes: tuple[float, float, float], step: float
) -> tuple[FloatArray, FloatArray]:
    """Give places along contours, from corner to corner, and what is seen from them.

    Args:
        contours: What is looked along.
        part: The part.
        inner: The inner ring.
        sizes: How far contours are from the part, how far the ring is from them where straight
            ways lead there, and the cutter's radius.
        step: How far places are apart at most.

    Returns:
        Rows of how far along its contour a place is, 1 if no way from it leads to the ring in that
        distance, else 0, and 1 if besides something stays; and the first row of each contour and
        how many there are.
    """
    P, _, _ = pieces_of(part[0], part[1], part[2], 0.0)
    R, _, _ = pieces_of(inner[0], inner[1], inner[2], 0.0)
    T, TR = tree_of(P, P.shape[0], 0.0), tree_of(R, R.shape[0], 0.0)
    vertices, bulges, starts = contours
    counts, lengths = np.empty(bulges.shape[0]), np.empty(bulges.shape[0])
    total = 0
    for loop in range(starts.shape[0] - 1):
        first, end = int(starts[loop]), int(starts[loop + 1])
        for i in range(first, end):
            j = i + 1 if i + 1 < end else first
            c = math.hypot(vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1])
            half = 2.0 * math.atan(bulges[i])
            lengths[i] = c * half / math.sin(half) if abs(half) > 1e-8 else c
            counts[i] = max(1.0, math.ceil(lengths[i] / step)) if c > 0.0 else -1.0
            total += int(counts[i]) + 1
    rows, begins = np.empty((total, 3)), np.empty(starts.shape[0])
    stack = np.empty((128, 2))
    scene = (P, T, R, TR)
    n = 0
    for loop in range(starts.shape[0] - 1):
        first, end = int(starts[loop]), int(starts[loop + 1])
        begins[loop] = n
        mark = 0.0
        for i in range(first, end):
            j = i + 1 if i + 1 < end else first
            ends = (vertices[i, 0], vertices[i, 1], vertices[j, 0], vertices[j, 1])
            for k in range(int(counts[i]) + 1):
                share = k / counts[i]
                open_, left = _seen(ends, (bulges[i], share), scene, sizes, stack)
                rows[n, 0], rows[n, 1], rows[n, 2] = mark + lengths[i] * share, open_, left
                n += 1
            mark += lengths[i]
    begins[starts.shape[0] - 1] = n
    return rows, begins


@bare_kernel
def _seen(
    ends: tuple[float, float, float, float],
    at: tuple[float, float],
    scene: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    sizes: tuple[float, float, float],
    stack: FloatArray,
) -> tuple[float, float]:
    """Say whether a place of a segment is open, and whether something stays ahead of it."""
    P, T, R, TR = scene
    level, beyond, radius = sizes
    bulge, share = at
    half = 2.0 * math.atan(bulge)
    ex, ey = ends[2] - ends[0], ends[3] - ends[1]
    c = math.sqrt(ex * ex + ey * ey)
    grown = share if abs(half) < 1e-12 else math.sin(share * half) / math.sin(half)
    co, si = math.cos((share - 1.0) * half), math.sin((share - 1.0) * half)
    x = ends[0] + grown * (co * ex - si * ey)
    y = ends[1] + grown * (si * ex + co * ey)
    reach = beyond * (1.0 + 1e-6)
    if nearest(R, R.shape[0], TR, (x, y), (reach, reach), stack)[1] >= 0:
        return 0.0, 0.0
    co, si = math.cos((2.0 * share - 1.0) * half) / c, math.sin((2.0 * share - 1.0) * half) / c
    nx, ny = -(si * ex + co * ey), co * ex - si * ey
    for ray in range(_RAYS):
        far = beyond * ray / (_RAYS - 1)
        spot = (x + far * nx, y + far * ny)
        # on its way from the wall a place is farther by as much as it went
        reach = level + far - 1e-9 * (level + beyond)
        if nearest(P, P.shape[0], T, spot, (reach, reach), stack)[1] >= 0:
            continue
        reach = _LEFT * radius
        if nearest(R, R.shape[0], TR, spot, (reach, reach), stack)[1] < 0:
            return 1.0, 1.0
    return 1.0, 0.0
