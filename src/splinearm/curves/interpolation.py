"""B-splines through given points."""

from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import banded, basis
from .bspline import BSpline

Parameters = Literal["chord", "centripetal", "uniform"]
"""How parameters are chosen for points: by distance, by its square root, or evenly."""

Ends = Literal["natural", "free", "closed"]
"""Natural: the highest derivatives vanish at the ends. Free: no condition. Closed: a loop."""


@dataclass(frozen=True, slots=True, eq=False)
class EndDerivatives:
    """The first, second ... derivatives by the parameter that a curve shall have at its ends."""

    start: FloatArray
    """At the start, first derivative first, shape (a, dim); a may be 0."""
    end: FloatArray
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
    points: ArrayInput, kind: Parameters = "chord", *, closed: bool = False
) -> FloatArray:
    """Give rising parameters for points, starting at 0.

    Args:
        points: Points, shape (m, dim).
        kind: "chord": distances add up, so that the parameter is nearly arc length;
            "centripetal": their square roots do, which keeps sharp turns tame (Lee, Choosing
            nodes in parametric curve interpolation, CAD 21, 1989); "uniform": 0, 1, 2 ...
        closed: Whether the way from the last point back to the first counts as well; then there
            is one parameter more than points.

    Raises:
        CurveError: If two neighbours are the same point.
        ValueError: If the kind is none of these.
    """
    array = frozen_array(points, (None, None), "points")
    if closed:
        array = np.vstack((array, array[:1]))
    chords = np.linalg.norm(np.diff(array, axis=0), axis=1)
    if kind not in ("chord", "centripetal", "uniform"):
        raise ValueError(f"parameters: want chord, centripetal or uniform, got {kind!r}")
    if kind == "uniform":
        return np.arange(len(array), dtype=np.float64)
    if (chords <= 0.0).any():
        i = int(np.argmin(chords))
        raise CurveError(
            f"points {i} and {(i + 1) % (len(array) - closed)} are the same; take one out",
            "interpolation",
        )
    steps = chords if kind == "chord" else np.sqrt(chords)
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
        u = choose_parameters(array, cast(Parameters, parameters), closed=closed)
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
    elif ends in ("natural", "free"):
        if ends == "natural" and (degree % 2 == 0 or len(u) < (degree + 1) // 2):
            raise ValueError(
                f"degree: want an odd one below {2 * len(u)} for natural ends of {len(u)} points, "
                f"got {degree}"
            )
        count = (degree - 1) // 2 if ends == "natural" else 0
        first = last = np.zeros((count, dim))
        orders_first = orders_last = np.arange(degree - count, degree)
    else:
        raise ValueError(f"ends: want natural, free, closed or EndDerivatives, got {ends!r}")
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
