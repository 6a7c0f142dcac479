"""Curvature, torsion and the frame of Frenet of curves."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .bspline import BSpline

_STILL = 1e-14
"""A speed below this share of the curve's size over its domain is none."""

_STRAIGHT = 1e-13
"""Below this sine the second derivative points along the first: no normal."""


class Frenet(NamedTuple):
    """Unit vectors along a curve, each of shape (..., dim)."""

    tangent: FloatArray
    """Along the curve."""
    normal: FloatArray
    """Across it: in the plane to the left, in space towards the centre of curvature."""
    binormal: FloatArray
    """Tangent x normal, in space; in the plane of shape (..., 0)."""


def curvature(curve: BSpline, u: ArrayInput) -> FloatArray:
    """Give the curvature at parameters, shape (...), 1/m.

    In the plane it is positive where the curve turns left; otherwise never negative.

    Args:
        curve: A curve with at least two coordinates.
        u: Parameters in the domain, shape (...).

    Raises:
        CurveError: If a parameter lies outside the domain, or the curve stands still there.
    """
    _check_dim(curve, 2, 10**9)
    _, first, second = np.moveaxis(curve.jet(u, 2), -2, 0)
    speed = _speed(curve, first, u)
    tangent = first / speed[..., None]
    if curve.dim == 2:
        turn = tangent[..., 0] * second[..., 1] - tangent[..., 1] * second[..., 0]
        return np.asarray(turn / speed**2)
    across = second - np.sum(second * tangent, axis=-1)[..., None] * tangent
    bend: FloatArray = np.linalg.norm(across, axis=-1) / speed**2
    return bend


def torsion(curve: BSpline, u: ArrayInput) -> FloatArray:
    """Give the torsion at parameters of a curve in space, shape (...), 1/m.

    It is positive where the curve leaves its plane as a right-hand screw does.

    Args:
        curve: A curve with three coordinates.
        u: Parameters in the domain, shape (...).

    Raises:
        CurveError: If a parameter lies outside the domain, or the curve stands still or is
            straight there.
    """
    _check_dim(curve, 3, 3)
    _, first, second, third = np.moveaxis(curve.jet(u, 3), -2, 0)
    # do Carmo, Differential Geometry of Curves and Surfaces, 1976, sec. 1-5, exercise 12
    across = _across(curve, first, second, u)
    twist: FloatArray = np.sum(across * third, axis=-1) / np.sum(across * across, axis=-1)
    return twist


def frenet(curve: BSpline, u: ArrayInput) -> Frenet:
    """Give tangent, normal and binormal at parameters.

    Args:
        curve: A curve with two or three coordinates.
        u: Parameters in the domain, shape (...).

    Raises:
        CurveError: If a parameter lies outside the domain, or the curve stands still there, or,
            in space, is straight there: then it has no normal.
    """
    _check_dim(curve, 2, 3)
    _, first, second = np.moveaxis(curve.jet(u, 2), -2, 0)
    tangent = first / _speed(curve, first, u)[..., None]
    if curve.dim == 2:
        normal = np.stack((-tangent[..., 1], tangent[..., 0]), axis=-1)
        return Frenet(tangent, normal, np.empty((*tangent.shape[:-1], 0)))
    across = _across(curve, first, second, u)
    binormal = across / np.linalg.norm(across, axis=-1)[..., None]
    return Frenet(tangent, np.cross(binormal, tangent), binormal)


def _check_dim(curve: BSpline, least: int, most: int) -> None:
    if not least <= curve.dim <= most:
        wanted = str(least) if least == most else f"{least} or {most}" if most < 9 else "at least 2"
        raise ValueError(f"curve: want {wanted} coordinates, got {curve.dim}")


def _speed(curve: BSpline, first: FloatArray, u: ArrayInput) -> FloatArray:
    speed: FloatArray = np.linalg.norm(first, axis=-1)
    start, end = curve.domain
    size = float(np.abs(curve.points - curve.points[0]).max()) / (end - start)
    _refuse(speed <= _STILL * size, u, "it stands still")
    return speed


def _across(curve: BSpline, first: FloatArray, second: FloatArray, u: ArrayInput) -> FloatArray:
    """Give first x second after checking that there is such a direction."""
    speed = _speed(curve, first, u)
    across = np.cross(first, second)
    size = speed * np.linalg.norm(second, axis=-1)
    _refuse(np.linalg.norm(across, axis=-1) <= _STRAIGHT * size, u, "it is straight")
    return across


def _refuse(where: npt.NDArray[np.bool], u: ArrayInput, what: str) -> None:
    if np.any(where):
        at = float(np.ravel(np.asarray(u, dtype=np.float64))[int(np.argmax(np.ravel(where)))])
        raise CurveError(f"{what} at u = {at}: no direction there", "curvature")
