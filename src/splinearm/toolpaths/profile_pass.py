"""Cutting along contours: outside, inside or on them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Protocol

import numpy as np

from splinearm.arrays import FloatArray

from .clearance import Wall
from .contour import Contour
from .lead_in import with_leads
from .mill import Mill
from .offset import Offsets, offset
from .operation import Barrier, Milled, Milling, Notes, Run, Side, Track
from .order import shortest_order
from .pocket_side import Ring
from .region import Region
from .stretch import begun_at, nearest_along, opened
from .tab import Tabs, tab_places, with_tabs


class Edges(Protocol):
    """The edges of parts, as what they are made of has them."""

    @property
    def beside(self) -> float:
        """How far ways may be from their splines where these are cut anew, m."""
        ...

    def wall(self, distance: float) -> Barrier | None:
        """Give what keeps a cutter's middle that far away, if there is such."""
        ...

    def ways(self, setting: Milling, notes: Notes) -> tuple[list[Track], list[Track]]:
        """Give the ways within openings and those around parts, in the direction of cutting."""
        ...

    def require_clear(self, ways: Sequence[Track], distance: float) -> None:
        """Refuse ways that come nearer to any part than that."""
        ...


def profile(
    parts: Sequence[Region], setting: Milling, side: Side, tabs: Tabs | None = None
) -> Milled:
    """Cut along the contours of parts, openings first, each to its full depth.

    Args:
        parts: What is kept (outside) or opened (inside).
        setting: The cutter and how it is used.
        side: On which side of the contours it goes.
        tabs: Where contours stay joined to the stock; openings have as many as have room; None:
            nowhere.

    Raises:
        GougeError: If a way would come nearer to any of the parts than the cutter's radius.
        ValueError: If there are no parts, or tabs have no room or are higher than the cut is deep.
    """
    if not parts:
        raise ValueError("parts: want at least one")
    return cut_edges(_Contours(tuple(parts), side), setting, tabs)


def cut_edges(edges: Edges, setting: Milling, tabs: Tabs | None) -> Milled:
    """Cut along edges, openings first, each to its full depth; then what was left on the sides."""
    if tabs is not None and tabs.height > setting.depth:
        high, deep = tabs.height * 1e3, setting.depth * 1e3
        raise ValueError(f"tabs: {high:g} mm high in a cut {deep:g} mm deep; make them lower")
    mill = Mill(setting, edges.wall(setting.reach))
    inner, outer = edges.ways(setting, mill.notes)
    rough = _ordered(inner, outer)
    over = None if tabs is None else setting.levels[-1] + tabs.height
    openings = {id(way) for way in inner}
    places = [_held(way, tabs, mill, opening=id(way) in openings) for way in rough]
    _cut(mill, edges, rough, (places, tabs), setting.levels, over)
    if setting.finish and mill.wall is not None:
        mill.setting = replace(setting, stock=0.0, finish=False)
        fine = _ordered(*edges.ways(mill.setting, Notes()))
        mill.wall = edges.wall(mill.setting.reach)
        like = [_nearest(way, rough) for way in fine]
        around = [places[k] for k in like]
        # what is entered where the passes were is not entered where a tab stays
        starts = [rough[k].path.vertices[0] for k in like]
        fine = [
            way if spots is None else _begun_beside(way, start, edges.beside)
            for way, spots, start in zip(fine, around, starts, strict=True)
        ]
        _cut(mill, edges, fine, (around, tabs), setting.levels[-1:], over)
    return mill.milled()


def _cut(
    mill: Mill,
    edges: Edges,
    ways: Sequence[Track],
    held: tuple[Sequence[FloatArray | None], Tabs | None],
    levels: Sequence[float],
    over: float | None,
) -> None:
    if mill.wall is not None:
        edges.require_clear(ways, mill.setting.reach)
    runs: list[Run] = []
    places, tabs = held
    for way, spots in zip(ways, places, strict=True):
        track = way
        if tabs is not None and spots is not None:
            track = with_tabs(way, spots, tabs, mill.setting.cutter.radius)
        runs.append(with_leads(track, mill.wall, mill.setting.lead, mill.notes))
    mill.cut(runs, levels, whole=True, over=over)


