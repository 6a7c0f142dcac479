"""Hardware errors by their names, and what Protocol 1.0 says of them.

Source: ROBOTIS e-Manual, "Hardware Error Status" and "Shutdown" of each series; "DYNAMIXEL Protocol
1.0", Status Packet.
"""

from splinearm.drivers.model import ServoModel

from .rule import Refusal

INPUT_VOLTAGE = "input voltage"
OVERHEATING = "overheating"
ENCODER = "motor encoder"
SHOCK = "electrical shock"
OVERLOAD = "overload"

ALARMS = (INPUT_VOLTAGE, OVERHEATING, ENCODER, SHOCK, OVERLOAD)
"""The hardware errors that some servo can have."""

ALERT = 0x80
"""The bit of an error byte of Protocol 2.0 that says that a hardware error stands."""


def alarm_bit(model: ServoModel, name: str) -> int:
    """Give the bit of a hardware error in a model's status; 0: the model has no such error."""
    return next((bit for bit, known in model.error_bits.items() if known == name), 0)


_V1 = {INPUT_VOLTAGE: 0x01, OVERHEATING: 0x04, OVERLOAD: 0x20}
_ANGLE_LIMIT, _RANGE, _INSTRUCTION = 0x02, 0x08, 0x40

_REFUSED_V1 = {
    Refusal.NONE: 0,
    Refusal.RESULT_FAIL: _INSTRUCTION,
    Refusal.INSTRUCTION: _INSTRUCTION,
    Refusal.DATA_RANGE: _RANGE,
    Refusal.DATA_LENGTH: _RANGE,
    Refusal.DATA_LIMIT: _ANGLE_LIMIT,
    Refusal.ACCESS: _RANGE,
}
"""The bit of Protocol 1.0 for what is refused. It has none for access and length: range is said
"when the command is given beyond the range of usage"."""


def error_byte_v1(model: ServoModel, alarms: int, number: int) -> int:
    """Give the error byte of Protocol 1.0.

    Args:
        model: The servo's model.
        alarms: The hardware errors that stand, as the model's status says them.
        number: The error number of Protocol 2.0 for what was refused, or 0.
    """
    bits = _REFUSED_V1[Refusal(number)]
    for name, bit in _V1.items():
        if alarms & alarm_bit(model, name):
            bits |= bit
    return bits
