"""The pieces of an offset: lines and arcs as such, splines fitted within the tolerance."""

from collections.abc import Sequence
from math import pi

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline

from .piece import ArcPiece, LinePiece, Piece, SplinePiece
from .spline_rough import UnclearError
from .spline_run import Run, Track
from .spline_source import Source

_SMOOTH = 1e-6
"""Directions that differ by less, rad, are one."""
_THROUGH, _OPEN, _CORNER = 0, 1, 2
"""How runs end: where the next goes on in the same direction, in the open, or at a corner."""


def track_pieces(
    source: Source, track: Track, band: tuple[float, float], *, free_ends: bool, thin: bool
) -> list[Piece]:
    """Give the pieces of a track, in the coordinates of the drawing.

    Args:
        source: What is offset.
        track: The runs.
        band: Distances of the near and the far edge, scaled; runs join at the near one.
        free_ends: Whether the ends of an open track may lie anywhere between them.
        thin: Whether to take out the control points that it can do without, which takes longer.

    Raises:
        UnclearError: If a run cannot be fitted.
    """
    runs = track.runs
    joints = [
        _joint(source, before, run)
        for before, run in zip((runs[-1], *runs[:-1]), runs, strict=True)
    ]
    joints.append(joints[0])
    if not track.closed:
        joints[0] = joints[-1] = _OPEN if free_ends else _CORNER
    found = [
        _piece(source, run, band, (joints[k], joints[k + 1]), thin=thin)
        for k, run in enumerate(runs)
    ]
    # joined where the drawing's coordinates are rounded to
    return _joined(found, closed=track.closed)


def _joint(source: Source, before: Run, run: Run) -> int:
    """Say how two runs join."""
    a, b = _direction(source, before, before.end), _direction(source, run, run.start)
    smooth = abs(a[0] * b[1] - a[1] * b[0]) < _SMOOTH and a @ b > 0.0
    return _THROUGH if smooth else _CORNER


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
    source: Source, run: Run, band: tuple[float, float], joints: tuple[int, int], *, thin: bool
) -> Piece:
    first, last = source.placed(run.first), source.placed(run.last)
    if run.corner:
        return _corner_arc(source, run, first, last)
    exact = source.chains[run.chain].piece
    if isinstance(exact, LinePiece):
        return LinePiece(first, last)
    if isinstance(exact, ArcPiece):
        arms = np.array([first, last]) - exact.centre
        turn = _turn(arms[0], arms[1], exact.turn)
        if (first == last).all():
            turn = float(np.sign(exact.turn)) * 2.0 * pi
        return ArcPiece(start=first, end=last, centre=exact.centre, turn=turn)
    return SplinePiece(_fitted(source, run, band, joints, thin=thin))


def _turn(a: FloatArray, b: FloatArray, sign: float) -> float:
    """Give the angle from a to b, with a sign."""
    turn = float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))
    if sign > 0.0:
        return turn if turn > 0.0 else turn + 2.0 * pi
    return turn if turn < 0.0 else turn - 2.0 * pi


def _corner_arc(source: Source, run: Run, first: FloatArray, last: FloatArray) -> ArcPiece:
    centre = source.placed(source.corner(run.chain))
    return ArcPiece(start=first, end=last, centre=centre, turn=run.end - run.start)


def _fitted(
    source: Source, run: Run, band: tuple[float, float], joints: tuple[int, int], *, thin: bool
) -> BSpline:
    """Give a run as one cubic B-spline with a continuous derivative."""
    from .spline_fit_kernel import fewest, piece_points
    from .spline_thin_kernel import thinned

    S, limits = source.segments, source.limits(run.chain)
    edges = -1 if joints[0] == _OPEN else 0, -1 if joints[1] == _OPEN else 0
    pieces = fewest(S, limits, (run.start, run.end), band, edges)
    if not len(pieces):
        raise UnclearError("a part of it cannot be fitted", run.first)
    points = np.array([piece_points(S, limits, p, band) for p in pieces]).reshape(-1, 4, 2)
    # a joint is where it should be if the spans are as long as the handles beside it: n pieces that
    # have a direction in common have a velocity in common, and need no points at their joints
    spans = np.ones(len(pieces))
    for k in range(1, len(pieces)):
        spans[k] = spans[k - 1] * pieces[k, 4] / pieces[k - 1, 5]
    inner = np.cumsum(spans)[:-1] / spans.sum()
    knots = np.concatenate((np.zeros(4), np.repeat(inner, 2), np.ones(4)))
    control = np.concatenate((points[0, :1], points[:, 1:3].reshape(-1, 2), points[-1, 3:]))
    if thin:
        feet = np.repeat(np.append(pieces[:, 0], run.end), [4] + [2] * len(inner) + [4])
        ways = np.array([control[1] - control[0], control[-1] - control[-2]])
        ways /= np.hypot(*ways.T)[:, None]
        ends = np.column_stack((ways, joints))
        control, knots, _ = thinned(S, limits, (control, knots, feet), band, ends)
    return BSpline(knots, source.placed(control), 3)
