"""B-splines through given points."""

from dataclasses import dataclass, field
from typing import Literal, cast, get_args

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import banded, basis, hermite, parametrisation
from .bspline import BSpline

Parameters = Literal["chord", "centripetal", "uniform", "universal", "foley", "nielson"]
"""How parameters are chosen for points: by distance, by its square root, evenly ..."""

Ends = Literal["natural", "free", "not-a-knot", "closed"]
"""What holds at the ends of a curve through points.

Natural: the highest derivatives vanish. Free: no condition, all knots are means of parameters.
Not-a-knot: no condition, knots are parameters, but none of the outermost. Closed: a loop.
"""

_NONE = np.empty((0, 0))


@dataclass(frozen=True, slots=True, eq=False)
class EndDerivatives:
    """The first, second ... derivatives by the parameter that a curve shall have at its ends."""

    start: FloatArray = field(default_factory=_NONE.copy)
    """At the start, first derivative first, shape (a, dim); a may be 0."""
    end: FloatArray = field(default_factory=_NONE.copy)
    """At the end, shape (b, dim)."""

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (None, None), name))


@dataclass(frozen=True, slots=True, eq=False)
class _Conditions:
    """What a curve is to fulfil, one row each: a derivative at a parameter."""

    u: FloatArray
    order: FloatArray
    values: FloatArray


def choose_parameters(
    points: ArrayInput, kind: Parameters = "chord", *, closed: bool = False, degree: int = 3
) -> FloatArray:
    """Give rising parameters for points, starting at 0.

    Args:
        points: Points, shape (m, dim).
        kind: "chord": distances add up, so that the parameter is nearly arc length;
            "centripetal": their square roots do, which keeps sharp turns tame (Lee, Choosing
            nodes in parametric curve interpolation, CAD 21, 1989); "uniform": 0, 1, 2 ...;
            "universal": where the basis functions of even knots are largest; "foley": distances,
            longer where the way turns; "nielson": the same with distances that no affine map of
            the points changes.
        closed: Whether the way from the last point back to the first counts as well; then there
            is one parameter more than points.
        degree: Degree of the curve, which only "universal" looks at.

    Raises:
        CurveError: If two neighbours are the same point.
        ValueError: If the kind is none of these.
    """
    array = frozen_array(points, (None, None), "points")
    if closed:
        array = np.vstack((array, array[:1]))
    chords = np.linalg.norm(np.diff(array, axis=0), axis=1)
    if kind not in get_args(Parameters):
        raise ValueError(f"parameters: want one of {get_args(Parameters)}, got {kind!r}")
    if kind == "uniform" or (kind == "universal" and closed):
        return np.arange(len(array), dtype=np.float64)
    if kind == "universal":
        return parametrisation.universal(len(array), degree)
    if (chords <= 0.0).any():
        i = int(np.argmin(chords))
        raise CurveError(
            f"points {i} and {(i + 1) % (len(array) - closed)} are the same; take one out",
            "interpolation",
        )
    if kind in ("chord", "centripetal"):
        steps = chords if kind == "chord" else np.sqrt(chords)
    else:
        metric = parametrisation.affine_metric(array) if kind == "nielson" else array
        steps = parametrisation.foley_steps(metric, closed=closed)
    return np.concatenate(([0.0], np.cumsum(steps)))


