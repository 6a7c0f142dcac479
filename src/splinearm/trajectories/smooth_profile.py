"""How a smooth speed profile is found, and how much of the limits it uses."""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

from .smooth_entry import kernels
from .smooth_placed import Placed
from .smooth_problem import Problem, slaves_of, tool_caps

_TRIES = ((1.4, 1, 0.6, 3.0), (0.7, 3, 0.3, 1.0), (0.2, 6, 0.3, 1.0), (0.02, 12, 1.0, 10.0))
"""How to begin: share of the guess, cells that it is smoothed over, least slack, centre."""

_GAP = 1e-7
"""By this share of the time a profile may be longer than the quickest on its grid ..."""

_FINE_GAP = 1e-10
"""... and by this one where a speed of the tool is wanted, which is then even to nine digits."""

_LEAST_SLACK = 1e-2
"""A slack begins anew with at least this when bounds have become narrower."""

_LEAST = 0.1
"""Where x would dip below zero, a coefficient is at least this share of the x beside it."""

_FINER_TOOL = 4

_VAGUE, _FINER = 1e-8, 16
"""Tops that may be misjudged by more than that are looked at in so many times as many places."""


_NEAR = 0.8
"""Share of a limit from which on it matters how high a top is."""

_CUBIC = 0.4
"""Share of the third difference by which a parabola may be off."""


class Answer(NamedTuple):
    """A profile."""

    coefficients: FloatArray
    """Of the quadratic B-spline x, shape (m + 2,)."""
    y: FloatArray
    """x, h x'/2 and h^2 x''/2 at the begin of each cell, shape (m, 3)."""
    slack: FloatArray
    """What rows leave of their bounds, shape (m, rows)."""
    multiplier: FloatArray
    """What their bounds cost, shape (m, rows)."""


def solve(problem: Problem, before: Answer | None = None) -> Answer | None:
    """Give the quickest profile, or None if there is none or it is not found.

    Args:
        problem: What is asked.
        before: The answer to a problem with other bounds, to go on from.
    """
    if before is not None:
        slack = np.maximum(before.slack, _LEAST_SLACK)
        multiplier = np.maximum(before.multiplier, 1e-3 * _GAP / slack.size / slack)
        answer = _improved(problem, before._replace(slack=slack, multiplier=multiplier))
        if answer is not None:
            return answer
    for share, width, floor, centre in _TRIES:
        guess = share * np.minimum(problem.guess, _smoothed(problem.guess, width))
        answer = _improved(problem, _begin(problem, guess, floor, centre))
        if answer is not None:
            return answer
    return None


def smoothed(problem: Problem, width: int) -> Answer:
    """Give a profile of the shape of the guess, smoothed over so many cells, however quick."""
    share, _, floor, centre = _TRIES[-1]
    guess = share * np.minimum(problem.guess, _smoothed(problem.guess, width))
    return _begin(problem, guess, floor, centre)


def tool_looks(problem: Problem, parts: int) -> FloatArray:
    """Give the highest x that the tool's speed allows where ``use_of`` looks at it, (m, k).

    The same for all problems on one grid; without a wish for the tool's speed there are none.
    """
    if problem.way.cap is None:
        return np.empty((len(problem.pieces), 0))
    return tool_caps(problem, np.linspace(0.0, 1.0, parts * _FINER_TOOL + 1))


