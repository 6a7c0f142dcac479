"""Orientations that face a surface: the tool's z axis along the normals of a way on it.

The rates are exact derivatives of the frame. They are as smooth as the way and its normals.
"""

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.kinematics import quaternion

from .carrying import no_direction, node_before, nodes_of, steps
from .turning import SpaceJet, Turning, inside

_TURN = 0.1
"""Largest turn of a direction from node to node where it is looked at, rad."""

_FINE_TURN = 0.006
"""The same where steps of fourth order lead from node to node."""

_LEAST = 64
"""The fewest nodes of a smooth piece."""

_STILL = 1e-9
"""Where the way goes on at less than this share of its usual rate it has no direction."""

_BESIDE = 1e-9
"""How far beside a break, as a share of the piece there, both sides of it are looked at."""

_CORNER = 1e-6
"""A change of direction at a break above this, rad, is a corner."""


class NormalJet(NamedTuple):
    """Unit normals along a way, and how they change with its parameter."""

    unit: FloatArray
    """Unit normals, shape (m, 3)."""
    slope: FloatArray
    """Their first derivative, shape (m, 3)."""
    bend: FloatArray
    """Their second derivative, shape (m, 3)."""


class GuidedWay(SpaceJet, Protocol):
    """A way on a surface, with derivatives to the third, that knows the normals along it."""

    def normals(self, u: ArrayInput) -> NormalJet:
        """Give unit normals and their derivatives at parameters, shape (m,).

        Raises:
            CurveError: If a parameter lies outside the domain or the surface has no normal there.
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TravelFacing:
    """The tool's z axis along the normals and its x axis along the direction of travel."""

    way: GuidedWay
    """Where the tool goes."""
    sign: float
    """1: z along the normals; -1: against them, into the surface."""

    def __post_init__(self) -> None:
        _check_corners(self.way)
        for direction in (lambda u: self.way.normals(u).unit, lambda u: _unit(self._across(u))):
            nodes_of(self.breaks, direction, _TURN, _LEAST)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return self.way.domain

    @property
    def breaks(self) -> FloatArray:
        """The ends of the way's smooth pieces."""
        return self.way.breaks

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations at parameters, shape (m,).

        Raises:
            CurveError: If one lies outside the domain.
        """
        u = inside(u, self.domain)
        z, dz, ddz = (self.sign * part for part in self.way.normals(u))
        v, dv, ddv = (self.way.at(u, order) for order in (1, 2, 3))
        # the part of the velocity beside z, which for a way on the surface is all of it
        a, da, dda = _dot(v, z), _dot(dv, z) + _dot(v, dz), _dot(ddv, z)
        dda = dda + 2.0 * _dot(dv, dz) + _dot(v, ddz)
        w, dw = v - a * z, dv - da * z - a * dz
        ddw = ddv - dda * z - 2.0 * da * dz - a * ddz
        x, dx, ddx = unit_jet(w, dw, ddw)
        y = np.cross(z, x)
        dy = np.cross(dz, x) + np.cross(z, dx)
        quat = quaternion.from_matrix(np.stack((x, y, z), axis=-1))
        # of omega the part beside z turns z, and the rest turns x towards y
        spin = _dot(dx, y)
        omega = np.cross(z, dz) + spin * z
        alpha = np.cross(z, ddz) + (_dot(ddx, y) + _dot(dx, dy)) * z + spin * dz
        return Turning(quat, omega, alpha)

    def _across(self, u: FloatArray) -> FloatArray:
        """Give the way's direction beside the normals, of any length."""
        slope, unit = self.way.at(u, 1), self.way.normals(u).unit
        rates = np.linalg.norm(slope, axis=1)
        beside: FloatArray = slope - _dot(slope, unit) * unit
        still = np.linalg.norm(beside, axis=1) <= _STILL * rates.max()
        if still.any():
            raise no_direction("the way has no direction there", u[int(np.argmax(still))])
        return beside


