"""The check in the plane: exact distances of the ways to the part, and of the part to the ways."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

from .action import Move
from .cutter import Cutter, Tip
from .verify_part import Free, Task, Zone, edge_places, interior_places
from .verify_report import Fault
from .verify_way import Track

_THIN = 1e-6
"""Cutters are not looked at where their radius is below this: they touch, they do not gouge, m."""
_STEEP = 1e-6
"""So much do pieces of ramps of pointed and ball cutters fall at most, m."""
_EDGE_PLACES = 20_000
_PLACES = 20_000
_FAR = 1e-4
"""It is not told how far ways stay off the part beyond this, m."""
_LOOKS = 500
"""So many places where something is left are asked whether the cutter could have been there."""


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """What cuts: moves, each with its cutter, and their pieces."""

    moves: Sequence[Move]
    """The moves."""
    cutters: Sequence[Cutter]
    """The cutter of each."""
    track: Track
    """Their pieces."""

    def line(self, owner: float) -> int:
        """Give the line of the program that a piece is of."""
        return self.moves[int(owner)].line

    def tools(self) -> list[Cutter]:
        """Give the cutters, each once."""
        return list({id(cutter): cutter for cutter in self.cutters}.values())

    def with_track(self, track: Track) -> "Cuts":
        """Give some of the pieces."""
        return Cuts(self.moves, self.cutters, track)

    def of_tool(self, cutter: Cutter) -> Track:
        """Give the pieces that a cutter goes."""
        own = np.array([other is cutter for other in self.cutters], dtype=bool)
        return self.track.where(own[self.track.owners.astype(np.intp)])


@dataclass(frozen=True, slots=True, eq=False)
class Leftover:
    """What the ways leave of a zone."""

    left: float
    """The most where the cutter could have been, m."""
    unreachable: float
    """The most where it could not, m."""
    faults: tuple[Fault, ...]
    """What is wrong."""


def gouges(task: Task, cuts: Cuts, tolerance: float) -> tuple[float, list[Fault]]:
    """Give how far ways cut into the part at the most, and where more than a tolerance."""
    asked = bool(task.zones or task.lines)
    deepest, faults = -_FAR if asked else 0.0, list[Fault]()
    for level in task.levels() if asked else ():
        free = task.free_below(level)
        if free.everywhere:
            continue
        for cutter in cuts.tools():
            track = cuts.of_tool(cutter).below(level - tolerance)
            if len(track.pieces) == 0:
                continue
            steepest = inf if cutter.tip is Tip.FLAT else _STEEP
            track = track.fine(max(cutter.radius, 10.0 * _THIN), steepest)
            worst, found = _into(free, level, cutter, track, cuts, tolerance)
            deepest = max(deepest, worst)
            faults += found
    return deepest, faults


def _into(
    free: Free, level: float, cutter: Cutter, track: Track, cuts: Cuts, tolerance: float
) -> tuple[float, list[Fault]]:
    """Give how far pieces cut into what stands at a level and is not free."""
    from .verify_kernel import clearances

    depths = level - track.heights.min(axis=1)
    reach = np.array([cutter.radius_at(depth) for depth in depths.tolist()])
    looked = reach > _THIN
    if len(free.outline) == 0:  # nothing is free there
        x, y = track.pieces[0, :2]
        owner = track.owners[0]
        says = "cuts where nothing shall be cut"
        where = (float(x), float(y), float(track.heights[0].min()))
        fault = Fault(kind="gouge", line=cuts.line(owner), where=where, amount=float(reach.max()),
                      count=len(np.unique(track.owners)), says=says)  # fmt: skip
        return float(reach.max()), [fault]
    found = np.empty((len(reach), 3))
    slack = max(_FAR, tolerance)
    clearances(np.ascontiguousarray(track.pieces), reach + slack, free.outline, found)
    into = np.where(np.isfinite(found[:, 0]), reach - found[:, 0], -slack)
    beyond = ~free.holds(track.pieces[:, :2]) | ~free.holds(track.pieces[:, 2:4])
    # an end that lies on the edge itself is in neither
    far = np.maximum(free.gaps(track.pieces[:, :2]), free.gaps(track.pieces[:, 2:4]))
    beyond &= far > tolerance
    into = np.where(beyond, reach + far, into)
    found[beyond, 1:] = track.pieces[beyond, :2]
    into[~looked & ~beyond] = -slack
    wrong = into > tolerance
    if not wrong.any():
        return float(into.max()), []
    i = int(np.argmax(into))
    where = (float(found[i, 1]), float(found[i, 2]), float(track.heights[i].min()))
    amount = float(into[i])
    fault = Fault(
        kind="gouge",
        line=cuts.line(track.owners[i]),
        where=where,
        amount=amount,
        count=len(np.unique(track.owners[wrong])),
        says=f"cuts {amount * 1e3:.6g} mm into the part",
    )
    return amount, [fault]


def too_deep(task: Task, cuts: Cuts, tolerance: float) -> Iterator[Fault]:
    """Give ways that go below every floor."""
    floors = task.floors_asked()
    if not floors or len(cuts.track.pieces) == 0:
        return
    lowest = min(floors)
    low = cuts.track.heights.min(axis=1)
    wrong = low < lowest - tolerance
    if wrong.any():
        i = int(np.argmin(low))
        x, y = cuts.track.pieces[i, :2].tolist()
        amount = float(lowest - low[i])
        yield Fault(
            kind="too deep",
            line=cuts.line(cuts.track.owners[i]),
            where=(x, y, float(low[i])),
            amount=amount,
            count=len(np.unique(cuts.track.owners[wrong])),
            says=f"goes {amount * 1e3:.6g} mm below the floor",
        )


def leftovers(task: Task, zone: Zone, cuts: Cuts, allowed: tuple[float, float]) -> Leftover:
    """Give what is left of a zone by places of its edge and, if it shall be cleared, of its inside.

    Args:
        task: The whole task.
        zone: The zone.
        cuts: What cuts.
        allowed: What may be left, and how much farther than they must cutters may keep off, m.
    """
    tolerance, beside = allowed
    if not cuts.moves:
        x, y = zone.regions[0].outer.vertices[0].tolist()
        where = (x, y, zone.floor)
        says = "nothing is cut"
        return Leftover(inf, 0.0, (Fault(kind="left over", where=where, amount=inf, says=says),))
    free = task.free_below(zone.floor + 2e-9)
    radii = [cutter.radius_at(task.surface_of(zone) - zone.floor) for cutter in cuts.tools()]
    radius = min((r for r in radii if r > _THIN), default=0.0)
    if radius == 0.0:
        return Leftover(0.0, 0.0, ())
    points, inward = edge_places(zone, 0.25 * radius, _EDGE_PLACES)
    left = _left(task, zone, cuts, points, zone.floor)
    if zone.tab_height:
        higher = _left(task, zone, cuts, points, zone.floor + zone.tab_height)
        if (left > tolerance).mean() <= 0.5:
            left = higher
    wrong = np.flatnonzero(left > tolerance)
    # only a disc that touches there covers a place on a smooth edge
    wide = radius + beside
    centres = points[wrong] + wide * inward[wrong]
    reached = free.holds(centres) & (free.gaps(centres) >= wide - 1e-9)
    found = _sorted(zone, points[wrong], left[wrong], reached, "along the edge")
    rest = _clean(left, tolerance)
    if not zone.cleared or any(cutter.tip is not Tip.FLAT for cutter in cuts.tools()):
        return Leftover(max(rest, found.left), found.unreachable, found.faults)
    points = interior_places(zone, 0.25 * radius, _PLACES)
    left = _left(task, zone, cuts, points, zone.floor)
    wrong = np.flatnonzero(left > tolerance)
    looked = wrong[np.argsort(-left[wrong])][:: max(1, len(wrong) // _LOOKS)]
    reached = free.reachable(points[looked], wide)
    inner = _sorted(zone, points[looked], left[looked], reached, "inside")
    return Leftover(
        max(rest, found.left, inner.left),
        max(found.unreachable, inner.unreachable),
        (*found.faults, *inner.faults),
    )


def _clean(left: FloatArray, tolerance: float) -> float:
    """Give the most that is left where it is not too much."""
    return float(left[left <= tolerance].max(initial=0.0))


def _sorted(
    zone: Zone, points: FloatArray, left: FloatArray, reached: npt.NDArray[np.bool_], where: str
) -> Leftover:
    """Tell what could have been cut from what could not."""
    faults: tuple[Fault, ...] = ()
    if reached.any():
        i = int(np.flatnonzero(reached)[np.argmax(left[reached])])
        amount = float(left[i])
        x, y = points[i].tolist()
        faults = (
            Fault(
                kind="left over",
                where=(x, y, zone.floor),
                amount=amount,
                count=int(reached.sum()),
                says=f"leaves {amount * 1e3:.6g} mm of the material {where}",
            ),
        )
    return Leftover(
        float(left[reached].max(initial=0.0)), float(left[~reached].max(initial=0.0)), faults
    )


def _left(task: Task, zone: Zone, cuts: Cuts, points: FloatArray, floor: float) -> FloatArray:
    """Give how far places are from what cutters cut at a floor, shape (m,), m."""
    left = np.full(len(points), inf)
    for cutter in cuts.tools():
        radius = cutter.radius_at(task.surface_of(zone) - zone.floor)
        if radius > _THIN:
            low = cuts.of_tool(cutter).below(floor + 1e-7)
            left = np.minimum(left, low.gaps(points, radius * (1.0 - 1e-3)) - radius)
    return left
