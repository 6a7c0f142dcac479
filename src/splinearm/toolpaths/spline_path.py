"""The pieces of an offset: lines and arcs as such, splines fitted within the tolerance."""

from collections.abc import Sequence
from itertools import pairwise
from math import pi

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline

from .piece import ArcPiece, LinePiece, Piece, SplinePiece
from .spline_rough import UnclearError
from .spline_run import Run, Track, is_spline
from .spline_source import Source

_SMOOTH = 1e-6
"""Directions that differ by less, rad, are one."""
_THROUGH, _OPEN, _CORNER = 0, 1, 2
"""How runs end: where the next goes on in the same direction, in the open, or at a corner."""
_NEAR, _FAR, _MIDDLE, _ANY = 0, 1, 2, -1
"""At which edge of the band they end."""

_Ends = tuple[tuple[int, int], tuple[int, int]]


def track_pieces(
    source: Source, track: Track, band: tuple[float, float], *, free_ends: bool, thin: bool
) -> list[Piece]:
    """Give the pieces of a track, in the coordinates of the drawing.

    Args:
        source: What is offset.
        track: The runs.
        band: Distances of the near and the far edge, scaled: splines join in the middle, others
            at the near one.
        free_ends: Whether the ends of an open track may lie anywhere between them.
        thin: Whether to take out the control points that it can do without, which takes longer.

    Raises:
        UnclearError: If a run cannot be fitted.
    """
    runs = track.runs
    pairs = list(zip((runs[-1], *runs[:-1]), runs, strict=True))
    ends = [_end(source, *pair) for pair in pairs]
    if not track.closed:
        ends[0] = (_OPEN, _ANY) if free_ends else (_CORNER, ends[0][1])
    begins = [k for k, pair in enumerate(pairs) if ends[k][0] or not _goes_on(source, *pair)] or [0]
    found = []
    for first, behind in pairwise((*begins, begins[0] + len(runs))):
        several = [runs[k % len(runs)] for k in range(first, behind)]
        between = ends[first], ends[behind % len(runs)]
        found.append(_piece(source, several, band, between, thin=thin))
    # joined where the drawing's coordinates are rounded to
    return _joined(found, closed=track.closed)


def _end(source: Source, before: Run, run: Run) -> tuple[int, int]:
    """Say how two runs join, and at which edge of the band."""
    a, b = _direction(source, before, before.end), _direction(source, run, run.start)
    smooth = abs(a[0] * b[1] - a[1] * b[0]) < _SMOOTH and a @ b > 0.0
    splines = is_spline(source, before) and is_spline(source, run)
    return _THROUGH if smooth else _CORNER, _MIDDLE if splines else _NEAR


def _goes_on(source: Source, before: Run, run: Run) -> bool:
    """Say whether two runs that join smoothly are beside one spline or two that follow it."""
    if before is run or not (is_spline(source, before) and is_spline(source, run)):
        return False
    last, first = source.limits(before.chain)[1], source.limits(run.chain)[0]
    return before.end == last and run.start == first


def _direction(source: Source, run: Run, place: float) -> FloatArray:
    """Give the direction of a run at a place of its chain, or at an angle."""
    if not run.corner:
        return source.beside(run.chain, place, 0.0)[2:]
    side = float(np.sign(run.end - run.start))
    return np.array([-side * np.sin(place), side * np.cos(place)])


def _joined(pieces: Sequence[Piece], *, closed: bool) -> list[Piece]:
    joined = list(pieces)
    for k in range(1 if not closed else 0, len(joined)):
        end, piece = joined[k - 1].end, joined[k]
        if not (piece.start == end).all():
            joined[k] = piece.between(end, piece.end if len(joined) > 1 else end)
    return joined


