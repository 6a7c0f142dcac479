"""Where searches start: joint vectors spread evenly between the limits. Bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray

from . import turn
from .chain import Chain, fk_batch
from .descent import Goal

CANDIDATES = 1024
"""Joint vectors of which a search takes its starts, unless it wants more."""

NEAREST = 24
"""How many starts are the nearest to the goal; the others are spread over the rest."""


def near_and_far(chain: Chain, goal: Goal, count: int) -> FloatArray:
    """Give ``count`` starts, shape (count, n): those nearest to the goal, then nearer to farther.

    The nearest may all lead to one place that is not the goal; the others are there for that.
    """
    candidates = spread(goal.lower, goal.upper, goal.units, max(CANDIDATES, count))
    ordered = nearest_first(chain, goal, candidates)
    others = ordered[NEAREST:]
    stride = max(1, len(others) // max(1, count - NEAREST))
    return np.concatenate((ordered[:NEAREST], others[::stride]))[:count]


def spread(lower: FloatArray, upper: FloatArray, units: FloatArray, count: int) -> FloatArray:
    """Give ``count`` joint vectors, shape (count, n), that fill the limits evenly.

    They are the same at every call. A joint without a limit, or with room for more than 2 pi of
    its units (a turn of a turning joint), is spread over that much about the middle.
    """
    # additive recurrence with powers of the generalised golden ratio: M. Roberts, The unreasonable
    # effectiveness of quasirandom sequences, 2018; the ratio is the root of x^(n + 1) = x + 1
    n = len(lower)
    ratio = 2.0
    for _ in range(60):
        ratio = (1.0 + ratio) ** (1.0 / (n + 1))
    shares = (0.5 + np.outer(np.arange(1, count + 1), ratio ** -np.arange(1.0, n + 1))) % 1.0
    middle = turn.middle(lower, upper)
    low, high = np.maximum(lower, middle - np.pi * units), np.minimum(upper, middle + np.pi * units)
    starts: FloatArray = low + shares * (high - low)
    return starts


def nearest_first(chain: Chain, goal: Goal, starts: FloatArray) -> FloatArray:
    """Give the starts, shape (m, n), in the order of how near their tools are to the goal."""
    T = fk_batch(chain, starts)
    miss = np.sum(((T[:, :3, 3] - goal.p) * goal.weights[0]) ** 2, axis=1)
    if goal.R is not None:
        # |R1 - R2|^2 = 8 sin^2(angle / 2): the square of the angle, nearly, times two
        turned = np.sum((T[:, :3, :3] - goal.R) ** 2, axis=(1, 2))
        miss += 0.5 * turned * goal.weights[-1] ** 2
    return starts[np.argsort(miss, kind="stable")]
