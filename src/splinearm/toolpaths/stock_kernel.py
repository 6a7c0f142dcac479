"""A block of material as heights over a grid, and what a turning tool leaves of it, compiled.

A height is that of the material over one place; the places are the middles of square cells. What a
straight way leaves there is worked out exactly: the lowest that the tool's end gets over it.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

_GOLD = 0.6180339887498949
_EDGE = 0.05
"""What only the outermost share of a cell of a tool gets is no depth: chords of the same curve may
differ there.
"""


@fast_kernel
def _end(kind: float, radius: float, slope: float, far: float) -> float:
    """Give how high over its tip a tool's end is at a distance from its axis."""
    if kind == 0.0:
        return 0.0
    if kind == 1.0:
        return radius - math.sqrt(max(0.0, radius * radius - far * far))
    return far * slope


@fast_kernel
def _lowest(way: FloatArray, w: int, tool: tuple[float, float, float], x: float, y: float) -> float:
    """Give the lowest that a tool gets over a place along a straight way; infinite: not at all."""
    kind, radius, slope = tool
    none = math.inf
    px, py, pz = way[w, 0], way[w, 1], way[w, 2]
    ex, ey, ez = way[w, 3] - px, way[w, 4] - py, way[w, 5] - pz
    qx, qy = x - px, y - py
    e2 = ex * ex + ey * ey
    if e2 == 0.0:
        far = math.hypot(qx, qy)
        over: float = min(pz, pz + ez) + _end(kind, radius, slope, far)
        return none if far > radius else over
    foot = (qx * ex + qy * ey) / e2
    off2 = max(0.0, qx * qx + qy * qy - foot * foot * e2)
    half = math.sqrt(max(0.0, radius * radius - off2) / e2)
    low, high = max(0.0, foot - half), min(1.0, foot + half)
    if off2 > radius * radius or low > high:
        return none
    if kind == 0.0:
        flat: float = pz + (low * ez if ez > 0.0 else high * ez)
        return flat
    if ez == 0.0:
        t = max(low, min(high, foot))
        level: float = pz + _end(kind, radius, slope, math.sqrt(off2 + (t - foot) ** 2 * e2))
        return level
    # it is convex along the way: a golden section finds its least
    a, b = low, high
    for _ in range(24):
        c, d = b - _GOLD * (b - a), a + _GOLD * (b - a)
        hc = c * ez + _end(kind, radius, slope, math.sqrt(off2 + (c - foot) ** 2 * e2))
        hd = d * ez + _end(kind, radius, slope, math.sqrt(off2 + (d - foot) ** 2 * e2))
        if hc < hd:
            b = d
        else:
            a = c
    t = 0.5 * (a + b)
    far = math.sqrt(off2 + (t - foot) ** 2 * e2)
    lowest: float = pz + t * ez + _end(kind, radius, slope, far)
    return lowest


@fast_kernel
def carve(
    heights: FloatArray,
    grid: tuple[float, float, float],
    ways: FloatArray,
    tools: FloatArray,
    found: FloatArray,
) -> None:
    """Take away what tools take away on their ways, one after the other.

    Args:
        heights: Heights of the material by row (y) and column (x); lowered in place.
        grid: x and y of the middle of the first cell, and the size of cells.
        ways: Straight ways, ``x y z x y z``, shape (m, 6).
        tools: Of each way its tool: kind of its end (0 flat, 1 a ball, 2 a cone), radius, and how
            a cone rises, shape (m, 3).
        found: Of each way how deep it goes into the material, where (x, y), and how much of it is
            taken away, shape (m, 4).
    """
    x0, y0, cell = grid
    rows, columns = heights.shape
    for w in range(ways.shape[0]):
        tool = (tools[w, 0], tools[w, 1], tools[w, 2])
        r = tools[w, 1]
        inner = (tools[w, 0], max(0.5 * r, r - _EDGE * cell), tools[w, 2])
        ax, ay, bx, by = ways[w, 0], ways[w, 1], ways[w, 3], ways[w, 4]
        first = max(0, math.ceil((min(ay, by) - r - y0) / cell))
        last = min(rows - 1, math.floor((max(ay, by) + r - y0) / cell))
        deepest, dx, dy, volume = 0.0, 0.0, 0.0, 0.0
        for i in range(first, last + 1):
            y = y0 + i * cell
            low, high = min(ax, bx) - r, max(ax, bx) + r
            if ay != by:
                # of the row only what is within the radius of the way
                t0, t1 = (y - r - ay) / (by - ay), (y + r - ay) / (by - ay)
                t0, t1 = max(0.0, min(t0, t1)), min(1.0, max(t0, t1))
                u0, u1 = ax + t0 * (bx - ax), ax + t1 * (bx - ax)
                low, high = min(u0, u1) - r, max(u0, u1) + r
            left = max(0, math.ceil((low - x0) / cell))
            right = min(columns - 1, math.floor((high - x0) / cell))
            for j in range(left, right + 1):
                x = x0 + j * cell
                height = _lowest(ways, w, tool, x, y)
                deep = heights[i, j] - height
                if deep > 0.0:
                    volume += deep
                    if deep > deepest:
                        deep = heights[i, j] - _lowest(ways, w, inner, x, y)
                        if deep > deepest:
                            deepest, dx, dy = deep, x, y
                    heights[i, j] = height
        found[w, 0], found[w, 1], found[w, 2] = deepest, dx, dy
        found[w, 3] = volume * cell * cell


@fast_kernel
def filled(
    corners: FloatArray, starts: FloatArray, grid: tuple[float, float, float], found: FloatArray
) -> None:
    """Write 1 into the cells of a grid whose middles closed polygons go around, else 0.

    Args:
        corners: Corners of polygons one after the other, shape (m, 2).
        starts: The first corner of each and m.
        grid: x and y of the middle of the first cell, and the size of cells.
        found: The grid, by row (y) and column (x).
    """
    x0, y0, cell = grid
    rows, columns = found.shape
    found[:, :] = 0.0
    flips = np.zeros((rows, columns + 1))
    for loop in range(starts.shape[0] - 1):
        begin, end = int(starts[loop]), int(starts[loop + 1])
        for k in range(begin, end):
            m = k + 1 if k + 1 < end else begin
            ax, ay, bx, by = corners[k, 0], corners[k, 1], corners[m, 0], corners[m, 1]
            if ay == by:
                continue
            first = max(0, math.ceil((min(ay, by) - y0) / cell))
            last = min(rows - 1, math.floor((max(ay, by) - y0) / cell))
            for i in range(first, last + 1):
                y = y0 + i * cell
                if (ay > y) != (by > y):
                    x = ax + (y - ay) / (by - ay) * (bx - ax)
                    j = max(0, min(columns, math.ceil((x - x0) / cell)))
                    flips[i, j] += 1.0
    for i in range(rows):
        inside = 0.0
        for j in range(columns):
            if flips[i, j] % 2.0 == 1.0:
                inside = 1.0 - inside
            found[i, j] = inside
