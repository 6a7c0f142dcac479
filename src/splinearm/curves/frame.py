"""Frames that go along a curve in space without turning about it more than they must."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from .arc_length import ArcLength
from .basis import IndexArray
from .bspline import BSpline
from .velocity import Velocity, directions, locate, velocity_of

_ROUGH, _ROUGH_WEIGHTS = np.polynomial.legendre.leggauss(8)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)

_LEAST_COSINE = 0.5
"""The tangent turns by no more than 60 degrees on an interval."""

_BACK = 1e-12
_MOST_HALVINGS = 40


class _Interval(NamedTuple):
    """Parts of pieces, in order along the curve, each number of shape (k,)."""

    piece: IndexArray
    start: FloatArray
    end: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class RotationMinimisingFrame:
    """Tangent and two normals that do not turn about the tangent, at any place of a curve.

    The twist is integrated to the tolerance, not stepped: a frame does not depend on which others
    are asked for. Inflections and straight pieces are nothing special; where the curve has a
    corner, the frame turns with it on the shortest way.
    """

    curve: BSpline
    """A curve in space that stands still nowhere."""
    normal: FloatArray | None = None
    """The direction nearest to which the first normal starts, shape (3,); None: some direction."""
    closed: bool = False
    """Whether the frame ends as it starts: what is missing for that is spread along the curve."""
    tolerance: float = 1e-13
    """By how much the angle of a part of the curve may be wrong, rad."""
    _velocity: Velocity = field(init=False, repr=False)
    _interval: _Interval = field(init=False, repr=False)
    _normals: FloatArray = field(init=False, repr=False)
    _closing: "tuple[ArcLength, float] | None" = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.curve.dim != 3 or self.curve.degree == 0:
            raise ValueError(
                f"curve: want 3 coordinates and degree 1 or more, got {self.curve.dim} and "
                f"{self.curve.degree}"
            )
        if not self.tolerance > 0.0:
            raise ValueError(f"tolerance: want it above 0, got {self.tolerance}")
        velocity = velocity_of(self.curve)
        interval, angle = _twists(velocity, self.tolerance)
        starts = directions(velocity, interval.piece, interval.start)[0]
        first = starts[:1]
        last = directions(velocity, interval.piece[-1:], interval.end[-1:])[0]
        begin = _start_angle(first[0], self.normal)
        closing = None
        if self.closed:
            if not self.curve.is_closed() or float(first[0] @ last[0]) < 1.0 - 1e-9:
                raise CurveError("it does not end as it starts: not closed", "frame")
            twist = float(angle[-1] + _turn_between(last, first)[0])
            missing = -((twist + np.pi) % (2.0 * np.pi) - np.pi)
            closing = ArcLength(self.curve), float(missing)
        for name, value in (
            ("_velocity", velocity),
            ("_interval", interval),
            ("_normals", _turned(_some_normal(starts), starts, angle[:-1] + begin)),
            ("_closing", closing),
        ):
            object.__setattr__(self, name, value)

    def at(self, u: ArrayInput) -> FloatArray:
        """Give frames at parameters in the domain, shape (..., 3, 3).

        The columns are tangent, first and second normal, a right-handed frame.

        Raises:
            CurveError: If a parameter lies outside the domain or is not a number.
        """
        parameters = np.asarray(u, dtype=np.float64)
        flat = parameters.ravel()
        start, end = self.curve.domain
        outside = ~((flat >= start) & (flat <= end))
        if outside.any():
            where = flat[int(np.argmax(outside))]
            raise CurveError(f"defined from {start} to {end}, not at {where}", "frame")
        piece, t = locate(self._velocity, flat)
        places = self._interval.piece + self._interval.start
        k = np.clip(np.searchsorted(places, piece + t, side="right") - 1, 0, len(places) - 1)
        # a place may lie on the piece before by rounding of the sum
        k = np.where(self._interval.piece[k] > piece, k - 1, k)
        asked = _Interval(piece, self._interval.start[k], t)
        _, before, tangent, angle = _twist(self._velocity, asked, _NODES, _WEIGHTS)
        if self._closing is not None:
            arc, missing = self._closing
            angle = angle + missing * arc.s(flat) / arc.length
        normal = _turned(_carried(self._normals[k], before, tangent), tangent, angle)
        frames = np.stack((tangent, normal, np.cross(tangent, normal)), axis=-1)
        return frames.reshape(*parameters.shape, 3, 3)

    @property
    def closing_twist(self) -> float:
        """The angle that is spread along a closed curve so that the frame ends as it starts, rad.

        0 for a frame that is not closed.
        """
        return 0.0 if self._closing is None else self._closing[1]


def double_reflection(
    points: ArrayInput, tangents: ArrayInput, normal: ArrayInput | None = None
) -> FloatArray:
    """Give rotation-minimising frames at points of a curve from no more than these.

    The angle about the curve is wrong by the fourth power of the step: halving the steps divides
    the error by 16.

    Args:
        points: Successive points, shape (m, 3).
        tangents: Unit tangents there, shape (m, 3).
        normal: The direction nearest to which the first normal starts, shape (3,).

    Returns:
        Frames, shape (m, 3, 3): columns tangent, first and second normal.

    Raises:
        ValueError: If successive points are the same, or tangents not of length 1.
    """
    # Wang, Juttler, Zheng and Liu, Computation of rotation minimizing frames, ACM Transactions on
    # Graphics 27 (2008) 2: reflect in the plane between both points, then in the one that leads
    # the tangent to where it should be
    p = frozen_array(points, (None, 3), "points")
    t = frozen_array(tangents, (len(p), 3), "tangents")
    if not np.allclose(np.linalg.norm(t, axis=1), 1.0, rtol=0.0, atol=1e-9):
        raise ValueError(f"tangents: want them of length 1, got {t.tolist()}")
    step = np.diff(p, axis=0)
    if not step.any(axis=1).all():
        raise ValueError("points: want no two after another the same")
    some = _some_normal(t)
    carried = _mirrored(some[:-1], step)
    carried = _mirrored(carried, t[1:] - _mirrored(t[:-1], step))
    angle = np.concatenate(([_start_angle(t[0], normal)], _angle_to(some[1:], carried, t[1:])))
    normals = _turned(some, t, np.cumsum(angle))
    return np.stack((t, normals, np.cross(t, normals)), axis=-1)


def _twists(velocity: Velocity, tolerance: float) -> tuple[_Interval, FloatArray]:
    """Give intervals on which quadrature is exact, and the angle of the frame at their starts.

    Angles are from some normal of the tangent there to the frame's own; one more belongs to the
    end of the last interval.
    """
    count = len(velocity.V)
    waiting = _Interval(np.arange(count), np.zeros(count), np.ones(count))
    done: list[_Interval] = []
    for _ in range(_MOST_HALVINGS):
        cosine, _, _, rough = _twist(velocity, waiting, _ROUGH, _ROUGH_WEIGHTS)
        sine, _, _, fine = _twist(velocity, waiting, _NODES, _WEIGHTS)
        good = (np.abs(rough - fine) <= tolerance) & (np.minimum(cosine, sine) > _LEAST_COSINE)
        done.append(_Interval(waiting.piece[good], waiting.start[good], waiting.end[good]))
        twice = np.repeat(np.flatnonzero(~good), 2)
        waiting = _Interval(waiting.piece[twice], waiting.start[twice], waiting.end[twice])
        if not len(waiting.piece):
            break
        middle = 0.5 * (waiting.start + waiting.end)
        waiting.start[1::2], waiting.end[::2] = middle[1::2], middle[::2]
    else:
        where = velocity.ends[waiting.piece[0]]
        raise CurveError(f"its direction changes too quickly after u = {where}", "frame")
    order = np.argsort(np.concatenate([x.piece + x.start for x in done]), kind="stable")
    interval = _Interval(*(np.concatenate(x)[order] for x in zip(*done, strict=True)))
    _, first, last, angle = _twist(velocity, interval, _NODES, _WEIGHTS)
    steps = angle + _turn_between(first, last)
    steps[:-1] += _turn_between(last[:-1], first[1:])
    return interval, np.concatenate(([0.0], np.cumsum(steps)))


def _twist(
    velocity: Velocity, interval: _Interval, nodes: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Give the least cosine to the first tangent, both tangents and the angle of each interval.

    The angle is that by which the frame is ahead of a normal that turns with the tangent on the
    shortest way from that of the start.
    """
    piece, start, end = interval
    first, last = (directions(velocity, piece, t)[0] for t in (start, end))
    half = 0.5 * (end - start)
    t = np.clip(start[:, None] + half[:, None] * (1.0 + nodes), 0.0, 1.0)
    flat = directions(velocity, np.repeat(piece, len(nodes)), t.ravel())
    tangent, bend = (x.reshape(*t.shape, 3) for x in flat)
    # a frame that turns from t0 to t on the shortest way has, with t = (sin a cos b, sin a sin b,
    # cos a) seen from t0, the rate -(1 - cos a) db about t: Goldstein, Classical Mechanics, the
    # angles of Euler with the third minus the first
    cosine = np.einsum("kni,ki->kn", tangent, first)
    rate = np.einsum("kni,kni->kn", np.cross(first[:, None], tangent), bend)
    angle = half * np.sum(weights * rate / np.maximum(1.0 + cosine, _BACK), axis=1)
    least = np.minimum(cosine.min(axis=1), np.sum(first * last, axis=1))
    return least, first, last, angle


