"""An orientation that turns with the direction of a way and does not spin about it."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.kinematics import quaternion

from .carrying import no_direction, node_before, nodes_of, steps
from .turning import SpaceJet, Turning, inside

_STEP = 0.006
"""Largest turn from node to node, rad."""

_LEAST = 16
"""The fewest steps of a smooth piece."""

_STILL = 1e-9
"""Where the way goes on at less than this share of its usual rate it has no direction."""


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
        nodes = nodes_of(self.breaks, self._direction, _STEP, _LEAST)
        object.__setattr__(self, "nodes", nodes)
        quats = np.empty((len(nodes), 4))
        quats[0] = self.quat_start
        for i, step in enumerate(steps(self._omega, nodes[:-1], np.diff(nodes))):
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
        node = node_before(self.nodes, u)
        turns = steps(self._omega, self.nodes[node], u - self.nodes[node])
        quat = quaternion.normalize(quaternion.multiply(turns, self.quats[node]))
        slope, bend, third = (self.way.at(u, order) for order in (1, 2, 3))
        square = np.sum(slope * slope, axis=1, keepdims=True)
        omega = np.cross(slope, bend) / square
        drift = 2.0 * np.sum(slope * bend, axis=1, keepdims=True) / square
        return Turning(quat, omega, np.cross(slope, third) / square - drift * omega)

    def _omega(self, u: FloatArray) -> FloatArray:
        # the direction of the way turns by this, at right angles to itself (Bishop, There is more
        # than one way to frame a curve, Amer. Math. Monthly 82, 1975)
        slope, bend = self.way.at(u, 1), self.way.at(u, 2)
        omega: FloatArray = np.cross(slope, bend) / np.sum(slope * slope, axis=1, keepdims=True)
        return omega

    def _direction(self, u: FloatArray) -> FloatArray:
        """Give the direction of the way, unit vectors, shape (m, 3)."""
        slopes = self.way.at(u, 1)
        rates = np.linalg.norm(slopes, axis=1)
        if rates.min() <= _STILL * rates.max():
            where = u[int(np.argmin(rates))]
            raise no_direction("it has no direction there for the tool to turn to", where)
        direction: FloatArray = slopes / rates[:, None]
        return direction
