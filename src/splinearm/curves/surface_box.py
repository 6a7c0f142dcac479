"""Boxes that surfaces fit into."""

import numpy as np

from splinearm.arrays import FloatArray

from .surface import BSplineSurface

_MOST_HALVINGS = 60


def control_box(surface: BSplineSurface) -> tuple[FloatArray, FloatArray]:
    """Give the least and the largest coordinates of the control points, each of shape (dim,).

    The surface lies inside; ``bounding_box`` is nearly the smallest such box.
    """
    return surface.points.min(axis=(0, 1)), surface.points.max(axis=(0, 1))


def bounding_box(
    surface: BSplineSurface, tolerance: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Give the least and the largest coordinates of a surface, each of shape (dim,).

    The surface lies inside, but for rounding, and comes as near to each side as the tolerance.

    Args:
        surface: The surface.
        tolerance: How far the box may reach beyond it; None: 1e-9 of its size.

    Raises:
        ValueError: If the tolerance is not above 0.
    """
    low, high = control_box(surface)
    room = 1e-9 * float((high - low).max()) if tolerance is None else tolerance
    if tolerance is not None and not tolerance > 0.0:
        raise ValueError(f"tolerance: want it above 0, got {tolerance}")
    _, _, pieces = surface.bezier()
    p, q = surface.degree_u, surface.degree_v
    nets = pieces.reshape(-1, p + 1, q + 1, pieces.shape[-1])
    weights = nets[..., -1] if surface.is_rational else np.ones(nets.shape[:-1])
    dim = surface.dim
    largest = np.array([_largest(np.stack((nets[..., c], weights)), room) for c in range(dim)])
    least = np.array([-_largest(np.stack((-nets[..., c], weights)), room) for c in range(dim)])
    return least, largest


def _largest(nets: FloatArray, room: float) -> float:
    """Give a close upper bound of value / weight on patches, shape (2, k, p + 1, q + 1)."""
    best = bound = -np.inf
    eps = 4.0 * np.finfo(np.float64).eps * float(np.abs(nets[0] / nets[1]).max())
    room = max(room, eps)
    for _ in range(_MOST_HALVINGS):
        values = nets[0] / nets[1]
        best = max(best, float(values[:, [0, 0, -1, -1], [0, -1, 0, -1]].max()))
        tops = values.max(axis=(1, 2))
        alive = tops > best + room
        bound = max(bound, float(tops[~alive].max(initial=best)))
        if not alive.any():
            return bound
        nets, values = nets[:, alive], values[alive]
        # halving the direction in which values hardly differ would not bring the bound down: a
        # ridge along u asks for halves along v only
        bend_u = np.abs(np.diff(values, axis=1)).sum(axis=(1, 2))
        bend_v = np.abs(np.diff(values, axis=2)).sum(axis=(1, 2))
        along_u = bend_u > bend_v
        nets = np.concatenate((halves(nets[:, along_u], 2), halves(nets[:, ~along_u], 3)), axis=1)
    return max(bound, float((nets[0] / nets[1]).max()))


def halves(nets: FloatArray, axis: int) -> FloatArray:
    """Give the control points of both halves along an axis, first halves first along axis 1."""
    # de Casteljau
    local = np.moveaxis(nets, axis, 0)
    first, last = [local[0]], [local[-1]]
    while len(local) > 1:
        local = 0.5 * (local[:-1] + local[1:])
        first.append(local[0])
        last.append(local[-1])
    both = np.concatenate((np.stack(first), np.stack(last[::-1])), axis=2)
    return np.moveaxis(both, 0, axis)