def _some_normal(tangent: FloatArray) -> FloatArray:
    """Give a unit vector across each tangent, shape (k, 3)."""
    axis = np.eye(3)[np.argmin(np.abs(tangent), axis=1)]
    across = np.cross(tangent, axis)
    unit: FloatArray = across / np.linalg.norm(across, axis=1)[:, None]
    return unit


def _carried(normal: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Give normals turned with the tangent on the shortest way from start to end."""
    cosine = 1.0 + np.sum(start * end, axis=1)
    if (cosine <= _BACK).any():
        raise CurveError("it turns back: no shortest way for the frame", "frame")
    share = np.sum(end * normal, axis=1) / cosine
    carried: FloatArray = normal - share[:, None] * (start + end)
    return carried


def _turned(normal: FloatArray, tangent: FloatArray, angle: FloatArray) -> FloatArray:
    """Give normals turned about their tangents."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return c * normal + s * np.cross(tangent, normal)


def _angle_to(start: FloatArray, end: FloatArray, tangent: FloatArray) -> FloatArray:
    """Give the angles about tangents from one normal to another."""
    sine = np.sum(np.cross(start, end) * tangent, axis=1)
    angles: FloatArray = np.arctan2(sine, np.sum(start * end, axis=1))
    return angles


def _turn_between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Give the angle from some normal of the end to the carried one of the start."""
    return _angle_to(_some_normal(end), _carried(_some_normal(start), start, end), end)


def _start_angle(tangent: FloatArray, normal: ArrayInput | None) -> float:
    """Give the angle from some normal of the first tangent to the wanted one."""
    if normal is None:
        return 0.0
    wanted = frozen_array(normal, (3,), "normal")
    across = wanted - (wanted @ tangent) * tangent
    if not np.linalg.norm(across) > 1e-9 * np.linalg.norm(wanted):
        raise ValueError(
            f"normal: want one across the tangent {tangent.tolist()}, got {wanted.tolist()}"
        )
    return float(_angle_to(_some_normal(tangent[None]), across[None], tangent[None])[0])


def _mirrored(vectors: FloatArray, normals: FloatArray) -> FloatArray:
    """Give vectors mirrored in planes."""
    share = 2.0 * np.sum(vectors * normals, axis=1) / np.sum(normals * normals, axis=1)
    mirrored: FloatArray = vectors - share[:, None] * normals
    return mirrored
