"""Ways of one joint that take a given time: at once to a constant velocity, and on to the goal.

Units are those of ``extremal_kernel``. The place that is reached rises with that velocity, which is
found between bounds by the Illinois method (Dowell and Jarratt 1971). Beside a mixture of the
nearest and the farthest way this one uses all of its limits, and so swings less far from a moving
start; where the time does not suffice for both changes of velocity there is none.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .duration_kernel import Task

_STEPS = 40


@kernel
def cruise_into(task: Task, T: float, spans: FloatArray, jerks: FloatArray) -> bool:
    """Write the seven phases of the way that takes T; tell whether there is one."""
    low, high = -task.top, task.top
    below, above = _miss(task, T, low), _miss(task, T, high)
    if below > 0.0 or above < 0.0:
        return False
    kept = 0
    for _ in range(_STEPS):
        c = (low * above - high * below) / (above - below) if above > below else low
        miss = _miss(task, T, c)
        if abs(miss) <= 0.1 * task.slack:
            return _write(task, T, c, spans, jerks)
        # an end that stays twice counts half
        if miss < 0.0:
            low, below = c, miss
            above *= 0.5 if kept < 0 else 1.0
            kept = -1
        else:
            high, above = c, miss
            below *= 0.5 if kept > 0 else 1.0
            kept = 1
    return False


@kernel
def _miss(task: Task, T: float, c: float) -> float:
    """Give by how much the way with this velocity goes beyond the goal."""
    _, _, _, _, first = _change(task.v0, task.a0, c)
    _, _, _, _, last = _change(task.vf, -task.af, c)
    return c * T + first + last - task.p


@kernel
def _change(v: float, a: float, c: float) -> tuple[float, float, float, float, float]:
    """Give the quickest change from (v, a) to (c, 0): sign, three durations, and the way beside c.

    The jerk is the sign, zero, and the opposite; the last is the integral of the velocity less c.
    """
    sign = 1.0 if c >= v + 0.5 * a * abs(a) else -1.0
    v, a, c = sign * v, sign * a, sign * c
    rise = max(c - v + 0.5 * a * a, 0.0)
    peak = max(a, min(1.0, math.sqrt(rise)))
    hold = max(rise - peak * peak, 0.0)
    up = peak - a
    way = up * (v - c + up * (0.5 * a + up / 6.0))
    v += 0.5 * (peak * peak - a * a)
    way += hold * (v - c + 0.5 * peak * hold)
    # the last part played backwards begins at (c, 0)
    way -= peak * peak * peak / 6.0
    return sign, up, hold, peak, sign * way


@kernel
def _write(task: Task, T: float, c: float, spans: FloatArray, jerks: FloatArray) -> bool:
    first, spans[0], spans[1], spans[2], _ = _change(task.v0, task.a0, c)
    last, spans[6], spans[5], spans[4], _ = _change(task.vf, -task.af, c)
    spans[3] = T - spans[0] - spans[1] - spans[2] - spans[4] - spans[5] - spans[6]
    jerks[0], jerks[1], jerks[2], jerks[3] = first, 0.0, -first, 0.0
    jerks[4], jerks[5], jerks[6] = -last, 0.0, last
    return bool(spans[3] >= 0.0)
