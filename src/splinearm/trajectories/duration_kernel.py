"""How long one joint can take from one state to another: the intervals of time that are possible.

The velocities that lead from state to state within a time T are a convex set, so the places that
can be reached are an interval, from the nearest P-(T) to the farthest P+(T). The durations of a
motion over p are those with P-(T) <= p <= P+(T): they begin and end at roots of either, or where
the velocities themselves begin or end to exist. All are found, by Newton's method within pieces
on which P is convex or concave; the first is the time-optimal one, the gaps are what synchronised
motions must step over (Kroeger 2010 calls them inoperative; Berscheid and Kroeger 2021, blocked).
"""

import math
from typing import NamedTuple

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .brake_kernel import brake_of
from .extremal_kernel import Side
from .extremal_kernel import domain_of as jerky_domain_of
from .extremal_kernel import place_of as jerky_place_of
from .extremal_kernel import roots_of as jerky_roots_of
from .extremal_kernel import side_of as jerky_side_of
from .trapezoid_kernel import place_of as jumpy_place_of
from .trapezoid_kernel import roots_of as jumpy_roots_of
from .trapezoid_kernel import side_of as jumpy_side_of


class Task(NamedTuple):
    """What one joint shall do, in its own units, once it is within its limits."""

    v0: float
    a0: float
    vf: float
    af: float
    top: float
    p: float
    """How far, from where it is within its limits."""
    slack: float
    """By how much rounding may miss that."""
    unit: float
    """The unit of time, s."""
    control: float
    """The limit of the control, which is the jerk or, where that has none, the acceleration."""
    jerky: bool
    """Whether the control is the jerk."""
    brake: float
    """How long the first part of the way back within the limits takes."""
    push: float
    """The control on it."""
    coast: float
    """How long the second part takes, with no control."""


INTERVALS = 8
"""Most intervals of possible durations that are kept."""

_ROUNDING = 1e-14
"""By this share of its largest terms a place is off at most."""

_SMALLEST = 1e-60

_SAME_PLACE = 1e-13
"""Places that are apart by this share of about the way to stop from full speed are the same."""

_LAST_DIGITS = 1e-15
"""By this share of itself a number that comes in is off."""


@kernel
def task_of(start: FloatArray, goal: FloatArray, limits: FloatArray) -> Task:
    """Give one joint's task; ``start`` and ``goal`` are (q, qd, qdd), ``limits`` their maxima.

    The limits are velocity, acceleration and jerk; a jerk of inf is not limited.
    """
    a0 = af = 0.0
    jerky = not math.isinf(limits[2])
    if jerky:
        control = limits[2]
        unit = limits[1] / control
        speed = limits[1] * unit
        a0, af = start[2] / limits[1], goal[2] / limits[1]
    else:
        control = limits[1]
        unit = limits[0] / control
        speed = limits[0]
    length = speed * unit
    a0, af = _solid(a0), _solid(af)
    v0, vf, top = _solid(start[1] / speed), _solid(goal[1] / speed), limits[0] / speed
    p = _solid((goal[0] - start[0]) / length)
    slack = _LAST_DIGITS * (abs(goal[0]) + abs(start[0])) / length
    slack += _ROUNDING * abs(p) + _SAME_PLACE * top * (top + 1.0)
    if jerky:
        t0, push, t1 = brake_of(v0, a0, top)
        a = a0 + push * t0
        p -= t0 * (v0 + t0 * (0.5 * a0 + push * t0 / 6.0))
        v0 += t0 * (a0 + 0.5 * push * t0)
        p -= t1 * (v0 + 0.5 * a * t1)
        v0, a0 = v0 + a * t1, min(max(a, -1.0), 1.0)
    else:
        t0, push, t1 = max(abs(v0) - 1.0, 0.0), -math.copysign(1.0, v0), 0.0
        p -= t0 * (v0 + 0.5 * push * t0)
        v0 = min(max(v0, -1.0), 1.0)
    return Task(v0, a0, vf, af, top, p, slack, unit, control, jerky, t0, push, t1)


@kernel
def _solid(x: float) -> float:
    """Give 0 for what is so small that its powers would leave the range of numbers."""
    return x if abs(x) > _SMALLEST else 0.0


