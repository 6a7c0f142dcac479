"""Lines, arcs and the other conics as B-splines that are exactly they.

Every curve has the domain [0, 1]. Arcs and ellipses are rational and made of pieces of a quarter
turn at most; angles are in rad, from x towards y of the plane that the curve lies in.
"""

from math import ceil, pi

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from .bspline import BSpline
from .plane import Plane

_STRAIGHT = 1e-12
"""Below this sine three points lie on a line."""

_TURN = 2.0 * pi
_QUARTER = 0.5 * pi * (1.0 + 1e-12)
_LONGEST = 1.5
"""How far the hyperbolic angle of one piece of a hyperbola may go."""


def line(start: ArrayInput, end: ArrayInput) -> BSpline:
    """Give the straight piece between two points, shape (dim,) each.

    Raises:
        CurveError: If they are the same.
        ValueError: If they have different numbers of coordinates.
    """
    first = frozen_array(start, (None,), "start")
    last = frozen_array(end, first.shape, "end")
    if np.array_equal(first, last):
        raise CurveError(f"its ends are the same point {first.tolist()}", "line")
    return BSpline(np.array([0.0, 0.0, 1.0, 1.0]), np.array([first, last]), 1)


def circle(radius: float, plane: Plane | None = None) -> BSpline:
    """Give a full circle about the origin of a plane, from its x towards its y.

    Raises:
        ValueError: If the radius is not above 0.
    """
    return elliptic_arc((radius, radius), 0.0, _TURN, plane)


def arc(radius: float, start: float, end: float, plane: Plane | None = None) -> BSpline:
    """Give an arc about the origin of a plane from one angle to another, rad; backwards too.

    Raises:
        ValueError: If the radius is not above 0, or the arc has no length or more than one turn.
    """
    return elliptic_arc((radius, radius), start, end, plane)


def ellipse(a: float, b: float, plane: Plane | None = None) -> BSpline:
    """Give a full ellipse with half axis a along x and b along y of a plane.

    Raises:
        ValueError: If a half axis is not above 0.
    """
    return elliptic_arc((a, b), 0.0, _TURN, plane)


def elliptic_arc(
    axes: tuple[float, float], start: float, end: float, plane: Plane | None = None
) -> BSpline:
    """Give the arc of (a cos v, b sin v) with v from one angle to another, rad; backwards too.

    Args:
        axes: Half axes a along x and b along y.
        start: First v.
        end: Last v.
        plane: Where x and y lie; None: those of the plane of two coordinates.

    Raises:
        ValueError: If a half axis is not above 0, or the arc has no length or more than one turn.
    """
    a, b = _positive(axes[0], "a"), _positive(axes[1], "b")
    sweep = end - start
    if not 0.0 < abs(sweep) <= _TURN * (1.0 + 1e-15):
        raise ValueError(f"end: want an arc of more than 0 and up to one turn, got {sweep} rad")
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, sec. 7.3: half-way points where tangents meet
    count = max(1, ceil(abs(sweep) / _QUARTER))
    v = start + sweep * np.arange(2 * count + 1) / (2 * count)
    if abs(sweep) == _TURN:
        v[-1] = v[0]
    weight = np.cos(0.5 * sweep / count)
    return _chained(a * np.cos(v), b * np.sin(v), float(weight), plane)


def arc_through(start: ArrayInput, middle: ArrayInput, end: ArrayInput) -> BSpline:
    """Give the circular arc from one point through a second to a third, shape (dim,) each.

    Raises:
        CurveError: If they lie on a line.
        ValueError: If they have different numbers of coordinates, or only one.
    """
    p0 = frozen_array(start, (None,), "start")
    p1, p2 = frozen_array(middle, p0.shape, "middle"), frozen_array(end, p0.shape, "end")
    plane, radius, sweep = _through(p0, p1, p2)
    curve = elliptic_arc((radius, radius), 0.0, sweep, plane)
    points = curve.points.copy()
    points[0], points[-1] = p0, p2
    return BSpline(curve.knots, points, 2, curve.weights)


def _through(p0: FloatArray, p1: FloatArray, p2: FloatArray) -> tuple[Plane, float, float]:
    """Give the circle through three points: x to the first, y so that the arc goes forward."""
    if len(p0) < 2:
        raise ValueError(f"start: want at least two coordinates, got {p0.tolist()}")
    a, b = p1 - p0, p2 - p0
    scale = max(float(np.abs(a).max()), float(np.abs(b).max()))
    if not (a.any() and b.any() and (p2 - p1).any()):
        raise CurveError("two of its three points are the same", "arc")
    a, b = a / scale, b / scale
    ex = b / np.linalg.norm(b)
    along = float(a @ ex)
    across = a - along * ex
    height = float(np.linalg.norm(across))
    if height <= _STRAIGHT * float(np.linalg.norm(a)):
        raise CurveError("its three points lie on a line", "arc")
    ey = across / height
    half = 0.5 * float(np.linalg.norm(b))
    # the centre (half, c) is as far from (along, height) as from the origin
    c = 0.5 * (height + along * (along - 2.0 * half) / height)
    centre = half * ex + c * ey
    radius = float(np.hypot(half, c))
    x = -centre / radius
    # it leaves to the side of the chord that the middle point is on
    y = (half * ey - c * ex) / radius
    sweep = 2.0 * float(np.arctan2(half, -c))
    plane = Plane(p0 + scale * centre, x, y)
    return plane, scale * radius, sweep


