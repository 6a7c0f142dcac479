"""Velocities and accelerations with which waypoints are passed, so that the motion is short.

The states at the waypoints say all: between two of them the quickest synchronised motion takes a
duration that is known in closed form. A pattern search changes them, keeps what shortens the
motion, and doubles or halves its steps. It changes one joint's velocity or acceleration at one
waypoint, which touches the two segments beside it; or the pace of all joints on a block of
waypoints (velocities by a factor, accelerations by its square), in blocks of every power of two. A
segment lasts as long as its slowest joint, so a small weight on what each joint would take alone
leads the others on.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .duration_kernel import INTERVALS, durations_of, task_of
from .synchronised_kernel import common

_FIRST_STEP = 0.25
"""First steps, as a share of the limit."""

_LAST_STEP = 1e-3
"""Steps shorter than this share of the limit are not made."""

_SWEEPS = 200
"""Most times that all waypoints are gone through."""

_WEIGHTS = (0.1, 0.0)
"""Weights on what joints would take alone, one search after the other."""

_BETTER = 1.0 - 1e-9
"""A motion is shorter if it takes less than this share."""


_Motion = tuple[FloatArray, FloatArray, FloatArray]
"""States, intervals of possible durations (m - 1, n, INTERVALS, 2), durations."""


@kernel
def through_into(
    states: FloatArray, free: FloatArray, limits: FloatArray, durations: FloatArray
) -> None:
    """Improve the states at waypoints in place.

    Args:
        states: q, qd and qdd of each joint at each waypoint, shape (m, n, 3).
        free: Whether velocity and acceleration there may be chosen (1, 0), shape (m,).
        limits: Of velocity, acceleration and jerk, shape (n, 3).
        durations: Receives that of each segment, shape (m - 1,).
    """
    m, n = states.shape[0], states.shape[1]
    events = np.empty(32)
    intervals = np.zeros((m - 1, n, INTERVALS, 2))
    now = (states, intervals, durations)
    trial = (states.copy(), intervals.copy(), durations.copy())
    moves = np.empty(((m - 2) * (3 * n + 2 * m) + 1, 4))
    count = _list_moves(free, limits, moves)
    steps = np.empty(count)
    for weight in _WEIGHTS:
        steps[:] = _FIRST_STEP
        # the first move is none: from endless durations to those of the states given
        durations[:] = math.inf
        for _ in range(_SWEEPS):
            tried = False
            for move in range(count):
                if steps[move] < _LAST_STEP:
                    continue
                tried = True
                found = False
                first, last = int(moves[move, 0]), int(moves[move, 1])
                joint = int(moves[move, 2])
                i, end = (0, n) if joint < 0 else (joint, joint + 1)
                for sign in (1.0, -1.0):
                    _propose(states, trial[0], free, limits, moves[move], sign * steps[move])
                    if _is_better(now, trial, limits, first, last, i, end, weight, events):
                        found = True
                        break
                steps[move] = min(2.0 * steps[move], 1.0) if found else 0.5 * steps[move]
                if move == 0:
                    steps[move] = 0.0
            if not tried:
                break


@kernel
def _list_moves(free: FloatArray, limits: FloatArray, out: FloatArray) -> int:
    """Write what may be changed; give how many.

    A row holds the first waypoint and the one after the last, the joint (-1: the pace of all) and
    whether its velocity (1) or acceleration (2) changes; 0 stands for nothing at all.
    """
    m, n = free.shape[0], limits.shape[0]
    out[0, 0], out[0, 1], out[0, 2], out[0, 3] = 1, m - 1, -1, 0
    k = 1
    size = 1
    while size < 2 * (m - 2):
        for first in range(1, m - 1, max(size // 2, 1)):
            last = min(first + size, m - 1)
            some = False
            for i in range(first, last):
                some = some or free[i] > 0.0
            if some:
                out[k, 0], out[k, 1], out[k, 2], out[k, 3] = first, last, -1, 1
                k += 1
        size *= 2
    for first in range(1, m - 1):
        for i in range(n):
            for which in range(1, 2 if math.isinf(limits[i, 2]) else 3):
                if free[first] > 0.0:
                    out[k, 0], out[k, 1], out[k, 2], out[k, 3] = first, first + 1, i, which
                    k += 1
    return k


@kernel
def _propose(
    states: FloatArray,
    out: FloatArray,
    free: FloatArray,
    limits: FloatArray,
    move: FloatArray,
    step: float,
) -> None:
    """Write the states that a move leads to."""
    first, last, joint, which = int(move[0]), int(move[1]), int(move[2]), int(move[3])
    for k in range(first, last):
        _copy_state(states, out, k)
        if joint >= 0:
            out[k, joint, which] += step * limits[joint, which - 1]
            _admit(out[k, joint], limits[joint], which)
        elif which > 0 and free[k] > 0.0:
            factor = 1.0 + step if step > 0.0 else 1.0 / (1.0 - step)
            for i in range(limits.shape[0]):
                out[k, i, 1] *= factor
                out[k, i, 2] *= factor * factor
                _admit(out[k, i], limits[i], 1)


@kernel
def _is_better(
    now: _Motion,
    trial: _Motion,
    limits: FloatArray,
    first: int,
    last: int,
    i_first: int,
    i_last: int,
    weight: float,
    events: FloatArray,
) -> bool:
    """Take over waypoints first to last, where joints i_first to i_last differ, if that is shorter.

    The states tried stand in ``trial`` already; elsewhere both are the same.
    """
    states, intervals, durations = now
    trial_states, trial_intervals, trial_durations = trial
    n = limits.shape[0]
    before = after = 0.0
    for k in range(first - 1, last):
        _copy_intervals(intervals, trial_intervals, k)
        for i in range(i_first, i_last):
            start = trial_states[k, i] if k >= first else states[k, i]
            goal = trial_states[k + 1, i] if k + 1 < last else states[k + 1, i]
            durations_of(task_of(start, goal, limits[i]), events, trial_intervals[k, i])
            before += weight / n * intervals[k, i, 0, 0]
            after += weight / n * trial_intervals[k, i, 0, 0]
        trial_durations[k] = common(trial_intervals[k], 0.0)
        before += durations[k]
        after += trial_durations[k]
    if not after < before * _BETTER:
        return False
    for k in range(first - 1, last):
        _copy_intervals(trial_intervals, intervals, k)
        durations[k] = trial_durations[k]
    for k in range(first, last):
        _copy_state(trial_states, states, k)
    return True


@kernel
def _copy_state(states: FloatArray, out: FloatArray, k: int) -> None:
    for i in range(states.shape[1]):
        for order in range(3):
            out[k, i, order] = states[k, i, order]


@kernel
def _copy_intervals(intervals: FloatArray, out: FloatArray, k: int) -> None:
    for i in range(intervals.shape[1]):
        for j in range(INTERVALS):
            for end in range(2):
                out[k, i, j, end] = intervals[k, i, j, end]


@kernel
def _admit(state: FloatArray, limits: FloatArray, which: int) -> None:
    """Bring velocity (1) or acceleration (2) to where both can be reached and left in limits."""
    if math.isinf(limits[2]):
        state[1] = min(max(state[1], -limits[0]), limits[0])
        return
    if which == 1:
        state[2] = min(max(state[2], -limits[1]), limits[1])
        most = max(limits[0] - 0.5 * state[2] * state[2] / limits[2], 0.0)
        if most == 0.0:
            state[2] = math.copysign(math.sqrt(2.0 * limits[2] * limits[0]), state[2])
    else:
        room = max(limits[0] - abs(state[1]), 0.0)
        most = min(limits[1], math.sqrt(2.0 * limits[2] * room))
    state[which] = min(max(state[which], -most), most)
