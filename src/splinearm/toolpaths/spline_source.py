"""Lines, arcs and splines as the chains of polynomial segments that kernels work on."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import comb, frexp, hypot, ldexp, pi

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.conic import elliptic_arc
from splinearm.curves.feature import cusps
from splinearm.errors import CurveError

from .piece import ArcPiece, LinePiece, Piece, SplinePiece

_SMOOTH = 1e-7
"""Pieces whose directions differ by less than this, rad, meet smoothly."""
_ROUND = 1e-11
"""Share of its size by which a curve may differ from a line or a circle and still be one."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Segments from ``first`` to before ``end`` that are one smooth piece."""

    first: int
    """Its first segment."""
    end: int
    """The segment behind its last."""
    piece: Piece
    """What it is in the drawing's coordinates; splines that are lines or arcs are such."""

    def places(self, us: FloatArray) -> FloatArray:
        """Give the places of parameters of its spline, shape (k,)."""
        if not isinstance(self.piece, SplinePiece):
            return np.empty(0)
        breaks = self.piece.curve.breaks
        k = np.clip(np.searchsorted(breaks, us, side="right") - 1, 0, len(breaks) - 2)
        found: FloatArray = self.first + k + (us - breaks[k]) / (breaks[k + 1] - breaks[k])
        return found


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Source:
    """Wires as segments, moved to the origin and scaled to about 1."""

    segments: FloatArray
    """Coefficients, shape (k, n + 1, 3), see ``spline_jet_kernel``."""
    chains: tuple[Chain, ...]
    """The chains, in the order of the segments."""
    loops: tuple[tuple[int, int], ...]
    """Of each wire its first chain and the one behind its last."""
    origin: FloatArray
    """What was the origin, shape (2,), m."""
    unit: float
    """Length of what is 1 here, m."""

    def limits(self, chain: int) -> tuple[float, float]:
        """Give where a chain begins and ends."""
        return float(self.chains[chain].first), float(self.chains[chain].end)

    def beside(self, chain: int, place: float, distance: float) -> FloatArray:
        """Give the point to the left of a place and the direction there, shape (4,), scaled."""
        from .spline_jet_kernel import moved

        return np.array(moved(self.segments, *self.limits(chain), place, distance)[:4])

    def corner(self, chain: int) -> FloatArray:
        """Give where a chain ends, shape (2,), scaled."""
        return self.beside(chain, self.limits(chain)[1], 0.0)[:2]

    def placed(self, points: FloatArray) -> FloatArray:
        """Give points, shape (..., 2), in the coordinates of the drawing, m."""
        there: FloatArray = points * self.unit + self.origin
        return there


def source_of(wires: Sequence[Sequence[Piece]], reach: float) -> Source:
    """Give wires ready for kernels.

    Args:
        wires: Pieces, each of which begins where the one before it ends.
        reach: The distance by which they will be offset, m.

    Raises:
        CurveError: If a spline stands still somewhere.
    """
    smooth = [[part for piece in wire for part in _smooth_parts(piece)] for wire in wires]
    corners = np.concatenate([_corners(part) for wire in smooth for part in wire])
    low, high = corners.min(axis=0), corners.max(axis=0)
    origin = 0.5 * (low + high)
    unit = ldexp(1.0, frexp(max(float((high - low).max()), reach))[1])
    rows: list[FloatArray] = []
    chains: list[Chain] = []
    loops: list[tuple[int, int]] = []
    for wire in smooth:
        begun = len(chains)
        for part in wire:
            first = len(rows)
            rows += _segments(part, origin, unit)
            chains.append(Chain(first, len(rows), part))
        loops.append((begun, len(chains)))
    degree = max(len(row) for row in rows) - 1
    segments = np.zeros((len(rows), degree + 1, 3))
    for k, row in enumerate(rows):
        segments[k, : len(row)] = row
    return Source(
        segments=segments, chains=tuple(chains), loops=tuple(loops), origin=origin, unit=unit
    )


def _smooth_parts(piece: Piece) -> list[Piece]:
    """Give a piece as parts without corners; splines that are lines or arcs become such."""
    if not isinstance(piece, SplinePiece):
        return [piece]
    curve = piece.curve
    halts = cusps(curve)
    if len(halts.u) or len(halts.stretches):
        where = halts.u[0] if len(halts.u) else halts.stretches[0, 0]
        raise CurveError(f"it stands still at u = {where}: it has no side there", "spline")
    inner = curve.breaks[1:-1]
    times = np.searchsorted(curve.knots, inner, "right") - np.searchsorted(curve.knots, inner)
    sharp = [u for u in inner[times >= curve.degree].tolist() if _turns_at(curve, u)]
    ends = [curve.domain[0], *sharp, curve.domain[1]]
    parts = [curve] if not sharp else [curve.part(a, b) for a, b in pairwise(ends)]
    return [exact_form(part) for part in parts]


def _turns_at(curve: BSpline, u: float) -> bool:
    """Say whether a curve has a corner at a knot."""
    before, behind = curve.split(u)
    a, b = before.at(u, 1), behind.at(u, 1)
    return abs(float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))) > _SMOOTH


