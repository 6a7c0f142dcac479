"""What is asked of a smooth time law on a grid: bounds on its speed profile, cell by cell.

All of it in shares of the way and of the time that the way takes about. With x the square of the
speed, a cell of length h is y = (x, h x'/2, h^2 x''/2) at its begin; see ``smooth_kernel``.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

from . import smooth_grid
from .smooth_entry import kernels
from .smooth_grid import Estimate, Way
from .smooth_placed import Placed

_LAUNCH_LOOKS = np.linspace(0.0, 1.0, 33)
"""Where in a launch its limits are looked at."""

_FIRST_CHANGE = 0.2
"""By at most this share a given acceleration changes a given x within the first cell."""


_LEAST_ROOM = 1e-6
"""At least this share of a torque is left for moving."""

_TRIFLE = 1e-7
"""By this share bounds are lowered further than they need to be."""


class End(NamedTuple):
    """How fast the way begins or ends."""

    speed: float
    """ds/dt, not below zero."""
    acceleration: float
    """d2s/dt2."""

    @property
    def is_rest(self) -> bool:
        """Whether nothing moves there, nor begins to at once."""
        return self.speed == 0.0 and self.acceleration == 0.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Problem:
    """What is asked of a profile on a grid."""

    way: Way
    """What is to be timed."""
    unit: float
    """The unit of the time, s."""
    ends: tuple[End, End]
    """How it begins and ends, by the share of the way and the unit of time."""
    share: FloatArray
    """Nodes, shape (m + 1,), without the launch from rest before and the landing behind them."""
    launches: FloatArray
    """Lengths of launch and landing, 0 where there is none, shape (2,)."""
    inverse: FloatArray
    """1 / limits of velocity, acceleration and jerk, shape (3, n)."""
    pieces: FloatArray
    """To which piece of the path each cell belongs, shape (m,)."""
    rows: FloatArray
    """Rows of accelerations and jerks, shape (m, 4 n, 3)."""
    caps: FloatArray
    """Highest x at the begin, middle and end of each cell, shape (m, 3)."""
    bounds: FloatArray
    """What the rows may reach: acceleration, jerk at the begin and the end, shape (m, 3)."""
    lines: FloatArray
    """Rows of torques, as the solver takes them, shape (m, k, 6)."""
    cones: FloatArray
    """Pairs of rows of accelerations of the tool, shape (m, l, 6)."""
    guess: FloatArray
    """About what x will be at the nodes, shape (m + 1,)."""


def pose(way: Way, guess: Estimate, ends: tuple[End, End], cells: int) -> Problem:
    """Give the problem on about so many cells.

    Args:
        way: What is to be timed.
        guess: About how fast it can be passed.
        ends: How it begins and ends, by the share of the way and seconds.
        cells: About how many cells there shall be.
    """
    unit = float(guess.t[-1])
    if way.placed is not None:
        way = way._replace(placed=replace(way.placed, unit=way.placed.unit * unit))
    ends = (_in_unit(ends[0], unit), _in_unit(ends[1], unit))
    share = smooth_grid.nodes(way, guess, cells, (_first_cell(ends[0]), _first_cell(ends[1])))
    launched = [end.speed == 0.0 for end in ends]
    launches = np.array([share[1], 1.0 - share[-2]]) * launched
    share = share[int(launched[0]) : len(share) - int(launched[1])]
    units = unit ** np.arange(1.0, 4.0)[:, None]
    inverse = np.ascontiguousarray(1.0 / (way.limits * units))
    x = np.interp(share, guess.share, guess.x) * unit**2
    h = np.diff(share)
    middles = 0.5 * (share[1:] + share[:-1])
    pieces = way.path.pieces_of(middles).astype(np.float64)
    root = np.sqrt(x)
    bounds = np.stack((np.ones(h.size), root[:-1], root[1:]), axis=1)
    rows, caps = np.empty((h.size, 4 * inverse.shape[1], 3)), np.empty((h.size, 3))
    problem = Problem(
        way=way,
        unit=unit,
        ends=ends,
        share=share,
        launches=launches,
        inverse=inverse,
        pieces=pieces,
        rows=rows,
        caps=caps,
        bounds=bounds,
        lines=np.empty((h.size, 0, 6)),
        cones=np.empty((h.size, 0, 6)),
        guess=x,
    )
    _fill(problem)
    return problem if way.placed is None else _with_placed(problem, way.placed)


def tightened(problem: Problem, use: FloatArray, times: float) -> Problem:
    """Give the problem with lower bounds in those cells that break a limit.

    Args:
        problem: What was asked.
        use: How much of x, acceleration, jerk and other limits each cell uses, shape (m, 4).
        times: How many times the excess bounds are lowered.
    """
    shrink = 1.0 / np.where(use > 1.0 + 0.5 * _TRIFLE, 1.0 + times * (use - 1.0) + _TRIFLE, 1.0)
    # the acceleration at the begin of a cell is bounded by the rows of the cell before
    for k in (1, 3):
        shrink[:-1, k] = np.minimum(shrink[:-1, k], shrink[1:, k])
    bounds = np.ascontiguousarray(problem.bounds * shrink[:, [1, 2, 2]])
    caps = problem.caps * shrink[:, :1]
    if problem.way.cap is not None:
        # a cell ends as fast as it may: the one beside it shall not be slower for its sake
        caps[:, ::2] = problem.caps[:, ::2]
    lines = problem.lines.copy()
    lines[:, :, 4] *= shrink[:, 3:]
    cones = problem.cones / shrink[:, 3:, None]
    return replace(problem, caps=caps, bounds=bounds, lines=lines, cones=cones)


def _in_unit(end: End, unit: float) -> End:
    return End(end.speed * unit, end.acceleration * unit**2)


def _first_cell(end: End) -> float | None:
    """Give how long the outermost cell may be: a given acceleration changes x only little there."""
    if end.is_rest:
        return None
    if end.acceleration == 0.0 or end.speed == 0.0:
        return 1.0
    return _FIRST_CHANGE * end.speed**2 / abs(end.acceleration)


def _fill(problem: Problem) -> None:
    """Write the problem's rows and caps."""
    path, caps = problem.way.path, problem.caps
    kernels().rows_into(
        path.breaks,
        path.coefficients,
        problem.pieces,
        problem.share,
        problem.inverse,
        np.ascontiguousarray(problem.bounds[:, 1:]),
        problem.rows,
        caps,
    )
    np.minimum(caps, smooth_grid.FARTHEST**2, out=caps)
    np.minimum(caps, tool_caps(problem, np.linspace(0.0, 1.0, 3)), out=caps)
    if problem.ends[0].is_rest:
        caps[0, 0] = min(caps[0, 0], _launch_cap(problem, 0))
    if problem.ends[1].is_rest:
        caps[-1, 2] = min(caps[-1, 2], _launch_cap(problem, 1))


