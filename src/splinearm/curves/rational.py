"""Rational curves as polynomial ones with one coordinate more, on bare arrays."""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError


def homogeneous(points: FloatArray, weights: FloatArray) -> FloatArray:
    """Give points times weight, then the weight, shape (m, dim + 1), read-only."""
    rows = np.empty((points.shape[0], points.shape[1] + 1))
    np.multiply(points, weights[:, None], out=rows[:, :-1])
    rows[:, -1] = weights
    rows.flags.writeable = False
    return rows


def quotient(jets: FloatArray) -> FloatArray:
    """Give the derivatives of (x / w, y / w ...) from those of (x, y ..., w).

    Args:
        jets: Value and derivatives in rising order, shape (order + 1, ..., dim + 1).

    Returns:
        The same of the quotient, shape (order + 1, ..., dim).
    """
    # Leibniz' rule for w C = A, solved for the highest derivative of C: Piegl and Tiller, The
    # NURBS Book, 2nd ed. 1997, eq. 4.8
    w = jets[..., -1:]
    values = np.array(jets[..., :-1])
    for k in range(len(jets)):
        for i in range(1, k + 1):
            values[k] -= math.comb(k, i) * w[i] * values[k - i]
        values[k] /= w[0]
    return values


def map_rows(rows: FloatArray, matrix: FloatArray) -> FloatArray:
    """Give homogeneous points under a map, their weights above 0.

    Raises:
        CurveError: If the map sends a place between the control points to infinity.
    """
    mapped: FloatArray = rows @ matrix.T
    if (mapped[:, -1] < 0.0).all():
        mapped = -mapped
    if not (mapped[:, -1] > 0.0).all():
        raise CurveError("the map sends a place between its control points to infinity", "B-spline")
    return mapped


def check_weights(rows: FloatArray) -> None:
    """Refuse homogeneous points, the outcome of some change, whose weights are not above 0."""
    if not (rows[:, -1] > 0.0).all():
        raise CurveError(f"a weight would become {rows[:, -1].min():.3g}, not above 0", "B-spline")
