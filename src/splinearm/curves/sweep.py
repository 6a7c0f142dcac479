"""Surfaces of a profile that is carried along a path and turns with it."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from . import knot
from .bspline import BSpline
from .frame import RotationMinimisingFrame
from .surface import BSplineSurface

_DEGREE = 5
_LOOKS = np.linspace(0.0, 1.0, 9)[1:-1]
_SAFETY = 0.7
"""Share of the tolerance that is allowed where the carrying is compared with the exact one."""

_MOST_PIECES = 20_000
_MOST_HALVINGS = 30
_SMOOTH = 1e-9
_CORNER = 1e-9


class _Carrying(NamedTuple):
    """Where the profile's origin and axes are along a part of the path, with two derivatives."""

    start: FloatArray
    """Jets at the starts of pieces, shape (k, 3, 12): origin, x, y and z of the profile."""
    end: FloatArray
    """Jets at their ends, shape (k, 3, 12)."""
    edges: FloatArray
    """The ends of the pieces, shape (k + 1,)."""


def swept(
    profile: BSpline,
    path: BSpline,
    tolerance: float,
    *,
    normal: ArrayInput | None = None,
    closed: bool = False,
) -> BSplineSurface:
    """Give the surface of a profile carried along a path in a rotation-minimising frame.

    u is the parameter of the profile, v that of the path. The frame's first and second normal
    are x and y of the profile, its tangent z. Without turning, ``translated`` is exact.

    Args:
        profile: A curve of coordinates x and y, or x, y and z, in the frame of the path.
        path: A curve in space without corners that stands still nowhere.
        tolerance: How far the surface may be from the exact one, at the same u and v, m.
        normal: The direction nearest to which x starts, shape (3,); None: some direction.
        closed: Whether the frame ends as it starts, along a closed path.

    Raises:
        CurveError: If the path has a corner, stands still or is not closed where it should be, or
            the tolerance cannot be reached.
        ValueError: If numbers of coordinates do not fit or the tolerance is not above 0.
    """
    if profile.dim not in (2, 3):
        raise ValueError(f"profile: want 2 or 3 coordinates, got {profile.dim}")
    if not tolerance > 0.0:
        raise ValueError(f"tolerance: want it above 0, got {tolerance}")
    frame = RotationMinimisingFrame(path, None if normal is None else np.asarray(normal), closed)
    local = np.zeros((len(profile.points), 4))
    local[:, 0] = 1.0
    local[:, 1 : 1 + profile.dim] = profile.points
    reach = np.abs(local).max(axis=0)
    pieces = [path.part(start, end) for start, end in pairwise(path.breaks.tolist())]
    _check_corners(pieces)
    carryings = [_carry(frame, piece, reach, tolerance) for piece in pieces]
    knots, rows = _joined(carryings)
    points = np.einsum("if,jfc->ijc", local, rows.reshape(len(rows), 4, 3))
    weights = None
    if profile.weights is not None:
        weights = np.repeat(profile.weights[:, None], len(rows), axis=1)
    return BSplineSurface(profile.knots, knots, points, profile.degree, _DEGREE, weights)


def _check_corners(pieces: list[BSpline]) -> None:
    """Refuse a path whose direction jumps between its smooth pieces."""
    for before, behind in pairwise(pieces):
        where = behind.domain[0]
        ways = [piece.at(where, 1) for piece in (before, behind)]
        first, second = (way / np.linalg.norm(way) for way in ways)
        if np.linalg.norm(first - second) > _CORNER:
            raise CurveError("the path has a corner: sweep its parts", f"path at {where:.9g}")


def _carry(
    frame: RotationMinimisingFrame, piece: BSpline, reach: FloatArray, tolerance: float
) -> _Carrying:
    """Give the carrying along a smooth piece, in parts that a quintic each is near enough to."""
    edges = np.array(piece.domain)
    jets = _jets(frame, piece, edges)
    for _ in range(_MOST_HALVINGS):
        widths = np.diff(edges)
        points = _hermite(_Carrying(jets[:-1], jets[1:], edges))
        looks = edges[:-1, None] + widths[:, None] * _LOOKS
        exact = _jets(frame, piece, looks.ravel(), order=0).reshape(len(widths), -1, 4, 3)
        off = np.einsum("ln,knc->klc", _bernstein(_LOOKS), points).reshape(exact.shape) - exact
        worst = (np.linalg.norm(off, axis=-1) @ reach).max(axis=1)
        rough = worst > _SAFETY * tolerance
        if not rough.any():
            return _Carrying(jets[:-1], jets[1:], edges)
        if len(edges) > _MOST_PIECES:
            break
        halves = (edges[:-1] + 0.5 * widths)[rough]
        order = np.argsort(np.concatenate((edges, halves)), kind="stable")
        edges = np.concatenate((edges, halves))[order]
        jets = np.concatenate((jets, _jets(frame, piece, halves)))[order]
    raise CurveError(f"{tolerance:.3g} m cannot be reached along the path", "swept surface")


