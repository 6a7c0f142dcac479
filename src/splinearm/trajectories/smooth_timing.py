"""The quickest time law of a path within velocity, acceleration and jerk limits."""

import logging
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError, LimitError
from splinearm.joints import JointKind, JointLimits

from . import smooth_grid, smooth_problem, smooth_profile
from .constraint import SpeedCap
from .joint_path import JointPath
from .limit import MotionLimits
from .smooth_canonical import Canonical, canonical
from .smooth_grid import Estimate, check_bend
from .smooth_law import SmoothLaw, cell_times
from .smooth_placed import Placed
from .smooth_problem import End, Problem
from .smooth_profile import Answer, slower_by
from .smooth_straight import double_s
from .tool_row import sampled_limits

_LOG = logging.getLogger(__name__)

_LEAST_CELLS = 8
"""Fewer cells than that are no grid."""

_PARTS = 8
"""Parts of a cell in which the finished law is looked at."""

_TRIFLE = 1.005
"""A law slower than it needs to be by less than this share is not worth another round."""

_GRIDS = 1.0, 1.5, 2.5
"""Where nothing is found on as many cells as were asked for, so many times as many are tried."""

_WIDTHS = 3, 8, 20
"""... and in the end the estimate is smoothed over so many cells."""

_ENOUGH, _EXACT = 1.0 + 1e-7, 1.0 + 1e-6
"""... but where a speed is wanted or given, nothing but this is good enough, or is good at all."""