def _ordered(inner: Sequence[Track], outer: Sequence[Track]) -> list[Track]:
    """Give ways, openings first, each group by the shortest travel."""
    tracks: list[Track] = []
    at = np.zeros(2)
    for group in (inner, outer):
        starts = np.array([way.path.vertices[0] for way in group]).reshape(-1, 2)
        for i, _ in shortest_order(starts, begin=at):
            tracks.append(group[i])
            at = group[i].path.vertices[0]
    return tracks


@dataclass(frozen=True, slots=True, eq=False)
class _Contours:
    """The contours of regions."""

    parts: tuple[Region, ...]
    side: Side

    @property
    def beside(self) -> float:
        return 0.0

    def wall(self, distance: float) -> Wall | None:
        if self.side is Side.ON:
            return None
        return Wall.of([contour for part in self.parts for contour in part.contours], distance)

    def ways(self, setting: Milling, notes: Notes) -> tuple[list[Track], list[Track]]:
        inner: list[Contour] = []
        outer: list[Contour] = []
        for part in self.parts:
            found = self._beside(part, setting.reach, notes)
            outer += [region.outer for region in found]
            inner += [island for region in found for island in region.islands]
        if self.side is Side.INSIDE:
            inner, outer = [], [*inner, *outer]
        wall = 0 if self.side is Side.ON else setting.wall
        turn = turned(setting, self.side)
        first, last = (
            [Track(_begun(c.reversed() if turn else c), wall) for c in group]
            for group in (inner, outer)
        )
        return first, last

    def require_clear(self, ways: Sequence[Track], distance: float) -> None:
        wall = self.wall(distance)
        if wall is not None:
            wall.require_clear([way.path for way in ways])

    def _beside(self, part: Region, reach: float, notes: Notes) -> tuple[Region, ...]:
        if self.side is Side.ON:
            return (part,)
        found = Offsets(part).at(reach if self.side is Side.OUTSIDE else -reach)
        kept = sum(len(region.contours) for region in found)
        if kept < len(part.contours) or not found:
            narrow = part.islands if self.side is Side.OUTSIDE else (part.outer,) * (not found)
            for contour in narrow:
                if self.side is Side.INSIDE or not offset(contour, -reach):
                    tell_narrow(contour.vertices.mean(axis=0), notes)
        return found


def turned(setting: Milling, side: Side) -> bool:
    """Say whether ways run against the direction in which what they enclose lies to their left."""
    # outside of parts that is what stays, inside what is cut away
    return (1 if side is Side.OUTSIDE else -1) != setting.wall


def tell_narrow(place: FloatArray, notes: Notes) -> None:
    """Tell that an opening has no way for the cutter."""
    x, y = (place * 1e3).tolist()
    notes.add(f"the opening at ({x:.6g}, {y:.6g}) mm is too narrow for the cutter: left out")


def _begun(contour: Contour) -> Contour:
    """Give a contour begun where it is best entered: amid its longest line, else arc."""
    lengths = contour.lengths
    lines = np.where(contour.bulges == 0.0, lengths, 0.0)
    i = int(lines.argmax()) if lines.any() else int(lengths.argmax())
    return begun_at(contour, float(lengths[:i].sum() + 0.5 * lengths[i]))


def _begun_beside(way: Track, place: FloatArray, beside: float) -> Track:
    """Give a way around begun beside a place."""
    path = way.path
    ring = Ring(Contour.made(path.vertices[:-1].copy(), path.bulges), way.legs, beside)
    return ring.begun_at(nearest_along(ring.contour, place), way.wall)


def _held(way: Track, tabs: Tabs | None, mill: Mill, *, opening: bool) -> FloatArray | None:
    """Give where the tabs of a way are; of an opening as many as have room."""
    radius = mill.setting.cutter.radius
    if tabs is not None and opening:
        room = ceil(way.path.length / (tabs.length + 2.0 * radius)) - 1
        if room < tabs.count:
            x, y = (np.reshape(way.path.bounds, (2, 2)).mean(axis=0) * 1e3).tolist()
            what = f"{room} of {tabs.count} tabs"
            mill.notes.add(f"the opening at ({x:.6g}, {y:.6g}) mm has room for {what}")
            tabs = replace(tabs, count=room) if room else None
    return None if tabs is None else tab_places(way.path, tabs, radius)


def _nearest(way: Track, others: Sequence[Track]) -> int:
    """Give which of other ways goes along the same contour."""
    contour = opened(way.path)
    far = [float(contour.distance(other.path.vertices).max()) for other in others]
    return int(np.argmin(far))