@dataclass(frozen=True, slots=True, eq=False)
class CarriedFacing:
    """The tool's z axis along the normals, and no spin about it (rotation-minimising).

    z is exact. Between nodes a step of fourth order leads on, so that the turn about z is right to
    some 1e-8 rad.
    """

    way: GuidedWay
    """Where the tool goes."""
    sign: float
    """1: z along the normals; -1: against them, into the surface."""
    x_start: FloatArray
    """Where the x axis points at the start, as nearly as facing allows, in base, shape (3,)."""
    nodes: FloatArray = field(init=False, repr=False)
    """Parameters between which one step leads on, shape (k,)."""
    quats: FloatArray = field(init=False, repr=False)
    """Orientations there, shape (k, 4)."""

    def __post_init__(self) -> None:
        _check_corners(self.way)
        nodes = nodes_of(self.breaks, lambda u: self.way.normals(u).unit, _FINE_TURN, _LEAST)
        z = self.sign * self.way.normals(nodes).unit
        quats = np.empty((len(nodes), 4))
        quats[0] = self._first(z[0])
        for i, step in enumerate(steps(self._omega, nodes[:-1], np.diff(nodes))):
            carried = quaternion.multiply(step, quats[i])
            quats[i + 1] = _aligned(carried[None], z[i + 1][None])[0]
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "quats", quats)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return self.way.domain

    @property
    def breaks(self) -> FloatArray:
        """The ends of the way's smooth pieces."""
        return self.way.breaks

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations at parameters, shape (m,).

        Raises:
            CurveError: If one lies outside the domain.
        """
        u = inside(u, self.domain)
        z, dz, ddz = (self.sign * part for part in self.way.normals(u))
        node = node_before(self.nodes, u)
        turns = steps(self._omega, self.nodes[node], u - self.nodes[node])
        quat = _aligned(quaternion.multiply(turns, self.quats[node]), z)
        return Turning(quat, np.cross(z, dz), np.cross(z, ddz))

    def _omega(self, u: FloatArray) -> FloatArray:
        unit, slope, _ = self.way.normals(u)
        omega: FloatArray = np.cross(unit, slope)
        return omega

    def _first(self, z: FloatArray) -> FloatArray:
        """Give the orientation at the start, shape (4,)."""
        x = self.x_start - (self.x_start @ z) * z
        length = float(np.linalg.norm(x))
        if length <= _CORNER * float(np.linalg.norm(self.x_start)):
            raise ValueError(
                f"x_start: want a direction beside the normal, got {self.x_start.tolist()}"
            )
        x = x / length
        return quaternion.from_matrix(np.stack((x, np.cross(z, x), z), axis=-1))


def unit_jet(
    v: FloatArray, dv: FloatArray, ddv: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give unit vectors and their first two derivatives, from vectors with theirs, each (m, 3)."""
    # v = r n, so that v' = r' n + r n' and v'' = r'' n + 2 r' n' + r n''
    r = np.linalg.norm(v, axis=1, keepdims=True)
    n = v / r
    dr = _dot(n, dv)
    dn = (dv - dr * n) / r
    ddr = _dot(n, ddv) + _dot(dn, dv)
    return n, dn, (ddv - ddr * n - 2.0 * dr * dn) / r


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = np.sum(a * b, axis=1, keepdims=True)
    return product


def _unit(v: FloatArray) -> FloatArray:
    unit: FloatArray = v / np.linalg.norm(v, axis=1, keepdims=True)
    return unit


def _aligned(quats: FloatArray, z: FloatArray) -> FloatArray:
    """Turn orientations by the least that brings their z axes to unit vectors, shape (m, 3)."""
    have = quaternion.rotate(quats, np.broadcast_to(np.array([0.0, 0.0, 1.0]), z.shape))
    # the turn from a to b by half its angle: (1 + a . b, a x b), normalised
    half = np.hstack((1.0 + _dot(have, z), np.cross(have, z)))
    return quaternion.normalize(quaternion.multiply(quaternion.normalize(half), quats))


def _check_corners(way: GuidedWay) -> None:
    """Refuse a way that has a corner, or whose normals jump, at one of its breaks."""
    breaks = way.breaks
    gaps = np.diff(breaks)
    inner = breaks[1:-1]
    before, behind = inner - _BESIDE * gaps[:-1], inner + _BESIDE * gaps[1:]
    if not inner.size:
        return
    slopes = way.at(before, 1), way.at(behind, 1)
    rates = np.maximum(*(np.linalg.norm(slope, axis=1) for slope in slopes))
    bent = np.linalg.norm(slopes[1] - slopes[0], axis=1) > _CORNER * rates
    if bent.any():
        where = inner[int(np.argmax(bent))]
        raise no_direction("the way has a corner there; split it and let the tool stop", where)
    jumps = way.normals(behind).unit - way.normals(before).unit
    folded = np.linalg.norm(jumps, axis=1) > _CORNER
    if folded.any():
        where = inner[int(np.argmax(folded))]
        raise no_direction("the surface has an edge there, and no single normal", where)