@kernel
def sides_of(task: Task) -> tuple[Side, Side]:
    """Give the farthest way and the farthest one backwards (of the task turned round)."""
    v0, a0, vf, af, top = task.v0, task.a0, task.vf, task.af, task.top
    if task.jerky:
        return jerky_side_of(v0, a0, vf, af, top), jerky_side_of(-v0, -a0, -vf, -af, top)
    return jumpy_side_of(v0, vf), jumpy_side_of(-v0, -vf)


@kernel
def reach_of(task: Task, there: Side, back: Side, T: float) -> tuple[float, float, float]:
    """Give the nearest and the farthest place after T, and by how much rounding may miss them."""
    width = there.width
    if task.jerky:
        far, _ = jerky_place_of(there, 0.5 * (T - width))
        near, _ = jerky_place_of(back, 0.5 * (T + width))
    else:
        far = jumpy_place_of(there, 0.5 * T)
        near = jumpy_place_of(back, 0.5 * T)
    return -near, far, task.slack + _ROUNDING * T * (abs(task.v0) + abs(task.vf))


@kernel
def durations_of(task: Task, events: FloatArray, out: FloatArray) -> None:
    """Write the intervals of possible durations, in s, rising, filled up with inf.

    They hold the way back from outside of the limits. The last one has no end. ``out`` has shape
    (INTERVALS, 2); ``events``, shape (32,), is a place to work in.
    """
    there, back = sides_of(task)
    if task.jerky:
        begin, gap, after = jerky_domain_of(there)
    else:
        begin, gap, after = 0.5 * abs(task.vf - task.v0), math.nan, math.nan
    k = 0
    end = math.inf if math.isnan(gap) else gap
    while True:
        k = _component(task, there, back, begin, end, events, out, k)
        if math.isinf(end):
            break
        begin, end = after, math.inf
    lead, unit = task.brake + task.coast, task.unit
    for i in range(k):
        out[i, 0] = unit * (out[i, 0] + lead)
        out[i, 1] = unit * (out[i, 1] + lead)
    for i in range(k, INTERVALS):
        out[i, 0] = out[i, 1] = math.inf


@kernel
def _component(
    task: Task,
    there: Side,
    back: Side,
    begin: float,
    end: float,
    events: FloatArray,
    out: FloatArray,
    k: int,
) -> int:
    """Add the possible durations for D from begin to end; give the new count."""
    p, width = task.p, there.width
    if task.jerky:
        e = 0
        for turn in range(2):
            # the way backwards counts D from -width on
            side, sign, shift = (there, 1.0, 0.0) if turn == 0 else (back, -1.0, width)
            m = e
            e = jerky_roots_of(side, sign * p, begin + shift, end + shift, events, m)
            for i in range(m, e):
                events[i] -= shift
    else:
        m = jumpy_roots_of(there, p, events, 0)
        e = jumpy_roots_of(back, -p, events, m)
    _sort(events, e)
    # times from here on
    now = max(2.0 * begin + width, 0.0)
    open_since = math.nan
    for i in range(e + 1):
        after = 2.0 * (events[i] if i < e else end) + width
        after = max(after, now)
        if math.isinf(after):
            possible = True
        else:
            possible = after > now and _is_possible(task, there, back, 0.5 * (now + after))
        if possible and math.isnan(open_since):
            open_since = now
        elif not possible and not math.isnan(open_since):
            k = _add(out, k, open_since, now)
            open_since = math.nan
        elif not possible and _is_possible(task, there, back, now):
            # a time may be possible alone
            k = _add(out, k, now, now)
        now = after
    if not math.isnan(open_since):
        return _add(out, k, open_since, now)
    return _add(out, k, now, now) if _is_possible(task, there, back, now) else k


@kernel
def _is_possible(task: Task, there: Side, back: Side, T: float) -> bool:
    near, far, slack = reach_of(task, there, back, T)
    return near - slack <= task.p <= far + slack


@kernel
def _add(out: FloatArray, k: int, begin: float, end: float) -> int:
    # the last one has no end and is never left out
    k = min(k, INTERVALS - 1)
    out[k, 0], out[k, 1] = begin, end
    return k + 1


@kernel
def _sort(values: FloatArray, count: int) -> None:
    """Sort the first few numbers by insertion."""
    for i in range(1, count):
        value = values[i]
        j = i - 1
        while j >= 0 and values[j] > value:
            values[j + 1] = values[j]
            j -= 1
        values[j + 1] = value
