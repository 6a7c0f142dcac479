"""Operating modes, and which of them a servo's registers ask for."""

from enum import IntEnum

from .memory import TableMemory

_WHEEL = 1  # Control Mode of an XL-320


class Mode(IntEnum):
    """Values of Operating Mode."""

    CURRENT = 0
    VELOCITY = 1
    POSITION = 3
    EXTENDED_POSITION = 4
    CURRENT_POSITION = 5
    PWM = 16


POSITION_MODES = frozenset((Mode.POSITION, Mode.EXTENDED_POSITION, Mode.CURRENT_POSITION))
"""Modes that follow Goal Position."""


def mode_of(memory: TableMemory) -> int:
    """Give the operating mode of a servo.

    Servos without Operating Mode have a joint mode, which is position control, and a wheel mode, in
    which the manual has their output controlled in per mill: that is PWM control. An XL-320 tells
    them apart by Control Mode, an AX-12A by its angle limits: both 0 is wheel mode.
    """
    if "Operating Mode" in memory:
        return memory["Operating Mode"]
    if "Control Mode" in memory:
        turns = memory["Control Mode"] == _WHEEL
    else:
        turns = memory["CW Angle Limit"] == memory["CCW Angle Limit"] == 0
    return Mode.PWM if turns else Mode.POSITION
