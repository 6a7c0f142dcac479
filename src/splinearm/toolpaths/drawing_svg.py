"""Drawings from SVG files, read by svgelements.

Paths with lines, arcs, quadratic and cubic Beziers, and the basic shapes, under their transforms.
The drawing is turned over so that y grows upwards, with 0 at the lower edge of the page. Texts and
images are left out and counted.
Source of the format: W3C, "Scalable Vector Graphics (SVG) 1.1", units in CSS px of 1/96 inch.
"""

from collections.abc import Callable, Iterator
from io import BytesIO
from math import atan2, isfinite, nan, pi
from pathlib import Path
from re import fullmatch
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.errors import DrawingError

from .drawing import UNITS, Drawing, Sheet, first_line, reading
from .piece import LinePiece, Piece, SplinePiece
from .shape import ellipse_piece

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

_PX = 0.0254 / 96.0
_LENGTHS = {"": _PX, "px": _PX, "pt": 0.0254 / 72.0, "pc": 0.0254 / 6.0, "mm": 1e-3, "cm": 1e-2}
_LENGTHS |= {"in": 0.0254, "Q": 0.25e-3}
_LONGEST_STYLE = 20_000
_MOST_ELEMENTS = 200_000
_NOT_DRAWN = ("text", "image", "foreignObject")


def read_svg(file: Path, unit: str | None = None) -> Drawing:
    """Read an SVG file.

    Args:
        file: The file.
        unit: What a px is, where the page's size is given in none; None: 1/96 inch.

    Raises:
        DrawingError: If it is no SVG file or a path in it is broken.
        OSError: If it cannot be opened.
    """
    try:
        import svgelements
    except ImportError as error:
        raise DrawingError(
            str(file), "", "reading SVG needs svgelements: pip install 'splinearm[cad]'"
        ) from error

    root = _root(file)
    _require_small(root, str(file))
    px = _PX if unit is None else UNITS[unit]
    width, height = _page(root, px, str(file))
    # svgelements rounds millimetres to seven digits: it gets a page of plain numbers
    root.set("width", repr(width / px))
    root.set("height", repr(height / px))
    sheet = Sheet(str(file), unit or "px")
    for name in _NOT_DRAWN:
        count = sum(1 for element in root.iter() if element.tag.rpartition("}")[2] == name)
        if count:
            sheet.left_out[name] = count
    try:
        page = svgelements.SVG.parse(BytesIO(ElementTree.tostring(root)), on_error="raise")
        shapes = [each for each in page.elements() if isinstance(each, svgelements.Shape)]
    except RecursionError as error:
        raise DrawingError(str(file), "", "its groups lie within each other too deep") from error
    except (ValueError, ArithmeticError, LookupError, TypeError, AttributeError) as error:
        reason = f"is no valid SVG file: {first_line(error)}"
        raise DrawingError(str(file), "", reason) from error
    flip = np.array([[px, 0.0, 0.0], [0.0, -px, height]])
    for shape in shapes:
        name = str(shape.id or type(shape).__name__.lower())
        with reading(str(file), name):
            for piece in _pieces(abs(svgelements.Path(shape)), flip):
                sheet.add(piece, _layer(shape))
    return sheet.finished()


def _root(file: Path) -> "Element":
    try:
        # the parser that Python comes with (expat 2.4.1 and later) refuses exploding entities
        root = ElementTree.fromstring(file.read_bytes())  # noqa: S314
    except ElementTree.ParseError as error:
        line, column = error.position
        raise DrawingError(
            str(file), f"line {line}, column {column + 1}", f"is no valid SVG file: {error.msg}"
        ) from error
    except RecursionError as error:
        raise DrawingError(str(file), "", "its groups lie within each other too deep") from error
    if root.tag.rpartition("}")[2] != "svg":
        raise DrawingError(str(file), "", f"is no SVG file: it begins with <{root.tag}>")
    return root


