"""Offsets of lines and arcs: exact, trimmed, checked."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from math import frexp, isfinite, ldexp
from typing import TYPE_CHECKING

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import OffsetError

from .contour import Contour, joined
from .offset_check import raise_of
from .region import Region

if TYPE_CHECKING:
    from .offset_corner_kernel import Corner
    from .offset_made_kernel import Model

_CORNERS = {"round": 0.0, "mitre": 1.0, "chamfer": 2.0}
_ENDS = ("round", "butt", "square")
_LONGER = 1e-9
_DIAGONAL = 1.4143
"""So many distances an end that is square reaches, and more than any corner that is cut across."""


@dataclass(frozen=True, slots=True, eq=False)
class _Scaled:
    """Loops moved to the origin and scaled to about 1, with what is searched in them."""

    model: "Model"
    unit: float
    """What is 1, m: a power of two."""
    outward: bool
    turned: bool
    """Whether the loops run the other way."""


def _scaled(
    contours: Iterable[Contour], reach: float, *, outward: bool, turned: bool = False
) -> _Scaled:
    from .offset_made_kernel import prepared

    model = prepared(*joined(contours), reach, 1.0 if turned else 0.0)
    return _Scaled(model, float(model[-1][2]), outward, turned)


@dataclass(frozen=True, slots=True, eq=False)
class _Loops:
    """Closed loops one after the other."""

    vertices: FloatArray
    bulges: FloatArray
    numbers: FloatArray
    """The same along one line or arc, rising along the part; not of turned ones."""
    starts: FloatArray
    """The first vertex of each loop and how many there are."""
    areas: FloatArray
    """Of each, before it was turned."""

    @property
    def bounds(self) -> list[int]:
        return [int(start) for start in self.starts.tolist()]


@dataclass(frozen=True, slots=True, eq=False)
class Offsets:
    """A part to be offset again and again: what is searched is made once."""

    part: Region
    """The part."""
    _sides: dict[tuple[bool, float], _Scaled] = field(init=False, repr=False, default_factory=dict)

    def at(
        self, distance: float, *, corner: str = "round", mitre_limit: float = 2.0
    ) -> tuple[Region, ...]:
        """Give all points of the part, grown or shrunk by a distance: see `offset`."""
        style = _style(corner, distance, mitre_limit)
        if distance == 0.0:
            return (self.part,)
        outward = distance > 0.0
        scaled = self._side(outward, abs(distance))
        return _regions(_offset_loops(scaled, abs(distance), style), outward=outward)

    def _side(self, outward: bool, reach: float) -> _Scaled:  # noqa: FBT001
        found = self._sides.get((outward, 0.0))
        if found is None:
            found = _scaled(self.part.contours, 0.0, outward=outward, turned=outward)
            self._sides[outward, 0.0] = found
        if reach <= found.unit:
            return found
        # a distance beyond the size of the part wants a larger scale
        key = outward, ldexp(1.0, frexp(reach)[1])
        if key not in self._sides:
            self._sides[key] = _scaled(self.part.contours, key[1], outward=outward, turned=outward)
        return self._sides[key]


def offset(
    shape: Contour | Region, distance: float, *, corner: str = "round", mitre_limit: float = 2.0
) -> tuple[Region, ...]:
    """Give a closed shape grown or shrunk by a distance; lines stay lines and arcs arcs.

    Grown: all points within the distance of the shape; shrunk: all that are farther than the
    distance from what is outside of it. Regions split, join and vanish as they do; the result is
    exact but for rounding, and checked.

    Args:
        shape: A region, or a closed contour, whose direction does not matter.
        distance: How far, m; above 0 grown, below 0 shrunk.
        corner: How the offset goes around corners: "round", "mitre" (straight on until both sides
            meet) or "chamfer" (cut off across at the distance). None of them is nearer than it.
        mitre_limit: A mitre that reaches farther than this many distances becomes a chamfer.

    Raises:
        ContourError: If the shape crosses itself.
        OffsetError: If no result passes its check.
        GougeError: If the only result is nearer to the shape than the distance.
        ValueError: If a contour is open, or the distance is not finite.
    """
    part = shape if isinstance(shape, Region) else Region(shape)
    return Offsets(part).at(distance, corner=corner, mitre_limit=mitre_limit)


def rings(part: Region, distances: Iterable[float]) -> tuple[tuple[Region, ...], ...]:
    """Give the offsets of a part by several distances, each from the part itself.

    Args:
        part: The part.
        distances: The distances, m, see `offset`.
    """
    offsets = Offsets(part)
    return tuple(offsets.at(distance) for distance in distances)


def offset_path(
    path: Contour,
    distance: float,
    *,
    corner: str = "round",
    mitre_limit: float = 2.0,
    end: str = "butt",
) -> tuple[Contour, ...]:
    """Give the ways beside a path on which a cutter of that radius touches and cuts none of it.

    Every point of the result is at the distance from the path (farther at corners and ends that
    are not round) and none of the path is nearer, also not its far side or its ends.

    Args:
        path: Open or closed.
        distance: How far, m; above 0 to the left of the path, below 0 to the right.
        corner: How the offset goes around corners, see `offset`.
        mitre_limit: See `offset`.
        end: How the ways of an open path end: "butt" beside its ends, "square" straight on by the
            distance and across, until they are ahead of the ends, "round" around them as far.

    Returns:
        The ways in the direction of the path, in the order of where they begin beside it.

    Raises:
        OffsetError: If no result passes its check.
        GougeError: If the only result is nearer to the path than the distance.
        ValueError: If a name is unknown, or the distance is not finite.
    """
    style = _style(corner, distance, mitre_limit)
    _require_end(end)
    if distance == 0.0:
        return (path,)
    if path.closed:
        return _beside_closed(path, distance, corner, mitre_limit)
    forward = path if distance > 0.0 else path.reversed()
    scaled = _scaled((_there_and_back(forward),), abs(distance), outward=True)
    last = len(path.bulges) - 1
    # what goes around ends is asked for in halves: one belongs to this side
    style = (*style[:2], 3.0 if end == "square" else 2.0, float(last))
    loops = _offset_loops(scaled, abs(distance), style)
    ways = _ways(loops, last, around=end != "butt")
    if distance < 0.0:
        ways = [way.reversed() for way in reversed(ways)]
    return tuple(ways)


def widened(
    path: Contour,
    distance: float,
    *,
    corner: str = "round",
    mitre_limit: float = 2.0,
    end: str = "round",
) -> tuple[Region, ...]:
    """Give all points within a distance of an open path: a slot.

    Args:
        path: An open path.
        distance: How far to each side, m, above 0.
        corner: How it goes around corners, see `offset`.
        mitre_limit: See `offset`.
        end: How it ends: "round", "square" (straight on by the distance) or "butt" (flat where the
            path ends, which wants lines there that are longer than the distance).

    Raises:
        OffsetError: If no result passes its check, or an end is to be flat but its last line is an
            arc or not longer than the distance.
        GougeError: If the only result is nearer to the path than the distance.
        ValueError: If the path is closed, a name is unknown, or the distance is not above 0.
    """
    if path.closed:
        raise ValueError("path: want an open one; of a closed one take `offset`")
    style = _style(corner, distance, mitre_limit)
    _require_end(end)
    if not distance > 0.0:
        raise ValueError(f"distance: want a length above zero, got {distance}")
    if end == "butt" and len(path.bulges) == 1 and path.bulges[0] == 0.0:
        return (_bar(path, distance),)
    if end == "butt":
        # square ends of what is shorter by the distance are flat where the path ends
        path = _shortened(path, distance)
    style = (*style[:2], 0.0 if end == "round" else 1.0, float(len(path.bulges) - 1))
    scaled = _scaled((_there_and_back(path),), distance, outward=True, turned=True)
    return _regions(_offset_loops(scaled, distance, style), outward=True)


def _require_end(end: str) -> None:
    if end not in _ENDS:
        raise ValueError(f"end: want one of {', '.join(_ENDS)}, got {end!r}")


def _bar(path: Contour, distance: float) -> Region:
    """Give the rectangle about a line."""
    a, b = path.vertices
    way = (b - a) * (distance / float(np.hypot(*(b - a))))
    side = np.array([-way[1], way[0]])
    return Region(Contour.polyline([a - side, b - side, b + side, a + side]))


def _shortened(path: Contour, distance: float) -> Contour:
    """Give a path that ends in lines, shorter by a distance at both ends."""
    vertices = path.vertices.copy()
    for here, inner, k in ((0, 1, 0), (-1, -2, -1)):
        way = path.vertices[inner] - path.vertices[here]
        length = float(np.hypot(*way))
        if path.bulges[k] != 0.0 or not length > distance * (1.0 + _LONGER):
            x, y = path.vertices[here].tolist()
            raise OffsetError(
                distance, "a flat end wants a straight line there, longer than it", (x, y)
            )
        vertices[here] += way * (distance / length)
    return Contour.made(vertices, path.bulges.copy(), closed=False)


def _style(corner: str, distance: float, mitre_limit: float) -> "Corner":
    """Give how corners are joined as kernels take it, and the reach of corners."""
    if corner not in _CORNERS:
        raise ValueError(f"corner: want one of {', '.join(_CORNERS)}, got {corner!r}")
    if not isfinite(distance):
        raise ValueError(f"distance: want a finite length, got {distance}")
    if not mitre_limit >= 1.0:
        raise ValueError(f"mitre_limit: want 1 or more, got {mitre_limit}")
    return _CORNERS[corner], mitre_limit, 0.0, -1.0


def _offset_loops(scaled: _Scaled, distance: float, style: "Corner") -> _Loops:
    """Give checked loops of the offset to the left."""
    from .offset_made_kernel import OPEN, checked_loops

    reach = 1.0
    if style[0] != 0.0 or style[2] % 2.0 == 1.0:
        reach = max(style[1] if style[0] == 1.0 else 1.0, _DIAGONAL)
    *loops, said = checked_loops(
        scaled.model,
        distance,
        style,
        reach,
        1.0 if scaled.outward else 0.0,
        1.0 if scaled.turned else 0.0,
    )
    if said[0] == OPEN:
        raise OffsetError(distance, "its pieces do not close to loops", (said[1], said[2]))
    raise_of(said, distance)
    return _Loops(*loops)


def _regions(loops: _Loops, *, outward: bool) -> tuple[Region, ...]:
    """Give the regions that loops enclose."""
    if len(loops.areas) == 1:
        return (Region.made(Contour.made(loops.vertices, loops.bulges)),)
    outers: list[tuple[float, Contour]] = []
    islands: list[Contour] = []
    bounds = loops.bounds
    for k, area in enumerate(loops.areas.tolist()):
        own = slice(bounds[k], bounds[k + 1])
        contour = Contour.made(loops.vertices[own], loops.bulges[own])
        if (area > 0.0) != outward:
            outers.append((abs(area), contour))
        else:
            islands.append(contour)
    if len(outers) == 1:
        return (Region.made(outers[0][1], tuple(islands)),)
    # an island belongs to the smallest outer contour around it
    outers.sort(key=lambda pair: pair[0])
    inside: list[list[Contour]] = [[] for _ in outers]
    for island in islands:
        spot = _spot(island)
        for k, (_, outer) in enumerate(outers):
            if outer.contains(spot):
                inside[k].append(island)
                break
    pairs = zip(outers, inside, strict=True)
    return tuple(Region.made(outer, tuple(inner)) for (_, outer), inner in pairs)


def _spot(contour: Contour) -> FloatArray:
    """Give the middle of a contour's longest segment: where it touches others least."""
    longest = int(contour.lengths.argmax())
    start, end = contour.starts[longest], contour.ends[longest]
    way = end - start
    height = 0.5 * contour.bulges[longest]
    middle: FloatArray = 0.5 * (start + end) + height * np.array([way[1], -way[0]])
    return middle


