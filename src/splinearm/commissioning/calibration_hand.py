"""A hand for rehearsals: it turns the joints of virtual servos whose torque is off."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import isinf, tau

import numpy as np

from splinearm.backends import centred, require_chain
from splinearm.config import Cell
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG

_STEP, _STRIDE = 2.0 * DEG, 20.0 * DEG
_STOPS = 3.0 * DEG
"""So far beyond the limits are the stops of a virtual arm, rad."""
_GRIPPER_TRAVEL = 60.0 * DEG


class VirtualHand:
    """Turns the joints of an arm on a virtual bus by keys."""

    def __init__(self, cell: Cell, bus: VirtualBus) -> None:
        chain = require_chain(cell)
        limits = cell.arm.limits
        self._bus = bus
        self._chosen = 0
        self._moved = [*cell.arm.joint_names, *([] if chain.gripper is None else [""])]
        pairs = list(zip(chain.servos, bus.all_servos, strict=True))
        self._shafts = [
            [servo.shaft for spec, servo in pairs if (spec.joint or "") == name]
            for name in self._moved
        ]
        ends = zip(limits.q_min.tolist(), limits.q_max.tolist(), strict=True)
        self._stops = [_stops(low, high) for low, high in ends]
        if chain.gripper is not None:
            self._stops.append((0.0, _GRIPPER_TRAVEL))

    @property
    def words(self) -> str:
        """Which keys move what."""
        chosen = self._moved[self._chosen] or "the gripper"
        return f"your hand is on {chosen}: left/right turns, with shift farther; up/down: another"

    def take(self, key: str) -> bool:
        """Do what a key says; tell whether it was one of the hand's."""
        if key in ("up", "down"):
            step = 1 if key == "down" else -1
            self._chosen = (self._chosen + step) % len(self._moved)
            return True
        if key.removeprefix("shift-") not in ("left", "right"):
            return False
        size = _STRIDE if key.startswith("shift-") else _STEP
        self.turn(self._chosen, size if key.endswith("right") else -size)
        return True

    def turn(self, i: int, angle: float) -> None:
        """Turn a joint by an angle, rad, as far as its stops let it."""
        low, high = self._stops[i]
        with self._bus.lock:
            for shaft in self._shafts[i]:
                shaft.angle = min(max(shaft.angle + angle, low), high)


def _stops(low: float, high: float) -> tuple[float, float]:
    """Give where the stops of a joint are, rad: beyond its limits, but less than a turn apart."""
    beyond = _STOPS if isinf(high - low) else min(_STOPS, max((tau - (high - low)) / 3.0, 0.0))
    return low - beyond, high + beyond


@contextmanager
def virtual_arm(cell: Cell) -> Iterator[tuple[str, VirtualHand]]:
    """Give the port of virtual servos mounted anyhow, and a hand for them.

    Yields:
        The name of the port, and the hand.
    """
    rng = np.random.default_rng(len(cell.name))
    chain = centred(require_chain(cell))
    with VirtualBus(cell.arm, chain, cell.poses["home"], transport="socket") as bus:
        with bus.lock:
            for servo in bus.all_servos:
                servo.slip(float(rng.uniform(-0.6, 0.6)))
        yield bus.port, VirtualHand(cell, bus)
