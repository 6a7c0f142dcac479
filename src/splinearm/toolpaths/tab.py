"""Tabs: places where a part stays joined to its stock until it is broken out."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from splinearm.arrays import FloatArray

from .contour import Contour
from .operation import Track
from .stretch import nearest_along, place_on


@dataclass(frozen=True, slots=True, kw_only=True)
class Tabs:
    """How a part stays joined to its stock."""

    count: int
    """How many tabs a contour has."""
    length: float
    """How long each is along the part, m."""
    height: float
    """How high they stand above the bottom of the cut, m."""

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ValueError(f"count: want one tab or more, got {self.count}")
        for name in ("length", "height"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: want above zero, got {getattr(self, name)}")


def tab_places(path: Contour, tabs: Tabs, radius: float) -> FloatArray:
    """Give where the tabs of a contour are, shape (count, 2), m.

    They are spread evenly and moved to straight parts nearby, where there are any.

    Raises:
        ValueError: If they have no room beside each other.
    """
    whole, width = path.length, tabs.length + 2.0 * radius
    apart = whole / tabs.count
    if not width < apart:
        raise ValueError(
            f"tabs: {tabs.count} of {tabs.length * 1e3:g} mm and the cutter's diameter between "
            f"them have no room on {whole * 1e3:.6g} mm"
        )
    marks = np.concatenate(([0.0], np.cumsum(path.lengths)))
    lines = [
        (first + 0.5 * width, last - 0.5 * width)
        for (first, last), bulge in zip(pairwise(marks), path.bulges, strict=True)
        if bulge == 0.0 and last - first > width
    ]
    farthest = 0.5 * (apart - width)
    places = []
    for k in range(tabs.count):
        middle = (k + 0.5) * apart
        moved = [min(max(middle, low), high) for low, high in lines]
        best = min(moved, key=lambda s: abs(s - middle), default=middle)
        places.append(place_on(path, best if abs(best - middle) < farthest else middle)[0])
    return np.array(places)


def with_tabs(track: Track, places: FloatArray, tabs: Tabs, radius: float) -> Track:
    """Give a track that is lifted where tabs stay.

    Args:
        track: A track that begins where there is no tab.
        places: Where the tabs are, shape (count, 2), m.
        tabs: What they are like.
        radius: The radius of the cutter, which takes that much more to both sides, m.
    """
    half = 0.5 * tabs.length + radius
    path, whole = track.path, track.path.length
    middles = sorted(nearest_along(path, place) for place in places)
    # another way along the contour may be shorter around a corner: none goes over its ends
    return replace(track, lifted=tuple((max(0.0, s - half), min(whole, s + half)) for s in middles))
