"""Nodes along a path between which a time law is sought."""

import numpy as np

from splinearm.arrays import FloatArray

from .joint_path import JointPath
from .time_law import split_cells

_CELLS_A_PIECE = 2
"""At least so many cells for each polynomial piece of the path."""

_FIRST = 0.2
"""The first grid has this share of the cells."""

_HALVES = 0.5 ** np.arange(1, 9)
"""Where the first and the last cell are divided, seen from the end."""

_BY_TIME = 0.7
"""This share of the cells is dealt out by the time that is spent, the others by the way."""

_APART = 1e-12
"""Ends of pieces nearer together than this share of the way are one but for rounding."""


def first(
    path: JointPath, span: tuple[float, float], edges: FloatArray | None, cells: int
) -> FloatArray:
    """Give nodes at all ends of pieces and changes of speed, and enough between.

    Args:
        path: The path.
        span: From where to where.
        edges: More places that are to be nodes, or None.
        cells: About how many cells the law shall have in the end.
    """
    start, end = span
    fixed = path.breaks if edges is None else np.union1d(path.breaks, edges)
    apart = _APART * (end - start)
    inner = fixed[(fixed > start + apart) & (fixed < end - apart)]
    inner = inner[np.diff(inner, prepend=start) > apart]
    fixed = np.concatenate(([start], inner, [end]))
    counts = np.ceil(np.diff(fixed) * (_FIRST * cells / (end - start)) - 1e-9).astype(np.intp)
    nodes = split_cells(fixed, np.maximum(counts, _CELLS_A_PIECE))
    # hard accelerations are over within a fraction of a cell: the outer ones are halved often
    before = nodes[0] + (nodes[1] - nodes[0]) * _HALVES[::-1]
    behind = nodes[-1] - (nodes[-1] - nodes[-2]) * _HALVES
    return np.concatenate((nodes[:1], before, nodes[1:-1], behind, nodes[-1:]))


def second(s: FloatArray, x: FloatArray, cells: int) -> FloatArray:
    """Give finer nodes where a law spends its time: at rests and where the path bends sharply."""
    h, speed = np.diff(s), np.sqrt(x)
    dt = 2.0 * h / (speed[:-1] + speed[1:])
    share = _BY_TIME * dt / dt.sum() + (1.0 - _BY_TIME) * h / (s[-1] - s[0])
    # every cell has one, and half a cell is lost on rounding up
    some = max(cells - 0.5 * len(h), 0.5 * cells)
    counts = np.ceil(share * some - 1e-9).astype(np.intp)
    return split_cells(s, np.maximum(counts, 1))
