"""A drawing: pieces in the plane, the layer of each, and what was left out when it was read."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import DrawingError

from .piece import ArcPiece, LinePiece, Piece, SplinePiece

_LARGEST = 1e5
"""A drawing may be that large, m: beyond it somebody is wrong about its unit or its numbers."""

_POINT = 1e-12
"""A piece shorter than this share of the drawing's size is a point."""

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048, "um": 1e-6}
"""Units that a drawing may be in, m."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A piece of a drawing."""

    piece: Piece
    """The piece, in m."""
    layer: str
    """The layer or group it is on; "" if none is named."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Drawing:
    """What a drawing file holds."""

    file: str
    """Where it was read."""
    unit: str
    """The unit that the file is in."""
    drawn: tuple[Drawn, ...]
    """Its pieces, in m, in the order of the file."""
    left_out: dict[str, int]
    """What the file holds besides and is not cut, such as texts, and how many of each."""

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """Every piece."""
        return tuple(each.piece for each in self.drawn)

    @property
    def layers(self) -> tuple[str, ...]:
        """The names of its layers, in the order of the file."""
        return tuple(dict.fromkeys(each.layer for each in self.drawn))

    def on_layers(self, *layers: str) -> "Drawing":
        """Give what is on some layers only.

        Raises:
            DrawingError: If there is no such layer; its message lists those there are.
        """
        unknown = [name for name in layers if name not in self.layers]
        if unknown:
            there = ", ".join(repr(name) for name in self.layers)
            raise DrawingError(
                self.file, f"layer {unknown[0]!r}", f"is not there; there are {there}"
            )
        kept = tuple(each for each in self.drawn if each.layer in layers)
        return Drawing(file=self.file, unit=self.unit, drawn=kept, left_out=self.left_out)


@dataclass(slots=True)
class Sheet:
    """A drawing while it is read."""

    file: str
    """Where it is read."""
    unit: str
    """The unit that the file is in."""
    drawn: list[Drawn] = field(default_factory=list)
    """Pieces so far."""
    left_out: Counter[str] = field(default_factory=Counter)
    """What was left out so far."""

    def add(self, piece: Piece, layer: str) -> None:
        """Keep a piece."""
        self.drawn.append(Drawn(piece, layer))

    def finished(self) -> Drawing:
        """Give the drawing, without pieces that have no length.

        Raises:
            DrawingError: If nothing is drawn in it.
        """
        size = _size([each.piece for each in self.drawn])
        if not size <= _LARGEST:
            raise DrawingError(self.file, "", f"is {size:.3g} m large: look at its unit")
        kept = tuple(each for each in self.drawn if each.piece.length > _POINT * size)
        points = len(self.drawn) - len(kept)
        left_out = dict(self.left_out) | ({"point": points} if points else {})
        if not kept:
            found = ", ".join(f"{count} {name}" for name, count in left_out.items()) or "nothing"
            raise DrawingError(
                self.file, "", f"nothing in it can be cut: it holds {found}; draw lines or curves"
            )
        return Drawing(file=self.file, unit=self.unit, drawn=kept, left_out=left_out)


def read_drawing(file: str | PathLike[str], unit: str | None = None) -> Drawing:
    """Read a DXF or SVG file.

    Args:
        file: The file, by its ending a DXF or an SVG.
        unit: The unit of its numbers where it says none; None: mm for DXF, 1/96 inch for SVG.

    Raises:
        DrawingError: If it cannot be read; it says where.
        ValueError: If there is no such unit.
    """
    from .drawing_dxf import read_dxf
    from .drawing_svg import read_svg

    if unit is not None and unit not in UNITS:
        raise ValueError(f"unit: want one of {', '.join(UNITS)}, got {unit!r}")
    readers: dict[str, Callable[[Path, str | None], Drawing]] = {
        ".dxf": read_dxf,
        ".svg": read_svg,
    }
    path = Path(file)
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise DrawingError(str(file), "", f"want a file ending in {' or '.join(readers)}")
    try:
        return reader(path, unit)
    except FileNotFoundError as error:
        raise DrawingError(str(file), "", "there is no such file") from error
    except OSError as error:
        raise DrawingError(str(file), "", error.strerror or str(error)) from error


@contextmanager
def reading(file: str, where: str) -> Iterator[None]:
    """Turn what a curve that cannot be made complains of into an error of the drawing."""
    try:
        yield
    except (ValueError, ArithmeticError, LookupError, TypeError, AttributeError) as error:
        raise DrawingError(file, where, first_line(error)) from error


def first_line(error: Exception) -> str:
    """Give what an error says, in one line that is not long."""
    return (str(error).splitlines() or [type(error).__name__])[0][:200]


def _size(pieces: list[Piece]) -> float:
    """Give how far the places of pieces are from each other at the most, m."""
    places: list[FloatArray] = []
    for piece in pieces:
        match piece:
            case LinePiece():
                places += [piece.start, piece.end]
            case ArcPiece():
                places += [piece.centre - piece.radius, piece.centre + piece.radius]
            case SplinePiece():
                places += list(piece.curve.points)
    return float(np.ptp(places, axis=0).max()) if places else 0.0