def interpolate(
    points: ArrayInput,
    *,
    degree: int = 3,
    parameters: Parameters | ArrayInput = "chord",
    ends: Ends | EndDerivatives = "natural",
) -> BSpline:
    """Give the B-spline that passes through points at their parameters.

    Args:
        points: Points to pass, shape (m, dim); of a closed curve each once.
        degree: Degree, at least 1; natural and closed curves have an odd one.
        parameters: How to choose the parameters, or the parameters themselves, rising, shape
            (m,), of a closed curve (m + 1,).
        ends: What holds at the ends.

    Raises:
        CurveError: If two neighbours are the same point, or no such curve is there.
        ValueError: If the numbers of points, parameters and conditions do not fit.
    """
    array = frozen_array(points, (None, None), "points")
    closed = isinstance(ends, str) and ends == "closed"
    if isinstance(parameters, str):
        u = choose_parameters(array, cast(Parameters, parameters), closed=closed, degree=degree)
    else:
        u = frozen_array(parameters, (len(array) + closed,), "parameters")
        if (np.diff(u) <= 0.0).any():
            raise ValueError(f"parameters: want them rising, got {u.tolist()}")
    if degree < 1:
        raise ValueError(f"degree: want at least 1, got {degree}")
    if len(array) < 2:
        raise ValueError(f"points: want at least 2, got {len(array)}")
    try:
        return _interpolate_closed(array, u, degree) if closed else _open(array, u, degree, ends)
    except np.linalg.LinAlgError as error:
        raise CurveError(
            f"no curve of degree {degree} meets these {len(array)} points and ends",
            "interpolation",
        ) from error


def _open(points: FloatArray, u: FloatArray, degree: int, ends: Ends | EndDerivatives) -> BSpline:
    conditions, knots = _open_conditions(points, u, degree, ends)
    spans = basis.find_spans(knots, degree, conditions.u)
    rows = basis.basis_values(knots, degree, spans, conditions.u, conditions.order)
    solved = banded.solve(spans - degree, rows, conditions.values)
    return BSpline(knots, solved, degree)


