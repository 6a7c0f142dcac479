"""Motions of constant jerk from phase to phase: sampled, and how far they go.

``phases``, shape (n, m, 5), holds t, q, qd, qdd and qddd at the begin of each phase of each joint.
The last phases of a joint begin where the motion ends and have no duration.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel


@kernel
def sample_into(phases: FloatArray, ts: FloatArray, out: FloatArray) -> None:
    """Write q, qd, qdd and qddd at times within the motion, to ``out`` of shape (4, m, n).

    Where a phase ends and the next one begins it is the next one that speaks.
    """
    n, rows, _ = phases.shape
    at = np.zeros(n, dtype=np.int64)
    for j in range(ts.shape[0]):
        t = ts[j]
        for i in range(n):
            k = at[i] if phases[i, at[i], 0] <= t else 0
            while k + 1 < rows and phases[i, k + 1, 0] <= t:
                k += 1
            at[i] = k
            q, v, a = state_of(phases[i, k], t - phases[i, k, 0])
            out[0, j, i], out[1, j, i], out[2, j, i] = q, v, a
            out[3, j, i] = phases[i, k, 4]


@kernel
def state_of(phase: FloatArray, h: float) -> tuple[float, float, float]:
    """Give q, qd and qdd so long after the begin of a phase."""
    v, a, u = phase[2], phase[3], phase[4]
    q = phase[1] + h * (v + h * (0.5 * a + h * u / 6.0))
    return q, v + h * (a + 0.5 * h * u), a + h * u


@kernel
def range_into(phases: FloatArray, out: FloatArray) -> None:
    """Write each joint's lowest place, when, its highest and when, first times; shape (n, 4)."""
    n, rows, _ = phases.shape
    for i in range(n):
        out[i, 0], out[i, 2] = phases[i, 0, 1], phases[i, 0, 1]
        out[i, 1], out[i, 3] = phases[i, 0, 0], phases[i, 0, 0]
        for k in range(rows):
            _extend(phases[i, k, 1], phases[i, k, 0], out[i])
            if k + 1 == rows:
                break
            first, second = _rests(phases[i, k, 2], phases[i, k, 3], phases[i, k, 4])
            for h in (first, second):
                if 0.0 < h < phases[i, k + 1, 0] - phases[i, k, 0]:
                    q, _, _ = state_of(phases[i, k], h)
                    _extend(q, phases[i, k, 0] + h, out[i])


@kernel
def _extend(q: float, t: float, out: FloatArray) -> None:
    if q < out[0]:
        out[0], out[1] = q, t
    if q > out[2]:
        out[2], out[3] = q, t


@kernel
def _rests(v: float, a: float, u: float) -> tuple[float, float]:
    """Give the times at which v + a h + u h^2/2 is zero, NaN where there is none."""
    square = a * a - 2.0 * u * v
    if square < 0.0:
        return math.nan, math.nan
    # the root without cancellation first; the other one from their product
    sum_ = -(a + math.copysign(math.sqrt(square), a))
    first = sum_ / u if u != 0.0 else math.nan
    second = 2.0 * v / sum_ if sum_ != 0.0 else math.nan
    return first, second
