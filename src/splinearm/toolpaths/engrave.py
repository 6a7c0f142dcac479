"""Engraving: the cutter's middle on the line."""

from collections.abc import Sequence

import numpy as np

from .action import ArcFeed, Feed
from .mill import Mill
from .operation import Milled, Milling
from .order import shortest_order
from .piece import ArcPiece, LinePiece, Piece
from .wire import Wire


def engrave(wires: Sequence[Wire], setting: Milling) -> Milled:
    """Cut along wires, each to its full depth, by the shortest travel.

    Open wires are run through from either end; splines stay splines.

    Args:
        wires: The wires.
        setting: The cutter and how it is used; it comes straight down.

    Raises:
        ValueError: If there are no wires.
    """
    if not wires:
        raise ValueError("wires: want at least one")
    mill = Mill(setting)
    starts = np.array([wire.pieces[0].start for wire in wires])
    ends = np.array([wire.pieces[-1].end for wire in wires])
    for i, backwards in shortest_order(starts, ends, turnable=[not w.closed for w in wires]):
        forward = list(wires[i].pieces)
        reverse = [piece.reversed() for piece in reversed(forward)]
        pieces = reverse if backwards else forward
        surface = setting.top
        mill.above(np.asarray(pieces[0].start))
        for z in setting.levels:
            mill.down_to(surface)
            mill.drop(z)
            for piece in pieces:
                _follow(mill, piece, z)
            surface = z
            if not wires[i].closed:  # an open one is cut to and fro
                pieces = reverse if pieces is forward else forward
    return mill.milled()


def _follow(mill: Mill, piece: Piece, z: float) -> None:
    """Cut along a piece, level."""
    feed, blend = mill.setting.cutter.feed, mill.setting.blend
    start = mill.known
    end = np.array([*piece.end, z])
    match piece:
        case LinePiece():
            mill.actions.append(Feed(start=start, end=end, feed=feed, blend=blend))
        case ArcPiece():
            centre = np.array([*piece.centre, z])
            mill.actions.append(
                ArcFeed(
                    start=start,
                    end=end,
                    feed=feed,
                    blend=blend,
                    centre=centre,
                    axis=2,
                    turn=piece.turn,
                )
            )
        case _:
            mill.spline(piece.curve, z, feed)
            return
    mill.place = end
