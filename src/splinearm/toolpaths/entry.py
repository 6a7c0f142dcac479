"""How a cutter comes down to a level: straight, on a ramp along its way, or on a helix."""

from math import ceil, pi, tan
from typing import TYPE_CHECKING

import numpy as np

from splinearm.arrays import FloatArray

from .contour import Contour
from .operation import Entry, Run, Track
from .stretch import direction_at, stretch

if TYPE_CHECKING:
    from .mill import Mill

_WIDEST = 0.9
"""Radius of a helix as a share of the cutter's: no core is left standing in the middle."""
_TIGHTEST = 0.2
_HALVINGS = 3


def enter(mill: "Mill", run: Run, z: float, surface: float) -> None:
    """Come down to where a run begins, at its level.

    Args:
        mill: The cutter.
        run: What is cut next.
        z: The level, m.
        surface: Where the material begins there, m.
    """
    track = run.tracks[0]
    spot = track.path.vertices[0]
    entry = mill.setting.entry
    if entry is Entry.HELIX:
        path = _helix(mill, track, surface + mill.setting.gap - z)
        if path is not None:
            _descend(mill, path, z, surface)
            return
        mill.notes.add("no room for a helix: entered on a ramp")
    if entry is not Entry.PLUNGE:
        path = ramp(run, _run_out(mill, surface - z), mill.setting.cutter.radius)
        if path is not None:
            _descend(mill, path, z, surface)
            return
        mill.notes.add("no room for a ramp: entered straight down")
    at = mill.place
    if at is None or (at[:2] != spot).any():
        mill.above(spot)
    mill.down_to(surface)
    mill.drop(z)


def ramp(run: Run, length: float, radius: float) -> Contour | None:
    """Give the way of some length on which one comes down to where a run begins.

    Where the run begins with a way around one comes along it from before its begin; else one goes
    there and back along its first part, as often as it takes. Nothing if that is shorter than the
    cutter's radius.
    """
    track = run.tracks[0]
    if track.around and not track.lifted:
        path = track.path
        loop = Contour.made(np.array(path.vertices[:-1]), np.array(path.bulges))
        way = stretch(loop, -length, 0.0)
        vertices = np.array(way.vertices)
        vertices[-1] = path.vertices[0]
        return Contour.made(vertices, np.array(way.bulges), closed=False)
    path = _first_part(run)
    whole = path.length
    if whole < radius:
        return None
    times = max(1, ceil(0.5 * length / whole))
    part = stretch(path, 0.0, 0.5 * length / times)
    there = np.concatenate((part.vertices[1:], part.vertices[-2::-1]))
    back = np.concatenate((part.bulges, -part.bulges[::-1]))
    vertices = np.concatenate((path.vertices[:1], np.tile(there, (times, 1))))
    return Contour.made(vertices, np.tile(back, times), closed=False)


def _first_part(run: Run) -> Contour:
    """Give a run up to its first tab as one way."""
    vertices, bulges = [run.tracks[0].path.vertices[:1]], []
    for track in run.tracks:
        path = stretch(track.path, 0.0, track.lifted[0][0]) if track.lifted else track.path
        vertices.append(path.vertices[1:])
        bulges.append(path.bulges)
        if track.lifted:
            break
    return Contour.made(np.concatenate(vertices), np.concatenate(bulges), closed=False)


def _descend(mill: "Mill", path: Contour, z: float, surface: float) -> None:
    """Go along a way that ends at a level, from just above the material."""
    spot = path.vertices[0]
    at = mill.place
    if at is None or (at[:2] != spot).any() or at[2] < surface:
        mill.above(spot)
    mill.down_to(surface)
    cutter = mill.setting.cutter
    angle = mill.setting.ramp_angle
    # never quicker down than the plunge allows
    feed = min(cutter.feed, cutter.plunge / np.sin(angle))
    mill.follow(Track(path), z, float(feed))


def _run_out(mill: "Mill", deep: float) -> float:
    """Give how long a ramp is that comes down by a depth and the gap above it, m."""
    return (deep + mill.setting.gap) / tan(mill.setting.ramp_angle)


def _helix(mill: "Mill", track: Track, deep: float) -> Contour | None:
    """Give the full circles that touch a track where it begins, or nothing if there is no room."""
    path = track.path
    spot = path.vertices[0]
    along = direction_at(path.vertices[0], path.vertices[1], float(path.bulges[0]), 0.0)
    side = -track.wall if track.wall else 1
    across = side * np.array([-along[1], along[0]])
    radius = _WIDEST * mill.setting.cutter.radius
    for _ in range(_HALVINGS):
        if radius < _TIGHTEST * mill.setting.cutter.radius:
            return None
        far = spot + 2.0 * radius * across
        if mill.wall is None or (
            mill.wall.is_clear(spot, far, float(side))
            and mill.wall.is_clear(far, spot, float(side))
        ):
            turns = ceil(deep / (2.0 * pi * radius * tan(mill.setting.ramp_angle)))
            return _circles(spot, far, side, turns)
        radius *= 0.5
    return None


def _circles(spot: FloatArray, far: FloatArray, side: int, turns: int) -> Contour:
    vertices = np.array([spot, far] * turns + [spot])
    return Contour.made(vertices, np.full(2 * turns, float(side)), closed=False)
