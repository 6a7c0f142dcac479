"""Toolpaths as a controller takes them: arcs that are too wide for it as lines."""

from collections.abc import Iterable, Iterator
from dataclasses import fields
from itertools import pairwise
from math import ceil

import numpy as np

from .action import Action, ArcFeed, Cutting, Feed
from .gcode_dialect import Dialect


def fitted(actions: Iterable[Action], dialect: Dialect) -> tuple[Action, ...]:
    """Give actions with arcs wider than a controller can reckon with as lines.

    Nowhere are the lines farther from the arc than the least length that the controller knows.

    Args:
        actions: What a machine shall do.
        dialect: The controller.
    """
    return tuple(each for action in actions for each in _fitted(action, dialect))


def _fitted(action: Action, dialect: Dialect) -> Iterator[Action]:
    if not isinstance(action, ArcFeed) or action.radius_at_start <= dialect.largest_radius:
        yield action
        return
    # the height of an arc over its chord: r (1 - cos(turn / 2)), about r turn^2 / 8
    most = (8.0 * dialect.resolution / action.radius_at_start) ** 0.5
    places = action.at(np.linspace(0.0, 1.0, max(1, ceil(abs(action.turn) / most)) + 1))
    places[0], places[-1] = action.start, action.end
    common = {f.name: getattr(action, f.name) for f in fields(Cutting)}
    for start, end in pairwise(places):
        yield Feed(**(common | {"start": start, "end": end}))
