"""How fast the cutter's middle goes so that its edge keeps its feed."""

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

_SLOWEST = 0.05
"""Share of the feed below which it is never slowed, however tight an arc is."""


def feeds_along(
    lengths: FloatArray,
    turns: FloatArray,
    wall: int | npt.NDArray[np.int64],
    feed: float,
    radius: float,
) -> FloatArray:
    """Give the feeds of the cutter's middle along lines and arcs, m/s.

    On an arc that bends away from the wall the edge at the wall runs on a wider circle than the
    middle and would be faster than it: there the middle is slowed by R / (R + r). On arcs around
    the wall the edge is slower; the middle keeps the feed and never exceeds it.

    Args:
        lengths: Lengths of the middle's lines and arcs, m.
        turns: How far they turn, rad, above 0 to the left.
        wall: The side of the wall: 1 left, -1 right, 0 none; one for all, or one a piece.
        feed: The feed of the cutter, m/s.
        radius: Its radius, m.
    """
    inner = np.maximum(0.0, -wall * turns)
    share = lengths / np.maximum(lengths + radius * inner, 1e-300)
    feeds: FloatArray = feed * np.clip(share, _SLOWEST, 1.0)
    return feeds
