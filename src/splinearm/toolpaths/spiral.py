"""Pockets cleared on one way that winds outwards."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from splinearm.arrays import FloatArray

from .clearing import clear
from .contour import Contour
from .offset import Offsets
from .operation import Milled, Milling, Notes, Run, Track
from .pocket import pocket_runs
from .pocket_side import ContourSides, Ring, Sides
from .region import Region
from .stretch import begun_at, nearest_along, place_on, stretch

_PARTS = 12
"""A turn comes outwards in so many parts."""
_BLEND = 3.0
"""The way from part to part is so many times longer along the turn than across."""


def spiral(parts: Sequence[Region], setting: Milling) -> Milled:
    """Clear regions on ways that wind outwards, without a line across from turn to turn.

    Each twelfth of a turn is an exact offset of the part, a twelfth of the step nearer to the wall
    than the one before it. Turns are at most as far apart as leaves nothing between them: the
    radius, less a sixth. A region with islands, or whose rings fall apart, is cleared by parallel
    contours instead, and that is told.

    Args:
        parts: What is cleared.
        setting: The cutter and how it is used.

    Raises:
        GougeError: If a way would come nearer to a part than the cutter's radius.
        ValueError: If there are no parts.
    """
    return spiral_within([ContourSides(part) for part in parts], setting)


def spiral_within(parts: Sequence[Sides], setting: Milling) -> Milled:
    """Clear what lies within sides on ways that wind outwards: see `spiral`."""
    return clear(parts, setting, lambda sides, mill: _spiral_runs(sides, setting, mill.notes))


def _spiral_runs(sides: Sides, setting: Milling, notes: Notes) -> list[Run]:
    """Give the way that winds outwards through a part, or where there is none parallel contours."""
    rooms = sides.offsets.at(-sides.reach(setting))
    if not rooms:
        return []
    radius = setting.cutter.radius
    if sum(len(room.contours) for room in rooms) == 1:
        most = radius * _PARTS / (_PARTS + 2)
        (ring,) = sides.rings(rooms, 0.0, setting, notes)
        way = _wound(sides, ring, min(setting.over, most - sides.spare), setting)
        if way is not None:
            if setting.over > most:
                notes.add(
                    f"turns of a spiral are {most * 1e3:.6g} mm apart: farther would leave ridges"
                )
            return [Run(tuple(way))]
    notes.add("a pocket with islands or necks is cleared by parallel contours instead")
    return pocket_runs(sides, replace(setting, step_over=min(setting.over, radius)), notes)


def _wound(sides: Sides, ring: Ring, step: float, setting: Milling) -> list[Track] | None:
    """Give the way that winds outwards and then goes along the wall, or nothing."""
    mirrored = setting.wall == 1
    offsets = Offsets(sides.part.transformed(mirrored=True)) if mirrored else sides.offsets
    paths = _winding(offsets, sides.reach(setting), step)
    if paths is None:
        return None
    ways = [Track(_mirrored(path) if mirrored else path, setting.wall) for path in paths]
    at = ways[-1].path.vertices[-1]
    last = ring.begun_at(nearest_along(ring.contour, at), setting.wall)
    sides.require_clear([*ways, last], setting)
    begin = last.path.vertices[0]
    if ring.legs:
        if not sides.wall(setting).is_clear(at, begin):
            return None
        link = Contour.made(np.array([at, begin]), np.zeros(1), closed=False)
        ways.append(Track(link, setting.wall, link=True))
    else:
        last = replace(last, path=_from(last.path, at))
    return [*ways, last]


def _winding(offsets: Offsets, first: float, step: float) -> list[Contour] | None:
    """Give the way from the inmost ring to that along the wall, or nothing if rings fall apart."""
    if offsets.part.islands:
        return None
    count = 0
    while True:
        rings = offsets.at(-(first + count * step))
        if not rings:
            break
        if len(rings) > 1 or rings[0].islands:
            return None
        count += 1
    if not count:
        return None
    inmost = offsets.at(-(first + (count - 1) * step))[0].outer
    start = begun_at(inmost, 0.0)
    ways = [start]
    at = start.vertices[-1]
    for k in range((count - 1) * _PARTS - 1, -1, -1):
        level = first + k * step / _PARTS
        rings = offsets.at(-level)
        if len(rings) != 1 or rings[0].islands:
            return None
        ring = rings[0].outer
        whole = ring.length
        along = nearest_along(ring, at) + _BLEND * step / _PARTS
        begin = place_on(ring, along)[0]
        ways.append(Contour.made(np.array([at, begin]), np.zeros(1), closed=False))
        part = stretch(ring, along, along + whole / _PARTS)
        ways.append(part)
        at = part.vertices[-1]
    return [_from(way, ways[i - 1].vertices[-1]) if i else way for i, way in enumerate(ways)]


def _from(path: Contour, spot: FloatArray) -> Contour:
    """Give a way that begins exactly where the one before it ended."""
    vertices = np.array(path.vertices)
    around = (vertices[0] == vertices[-1]).all()
    vertices[0] = spot
    if around:
        vertices[-1] = spot
    return Contour.made(vertices, np.array(path.bulges), closed=False)


def _mirrored(path: Contour) -> Contour:
    """Give a way mirrored in the x axis."""
    return Contour.made(path.vertices * np.array([1.0, -1.0]), -path.bulges, closed=path.closed)
