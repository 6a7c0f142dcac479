"""Contours: lines and arcs one after the other in the plane."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import cos, pi, sin, tan
from typing import Self

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from .piece import ArcPiece, LinePiece

_SMALL_TURN = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """Lines and arcs, each beginning where the one before it ends, closed or open.

    Kept as corners and bulges, as DXF has them: neighbours share their corner, so that no gap can
    arise; a line is the arc whose bulge is 0, and one that is nearly straight keeps all its digits,
    which a centre far away would cost; and turning, shifting or scaling leaves the bulges alone.
    """

    vertices: FloatArray
    """Where the segments begin and, of an open one, where the last ends, shape (m, 2), m."""
    bulges: FloatArray
    """Of each segment the tangent of a quarter of its turn, above 0 to the left, 0 for a line,
    shape (m,), of an open one (m - 1,). A full circle has two segments."""
    closed: bool = True
    """Whether the last segment leads back to the first vertex."""

    def __post_init__(self) -> None:
        vertices = frozen_array(self.vertices, (None, 2), "vertices")
        bulges = frozen_array(self.bulges, (None,), "bulges")
        if len(vertices) < 2:
            raise ValueError(f"vertices: want at least 2, got {len(vertices)}")
        wanted = len(vertices) - (0 if self.closed else 1)
        if len(bulges) != wanted:
            raise ValueError(f"bulges: want {wanted}, one a segment, got {len(bulges)}")
        if not np.ptp(vertices, axis=0).any():
            raise ValueError(f"vertices: all of them are {vertices[0].tolist()}")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "bulges", bulges)

    @classmethod
    def made(cls, vertices: FloatArray, bulges: FloatArray, *, closed: bool = True) -> Self:
        """Give a contour of arrays that nobody else has; they are neither checked nor copied."""
        contour = object.__new__(cls)
        vertices.flags.writeable = False
        bulges.flags.writeable = False
        object.__setattr__(contour, "vertices", vertices)
        object.__setattr__(contour, "bulges", bulges)
        object.__setattr__(contour, "closed", closed)
        return contour

    @classmethod
    def polyline(cls, points: ArrayInput, *, closed: bool = True) -> Self:
        """Give straight lines from point to point, shape (m, 2), m."""
        vertices = frozen_array(points, (None, 2), "points")
        return cls(vertices, np.zeros(max(0, len(vertices) - (0 if closed else 1))), closed)

    @classmethod
    def circle(cls, centre: ArrayInput, radius: float, *, clockwise: bool = False) -> Self:
        """Give a full circle, of two halves, m.

        Raises:
            ValueError: If the radius is not above 0.
        """
        x, y = frozen_array(centre, (2,), "centre").tolist()
        if not radius > 0.0:
            raise ValueError(f"radius: want a length above zero, got {radius}")
        bulge = -1.0 if clockwise else 1.0
        return cls(np.array([[x - radius, y], [x + radius, y]]), np.array([bulge, bulge]))

    @classmethod
    def rectangle(cls, corner: ArrayInput, size: ArrayInput, radius: float = 0.0) -> Self:
        """Give a rectangle along the axes, to the left.

        Args:
            corner: The corner of least x and y, shape (2,), m.
            size: Width and height, shape (2,), m.
            radius: Radius of its rounded corners, m; 0: sharp ones.

        Raises:
            ValueError: If a size is not above 0, or the radius is not from 0 to half of one.
        """
        x, y = frozen_array(corner, (2,), "corner").tolist()
        w, h = frozen_array(size, (2,), "size").tolist()
        if not (w > 0.0 and h > 0.0):
            raise ValueError(f"size: want lengths above zero, got {[w, h]}")
        if not 0.0 <= radius <= 0.5 * min(w, h):
            raise ValueError(f"radius: want 0 to {0.5 * min(w, h)}, half the size, got {radius}")
        if radius == 0.0:
            return cls.polyline([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
        r = radius
        corners = [
            [x + r, y],
            [x + w - r, y],
            [x + w, y + r],
            [x + w, y + h - r],
            [x + w - r, y + h],
            [x + r, y + h],
            [x, y + h - r],
            [x, y + r],
        ]
        # where the radius is half a side, no line is left between two corners
        whole = [k % 2 == 1 or (w, h)[k // 2 % 2] > 2.0 * r for k in range(8)]
        quarter = tan(pi / 8.0)
        bulges = [quarter if k % 2 else 0.0 for k in range(8)]
        kept = [k for k in range(8) if whole[k]]
        return cls(np.array(corners)[kept], np.array(bulges)[kept])

    @classmethod
    def of_pieces(
        cls, pieces: Sequence[LinePiece | ArcPiece], *, closed: bool | None = None
    ) -> Self:
        """Give the contour of lines and arcs, each of which begins where the one before it ends.

        Args:
            pieces: The pieces; ends that differ by rounding become the end of the earlier piece.
            closed: Whether it is closed; None: if the last ends where the first begins.

        Raises:
            ValueError: If there are no pieces, or two of them leave a gap.
        """
        if not pieces:
            raise ValueError("pieces: want at least one")
        corners: list[FloatArray] = []
        bulges: list[float] = []
        for piece in pieces:
            corners.append(piece.start)
            if isinstance(piece, LinePiece):
                bulges.append(0.0)
                continue
            parts = 1 if abs(piece.turn) <= pi * (1.0 + 1e-9) else 2
            bulges += [tan(0.25 * piece.turn / parts)] * parts
            if parts == 2:
                corners.append(piece.middle)
        ends = [piece.end for piece in pieces]
        extent = float(np.ptp(np.array(corners + ends), axis=0).max())
        for k, (end, piece) in enumerate(zip(ends, pieces[1:], strict=False)):
            gap = float(np.abs(end - piece.start).max())
            if gap > 1e-9 * extent:
                raise ValueError(
                    f"pieces: number {k + 1} begins {gap:.6g} m from the end of the one before it, "
                    f"at {piece.start.tolist()}"
                )
        meets = float(np.abs(ends[-1] - corners[0]).max()) <= 1e-9 * extent
        if closed is None:
            closed = meets
        if closed and not meets:
            raise ValueError(
                f"pieces: the last ends at {ends[-1].tolist()}, not where the first begins"
            )
        if not closed:
            corners.append(ends[-1])
        return cls(np.array(corners), np.array(bulges), closed)

    @property
    def ends(self) -> FloatArray:
        """Where the segments end, shape (segments, 2), m."""
        return np.roll(self.vertices, -1, axis=0) if self.closed else self.vertices[1:]

    @property
    def starts(self) -> FloatArray:
        """Where the segments begin, shape (segments, 2), m."""
        return self.vertices if self.closed else self.vertices[:-1]

    @property
    def turns(self) -> FloatArray:
        """How far the segments turn, rad, above 0 to the left, shape (segments,)."""
        turned: FloatArray = 4.0 * np.arctan(self.bulges)
        return turned

    @property
    def lengths(self) -> FloatArray:
        """How long the segments are, m, shape (segments,)."""
        way = self.ends - self.starts
        # (turn / 2) / sin(turn / 2) of the chord
        half = 2.0 * np.arctan(self.bulges)
        grown = np.where(np.abs(half) > 1e-8, half / np.where(half == 0.0, 1.0, np.sin(half)), 1.0)
        lengths: FloatArray = np.hypot(way[:, 0], way[:, 1]) * grown
        return lengths

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(self.lengths.sum())

    @property
    def area(self) -> float:
        """The area it goes around, to the left positive, m2.

        Raises:
            ValueError: If it is open.
        """
        if not self.closed:
            raise ValueError("area: an open contour has none; close it first")
        start = self.vertices - self.vertices[0]
        end, turn = np.roll(start, -1, axis=0), self.turns
        cross = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
        chord2 = ((end - start) ** 2).sum(axis=1)
        # the segment of a circle over a chord c: c^2 (t - sin t) / (8 sin^2(t / 2))
        small = np.abs(turn) < _SMALL_TURN
        t = np.where(small, 1.0, turn)
        share = np.where(
            small,
            turn / 12.0 * (1.0 + turn**2 / 30.0),
            (t - np.sin(t)) / (8.0 * np.sin(0.5 * t) ** 2),
        )
        return float((0.5 * cross + share * chord2).sum())

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least x and y, largest x and y, m."""
        P = self.packed()[0]
        ends = np.concatenate((P[:, :2], P[:, 2:4]))
        low, high = ends.min(axis=0), ends.max(axis=0)
        # an arc of at most a quarter turn is farthest out where its normal lies along an axis
        for axis in (0, 1):
            other = 6 - axis  # the tangent's share along the axis, but for its sign
            bends = (P[:, other] * P[:, other + 2] < 0.0) & (P[:, 4] != 0.0)
            if bends.any():
                arcs = P[bends]
                centre = arcs[:, axis] + arcs[:, 5 + axis] / arcs[:, 4]
                radius = 1.0 / np.abs(arcs[:, 4])
                # the chord's middle lies to the side to which the arc reaches
                middle = 0.5 * (arcs[:, axis] + arcs[:, axis + 2])
                low[axis] = min(low[axis], (centre - radius)[middle < centre].min(initial=np.inf))
                high[axis] = max(
                    high[axis], (centre + radius)[middle >= centre].max(initial=-np.inf)
                )
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def contains(self, points: ArrayInput) -> npt.NDArray[np.bool_]:
        """Say which points it goes around, shape (...) of booleans.

        Args:
            points: Points, shape (..., 2), m.

        Raises:
            ValueError: If it is open.
        """
        if not self.closed:
            raise ValueError("contains: an open contour goes around nothing; close it first")
        from .contour_kernel import windings

        flat, shape = _points(points)
        found = np.empty(len(flat))
        windings(self.packed()[0], flat, found)
        inside: npt.NDArray[np.bool_] = (found != 0.0).reshape(shape)
        return inside

    def distance(self, points: ArrayInput) -> FloatArray:
        """Give how far points are from it, m, shape (...).

        Args:
            points: Points, shape (..., 2), m.
        """
        from .contour_kernel import distances

        flat, shape = _points(points)
        found = np.empty(len(flat))
        distances(self.packed()[0], flat, found)
        return found.reshape(shape)

    def reversed(self) -> Self:
        """Give it run through the other way."""
        if self.closed:
            return self.made(np.roll(self.vertices, -1, axis=0)[::-1].copy(), -self.bulges[::-1])
        return self.made(self.vertices[::-1].copy(), -self.bulges[::-1], closed=False)

    def transformed(
        self,
        *,
        scale: float = 1.0,
        angle: float = 0.0,
        shift: ArrayInput = (0.0, 0.0),
        mirrored: bool = False,
    ) -> Self:
        """Give it mirrored, scaled, turned and shifted, in that order.

        Args:
            scale: By what it becomes larger, above 0.
            angle: By how much it is turned about the origin, rad.
            shift: By how much it is shifted at last, shape (2,), m.
            mirrored: Whether it is mirrored in the x axis first; it then turns the other way.

        Raises:
            ValueError: If the scale is not above 0.
        """
        if not scale > 0.0:
            raise ValueError(f"scale: want a number above zero, got {scale}")
        c, s = scale * cos(angle), scale * sin(angle)
        sign = -1.0 if mirrored else 1.0
        turn = np.array([[c, s], [-sign * s, sign * c]])
        moved = self.vertices @ turn + frozen_array(shift, (2,), "shift")
        return type(self)(moved, sign * self.bulges, self.closed)

    def starting_at(self, vertex: int) -> Self:
        """Give the closed contour begun at another of its vertices.

        Raises:
            ValueError: If it is open.
        """
        if not self.closed:
            raise ValueError("starting_at: an open contour begins where it begins")
        return self.made(np.roll(self.vertices, -vertex, axis=0), np.roll(self.bulges, -vertex))

    def pieces(self) -> tuple[LinePiece | ArcPiece, ...]:
        """Give its segments as lines and arcs; segments without length are left out."""
        found: list[LinePiece | ArcPiece] = []
        for start, end, bulge in zip(self.starts, self.ends, self.bulges.tolist(), strict=True):
            if (start == end).all():
                continue
            found.append(
                LinePiece(start, end) if bulge == 0.0 else ArcPiece.bulging(start, end, bulge)
            )
        return tuple(found)

    def flattened(self, tolerance: float) -> FloatArray:
        """Give points on it whose straight lines are nowhere farther from it, shape (k, 2), m.

        Raises:
            ValueError: If the tolerance is not above 0.
        """
        if not tolerance > 0.0:
            raise ValueError(f"tolerance: want a distance above zero, got {tolerance}")
        parts: list[FloatArray] = []
        for start, end, bulge in zip(self.starts, self.ends, self.bulges.tolist(), strict=True):
            parts.append(_chords(start, end, bulge, tolerance))
        if not self.closed:
            parts.append(self.vertices[-1:])
        return np.concatenate(parts)

    def packed(self) -> tuple[FloatArray, FloatArray]:
        """Give it as rows of pieces of at most a quarter turn, and the segment of each.

        Returns:
            Pieces, shape (n, 9), as ``arc_kernel`` has them, and their segments, shape (n,).
        """
        from .offset_kernel import pieces_of

        vertices, bulges, starts = joined((self,))
        P, segment, _ = pieces_of(vertices, bulges, starts, 0.0)
        if not self.closed:  # without the line that would close it
            count = int((segment < len(self.bulges)).sum())
            P, segment = P[:count], segment[:count]
        return P, segment


