"""Drilling: holes one after the other, in steps if they are deep."""

from math import ceil

import numpy as np

from splinearm.arrays import ArrayInput, frozen_array

from .mill import Mill
from .operation import Milled, Milling
from .order import shortest_order


def drill(points: ArrayInput, setting: Milling, peck: float | None = None) -> Milled:
    """Drill holes, by the shortest travel.

    Args:
        points: Their middles, shape (m, 2), m.
        setting: The drill and how it is used; its tip goes to the depth.
        peck: After so much depth the drill comes out to clear the chips, m; None: never.

    Raises:
        ValueError: If there are no points, or the peck is not above 0.
    """
    spots = frozen_array(points, (None, 2), "points")
    if not len(spots):
        raise ValueError("points: want at least one")
    if peck is not None and not peck > 0.0:
        raise ValueError(f"peck: want a depth above zero, got {peck}")
    count = 1 if peck is None else max(1, ceil(setting.depth / peck - 1e-9))
    between = [setting.top - setting.depth * k / count for k in range(1, count)]
    levels = (*between, setting.top - setting.depth)
    mill = Mill(setting)
    for i, _ in shortest_order(spots):
        mill.above(spots[i])
        surface = setting.top
        for k, z in enumerate(levels):
            if k:
                x, y = spots[i].tolist()
                mill.rapid(np.array([x, y, min(setting.top + setting.gap, setting.safe)]))
            mill.down_to(surface)
            mill.drop(z)
            surface = z
    return mill.milled()
