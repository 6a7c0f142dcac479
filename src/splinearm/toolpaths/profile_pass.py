"""Cutting along contours: outside, inside or on them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .clearance import Wall
from .contour import Contour
from .lead_in import with_leads
from .mill import Mill
from .offset import Offsets, offset
from .operation import Milled, Milling, Notes, Run, Side, Track
from .order import shortest_order
from .region import Region
from .stretch import begun_at, opened
from .tab import Tabs, tab_places, with_tabs


def profile(
    parts: Sequence[Region], setting: Milling, side: Side, tabs: Tabs | None = None
) -> Milled:
    """Cut along the contours of parts, openings first, each to its full depth.

    Args:
        parts: What is kept (outside) or opened (inside).
        setting: The cutter and how it is used.
        side: On which side of the contours it goes.
        tabs: Where outer contours stay joined to the stock; None: nowhere.

    Raises:
        GougeError: If a way would come nearer to any of the parts than the cutter's radius.
        ValueError: If there are no parts, or tabs have no room.
    """
    if not parts:
        raise ValueError("parts: want at least one")
    notes = Notes()
    distance = setting.reach
    wall = _wall(parts, distance, side)
    mill = Mill(setting, wall, notes=notes)
    rough = _ways(parts, distance, setting, side, notes)
    over = None if tabs is None else setting.levels[-1] + tabs.height
    places = [tab_places(way.path, tabs, setting.cutter.radius) if tabs else None for way in rough]
    _cut(mill, rough, places, tabs, setting.levels, over)
    if setting.finish and side is not Side.ON:
        mill.setting = replace(setting, stock=0.0, finish=False)
        fine = _ways(parts, mill.setting.reach, setting, side, Notes())
        mill.wall = _wall(parts, mill.setting.reach, side)
        spots = [spot for spot in places if spot is not None]
        around = [_near(way, spots) for way in fine]
        _cut(mill, fine, around, tabs, setting.levels[-1:], over)
    return mill.milled()


def _cut(
    mill: Mill,
    ways: Sequence[Track],
    places: "Sequence[np.typing.NDArray[np.float64] | None]",
    tabs: Tabs | None,
    levels: Sequence[float],
    over: float | None,
) -> None:
    if mill.wall is not None:
        mill.wall.require_clear([way.path for way in ways])
    runs: list[Run] = []
    for way, spots in zip(ways, places, strict=True):
        track = way
        if tabs is not None and spots is not None:
            track = with_tabs(way, spots, tabs, mill.setting.cutter.radius)
        runs.append(with_leads(track, mill.wall, mill.setting.lead, mill.notes))
    mill.cut(runs, levels, whole=True, over=over)


def _ways(
    parts: Sequence[Region], distance: float, setting: Milling, side: Side, notes: Notes
) -> list[Track]:
    """Give the ways beside parts, openings first, each group by the shortest travel."""
    inner: list[Contour] = []
    outer: list[Contour] = []
    for part in parts:
        if side is Side.ON:
            found: tuple[Region, ...] = (part,)
        else:
            found = Offsets(part).at(distance if side is Side.OUTSIDE else -distance)
            _tell_lost(part, found, distance, side, notes)
        for region in found:
            outer.append(region.outer)
            inner += region.islands
    if side is Side.INSIDE:
        inner, outer = [], [*inner, *outer]
    # what a contour goes around lies to its left; outside of parts that is what stays
    stays = 1 if side is Side.OUTSIDE else -1
    tracks: list[Track] = []
    at = np.zeros(2)
    for group in (inner, outer):
        turned = [c if stays == setting.wall else c.reversed() for c in group]
        begun = [begun_at(c, _begin(c)) for c in turned]
        for i, _ in shortest_order(
            np.array([path.vertices[0] for path in begun]).reshape(-1, 2), begin=at
        ):
            tracks.append(Track(begun[i], 0 if side is Side.ON else setting.wall))
            at = begun[i].vertices[0]
    return tracks


def _begin(contour: Contour) -> float:
    """Give where a contour is best entered: in the middle of its longest line, else arc."""
    lengths = contour.lengths
    lines = np.where(contour.bulges == 0.0, lengths, 0.0)
    i = int(lines.argmax()) if lines.any() else int(lengths.argmax())
    return float(lengths[:i].sum() + 0.5 * lengths[i])


def _wall(parts: Sequence[Region], distance: float, side: Side) -> Wall | None:
    if side is Side.ON:
        return None
    return Wall.of([contour for part in parts for contour in part.contours], distance)


def _tell_lost(
    part: Region, found: Sequence[Region], distance: float, side: Side, notes: Notes
) -> None:
    """Tell which contours have no way beside them, as the cutter does not fit in."""
    kept = sum(len(region.contours) for region in found)
    if kept >= len(part.contours) and found:
        return
    narrow = part.islands if side is Side.OUTSIDE else (() if found else (part.outer,))
    for contour in narrow:
        if side is Side.INSIDE or not offset(contour, -distance):
            x, y = (contour.vertices.mean(axis=0) * 1e3).tolist()
            notes.add(
                f"the opening at ({x:.6g}, {y:.6g}) mm is too narrow for the cutter: left out"
            )


def _near(
    way: Track, groups: "Sequence[np.typing.NDArray[np.float64]]"
) -> "np.typing.NDArray[np.float64] | None":
    """Give the tab places that belong to a way: those of the group that is nearest to it."""
    if not groups:
        return None
    contour = opened(way.path)
    return min(groups, key=lambda places: float(contour.distance(places).max()))
