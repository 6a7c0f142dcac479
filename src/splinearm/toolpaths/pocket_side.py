"""The sides of what is cleared, and the rings along them, as what they are made of has them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from splinearm.arrays import FloatArray

from .clearance import Wall
from .contour import Contour
from .offset import Offsets
from .operation import Barrier, Milling, Notes, Track
from .region import Region
from .spline_leg import Leg, begun_legs, path_of
from .stretch import along_of, begun_at, begun_on


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A closed way, in the direction of cutting, before it is known where it begins."""

    contour: Contour
    """The way, closed; where there are splines the lines and arcs beside them."""
    legs: tuple[Leg, ...] = ()
    """What it is where there are splines."""
    beside: float = 0.0
    """How far from the splines the arcs are at most, m."""

    def begun(self, segment: int, place: FloatArray, wall: int) -> Track:
        """Give the way begun at a place of one of its segments."""
        if self.legs:
            return self.begun_at(along_of(self.contour, segment, place), wall)
        return Track(begun_on(self.contour, segment, place), wall)

    def begun_amid(self, wall: int) -> Track:
        """Give the way begun in the middle of its longest line or arc."""
        lengths = self.contour.lengths
        longest = int(lengths.argmax())
        middle = float(lengths[:longest].sum() + 0.5 * lengths[longest])
        return self.begun_at(middle, wall)

    def begun_at(self, along: float, wall: int) -> Track:
        """Give the way begun at a place by how far along it is, m; of splines about there."""
        if not self.legs:
            return Track(begun_at(self.contour, along), wall)
        legs = begun_legs(self.legs, along % self.contour.length, self.beside)
        return Track(path_of(legs), wall, legs=legs)


class Sides(Protocol):
    """The sides of a region that is cleared."""

    @property
    def part(self) -> Region:
        """The region, of lines and arcs."""
        ...

    @property
    def spare(self) -> float:
        """How much farther apart than they should be its rings may be, m."""
        ...

    @property
    def offsets(self) -> Offsets:
        """What is offset."""
        ...

    def reach(self, setting: Milling) -> float:
        """Give how far the cutter's middle stays from the region's lines and arcs, m."""
        ...

    def wall(self, setting: Milling) -> Barrier:
        """Give what the middle of the cutter keeps away from."""
        ...

    def rings(
        self, rooms: Sequence[Region], inward: float, setting: Milling, notes: Notes
    ) -> list[Ring]:
        """Give the rings around where the middle may be, so much farther in than it may be.

        Args:
            rooms: The same, of lines and arcs.
            inward: How much farther in than the cutter's middle may be, m.
            setting: The cutter and how it is used.
            notes: Where it is told what cannot be done as it should be.
        """
        ...

    def require_clear(self, ways: Sequence[Track], setting: Milling) -> None:
        """Refuse ways that come too near."""
        ...


@dataclass(frozen=True, eq=False)
class ContourSides:
    """Sides of lines and arcs."""

    part: Region
    """The region."""

    spare = 0.0

    @cached_property
    def offsets(self) -> Offsets:
        """What is offset."""
        return Offsets(self.part)

    def reach(self, setting: Milling) -> float:
        """Give how far the cutter's middle stays from the region's lines and arcs, m."""
        return setting.reach

    def wall(self, setting: Milling) -> Wall:
        """Give what the middle of the cutter keeps away from."""
        return Wall.of(self.part.contours, setting.reach)

    def rings(
        self, rooms: Sequence[Region], inward: float, setting: Milling, notes: Notes
    ) -> list[Ring]:
        """Give the rings: the contours themselves."""
        del inward, notes
        return contour_rings(rooms, setting)

    def require_clear(self, ways: Sequence[Track], setting: Milling) -> None:
        """Refuse ways that come too near."""
        self.wall(setting).require_clear([way.path for way in ways])


def contour_rings(rooms: Sequence[Region], setting: Milling) -> list[Ring]:
    """Give the contours of regions as rings."""
    contours = [contour for room in rooms for contour in room.contours]
    return [Ring(c if setting.wall == -1 else c.reversed()) for c in contours]


def along_walls(sides: Sides, setting: Milling, notes: Notes) -> list[Track]:
    """Give the ways along the walls."""
    rings = sides.rings(sides.offsets.at(-sides.reach(setting)), 0.0, setting, notes)
    return [ring.begun_amid(setting.wall) for ring in rings]


def tell_narrow(sides: Sides, notes: Notes) -> None:
    """Tell that the cutter has no room."""
    x, y = (sides.part.outer.vertices.mean(axis=0) * 1e3).tolist()
    notes.add(f"the pocket at ({x:.6g}, {y:.6g}) mm is too narrow for the cutter")
