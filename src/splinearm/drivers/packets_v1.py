"""Packets of DYNAMIXEL Protocol 1.0: bytes to packets and back, for both ends, without any port.

A packet is ``FF FF  ID  LEN  instruction or error  parameters  checksum``, without stuffing.
Nothing in the bytes tells a status from an instruction, so a decoder must know which end it serves.
Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 1.0".
"""

from .packets import ALERT_BIT, Instruction, Packet

HEADER = b"\xff\xff"
BROADCAST_ID = 0xFE
MAX_LENGTH = 250
"""Greatest LEN that the decoder believes."""


def checksum(data: bytes) -> int:
    """Give the checksum of the bytes from the id to the last parameter."""
    return ~sum(data) & 0xFF


def encode(servo_id: int, instruction: int, params: bytes = b"") -> bytes:
    """Give the bytes of an instruction packet.

    Raises:
        ValueError: If the id is none, or there is more than a packet can carry.
    """
    return _frame(servo_id, instruction, params)


def encode_status(servo_id: int, error: int = 0, params: bytes = b"") -> bytes:
    """Give the bytes of a status packet; ``error`` is its error byte, a set of bits."""
    return _frame(servo_id, error, params)


def _frame(servo_id: int, code: int, params: bytes) -> bytes:
    """Put a packet together."""
    if not 0 <= servo_id <= BROADCAST_ID:
        raise ValueError(f"servo_id: want 0..{BROADCAST_ID}, got {servo_id}")
    length = len(params) + 2
    if length > MAX_LENGTH:
        raise ValueError(f"params: want at most {MAX_LENGTH} bytes in a packet, got {length}")
    content = bytes((servo_id, length, code)) + params
    return HEADER + content + bytes((checksum(content),))


_LATCHED = 0x01 | 0x04 | 0x20  # input voltage, overheating, overload
_NUMBERS = {0x40: 2, 0x10: 3, 0x08: 4, 0x02: 6}
RAW_SHIFT = 8
"""Above so many bits of an error the byte of Protocol 1.0 stands as it came."""


def modern_error(error: int) -> int:
    """Give what the error byte says in the way of Protocol 2.0, with the byte itself above it.

    Instruction, checksum, range and angle limit become the number of the like error; a fault of the
    servo becomes the alert bit.
    """
    number = next((number for bit, number in _NUMBERS.items() if error & bit), 0)
    alert = ALERT_BIT if error & _LATCHED else 0
    return alert | number | (error & _LATCHED) << RAW_SHIFT


class Decoder:
    """Finds packets in a stream of bytes, however it is cut; skips what is damaged.

    Args:
        status: Whether the packets come from servos (status) or go to them (instructions).
    """

    def __init__(self, *, status: bool) -> None:
        self._status = status
        self._pending = bytearray()
        self.checksum_errors = 0
        """Packets thrown away because their checksum was wrong."""

    def reset(self) -> None:
        """Forget what has come of a packet whose rest will not come any more."""
        self._pending.clear()

    def feed(self, data: bytes) -> list[Packet]:
        """Take bytes as they come and give the packets that they complete, oldest first."""
        pending = self._pending
        pending += data
        packets: list[Packet] = []
        while self._seek_header() and len(pending) >= 4 + pending[3]:
            end = 4 + pending[3]
            content, check = bytes(pending[2 : end - 1]), pending[end - 1]
            if checksum(content) != check:
                self.checksum_errors += 1
                del pending[:1]
                continue
            packets.append(self._packet(content))
            del pending[:end]
        return packets

    def _seek_header(self) -> bool:
        """Drop what cannot begin a packet; say whether header, id and LEN are there."""
        pending = self._pending
        while len(pending) >= 4:
            if pending.startswith(HEADER) and pending[2] != 0xFF and 2 <= pending[3] <= MAX_LENGTH:
                return True
            del pending[:1]
        return False

    def _packet(self, content: bytes) -> Packet:
        """Turn id, LEN, code and parameters into a packet."""
        servo_id, code, params = content[0], content[2], content[3:]
        if self._status:
            return Packet(servo_id, Instruction.STATUS, params, code)
        return Packet(servo_id, code, params)
