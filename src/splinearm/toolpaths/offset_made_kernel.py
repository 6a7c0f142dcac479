"""An offset from the part to loops that were checked, in one call, compiled."""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, entry, fast_kernel, inputs, numbers

from .loop_kernel import offset_loops
from .offset_corner_kernel import Corner
from .offset_kernel import pieces_of
from .offset_whole_kernel import part_of, verdict
from .tree_kernel import tree_of

_ROUNDING = 1e-11
"""What a result may be off by, as a share of the size of the part and the distance."""
_NUDGES = (0.0, 0.0, 1e-12, -1e-12, 3e-12, -1e-11)
"""Shares of the size by which the distance is changed in turn if no loops close; at the second
attempt all is looked at for whether it is in the part at all, which costs more."""
_TINY = 1e-14
"""Segments with chords below this share of the size are none."""

OPEN = 4.0
"""What is wrong where the loops do not close, besides what a verdict says."""

Model = tuple[
    FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray
]
"""Pieces, the segment of each, the first of each loop, their tree; segments to compare with, the
first of each loop, their tree; and the frame: the origin (x, y), and the unit."""


Verdict = tuple[float, float, float, float]
"""What is wrong, where (x, y), and by how much."""


@bare_kernel
def _turn(vertices: FloatArray, bulges: FloatArray, starts: FloatArray) -> None:
    """Let closed loops be run through the other way, from the same vertices on."""
    for loop in range(starts.shape[0] - 1):
        low, high = int(starts[loop]), int(starts[loop + 1]) - 1
        for k in range((high - low + 1) // 2):
            a, b = low + k, high - k
            bulges[a], bulges[b] = bulges[b], bulges[a]
        for k in range((high - low) // 2):
            a, b = low + 1 + k, high - k
            for c in range(2):
                vertices[a, c], vertices[b, c] = vertices[b, c], vertices[a, c]
        for i in range(low, high + 1):
            bulges[i] = -bulges[i]


@fast_kernel
def _prepared(
    vertices: FloatArray, bulges: FloatArray, starts: FloatArray, reach: float, turned: float
) -> Model:
    """Give closed loops moved to the origin and scaled to about 1, as pieces in a tree.

    Args:
        vertices: Where segments begin, loop after loop, shape (m, 2).
        bulges: Their bulges, shape (m,).
        starts: The first vertex of each loop and m, shape (loops + 1,).
        reach: The scale is at least this.
        turned: 1 if they are to be run through the other way, else 0.
    """
    x0, y0, x1, y1 = math.inf, math.inf, -math.inf, -math.inf
    bent, reaches = 0.0, 0.0
    m = vertices.shape[0]
    for i in range(m):
        x, y = vertices[i, 0], vertices[i, 1]
        x0, y0, x1, y1 = min(x0, x), min(y0, y), max(x1, x), max(y1, y)
        bent = max(bent, abs(bulges[i]))
    extent = max(x1 - x0, y1 - y0)
    if bent > 1.0:
        # arcs of more than half a turn may reach far beyond their ends
        for i in range(m):
            if abs(bulges[i]) > 1.0:
                j = 0
                for loop in range(starts.shape[0] - 1):
                    if starts[loop] <= i < starts[loop + 1]:
                        j = i + 1 if i + 1 < starts[loop + 1] else int(starts[loop])
                chord = math.hypot(vertices[j, 0] - vertices[i, 0], vertices[j, 1] - vertices[i, 1])
                reaches = max(reaches, 0.5 * abs(bulges[i]) * chord)
        extent += 2.0 * reaches
    # a power of two: scaling by it is exact
    unit = math.ldexp(1.0, math.frexp(max(extent, reach))[1])
    frame = np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1), unit])
    V, B = np.empty((m, 2)), np.empty(m)
    for i in range(m):
        V[i, 0], V[i, 1] = (vertices[i, 0] - frame[0]) / unit, (vertices[i, 1] - frame[1]) / unit
        B[i] = bulges[i]
    if turned > 0.0:
        _turn(V, B, starts)
    P, segment, firsts = pieces_of(V, B, starts, _TINY)
    Q, begins, T = part_of(V, B, starts)
    return P, segment, firsts, tree_of(P, P.shape[0], 0.0), Q, begins, T, frame


prepared = entry(_prepared, *inputs(2, 1, 1), *numbers(2))


@fast_kernel
def checked_loops(
    model: Model,
    distance: float,
    corner: Corner,
    reach: float,
    outward: float,
    turned: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, Verdict]:
    """Give the loops of an offset to the left that pass their check.

    Args:
        model: What `prepared` gives.
        distance: How far, m, above 0.
        corner: How corners are joined and ends go.
        reach: How far any corner may reach, as a multiple of it.
        outward: 1 if what is offset is what the loops do not enclose, else 0.
        turned: 1 if the loops are to be run through the other way, else 0.

    Returns:
        Vertices, bulges, the numbers of the lines and arcs (only where they are not turned), the
        first vertex of each loop and how many there are, the areas, and what is wrong: 0 if nothing
        is, or what the first of several attempts came to, where (x, y) and by how much.
    """
    P, segment, firsts, tree, Q, begins, T, frame = model
    unit = frame[2]
    d = distance / unit
    first = (0.0, 0.0, 0.0, 0.0)
    attempt = 0
    around = 1.0 - outward if corner[3] < 0.0 else -1.0
    reached = around if reach > 1.0 else -1.0
    while True:
        nudged = d + _NUDGES[attempt]
        rows, starts, areas, wrong = offset_loops(
            P, segment, firsts, tree, nudged, corner, around if attempt > 0 else reached
        )
        said = (OPEN, wrong[1], wrong[2], 0.0)
        m = rows.shape[0]
        vertices, bulges, curves = np.empty((m, 2)), np.empty(m), np.empty(m)
        for r in range(m):
            vertices[r, 0], vertices[r, 1] = rows[r, 0], rows[r, 1]
            bulges[r], curves[r] = rows[r, 2], rows[r, 3]
        if wrong[0] < 0.0:
            result = (vertices, bulges, starts)
            said = verdict(result, (Q, begins, T), (d, reach), _ROUNDING, outward)
        if said[0] == 0.0:
            for r in range(m):
                vertices[r, 0] = vertices[r, 0] * unit + frame[0]
                vertices[r, 1] = vertices[r, 1] * unit + frame[1]
            if turned > 0.0:
                _turn(vertices, bulges, starts)
            return vertices, bulges, curves, starts, areas, said
        if first[0] == 0.0:
            x, y = said[1] * unit + frame[0], said[2] * unit + frame[1]
            first = (said[0], x, y, said[3] * unit)
        attempt += 1
        if attempt == len(_NUDGES):
            return vertices, bulges, curves, starts, areas, first
