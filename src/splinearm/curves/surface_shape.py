"""How a surface is bent at its places, and how large it is."""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from .surface import BSplineSurface
from .surface_normal import check_space, places, refuse, tangents

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)

_AREA_ACCURACY = 1e-14
_MOST_HALVINGS = 30


class Forms(NamedTuple):
    """Both fundamental forms at places, as matrices by u and v."""

    first: FloatArray
    """Lengths: scalar products of the tangents, shape (..., 2, 2)."""
    second: FloatArray
    """Bends: second derivatives along the unit normal, shape (..., 2, 2)."""


class Curvatures(NamedTuple):
    """The principal curvatures at places and where they point.

    A curvature is positive where the surface bends towards its normal, so a sphere of radius r
    whose normals point outwards has -1 / r everywhere.
    """

    values: FloatArray
    """The smaller and the larger, shape (..., 2), 1/m."""
    directions: FloatArray
    """Unit vectors in space along them, at right angles, shape (..., 2, 3), of sign and, where both
    curvatures are the same, of direction that mean nothing."""
    parameters: FloatArray
    """The same directions by u and v, shape (..., 2, 2)."""

    @property
    def gaussian(self) -> FloatArray:
        """Their product, shape (...), 1/m^2."""
        product: FloatArray = self.values[..., 0] * self.values[..., 1]
        return product

    @property
    def mean(self) -> FloatArray:
        """Their mean, shape (...), 1/m."""
        half: FloatArray = 0.5 * (self.values[..., 0] + self.values[..., 1])
        return half


def fundamental_forms(surface: BSplineSurface, u: ArrayInput, v: ArrayInput) -> Forms:
    """Give both fundamental forms.

    Args:
        surface: A surface in space.
        u: First parameters, shape (...).
        v: Second parameters, shape (...).

    Raises:
        CurveError: If a place lies outside the domain, or the surface is degenerate there.
        ValueError: If the surface does not lie in space.
    """
    us, vs = places(u, v)
    _, first, second = _forms(surface, us.ravel(), vs.ravel())
    return Forms(first.reshape(*us.shape, 2, 2), second.reshape(*us.shape, 2, 2))


def curvatures(surface: BSplineSurface, u: ArrayInput, v: ArrayInput) -> Curvatures:
    """Give the principal curvatures and their directions.

    Args:
        surface: A surface in space.
        u: First parameters, shape (...).
        v: Second parameters, shape (...).

    Raises:
        CurveError: If a place lies outside the domain, or the surface is degenerate there.
        ValueError: If the surface does not lie in space.
    """
    us, vs = places(u, v)
    pair, first, second = _forms(surface, us.ravel(), vs.ravel())
    # in an orthonormal pair of tangents the shape operator is symmetric (do Carmo, Differential
    # Geometry of Curves and Surfaces, 1976, sec. 3-2): with tangents = e @ upper it is
    # upper^-T second upper^-1
    inverse = _inverse_upper(first)
    e = pair @ inverse
    bend = inverse.swapaxes(-1, -2) @ second @ inverse
    mean, half = (0.5 * (bend[:, 0, 0] + sign * bend[:, 1, 1]) for sign in (1.0, -1.0))
    apart = np.hypot(half, bend[:, 0, 1])
    values = np.stack((mean - apart, mean + apart), axis=-1)
    angle = 0.5 * np.arctan2(bend[:, 0, 1], half)
    c, s = np.cos(angle), np.sin(angle)
    turned = np.stack((-s, c, c, s), axis=-1).reshape(-1, 2, 2).swapaxes(-1, -2)
    directions = (e @ turned).swapaxes(-1, -2)
    parameters = (inverse @ turned).swapaxes(-1, -2)
    return Curvatures(
        values.reshape(*us.shape, 2),
        directions.reshape(*us.shape, 2, 3),
        parameters.reshape(*us.shape, 2, 2),
    )


def area(surface: BSplineSurface) -> float:
    """Give the area of a surface in space, m^2, to about 14 digits.

    Raises:
        ValueError: If the surface does not lie in space.
    """
    check_space(surface)
    ends_u, ends_v = surface.breaks
    low, high = (
        np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
        for u, v in ((ends_u[:-1], ends_v[:-1]), (ends_u[1:], ends_v[1:]))
    )
    whole, total = _areas(surface, low, high), 0.0
    accuracy = _AREA_ACCURACY * float(whole.sum())
    for _ in range(_MOST_HALVINGS):
        low, high = _quarters(low, high)
        parts = _areas(surface, low, high)
        fine = parts.reshape(-1, 4).sum(axis=1)
        rough = np.abs(fine - whole) > accuracy
        total += float(fine[~rough].sum())
        four = np.repeat(rough, 4)
        whole, low, high = parts[four], low[four], high[four]
        if not rough.any():
            break
    return total + float(whole.sum())


def _forms(
    surface: BSplineSurface, us: FloatArray, vs: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give the tangents as columns, shape (k, 3, 2), and both forms, shape (k, 2, 2)."""
    found = tangents(surface, us, vs)
    refuse(found.degenerate, us, vs)
    pair = np.stack((found.along_u, found.along_v), axis=-1)
    unit = found.across / np.linalg.norm(found.across, axis=1)[:, None]
    jets = surface.jet(us, vs, 2)
    uu, uv, vv = (np.sum(jets[:, i, j] * unit, axis=1) for i, j in ((2, 0), (1, 1), (0, 2)))
    second = np.stack((uu, uv, uv, vv), axis=-1).reshape(-1, 2, 2)
    return pair, pair.swapaxes(-1, -2) @ pair, second


def _inverse_upper(first: FloatArray) -> FloatArray:
    """Give what makes the tangents of first fundamental forms orthonormal, upper triangular."""
    length = np.sqrt(first[:, 0, 0])
    slant = first[:, 0, 1] / length
    height = np.sqrt(first[:, 1, 1] - slant * slant)
    inverse = np.zeros_like(first)
    inverse[:, 0, 0], inverse[:, 1, 1] = 1.0 / length, 1.0 / height
    inverse[:, 0, 1] = -slant / (length * height)
    return inverse


def _areas(surface: BSplineSurface, low: FloatArray, high: FloatArray) -> FloatArray:
    """Give the areas of rectangles of parameters, shape (k,), by Gauss quadrature."""
    half = 0.5 * (high - low)
    u, v = (
        np.minimum(low[:, i, None] + half[:, i, None] * (1.0 + _NODES), high[:, i, None])
        for i in (0, 1)
    )
    us, vs = np.broadcast_arrays(u[:, :, None], v[:, None, :])
    jets = surface.jet(us, vs, 1)
    normals = np.cross(jets[..., 1, 0, :], jets[..., 0, 1, :])
    density = np.sqrt(np.sum(normals * normals, axis=-1))
    sums: FloatArray = np.einsum("kij,i,j->k", density, _WEIGHTS, _WEIGHTS)
    areas: FloatArray = sums * half[:, 0] * half[:, 1]
    return areas


def _quarters(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the four quarters of each rectangle, one after the other."""
    size = 0.5 * (high - low)
    corner = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    starts = (low[:, None] + corner * size[:, None]).reshape(-1, 2)
    ends = np.where(corner == 1.0, high[:, None], (low + size)[:, None]).reshape(-1, 2)
    return starts, ends
