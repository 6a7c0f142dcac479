"""What a servo says of its motion: which registers, and how their bytes are to be read."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .layout import Field, block_length
from .model import ServoModel
from .registers import Register

MARK = "Status Return Level"
"""Register that marks an indirect block: it is 2 in every servo of a running arm, while in a block
that a reboot has undone a byte stands for itself and is 0."""
MARK_VALUE = 2

_POSITION = "Present Position"
_VELOCITY = ("Present Velocity", "Present Speed")
_LOAD = ("Present Current", "Present Load")
_CODES = {(1, False): "B", (1, True): "b", (2, False): "H", (2, True): "h"}
_CODES |= {(4, False): "I", (4, True): "i"}
_MAGNITUDE, _DIRECTION = 0x3FF, 0x400


class Measured(NamedTuple):
    """The registers of a servo's motion, as numbers."""

    load: float
    """Current, or load where the servo measures no current."""
    velocity: float
    """Velocity."""
    position: float
    """Position."""


@dataclass(frozen=True, slots=True, eq=False)
class Gauge:
    """Reads a block of load, velocity and position, in whatever order and width a model has them.

    Old models give speed and load as ten bits and a direction.
    """

    registers: tuple[Register, ...]
    """The three registers, by address."""
    marked: bool = False
    """Whether the block ends with a mark."""

    @classmethod
    def of(cls, model: ServoModel, *, marked: bool = False) -> "Gauge":
        """Give the gauge of a model.

        Raises:
            ValueError: If it lacks one of the three.
        """
        names = [_first(model, _LOAD), _first(model, _VELOCITY), _first(model, (_POSITION,))]
        registers = sorted((model.table[name] for name in names), key=lambda r: r.address)
        return cls(tuple(registers), marked)

    def fields(self, model: ServoModel) -> tuple[Field, ...]:
        """Give what the block is made of."""
        return (*self.registers, model.table[MARK]) if self.marked else self.registers

    @property
    def length(self) -> int:
        """Number of bytes of the block."""
        return block_length(self.registers) + self.marked

    @property
    def kind(self) -> tuple[object, ...]:
        """What two gauges have in common that read the same bytes in the same way."""
        rows = tuple((_role(r), r.size, r.signed) for r in self.registers)
        return (*rows, self.plain, self.marked)

    @property
    def plain(self) -> bool:
        """Whether each register is a number as it stands."""
        return not any(_is_signed_apart(register) for register in self.registers)

    def is_marked_well(self, data: bytes) -> bool:
        """Say whether a block is what it shall be, and not what a reboot made of it."""
        return not self.marked or data[-1] == MARK_VALUE

    def read(self, data: bytes) -> Measured:
        """Give the numbers of a block."""
        found = dict.fromkeys(("load", "velocity", "position"), 0.0)
        start = 0
        for register in self.registers:
            value = register.decode(data[start : start + register.size])
            start += register.size
            if _is_signed_apart(register):
                size = value & _MAGNITUDE
                value = -size if value & _DIRECTION else size
            found[_role(register)] = float(value)
        return Measured(**found)

    def dtype(self, stride: int, start: int) -> np.dtype[np.void]:
        """Give the same as a numpy type, for blocks that follow each other.

        Args:
            stride: From one block to the next, bytes.
            start: Where in each stride the block begins.
        """
        names = [_role(register) for register in self.registers]
        formats = [f"<{_CODES[r.size, r.signed]}" for r in self.registers]
        offsets = [start + sum(r.size for r in self.registers[:k]) for k in range(len(names))]
        if self.marked:
            names.append("mark")
            formats.append("B")
            offsets.append(start + self.length - 1)
        return np.dtype(
            {"names": names, "formats": formats, "offsets": offsets, "itemsize": stride}
        )


def struct_code(register: Register) -> str:
    """Give the letter by which ``struct`` packs a register."""
    return _CODES[register.size, register.signed]


def pack_code(fields: Sequence[Field]) -> str:
    """Give the letters by which ``struct`` packs fields; bytes that mean nothing become 0."""
    return "".join(f"{f}x" if isinstance(f, int) else struct_code(f) for f in fields)


def _first(model: ServoModel, names: Sequence[str]) -> str:
    """Give the first of some registers that a model has."""
    for name in names:
        if name in model.table:
            return name
    raise ValueError(f"{model.name} cannot be a joint: it has no {' and no '.join(names)}")


def _role(register: Register) -> str:
    """Say which of the three a register is."""
    if register.name == _POSITION:
        return "position"
    return "velocity" if register.name in _VELOCITY else "load"


def _is_signed_apart(register: Register) -> bool:
    """Whether a register is ten bits and a direction."""
    old = register.name in ("Present Speed", "Present Load") and not register.signed
    return old and register.size == struct.calcsize("<H")
