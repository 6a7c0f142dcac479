"""The farthest way of one joint in a given time, with limits of velocity and acceleration only.

What ``extremal_kernel`` is without a limit of jerk, with the same doors: up to a highest velocity,
perhaps a rest there, and down. Units are the joint's own: both limits are 1. D is half the time.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .extremal_kernel import Side


@kernel
def side_of(v0: float, vf: float) -> Side:
    """Give what the shape depends on, laid out as that of ``extremal_kernel``."""
    full = max(1.0 - 0.5 * (v0 + vf), 0.0)
    return Side(v0, 0.0, vf, 0.0, 0.0, False, 0.0, 0.0, 0.0, 0.0, full, 1.0, 0.0)


@kernel
def place_of(side: Side, D: float) -> float:
    """Give the distance P."""
    v0, vf, full = side.v0, side.vf, side.full
    v = 1.0 if full <= D else D + 0.5 * (v0 + vf)
    return v * v - 0.5 * (v0 * v0 + vf * vf) + 2.0 * max(D - full, 0.0)


@kernel
def roots_of(side: Side, p: float, out: FloatArray, k: int) -> int:
    """Write the D where P = p to out[k:]; give the new k."""
    v0, vf, full = side.v0, side.vf, side.full
    square = p + 0.5 * (v0 * v0 + vf * vf)
    if square >= 1.0:
        out[k] = full + 0.5 * (square - 1.0)
        return k + 1
    if square < 0.0:
        return k
    v = math.sqrt(square)
    for peak in (-v, v):
        if peak >= max(v0, vf):
            out[k] = peak - 0.5 * (v0 + vf)
            k += 1
    return k


@kernel
def phases_of(side: Side, D: float, sign: float, spans: FloatArray, controls: FloatArray) -> None:
    """Write the durations and accelerations of the phases; ``sign`` -1 turns the way round."""
    v0, vf, full = side.v0, side.vf, side.full
    v = 1.0 if full <= D else max(D + 0.5 * (v0 + vf), v0, vf)
    for i in range(7):
        spans[i] = controls[i] = 0.0
    spans[0], spans[3], spans[4] = v - v0, 2.0 * max(D - full, 0.0), v - vf
    controls[0], controls[4] = sign, -sign
