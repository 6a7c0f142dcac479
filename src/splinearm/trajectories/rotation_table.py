"""Curves of rotations as tables of turns by polynomials, which compiled kernels sample."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .turning import Turning, inside


def make(
    breaks: FloatArray, starts: FloatArray, turns: FloatArray, shares: FloatArray
) -> FloatArray:
    """Give the table, as ``rotation_kernel`` describes it, of products of turns.

    Args:
        breaks: Ends of the pieces, rising, shape (k + 1,).
        starts: Orientation before all turns of each piece, unit quaternions, shape (k, 4).
        turns: Turns of each piece, rotation vectors, shape (k, r, 3).
        shares: How much of each turn has been made: coefficients of falling powers of u less the
            start of the piece, shape (k, r, degree + 1).
    """
    k, r, coefficients = shares.shape
    angles = np.linalg.norm(turns, axis=2, keepdims=True)
    axes = turns / np.where(angles > 0.0, angles, 1.0)
    table = np.zeros((k + 1, 5 + r * (4 + coefficients)))
    table[:, 0] = breaks
    table[:-1, 1:5] = starts
    table[:-1, 5:] = np.concatenate((axes, angles, shares), axis=2).reshape(k, -1)
    table[-1, 1:3] = coefficients - 1, r
    # it is left writable: numba passes a frozen array more slowly
    return table


def domain_of(table: FloatArray) -> tuple[float, float]:
    """Give first and last parameter."""
    return float(table[0, 0]), float(table[-1, 0])


def sample(table: FloatArray, u: ArrayInput) -> Turning:
    """Give orientations, angular velocities and accelerations at parameters, shape (m,).

    Raises:
        CurveError: If one lies outside the domain.
    """
    parameters = np.ascontiguousarray(u, dtype=np.float64)
    m = parameters.size
    turning = Turning(np.empty((m, 4)), np.empty((m, 3)), np.empty((m, 3)))
    if _kernels()[1](table, parameters, *turning) >= 0:
        inside(parameters, domain_of(table))
    return turning


def sample_into(table: FloatArray, u: float, state: FloatArray) -> None:
    """Write orientation, angular velocity and acceleration at one parameter, shape (10,).

    Raises:
        CurveError: If the parameter lies outside the domain or is not a number.
        ValueError: If ``state`` has not that shape.
        TypeError: If ``state`` is no contiguous array of float64.
    """
    if _kernels()[0](table, u, state):
        if state.shape == (10,):
            start, end = domain_of(table)
            raise CurveError(f"defined from {start} to {end}, not at {u}", "orientation")
        raise ValueError(f"state: want shape (10,), got {state.shape}")


@cache
def _kernels() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Give the kernels for one parameter and for many, compiled for their arguments."""
    from splinearm.compiled import entry, inputs, numbers, outputs

    from . import rotation_kernel as kernel

    return (
        entry(kernel.sample_one, *inputs(2), *numbers(), *outputs(1)),
        entry(kernel.sample_many, *inputs(2, 1), *outputs(2, 2, 2)),
    )
