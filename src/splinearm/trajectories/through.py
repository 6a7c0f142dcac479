"""One motion of the joints through several waypoints, without stopping there."""

from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import LimitError
from splinearm.joints import JointLimits, JointSetpoint

from .point_to_point import check_goal, limit_rows, motion_phases, state_rows
from .profile import JointProfile

_PACES = (1.0, 0.7, 0.4, 0.2, 0.0)
"""Shares of the velocities at waypoints that are tried until the joints stay within positions."""


@cache
def _kernel() -> Callable[..., None]:
    """Give the search, compiled for its arguments."""
    from splinearm.compiled import entry, inputs, outputs

    from .through_kernel import through_into

    return entry(through_into, *outputs(3), *inputs(1, 2), *outputs(1))


def through(
    limits: JointLimits, waypoints: Sequence[JointSetpoint | ArrayInput]
) -> tuple[JointProfile, FloatArray]:
    """Give a quick motion of the joints through waypoints, and when it passes each of them.

    Velocities and accelerations at waypoints are chosen so that the motion is short: they begin as
    those of a cubic spline, slowed down until that is within the limits, and are changed as long as
    that shortens the motion. It takes never longer than stopping everywhere. Between waypoints each
    joint goes as ``point_to_point`` has it go. It is meant for a few waypoints that are far apart;
    a path of many is better followed by a time law along it.

    Args:
        limits: What the joints may do.
        waypoints: At least two. Joint positions, shape (n,), which are passed in motion (the first
            and the last at rest); or whole states, which are kept as they are.

    Returns:
        The motion, and the times of the waypoints, shape (m,), s.

    Raises:
        LimitError: If a waypoint is beyond a limit, with the joint, the place and the time.
        ValueError: If shapes or numbers are wrong, or a waypoint repeats the place of the last one.
    """
    if len(waypoints) < 2:
        raise ValueError(f"waypoints: want at least 2, got {len(waypoints)}")
    rows = limit_rows(limits)
    states = np.stack(
        [state_rows(one, limits.n, f"waypoint {k}") for k, one in enumerate(waypoints)]
    )
    for k, (here, there) in enumerate(pairwise(states[:, :, 0])):
        if (here == there).all():
            raise ValueError(f"waypoints: {k} and {k + 1} are the same place")
    for state in states[1:]:
        check_goal(limits, state, rows)
    free = np.array([float(not isinstance(one, JointSetpoint)) for one in waypoints])
    free[[0, -1]] = 0.0
    stops = np.empty(len(states) - 1)
    _kernel()(states, np.zeros(len(states)), rows, stops)
    moving = states.copy()
    moving[free > 0.0, :, 1:] = _spline_states(states[:, :, 0], rows)[free > 0.0]
    durations = np.empty_like(stops)
    _kernel()(moving, free, rows, durations)
    if durations.sum() > stops.sum():
        moving = states
    return _within_positions(limits, moving, free, rows)


def _within_positions(
    limits: JointLimits, states: FloatArray, free: FloatArray, rows: FloatArray
) -> tuple[JointProfile, FloatArray]:
    """Give the motion through states, passed more slowly if it swings beyond positions."""
    for pace in _PACES:
        slower = states.copy()
        slower[free > 0.0, :, 1:] *= [pace, pace**2]
        profile, times = _joined(limits, slower, rows)
        try:
            profile.check_positions()
        except LimitError:
            if pace == 0.0 or not free.any():
                raise
        else:
            return profile, times
    raise AssertionError("the slowest pace returns or raises")


def _joined(
    limits: JointLimits, states: FloatArray, rows: FloatArray
) -> tuple[JointProfile, FloatArray]:
    """Give the motion from state to state, and when it is at each."""
    parts = [motion_phases(start, goal, rows) for start, goal in pairwise(states)]
    times = np.cumsum([0.0, *(phases[0, -1, 0] for phases in parts)])
    for phases, begin, end in zip(parts, times, times[1:], strict=False):
        phases[:, :, 0] = np.minimum(phases[:, :, 0] + begin, end)
    rest = [phases[:, :-1] for phases in parts[:-1]]
    times.flags.writeable = False
    return JointProfile(limits, np.concatenate((*rest, parts[-1]), axis=1)), times


def _spline_states(Q: FloatArray, rows: FloatArray) -> FloatArray:
    """Give qd and qdd, shape (m, n, 2), of a cubic spline through places, within the limits.

    It is C2 and begins and ends at rest, with times in proportion to how long the joints would take
    at their highest velocities.
    """
    h = (np.abs(np.diff(Q, axis=0)) / rows[:, 0]).max(axis=1)[:, None]
    slopes = np.diff(Q, axis=0) / h
    # equal accelerations on both sides of each inner knot
    matrix, right = np.eye(len(Q)), np.zeros_like(Q)
    for k in range(1, len(Q) - 1):
        before, after = 1.0 / h[k - 1, 0], 1.0 / h[k, 0]
        matrix[k, k - 1 : k + 2] = before, 2.0 * (before + after), after
        right[k] = 3.0 * (slopes[k - 1] * before + slopes[k] * after)
    qd = np.linalg.solve(matrix, right)
    first = (6.0 * slopes - 4.0 * qd[:-1] - 2.0 * qd[1:]) / h
    last = (4.0 * qd[1:] + 2.0 * qd[:-1] - 6.0 * slopes) / h
    qdd = np.concatenate((first, last[-1:]))
    slower = max(
        (np.abs(qd) / rows[:, 0]).max(),
        (np.abs(qdd) / rows[:, 1]).max() ** (1 / 2),
        (np.abs(last - first) / h / rows[:, 2]).max() ** (1 / 3),
    )
    qd, qdd = qd / slower, qdd / slower**2
    # where both are used at once, the velocity before or after would still be beyond its limit
    extreme = (np.abs(qd) + 0.5 * qdd**2 / rows[:, 2]) / rows[:, 0]
    slower_here = np.maximum(extreme.max(axis=1), 1.0)[:, None]
    return np.stack((qd / slower_here, qdd / slower_here**2), axis=2)