def _piece(
    source: Source, runs: Sequence[Run], band: tuple[float, float], ends: _Ends, *, thin: bool
) -> Piece:
    run = runs[0]
    if is_spline(source, run):
        return SplinePiece(_fitted(source, runs, band, ends, thin=thin))
    first, last = source.placed(run.first), source.placed(run.last)
    if run.corner:
        return _corner_arc(source, run, first, last)
    exact = source.chains[run.chain].piece
    if isinstance(exact, LinePiece):
        return LinePiece(first, last)
    if not isinstance(exact, ArcPiece):
        raise TypeError(f"exact: want a line or an arc here, got {type(exact).__name__}")
    arms = np.array([first, last]) - exact.centre
    turn = _turn(arms[0], arms[1], exact.turn)
    if (first == last).all():
        turn = float(np.sign(exact.turn)) * 2.0 * pi
    return ArcPiece(start=first, end=last, centre=exact.centre, turn=turn)


def _turn(a: FloatArray, b: FloatArray, sign: float) -> float:
    """Give the angle from a to b, with a sign."""
    turn = float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
    if sign > 0.0:
        return turn if turn > 0.0 else turn + 2.0 * pi
    return turn if turn < 0.0 else turn - 2.0 * pi


def _corner_arc(source: Source, run: Run, first: FloatArray, last: FloatArray) -> ArcPiece:
    centre = source.placed(source.corner(run.chain))
    return ArcPiece(start=first, end=last, centre=centre, turn=run.end - run.start)


def _segments(source: Source, runs: Sequence[Run]) -> tuple[FloatArray, float, float]:
    """Give the segments beside which runs lie, one after the other, and where on them."""
    chains = [source.chains[run.chain] for run in runs]
    rows = np.concatenate([source.segments[chain.first : chain.end] for chain in chains])
    start = runs[0].start - chains[0].first
    return rows, start, runs[-1].end - chains[-1].end + len(rows)


def _fitted(
    source: Source, runs: Sequence[Run], band: tuple[float, float], ends: _Ends, *, thin: bool
) -> BSpline:
    """Give runs as one cubic B-spline with a continuous derivative."""
    from .spline_thin_kernel import thinned

    S, start, end = _segments(source, runs)
    limits = 0.0, float(len(S))
    (first, edge), (last, other) = ends
    found: list[tuple[FloatArray, FloatArray]] = []
    # from where a free end begins some ways to fewer points are found and others are not
    for free in (_ANY, _FAR) if thin and _ANY in (edge, other) else (_ANY,):
        edges = free if edge == _ANY else edge, free if other == _ANY else other
        made = _joined_pieces(S, (start, end), band, edges)
        if made is None:
            continue
        control, knots, _feet = made
        if thin:
            ways = np.array([control[1] - control[0], control[-1] - control[-2]])
            ways /= np.hypot(*ways.T)[:, None]
            held = np.column_stack((ways, [float(first), float(last)]))
            control, knots, _ = thinned(S, limits, made, band, held)
        found.append((control, knots))
    if not found:
        raise UnclearError("a part of it cannot be fitted", runs[0].first)
    control, knots = min(found, key=lambda one: len(one[0]))
    return BSpline(knots, source.placed(control), 3)


def _joined_pieces(
    S: FloatArray, run: tuple[float, float], band: tuple[float, float], edges: tuple[int, int]
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Give the fewest cubics beside segments as one spline: points, knots and feet of these."""
    from .spline_fit_kernel import fewest, piece_points

    limits = 0.0, float(len(S))
    pieces = fewest(S, limits, run, band, edges)
    if not len(pieces):
        return None
    points = np.array([piece_points(S, limits, p, band) for p in pieces]).reshape(-1, 4, 2)
    # a joint is where it should be if the spans are as long as the handles beside it: n pieces that
    # have a direction in common have a velocity in common, and need no points at their joints
    spans = np.ones(len(pieces))
    for k in range(1, len(pieces)):
        spans[k] = spans[k - 1] * pieces[k, 4] / pieces[k - 1, 5]
    inner = np.cumsum(spans)[:-1] / spans.sum()
    knots = np.concatenate((np.zeros(4), np.repeat(inner, 2), np.ones(4)))
    control = np.concatenate((points[0, :1], points[:, 1:3].reshape(-1, 2), points[-1, 3:]))
    feet = np.repeat(np.append(pieces[:, 0], run[1]), [4] + [2] * len(inner) + [4])
    return control, knots, feet
