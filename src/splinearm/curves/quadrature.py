"""Arc length of curves by Gauss quadrature."""

from typing import Protocol

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)

_LENGTH_ACCURACY = 1e-15
_MOST_HALVINGS = 40


class Differentiable(Protocol):
    """A curve that gives its derivatives."""

    def at(self, u: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give a derivative at many parameters, shape (..., dim)."""
        ...


def length(curve: Differentiable, starts: FloatArray, ends: FloatArray) -> float:
    """Give the arc length over pieces, each halved until its length no longer changes."""
    total = 0.0
    lengths = _gauss_lengths(curve, starts, ends)
    accuracy = _LENGTH_ACCURACY * float(lengths.sum())
    for _ in range(_MOST_HALVINGS):
        middles = 0.5 * (starts + ends)
        first, last = _gauss_lengths(curve, starts, middles), _gauss_lengths(curve, middles, ends)
        rough = np.abs(first + last - lengths) > accuracy
        total += float((first + last)[~rough].sum())
        starts, ends = (
            np.append(starts, middles)[np.tile(rough, 2)],
            np.append(middles, ends)[np.tile(rough, 2)],
        )
        lengths = np.append(first, last)[np.tile(rough, 2)]
        if not rough.any():
            break
    return total + float(lengths.sum())


def _gauss_lengths(curve: Differentiable, starts: FloatArray, ends: FloatArray) -> FloatArray:
    half = 0.5 * (ends - starts)[:, None]
    u = np.minimum(starts[:, None] + half * (1.0 + _NODES), ends[:, None])
    speed = np.linalg.norm(curve.at(u, 1), axis=-1)
    lengths: FloatArray = np.sum(speed * _WEIGHTS * half, axis=1)
    return lengths
