"""Toolpaths as a controller takes them: arcs that are too wide for it as lines."""

from collections.abc import Iterable, Iterator
from dataclasses import fields
from itertools import pairwise
from math import ceil

import numpy as np

from splinearm.errors import ToolpathError

from .action import Action, ArcFeed, Cutting, Feed
from .gcode_dialect import Dialect

_MOST_LINES = 100_000
"""No machine cuts an arc that takes more lines: it is kilometres wide."""


def fitted(actions: Iterable[Action], dialect: Dialect) -> tuple[Action, ...]:
    """Give actions with arcs wider than a controller can reckon with as lines.

    Nowhere are the lines farther from the arc than the least length that the controller knows.

    Args:
        actions: What a machine shall do.
        dialect: The controller.

    Raises:
        ToolpathError: If an arc is so wide that no machine can be meant.
    """
    return tuple(each for action in actions for each in _fitted(action, dialect))


def _fitted(action: Action, dialect: Dialect) -> Iterator[Action]:
    if not isinstance(action, ArcFeed) or action.radius_at_start <= dialect.largest_radius:
        yield action
        return
    # the height of an arc over its chord: r (1 - cos(turn / 2)), about r turn^2 / 8
    most = (8.0 * dialect.resolution / action.radius_at_start) ** 0.5
    count = max(1, ceil(abs(action.turn) / most))
    if count > _MOST_LINES:
        raise ToolpathError(
            f"an arc of {action.radius_at_start:.4g} m radius is too wide to be cut; "
            "look for a wrong unit, or a length that is too large"
        )
    places = action.at(np.linspace(0.0, 1.0, count + 1))
    places[0], places[-1] = action.start, action.end
    common = {f.name: getattr(action, f.name) for f in fields(Cutting)}
    for start, end in pairwise(places):
        yield Feed(**(common | {"start": start, "end": end}))
