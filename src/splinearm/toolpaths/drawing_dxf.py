"""Drawings from DXF files, read by ezdxf.

Lines, arcs, circles, ellipses, polylines with bulges, splines, and blocks of them. Arcs stay arcs,
ellipses become exact NURBS. Texts, dimensions and the like are left out and counted.
Source of the format: Autodesk, "DXF Reference".
"""

import struct
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from math import cos, pi, radians, sin
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.errors import DrawingError

from .drawing import UNITS, Drawing, Sheet, first_line, reading
from .piece import ArcPiece, LinePiece, Piece, SplinePiece
from .shape import bulging_chain, ellipse_piece

if TYPE_CHECKING:
    from ezdxf.document import Drawing as Document
    from ezdxf.entities.dxfgfx import DXFGraphic

_UNIT_CODES = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m", 13: "um"}
"""Units by the file's $INSUNITS."""

_DEEPEST = 32
"""How deep blocks may lie within blocks."""

_MOST_BLOCKS = 20_000
"""So many blocks may be placed in all."""

_FAULTS = (ValueError, ArithmeticError, LookupError, TypeError, AttributeError, struct.error)
"""What a reader of files stumbles over where a file is broken."""

_FLAT = 1e-6
"""Share of the largest coordinate by which a drawing may leave its plane."""

_SPLINE_FRAME = 2 | 4
"""Flags of a polyline to which a curve or a spline was fitted."""


def read_dxf(file: Path, unit: str | None = None) -> Drawing:
    """Read a DXF file.

    Args:
        file: The file.
        unit: The unit of its numbers if it says none; None: mm.

    Raises:
        DrawingError: If it is no DXF file or holds what cannot be drawn in the plane.
        OSError: If it cannot be opened.
    """
    with _blaming(file):
        document = _load(file)
        name = _UNIT_CODES.get(int(document.units))
        sheet = Sheet(str(file), name or unit or "mm")
        off = {layer.dxf.name for layer in document.layers if layer.is_off() or layer.is_frozen()}
        _Reader(sheet, UNITS[sheet.unit], off).read(document.modelspace(), ())
    return sheet.finished()


@contextmanager
def _blaming(file: Path) -> Iterator[None]:
    """Let whatever ezdxf complains of be one error of the drawing, and its notes be none."""
    from logging import CRITICAL, getLogger

    log = getLogger("ezdxf")
    level = log.level
    log.setLevel(CRITICAL)
    try:
        yield
    except OSError as error:
        if error.errno is not None:
            raise
        raise DrawingError(str(file), "", "is no DXF file") from error
    except DrawingError:
        raise
    except RecursionError as error:
        raise DrawingError(str(file), "", "its blocks lie within each other too deep") from error
    except ImportError as error:
        raise DrawingError(
            str(file), "", "reading DXF needs ezdxf: pip install 'splinearm[cad]'"
        ) from error
    except Exception as error:
        if not (type(error).__module__.startswith("ezdxf.") or isinstance(error, _FAULTS)):
            raise
        raise DrawingError(str(file), "", f"is no valid DXF file: {first_line(error)}") from error
    finally:
        log.setLevel(level)


def _load(file: Path) -> "Document":
    """Let ezdxf read a file."""
    from ezdxf.filemanagement import readfile

    _require_end(file)
    return readfile(file)


def _require_end(file: Path) -> None:
    """Refuse a text DXF file that was cut off: what is missing would not be cut."""
    with file.open("rb") as handle:
        if handle.read(18) == b"AutoCAD Binary DXF":
            return
        handle.seek(0, 2)
        handle.seek(max(handle.tell() - 64, 0))
        tail = handle.read()
    if not tail.strip().endswith(b"EOF"):
        raise DrawingError(str(file), "", "is cut off: a DXF file ends with EOF")


class _Reader:
    """Entities of one file on their way to the sheet."""

    def __init__(self, sheet: Sheet, scale: float, hidden: set[str]) -> None:
        self.sheet = sheet
        self.scale = scale
        self.hidden = hidden
        self.placed = 0

    def read(self, entities: "Iterable[DXFGraphic]", blocks: tuple[str, ...]) -> None:
        """Read entities, those of blocks in their places."""
        for entity in entities:
            kind, layer = entity.dxftype(), entity.dxf.get("layer", "0")
            if layer in self.hidden:
                self.sheet.left_out[f"{kind} on a layer that is off"] += 1
            elif kind == "INSERT":
                self._read_block(entity, blocks)
            elif kind in _MAKERS:
                where = f"{kind} #{entity.dxf.handle}" if entity.dxf.handle else kind
                with reading(self.sheet.file, where):
                    for piece in self._pieces(entity, where):
                        self.sheet.add(piece, layer)
            else:
                self.sheet.left_out[kind] += 1

    def _read_block(self, insert: Any, blocks: tuple[str, ...]) -> None:
        name = insert.dxf.name
        if name in blocks or len(blocks) >= _DEEPEST:
            trail = " in ".join(repr(each) for each in (name, *reversed(blocks[-3:])))
            why = "lies within itself" if name in blocks else f"lies more than {_DEEPEST} deep"
            raise DrawingError(self.sheet.file, f"block {name!r}", f"{why}: {trail}")
        if insert.block() is None:
            raise DrawingError(
                self.sheet.file, f"INSERT #{insert.dxf.handle}", f"no block {name!r}"
            )
        self.placed += max(1, insert.mcount)
        if self.placed > _MOST_BLOCKS:
            raise DrawingError(
                self.sheet.file, f"block {name!r}", f"more than {_MOST_BLOCKS} blocks are placed"
            )
        copies = insert.multi_insert() if insert.mcount > 1 else (insert,)
        for copy in copies:
            self.read(copy.virtual_entities(), (*blocks, name))

    def _pieces(self, entity: Any, where: str) -> list[Piece]:
        """Give the pieces of an entity, in m."""
        sheet = _Plane(self.sheet.file, where, entity, self.scale)
        return _MAKERS[entity.dxftype()](entity, sheet)