def exact_form(curve: BSpline) -> Piece:
    """Give a spline that is a line or a circular arc as such, any other as it is."""
    points = curve.points
    start, end = points[0], points[-1]
    size = float(np.abs(points - start).max())
    way = end - start
    chord = hypot(*way)
    if chord > _ROUND * size:
        aside = (points - start) @ np.array([-way[1], way[0]]) / chord
        along = (points - start) @ way / chord
        if np.abs(aside).max() <= _ROUND * size and (np.diff(along) >= -_ROUND * size).all():
            return LinePiece(start, end)
    if curve.weights is None:
        return SplinePiece(curve)
    return _arc_form(curve) or SplinePiece(curve)


def _arc_form(curve: BSpline) -> ArcPiece | None:
    """Give a rational curve as the circular arc that it is, if it is one of at most a full turn."""
    ends = curve.breaks
    t = np.linspace(0.0, 1.0, 4 * curve.degree + 3)
    u = (ends[:-1, None] + np.diff(ends)[:, None] * t).ravel()
    places, ways = curve.at(u), curve.at(u, 1)
    mean = places.mean(axis=0)
    q = places - mean
    answer, *_ = np.linalg.lstsq(np.column_stack((2.0 * q, np.ones(len(q)))), (q * q).sum(axis=1))
    centre = mean + answer[:2]
    radius = float(np.sqrt(answer[2] + answer[:2] @ answer[:2]))
    arms = places - centre
    # more places than the polynomial |P - c w|^2 - r^2 w^2 of a piece has roots
    if np.abs(np.hypot(*arms.T) - radius).max() > _ROUND * radius:
        return None
    steps = np.arctan2(
        arms[:-1, 0] * arms[1:, 1] - arms[:-1, 1] * arms[1:, 0], (arms[:-1] * arms[1:]).sum(axis=1)
    )
    turning = arms[:, 0] * ways[:, 1] - arms[:, 1] * ways[:, 0]
    turn = float(steps.sum())
    if not ((turning * np.sign(turn)) > 0.0).all() or abs(turn) > 2.0 * pi * (1.0 + 1e-12):
        return None
    closed = abs(turn) > 2.0 * pi - 1e-9
    end = curve.points[0] if closed else curve.points[-1]
    whole = float(np.sign(turn)) * 2.0 * pi if closed else turn
    return ArcPiece(start=curve.points[0], end=end, centre=centre, turn=whole)


def _corners(piece: Piece) -> FloatArray:
    """Give points that tell how large a piece is and where."""
    if isinstance(piece, SplinePiece):
        return piece.curve.points
    if isinstance(piece, ArcPiece):
        angles = piece.turn * np.linspace(0.0, 1.0, 9)[:, None]
        x, y = piece.start - piece.centre
        c, s = np.cos(angles), np.sin(angles)
        round_ones: FloatArray = piece.centre + np.hstack((c * x - s * y, s * x + c * y))
        return round_ones
    return np.array([piece.start, piece.end])


def _segments(piece: Piece, origin: FloatArray, unit: float) -> list[FloatArray]:
    """Give the coefficients of a piece, each of shape (n + 1, 3)."""
    if isinstance(piece, LinePiece):
        ends = (np.array([piece.start, piece.end]) - origin) / unit
        return [np.column_stack((_centred(ends), [1.0, 0.0]))]
    if isinstance(piece, ArcPiece):
        arm = piece.start - piece.centre
        first = float(np.arctan2(arm[1], arm[0]))
        round_one = elliptic_arc((piece.radius, piece.radius), first, first + piece.turn)
        centre = (piece.centre - origin) / unit
        _, bezier = round_one.bezier()
        for rows in bezier:
            rows[:, :2] = rows[:, :2] / unit + centre * rows[:, 2:]
        return [_centred(rows) for rows in bezier]
    curve = piece.curve
    weights = np.ones(len(curve.points)) if curve.weights is None else curve.weights
    shifted = BSpline(curve.knots, (curve.points - origin) / unit, curve.degree, curve.weights)
    _, bezier = shifted.bezier()
    if curve.weights is None:
        bezier = np.concatenate((bezier, np.ones((*bezier.shape[:2], 1))), axis=2)
    found = []
    for piece_rows in bezier:
        own = _centred(piece_rows)
        own /= own[0, 2]
        if (weights == weights[0]).all():
            own[1:, 2] = 0.0
        found.append(own)
    return found


@cache
def _to_powers(degree: int) -> FloatArray:
    """Give the matrix from Bernstein coefficients on [-1, 1] to those of powers of s."""
    M = np.empty((degree + 1, degree + 1))
    for i in range(degree + 1):
        row = np.array([1.0])
        for _ in range(i):
            row = np.convolve(row, [0.5, 0.5])
        for _ in range(degree - i):
            row = np.convolve(row, [0.5, -0.5])
        M[:, i] = comb(degree, i) * row
    return M


def _centred(rows: FloatArray) -> FloatArray:
    """Give Bernstein coefficients, shape (n + 1, ...), as those of 1, s, s^2 ... from -1 to 1."""
    powers: FloatArray = _to_powers(len(rows) - 1) @ rows
    return powers


def pieces_as_segments(
    pieces: Sequence[Piece], origin: FloatArray, unit: float
) -> list[FloatArray]:
    """Give the coefficients of pieces, those of one kind together, each of shape (k, n + 1, 3)."""
    groups: dict[tuple[int, bool], list[FloatArray]] = {}
    for piece in pieces:
        for row in _segments(piece, origin, unit):
            groups.setdefault((len(row), bool(row[1:, 2].any())), []).append(row)
    return [np.array(rows) for rows in groups.values()]
