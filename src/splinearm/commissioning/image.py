"""The control table of a servo as it is: every byte of EEPROM and RAM that can be read."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from splinearm.doctor.chart import blocks
from splinearm.drivers.bus import Loss
from splinearm.drivers.cyclic import GroupRead
from splinearm.drivers.groups import BulkRead
from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Area, ControlTable, Register
from splinearm.errors import BusTimeoutError, PacketError, ServoError

from .bench import Address, Bench, Found

_TRIES = 6
_REACH_V1 = 256


class Block(NamedTuple):
    """Bytes that lie together."""

    area: Area
    """What becomes of them when the power goes."""
    address: int
    """Address of the first."""
    data: bytes
    """The bytes."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ControlImage:
    """What was read of one servo."""

    found: Found
    """The servo, and how it was reached."""
    model: ServoModel
    """Its model."""
    blocks: tuple[Block, ...]
    """Its bytes, by address."""

    @property
    def address(self) -> Address:
        """How it was reached."""
        return self.found.address

    def value(self, name: str) -> int | None:
        """Give what a register holds; None: it has none of that name, or it could not be read."""
        if name not in self.model.table:
            return None
        register = self.model.table[name]
        data = self.bytes_at(register.address, register.size)
        return None if data is None else register.decode(data)

    def bytes_at(self, address: int, length: int) -> bytes | None:
        """Give bytes; None: they were not read."""
        for block in self.blocks:
            at = address - block.address
            if at >= 0 and at + length <= len(block.data):
                return block.data[at : at + length]
        return None

    def settings(self) -> dict[str, int]:
        """Give by name what the writable registers of the EEPROM hold."""
        values = {register.name: self.value(register.name) for register in kept(self.model.table)}
        return {name: value for name, value in values.items() if value is not None}


def kept(table: ControlTable) -> Sequence[Register]:
    """Give the registers that can be written and outlive the power."""
    return [r for r in table.registers if r.area is Area.EEPROM and r.writable]


def read_image(bench: Bench, found: Found) -> ControlImage:
    """Read the whole control table of a servo.

    In Protocol 1.0 what lies beyond address 255 is out of reach and left out.

    Raises:
        BusTimeoutError: If it does not answer.
        PacketError: If its answers are damaged each time, as those of two with one id are.
        ServoError: If its model is not known, or it refuses.
    """
    model = found.model
    servo_id = found.address.servo_id
    if model is None:
        raise ServoError(servo_id, f"its model number, {found.model_number}, is not known here")
    blocks: list[Block] = []
    for registers in _chunks(model.table, found.address.protocol):
        for block in _read_chunk(bench, found.address, registers):
            last = blocks[-1] if blocks else None
            if last and last.area is block.area and last.address + len(last.data) == block.address:
                blocks[-1] = Block(last.area, last.address, last.data + block.data)
            else:
                blocks.append(block)
    return ControlImage(found=found, model=model, blocks=tuple(blocks))


def _chunks(table: ControlTable, protocol: int) -> Iterator[list[Register]]:
    """Give the registers in pieces that one read can bring, EEPROM and RAM apart."""
    near = [r for r in table.registers if protocol != 1 or r.end <= _REACH_V1]
    for area in Area:
        yield from blocks([register for register in near if register.area is area])


def _read_chunk(bench: Bench, address: Address, registers: Sequence[Register]) -> Iterator[Block]:
    """Read registers that lie together; those that a firmware does not have are left out."""
    first, last = registers[0], registers[-1]
    data = _read(bench, address, first.address, last.end - first.address, first.name)
    if data is not None:
        yield Block(first.area, first.address, data)
    elif len(registers) > 1:
        half = len(registers) // 2
        yield from _read_chunk(bench, address, registers[:half])
        yield from _read_chunk(bench, address, registers[half:])
    elif first.area is Area.EEPROM:
        raise ServoError(address.servo_id, f"it does not let its {first.name} be read")


def _read(bench: Bench, address: Address, start: int, length: int, name: str) -> bytes | None:
    """Read bytes of a servo; None: it refuses."""
    bus, servo_id = bench.to(address), address.servo_id
    group = GroupRead([BulkRead(servo_id, start, length)], fast=False)
    damaged = False
    for _ in range(_TRIES):
        reply = bus.sync_read(group)[servo_id]
        if reply.loss is None:
            return reply.data
        if reply.loss is Loss.REFUSED:
            return None
        damaged |= reply.loss is Loss.DAMAGED
    if damaged:
        raise PacketError(f"{name} of servo {servo_id}", "damaged packets only")
    raise BusTimeoutError(servo_id, name, port=bench.port)
