"""B-splines near points: least squares with a given number of control points or given knots."""

from typing import Literal, cast

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import basis, form, least
from .bspline import BSpline
from .interpolation import EndDerivatives, Parameters, choose_parameters
from .least import Frame

FitEnds = Literal["kept", "free", "closed"]
"""Kept: the first and last point are met exactly. Free: no condition. Closed: a loop."""

_SETTLED = 1e-3
"""Parameters are right once a round lowers the error by less than this share."""


def fit(
    points: ArrayInput,
    control: int | ArrayInput,
    *,
    degree: int = 3,
    parameters: Parameters | ArrayInput = "chord",
    weights: ArrayInput | None = None,
    ends: FitEnds | EndDerivatives = "kept",
) -> BSpline:
    """Give the B-spline that misses points at their parameters by the least sum of squares.

    Args:
        points: Points, shape (k, dim); of a closed curve each once.
        control: How many control points, or the knots: clamped ones from the first to the last
            parameter, of a closed curve those of one turn.
        degree: Degree, at least 1.
        parameters: How to choose the parameters, or the parameters themselves, rising, shape
            (k,), of a closed curve (k + 1,).
        weights: What the square of each miss counts, each 0 or more, shape (k,); None: 1.
        ends: What holds at the ends: with ``EndDerivatives`` the first and last point are met,
            with these derivatives.

    Raises:
        CurveError: If two neighbours are the same point, or some control points have no points
            near.
        ValueError: If the numbers of points, parameters, weights and knots do not fit.
    """
    array = frozen_array(points, (None, None), "points")
    u = parameters_of(array, parameters, closed=ends == "closed", degree=degree)
    share = root_weights(weights, len(array))
    frame = frame_of(array, u, control, degree, ends)
    return _fitted(frame, array, u, share)


def correct_parameters(curve: BSpline, points: ArrayInput, parameters: ArrayInput) -> FloatArray:
    """Give parameters moved towards the feet of points on a curve, in their order, shape (k,).

    One step of Newton each, at most half-way to its neighbours, none beyond the first and last.

    Args:
        curve: The curve.
        points: Points near the curve, shape (k, dim).
        parameters: Their parameters, never falling, in the domain, shape (k,).

    Raises:
        CurveError: If a parameter lies outside the domain.
        ValueError: If shapes do not fit.
    """
    array = frozen_array(points, (None, curve.dim), "points")
    u = frozen_array(parameters, (len(array),), "parameters")
    jets = curve.jet(u, 2)
    return np.asarray(moved_parameters(jets, array, u, (u[0], u[-1])), dtype=np.float64)


def fit_corrected(
    points: ArrayInput,
    control: int | ArrayInput,
    *,
    degree: int = 3,
    weights: ArrayInput | None = None,
    ends: FitEnds | EndDerivatives = "kept",
    rounds: int = 50,
) -> tuple[BSpline, FloatArray]:
    """Give a B-spline that misses points by little wherever it is nearest to them.

    Fitting and moving the parameters to the nearest places take turns, from the chords' lengths
    on, until the error no longer falls.

    Args:
        points: Points, shape (k, dim); of a closed curve each once.
        control: How many control points, or the knots, as for ``fit``.
        degree: Degree, at least 1.
        weights: What the square of each miss counts, each 0 or more, shape (k,); None: 1.
        ends: What holds at the ends, as for ``fit``.
        rounds: How many turns at most, at least 1.

    Returns:
        The curve, and the parameters of the points, of a closed curve with its end, shape (k,) or
        (k + 1,).

    Raises:
        CurveError: As ``fit``.
        ValueError: As ``fit``.
    """
    # Hoschek, Intrinsic parametrization for approximation, CAGD 5 (1988) 27
    if rounds < 1:
        raise ValueError(f"rounds: want at least 1, got {rounds}")
    array = frozen_array(points, (None, None), "points")
    closed = ends == "closed"
    u = parameters_of(array, "chord", closed=closed, degree=degree)
    share = root_weights(weights, len(array))
    frame = frame_of(array, u, control, degree, ends)
    best, error = (_fitted(frame, array, u, share), u), np.inf
    for _ in range(rounds):
        curve, used = best[0], best[1]
        jets = curve.jet(used[: len(array)], 2)
        now = float(((share[:, None] * (jets[:, 0] - array)) ** 2).sum())
        if not now < error * (1.0 - _SETTLED):
            break
        error = now
        moved = moved_parameters(
            jets, array, used[: len(array)], (float(u[0]), float(u[-1])), ring=closed
        )
        following = np.append(moved, u[-1]) if closed else moved
        try:
            candidate = _fitted(frame, array, following, share)
        except CurveError:
            # so many points left some knots that their control points are no longer determined
            break
        miss = candidate.at(moved) - array
        if float(((share[:, None] * miss) ** 2).sum()) >= now:
            break
        best = candidate, following
    return best


