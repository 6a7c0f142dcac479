"""What curves fit into: boxes and, in the plane, convex hulls."""

import numpy as np

from splinearm.arrays import FloatArray

from .bspline import BSpline

_MOST_HALVINGS = 60


def control_box(curve: BSpline) -> tuple[FloatArray, FloatArray]:
    """Give the least and the largest coordinates of the control points, each of shape (dim,).

    The curve lies inside; ``bounding_box`` is the smallest such box.
    """
    return curve.points.min(axis=0), curve.points.max(axis=0)


def bounding_box(curve: BSpline) -> tuple[FloatArray, FloatArray]:
    """Give the least and the largest coordinates of a curve, each of shape (dim,).

    They are right to rounding: pieces whose control points reach beyond what is known to be on
    the curve are halved until they no longer do.
    """
    _, pieces = curve.bezier()
    if not curve.is_rational:
        pieces = np.concatenate((pieces, np.ones((*pieces.shape[:2], 1))), axis=2)
    largest = np.array([_largest(pieces, c) for c in range(curve.dim)])
    flipped = pieces * np.append(np.full(curve.dim, -1.0), 1.0)
    least = np.array([-_largest(flipped, c) for c in range(curve.dim)])
    return least, largest


def _largest(pieces: FloatArray, coordinate: int) -> float:
    """Give the largest value of a coordinate on rational pieces, shape (k, degree + 1, dim + 1)."""
    local = pieces[..., (coordinate, -1)]
    best = -np.inf
    accuracy = 2.0 * np.finfo(np.float64).eps * float(np.abs(local[..., 0] / local[..., 1]).max())
    for _ in range(_MOST_HALVINGS):
        values = local[..., 0] / local[..., 1]
        best = max(best, float(values[:, 0].max()), float(values[:, -1].max()))
        local = local[values.max(axis=1) > best + accuracy]
        if not local.size:
            break
        local = _halves(local)
    return best


def _halves(pieces: FloatArray) -> FloatArray:
    """Give the control points of both halves of each piece, by de Casteljau."""
    first, last = [pieces[:, 0]], [pieces[:, -1]]
    while pieces.shape[1] > 1:
        pieces = 0.5 * (pieces[:, :-1] + pieces[:, 1:])
        first.append(pieces[:, 0])
        last.append(pieces[:, -1])
    return np.concatenate((np.stack(first, axis=1), np.stack(last[::-1], axis=1)))


def convex_hull(curve: BSpline, *, pieces: bool = False) -> FloatArray:
    """Give the corners of a convex polygon around a plane curve, anticlockwise, shape (k, 2).

    Args:
        curve: A curve of two coordinates.
        pieces: Whether control points of its Bezier pieces are taken, which is tighter, instead
            of its own.

    Raises:
        ValueError: If the curve has another number of coordinates.
    """
    if curve.dim != 2:
        raise ValueError(f"dim: want a curve in the plane for a hull, got {curve.dim} coordinates")
    points = curve.points
    if pieces:
        rows = curve.bezier()[1].reshape(-1, 2 + curve.is_rational)
        points = rows[:, :2] / rows[:, 2:] if curve.is_rational else rows
    # Andrew, Another efficient algorithm for convex hulls in two dimensions, IPL 9 (1979) 216
    ordered = np.unique(points, axis=0)
    if len(ordered) < 3:
        return ordered
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return np.array(lower[:-1] + upper[:-1])


def _chain(points: FloatArray) -> list[FloatArray]:
    """Give the half of the hull on the right side of the way from the first to the last point."""
    chain: list[FloatArray] = []
    for p in points:
        while len(chain) > 1:
            (ax, ay), (bx, by) = chain[-1] - chain[-2], p - chain[-1]
            if ax * by - ay * bx > 0.0:
                break
            chain.pop()
        chain.append(p)
    return chain
