"""Quintic pieces with given value, slope and bend at both ends, on bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray

from .bspline import BSpline

Jet = tuple[FloatArray, FloatArray, FloatArray]
"""Value, first and second derivative."""


def quintic_pieces(h: FloatArray, starts: Jet, ends: Jet) -> FloatArray:
    """Give the coefficients of quintics on pieces of lengths h, shape (k, 6, dim).

    Args:
        h: Lengths of the pieces, shape (k,).
        starts: Value, first and second derivative at the starts, each of shape (k, dim).
        ends: The same at the ends.
    """
    h = h[:, None]
    step = ends[0] - starts[0]
    v0, v1 = starts[1] * h, ends[1] * h
    a0, a1 = starts[2] * h**2, ends[2] * h**2
    return np.stack(
        (
            starts[0],
            starts[1],
            0.5 * starts[2],
            (10.0 * step - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1) / h**3,
            (-15.0 * step + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1) / h**4,
            (6.0 * step - 3.0 * (v0 + v1) - 0.5 * (a0 - a1)) / h**5,
        ),
        axis=1,
    )


def quintic_spline(u: FloatArray, nodes: Jet) -> BSpline:
    """Give the quintic B-spline, C2, with value, slope and bend at its nodes.

    Args:
        u: Parameters of the nodes, rising, shape (k + 1,).
        nodes: Value, first and second derivative there, each of shape (k + 1, dim).
    """
    # with triple knots three control points belong to a node. Each is the blossom of five knots
    # around the node, of which all but two are the node itself: with distances d1 and d2 it is
    # f + (d1 + d2) f' / 5 + d1 d2 f'' / 20 (Ramshaw, Blossoms are polar forms, 1989)
    steps = np.concatenate(([0.0], np.diff(u), [0.0]))[:, None]
    before, behind = -steps[:-1], steps[1:]
    value, slope, bend = nodes
    points = np.stack(
        [
            value + 0.2 * (d1 + d2) * slope + 0.05 * d1 * d2 * bend
            for d1, d2 in ((before, before), (before, behind), (behind, behind))
        ],
        axis=1,
    )
    knots = np.concatenate((u[:1], u[:1], u[:1], np.repeat(u, 3), u[-1:], u[-1:], u[-1:]))
    return BSpline(knots, points.reshape(-1, points.shape[2]), 5)


def cubic_spline(u: FloatArray, values: FloatArray, slopes: FloatArray) -> BSpline:
    """Give the C1 cubic through values with given slopes.

    Args:
        u: Parameters, rising, shape (m,).
        values: Shape (m, dim).
        slopes: Derivatives by u, shape (m, dim).
    """
    third = np.diff(u)[:, None] / 3.0
    inner = np.stack((values[:-1] + third * slopes[:-1], values[1:] - third * slopes[1:]), axis=1)
    points = np.vstack((values[:1], inner.reshape(-1, values.shape[1]), values[-1:]))
    ends = np.full(2, u[0]), np.full(2, u[-1])
    return BSpline(np.concatenate((ends[0], np.repeat(u, 2), ends[1])), points, 3)


def cubic_values(
    ends: FloatArray, values: FloatArray, slopes: FloatArray, u: FloatArray
) -> FloatArray:
    """Give the cubic between two ends with given values and slopes at many u, shape (k, dim)."""
    h = ends[1] - ends[0]
    x = ((u - ends[0]) / h)[:, None]
    step = values[1] - values[0]
    first, last = h * slopes[0] - step, step - h * slopes[1]
    # the chord and what the slopes bend it by
    bent: FloatArray = values[0] + x * step + x * (1.0 - x) * (first * (1.0 - x) + last * x)
    return bent