def _there_and_back(path: Contour) -> Contour:
    """Give the closed contour along an open one and back."""
    vertices = np.concatenate((path.vertices, path.vertices[-2:0:-1]))
    return Contour.made(vertices, np.concatenate((path.bulges, -path.bulges[::-1])))


def _beside_closed(
    path: Contour, distance: float, corner: str, mitre_limit: float
) -> tuple[Contour, ...]:
    leftward = path.area > 0.0
    grown = abs(distance) if (distance > 0.0) != leftward else -abs(distance)
    regions = offset(path, grown, corner=corner, mitre_limit=mitre_limit)
    contours = tuple(contour for region in regions for contour in region.contours)
    return contours if leftward else tuple(contour.reversed() for contour in contours)


def _ways(loops: _Loops, last: int, *, around: bool) -> list[Contour]:
    """Give what of loops lies beside a path there, up to its last segment, as open contours.

    Args:
        loops: Around the path there and back.
        last: The last segment of the way there.
        around: Whether half of what goes around the ends belongs to it.
    """
    before, behind = 4.0 * last + 3.5, 2.0 * last + 1.0
    found: list[tuple[float, Contour]] = []
    for first, end in pairwise(loops.bounds):
        vertices, bulges = loops.vertices[first:end], loops.bulges[first:end]
        numbers = loops.numbers[first:end]
        numbers = np.where(numbers == before, -1.0, numbers) if around else numbers
        kept = numbers <= behind if around else numbers < behind
        if kept.all():
            found.append((float(numbers[0]), Contour.made(vertices, bulges)))
            continue
        # begun behind a segment that is not wanted, no run goes on over the end
        shift = int(np.argmin(kept))
        order = np.roll(np.arange(end - first), -shift)
        kept = kept[order]
        edges = np.flatnonzero(np.diff(np.concatenate(([False], kept, [False])).astype(int)))
        for a, b in edges.reshape(-1, 2).tolist():
            run = order[np.arange(a, b + 1) % len(order)]
            way = Contour.made(vertices[run], bulges[run[:-1]], closed=False)
            found.append((float(numbers[run[0]]), way))
    return [way for _, way in sorted(found, key=lambda pair: pair[0])]