def moved_parameters(
    jets: FloatArray,
    points: FloatArray,
    u: FloatArray,
    ends: tuple[float, float],
    *,
    ring: bool = False,
) -> FloatArray:
    """Give parameters after a step towards the feet, never falling, from one end to the other."""
    gap, slope = points - jets[:, 0], jets[:, 1]
    square = (slope * slope).sum(axis=1)
    bent = square - (gap * jets[:, 2]).sum(axis=1)
    pull = (gap * slope).sum(axis=1)
    # where the curve bends too much around the point, Newton would lead to the farthest place
    bent = np.where(bent > 0.1 * square, bent, square)
    step = np.divide(pull, bent, out=np.zeros_like(u), where=bent > 0.0)
    edge = np.concatenate((u[:1], u, [ends[1]] if ring else u[-1:]))
    step = np.clip(step, 0.5 * (edge[:-2] - u), 0.5 * (edge[2:] - u))
    moved: FloatArray = np.clip(u + step, *ends)
    return moved


def parameters_of(
    points: FloatArray, parameters: Parameters | ArrayInput, *, closed: bool, degree: int
) -> FloatArray:
    """Give checked parameters of points, of a closed curve one more."""
    if len(points) < 2:
        raise ValueError(f"points: want at least 2, got {len(points)}")
    if degree < 1:
        raise ValueError(f"degree: want at least 1, got {degree}")
    if isinstance(parameters, str):
        return choose_parameters(points, cast(Parameters, parameters), closed=closed, degree=degree)
    u = frozen_array(parameters, (len(points) + closed,), "parameters")
    if (np.diff(u) < 0.0).any() or not u[0] < u[-1]:
        raise ValueError(f"parameters: want them rising, got {u.tolist()}")
    return u


def root_weights(weights: ArrayInput | None, count: int) -> FloatArray:
    """Give the roots of checked weights, shape (count,)."""
    if weights is None:
        return np.ones(count)
    array = frozen_array(weights, (count,), "weights")
    if not ((array >= 0.0).all() and array.any()):
        raise ValueError(f"weights: want them 0 or more and not all 0, got {array.tolist()}")
    root: FloatArray = np.sqrt(array)
    return root


def frame_of(
    points: FloatArray,
    u: FloatArray,
    control: int | ArrayInput,
    degree: int,
    ends: FitEnds | EndDerivatives,
) -> Frame:
    """Give the curves to choose from: their knots, and the control points that the ends fix."""
    none = np.empty((0, points.shape[1]))
    if ends == "closed":
        turn = _turn(u, control, degree)
        return Frame(form.wrapped_knots(turn, degree), degree, none, none, closed=True)
    knots = _clamped(u, control, degree)
    if isinstance(ends, EndDerivatives):
        first = _end_points(knots, degree, points[0], ends.start, 0)
        last = _end_points(knots, degree, points[-1], ends.end, -1)
        if len(first) + len(last) > len(knots) - degree - 1:
            raise ValueError(
                f"control: want at least {len(first) + len(last)} control points for these ends, "
                f"got {len(knots) - degree - 1}"
            )
        return Frame(knots, degree, first, last)
    if ends not in ("kept", "free"):
        raise ValueError(f"ends: want kept, free, closed or EndDerivatives, got {ends!r}")
    kept = ends == "kept"
    return Frame(knots, degree, points[: int(kept)], points[len(points) - kept :])


