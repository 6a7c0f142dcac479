"""Wires: pieces of a drawing end to end, lines, arcs and splines, measured as they are drawn."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import sin

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.box import bounding_box
from splinearm.curves.bspline import BSpline
from splinearm.curves.cell import halves
from splinearm.curves.conic import elliptic_arc
from splinearm.curves.projection import nearest_point

from .piece import ArcPiece, LinePiece, Piece, SplinePiece, is_full_circle

_HALVINGS = 60
_RELIABLE = 1e-14
_MOST_PARTS = 1 << 10
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True, slots=True, eq=False)
class Wire:
    """Pieces one after the other, each beginning exactly where the one before it ends."""

    pieces: tuple[Piece, ...]
    """The pieces."""
    closed: bool
    """Whether the last ends where the first begins."""

    @property
    def length(self) -> float:
        """How long it is, m."""
        return sum(piece.length for piece in self.pieces)

    @property
    def area(self) -> float:
        """What it encloses, m2; above 0 if it runs counterclockwise.

        Of splines that are no NURBS exact but for rounding, of NURBS to 14 digits.

        Raises:
            ValueError: If it is open.
        """
        self._require_closed("area")
        origin = self.pieces[0].start
        return sum(_swept(piece, origin) for piece in self.pieces)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least x and y, largest x and y, m."""
        boxes = np.array([_box(piece) for piece in self.pieces])
        low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def contains(self, points: ArrayInput) -> npt.NDArray[np.bool_]:
        """Say which points it goes around.

        Args:
            points: Places, shape (m, 2), m; those on the wire itself may be said to be either.

        Raises:
            ValueError: If it is open.
        """
        self._require_closed("contains")
        rows = [_homogeneous(curve) for curve in self._curves()]
        places = frozen_array(points, (None, 2), "points")
        turns = np.array([sum(_turn(pieces, p) for pieces in rows) for p in places])
        inside: npt.NDArray[np.bool_] = np.abs(turns) > np.pi
        return inside

    def distance(self, points: ArrayInput) -> FloatArray:
        """Give how far points are from the nearest place of it, shape (m,), m.

        Args:
            points: Places, shape (m, 2), m.
        """
        places = frozen_array(points, (None, 2), "points")
        found = np.full(len(places), np.inf)
        for curve in self._curves():
            found = np.minimum(found, nearest_point(curve, places).distance)
        return found

    def reversed(self) -> "Wire":
        """Give it from its end to its start."""
        return Wire(tuple(piece.reversed() for piece in reversed(self.pieces)), self.closed)

    def _curves(self) -> Iterator[BSpline]:
        return map(curve_of, self.pieces)

    def _require_closed(self, name: str) -> None:
        if not self.closed:
            raise ValueError(f"{name}: want a closed wire, got an open one")


def curve_of(piece: Piece) -> BSpline:
    """Give a piece as a spline with exactly its ends: an arc as the NURBS that it is."""
    if isinstance(piece, SplinePiece):
        return piece.curve
    if isinstance(piece, LinePiece):
        return BSpline(np.repeat([0.0, 1.0], 2), np.array([piece.start, piece.end]), 1)
    arm = piece.start - piece.centre
    first = float(np.arctan2(arm[1], arm[0]))
    arc = elliptic_arc((piece.radius, piece.radius), first, first + piece.turn)
    points = arc.points + piece.centre
    points[0], points[-1] = piece.start, piece.end
    return BSpline(arc.knots, points, arc.degree, arc.weights)


def _swept(piece: Piece, origin: FloatArray) -> float:
    """Give what the way from an origin to a piece sweeps: half of the integral of x dy - y dx."""
    (x0, y0), (x1, y1) = piece.start - origin, piece.end - origin
    chord = 0.5 * float(x0 * y1 - x1 * y0)
    if isinstance(piece, LinePiece):
        return chord
    if isinstance(piece, ArcPiece):
        turn = np.copysign(2.0 * np.pi, piece.turn) if is_full_circle(piece) else piece.turn
        return chord + 0.5 * piece.radius**2 * (turn - sin(turn))
    curve, start = piece.curve, piece.start

    def rate(u: FloatArray) -> FloatArray:
        # about its own start, so that little is lost where it is far from the origin
        place, slope = curve.at(u) - start, curve.at(u, 1)
        swept: FloatArray = 0.5 * (place[:, 0] * slope[:, 1] - place[:, 1] * slope[:, 0])
        return swept

    about_start = _integral(rate, curve.breaks)
    return about_start + chord


def _integral(rate: Callable[[FloatArray], FloatArray], breaks: FloatArray) -> float:
    """Integrate by Gauss and Legendre, in more and more parts until nothing changes."""
    parts, before = 1, np.inf
    while True:
        shares = np.linspace(0.0, 1.0, parts + 1)
        edges = np.unique(breaks[:-1, None] + np.diff(breaks)[:, None] * shares)
        half = 0.5 * np.diff(edges)[:, None]
        values = rate((edges[:-1, None] + half * (1.0 + _NODES)).ravel()).reshape(len(half), -1)
        terms = half * _WEIGHTS * values
        total, size = float(terms.sum()), float(np.abs(terms).sum())
        if abs(total - before) <= _RELIABLE * size or parts >= _MOST_PARTS:
            return total
        parts, before = 2 * parts, total


def _box(piece: Piece) -> tuple[FloatArray, FloatArray]:
    if isinstance(piece, LinePiece):
        return np.minimum(piece.start, piece.end), np.maximum(piece.start, piece.end)
    return bounding_box(curve_of(piece))


def _homogeneous(curve: BSpline) -> FloatArray:
    """Give Bezier pieces, shape (k, degree + 1, 3)."""
    _, pieces = curve.bezier()
    if curve.is_rational:
        return pieces
    return np.concatenate((pieces, np.ones((*pieces.shape[:2], 1))), axis=2)


def _turn(pieces: FloatArray, point: FloatArray) -> float:
    """Give by what angle pieces go around a point, rad.

    A piece whose control points all lie on one side of the point goes around it as its chord does;
    others are halved until they do.
    """
    total = 0.0
    for _ in range(_HALVINGS):
        places = pieces[..., :2] / pieces[..., 2:] - point
        clear = ((places.min(axis=1) > 0.0) | (places.max(axis=1) < 0.0)).any(axis=1)
        total += float(_angles(places[clear, 0], places[clear, -1]).sum())
        pieces = np.concatenate(halves(pieces[~clear]))
        if not len(pieces):
            break
    return total


def _angles(a: FloatArray, b: FloatArray) -> FloatArray:
    angles: FloatArray = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
    return angles
