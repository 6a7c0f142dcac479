"""Pockets cleared on one way that winds outwards."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from splinearm.arrays import FloatArray

from .clearance import Wall
from .contour import Contour
from .mill import Mill
from .offset import Offsets
from .operation import Milled, Milling, Run, Track
from .pocket import finish, pocket_runs
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
    if not parts:
        raise ValueError("parts: want at least one")
    mill = Mill(setting)
    radius = setting.cutter.radius
    most = radius * _PARTS / (_PARTS + 2)
    if setting.over > most:
        mill.notes.add(
            f"turns of a spiral are {most * 1e3:.6g} mm apart: farther would leave ridges"
        )
    step = min(setting.over, most)
    for part in parts:
        mill.wall = Wall.of(part.contours, setting.reach)
        if not Offsets(part).at(-setting.reach):
            x, y = (part.outer.vertices.mean(axis=0) * 1e3).tolist()
            mill.notes.add(f"the pocket at ({x:.6g}, {y:.6g}) mm is too narrow for the cutter")
            continue
        mirrored = setting.wall == 1
        wound = part.transformed(mirrored=True) if mirrored else part
        way = _winding(Offsets(wound), setting.reach, step)
        if way is None:
            mill.notes.add("a pocket with islands or necks is cleared by parallel contours instead")
            runs = pocket_runs(
                part, replace(setting, step_over=min(setting.over, radius)), mill.wall
            )
        else:
            if mirrored:
                way = [_mirrored(path) for path in way]
            runs = [Run(tuple(Track(path, setting.wall) for path in way))]
        mill.wall.require_clear([t.path for run in runs for t in run.tracks])
        mill.cut(runs, setting.levels)
        if setting.finish:
            finish(mill, part)
    return mill.milled()


def _winding(offsets: Offsets, first: float, step: float) -> list[Contour] | None:
    """Give the way from the inmost ring to the wall, or nothing if rings fall apart."""
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
    wall = offsets.at(-first)[0].outer
    ways.append(begun_at(wall, nearest_along(wall, at)))
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
