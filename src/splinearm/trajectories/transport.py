"""An orientation that turns with the direction of a way and does not spin about it."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion

from .turning import SpaceJet, Turning, inside

_STEP = 0.006
"""Largest turn from node to node, rad."""

_LEAST = 16
_MOST_NODES = 200_000
_STILL = 1e-9
"""Where the way goes on at less than this share of its usual rate it has no direction."""

_GAUSS = 0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0


@dataclass(frozen=True, slots=True, eq=False)
class TransportedOrientation:
    """The rotation-minimising orientation along a way, from a given one at its start.

    Between nodes a step of fourth order leads on, so that the turn about the direction of the way
    is right to some 1e-8 rad; the direction itself is followed exactly in angular velocity.
    """

    way: SpaceJet
    """Where the tool goes, with derivatives to the third."""
    quat_start: FloatArray
    """How it stands at the start, unit quaternion, shape (4,)."""
    nodes: FloatArray = field(init=False, repr=False)
    """Parameters between which one step leads on, shape (m,)."""
    quats: FloatArray = field(init=False, repr=False)
    """Orientations there, shape (m, 4)."""

    def __post_init__(self) -> None:
        nodes = self._grid()
        object.__setattr__(self, "nodes", nodes)
        steps = self._steps(nodes[:-1], np.diff(nodes))
        quats = np.empty((len(nodes), 4))
        quats[0] = self.quat_start
        for i, step in enumerate(steps):
            quats[i + 1] = quaternion.normalize(quaternion.multiply(step, quats[i]))
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
        node = np.clip(np.searchsorted(self.nodes, u, side="right") - 1, 0, len(self.nodes) - 2)
        steps = self._steps(self.nodes[node], u - self.nodes[node])
        quat = quaternion.normalize(quaternion.multiply(steps, self.quats[node]))
        slope, bend, third = (self.way.at(u, order) for order in (1, 2, 3))
        square = np.sum(slope * slope, axis=1, keepdims=True)
        omega = np.cross(slope, bend) / square
        drift = 2.0 * np.sum(slope * bend, axis=1, keepdims=True) / square
        return Turning(quat, omega, np.cross(slope, third) / square - drift * omega)

    def _steps(self, start: FloatArray, h: FloatArray) -> FloatArray:
        """Give the turns from places on by steps h, unit quaternions, shape (m, 4)."""
        # Magnus expansion of fourth order on two Gauss points (Iserles et al., Lie-group methods,
        # Acta Numerica 9, 2000, sec. 5)
        first, second = (self._omega(start + share * h) for share in _GAUSS)
        width = h[:, None]
        turn = 0.5 * width * (first + second)
        turn += np.sqrt(3.0) / 12.0 * width**2 * np.cross(second, first)
        return quaternion.exp(turn)

    def _omega(self, u: FloatArray) -> FloatArray:
        # the direction of the way turns by this, at right angles to itself (Bishop, There is more
        # than one way to frame a curve, Amer. Math. Monthly 82, 1975)
        slope, bend = self.way.at(u, 1), self.way.at(u, 2)
        omega: FloatArray = np.cross(slope, bend) / np.sum(slope * slope, axis=1, keepdims=True)
        return omega

    def _grid(self) -> FloatArray:
        """Give nodes between which the way turns little; refuse a way that turns on the spot."""
        nodes = self.way.breaks
        nodes = np.unique(np.linspace(nodes[:-1], nodes[1:], _LEAST + 1, axis=1))
        while True:
            slopes = self.way.at(nodes, 1)
            rates = np.linalg.norm(slopes, axis=1)
            if rates.min() <= _STILL * rates.max():
                raise _no_direction(nodes[int(np.argmin(rates))])
            along = slopes / rates[:, None]
            sharp = np.linalg.norm(np.diff(along, axis=0), axis=1) > _STEP
            if not sharp.any():
                return nodes
            middles = 0.5 * (nodes[:-1] + nodes[1:])[sharp]
            if np.isin(middles, nodes).any() or len(nodes) > _MOST_NODES:
                raise _no_direction(middles[0])
            nodes = np.sort(np.concatenate((nodes, middles)))


def _no_direction(where: float) -> CurveError:
    return CurveError("it has no direction there for the tool to turn to", f"s = {where:g}")