def use_of(problem: Problem, answer: Answer, parts: int, tool: FloatArray) -> FloatArray:
    """Give the largest share of each kind of limits that a cell uses, shape (m, 4).

    They are x, acceleration, jerk, and torques and accelerations of the tool, whose use is the
    square of how much slower a cell must be to keep them.

    Args:
        problem: What was asked.
        answer: The profile.
        parts: In how many parts of each cell it is looked at, and more where it uses most.
        tool: What ``tool_looks`` gives for them.
    """
    path, look = problem.way.path, kernels().use_into
    use, chosen = np.zeros((len(problem.pieces), 4)), np.ones(len(problem.pieces))
    about = path.breaks, path.coefficients, problem.pieces, problem.share
    look(*about, problem.inverse, answer.y, chosen, float(parts), use)
    # where the top of a parabola may not be near enough to the top itself
    slower = slower_by(use * [1.0, 1.0, 1.0, 0.0])
    vague = (use[:, 3] > _VAGUE) & (slower + use[:, 3] > (slower - use[:, 3]).max())
    vague_cells = vague.astype(np.float64)
    look(*about, problem.inverse, answer.y, vague_cells, float(parts * _FINER), use)
    if tool.size:
        shares = np.linspace(0.0, 1.0, tool.shape[1])
        tops = _tops((_x_at(answer.y, shares) / tool)[:, :, None])
        use[:, 0] = np.maximum(use[:, 0], tops[:, 0])
    use[:, 3] = 0.0
    if problem.way.placed is not None:
        _look_at_placed(problem.way.placed, problem.share, answer.y, parts, use)
    return use


def _look_at_placed(
    placed: Placed, nodes: FloatArray, y: FloatArray, parts: int, use: FloatArray
) -> None:
    """Write what torques and the tool use of their limits to the columns of ``use``.

    Cells that may use most, as far as can be seen, are looked at again in more places.
    """
    found = _placed_use(placed, nodes, y, parts)
    near = np.maximum(found[:, 0], found[:, 1])
    vague = found[:, 2]
    again = np.flatnonzero((vague > _VAGUE) & (near + vague > (near - vague).max()))
    for run in np.split(again, np.flatnonzero(np.diff(again) > 1) + 1):
        if run.size:
            cells = slice(int(run[0]), int(run[-1]) + 1)
            ends = nodes[cells.start : cells.stop + 1]
            finer = _placed_use(placed, ends, y[cells], parts * _FINER)
            found[cells] = np.maximum(found[cells], finer)
    use[:, 0] = np.maximum(use[:, 0], found[:, 0])
    use[:, 3] = found[:, 1]


def _placed_use(placed: Placed, nodes: FloatArray, y: FloatArray, parts: int) -> FloatArray:
    """Give the use of speeds and of all else by cells, and by how much it may be misjudged."""
    shares = np.linspace(0.0, 1.0, parts + 1)
    rows, x = placed.rows(nodes, shares), np.maximum(_x_at(y, shares), 0.0)
    u = (y[:, 1:2] + y[:, 2:] * shares) / np.diff(nodes)[:, None]
    speeds, others = (rows.square * x)[:, :, None], rows.slower(u, x)
    both = np.concatenate((speeds, others), axis=2)
    bends = np.where(both.max(axis=1) > _NEAR, np.abs(np.diff(both, 3, axis=1)).max(axis=1), 0.0)
    return np.stack(
        (
            _tops(speeds)[:, 0],
            _tops(others).max(axis=1, initial=0.0),
            _CUBIC * bends.max(axis=1),
        ),
        axis=1,
    )


def _x_at(y: FloatArray, shares: FloatArray) -> FloatArray:
    """Give x at shares of cells, shape (m, k)."""
    x: FloatArray = y @ np.stack((np.ones_like(shares), 2.0 * shares, shares**2))
    return x


def _tops(use: FloatArray) -> FloatArray:
    """Give how high something at even shares of cells, shape (m, k, uses), rises, (m, uses).

    Between three neighbours it is taken for the parabola through them.
    """
    middle = use[:, 1:-1]
    bend, tilt = use[:, 2:] - 2.0 * middle + use[:, :-2], 0.5 * (use[:, 2:] - use[:, :-2])
    between = (bend < 0.0) & (np.abs(tilt) < -bend)
    tops = np.where(between, middle - 0.5 * tilt * tilt / np.where(between, bend, 1.0), 0.0)
    highest: FloatArray = np.maximum(use.max(axis=1), tops.max(axis=1))
    return highest