class _Plane:
    """The plane in which one entity is drawn, and how it lies in the drawing."""

    def __init__(self, file: str, where: str, entity: Any, scale: float) -> None:
        self._file, self._where, self._scale = file, where, scale
        self._ocs = entity.ocs() if entity.dxftype() in _OWN_PLANE else None
        self.handed = 1.0
        """-1 where the entity is drawn on the back of the plane: left is right there."""
        if self._ocs is not None and self._ocs.transform:
            up = self._ocs.uz.z
            if abs(abs(up) - 1.0) > _FLAT:
                raise self._error("stands on the drawing at a slant; draw it flat")
            self.handed = 1.0 if up > 0.0 else -1.0

    def places(self, points: Iterable[Any]) -> FloatArray:
        """Give points of the entity in the plane of the drawing, shape (m, 2), m."""
        given = [(*p, 0.0)[:3] for p in points]
        if self._ocs is not None:
            given = [tuple(p) for p in self._ocs.points_to_wcs(given)]
        array = np.array(given, dtype=np.float64)
        if not np.isfinite(array).all():
            raise self._error("a coordinate is not a finite number")
        if np.ptp(array[:, 2]) > _FLAT * np.abs(array).max():
            x, y, z = array[int(np.argmax(np.abs(array[:, 2] - array[0, 2])))]
            raise self._error(f"leaves its plane at ({x:g}, {y:g}, {z:g}); draw it flat")
        flat: FloatArray = array[:, :2] * self._scale
        return flat

    def _error(self, reason: str) -> DrawingError:
        return DrawingError(self._file, self._where, reason)


def _line(entity: Any, plane: _Plane) -> list[Piece]:
    start, end = plane.places((entity.dxf.start, entity.dxf.end))
    return [LinePiece(start, end)]


def _arc(entity: Any, plane: _Plane) -> list[Piece]:
    first = radians(entity.dxf.start_angle)
    turn = radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360.0) or 2.0 * pi
    return [_round(entity, plane, first, turn)]


def _circle(entity: Any, plane: _Plane) -> list[Piece]:
    return [_round(entity, plane, 0.0, 2.0 * pi)]


def _round(entity: Any, plane: _Plane, first: float, turn: float) -> Piece:
    """Give the arc of an entity that has a centre and a radius."""
    middle, radius = entity.dxf.center, entity.dxf.radius
    if not radius > 0.0:
        raise ValueError(f"its radius is {radius:g}")
    rim = [
        (middle.x + radius * cos(v), middle.y + radius * sin(v), middle.z)
        for v in (first, first + turn)
    ]
    centre, start, end = plane.places((middle, *rim))
    if turn >= 2.0 * pi:
        end = start
    return ArcPiece(start=start, end=end, centre=centre, turn=turn * plane.handed)


def _ellipse(entity: Any, plane: _Plane) -> list[Piece]:
    centre, major = entity.dxf.center, entity.dxf.major_axis
    minor = entity.minor_axis
    first, last = entity.dxf.start_param, entity.dxf.end_param
    turn = (last - first) % (2.0 * pi) or 2.0 * pi
    o, a, b = plane.places((centre, centre + major, centre + minor))
    return [ellipse_piece(o, a - o, b - o, first, turn)]


def _light_polyline(entity: Any, plane: _Plane) -> list[Piece]:
    rows = list(entity.get_points("xyb"))
    height = float(entity.dxf.elevation)
    places = plane.places([(x, y, height) for x, y, _ in rows])
    return bulging_chain(places, [b * plane.handed for *_, b in rows], closed=bool(entity.closed))


def _polyline(entity: Any, plane: _Plane) -> list[Piece]:
    if not (entity.is_2d_polyline or entity.is_3d_polyline):
        raise ValueError("is a mesh; draw its outline")
    if entity.dxf.flags & _SPLINE_FRAME:
        raise ValueError("is an old polyline with a curve fitted to it; explode it or redraw it")
    vertices = list(entity.vertices)
    places = plane.places([vertex.dxf.location for vertex in vertices])
    bulges = [float(vertex.dxf.get("bulge", 0.0)) * plane.handed for vertex in vertices]
    return bulging_chain(places, bulges, closed=bool(entity.is_closed))


def _spline(entity: Any, plane: _Plane) -> list[Piece]:
    if len(entity.control_points) == 0:
        return [_through(plane.places(entity.fit_points), closed=bool(entity.closed))]
    points = plane.places(entity.control_points)
    weights = np.array(entity.weights, dtype=np.float64) if len(entity.weights) else None
    return [SplinePiece(BSpline(np.array(entity.knots), points, int(entity.dxf.degree), weights))]


def _through(points: FloatArray, *, closed: bool) -> Piece:
    """Give the cubic through points, as programs draw a spline that says nothing else."""
    if closed and (points[0] == points[-1]).all():
        points = points[:-1]
    return SplinePiece(interpolate(points, ends="closed" if closed else "natural"))


_Maker = Callable[[Any, _Plane], list[Piece]]
_MAKERS: dict[str, _Maker] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _light_polyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
}

_OWN_PLANE = frozenset(("ARC", "CIRCLE", "LWPOLYLINE", "POLYLINE"))
"""Entities whose places are given in a plane of their own."""
