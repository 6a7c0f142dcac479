"""Pockets cleared by parallel contours, each from the part, from the inside to the outside."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import OffsetError

from .clearance import Wall
from .contour import Contour, joined
from .lead_in import with_leads
from .mill import Mill
from .offset import Offsets
from .operation import Milled, Milling, Run, Track
from .region import Region
from .ridge import ridge_ways
from .stretch import begun_at, begun_on

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
    if not parts:
        raise ValueError("parts: want at least one")
    mill = Mill(setting)
    for part in parts:
        mill.wall = Wall.of(part.contours, setting.reach)
        runs = pocket_runs(part, setting, mill.wall)
        if not runs:
            x, y = (part.outer.vertices.mean(axis=0) * 1e3).tolist()
            mill.notes.add(f"the pocket at ({x:.6g}, {y:.6g}) mm is too narrow for the cutter")
            continue
        mill.cut(runs, setting.levels)
        if setting.finish:
            finish(mill, part)
    return mill.milled()


def finish(mill: Mill, part: Region) -> None:
    """Take off what was left on the sides of a pocket, at full depth."""
    setting = mill.setting
    mill.setting = replace(setting, stock=0.0, finish=False)
    reach = mill.setting.reach
    mill.wall = Wall.of(part.contours, reach)
    ways = wall_ways(Offsets(part).at(-reach), setting)
    mill.wall.require_clear([way.path for way in ways])
    runs = [with_leads(way, mill.wall, setting.lead, mill.notes) for way in ways]
    mill.cut(runs, setting.levels[-1:], whole=True)
    mill.setting = setting


def wall_ways(regions: Sequence[Region], setting: Milling) -> list[Track]:
    """Give the contours of regions in which the cutter's middle may be, as ways along the wall."""
    ways = []
    for region in regions:
        for contour in region.contours:
            turned = contour if setting.wall == -1 else contour.reversed()
            longest = int(turned.lengths.argmax())
            middle = float(turned.lengths[:longest].sum() + 0.5 * turned.lengths[longest])
            ways.append(Track(begun_at(turned, middle), setting.wall))
    return ways


@dataclass(frozen=True, slots=True, eq=False)
class _Loop:
    """A way of the pocket before it is known where it begins."""

    contour: Contour
    level: int


def pocket_runs(part: Region, setting: Milling, wall: Wall) -> list[Run]:
    """Give the ways that clear a region, linked where that is clear of its walls."""
    step = setting.over
    loops = _loops(part, setting, step)
    if not loops:
        return []
    turned = [c if setting.wall == -1 else c.reversed() for c in (loop.contour for loop in loops)]
    wall.require_clear(turned)
    levels = np.array([float(loop.level) for loop in loops])
    return _linked(turned, levels, setting, wall)


def _loops(part: Region, setting: Milling, step: float) -> list[_Loop]:
    """Give the rings from the outside to the inside, with what goes between them."""
    offsets = Offsets(part)
    first = setting.reach
    rings: list[tuple[Region, ...]] = []
    for k in range(_MOST_RINGS):
        found = offsets.at(-(first + k * step))
        if not found:
            break
        rings.append(found)
    else:
        raise OffsetError(step, f"more than {_MOST_RINGS} rings", (0.0, 0.0))
    loops: list[_Loop] = []
    ridges = step > setting.cutter.radius * (1.0 + 1e-9)
    for k, regions in enumerate(rings):
        # what goes between two rings counts as a level of its own
        loops += [_Loop(c, 2 * k) for region in regions for c in region.contours]
        if ridges:
            inner = rings[k + 1] if k + 1 < len(rings) else ()
            ways = ridge_ways(offsets, inner, first + k * step, step, setting.cutter.radius)
            loops += [_Loop(way, 2 * k + 1) for way in ways]
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


def _linked(
    loops: Sequence[Contour], levels: FloatArray, setting: Milling, wall: Wall
) -> list[Run]:
    """Give loops as runs, from the inside to the outside, always on to the nearest."""
    net = _net(loops, levels, setting.over)
    runs: list[Run] = []
    tracks: list[Track] = []
    inmost = int(levels.argmax())
    spot, room = np.array(loops[inmost].vertices[0]), 0.0
    for _ in range(len(loops)):
        loop, far, place, segment = net.nearest(spot)
        net.take(loop)
        contour = loops[loop]
        begun = begun_on(contour, segment, place)
        begin = begun.vertices[0]
        if tracks:
            if far <= _FAR * setting.over and (far <= room or wall.is_clear(spot, begin)):
                if (begin != spot).any():
                    link = Contour.made(np.array([spot, begin]), np.zeros(1), closed=False)
                    tracks.append(Track(link, setting.wall, link=True))
            else:
                runs.append(Run(tuple(tracks)))
                tracks = []
        tracks.append(Track(begun, setting.wall))
        spot = begun.vertices[-1]
        # a loop of the level 2 k is k steps farther from the wall than it must be
        room = (levels[loop] // 2) * setting.over * (1.0 + _BESIDE)
    runs.append(Run(tuple(tracks)))
    return runs
