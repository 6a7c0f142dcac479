"""Smoothing splines: near points, and as little bent as their noise allows."""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, frozen_array
from splinearm.errors import CurveError

from . import least
from .bspline import BSpline
from .fit import frame_of, parameters_of, root_weights
from .interpolation import Parameters
from .least import Equations, Frame, Solved

_FREEDOM = 1e-3
"""Below this share of the points left to noise, what is left is taken for rounding."""

_PER_DECADE = 2
_ROUNDS = 40
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


class _Problem(NamedTuple):
    """A curve that is to be near points and little bent."""

    frame: Frame
    near: Equations
    straight: Equations

    def solved(self, stiffness: float) -> Solved:
        root = np.full(len(self.straight.rows), np.sqrt(stiffness))
        return least.solve(self.frame, self.near, self.straight.scaled(root))


def smooth(
    points: ArrayInput,
    stiffness: float | None = None,
    *,
    degree: int = 3,
    parameters: Parameters | ArrayInput = "chord",
    weights: ArrayInput | None = None,
    closed: bool = False,
) -> BSpline:
    """Give the smoothing spline of points: the curve for which a sum of two aims is least.

    It is the sum of weight times squared miss, plus the stiffness times the integral of the
    squared second derivative by the parameter. With degree 3 no other function has less.

    Args:
        points: Points, shape (k, dim); of a closed curve each once.
        stiffness: What being bent counts, above 0; None: what ``choose_stiffness`` gives.
        degree: Degree, at least 2; there is a knot at every point.
        parameters: How to choose the parameters, or the parameters themselves, rising, shape
            (k,), of a closed curve (k + 1,).
        weights: What the square of each miss counts, each 0 or more, shape (k,); None: 1.
        closed: Whether the curve is a loop.

    Raises:
        CurveError: If two neighbours are the same point, or the stiffness is so small or so large
            that rounding hides one of both aims.
        ValueError: If the numbers of points, parameters and weights do not fit.
    """
    problem = _problem(points, degree, parameters, weights, closed=closed)
    chosen = _best_stiffness(problem) if stiffness is None else stiffness
    if not (chosen > 0.0 and np.isfinite(chosen)):
        raise ValueError(f"stiffness: want it above 0, got {stiffness}")
    frame = problem.frame
    return BSpline(frame.knots, frame.all_points(problem.solved(chosen).found), degree)


def choose_stiffness(
    points: ArrayInput,
    *,
    degree: int = 3,
    parameters: Parameters | ArrayInput = "chord",
    weights: ArrayInput | None = None,
    closed: bool = False,
) -> float:
    """Give the stiffness that generalised cross validation finds best for noisy points.

    Each point is left out in turn and predicted from the others; the noise of all coordinates is
    taken for equal.

    Args:
        points: As for ``smooth``.
        degree: As for ``smooth``.
        parameters: As for ``smooth``.
        weights: As for ``smooth``.
        closed: As for ``smooth``.

    Raises:
        CurveError: If two neighbours are the same point.
        ValueError: If the numbers of points, parameters and weights do not fit.
    """
    return _best_stiffness(_problem(points, degree, parameters, weights, closed=closed))


def _problem(
    points: ArrayInput,
    degree: int,
    parameters: Parameters | ArrayInput,
    weights: ArrayInput | None,
    *,
    closed: bool,
) -> _Problem:
    array = frozen_array(points, (None, None), "points")
    if degree < 2:
        raise ValueError(f"degree: want at least 2, got {degree}")
    u = parameters_of(array, parameters, closed=closed, degree=degree)
    if len(array) < 3 or (closed and len(array) <= degree):
        raise ValueError(f"points: want at least {degree + 1 if closed else 3}, got {len(array)}")
    if (np.diff(u) <= 0.0).any():
        raise ValueError(f"parameters: want them rising, got {u.tolist()}")
    if closed:
        frame = frame_of(array, u, u, degree, "closed")
    else:
        knots = np.concatenate((np.full(degree, u[0]), u, np.full(degree, u[-1])))
        frame = frame_of(array, u, knots, degree, "free")
    share = root_weights(weights, len(array))
    near = least.equations(frame, u[: len(array)], array).scaled(share)
    # Gauss' rule is exact for the square of a second derivative
    nodes, counts = np.polynomial.legendre.leggauss(degree - 1)
    half = 0.5 * np.diff(u)[:, None]
    places = (0.5 * (u[:-1] + u[1:])[:, None] + half * nodes).ravel()
    zero = np.zeros((len(places), array.shape[1]))
    bent = least.equations(frame, places, zero, 2).scaled(np.sqrt((half * counts).ravel()))
    return _Problem(frame, near, bent)


def _best_stiffness(problem: _Problem) -> float:
    """Give the stiffness of the least score: the best of many, then golden section around it."""
    # what smooths over a length l counts as much as points that are so dense: count / range l^4.
    # Lengths from a third of the mean step to twice the range are looked at
    frame, count = problem.frame, len(problem.near.rows)
    start, end = frame.knots[frame.degree], frame.knots[-frame.degree - 1]
    unit = count * (end - start) ** 3 * float((problem.near.rows.sum(axis=1) ** 2).mean())
    least_power = -4.0 * np.log10(3.0 * count)
    powers = np.linspace(least_power, 1.0, int(_PER_DECADE * (1.0 - least_power)) + 2)
    scores = [_score(problem, unit * 10.0**p) for p in powers]
    if not np.isfinite(min(scores)):
        raise CurveError("rounding hides what being bent counts; choose the stiffness", "smoothing")
    best = int(np.argmin(scores))
    low, high = powers[max(best - 1, 0)], powers[min(best + 1, len(powers) - 1)]
    inner = [high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)]
    found = [_score(problem, unit * 10.0**p) for p in inner]
    for _ in range(_ROUNDS):
        if high - low < 1e-3:
            break
        if found[0] <= found[1]:
            high, inner[1], found[1] = inner[1], inner[0], found[0]
            inner[0] = high - _GOLDEN * (high - low)
            found[0] = _score(problem, unit * 10.0 ** inner[0])
        else:
            low, inner[0], found[0] = inner[0], inner[1], found[1]
            inner[1] = low + _GOLDEN * (high - low)
            found[1] = _score(problem, unit * 10.0 ** inner[1])
    return float(unit * 10.0 ** (0.5 * (low + high)))


def _score(problem: _Problem, stiffness: float) -> float:
    """Give the score of generalised cross validation."""
    # Craven and Wahba, Smoothing noisy data with spline functions, Numer. Math. 31 (1979) 377;
    # the trace from the middle of the inverse: Hutchinson and de Hoog, Numer. Math. 47 (1985) 99
    try:
        solved = problem.solved(stiffness)
    except CurveError:
        return np.inf
    near = problem.near
    column = near.first[:, None].astype(np.intp) + np.arange(near.rows.shape[1])
    fitted = np.einsum("kj,kjd->kd", near.rows, solved.found[column % len(solved.found)])
    count = len(near.rows)
    free = 1.0 - least.influence(solved, near).sum() / count
    if free <= _FREEDOM:
        return np.inf
    return float(((near.values - fitted) ** 2).sum() / count / free**2)