def joined(contours: Iterable[Contour]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give contours one after the other, open ones closed by a line: arrays that may be written to.

    Returns:
        Vertices, shape (m, 2), bulges, shape (m,), and the first vertex of each and m.
    """
    several = tuple(contours)
    if len(several) == 1 and several[0].closed:
        one = several[0]
        return one.vertices.copy(), one.bulges.copy(), np.array([0.0, len(one.bulges)])
    starts = np.cumsum([0.0] + [len(contour.vertices) for contour in several])
    vertices = np.concatenate([contour.vertices for contour in several])
    bulges = np.zeros(len(vertices))
    for start, contour in zip(starts.astype(int).tolist(), several, strict=False):
        bulges[start : start + len(contour.bulges)] = contour.bulges
    return vertices, bulges, starts


def _points(points: ArrayInput) -> tuple[FloatArray, tuple[int, ...]]:
    array = np.ascontiguousarray(points, dtype=np.float64)
    if array.shape[-1:] != (2,):
        raise ValueError(f"points: want shape (..., 2), got {array.shape}")
    return array.reshape(-1, 2), array.shape[:-1]


def _chords(start: FloatArray, end: FloatArray, bulge: float, tolerance: float) -> FloatArray:
    """Give the start of a segment and points on the way to its end, which is left out."""
    way = end - start
    chord = float(np.hypot(*way))
    height = 0.5 * abs(bulge) * chord
    if height <= tolerance:
        return start[None, :]
    turn = 4.0 * np.arctan(bulge)
    radius = chord / (2.0 * abs(sin(0.5 * turn)))
    step = 2.0 * np.arccos(1.0 - min(1.0, tolerance / radius))
    count = int(np.ceil(abs(turn) / step))
    off = 0.25 * (1.0 / bulge - bulge)
    centre = 0.5 * (start + end) + off * np.array([-way[1], way[0]])
    arm, angles = start - centre, turn * np.arange(count) / count
    c, s = np.cos(angles), np.sin(angles)
    turned = np.stack((c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]), axis=1)
    points: FloatArray = centre + turned
    return points