def parabola(focal: float, start: float, end: float, plane: Plane | None = None) -> BSpline:
    """Give the piece of (focal v^2, 2 focal v) with v from one number to another.

    Its vertex is the origin of the plane, its focus (focal, 0): y^2 = 4 focal x.

    Raises:
        ValueError: If the focal distance is not above 0, or the piece has no length.
    """
    f = _positive(focal, "focal")
    if start == end or not np.isfinite([start, end]).all():
        raise ValueError(f"end: want a piece of some length, got v from {start} to {end}")
    points = f * np.array(
        [[start * start, 2.0 * start], [start * end, start + end], [end * end, 2.0 * end]]
    )
    placed = points if plane is None else plane.points(points)
    return BSpline(np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), placed, 2)


def hyperbola(
    axes: tuple[float, float], start: float, end: float, plane: Plane | None = None
) -> BSpline:
    """Give the piece of (a cosh v, b sinh v) with v from one number to another.

    Its centre is the origin of the plane; the other branch is that of a plane turned by half a
    turn.

    Raises:
        ValueError: If a or b is not above 0, or the piece has no length.
    """
    a, b = _positive(axes[0], "a"), _positive(axes[1], "b")
    if start == end or not np.isfinite([start, end]).all():
        raise ValueError(f"end: want a piece of some length, got v from {start} to {end}")
    count = max(1, ceil(abs(end - start) / _LONGEST))
    v = start + (end - start) * np.arange(2 * count + 1) / (2 * count)
    weight = np.cosh(0.5 * (end - start) / count)
    return _chained(a * np.cosh(v), b * np.sinh(v), float(weight), plane)


def conic_piece(
    start: ArrayInput, corner: ArrayInput, end: ArrayInput, through: ArrayInput
) -> BSpline:
    """Give the conic between two points whose tangents meet in a corner, through a third point.

    Args:
        start: First point, shape (dim,).
        corner: Where the tangents of both ends meet, shape (dim,).
        end: Last point, shape (dim,).
        through: A point inside the triangle of the three, shape (dim,).

    Raises:
        CurveError: If the point does not lie inside the triangle, or that is none.
    """
    p0 = frozen_array(start, (None,), "start")
    p1, p2, p = (
        frozen_array(point, p0.shape, name)
        for point, name in ((corner, "corner"), (end, "end"), (through, "through"))
    )
    scale = float(np.abs(np.array([p1 - p0, p2 - p0])).max()) or 1.0
    sides = np.array([p0 - p1, p2 - p1]).T / scale
    if np.linalg.matrix_rank(sides, tol=_STRAIGHT) < 2:
        raise CurveError("its ends and its corner lie on a line", "conic")
    shares = np.linalg.lstsq(sides, (p - p1) / scale, rcond=None)[0]
    off = float(np.abs(sides @ shares - (p - p1) / scale).max())
    t0, t2 = float(shares[0]), float(shares[1])
    t1 = 1.0 - t0 - t2
    if not (min(t0, t1, t2) > 0.0 and off <= 1e-9):
        raise CurveError(
            f"the point to go through, {p.tolist()}, is not inside the triangle of its ends and "
            "their tangents' corner",
            "conic",
        )
    # t1^2 = 4 w^2 t0 t2 in shares of the triangle: Piegl and Tiller, eq. 7.17
    weight = t1 / (2.0 * np.sqrt(t0 * t2))
    knots = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    return BSpline(knots, np.array([p0, p1, p2]), 2, np.array([1.0, weight, 1.0]))


def _chained(x: FloatArray, y: FloatArray, weight: float, plane: Plane | None) -> BSpline:
    """Give a chain of pieces from places on the conic at both ends and in the middle of each."""
    count = len(x) // 2
    points = np.stack((x, y), axis=1)
    # the tangents of a piece's ends meet beyond its middle, seen from the centre
    points[1::2] /= weight
    weights = np.ones(len(points))
    weights[1::2] = weight
    inner = np.repeat(np.arange(1, count) / count, 2)
    knots = np.concatenate(([0.0, 0.0, 0.0], inner, [1.0, 1.0, 1.0]))
    placed = points if plane is None else plane.points(points)
    return BSpline(knots, placed, 2, weights)


def _positive(value: float, name: str) -> float:
    if not 0.0 < value < np.inf:
        raise ValueError(f"{name}: want it above 0, got {value}")
    return float(value)