def _jets(
    frame: RotationMinimisingFrame, piece: BSpline, v: FloatArray, order: int = 2
) -> FloatArray:
    """Give origin, x, y and z of the profile with derivatives, shape (k, order + 1, 12)."""
    place = piece.jet(v, 3)
    axes = np.roll(frame.at(v).swapaxes(1, 2), -1, axis=1)
    jets = np.empty((len(v), order + 1, 4, 3))
    jets[:, :, 0] = place[:, : order + 1]
    jets[:, 0, 1:] = axes
    if order > 0:
        spin, more = _spins(frame, place)
        turning = np.cross(spin[:, None], axes)
        jets[:, 1, 1:] = turning
        jets[:, 2, 1:] = np.cross(more[:, None], axes) + np.cross(spin[:, None], turning)
    return jets.reshape(len(v), order + 1, 12)


def _spins(frame: RotationMinimisingFrame, place: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the rate at which the frame turns, and its derivative, shape (k, 3) each."""
    # the frame turns with the tangent T and not about it: rate T x T'. C' = s T, differentiated,
    # gives the derivatives of T
    first, second, third = place[:, 1], place[:, 2], place[:, 3]
    s = np.linalg.norm(first, axis=1)[:, None]
    t0 = first / s
    s1 = np.sum(second * t0, axis=1)[:, None]
    t1 = (second - s1 * t0) / s
    s2 = np.sum(third * t0 + second * t1, axis=1)[:, None]
    t2 = (third - s2 * t0 - 2.0 * s1 * t1) / s
    spin, more = np.cross(t0, t1), np.cross(t0, t2)
    if frame.closing_twist != 0.0:
        about = frame.closing_twist / frame.curve.length()
        spin, more = spin + about * s * t0, more + about * (s1 * t0 + s * t1)
    return spin, more


def _hermite(carrying: _Carrying) -> FloatArray:
    """Give control points of the quintics between jets, shape (k, 6, 12)."""
    h = np.diff(carrying.edges)[:, None]
    points = np.empty((len(h), 6, 12))
    for jet, sign, at in ((carrying.start, 1.0, (0, 1, 2)), (carrying.end, -1.0, (5, 4, 3))):
        step, bend = sign * h * jet[:, 1] / 5.0, h * h * jet[:, 2] / 20.0
        points[:, at[0]] = jet[:, 0]
        points[:, at[1]] = jet[:, 0] + step
        points[:, at[2]] = jet[:, 0] + 2.0 * step + bend
    return points


def _bernstein(x: FloatArray) -> FloatArray:
    """Give the six quintic Bernstein polynomials at some shares, shape (k, 6)."""
    binomials = np.array([1.0, 5.0, 10.0, 10.0, 5.0, 1.0])
    i = np.arange(6)
    values: FloatArray = binomials * x[:, None] ** i * (1.0 - x[:, None]) ** (5 - i)
    return values


def _joined(carryings: list[_Carrying]) -> tuple[FloatArray, FloatArray]:
    """Give knots and control points of all pieces, as smooth where they meet as they are."""
    points = np.concatenate([_hermite(carrying) for carrying in carryings])
    starts = np.concatenate([carrying.start for carrying in carryings])
    ends = np.concatenate([carrying.end for carrying in carryings])
    edges = np.concatenate([carryings[0].edges[:1], *[c.edges[1:] for c in carryings]])
    size = np.abs(starts).max(axis=(0, 2))
    apart = np.abs(starts[1:] - ends[:-1]).max(axis=2) / np.where(size > 0.0, size, 1.0)
    counts = np.where(apart[:, 1] > _SMOOTH, 5, np.where(apart[:, 2] > _SMOOTH, 4, 3))
    # neighbours share their point to the last bit
    points[:-1, -1] = points[1:, 0]
    knots = knot.clamped_knots(edges[0], edges[1:-1], counts, edges[-1], _DEGREE)
    rows = knot.over_knots(np.repeat(edges, 6), points.reshape(-1, 12), _DEGREE, knots)
    return knots, rows
