"""How fast the cutter's middle goes so that its edge keeps its feed."""

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.curvature import curvature

_SLOWEST = 0.05
"""Share of the feed below which it is never slowed, however tight an arc is."""
_LOOKS = 17
"""Places of a span at which it is looked how a spline bends."""
_ALIKE = 0.98
"""Feeds of spans whose ratio is above this are one, the lower."""


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


def spline_feeds(
    curve: BSpline, wall: int, feed: float, radius: float
) -> list[tuple[BSpline, float]]:
    """Give a spline of the cutter's middle in parts, and of each the feed, m/s.

    A span that bends away from the wall is slowed as an arc is that bends as it does at most.

    Args:
        curve: The way of the middle, in the plane, m.
        wall: The side of the wall: 1 left, -1 right, 0 none.
        feed: The feed of the cutter, m/s.
        radius: Its radius, m.
    """
    ends = curve.breaks
    # curvature jumps at the ends of spans: it is looked at just within them
    shares = np.linspace(1e-9, 1.0 - 1e-9, _LOOKS)
    bends = curvature(curve, ends[:-1, None] + np.diff(ends)[:, None] * shares)
    turns = -wall * np.maximum(0.0, -wall * bends).max(axis=1)
    feeds = feeds_along(np.ones(len(turns)), turns, wall, feed, radius).tolist()
    parts: list[tuple[BSpline, float]] = []
    begun, slowest, quickest = 0, feeds[0], feeds[0]
    for k, own in enumerate([*feeds[1:], -1.0], start=1):
        if own >= 0.0 and min(slowest, own) >= _ALIKE * max(quickest, own):
            slowest, quickest = min(slowest, own), max(quickest, own)
            continue
        whole = begun == 0 and k == len(feeds)
        part = curve if whole else curve.part(float(ends[begun]), float(ends[k]))
        parts.append((part, slowest))
        begun, slowest, quickest = k, own, own
    return parts
