"""Memory for arrays that live shortly: fresh memory costs more than filling it."""

import math
import threading

import numpy as np

from splinearm.arrays import FloatArray

_KEPT = threading.local()

_MOST_KEPT = 1_000_000
"""Larger arrays are not kept."""


def scratch(name: str, *shape: int) -> FloatArray:
    """Give an array of any numbers; the next one of this name and thread uses the same memory."""
    size = math.prod(shape)
    if size > _MOST_KEPT:
        return np.empty(shape)
    kept: FloatArray | None = getattr(_KEPT, name, None)
    if kept is None or kept.size < size:
        kept = np.empty(max(size, 2 * (0 if kept is None else kept.size)))
        setattr(_KEPT, name, kept)
    return kept[:size].reshape(shape)
