"""Torques, and what the tool does, at places of a way, as limits of a smooth speed profile.

With u = d2s/dt2 and x = (ds/dt)^2, by the share of the way and the unit of its time, they are::

    push u + bend x + root sqrt(x) + drag <= room     torques and their friction
    |ahead u + bend x, across x| <= 1                 accelerations of the tool
    square x <= 1                                     speeds of the tool

Made slower by a factor k, u and x become a k^2th of themselves, so that every one of them says how
much slower a motion must be to keep it.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

from .constraint import on_cells
from .joint_path import JointPath
from .sampled_row import SampledLimit
from .tool_row import Speed, ToolAcceleration
from .torque_row import Torque

_STILL = 1e-12
"""A joint whose q' is below this share of the largest does not move."""

_LEAST_ROOM = 1e-6
"""So much of the full torque must be left where the arm only holds itself."""


class PlacedRows(NamedTuple):
    """Limits at places of cells."""

    push: FloatArray
    """Factor of u, shape (cells, places, rows), like all of rows."""
    bend: FloatArray
    """Factor of x."""
    root: FloatArray
    """Factor of the root of x."""
    drag: FloatArray
    """What friction takes as soon as anything moves."""
    room: FloatArray
    """What is left of 1 where the arm only holds itself."""
    cones: FloatArray
    """Ahead, bend and across of each acceleration, shape (cells, places, cones, 3)."""
    square: FloatArray
    """The largest factor of x of all speeds, shape (cells, places)."""

    def slower(self, u: FloatArray, x: FloatArray) -> FloatArray:
        """Give the square of how much slower each place must be passed, shape (cells, places, k).

        Args:
            u: d2s/dt2 at the places, shape (cells, places).
            x: Square of ds/dt there.
        """
        u, x = u[:, :, None], x[:, :, None]
        pull, lag = self.push * u + self.bend * x, self.root * np.sqrt(x)
        room = np.maximum(self.room - self.drag, _LEAST_ROOM)
        # pull / k^2 + lag / k = room
        square = lag * lag + 4.0 * pull * room
        reach = np.where(square >= 0.0, lag + np.sqrt(np.maximum(square, 0.0)), 0.0)
        rows = (np.maximum(reach, 0.0) / (2.0 * room)) ** 2
        ahead, bend, across = np.moveaxis(self.cones, -1, 0)
        return np.concatenate((rows, np.hypot(ahead * u + bend * x, across * x)), axis=2)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Placed:
    """Torques and what the tool does along a way."""

    path: JointPath
    """The way of the joints."""
    limits: tuple[SampledLimit, ...]
    """Its limits but those of the joints' velocity, acceleration and jerk."""
    span: tuple[float, float]
    """Where the way begins and ends, by s."""
    unit: float
    """The unit of time, s."""

    def rows(self, nodes: FloatArray, shares: FloatArray) -> PlacedRows:
        """Give the limits at shares of the cells between nodes, shape (cells + 1,), of the way.

        Raises:
            HoldError: If a joint is too weak to hold the arm there.
        """
        start, end = self.span
        pace = (end - start) / self.unit
        s = np.minimum(start + (end - start) * nodes, end)
        shape = len(s) - 1, shares.size
        torques, cones, square = [np.zeros((5, *shape, 0))], [np.zeros((*shape, 0, 3))], np.zeros(1)
        for limit in self.limits:
            if isinstance(limit, Torque):
                rows = _torques(limit, s, shares)
                if (rows[4] - np.maximum(rows[3], 0.0)).min() < _LEAST_ROOM:
                    limit.on(s)
                torques.append(rows)
            elif isinstance(limit, ToolAcceleration):
                cones.append(_cone(limit, s, shares)[:, :, None])
            elif isinstance(limit, Speed):
                square = np.maximum(square, (limit.used(s, shares) * pace) ** 2)
        push, bend, root, drag, room = np.concatenate(torques, axis=3)
        cone = np.concatenate(cones, axis=2) * pace**2
        cone[..., 0] /= end - start
        return PlacedRows(
            push * (pace / self.unit),
            bend * pace**2,
            root * pace,
            drag,
            room,
            cone,
            np.broadcast_to(square, shape),
        )


def _torques(limit: Torque, s: FloatArray, shares: FloatArray) -> FloatArray:
    """Give push, bend, root, drag and room of torques either way, (5, cells, shares, 2 n)."""
    q, slope, bend = on_cells(limit.path, s, shares)
    # at a pace at which joints move about 1 rad/s, whatever the parameter's unit
    pace = 1.0 / max(float(np.abs(slope).max()), 1e-300)
    rate, still = slope * pace, np.zeros_like(q)
    inverse, (viscous, coulomb, full, no_load, _) = limit.dynamics.inverse, limit.drive(pace)
    weight = inverse(q, still, still)
    push = (inverse(q, still, rate) - weight) / (pace * full)
    moved = inverse(q, rate, bend * pace**2) - weight
    moved = (moved - viscous * rate - coulomb * np.sign(rate)) / (pace**2 * full)
    turn = np.where(np.abs(rate) > _STILL, np.sign(rate), 0.0) * (coulomb / full)
    lag, drive = viscous * rate / (pace * full), rate / (pace * no_load)
    sides = [
        np.stack(
            (
                sign * push,
                sign * moved,
                sign * lag + np.maximum(sign * drive, 0.0),
                sign * turn,
                1.0 - sign * weight / full,
            )
        )
        for sign in (1.0, -1.0)
    ]
    return np.concatenate(sides, axis=3)


def _cone(limit: ToolAcceleration, s: FloatArray, shares: FloatArray) -> FloatArray:
    """Give ahead, bend and across of an acceleration, shape (cells, shares, 3)."""
    along, change = limit.derivatives(s, shares)
    ahead = np.linalg.norm(along, axis=2)
    direction = along / np.where(ahead > 0.0, ahead, 1.0)[:, :, None]
    bend = (change * direction).sum(axis=2)
    across = np.linalg.norm(change - bend[:, :, None] * direction, axis=2)
    return np.stack((ahead, bend, across), axis=2)
