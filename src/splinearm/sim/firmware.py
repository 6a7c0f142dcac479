"""What a servo's firmware version decides: its table, and what it knows."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import ControlTable, Register

from .scale import TIME_BASED, TORQUE_ON_BY_GOAL

FIRMWARE = 53
"""Firmware version that virtual servos report; with it every model has all its registers."""

_CLEAR = 42  # X servos; the P servos' first firmware with fast reads is taken for theirs
_TIME_BASED, _BY_GOAL, _BY_GOAL_X330 = 42, 45, 46
_NARROW = {"AX-12A": 24, "XL320": 41}  # nothing depends on these
_P = 14

_XL330_WIDE = 53
_OLD_ITEMS, _OLD_DATA = 20, 208


def newest_firmware(model: ServoModel) -> int:
    """Give the firmware version that a virtual servo of a model has, unless told otherwise."""
    if model.name in _NARROW:
        return _NARROW[model.name]
    return _P if model.name.startswith("P") else FIRMWARE


def knows_clear(model: ServoModel, firmware: int) -> bool:
    """Tell whether a servo knows the instruction Clear."""
    if model.name in _NARROW:
        return False
    first = model.fast_read_firmware if model.name.startswith("P") else _CLEAR
    return firmware >= first


def drive_mode_bits(model: ServoModel, firmware: int) -> int:
    """Give the bits of Drive Mode that a servo knows; of P servos the manual names no firmware."""
    known = model.table["Drive Mode"].maximum
    bits = known if isinstance(known, int) else 0
    if model.name.startswith("P"):
        return bits
    if firmware < _TIME_BASED:
        bits &= ~TIME_BASED
    if firmware < (_BY_GOAL_X330 if "330-" in model.name else _BY_GOAL):
        bits &= ~TORQUE_ON_BY_GOAL
    return bits


@cache
def table_of(model: ServoModel, firmware: int) -> ControlTable:
    """Give the control table of a model with that firmware.

    An XL330 has 28 indirect items with their data at 224; before firmware 53 it had 20 with their
    data at 208.
    """
    if not model.name.startswith("XL330") or firmware >= _XL330_WIDE:
        return model.table
    return ControlTable(model.name, _with_few_items(model.table))


def _with_few_items(table: ControlTable) -> Iterator[Register]:
    """Give the registers with the indirect items of an old XL330."""
    last = _OLD_DATA + _OLD_ITEMS - 1
    for register in table.registers:
        kind, _, number = register.name.rpartition(" ")
        if not kind.startswith("Indirect"):
            yield register
        elif int(number) <= _OLD_ITEMS:
            data = _OLD_DATA + int(number) - 1
            if kind == "Indirect Data":
                yield replace(register, address=data)
            else:
                yield replace(register, initial=data, maximum=last)
