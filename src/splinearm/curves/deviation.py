"""How far a curve may be from another of the same degree over the same knots, on bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray


def bound(rows: FloatArray, others: FloatArray, *, rational: bool) -> float:
    """Give a distance that the two curves are never apart at one parameter.

    Args:
        rows: Control points of one curve, shape (m, columns), homogeneous if it is rational.
        others: Those of the other.
        rational: Whether the last column is a weight.
    """
    # polynomial: the difference is a convex combination of differences of control points
    if not rational:
        return float(np.sqrt(((rows - others) ** 2).sum(axis=1)).max())
    # rational, with weights w and v and points P and Q: the difference times the weight function
    # of the first is the sum of N (w (P - Q) + (w - v) (Q - C)), where C is a point of the second
    # curve and so in the hull of Q
    w, v = rows[:, -1], others[:, -1]
    if not (v > 0.0).all():
        return float("inf")
    points, hull = rows[:, :-1] / w[:, None], others[:, :-1] / v[:, None]
    apart = np.sqrt(((points - hull) ** 2).sum(axis=1))
    low, high = hull.min(axis=0), hull.max(axis=0)
    across = np.sqrt((np.maximum(hull - low, high - hull) ** 2).sum(axis=1))
    return float((apart + np.abs(1.0 - v / w) * across).max())
