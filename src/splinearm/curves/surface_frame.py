"""Frames that stand on a surface, for what moves over it."""

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from .surface import BSplineSurface
from .surface_normal import normal, places, refuse, tangents

_STILL = 1e-11
"""A direction in which the surface moves by less than this share of its size is none."""


def surface_frame(
    surface: BSplineSurface, u: ArrayInput, v: ArrayInput, direction: ArrayInput
) -> FloatArray:
    """Give frames with z along the normal and x along a direction, shape (..., 3, 3).

    The columns are x, y and z, a right-handed frame; x and y touch the surface.

    Args:
        surface: A surface in space.
        u: First parameters, shape (...).
        v: Second parameters, shape (...).
        direction: Directions in the plane of parameters, of any length, shape (..., 2) or (2,).

    Raises:
        CurveError: If a place lies outside the domain, the surface is degenerate there, or does
            not move along the direction.
        ValueError: If the surface does not lie in space, or shapes do not fit.
    """
    us, vs = places(u, v)
    ways = np.asarray(direction, dtype=np.float64)
    if ways.shape[-1:] != (2,) or not np.isfinite(ways).all():
        raise ValueError(f"direction: want finite numbers of shape (..., 2), got {ways.tolist()}")
    shape = np.broadcast_shapes(us.shape, ways.shape[:-1])
    us, vs = np.broadcast_to(us, shape).ravel(), np.broadcast_to(vs, shape).ravel()
    ways = np.broadcast_to(ways, (*shape, 2)).reshape(-1, 2)
    found = tangents(surface, us, vs)
    refuse(found.degenerate, us, vs, "it is degenerate: no frame there")
    (u0, u1), (v0, v1) = surface.domain
    size = float(np.ptp(surface.points.reshape(-1, 3), axis=0).max())
    shares = np.abs(ways / (u1 - u0, v1 - v0)).sum(axis=1)
    x = ways[:, :1] * found.along_u + ways[:, 1:] * found.along_v
    length = np.linalg.norm(x, axis=1)
    refuse(length <= _STILL * size * shares, us, vs, "the direction leads nowhere: no frame there")
    x = x / length[:, None]
    z = normal(surface, us, vs)
    return np.stack((x, np.cross(z, x), z), axis=-1).reshape(*shape, 3, 3)
