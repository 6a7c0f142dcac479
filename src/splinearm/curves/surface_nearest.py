"""The place of a surface that is nearest to a point, found for certain."""

from functools import cache
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import bernstein
from .surface import BSplineSurface
from .surface_box import halves

_MOST_HALVINGS = 120
_MOST_PATCHES = 200_000
_STEPS = 60
_TRIALS = 4
_EPS = float(np.finfo(np.float64).eps)


class SurfacePlace(NamedTuple):
    """A place on a surface, and how far it is from where it was looked for."""

    u: float
    """First parameter."""
    v: float
    """Second parameter."""
    point: FloatArray
    """The point of the surface, shape (dim,)."""
    distance: float
    """Its distance, m."""


def nearest_on_surface(
    surface: BSplineSurface, point: ArrayInput, tolerance: float | None = None
) -> SurfacePlace:
    """Give a place of the surface than which none is nearer to a point but for the tolerance.

    Patches are halved until what is left of them cannot hold a nearer place: the polynomial of the
    squared distance lies above its control points' least.

    Args:
        surface: The surface.
        point: The point, shape (dim,).
        tolerance: By how much another place might be nearer, m; None: 1e-9 of the size of surface
            and distance.

    Raises:
        CurveError: If rounding or too many equally near places leave it open.
        ValueError: If the point has another number of coordinates or the tolerance is not above 0.
    """
    target = frozen_array(point, (surface.dim,), "point")
    if tolerance is not None and not tolerance > 0.0:
        raise ValueError(f"tolerance: want it above 0, got {tolerance}")
    low, high = surface.points.min(axis=(0, 1)), surface.points.max(axis=(0, 1))
    size = float(np.maximum(np.abs(low - target), np.abs(high - target)).max())
    room = 1e-9 * size if tolerance is None else tolerance
    nets, corners = _patches(surface, target)
    best, last_v = SurfacePlace(0.0, 0.0, target, np.inf), 2 * surface.degree_v
    for halving in range(_MOST_HALVINGS):
        squares, weights, reach = _squares(nets, (surface.degree_u, surface.degree_v))
        ratios = squares / weights
        ends = ratios[:, [0, last_v, -1 - last_v, -1]]
        k, corner = np.unravel_index(int(np.argmin(ends)), ends.shape)
        # a corner nearer than what is known is followed down to its foot; so are the first few
        if ends[k, corner] < best.distance**2 or halving < _TRIALS:
            start = corners[k, [corner // 2, corner % 2], [0, 1]]
            found = _foot(surface, target, start)
            best = found if found.distance < best.distance else best
        allowed = best.distance - room
        if allowed <= 0.0:
            return best
        alive = ratios.min(axis=1) - 16.0 * _EPS * size * reach < allowed**2
        if not alive.any():
            return best
        if np.count_nonzero(alive) > _MOST_PATCHES:
            break
        nets, corners = _halved(nets[:, alive], corners[alive], along_u=halving % 2 == 0)
    raise CurveError(
        f"no place is certain to be the nearest to {room:.3g} m; the best found is at u = "
        f"{best.u}, v = {best.v}, {best.distance:.9g} m away",
        "surface",
    )


def _patches(surface: BSplineSurface, target: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the patches as seen from a point, and their corners.

    Shapes (dim + 1, k, p + 1, q + 1), homogeneous, and (k, 2, 2): first and last corner, u and v.
    """
    ends_u, ends_v, patches = surface.bezier()
    flat = np.moveaxis(patches.reshape(-1, *patches.shape[2:]), -1, 0)
    weights = flat[-1:] if surface.is_rational else np.ones((1, *flat.shape[1:]))
    gaps = flat[: surface.dim] - target[:, None, None, None] * weights
    low = np.stack(np.meshgrid(ends_u[:-1], ends_v[:-1], indexing="ij"), axis=-1)
    high = np.stack(np.meshgrid(ends_u[1:], ends_v[1:], indexing="ij"), axis=-1)
    return np.concatenate((gaps, weights)), np.stack((low, high), axis=2).reshape(-1, 2, 2)


def _squares(
    nets: FloatArray, degrees: tuple[int, int]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give squared distance times squared weight, the latter, and the farthest control point.

    Shapes (k, (2 p + 1) (2 q + 1)) twice, and (k,).
    """
    flat = np.moveaxis(nets.reshape(*nets.shape[:2], -1), 0, -1)
    gaps, weights = flat[..., :-1], flat[..., -1:]
    table = _product_table(*degrees)
    both = [(x @ x.swapaxes(1, 2)).reshape(len(x), -1) @ table for x in (gaps, weights)]
    reach: FloatArray = np.sqrt(np.sum((gaps / weights) ** 2, axis=2).max(axis=1))
    return both[0], both[1], reach


@cache
def _product_table(p: int, q: int) -> FloatArray:
    """Give what products of pairs of coefficients count in the square of a Bernstein polynomial."""
    # Farouki and Rajan, Algorithms for polynomials in Bernstein form, CAGD 5 (1988) eq. 44
    tables = []
    for degree in (p, q):
        own = bernstein.binomials(degree)
        table = np.zeros((degree + 1, degree + 1, 2 * degree + 1))
        i, j = np.indices(table.shape[:2])
        table[i, j, i + j] = own[i] * own[j] / bernstein.binomials(2 * degree)[i + j]
        tables.append(table)
    product = np.einsum("ikm,jln->ijklmn", *tables)
    flat: FloatArray = product.reshape(((p + 1) * (q + 1)) ** 2, -1)
    return flat


def _halved(
    nets: FloatArray, corners: FloatArray, *, along_u: bool
) -> tuple[FloatArray, FloatArray]:
    """Give both halves of each patch in one direction."""
    axis = 0 if along_u else 1
    middles = 0.5 * (corners[:, 0, axis] + corners[:, 1, axis])
    first, last = corners.copy(), corners.copy()
    first[:, 1, axis], last[:, 0, axis] = middles, middles
    return halves(nets, 2 + axis), np.concatenate((first, last))


def _foot(surface: BSplineSurface, target: FloatArray, start: FloatArray) -> SurfacePlace:
    """Give a place near a start that is not moved towards the point by small steps any more."""
    # Levenberg and Marquardt's method for the least squared distance, kept in the domain: a
    # parameter at an edge that would leave it waits there
    low, high = np.array(surface.domain).T
    uv, damping = np.clip(start, low, high), 1e-6
    jet = surface.jet(uv[0], uv[1], 2)
    square = float(np.sum((jet[0, 0] - target) ** 2))
    for _ in range(_STEPS):
        step = _step(jet, target, (uv, low, high), damping)
        moved = np.clip(uv + step, low, high)
        if np.abs(moved - uv).max() <= 4.0 * _EPS * np.abs(high - low).max():
            break
        there = surface.jet(moved[0], moved[1], 2)
        nearer = float(np.sum((there[0, 0] - target) ** 2))
        if nearer <= square:
            uv, jet, damping = moved, there, 0.1 * damping
            square = nearer
        else:
            damping *= 10.0
    point = jet[0, 0]
    return SurfacePlace(float(uv[0]), float(uv[1]), point, float(np.linalg.norm(point - target)))


def _step(
    jet: FloatArray,
    target: FloatArray,
    where: tuple[FloatArray, FloatArray, FloatArray],
    damping: float,
) -> FloatArray:
    """Give the damped Newton step, (2,)."""
    uv, low, high = where
    gap = jet[0, 0] - target
    pair = np.stack((jet[1, 0], jet[0, 1]))
    pull = pair @ gap
    lengths = pair @ pair.T
    bends = np.array([[jet[2, 0] @ gap, jet[1, 1] @ gap], [jet[1, 1] @ gap, jet[0, 2] @ gap]])
    free = ~(((uv <= low) & (pull > 0.0)) | ((uv >= high) & (pull < 0.0)))
    hessian = lengths + bends
    scale = np.diag(lengths)
    # where the squared distance is no bowl, its part that always is one leads on
    bowl = hessian[0, 0] > 0.0 and hessian[1, 1] > 0.0 and np.linalg.det(hessian) > 0.0
    matrix = (hessian if bowl else lengths) + np.diag(damping * scale)
    step = np.zeros(2)
    index = np.flatnonzero(free)
    if index.size:
        step[index] = -np.linalg.lstsq(matrix[np.ix_(index, index)], pull[index], rcond=None)[0]
    return step
