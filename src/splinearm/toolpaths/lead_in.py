"""Arcs by which a contour is entered and left, where they have room."""

from math import pi, tan

import numpy as np

from splinearm.arrays import FloatArray

from .contour import Contour
from .operation import Barrier, Notes, Run, Track
from .stretch import direction_at

_QUARTER = tan(0.125 * pi)
_HALVINGS = 4


def with_leads(track: Track, wall: Barrier | None, radius: float, notes: Notes) -> Run:
    """Give a track with a quarter circle before and behind it, away from its wall.

    Where an arc of that radius would come too near to the part a smaller one is taken, then a
    straight way, then none; that is told.

    Args:
        track: The track.
        wall: What the cutter keeps away from.
        radius: Radius of the arcs, m; 0: none.
        notes: Where it is told.
    """
    if radius == 0.0 or not track.wall:
        return Run((track,))
    path = track.path
    first = direction_at(path.vertices[0], path.vertices[1], float(path.bulges[0]), 0.0)
    last = direction_at(path.vertices[-2], path.vertices[-1], float(path.bulges[-1]), 1.0)
    away = -track.wall
    into = _lead(path.vertices[0], first, away, wall, radius, -1.0)
    out = _lead(path.vertices[-1], last, away, wall, radius, 1.0)
    for name, lead in (("lead-in", into), ("lead-out", out)):
        if lead is None:
            notes.add(f"no room for a {name}: left out")
        elif lead[1] == 0.0:
            notes.add(f"no room for an arc as {name}: a straight one taken")
        elif lead[1] < radius:
            notes.add(f"no room for a {name} of {radius * 1e3:g} mm: {lead[1] * 1e3:g} mm taken")
    tracks = [] if into is None else [Track(into[0], track.wall, link=True)]
    tracks.append(track)
    if out is not None:
        tracks.append(Track(out[0], track.wall, link=True))
    return Run(tuple(tracks))


def _lead(
    spot: FloatArray, along: FloatArray, away: int, wall: Barrier | None, radius: float, sign: float
) -> tuple[Contour, float] | None:
    """Give the way to (sign -1) or from (1) a place, and its radius; 0 of a straight one."""
    across = away * np.array([-along[1], along[0]])
    size = radius
    for _ in range(_HALVINGS):
        far = spot + size * across + sign * size * along
        ends = (far, spot) if sign < 0.0 else (spot, far)
        if wall is None or wall.is_clear(*ends, away * _QUARTER):
            bulges = np.array([away * _QUARTER])
            return Contour.made(np.array(ends), bulges, closed=False), size
        size *= 0.5
    far = spot + radius * across
    if wall is None or wall.is_clear(spot, far):
        ends = (far, spot) if sign < 0.0 else (spot, far)
        return Contour.made(np.array(ends), np.zeros(1), closed=False), 0.0
    return None