def _fitted(frame: Frame, points: FloatArray, u: FloatArray, share: FloatArray) -> BSpline:
    wanted = least.equations(frame, u[: len(points)], points)
    if not (share == 1.0).all():
        wanted = wanted.scaled(share)
    if frame.unknowns == 0:
        return BSpline(frame.knots, frame.all_points(np.empty((0, points.shape[1]))), frame.degree)
    found = least.solve(frame, wanted).found
    return BSpline(frame.knots, frame.all_points(found), frame.degree)


def _clamped(u: FloatArray, control: int | ArrayInput, degree: int) -> FloatArray:
    if isinstance(control, int | np.integer):
        if control <= degree:
            raise ValueError(f"control: want at least {degree + 1} for degree {degree}")
        inner = spread_knots(u, int(control) - degree)
        return np.concatenate((np.full(degree + 1, u[0]), inner, np.full(degree + 1, u[-1])))
    knots = frozen_array(control, (None,), "control")
    ends = len(knots) > 2 * degree + 1 and (
        (knots[: degree + 1] == u[0]).all() and (knots[-degree - 1 :] == u[-1]).all()
    )
    if not ends or (np.diff(knots) < 0.0).any():
        raise ValueError(
            f"control: want knots rising from {u[0]} to {u[-1]}, each {degree + 1} times, got "
            f"{knots.tolist()}"
        )
    return knots


def _turn(u: FloatArray, control: int | ArrayInput, degree: int) -> FloatArray:
    if isinstance(control, int | np.integer):
        if control <= degree:
            raise ValueError(f"control: want at least {degree + 1} for degree {degree}")
        return np.concatenate((u[:1], spread_knots(u, int(control)), u[-1:]))
    turn = frozen_array(control, (None,), "control")
    if len(turn) < degree + 2 or (turn[0], turn[-1]) != (u[0], u[-1]) or (np.diff(turn) < 0).any():
        raise ValueError(
            f"control: want at least {degree + 2} knots of one turn, rising from {u[0]} to "
            f"{u[-1]}, got {turn.tolist()}"
        )
    return turn


def spread_knots(u: FloatArray, spans: int) -> FloatArray:
    """Give inner knots so that as many parameters lie in each span, shape (spans - 1,)."""
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, eq. 9.68 and 9.69
    at = len(u) / spans * np.arange(1, spans)
    i = np.clip(at.astype(np.intp), 1, len(u) - 1)
    share = np.clip(at - i, 0.0, 1.0)
    inner: FloatArray = (1.0 - share) * u[i - 1] + share * u[i]
    return inner


def _end_points(
    knots: FloatArray, degree: int, point: FloatArray, derivatives: FloatArray, side: int
) -> FloatArray:
    """Give the control points that an end and its derivatives fix."""
    dim = len(point)
    given = derivatives.reshape(-1, dim) if derivatives.size == 0 else derivatives
    if given.shape[1] != dim or len(given) > degree:
        raise ValueError(
            f"ends: want at most {degree} derivatives of {dim} coordinates, got {given.shape}"
        )
    count = len(given) + 1
    u = np.full(count, knots[side])
    spans = basis.find_spans(knots, degree, u)
    rows = basis.basis_values(knots, degree, spans, u, np.arange(count, dtype=np.float64))
    rows = rows[:, :count] if side == 0 else rows[:, -count:]
    wanted = np.vstack((point[None], given))
    # rows as large as each other: those of derivatives follow the scale of the parameter
    scale = np.abs(rows).max(axis=1, keepdims=True)
    return np.asarray(np.linalg.solve(rows / scale, wanted / scale), dtype=np.float64)