_ROUNDS, _MORE_ROUNDS, _HARDER = 2, 12, 1.5
"""So often bounds are narrowed by what cells are over, and by so many times more each time."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Passage:
    """How the path parameter itself begins, ends and may change."""

    start_speed: float = 0.0
    """ds/dt at the start, not below zero."""
    start_acceleration: float = 0.0
    """d2s/dt2 at the start; at rest not below zero."""
    end_speed: float = 0.0
    """ds/dt at the end, where d2s/dt2 is zero; not below zero."""
    jerk_max: float | None = None
    """Highest magnitude of d3s/dt3; None: as the joints allow."""

    def __post_init__(self) -> None:
        for name in ("start_speed", "end_speed"):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0.0):
                raise ValueError(f"{name}: want a number of at least 0, got {value}")
        if not isfinite(self.start_acceleration):
            raise ValueError(f"start_acceleration: want a number, got {self.start_acceleration}")
        if self.start_speed == 0.0 and self.start_acceleration < 0.0:
            raise ValueError(
                f"start_acceleration: nothing goes backwards from rest, got "
                f"{self.start_acceleration}"
            )
        if self.jerk_max is not None and not (isfinite(self.jerk_max) and self.jerk_max > 0.0):
            raise ValueError(f"jerk_max: want a number above 0, got {self.jerk_max}")

    @property
    def from_rest_to_rest(self) -> bool:
        """Whether it begins and ends at rest."""
        return self.start_speed == self.start_acceleration == self.end_speed == 0.0


def quickest_smooth(
    path: JointPath,
    limits: JointLimits | MotionLimits,
    span: tuple[float, float] | None = None,
    cap: SpeedCap | None = None,
    passage: Passage | None = None,
    cells: int = 200,
) -> SmoothLaw:
    """Give the quickest time law on a path whose acceleration never jumps.

    Velocity, acceleration and jerk of every joint stay within their limits, and so do torques and
    what the tool does where it is limited. Where the tool's speed binds it is even, and corners are
    slowed down for and left smoothly. On a straight path, if nothing else is wished, the law is the
    exact optimum; else it is near it, by less than a hundredth as a rule, and the nearer the more
    cells there are. Limits are looked at between nodes too and the law is slowed down by what they
    were broken, down to a millionth. Units do not matter: in others the same law comes out.

    If the solver finds nothing, which is rare, the law is slower than it could be, and a warning is
    logged that says so.

    Args:
        path: The way of the joints; its second derivative must not jump.
        limits: What the joints, or joints, torques and tool, may do; with a jerk of the joints.
        span: From where to where, by default the whole path.
        cap: How fast the tool may be along the path; None: as fast as the limits say.
        passage: How the path parameter begins, ends and may change; None: from rest to rest.
        cells: On about how many cells the law is sought; at least two for each piece of the path.

    Raises:
        CurveError: If the path's second derivative jumps, with the place; or if no law within the
            limits leads from the given start to the given end.
        HoldError: If a joint is too weak to hold the arm somewhere on the path.
        LimitError: If the given start or end is beyond a limit.
        ValueError: If something is missing or does not fit.
    """
    passage = Passage() if passage is None else passage
    every = limits if isinstance(limits, MotionLimits) else MotionLimits(joints=limits)
    joints = every.joints
    start, end = _span(path, joints, span)
    if cells < _LEAST_CELLS:
        raise ValueError(f"cells: want at least {_LEAST_CELLS}, got {cells}")
    if path.is_still:
        return SmoothLaw.resting(end)
    check_bend(path, start, end)
    columns, others = _columns(joints, passage), sampled_limits(path, every, None)
    if path.is_straight and cap is None and not others and passage.from_rest_to_rest:
        return _straight(path, (start, end), columns)
    _check_end(path, joints, start, passage.start_speed, passage.start_acceleration)
    _check_end(path, joints, end, passage.end_speed, None)
    same = canonical(path.breaks, path.coefficients, (start, end), columns, cap)
    if others:
        placed = Placed(path=path, limits=tuple(others), span=(start, end), unit=same.unit)
        same = replace(same, way=same.way._replace(placed=placed))
    pace = same.unit / same.length
    ends = (
        End(passage.start_speed * pace, passage.start_acceleration * pace * same.unit),
        End(passage.end_speed * pace, 0.0),
    )
    guess = smooth_grid.estimate(same.way, (ends[0].speed, ends[1].speed))
    if guess.t[-1] == 0.0:
        return SmoothLaw.resting(end)
    if passage.from_rest_to_rest:
        return _from_rest_to_rest(same, guess, cells)
    problem = smooth_problem.pose(same.way, guess, ends, cells)
    return _law(problem, *_in_motion(problem, same), same)


def _span(
    path: JointPath, limits: JointLimits, span: tuple[float, float] | None
) -> tuple[float, float]:
    """Give what is to be timed, checked."""
    if limits.n != path.n:
        raise ValueError(f"limits: want them for the {path.n} joints of the path, got {limits.n}")
    if limits.qddd_max is None:
        raise ValueError("limits: want a jerk, qddd_max; got none")
    first, last = path.domain
    start, end = path.domain if span is None else span
    if not first <= start < end <= last:
        raise ValueError(f"span: want a part of the path's {path.domain}, got {(start, end)}")
    return float(start), float(end)


def _columns(limits: JointLimits, passage: Passage) -> FloatArray:
    """Give the limits of joints, and of the path parameter if it has one, shape (3, n or n + 1)."""
    jerk = np.inf if limits.qddd_max is None else limits.qddd_max
    columns = np.stack(np.broadcast_arrays(limits.qd_max, limits.qdd_max, jerk))
    if passage.jerk_max is None:
        return columns
    return np.hstack((columns, np.array([[np.inf], [np.inf], [passage.jerk_max]])))


def _check_end(
    path: JointPath, limits: JointLimits, s: float, speed: float, acceleration: float | None
) -> None:
    """Refuse an end of the motion that is beyond limits itself; no acceleration: the last end."""
    at_end, push = acceleration is None, acceleration or 0.0
    if speed == 0.0 and push == 0.0:
        return
    slope, bend = path.at(s)[1:]
    for quantity, value, most in (
        ("velocity", slope * speed, limits.qd_max),
        ("acceleration", slope * push + bend * speed**2, limits.qdd_max),
    ):
        over = np.abs(value) > most * _EXACT
        if over.any():
            i = int(np.argmax(over))
            raise LimitError(
                limits.names[i],
                quantity,
                float(value[i]),
                float(most[i]),
                None if at_end else 0.0,
                linear=limits.kinds[i] is JointKind.PRISMATIC,
            )


def _straight(path: JointPath, span: tuple[float, float], limits: FloatArray) -> SmoothLaw:
    """Give the exact law on a straight way."""
    slope = np.abs(path.coefficients[0, 1])
    if limits.shape[1] > slope.size:
        slope = np.append(slope, 1.0)
    with np.errstate(divide="ignore"):
        speed, acceleration, jerk = (limits / slope).min(axis=1).tolist()
    return double_s(*span, speed, acceleration, jerk)


def _from_rest_to_rest(same: Canonical, guess: Estimate, cells: int) -> SmoothLaw:
    """Give the law of a way that may be passed as slowly as need be."""
    even, rest = same.way.cap is not None, End(0.0, 0.0)
    enough, rounds = (_ENOUGH, _MORE_ROUNDS) if even else (_TRIFLE, _ROUNDS)
    for more in _GRIDS:
        problem = smooth_problem.pose(same.way, guess, (rest, rest), int(more * cells))
        answer = smooth_profile.solve(problem)
        if answer is not None:
            answer, slower = _within(problem, answer, enough, rounds)
            return _law(problem, answer, max(slower, 1.0), same)
    problem = smooth_problem.pose(same.way, guess, (rest, rest), cells)
    return _law(problem, *_last_resort(problem), same)


def _last_resort(problem: Problem) -> tuple[Answer, float]:
    """Give a profile of the shape of the guess, as quick as limits allow that, and say so."""
    found = []
    tool = smooth_profile.tool_looks(problem, _PARTS)
    for width in _WIDTHS:
        answer = smooth_profile.smoothed(problem, width)
        use = smooth_profile.use_of(problem, answer, _PARTS, tool)
        # what launch and landing allow is said by caps at their ends
        use[0, 0] = max(use[0, 0], answer.y[0, 0] / problem.caps[0, 0])
        use[-1, 0] = max(use[-1, 0], answer.y[-1] @ [1.0, 2.0, 1.0] / problem.caps[-1, 2])
        slower = float(slower_by(use).max())
        times = slower * float((np.diff(problem.share) / np.sqrt(answer.y[:, 0])).sum())
        found.append((times, slower, answer))
    times, slower, answer = min(found, key=lambda one: one[0])
    _LOG.warning(
        "no quickest law within limits of jerk was found on %d cells; the one given instead "
        "keeps all limits but takes %.2g times as long as estimated",
        len(problem.pieces),
        times,
    )
    return answer, slower


def _in_motion(problem: Problem, same: Canonical) -> tuple[Answer, float]:
    """Give that to a problem whose speed is given at an end, so that it cannot be slowed."""
    answer = smooth_profile.solve(problem)
    if answer is not None:
        answer, slower = _within(problem, answer, _ENOUGH, _MORE_ROUNDS)
        if slower <= _EXACT:
            return answer, 1.0
    raise CurveError(
        "no motion within the limits leads from that start to that end of the way; start slower, "
        "or end later",
        f"s = {same.start:.6g} to {same.end:.6g}",
    )


def _within(problem: Problem, answer: Answer, enough: float, rounds: int) -> tuple[Answer, float]:
    """Narrow the bounds where an answer breaks limits between its rows; give what is left of it.

    That is the factor by which the law must become slower to keep them.
    """
    tool = smooth_profile.tool_looks(problem, _PARTS)
    use = smooth_profile.use_of(problem, answer, _PARTS, tool)
    best = answer, float(slower_by(use).max())
    for k in range(rounds):
        if best[1] <= enough:
            break
        problem = smooth_problem.tightened(problem, use, _HARDER**k)
        better = smooth_profile.solve(problem, answer)
        if better is None:
            break
        answer, use = better, smooth_profile.use_of(problem, better, _PARTS, tool)
        best = min(best, (answer, float(slower_by(use).max())), key=lambda pair: pair[1])
    return best


def _law(problem: Problem, answer: Answer, slower: float, same: Canonical) -> SmoothLaw:
    """Give the time law of a profile, so many times slower."""
    y, length = answer.y, same.length
    unit = problem.unit * same.unit * slower
    h = np.diff(problem.share)
    end = y[-1] @ np.array([1.0, 2.0, 1.0]), (y[-1, 1] + y[-1, 2]) / h[-1]
    speed = np.sqrt(np.append(y[:, 0], end[0]))
    acceleration = np.append(y[:, 1] / h, end[1])
    growth = y[:, 2] / h**2
    times, jerks = cell_times(h, speed, growth), np.zeros_like(h)
    share = problem.share
    for k, launch in enumerate(problem.launches):
        if launch == 0.0:
            continue
        at, sign = (0, 1.0) if k == 0 else (-1, -1.0)
        rest = problem.ends[k].is_rest
        time = (3.0 if rest else 2.0) * launch / float(speed[at])
        jerk = 6.0 * launch / time**3 if rest else 0.0
        begin = 0.0 if rest else problem.ends[k].acceleration
        share, speed = _joined(share, float(k), k), _joined(speed, 0.0, k)
        acceleration = _joined(acceleration, begin, k)
        if not rest:
            acceleration[at + int(sign)] = begin
        times, jerks, growth = (
            _joined(times, time, k),
            _joined(jerks, jerk, k),
            _joined(growth, 0.0, k),
        )
    return SmoothLaw(
        s=same.at(share),
        t=np.concatenate(([0.0], np.cumsum(times))) * unit,
        speed=speed * (length / unit),
        acceleration=acceleration * (length / unit**2),
        jerks=jerks * (length / unit**3),
        growth=growth / unit**2,
    )


def _joined(values: FloatArray, value: float, end: int) -> FloatArray:
    """Give the values with one more in front (0) or behind (1)."""
    one = np.array([value])
    return np.concatenate((one, values) if end == 0 else (values, one))