def tool_caps(problem: Problem, shares: FloatArray) -> FloatArray:
    """Give the highest x that the tool's speed allows at shares of each cell, (m, k)."""
    way, nodes = problem.way, problem.share
    if way.cap is None:
        return np.full((len(nodes) - 1, len(shares)), np.inf)
    at = nodes[:-1, None] + np.diff(nodes)[:, None] * shares
    rate = way.cap.rate(at.ravel()).reshape(at.shape)
    with np.errstate(divide="ignore"):
        caps: FloatArray = (way.cap.between(nodes)[:, None] / rate * problem.unit) ** 2
    return caps


def _with_placed(problem: Problem, placed: Placed) -> Problem:
    """Give the problem with torques and what the tool does half-way and at the end of cells."""
    h = np.diff(problem.share)[:, None]
    shares = np.linspace(0.0, 1.0, 3)
    rows = placed.rows(problem.share, shares)
    # where a joint turns back within a cell its friction may point either way
    room = np.maximum(rows.room - rows.drag.max(axis=1, keepdims=True), _LEAST_ROOM)
    lines, cones = [], []
    for k in (1, 2):
        z = float(shares[k])
        push = rows.push[:, k] / h
        parts = _by_y(push, rows.bend[:, k], z)
        lines.append(np.stack((*parts, rows.root[:, k], room[:, k], np.full_like(push, z)), axis=2))
        ahead, bend, across = np.moveaxis(rows.cones[:, k], -1, 0)
        pair = (*_by_y(ahead / h, bend, z), *_by_y(0.0 * ahead, across, z))
        cones.append(np.stack(pair, axis=2))
    with np.errstate(divide="ignore"):
        caps = np.minimum(problem.caps, 1.0 / rows.square)
    for k, end in enumerate(problem.ends):
        if end.is_rest:
            at = (0, 0) if k == 0 else (-1, 2)
            caps[at] = min(caps[at], _placed_launch_cap(problem, placed, k))
    return replace(
        problem,
        caps=caps,
        lines=np.ascontiguousarray(np.concatenate(lines, axis=1)),
        cones=np.ascontiguousarray(np.concatenate(cones, axis=1)),
    )


