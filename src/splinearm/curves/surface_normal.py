"""Unit normals of surfaces in space, also where a patch is degenerate but has a normal."""

from math import pi
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .surface import BSplineSurface

_FLAT = 1e-11
"""Below this share of what the size of the surface lets expect, an area of its tangents is none."""

_HIGHEST = 4
"""The highest derivative of the normal vector that is looked at for a limit."""

_SAME = 1e-6
"""Limits that are no farther apart than this are one."""

_TURNS = np.linspace(0.0, 0.5 * pi, 5)


_Span = tuple[tuple[float, float], tuple[float, float]]


class Tangents(NamedTuple):
    """A surface to first order at places, each of shape (k, ...)."""

    along_u: FloatArray
    """First derivative by u, shape (k, 3)."""
    along_v: FloatArray
    """First derivative by v, shape (k, 3)."""
    across: FloatArray
    """Their vector product, shape (k, 3)."""
    degenerate: npt.NDArray[np.bool]
    """Where that has no length worth naming, shape (k,)."""


def normal(surface: BSplineSurface, u: ArrayInput, v: ArrayInput) -> FloatArray:
    """Give unit normals, shape (..., 3): the direction of (derivative by u) x (derivative by v).

    Where that vanishes, as at the pole of a sphere, it is the limit that normals around the place
    have, from wherever in the domain they come.

    Args:
        surface: A surface in space.
        u: First parameters, shape (...).
        v: Second parameters, shape (...).

    Raises:
        CurveError: If a place lies outside the domain, or has no such limit.
        ValueError: If the surface does not lie in space.
    """
    us, vs = places(u, v)
    found = tangents(surface, us.ravel(), vs.ravel())
    length = np.linalg.norm(found.across, axis=1)
    units = found.across / np.where(found.degenerate, 1.0, length)[:, None]
    parts = dict[_Span, BSplineSurface]()
    for k in np.flatnonzero(found.degenerate):
        units[k] = _limit(surface, float(us.ravel()[k]), float(vs.ravel()[k]), parts)
    return units.reshape(*us.shape, 3)


def places(u: ArrayInput, v: ArrayInput) -> tuple[FloatArray, FloatArray]:
    """Give both parameters of each place, of one shape."""
    us, vs = np.broadcast_arrays(np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64))
    return us, vs


def tangents(surface: BSplineSurface, us: FloatArray, vs: FloatArray) -> Tangents:
    """Give both tangents and the normal vector at places, shape (k,) each."""
    check_space(surface)
    jets = surface.jet(us, vs, 1)
    along_u, along_v = jets[:, 1, 0], jets[:, 0, 1]
    across = np.cross(along_u, along_v)
    area = np.sqrt(np.sum(across * across, axis=1))
    return Tangents(along_u, along_v, across, area <= _FLAT * _expected_area(surface))


def check_space(surface: BSplineSurface) -> None:
    """Refuse a surface that does not lie in space."""
    if surface.dim != 3:
        raise ValueError(f"surface: want 3 coordinates, got {surface.dim}")


def refuse(
    where: npt.NDArray[np.bool], us: FloatArray, vs: FloatArray, what: str = "it is degenerate"
) -> None:
    """Refuse the first of some places."""
    if where.any():
        k = int(np.argmax(where))
        raise CurveError(what, f"surface at u = {us.ravel()[k]:.9g}, v = {vs.ravel()[k]:.9g}")


def _expected_area(surface: BSplineSurface) -> float:
    """Give the square of the surface's size by the area of its domain."""
    corner = surface.points.reshape(-1, 3)
    size = float(np.ptp(corner, axis=0).max())
    (u0, u1), (v0, v1) = surface.domain
    return size * size / ((u1 - u0) * (v1 - v0))


def _limit(
    surface: BSplineSurface, u: float, v: float, parts: dict[_Span, BSplineSurface]
) -> FloatArray:
    """Give the normal that normals near a place tend to; ``parts`` are patches cut out already."""
    enough = _FLAT * _expected_area(surface)
    found = list[FloatArray]()
    for piece_u, signs_u in _pieces(surface.breaks[0], u):
        for piece_v, signs_v in _pieces(surface.breaks[1], v):
            if (piece_u, piece_v) not in parts:
                parts[piece_u, piece_v] = surface.part(piece_u, piece_v)
            piece = parts[piece_u, piece_v]
            spans = piece_u[1] - piece_u[0], piece_v[1] - piece_v[0]
            series = _normal_series(piece.jet(u, v, _HIGHEST + 1), spans)
            enough_here = enough * spans[0] * spans[1]
            for sign_u in signs_u:
                for sign_v in signs_v:
                    ways = np.stack((sign_u * np.cos(_TURNS), sign_v * np.sin(_TURNS)), axis=1)
                    found += [_first_along(series, way, enough_here) for way in ways]
    limits = np.array([way for way in found if way.size])
    where = f"surface at u = {u:.9g}, v = {v:.9g}"
    if not limits.size:
        raise CurveError("it is degenerate and has no normal", where)
    if np.abs(limits - limits[0]).max() > _SAME:
        raise CurveError("it is degenerate: normals around there have no common limit", where)
    mean = limits.mean(axis=0)
    unit: FloatArray = mean / np.linalg.norm(mean)
    return unit


def _pieces(breaks: FloatArray, x: float) -> list[tuple[tuple[float, float], tuple[float, ...]]]:
    """Give the pieces that a parameter lies on, and to which sides of it each goes."""
    pieces = []
    for start, end in zip(breaks[:-1].tolist(), breaks[1:].tolist(), strict=True):
        if start <= x <= end:
            signs = ((1.0,) if x < end else ()) + ((-1.0,) if x > start else ())
            pieces.append(((start, end), signs))
    return pieces


def _normal_series(jet: FloatArray, spans: tuple[float, float]) -> FloatArray:
    """Give the Taylor coefficients of the normal vector by shares of a piece."""
    count = _HIGHEST + 1
    factorial = np.cumprod(np.maximum(np.arange(count + 1.0), 1.0))
    scaled = jet / (factorial[:, None] * factorial)[..., None]
    scaled *= (spans[0] ** np.arange(count + 1)[:, None] * spans[1] ** np.arange(count + 1))[
        ..., None
    ]
    rising = np.arange(1.0, count + 1)
    by_u = scaled[1:, :-1] * rising[:, None, None]
    by_v = scaled[:-1, 1:] * rising[None, :, None]
    pairs = np.cross(by_u[:, :, None, None], by_v)
    series = np.zeros((count, count, 3))
    for i in range(count):
        for j in range(count):
            series[i:, j:] += pairs[i, j, : count - i, : count - j]
    return series


def _first_along(series: FloatArray, way: FloatArray, enough: float) -> FloatArray:
    """Give the direction of the first term of a series that does not vanish along a way."""
    for order in range(len(series)):
        i = np.arange(order + 1)
        powers = way[0] ** i * way[1] ** (order - i)
        term = (powers[:, None] * series[i, order - i]).sum(axis=0)
        size = float(np.linalg.norm(term))
        if size > enough:
            unit: FloatArray = term / size
            return unit
    return np.empty(0)