def _require_small(root: "Element", file: str) -> None:
    """Refuse a file that says little and means more than can be drawn."""
    styles = sum(len(e.text or "") for e in root.iter() if e.tag.rpartition("}")[2] == "style")
    if styles > _LONGEST_STYLE:
        raise DrawingError(file, "style", f"is {styles} characters long; at most {_LONGEST_STYLE}")
    named = {element.get("id"): element for element in root.iter() if element.get("id")}
    counts = dict[int, int]()

    def count(element: "Element", trail: frozenset[int]) -> int:
        key = id(element)
        if key in trail:
            name = element.get("id") or element.tag
            raise DrawingError(file, f"#{name}", "is used within itself")
        if key not in counts:
            inner = list(element)
            link = element.get("{http://www.w3.org/1999/xlink}href") or element.get("href") or ""
            if element.tag.rpartition("}")[2] == "use" and link[1:] in named:
                inner.append(named[link[1:]])
            counts[key] = 1 + sum(count(each, trail | {key}) for each in inner)
        return counts[key]

    try:
        total = count(root, frozenset())
    except RecursionError as error:
        raise DrawingError(file, "", "its groups lie within each other too deep") from error
    if total > _MOST_ELEMENTS:
        raise DrawingError(file, "", f"it means {total} elements; at most {_MOST_ELEMENTS}")


def _page(root: "Element", px: float, file: str) -> tuple[float, float]:
    """Give width and height of the page, m."""
    given = root.get("viewBox", "")
    try:
        box = [float(number) for number in given.replace(",", " ").split()]
    except ValueError:
        box = [nan]
    if box and (len(box) != 4 or not all(map(isfinite, box)) or min(box[2:]) <= 0.0):
        raise DrawingError(file, "viewBox", f"want x, y, width and height, got {given[:40]!r}")
    sizes = []
    for i, name in enumerate(("width", "height")):
        given = root.get(name, "100%").strip()
        if given.endswith("%"):
            given = str(box[2 + i]) if box else "0"
        match = fullmatch(r"([-+0-9.eE]+?)\s*([a-zA-Z]*)", given)
        if match is None or match[2] not in _LENGTHS:
            raise DrawingError(file, name, f"want a length such as 120mm, got {given[:40]!r}")
        per = _LENGTHS[match[2]] if match[2] not in ("", "px") else px
        sizes.append(float(match[1]) * per)
    return sizes[0], sizes[1]


def _layer(shape: Any) -> str:
    """Give the name of the layer or group that a shape is in."""
    values = shape.values
    for key in ("{http://www.inkscape.org/namespaces/inkscape}label", "class"):
        if values.get(key):
            return str(values[key])
    return ""


def _pieces(path: Any, flip: FloatArray) -> Iterator[Piece]:
    """Give the pieces of a path, turned over and in m."""
    from svgelements import Arc, Close, CubicBezier, Line, Move, QuadraticBezier

    def place(point: Any) -> FloatArray:
        x, y = float(point.x), float(point.y)
        if not (isfinite(x) and isfinite(y)):
            raise ValueError(f"a coordinate is not a finite number: ({x}, {y})")
        placed: FloatArray = flip[:, :2] @ np.array([x, y]) + flip[:, 2]
        return placed

    for segment in path:
        match segment:
            case Move():
                continue
            case Line() | Close():
                if segment.start is None or segment.end is None or segment.start == segment.end:
                    continue
                yield LinePiece(place(segment.start), place(segment.end))
            case QuadraticBezier():
                yield _bezier([place(p) for p in (segment.start, segment.control, segment.end)])
            case CubicBezier():
                points = (segment.start, segment.control1, segment.control2, segment.end)
                yield _bezier([place(p) for p in points])
            case Arc():
                yield _elliptic(segment, place)


def _bezier(points: list[FloatArray]) -> Piece:
    """Give the Bezier curve of control points."""
    degree = len(points) - 1
    knots = np.repeat((0.0, 1.0), degree + 1)
    return SplinePiece(BSpline(knots, np.array(points), degree))


def _elliptic(arc: Any, place: Callable[[Any], FloatArray]) -> Piece:
    """Give the arc ``centre + a cos v + b sin v`` of an ellipse."""
    centre = place(arc.center)
    a, b = place(arc.prx) - centre, place(arc.pry) - centre
    axes = np.column_stack((a, b))
    across, along = np.linalg.solve(axes, place(arc.start) - centre)
    # sweep counts from x to y of the page; turned over, x to y is the other way about
    turn = -float(arc.sweep) if np.linalg.det(axes) > 0.0 else float(arc.sweep)
    return ellipse_piece(centre, a, b, atan2(along, across), max(min(turn, 2.0 * pi), -2.0 * pi))
