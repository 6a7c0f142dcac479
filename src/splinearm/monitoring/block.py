"""Which bytes of a servo are read together: its motion in every cycle, its health now and then.

Registers are read where the manual has them. Indirect Data are left alone, even where another
program has set them up: it may point them elsewhere at any time, and what is read there then would
be told under the wrong name.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import nan
from typing import NamedTuple

from splinearm.drivers.ability import HARDWARE_ERROR, torque_span, voltage_register
from splinearm.drivers.gauge import Gauge, Measured
from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Register
from splinearm.units import RPM

MOVING, TEMPERATURE, VOLTAGE, TORQUE = "Moving", "Present Temperature", "supply", "torque"
"""What blocks say besides the motion, by the names under which they say it."""

_GAP = 32
"""Bytes between two registers that are read along rather than asked for anew: a transaction of its
own costs at least 21 bytes and two turns of the line."""
_LOAD_UNIT = 1e-3
_SLOW = ("Torque Enable", "Torque Limit", HARDWARE_ERROR, "Bus Watchdog", TEMPERATURE)


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Registers of a model that one read brings, by address."""

    registers: tuple[Register, ...]
    """The registers."""

    @property
    def address(self) -> int:
        """Where it begins."""
        return self.registers[0].address

    @property
    def length(self) -> int:
        """Number of bytes."""
        return self.registers[-1].end - self.address

    def cut(self, data: bytes, register: Register) -> bytes:
        """Give the bytes of one of its registers."""
        at = register.address - self.address
        return data[at : at + register.size]

    def values(self, data: bytes) -> dict[str, int]:
        """Give what its registers hold, by name."""
        return {r.name: r.decode(self.cut(data, r)) for r in self.registers}


class Motion(NamedTuple):
    """How a servo moves."""

    ticks: float
    """Its position register."""
    velocity: float
    """Velocity, rad/s."""
    current: float
    """Current, A; NaN: it measures none."""
    load: float
    """Load, as a share of its torque; NaN: it measures its current."""
    moving: bool | None
    """Whether it says that it moves; None: it does not say."""


class MotionBlock:
    """What is read of a model in every cycle.

    Args:
        model: The model.

    Raises:
        ValueError: If it lacks position, velocity or load.
    """

    def __init__(self, model: ServoModel) -> None:
        self._gauge = Gauge.of(model)
        registers = {*self._gauge.registers}
        moving = model.table.get(MOVING)
        if moving is not None and len(_runs((*registers, moving))) == 1:
            registers.add(moving)
        self.block = Block(tuple(sorted(registers, key=lambda r: r.address)))
        """The bytes."""
        self._moving = moving if moving in registers else None
        self._velocity_unit = _unit(model, ("Present Velocity", "Present Speed")) * RPM
        self._current_unit = nan
        if model.has_current:
            self._current_unit = _unit(model, ("Present Current",)) * 1e-3
        self._load_unit = nan if model.has_current else _LOAD_UNIT

    def read(self, data: bytes) -> Motion:
        """Say what the bytes mean."""
        cut = self.block.cut
        parts = b"".join(cut(data, register) for register in self._gauge.registers)
        raw: Measured = self._gauge.read(parts)
        moving = None if self._moving is None else bool(cut(data, self._moving)[0])
        return Motion(
            ticks=raw.position,
            velocity=raw.velocity * self._velocity_unit,
            current=raw.load * self._current_unit,
            load=raw.load * self._load_unit,
            moving=moving,
        )


def slow_blocks(model: ServoModel) -> tuple[Block, ...]:
    """Give what is read of a model now and then: torque, errors, watchdog, supply, temperature."""
    table = model.table
    names = [name for name in _SLOW if name in table]
    registers = {table[name] for name in names} | {voltage_register(model)}
    return tuple(Block(tuple(run)) for run in _runs(registers))


def slow_values(model: ServoModel, block: Block, data: bytes) -> dict[str, int]:
    """Give what a slow block says; torque and supply by the names of this module.

    Torque is 1 or 0: whether the servo has any.
    """
    values = block.values(data)
    supply = voltage_register(model).name
    if supply in values:
        values[VOLTAGE] = values[supply]
    if "Torque Enable" in values:
        limited = (
            torque_span(model)[1] > 1 and "Torque Limit" in values and not values["Torque Limit"]
        )
        values[TORQUE] = int(bool(values["Torque Enable"]) and not limited)
    return values


def _runs(registers: Iterable[Register]) -> list[list[Register]]:
    """Split registers into those that are near enough to be read together."""
    runs: list[list[Register]] = []
    for register in sorted(registers, key=lambda r: r.address):
        if runs and register.address - runs[-1][-1].end <= _GAP:
            runs[-1].append(register)
        else:
            runs.append([register])
    return runs


def _unit(model: ServoModel, names: Sequence[str]) -> float:
    """Give what one step of the first of some registers that a model has is worth."""
    for name in names:
        if name in model.table:
            scale = model.table[name].scale
            if scale is not None:
                return scale
    raise ValueError(f"{model.name}: the unit of {' or '.join(names)} is not known")
