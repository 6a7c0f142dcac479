"""Profiles along splines as splines: proven not to gouge, in a tenth of the lines of a program."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from .chain import Wire
from .engrave import engrave
from .operation import Entry, Milled, Milling, Side
from .piece import SplinePiece
from .spline_offset import offset_outline


def keeps_splines(wires: Iterable[Sequence[Wire]], setting: Milling) -> bool:
    """Say whether a profile of wires has splines and goes along them plainly.

    Ramps, leads and tabs go along lines and arcs.
    """
    plain = setting.entry is Entry.PLUNGE and not setting.lead
    pieces = (piece for group in wires for wire in group for piece in wire.pieces)
    return plain and any(isinstance(piece, SplinePiece) for piece in pieces)


def spline_profile(
    parts: Sequence[Sequence[Wire]], setting: Milling, side: Side, tolerance: float
) -> Milled:
    """Go along outlines and openings on one side of them; splines stay splines.

    Args:
        parts: Of each part the closed wires: its outline, then its openings.
        setting: The cutter and how it is used; it comes straight down.
        side: Outside of the parts or inside of them.
        tolerance: How much farther from the wires than its radius the cutter may be, m.

    Raises:
        GougeError: If the only way found would cut into a part.
        OffsetError: If a wire crosses itself or no way passes its check.
        ValueError: If ways are to go on the wires themselves.
    """
    if side is Side.ON:
        raise ValueError("side: want outside or inside; along the line engrave")
    passes = [engrave(_beside(parts, setting, side, tolerance), setting)]
    if setting.finish:
        last = replace(setting, stock=0.0, finish=False, step_down=setting.depth)
        passes.append(engrave(_beside(parts, last, side, tolerance), last))
    actions = tuple(action for milled in passes for action in milled.actions)
    return Milled(actions, tuple(note for milled in passes for note in milled.notes))


def _beside(
    parts: Sequence[Sequence[Wire]], setting: Milling, side: Side, tolerance: float
) -> list[Wire]:
    """Give the ways of the cutter's middle, in the direction in which it shall cut."""
    reach = setting.cutter.radius + setting.stock
    distance = reach if side is Side.OUTSIDE else -reach
    ways: list[Wire] = []
    for outline, *openings in parts:
        ways += offset_outline(outline, distance, tolerance, islands=openings)
    # what ways enclose lies to their left: the part outside of it, what is beside it inside
    wall = 1 if side is Side.OUTSIDE else -1
    return ways if wall == setting.wall else [_turned(way) for way in ways]


def _turned(wire: Wire) -> Wire:
    return Wire(tuple(piece.reversed() for piece in reversed(wire.pieces)), wire.closed)
