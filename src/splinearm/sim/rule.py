"""What a servo refuses to have written, and with which error number.

Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0", Status Packet, and the register pages.
"""

from collections.abc import Sequence
from enum import IntEnum

from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Area, Register

from .firmware import drive_mode_bits
from .memory import Change, TableMemory
from .mode import Mode, mode_of


class Refusal(IntEnum):
    """Error number of a status packet of Protocol 2.0."""

    NONE = 0
    RESULT_FAIL = 1
    INSTRUCTION = 2
    DATA_RANGE = 4
    DATA_LENGTH = 5
    DATA_LIMIT = 6
    ACCESS = 7


GOALS = frozenset(("Goal PWM", "Goal Current", "Goal Velocity", "Goal Position"))
"""Registers that a tripped watchdog closes."""

WATCHDOG_TRIPPED = 0xFF
"""What Bus Watchdog reads once it has tripped: -1 in one byte."""

_TURNS = 256
_NO_SECONDARY_ID = range(253, 256)
_BIT_FIELDS = frozenset(("Drive Mode", "Startup Configuration"))


def refusal(
    memory: TableMemory, model: ServoModel, changes: Sequence[Change], *, may_write_eeprom: bool
) -> Refusal:
    """Say why a servo refuses a write; it refuses all of it or none.

    Args:
        memory: Its table.
        model: Its model.
        changes: What would be written.
        may_write_eeprom: Whether the torque is off and the packet was for its own id.
    """
    for register, _ in changes:
        if not register.writable or (register.area is Area.EEPROM and not may_write_eeprom):
            return Refusal.ACCESS
    tripped = memory.get("Bus Watchdog") == WATCHDOG_TRIPPED
    for register, value in changes:
        if tripped and (register.name in GOALS or (register.name == "Bus Watchdog" and value != 0)):
            return Refusal.DATA_RANGE
        if not _in_range(register, value, model) or _refused_here(register, value, memory, model):
            return Refusal.DATA_RANGE
        if not _within_limits(register, value, memory, model):
            return Refusal.DATA_LIMIT
    return Refusal.NONE


def _in_range(register: Register, value: int, model: ServoModel) -> bool:
    """Tell whether a value is among those that the manual names."""
    if register.name == "Operating Mode":
        return value in model.modes
    if register.name == "Protocol Type":
        return value in model.protocols
    if register.name == "Secondary(Shadow) ID" and value in _NO_SECONDARY_ID:
        return True
    low, high = register.minimum, register.maximum
    if register.name in _BIT_FIELDS and isinstance(high, int):
        return value & ~high == 0
    too_low = isinstance(low, int) and value < low
    too_high = isinstance(high, int) and value > high
    return not (too_low or too_high)


def _within_limits(register: Register, value: int, memory: TableMemory, model: ServoModel) -> bool:
    """Tell whether a value is within the limits that the servo's own registers set."""
    if register.name == "Goal Position":
        mode = mode_of(memory)
        if mode in (Mode.EXTENDED_POSITION, Mode.CURRENT_POSITION):
            return abs(value) < _TURNS * model.pulses
        if "CW Angle Limit" in memory:
            low, high = memory["CW Angle Limit"], memory["CCW Angle Limit"]
            return mode != Mode.POSITION or low <= value <= high
    if not (isinstance(register.minimum, str) or isinstance(register.maximum, str)):
        return True
    low, high = memory.table.limits(register.name, memory.__getitem__)
    return low <= value <= high


def _refused_here(register: Register, value: int, memory: TableMemory, model: ServoModel) -> bool:
    """Tell whether this servo lacks a value that its model has: by its firmware, or by Lock.

    What Lock has locked, only a loss of power unlocks.
    """
    if register.name == "Drive Mode":
        return bool(value & ~drive_mode_bits(model, memory["Firmware Version"]))
    return register.name == "Lock" and value == 0 and memory["Lock"] != 0
