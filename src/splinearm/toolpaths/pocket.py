"""Pockets cleared by parallel contours, each from the part, from the inside to the outside."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import OffsetError

from .clearing import clear
from .contour import Contour, joined
from .operation import Milled, Milling, Notes, Run, Track
from .pocket_side import ContourSides, Ring, Sides
from .region import Region
from .ridge import ridge_ways

_MOST_RINGS = 10_000
_BESIDE = 1e-6
"""Share of the step by which a ring may be farther from the next."""
_FAR = 1.5
"""Ways between rings longer than this many steps are flown."""


def pocket(parts: Sequence[Region], setting: Milling) -> Milled:
    """Clear regions by parallel contours, islands left standing.

    Rings are offsets of the part itself. Where the step is wider than the cutter's radius, what
    rings leave in corners and in the middle is taken by short ways between them; nothing that the
    cutter reaches stays.

    Args:
        parts: What is cleared.
        setting: The cutter and how it is used.

    Raises:
        GougeError: If a way would come nearer to a part than the cutter's radius.
        ValueError: If there are no parts.
    """
    return pocket_within([ContourSides(part) for part in parts], setting)


def pocket_within(parts: Sequence[Sides], setting: Milling) -> Milled:
    """Clear what lies within sides: see `pocket`."""
    return clear(parts, setting, lambda sides, mill: pocket_runs(sides, setting, mill.notes))


@dataclass(frozen=True, slots=True, eq=False)
class _Loop:
    """A way of the pocket before it is known where it begins."""

    ring: Ring
    level: int


def pocket_runs(sides: Sides, setting: Milling, notes: Notes) -> list[Run]:
    """Give the ways that clear a region, linked where that is clear of its walls."""
    # rings that are farther apart than they should be take as much less between them
    radius = setting.cutter.radius - sides.spare
    step = min(setting.over, 2.0 * radius)
    loops = _loops(sides, setting, (step, radius), notes)
    if not loops:
        return []
    sides.require_clear([Track(loop.ring.contour, legs=loop.ring.legs) for loop in loops], setting)
    return _linked(loops, setting, sides, step)


def _loops(sides: Sides, setting: Milling, sizes: tuple[float, float], notes: Notes) -> list[_Loop]:
    """Give the rings from the outside to the inside, with what goes between them."""
    offsets, first, (step, radius) = sides.offsets, sides.reach(setting), sizes
    rooms: list[tuple[Region, ...]] = []
    for k in range(_MOST_RINGS):
        found = offsets.at(-(first + k * step))
        if not found:
            break
        rooms.append(found)
    else:
        raise OffsetError(step, f"more than {_MOST_RINGS} rings", (0.0, 0.0))
    loops: list[_Loop] = []
    ridges = step > radius * (1.0 + 1e-9)
    for k, regions in enumerate(rooms):
        # what goes between two rings counts as a level of its own
        loops += [_Loop(ring, 2 * k) for ring in sides.rings(regions, k * step, setting, notes)]
        if ridges:
            inner = rooms[k + 1] if k + 1 < len(rooms) else ()
            ways = ridge_ways(offsets, inner, first + k * step, step, radius)
            turned = [way if setting.wall == -1 else way.reversed() for way in ways]
            loops += [_Loop(Ring(way), 2 * k + 1) for way in turned]
    return loops


@dataclass(slots=True, eq=False)
class _Net:
    """Loops, what must be cut before each, and what is left to cut."""

    loops: Sequence[Contour]
    P: FloatArray
    segment: FloatArray
    firsts: FloatArray
    before: FloatArray
    """How many loops must still be cut before each, shape (loops,)."""
    near: FloatArray
    """1 where the loop of the row is cut before that of the column."""
    left: FloatArray

    def nearest(self, spot: FloatArray) -> tuple[int, float, FloatArray, int]:
        """Give the nearest loop that may be cut now, how far, the place and its segment."""
        from .order_kernel import nearest_loop

        found = np.empty(5)
        wanted = self.left * (self.before == 0.0)
        nearest_loop(self.P, self.firsts, wanted, float(spot[0]), float(spot[1]), found)
        return int(found[0]), float(found[1]), found[3:5], int(self.segment[int(found[2])])

    def take(self, loop: int) -> None:
        self.left[loop] = 0.0
        self.before -= self.near[loop]


def _net(loops: Sequence[Contour], levels: FloatArray, step: float) -> _Net:
    from .offset_kernel import pieces_of
    from .order_kernel import beside

    vertices, bulges, starts = joined(loops)
    P, segment, firsts = pieces_of(vertices, bulges, starts, 0.0)
    count = len(loops)
    near = np.zeros((count, count))
    beside(P, firsts, levels, step * (1.0 + _BESIDE), near)
    before = near.sum(axis=0)
    for k in range(count):
        segment[int(firsts[k]) : int(firsts[k + 1])] -= starts[k]
    return _Net(loops, P, segment, firsts, before, near, np.ones(count))


def _linked(loops: Sequence[_Loop], setting: Milling, sides: Sides, step: float) -> list[Run]:
    """Give loops as runs, from the inside to the outside, always on to the nearest."""
    levels = np.array([float(loop.level) for loop in loops])
    wall = sides.wall(setting)
    net = _net([loop.ring.contour for loop in loops], levels, step + sides.spare)
    runs: list[Run] = []
    tracks: list[Track] = []
    inmost = int(levels.argmax())
    spot, room = np.array(loops[inmost].ring.contour.vertices[0]), 0.0
    for _ in range(len(loops)):
        loop, far, place, segment = net.nearest(spot)
        net.take(loop)
        ring = loops[loop].ring
        begun = ring.begun(segment, place, setting.wall)
        begin = begun.path.vertices[0]
        if tracks:
            inside = far <= room and not ring.legs
            if far <= _FAR * step and (inside or wall.is_clear(spot, begin)):
                if (begin != spot).any():
                    link = Contour.made(np.array([spot, begin]), np.zeros(1), closed=False)
                    tracks.append(Track(link, setting.wall, link=True))
            else:
                runs.append(Run(tuple(tracks)))
                tracks = []
        tracks.append(begun)
        spot = begun.path.vertices[-1]
        # a loop of the level 2 k is k steps farther from the wall than it must be
        room = (levels[loop] // 2) * step * (1.0 + _BESIDE)
    runs.append(Run(tuple(tracks)))
    return runs
