"""What a toolpath or an NC program amounts to: lengths, extent, feeds, tools."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.box import bounding_box

from .action import Action, ArcFeed, Cutting, Dwell, Feed, Rapid, SplineFeed, ToolChange


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Summary:
    """What actions amount to."""

    rapids: int
    """How many rapid ways there are."""
    lines: int
    """How many straight ways that cut."""
    arcs: int
    """How many arcs and helices."""
    splines: int
    """How many splines."""
    rapid_length: float
    """Length of the rapid ways, m."""
    cutting_length: float
    """Length of those that cut, m."""
    cutting_time: float
    """How long cutting takes at the feeds that are asked for, s; corners make it longer."""
    dwell_time: float
    """How long the tool rests, s."""
    low: FloatArray
    """Lowest coordinates of ways that cut, or of all where none does, shape (3,), m."""
    high: FloatArray
    """Highest coordinates, shape (3,), m."""
    slowest: float | None
    """Lowest feed, m/s; None: no way has one."""
    quickest: float | None
    """Highest feed, m/s."""
    tools: tuple[int, ...]
    """Tools in the order in which they are taken."""


def summarise(actions: Iterable[Action]) -> Summary:
    """Give what actions amount to."""
    known = tuple(actions)
    rapids = [a for a in known if isinstance(a, Rapid)]
    cuts = [a for a in known if isinstance(a, Feed | ArcFeed | SplineFeed)]
    moves: list[Rapid | Feed | ArcFeed | SplineFeed] = [*cuts] or [*rapids]
    places = np.vstack([_places(a) for a in moves]) if moves else np.zeros((1, 3))
    feeds = [cut.feed for cut in cuts if cut.feed is not None]
    return Summary(
        rapids=len(rapids),
        lines=sum(isinstance(cut, Feed) for cut in cuts),
        arcs=sum(isinstance(cut, ArcFeed) for cut in cuts),
        splines=sum(isinstance(cut, SplineFeed) for cut in cuts),
        rapid_length=sum(rapid.length for rapid in rapids),
        cutting_length=sum(cut.length for cut in cuts),
        cutting_time=sum(_time(cut, cut.length) for cut in cuts),
        dwell_time=sum(a.time for a in known if isinstance(a, Dwell)),
        low=places.min(axis=0),
        high=places.max(axis=0),
        slowest=min(feeds, default=None),
        quickest=max(feeds, default=None),
        tools=tuple(dict.fromkeys(a.tool for a in known if isinstance(a, ToolChange) and a.tool)),
    )


def _time(cut: Cutting, length: float) -> float:
    if cut.time is not None:
        return cut.time
    return length / cut.feed if cut.feed else 0.0


def _places(move: Rapid | Feed | ArcFeed | SplineFeed) -> FloatArray:
    """Give places that span a way: of an arc also where it is farthest along each axis."""
    match move:
        case ArcFeed():
            a, b = (move.axis + 1) % 3, (move.axis + 2) % 3
            arm = move.start - move.centre
            begin = np.arctan2(arm[b], arm[a])
            quarters = (np.arange(-8, 9) * 0.5 * np.pi - begin) / move.turn
            x = np.concatenate(([0.0, 1.0], quarters[(quarters > 0.0) & (quarters < 1.0)]))
            return move.at(x)
        case SplineFeed():
            return np.array(bounding_box(move.curve))
        case _:
            return np.array([move.start, move.end])