def _open_conditions(
    points: FloatArray, u: FloatArray, degree: int, ends: Ends | EndDerivatives
) -> tuple[_Conditions, FloatArray]:
    """Give all conditions in the order of their parameters, and fitting clamped knots."""
    dim = points.shape[1]
    if isinstance(ends, EndDerivatives):
        for name in ("start", "end"):
            given = getattr(ends, name)
            if (len(given) and given.shape[1] != dim) or len(given) >= degree:
                raise ValueError(
                    f"ends: want at most {degree - 1} derivatives of {dim} coordinates, {name} "
                    f"got shape {given.shape}"
                )
        first, last = ends.start.reshape(-1, dim), ends.end.reshape(-1, dim)
        orders_first = np.arange(1, len(first) + 1)
        orders_last = np.arange(1, len(last) + 1)
    elif ends in ("natural", "free", "not-a-knot"):
        if ends == "natural" and (degree % 2 == 0 or len(u) < (degree + 1) // 2):
            raise ValueError(
                f"degree: want an odd one below {2 * len(u)} for natural ends of {len(u)} points, "
                f"got {degree}"
            )
        count = (degree - 1) // 2 if ends == "natural" else 0
        first = last = np.zeros((count, dim))
        orders_first = orders_last = np.arange(degree - count, degree)
    else:
        raise ValueError(f"ends: want {get_args(Ends)} or EndDerivatives, got {ends!r}")
    conditions = _Conditions(
        np.concatenate((np.full(len(first), u[0]), u, np.full(len(last), u[-1]))),
        # the point first, then its derivatives; at the end mirrored
        np.concatenate(([0], orders_first, np.zeros(len(u) - 2), orders_last[::-1], [0])),
        np.vstack((points[:1], first, points[1:-1], last[::-1], points[-1:])),
    )
    if conditions.u.size <= degree:
        raise ValueError(
            f"points: want at least {degree + 1} points and end conditions for degree {degree}, "
            f"got {conditions.u.size}"
        )
    at_points = len(first) == len(last) == (degree - 1) // 2 and degree % 2 == 1
    inner = u[1:-1] if at_points else _averages(conditions.u, degree)
    if ends == "not-a-knot":
        if degree % 2 == 0:
            raise ValueError(f"degree: want an odd one for not-a-knot ends, got {degree}")
        inner = u[(degree + 1) // 2 : len(u) - (degree + 1) // 2]
    outer = np.full(degree + 1, 1.0)
    return conditions, np.concatenate((outer * u[0], inner, outer * u[-1]))


def _averages(u: FloatArray, degree: int) -> FloatArray:
    """Give inner knots that suit the parameters of all conditions."""
    # de Boor, A Practical Guide to Splines, 1978, ch. XIII; Piegl and Tiller, eq. 9.8
    if u.size == degree + 1:
        return np.empty(0)
    windows = np.lib.stride_tricks.sliding_window_view(u[1:-1], degree)
    means: FloatArray = windows.mean(axis=1)
    return means


def _interpolate_closed(points: FloatArray, u: FloatArray, degree: int) -> BSpline:
    """Give the closed curve whose knots are the parameters."""
    if degree % 2 == 0:
        raise ValueError(f"degree: want an odd one for a closed curve, got {degree}")
    m = len(points)
    ring = np.arange(m)
    frame = BSpline.closed(u, np.zeros((m, 1)), degree)
    spans = degree + ring
    rows = basis.basis_values(frame.knots, degree, spans, u[:-1])
    # row i has its largest entry in column i once the ring is turned by half the degree
    turned = banded.solve(ring - (degree - 1) // 2, rows, points, closed=True)
    return BSpline.closed(u, np.roll(turned, (degree - 1) // 2, axis=0), degree)


def interpolate_tangents(
    points: ArrayInput,
    tangents: ArrayInput,
    *,
    degree: int = 3,
    parameters: Parameters | ArrayInput = "chord",
    bends: ArrayInput | None = None,
) -> BSpline:
    """Give the B-spline that passes through points with given derivatives at every one of them.

    A cubic is C1. A quintic is C2 with given second derivatives; without them it is C3, the curve
    whose third derivative is least in the mean square.

    Args:
        points: Points to pass, shape (m, dim), of a closed curve the first again at the end.
        tangents: Derivatives by the parameter there, shape (m, dim); unit vectors suit "chord".
        degree: 3 or 5.
        parameters: How to choose the parameters, or the parameters themselves, rising, shape (m,).
        bends: Second derivatives there, shape (m, dim), for degree 5.

    Raises:
        CurveError: If two neighbours are the same point.
        ValueError: If shapes do not fit, the degree is another, or a cubic is to have bends.
    """
    array = frozen_array(points, (None, None), "points")
    slopes = frozen_array(tangents, array.shape, "tangents")
    if degree not in (3, 5) or (degree == 3 and bends is not None):
        raise ValueError(f"degree: want 3 without bends or 5, got {degree}")
    if len(array) < 2:
        raise ValueError(f"points: want at least 2, got {len(array)}")
    if isinstance(parameters, str):
        u = choose_parameters(array, cast(Parameters, parameters), degree=degree)
    else:
        u = frozen_array(parameters, (len(array),), "parameters")
        if (np.diff(u) <= 0.0).any():
            raise ValueError(f"parameters: want them rising, got {u.tolist()}")
    if degree == 3:
        return hermite.cubic_spline(u, array, slopes)
    if bends is not None:
        return hermite.quintic_spline(u, (array, slopes, frozen_array(bends, array.shape, "bends")))
    return _smoothest_quintic(u, array, slopes)


def _smoothest_quintic(u: FloatArray, points: FloatArray, slopes: FloatArray) -> BSpline:
    """Give the C3 quintic with given slopes whose third derivative vanishes at the ends."""
    knots = np.concatenate((np.full(4, u[0]), np.repeat(u, 2), np.full(4, u[-1])))
    # place and slope at every point, and the third derivative at both ends
    at = np.concatenate((u[:1], np.repeat(u, 2), u[-1:]))
    order = np.concatenate(([0.0, 1.0, 3.0], np.tile([0.0, 1.0], len(u) - 2), [3.0, 1.0, 0.0]))
    zero = np.zeros((1, points.shape[1]))
    both = np.stack((points, slopes), axis=1)
    last = both[-1, ::-1]
    values = np.vstack((both[0], zero, both[1:-1].reshape(-1, points.shape[1]), zero, last))
    spans = basis.find_spans(knots, 5, at)
    rows = basis.basis_values(knots, 5, spans, at, order)
    return BSpline(knots, banded.solve(spans - 5, rows, values), 5)
