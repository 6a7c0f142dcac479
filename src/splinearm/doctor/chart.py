"""What the registers of a servo say, read block by block."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from splinearm.drivers.bus import Loss
from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.cyclic import GroupRead
from splinearm.drivers.groups import BulkRead
from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Area, Register

from .stethoscope import Stethoscope

_TRIES = 4
_GAP, _LONGEST = 24, 100  # bytes
_WANTED = (
    "Drive Mode",
    "Operating Mode",
    "Homing Offset",
    "Secondary(Shadow) ID",
    "Return Delay Time",
    "Status Return Level",
    "Temperature Limit",
    "Max Voltage Limit",
    "Min Voltage Limit",
    "PWM Limit",
    "Current Limit",
    "Max Position Limit",
    "Min Position Limit",
    "Shutdown",
    "Torque Enable",
    "Hardware Error Status",
    "Bus Watchdog",
    "Present Position",
    "Present Input Voltage",
    "Present Temperature",
)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Chart:
    """The registers of one servo."""

    servo_id: int
    """Its id."""
    name: str
    """What the arm's file calls it; empty if it is not there."""
    model: ServoModel
    """Its model, as it says itself."""
    firmware: int
    """Its firmware."""
    values: dict[str, int]
    """By register what could be read."""

    @property
    def where(self) -> str:
        """Give it in words."""
        return f"servo {self.servo_id}" + (f" ({self.name})" if self.name else "")


def read_registers(
    bus: Stethoscope, servo_id: int, model: ServoModel, servo: ServoSpec | None
) -> dict[str, int] | None:
    """Read what is to be known of a servo; None: it answers no read.

    Raises:
        PortError: If the port is gone.
    """
    table = model.table
    names = set(_WANTED)
    if servo is not None:
        names |= {name for name in servo.settings if name in table}
    wanted = [r for r in table.registers if r.name in names]
    wanted = [r for r in wanted if r.area is Area.EEPROM or r.name in _WANTED]
    values: dict[str, int] = {}
    for block in blocks(wanted):
        data = _read(bus, servo_id, block[0].address, block[-1].end - block[0].address)
        if data is None and not values:
            return None
        for register in block if data is not None else ():
            at = register.address - block[0].address
            values[register.name] = register.decode((data or b"")[at : at + register.size])
    return values


def blocks(registers: Sequence[Register]) -> Iterator[list[Register]]:
    """Give registers, by address, in blocks that one read can bring."""
    block: list[Register] = []
    for register in registers:
        if block:
            far = register.address - block[-1].end > _GAP
            if far or register.end - block[0].address > _LONGEST:
                yield block
                block = []
        block.append(register)
    if block:
        yield block


def _read(bus: Stethoscope, servo_id: int, address: int, length: int) -> bytes | None:
    """Read bytes of a servo; None: nothing that can be trusted came."""
    group = GroupRead([BulkRead(servo_id, address, length)], fast=False)
    for _ in range(_TRIES):
        reply = bus.sync_read(group)[servo_id]
        if reply.loss is None:
            return reply.data
        if reply.loss is Loss.REFUSED:
            return None
    return None