def slower_by(use: FloatArray) -> FloatArray:
    """Give by what factor each cell must become slower to stay within limits, shape (m,)."""
    slower: FloatArray = np.maximum(np.sqrt(use[:, [0, 1, 3]].max(axis=1)), np.cbrt(use[:, 2]))
    return slower


def _coefficients(problem: Problem, x: FloatArray) -> FloatArray:
    """Give the coefficients of about these x at the nodes, right at the ends."""
    share = problem.share
    middles = 0.5 * (np.append(share[:1], share) + np.append(share, share[-1:]))
    d = np.interp(middles, share, x)
    slaves = slaves_of(problem)
    for k, (end, slave) in enumerate(zip(problem.ends, slaves, strict=True)):
        outer, inner = (0, 1) if k == 0 else (-1, -2)
        if slave > 0.0:
            d[outer] = slave * d[inner]
            continue
        h = float(share[1] - share[0]) if k == 0 else float(share[-2] - share[-1])
        length = float(problem.launches[k])
        d[outer] = 2.0 * abs(end.acceleration) * length if length > 0.0 else end.speed**2
        d[inner] = d[outer] + end.acceleration * h
    return d


def _begin(problem: Problem, guess: FloatArray, floor: float, centre: float) -> Answer:
    """Give where to begin: near a guess, with slacks of at least ``floor``."""
    d = _coefficients(problem, guess)
    _, y, slack = _measured(problem, d)
    slack = np.maximum(slack, floor)
    time = float((np.diff(problem.share) / np.sqrt(y[:, 0])).sum())
    return Answer(d, y, slack, centre * time / slack.size / slack)


def _measured(problem: Problem, d: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give the maps from coefficients to y, y, and what rows leave of their bounds."""
    h, cells = np.diff(problem.share), len(problem.pieces)
    maps, y = np.empty((cells, 3, 3)), np.empty((cells, 3))
    placed = problem.lines.shape[1] + problem.cones.shape[1]
    slack = np.empty((cells, 2 * problem.rows.shape[1] + 3 + placed))
    bounds = problem.rows, problem.bounds, problem.caps, problem.lines, problem.cones
    kernels().begin_into(h, np.array(slaves_of(problem)), d, *bounds, maps, y, slack)
    return maps, y, slack


def _improved(problem: Problem, begin: Answer) -> Answer | None:
    """Give what the solver makes of a begin, or None if it does not succeed."""
    d = begin.coefficients.copy()
    slack, multiplier = begin.slack.copy(), begin.multiplier.copy()
    maps, y, _ = _measured(problem, d)
    slaves = slaves_of(problem)
    held = np.zeros(d.size)
    for k, slave in enumerate(slaves):
        outer, inner = (0, 1) if k == 0 else (-1, -2)
        held[outer] = 1.0
        held[inner] = 0.0 if slave > 0.0 else 1.0
    free = problem.launches * [slave > 0.0 for slave in slaves]
    goal = _GAP if problem.way.cap is None else _FINE_GAP
    bounds = problem.rows, problem.bounds, problem.caps, problem.lines, problem.cones
    about = np.diff(problem.share), free, maps, held, *bounds
    if not kernels().improve(*about, goal, d, slack, multiplier, y, np.empty(5)):
        return None
    # between where the solver looks x may still dip below zero; it cannot with no coefficient there
    x, u, c = y.T
    if ((c > 0.0) & (u < 0.0) & (-u < c) & (x * c <= u * u)).any():
        ends = np.append(x, x[-1] + 2.0 * u[-1] + c[-1])
        least = _LEAST * np.minimum(np.append(ends[:1], ends), np.append(ends, ends[-1:]))
        d[2:-2] = np.maximum(d, least)[2:-2]
        y = _measured(problem, d)[1]
    return Answer(d, y, slack, multiplier)


def _smoothed(x: FloatArray, width: int) -> FloatArray:
    """Give the least of so many neighbours on either side, then their mean."""
    for reduce in (np.min, np.mean):
        padded = np.pad(x, width, mode="edge")
        windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * width + 1)
        x = reduce(windows, axis=1)
    return x
