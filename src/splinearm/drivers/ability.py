"""What a servo can do by its table, and what cannot be promised of one with a small table.

AX-12A and XL-320 have neither watchdog nor homing offset, call some registers by other names, and
say that a hardware error has cut their torque by a Torque Limit of 0.
Source: ROBOTIS e-Manual, the control tables of the series.
"""

from collections.abc import Sequence

from .chain import ServoSpec
from .model import ServoModel
from .registers import Register

WATCHDOG = "Bus Watchdog"
HARDWARE_ERROR = "Hardware Error Status"
_VOLTAGE = ("Present Input Voltage", "Present Voltage")
_LIMITS = (("Min Position Limit", "Max Position Limit"), ("CW Angle Limit", "CCW Angle Limit"))
_TORQUE, _TORQUE_LIMIT = "Torque Enable", "Torque Limit"


def having(servos: Sequence[ServoSpec], register: str) -> list[ServoSpec]:
    """Give those of some servos that have a register."""
    return [servo for servo in servos if register in servo.servo_model.table]


def broken_promises(servo: ServoSpec) -> tuple[str, ...]:
    """Give in words what is promised of servos in general, and cannot be of this one."""
    table = servo.servo_model.table
    words = []
    if WATCHDOG not in table:
        words.append("no watchdog: if this program dies, it goes on to its last goal")
    if not can_reboot(servo.servo_model):
        words.append("no reboot: after an overload its Torque Limit is written instead")
    return tuple(words)


def can_reboot(model: ServoModel) -> bool:
    """Say whether a model knows the instruction; those that speak only Protocol 1.0 do not."""
    return 2 in model.protocols


def voltage_register(model: ServoModel) -> Register:
    """Give the register of the supply, in steps of 0.1 V."""
    return next(model.table[name] for name in _VOLTAGE if name in model.table)


def range_registers(model: ServoModel) -> tuple[str, str]:
    """Give the names of the lowest and the highest goal that are taken."""
    return next(names for names in _LIMITS if names[0] in model.table)


def torque_span(model: ServoModel) -> tuple[int, int]:
    """Give address and length of the bytes that say whether a servo has torque."""
    table = model.table
    first = table[_TORQUE]
    last = table.get(_TORQUE_LIMIT, first)
    return first.address, last.end - first.address


def says_torque(data: bytes) -> bool:
    """Say whether a servo has torque, by the bytes of its ``torque_span``.

    Its torque is on, and, where there is a Torque Limit, that is not 0.
    """
    return bool(data[0]) and (len(data) == 1 or any(data[-2:]))
