"""Cumulative B-splines through given orientations."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves import banded, basis
from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion

from .rotation_bspline import RotationBSpline, cumulative_values, shorter
from .rotation_jacobian import inverse_jacobian, jacobian

_NEWTON_STEPS = 25
_STAGE_STEPS = 8
"""Most steps of Newton's method, for the whole and for each stage of a problem made harder."""

_STAGES = 60
"""Most stages."""

_LEAST_PART = 1e-3
"""How little of a step is worth trying."""

_LEAST_STAGE = 1e-3
"""How much harder a stage is at least."""

_EXACT = 1e-13
"""Misses, rad, that are rounding, times the root of their number."""

_CLOSE = 1e-11
"""Misses that are taken where no step improves on them."""


class EndRates(NamedTuple):
    """Angular velocities at the ends of an open curve, in the body, shape (3,); None: natural."""

    start: FloatArray | None = None
    """At the start."""
    end: FloatArray | None = None
    """At the end."""


def fit(
    u: FloatArray, quats: FloatArray, degree: int, *, closed: bool, rates: EndRates
) -> RotationBSpline:
    """Give the curve with knots at the parameters that passes orientations there.

    Args:
        u: Parameters, rising, shape (m,), of a closed curve (m + 1,).
        quats: Unit quaternions, shape (m, 4).
        degree: An odd degree.
        closed: Whether the curve returns to the first orientation.
        rates: What holds at the ends of an open curve.

    Raises:
        CurveError: If no such curve was found.
    """
    turns = shorter(np.vstack((quats, quats[:1])) if closed else quats)
    problem = _closed_problem(u, turns, degree) if closed else _problem(u, turns, degree, rates)
    try:
        found = _solve(problem)
        if found is None:
            raise _refusal(u, turns, degree)
        # a last step takes what is left of misses that were small enough to the rounding
        miss, matrix = _system(problem, found, 1.0)
        found = found - _linear(problem, matrix, miss)
    except np.linalg.LinAlgError as error:
        raise _refusal(u, turns, degree) from error
    if not closed:
        edge = np.ones(degree)
        knots = np.concatenate((edge * u[0], u, edge * u[-1]))
        return RotationBSpline(knots, quats[0], found, degree)
    # the ring of unknowns begins with the turn in the middle of the first piece
    ring = np.roll(found, degree // 2, axis=0)
    curve = RotationBSpline.of_ring(u, np.array((1.0, 0.0, 0.0, 0.0)), ring, degree)
    first = curve.at(u[:1]).quat[0]
    start = quaternion.multiply(quats[0], quaternion.conjugate(first))
    return RotationBSpline(curve.knots, quaternion.normalize(start), curve.turns, degree)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Problem:
    """Which turns between control orientations make each piece turn as it shall.

    Turns are the unknowns, not control orientations: they may become longer than a half turn, and
    what a piece turns depends on those alive there and on nothing before.
    """

    turns: FloatArray
    """By how much each piece shall turn, shape (k, 3)."""
    alive: basis.IndexArray
    """The unknowns alive on each piece, shape (k, degree)."""
    begin: FloatArray
    """Their cumulative basis functions where pieces start, shape (k, degree)."""
    end: FloatArray
    """The same where they end."""
    first: basis.IndexArray
    """Column of the first entry of each row of the linear system in blocks, shape (n,)."""
    before: "_EndRows"
    """Conditions at the start."""
    behind: "_EndRows"
    """Conditions at the end."""
    closed: bool
    """Whether unknowns wrap around."""

    @property
    def guess(self) -> FloatArray:
        """Control orientations at the given ones, and at the ends all in one, shape (n, 3)."""
        still = [np.zeros_like(rows.values) for rows in (self.before, self.behind)]
        return np.concatenate((still[0], self.turns, still[1]))

    @property
    def wanted(self) -> FloatArray:
        """What all conditions shall give, shape (n, 3)."""
        return np.concatenate((self.before.values, self.turns, self.behind.values))


class _EndRows(NamedTuple):
    """Linear conditions on the first or the last unknowns."""

    weights: FloatArray
    """Rows, shape (r, degree)."""
    values: FloatArray
    """What they shall give, shape (r, 3)."""


def _problem(u: FloatArray, turns: FloatArray, degree: int, rates: EndRates) -> _Problem:
    k = len(turns)
    edge = np.ones(degree)
    knots = np.concatenate((edge * u[0], u, edge * u[-1]))
    spans = degree + np.arange(k)
    extra = degree // 2
    before = _end_rows(knots, degree, spans[0], u[0], rates.start)
    behind = _end_rows(knots, degree, spans[-1], u[-1], rates.end)
    pieces = np.arange(k)
    first = np.concatenate((np.zeros(extra, int), pieces, np.full(extra, k - 1)))
    return _Problem(
        turns=turns,
        alive=pieces[:, None] + np.arange(degree),
        begin=cumulative_values(knots, degree, spans, u[:-1]),
        end=cumulative_values(knots, degree, spans, u[1:]),
        first=first,
        before=before,
        behind=_EndRows(behind.weights[::-1], behind.values[::-1]),
        closed=False,
    )


def _end_rows(
    knots: FloatArray, degree: int, span: int, u: float, rate: FloatArray | None
) -> _EndRows:
    """Give the conditions at an end: the highest derivatives vanish, or the first one is given.

    At a clamped end first and second derivative are linear in the turns, in the frames in which
    those are written. So are higher ones up to products of rates: what vanishes is the linear part.
    """
    # what is left free by the curve of least integral of the squared (degree + 1) / 2-th derivative
    orders = list(range((degree + 1) // 2, degree))
    values = np.zeros((len(orders), 3))
    if rate is not None:
        orders = [1, *orders[:-1]]
    weights = np.empty((len(orders), degree))
    for i, order in enumerate(orders):
        row = cumulative_values(knots, degree, np.array([span]), np.array([u]), order)[0]
        scale = np.abs(row).max()
        weights[i] = row / scale
        if rate is not None and order == 1:
            values[i] = rate / scale
    return _EndRows(weights, values)


def _closed_problem(u: FloatArray, turns: FloatArray, degree: int) -> _Problem:
    m = len(turns)
    pieces = np.arange(m)
    knots = BSpline.closed(u, np.zeros((m, 1)), degree).knots
    first = pieces - degree // 2
    nothing = _EndRows(np.zeros((0, degree)), np.zeros((0, 3)))
    return _Problem(
        turns=turns,
        alive=(first[:, None] + np.arange(degree)) % m,
        begin=cumulative_values(knots, degree, degree + pieces, u[:-1]),
        end=cumulative_values(knots, degree, degree + pieces, u[1:]),
        first=first,
        before=nothing,
        behind=nothing,
        closed=True,
    )


def _solve(problem: _Problem) -> FloatArray | None:
    """Give the unknowns, or None: at once, or by way of problems that turn less."""
    # of the many solutions, which differ by whole turns, only one that swings out no farther than
    # a spline of vectors would is the one wanted
    matrix = _system(problem, np.zeros_like(problem.guess), 0.0)[1]
    flat = _linear(problem, matrix, problem.wanted)
    farthest = 2.0 * float(np.linalg.norm(flat, axis=1).max()) + 2.0 * np.pi
    guess = problem.guess
    found = _newton(problem, guess, 1.0, _NEWTON_STEPS)
    if found is not None and np.linalg.norm(found, axis=1).max() <= farthest:
        return found
    share, step = 0.0, 0.25
    here, last = np.zeros_like(guess), None
    for _ in range(_STAGES):
        target = min(1.0, share + step)
        ahead = guess if last is None else (here - last[1]) / (share - last[0])
        stage = _newton(problem, here + (target - share) * ahead, target, _STAGE_STEPS)
        if stage is None or np.linalg.norm(stage, axis=1).max() > farthest:
            step *= 0.4
            if step < _LEAST_STAGE:
                break
            continue
        last, here, share = (share, here), stage, target
        step *= 1.6
        if share == 1.0:
            return stage
    return None


def _newton(problem: _Problem, x: FloatArray, share: float, steps: int) -> FloatArray | None:
    """Give the unknowns with which pieces turn ``share`` of what they shall, or None."""
    enough = _EXACT * np.sqrt(len(x))
    miss, matrix = _system(problem, x, share)
    norm = float(np.linalg.norm(miss))
    for _ in range(steps):
        try:
            step = _linear(problem, matrix, miss)
        except np.linalg.LinAlgError:
            break
        part = 1.0
        while part > _LEAST_PART:
            trial = x - part * step
            miss, matrix = _system(problem, trial, share)
            tried = float(np.linalg.norm(miss))
            if tried < norm * (1.0 - 0.1 * part) or tried < enough:
                x, norm = trial, tried
                break
            part *= 0.5
        if part <= _LEAST_PART or norm < enough:
            break
    return x if norm < _CLOSE else None


def _linear(problem: _Problem, matrix: FloatArray, miss: FloatArray) -> FloatArray:
    n = len(miss)
    first = np.repeat(3 * problem.first, 3)
    rows = matrix.reshape(3 * n, -1)
    solved = banded.solve(first, rows, miss.reshape(-1, 1), closed=problem.closed)
    return solved.reshape(-1, 3)


def _system(problem: _Problem, x: FloatArray, share: float) -> tuple[FloatArray, FloatArray]:
    """Give by how much each condition is missed, (n, 3), and its slopes, (n, 3, degree, 3)."""
    alive = x[problem.alive]
    start, start_slopes = _chain(alive, problem.begin)
    end, end_slopes = _chain(alive, problem.end)
    turned = quaternion.multiply(quaternion.conjugate(start), end)
    back = quaternion.to_matrix(quaternion.conjugate(turned))
    slopes = end_slopes - np.einsum("kab,kbjc->kajc", back, start_slopes)
    miss = quaternion.log(quaternion.multiply(quaternion.exp(-share * problem.turns), turned))
    slopes = np.einsum("kab,kbjc->kajc", inverse_jacobian(miss), slopes)
    if problem.closed:
        return miss, slopes
    ends = (problem.before, x[: slopes.shape[2]]), (problem.behind, x[len(x) - slopes.shape[2] :])
    missed = [rows.weights @ unknowns - share * rows.values for rows, unknowns in ends]
    weights = [np.einsum("rj,ab->rajb", rows.weights, np.eye(3)) for rows, _ in ends]
    return (
        np.concatenate((missed[0], miss, missed[1])),
        np.concatenate((weights[0], slopes, weights[1])),
    )


def _chain(turns: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give products of exp(share turn), (k, 4), and their slopes by the turns, in the body.

    The slopes have shape (k, 3, degree, 3).
    """
    k, degree, _ = turns.shape
    product = np.zeros((k, 4))
    product[:, 0] = 1.0
    slopes = np.empty((k, 3, degree, 3))
    for j in range(degree - 1, -1, -1):
        part = shares[:, j, None] * turns[:, j]
        back = quaternion.to_matrix(quaternion.conjugate(product))
        slopes[:, :, j] = back @ jacobian(part) * shares[:, j, None, None]
        product = quaternion.multiply(quaternion.exp(part), product)
    return product, slopes


def _refusal(u: FloatArray, turns: FloatArray, degree: int) -> CurveError:
    """Say where the orientations ask for the most."""
    steps, angles = np.diff(u), np.linalg.norm(turns, axis=1)
    # a piece is hard to pass that is long beside a neighbour that turns quickly
    rates = angles / steps
    beside = np.maximum(np.append(0.0, rates[:-1]), np.append(rates[1:], 0.0))
    i = int(np.argmax(steps * beside + angles))
    return CurveError(
        f"no smooth curve of degree {degree} was found: it would turn wildly between orientations "
        f"{i} and {i + 1} ({np.rad2deg(angles[i]):.4g} deg in {steps[i]:.4g} of the parameter, "
        f"beside {np.rad2deg(beside[i]):.4g} deg per unit); give one between them, or parameters "
        "more in proportion to the angles",
        "orientations",
    )
