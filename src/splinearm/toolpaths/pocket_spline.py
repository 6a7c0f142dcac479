"""Sides with splines, and rings along them that are splines themselves, proven not to gouge."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

from splinearm.errors import GougeError, OffsetError, ToolpathError

from .clearance import Wall
from .contour import Contour
from .nesting import Nested
from .offset import Offsets
from .operation import Milling, Notes, Track
from .pocket_side import ContourSides, Ring, Sides, contour_rings
from .profile_spline import keeps_splines
from .region import Region
from .spline_leg import BESIDE, legs_of, path_of
from .spline_offset import offset_outline
from .spline_wall import SplineWall
from .wire import Wire

_MOST_UNPROVEN = 2
"""Where so many rings of a region were not proven, others are not tried."""


def spline_sides(around: Nested, tolerance: float) -> list[Sides]:
    """Give the sides of regions; those without splines are exact.

    Args:
        around: The regions, with arcs in place of splines, and the wires that they were made of.
        tolerance: How much farther than they must be ways may keep off, m.
    """
    return [
        SplineSides(part=part, wires=wires, tolerance=tolerance, slack=around.slack)
        if keeps_splines([wires])
        else ContourSides(part)
        for part, wires in zip(around.regions, around.wires, strict=True)
    ]


@dataclass(frozen=True, eq=False, kw_only=True)
class SplineSides:
    """Sides of lines, arcs and splines."""

    part: Region
    """The region, with arcs in place of the splines."""
    wires: tuple[Wire, ...]
    """The wires that it was made of: its outline, then its openings."""
    tolerance: float
    """How much farther than they must be ways may keep off, m."""
    slack: float
    """How much farther than from splines ways keep off the arcs in their place, m."""
    unproven: list[float] = field(default_factory=list, init=False)
    """How far from the wires no ring was proven, m: that takes long."""

    @property
    def spare(self) -> float:
        """How much farther apart than they should be rings may be, m."""
        return 2.0 * self.tolerance

    @cached_property
    def offsets(self) -> Offsets:
        """What is offset."""
        return Offsets(self.part)

    def reach(self, setting: Milling) -> float:
        """Give how far the cutter's middle stays from the region's lines and arcs, m."""
        return setting.reach + self.slack

    def wall(self, setting: Milling) -> SplineWall:
        """Give what the middle of the cutter keeps away from."""
        return SplineWall.of(self.wires, setting.reach)

    def rings(
        self, rooms: Sequence[Region], inward: float, setting: Milling, notes: Notes
    ) -> list[Ring]:
        """Give the rings along splines; where they cannot be proven, along arcs."""
        count = sum(len(room.contours) for room in rooms)
        distance = setting.reach + inward
        found: list[Ring] = []
        if len(self.unproven) < _MOST_UNPROVEN:
            try:
                found = self._beside(distance, setting.wall)
            except (OffsetError, GougeError, ToolpathError):
                self.unproven.append(distance)
        if len(found) == count:
            return found
        if not inward:
            notes.add("along a wall no way along splines is proven: arcs are taken")
        return contour_rings(rooms, setting)

    def require_clear(self, ways: Sequence[Track], setting: Milling) -> None:
        """Refuse ways that come too near."""
        plain = [way.path for way in ways if not way.legs]
        Wall.of(self.part.contours, self.reach(setting)).require_clear(plain)
        # the splines were proven when they were made, but not the arcs beside them
        beside = [piece for way in ways if way.legs for piece in way.path.pieces()]
        self.wall(setting).require_clear(beside)

    def _beside(self, distance: float, wall: int) -> list[Ring]:
        """Give the proven rings at a distance, in the direction of cutting."""
        outline, *openings = self.wires
        beside = BESIDE * self.tolerance
        found = offset_outline(outline, -distance, self.tolerance, islands=openings)
        rings = []
        for wire in found:
            legs = legs_of((wire if wall == -1 else wire.reversed()).pieces, beside)
            path = path_of(legs)
            rings.append(Ring(Contour.made(path.vertices[:-1], path.bulges), legs, beside))
        return rings