def _by_y(push: FloatArray, bend: FloatArray, z: float) -> tuple[FloatArray, ...]:
    """Give push h d2s/dt2 + bend x at share z of a cell by its y."""
    return bend, push + 2.0 * z * bend, z * push + z * z * bend


def _placed_launch_cap(problem: Problem, placed: Placed, end: int) -> float:
    """Give the highest x behind the launch (before the landing) that torques and tool allow."""
    length = float(problem.launches[end])
    cell = np.array([0.0, length]) if end == 0 else np.array([1.0 - length, 1.0])
    rows = placed.rows(cell, _LAUNCH_LOOKS)
    six = 6.0 * (_LAUNCH_LOOKS if end == 0 else _LAUNCH_LOOKS[::-1])[None] * length
    # with s = j t^3 / 6 and j = 1; slower by k the jerk is a k^3th
    u, x = np.cbrt(six) * (1.0 - 2.0 * end), np.cbrt(six) ** 4 / 4.0
    most = max(rows.slower(u, x).max(initial=1e-300), (rows.square * x).max())
    return float(np.cbrt(6.0 * length) ** 4 / (4.0 * most))


def _launch_cap(problem: Problem, end: int) -> float:
    """Give the highest x behind the launch (before the landing) of even jerk.

    Its velocity, acceleration and jerk are the jerk of s to the power 1/3, 2/3 and 1 times what
    the place on the path says.
    """
    length = float(problem.launches[end])
    way = _LAUNCH_LOOKS * length
    first, second, third = problem.way.slopes(way if end == 0 else 1.0 - way, from_end=end == 1)
    second = second if end == 0 else -second
    velocity, acceleration, jerk = problem.inverse
    six = 6.0 * way[:, None]
    felt = np.abs(4.5 * third * way[:, None] ** 2 + 9.0 * second * way[:, None] + first)
    push = np.abs(first * six ** (1.0 / 3.0) + second * six ** (4.0 / 3.0) / 4.0)
    speed = np.abs(first) * six ** (2.0 / 3.0) / 2.0
    most = max(
        float((felt * jerk).max()) ** (2.0 / 3.0),
        float((push * acceleration).max()),
        float((speed * velocity).max()) ** 2,
        1e-300,
    )
    cap: float = (6.0 * length) ** (4.0 / 3.0) / (4.0 * most)
    return cap


def slaves_of(problem: Problem) -> tuple[float, float]:
    """Give the shares of their neighbours that outer coefficients have next to a launch."""
    # behind s = j t^3 / 6 is x' / 2 = 2/3 x / s
    h = np.diff(problem.share)
    shares = []
    for length, cell, end in zip(problem.launches, (h[0], h[-1]), problem.ends, strict=True):
        free = length > 0.0 and end.is_rest
        shares.append(float(1.0 / (1.0 + 2.0 * cell / (3.0 * length))) if free else 0.0)
    return shares[0], shares[1]
