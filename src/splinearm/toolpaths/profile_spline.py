"""Profiles along splines as splines, proven not to gouge; leads and ramps are arcs beside them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from .operation import Milled, Milling, Notes, Side, Track
from .piece import SplinePiece
from .profile_pass import cut_edges, tell_narrow, turned
from .spline_leg import BESIDE, begun_well, legs_of, path_of
from .spline_offset import offset_outline
from .spline_wall import SplineWall
from .tab import Tabs
from .wire import Wire


def keeps_splines(wires: Iterable[Sequence[Wire]]) -> bool:
    """Say whether wires have splines for a profile to go along."""
    pieces = (piece for group in wires for wire in group for piece in wire.pieces)
    return any(isinstance(piece, SplinePiece) for piece in pieces)


def spline_profile(
    parts: Sequence[Sequence[Wire]],
    setting: Milling,
    side: Side,
    tolerance: float,
    tabs: Tabs | None = None,
) -> Milled:
    """Go along outlines and openings beside them or on them; splines stay splines.

    Leads are arcs and ramps go along arcs, as controllers keep splines level. Where tabs stay
    splines are cut in two, exactly.

    Args:
        parts: Of each part the closed wires: its outline, then its openings.
        setting: The cutter and how it is used.
        side: Outside of the parts, inside of them, or on the wires themselves.
        tolerance: How much farther from the wires than its radius the cutter may be, m.
        tabs: Where contours stay joined to the stock; openings have as many as have room; None:
            nowhere.

    Raises:
        GougeError: If a way would come nearer to any of the parts than the cutter's radius.
        OffsetError: If a wire crosses itself or no way passes its check.
        ValueError: If tabs have no room.
    """
    return cut_edges(_Wires(tuple(tuple(part) for part in parts), side, tolerance), setting, tabs)


@dataclass(frozen=True, slots=True, eq=False)
class _Wires:
    """The wires of parts."""

    parts: tuple[tuple[Wire, ...], ...]
    side: Side
    tolerance: float

    @property
    def beside(self) -> float:
        return BESIDE * self.tolerance

    def wall(self, distance: float) -> SplineWall | None:
        if self.side is Side.ON:
            return None
        return SplineWall.of([wire for part in self.parts for wire in part], distance)

    def ways(self, setting: Milling, notes: Notes) -> tuple[list[Track], list[Track]]:
        groups: tuple[list[Track], list[Track]] = [], []
        turn = turned(setting, self.side)
        wall = 0 if self.side is Side.ON else setting.wall
        for part in self.parts:
            for wire in self._beside(part, setting.reach, notes):
                around = self.side is Side.INSIDE or wire.area > 0.0
                pieces = (wire.reversed() if turn else wire).pieces
                legs = legs_of(begun_well(pieces), self.beside)
                groups[around].append(Track(path_of(legs), wall, legs=legs))
        return groups

    def require_clear(self, ways: Sequence[Track], distance: float) -> None:
        # those beside one part were proven when they were made, but not the arcs beside them
        beside = [piece for way in ways for piece in way.path.pieces()]
        other = [leg.piece for way in ways for leg in way.legs] if len(self.parts) > 1 else []
        wall = self.wall(distance)
        if wall is not None:
            wall.require_clear(beside + other)

    def _beside(self, part: Sequence[Wire], reach: float, notes: Notes) -> tuple[Wire, ...]:
        outline, *openings = part
        if self.side is Side.ON:  # the part lies to the left of its wires
            return offset_outline(outline, 0.0, self.tolerance, islands=openings)
        distance = reach if self.side is Side.OUTSIDE else -reach
        found = offset_outline(outline, distance, self.tolerance, islands=openings)
        if len(found) < len(part) or not found:
            narrow = openings if self.side is Side.OUTSIDE else [outline] * (not found)
            for wire in narrow:
                if self.side is Side.INSIDE or not offset_outline(wire, -reach, self.tolerance):
                    tell_narrow(np.mean([piece.start for piece in wire.pieces], axis=0), notes)
        return found
