"""Whole turns: which of the angles that mean the same a joint shall take. Bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray

_TURN = 2.0 * np.pi
_ROUNDING = 1e-12


def middle(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Give the middle of limits, shape (n,); a joint without them has it at 0 or at the limit."""
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper, 0.0))
    high = np.where(np.isfinite(upper), upper, low)
    centre: FloatArray = 0.5 * (low + high)
    return centre


def nearest(q: FloatArray, near: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Give angles (n,) with whole turns added: within the limits, then nearest to ``near`` (n,).

    An angle that no whole turn brings within its limits comes back as near to them as one can.
    What lies beyond a limit by rounding alone is put on it.
    """
    turned = q + _TURN * np.round((near - q) / _TURN)
    turned = turned - _TURN * np.ceil((turned - upper - _ROUNDING) / _TURN).clip(0.0)
    raised = turned + _TURN * np.ceil((lower - _ROUNDING - turned) / _TURN).clip(0.0)
    fits = raised <= upper + _ROUNDING
    # none fits: the two candidates are the last below and the first above
    below = lower - (raised - _TURN) < raised - upper
    turned = np.where(fits, raised, np.where(below, raised - _TURN, raised))
    on_limit = np.clip(turned, lower, upper)
    return np.where(np.abs(turned - on_limit) <= _ROUNDING, on_limit, turned)
