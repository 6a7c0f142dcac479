"""Rigid bodies seen from other frames, put together and taken apart."""

from collections.abc import Iterable

import numpy as np

from splinearm.arrays import FloatArray

from .link import Inertia

_NOTHING = 1e-12
"""Smaller shares of a body than this are rounding."""


def moved(inertia: Inertia, T_a_b: FloatArray) -> Inertia:
    """Give in frame a the inertia that is known in frame b, of which T_a_b is the pose."""
    R = T_a_b[:3, :3]
    tensor = R @ inertia.tensor @ R.T
    return Inertia(inertia.mass, T_a_b[:3, 3] + R @ inertia.com, 0.5 * (tensor + tensor.T))


def joined(bodies: Iterable[Inertia | None]) -> Inertia | None:
    """Give the one body that bodies fixed to each other are; None if none of them is known."""
    known = [body for body in bodies if body is not None]
    if len(known) < 2:
        return known[0] if known else None
    return _of_sums(sum((_sums(body) for body in known[1:]), _sums(known[0])))


def without(whole: Inertia, part: Inertia) -> Inertia | None:
    """Give what is left of a body when a part of it is taken off; None if nothing is."""
    sums = _sums(whole) - _sums(part)
    return _of_sums(sums) if sums[0] > _NOTHING * whole.mass else None


def _sums(body: Inertia) -> FloatArray:
    """Give mass, first and second moments about the origin, shape (13,), which just add up."""
    # parallel axes: Siciliano et al., Robotics, 2009, eq. B.60
    c = body.com
    about_origin = body.tensor + body.mass * ((c @ c) * np.eye(3) - np.outer(c, c))
    return np.concatenate(([body.mass], body.mass * c, about_origin.ravel()))


def _of_sums(sums: FloatArray) -> Inertia:
    mass, about_origin = float(sums[0]), sums[4:].reshape(3, 3)
    c = sums[1:4] / mass if mass > 0.0 else np.zeros(3)
    tensor = about_origin - mass * ((c @ c) * np.eye(3) - np.outer(c, c))
    tensor = 0.5 * (tensor + tensor.T)
    moments, axes = np.linalg.eigh(tensor)
    if -_NOTHING * np.abs(about_origin).max() <= moments[0] < 0.0:
        # rounding alone makes a body without a moment one with less than none
        tensor = (axes * np.maximum(moments, 0.0)) @ axes.T
        tensor = 0.5 * (tensor + tensor.T)
    return Inertia(mass, c, tensor)
