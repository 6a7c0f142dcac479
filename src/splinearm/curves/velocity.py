"""Velocities of curves as polynomials on Bezier pieces, the weights multiplied out."""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from . import bernstein
from .basis import IndexArray
from .bspline import BSpline


class Velocity(NamedTuple):
    """Pieces of a curve: with t from 0 to 1 on a piece, dC/dt = V(t) / W(t)^2."""

    ends: FloatArray
    """Parameters where pieces begin and end, shape (k + 1,)."""
    V: FloatArray
    """Bernstein coefficients, shape (k, m + 1, dim)."""
    W: FloatArray
    """Those of the weight, shape (k, p + 1); of polynomial curves a single 1."""
    error: FloatArray
    """Bound on the rounding of each number of V, shape (k,)."""


def velocity_of(curve: BSpline) -> Velocity:
    """Give the velocity of a curve of degree 1 or more on its pieces."""
    p = curve.degree
    # from the first point of the curve: what lies far away has no finer numbers, but near it
    origin = curve.points[0]
    points = curve.points - origin
    size = float(np.abs(curve.points).max())
    if curve.weights is None:
        ends, rows = bernstein.bezier_pieces(curve.knots, points, p)
        V = bernstein.differentiate(rows.swapaxes(1, 2))
        W = np.ones((len(rows), 1))
        error = np.full(len(rows), 2.0 * p * (p + 1) * bernstein.EPS * size)
        return Velocity(ends, np.ascontiguousarray(V.swapaxes(1, 2)), W, error)
    weights = curve.weights[:, None]
    ends, rows = bernstein.bezier_pieces(curve.knots, np.hstack((points * weights, weights)), p)
    W = np.ascontiguousarray(rows[..., -1])
    # (A / w)' w^2 = A' w - A w', of A from the first point of the piece
    A = rows[..., :-1] - rows[..., -1:] * (rows[:, :1, :-1] / rows[:, :1, -1:])
    A, w = A.swapaxes(1, 2), W[:, None]
    V = bernstein.multiply(bernstein.differentiate(A), w)
    V -= bernstein.multiply(A, bernstein.differentiate(w))
    error = 8.0 * p * (p + 1) * bernstein.EPS * size * np.max(W, axis=1) ** 2
    return Velocity(ends, np.ascontiguousarray(V.swapaxes(1, 2)), W, error)


def directions(
    velocity: Velocity, piece: IndexArray, t: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give unit tangents and their derivatives by t, each of shape (k, dim).

    Args:
        velocity: The pieces.
        piece: Which piece, shape (k,).
        t: Where on it, from 0 to 1, shape (k,).

    Raises:
        CurveError: If the curve stands still at one of them.
    """
    V = velocity.V[piece]
    share = t[:, None, None]
    slope = np.diff(V, axis=1) * (V.shape[1] - 1) if V.shape[1] > 1 else np.zeros_like(V)
    for _ in range(V.shape[1] - 1):
        V = V[:, :-1] * (1.0 - share) + V[:, 1:] * share
    for _ in range(slope.shape[1] - 1):
        slope = slope[:, :-1] * (1.0 - share) + slope[:, 1:] * share
    here, change = V[:, 0], slope[:, 0]
    size = np.linalg.norm(here, axis=1)
    still = size <= velocity.error[piece]
    if still.any():
        k = int(np.argmax(still))
        start, end = velocity.ends[piece[k]], velocity.ends[piece[k] + 1]
        raise CurveError(
            f"it stands still at u = {start + t[k] * (end - start)}: no direction there", "curve"
        )
    tangent = here / size[:, None]
    bend = (change - np.sum(change * tangent, axis=1)[:, None] * tangent) / size[:, None]
    return tangent, bend


def locate(velocity: Velocity, u: FloatArray) -> tuple[IndexArray, FloatArray]:
    """Give the piece and t of parameters in the domain, of shape (k,) each."""
    ends = velocity.ends
    piece = np.clip(np.searchsorted(ends, u, side="right") - 1, 0, len(ends) - 2)
    return piece, (u - ends[piece]) / (ends[piece + 1] - ends[piece])
