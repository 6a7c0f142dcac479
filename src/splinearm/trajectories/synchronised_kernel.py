"""Motions of several joints from state to state, all ending at once.

The common duration is the shortest that every joint can take (``duration_kernel``). For that
duration each joint has a farthest and a nearest way, both within the limits, and so is each
mixture of the two velocities, because the limits are convex: the share that leads to the goal is
one division, and whatever the duration leaves unused of a limit is left unused evenly. From and to
rest that is the smoothest way. A joint that moves at either end would swing far with it: it rather
goes at a constant velocity in between (``cruise_kernel``) where there is time for that.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .cruise_kernel import cruise_into
from .duration_kernel import INTERVALS, Task, durations_of, reach_of, sides_of, task_of
from .extremal_kernel import phases_of as jerky_phases_of
from .trapezoid_kernel import phases_of as jumpy_phases_of

ROWS = 18
"""Most phases of a joint: two back from outside of the limits, 13 mixed, a rest, and the end."""

_SAME = 1e-12
"""By this share two durations are the same."""

_ROUNDING = 1e-14
"""By this share of their largest values velocities and accelerations are off at most."""


@kernel
def motion_into(
    start: FloatArray,
    goal: FloatArray,
    limits: FloatArray,
    request: FloatArray,
    phases: FloatArray,
    report: FloatArray,
) -> int:
    """Write the motion of n joints; give how many rows of phases hold it.

    Args:
        start: q, qd and qdd of each joint, shape (n, 3).
        goal: The same at the end, shape (n, 3).
        limits: Of velocity, acceleration and jerk (inf: none), shape (n, 3).
        request: The wanted duration (NaN: the shortest), and 0 where joints may end each on its
            own; shape (2,).
        phases: Receives t, q, qd, qdd, qddd at the begin of each phase and, from the end of the
            motion on, the end, shape (n, ROWS, 5).
        report: Receives the duration of the motion, the shortest that is possible and not below
            the wanted one, and then each joint's own shortest, shape (1 + n,).
    """
    n = start.shape[0]
    events = np.empty(32)
    spans, controls = np.empty((3, 16)), np.empty((3, 16))
    intervals = np.empty((n, INTERVALS, 2))
    for i in range(n):
        durations_of(task_of(start[i], goal[i], limits[i]), events, intervals[i])
        report[1 + i] = intervals[i, 0, 0]
    wanted = request[0]
    if request[1] > 0.0:
        T = common(intervals, 0.0 if math.isnan(wanted) else wanted)
    else:
        T = report[1]
        for i in range(1, n):
            T = max(T, report[1 + i])
    report[0] = T
    rows = 1
    for i in range(n):
        task = task_of(start[i], goal[i], limits[i])
        own = T if request[1] > 0.0 else report[1 + i]
        count = _write(task, start[i], limits[i], own, T, spans, controls, phases[i])
        rows = max(rows, count + 1)
    return rows


@kernel
def common(intervals: FloatArray, T: float) -> float:
    """Give the shortest duration, not below T, that is possible for all joints."""
    settled = False
    while not settled:
        settled = True
        for i in range(intervals.shape[0]):
            for j in range(INTERVALS):
                if intervals[i, j, 1] * (1.0 + _SAME) >= T:
                    break
            else:
                return math.inf
            if intervals[i, j, 0] * (1.0 - _SAME) > T:
                T = intervals[i, j, 0]
                settled = False
    for i in range(intervals.shape[0]):
        for j in range(INTERVALS):
            # equal but for rounding: the longest of them
            if T < intervals[i, j, 0] <= T * (1.0 + 2.0 * _SAME):
                T = intervals[i, j, 0]
    return T


@kernel
def _write(
    task: Task,
    start: FloatArray,
    limits: FloatArray,
    own: float,
    end: float,
    spans: FloatArray,
    controls: FloatArray,
    out: FloatArray,
) -> int:
    """Write one joint's phases for its own duration, then its rest to the end; give how many."""
    unit, control, jerky = task.unit, task.control, task.jerky
    count = _mix(task, own / unit - task.brake - task.coast, spans, controls)
    t, q, v, a = 0.0, start[0], start[1], start[2]
    if not jerky:
        a = 0.0
    fast, steep = max(abs(v), limits[0]), max(abs(a), limits[1])
    k = 0
    for i in range(-2, count):
        # the way back from outside of the limits comes first
        if i == -2:
            h, u = task.brake * unit, task.push * control
        elif i == -1:
            h, u = task.coast * unit, 0.0
        else:
            h, u = spans[2, i] * unit, controls[2, i] * control
        if h <= 0.0:
            continue
        if not jerky:
            a, u = u, 0.0
        _row(out[k], t, q, v, a, u)
        k += 1
        t = min(t + h, end)
        q += h * (v + h * (0.5 * a + h * u / 6.0))
        v += h * (a + 0.5 * h * u)
        fast = max(fast, abs(v))
        # what rounding leaves of a rest would grow over a long time
        a = _snapped(a + h * u, limits[1], _ROUNDING * steep)
        if a == 0.0:
            v = _snapped(v, limits[0], _ROUNDING * fast)
    if not jerky:
        a = 0.0
    if t < end and own < end:
        _row(out[k], t, q, v, a, 0.0)
        k += 1
    for i in range(k, out.shape[0]):
        _row(out[i], end, q, v, a, 0.0)
    return k


@kernel
def _snapped(x: float, limit: float, tolerance: float) -> float:
    """Give 0 or the limit, of either sign, where x is as near as rounding."""
    if abs(x) <= tolerance:
        return 0.0
    if abs(abs(x) - limit) <= tolerance:
        return math.copysign(limit, x)
    return x


@kernel
def _row(out: FloatArray, t: float, q: float, v: float, a: float, u: float) -> None:
    out[0], out[1], out[2], out[3], out[4] = t, q, v, a, u


@kernel
def _mix(task: Task, T: float, spans: FloatArray, controls: FloatArray) -> int:
    """Write the phases of the mixture that leads to the goal to row 2; give their number."""
    there, back = sides_of(task)
    width, p = there.width, task.p
    near, far, slack = reach_of(task, there, back, T)
    if task.jerky:
        jerky_phases_of(there, 0.5 * (T - width), 1.0, spans[0], controls[0])
        jerky_phases_of(back, 0.5 * (T + width), -1.0, spans[1], controls[1])
    else:
        jumpy_phases_of(there, 0.5 * T, 1.0, spans[0], controls[0])
        jumpy_phases_of(back, 0.5 * T, -1.0, spans[1], controls[1])
    if p >= far - slack or p <= near + slack:
        row = 0 if p >= far - slack else 1
        for i in range(7):
            spans[2, i], controls[2, i] = spans[row, i], controls[row, i]
        return 7
    moves = task.v0 != 0.0 or task.a0 != 0.0 or task.vf != 0.0 or task.af != 0.0
    if task.jerky and moves and cruise_into(task, T, spans[2], controls[2]):
        return 7
    share = (p - near) / (far - near)
    i = j = k = 0
    left, right = spans[0, 0], spans[1, 0]
    while i < 7 and j < 7:
        h = min(left, right)
        if h > 0.0:
            spans[2, k] = h
            controls[2, k] = share * controls[0, i] + (1.0 - share) * controls[1, j]
            k += 1
        left, right = left - h, right - h
        if left <= right:
            i += 1
            left = spans[0, i] if i < 7 else 0.0
            if right <= 0.0:
                j += 1
                right = spans[1, j] if j < 7 else 0.0
        else:
            j += 1
            right = spans[1, j] if j < 7 else 0.0
    return k
