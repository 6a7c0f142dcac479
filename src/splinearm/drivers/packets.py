"""Packets of DYNAMIXEL Protocol 2.0: bytes to packets and back, for both ends, without any port.

A packet is ``FF FF FD 00  ID  LEN_L LEN_H  instruction  parameters  CRC_L CRC_H``. In a status
packet the instruction is 0x55 and the first parameter is the error byte. From the instruction to
the last parameter ``FF FF FD`` travels as ``FF FF FD FD``; LEN and CRC are those of the bytes as
they travel.
The one exception is the answer to a fast read (id 0xFE, instruction 0x55), which is never stuffed.
Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".
"""

import re
from dataclasses import dataclass
from enum import IntEnum

from .crc import crc16 as crc16
from .groups import BulkRead as BulkRead
from .groups import BulkWrite as BulkWrite
from .groups import FastBlock as FastBlock
from .groups import bulk_read_params as bulk_read_params
from .groups import bulk_write_params as bulk_write_params
from .groups import fast_reply_pieces as fast_reply_pieces
from .groups import parse_bulk_read as parse_bulk_read
from .groups import parse_bulk_write as parse_bulk_write
from .groups import parse_fast_reply as parse_fast_reply
from .groups import parse_read as parse_read
from .groups import parse_sync_read as parse_sync_read
from .groups import parse_sync_write as parse_sync_write
from .groups import parse_write as parse_write
from .groups import read_params as read_params
from .groups import sync_read_params as sync_read_params
from .groups import sync_write_params as sync_write_params
from .groups import write_params as write_params

HEADER = b"\xff\xff\xfd\x00"
BROADCAST_ID = 0xFE
ALERT_BIT = 0x80
"""Bit of the error byte that says that Hardware Error Status is not zero."""
MAX_LENGTH = 4096
"""Greatest LEN that the decoder believes."""

_PREFIX = 7  # header, id, LEN
_MARK = b"\xff\xff\xfd"
_STUFFED = b"\xff\xff\xfd\xfd"
_UNSTUFFED = re.compile(rb"\xff\xff\xfd(?!\xfd)")


class Instruction(IntEnum):
    """What a packet is about."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    CONTROL_TABLE_BACKUP = 0x20
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93
    FAST_BULK_READ = 0x9A


ERROR_TEXTS = {
    1: "it could not carry the instruction out (result fail)",
    2: "it does not know the instruction (instruction error)",
    3: "the packet reached it damaged (CRC error)",
    4: "the value is out of the register's range (data range error)",
    5: "the data are too short or too long for the register (data length error)",
    6: "the value is beyond the limit set in the servo (data limit error)",
    7: "the register cannot be read or written now (access error)",
}
"""What the error numbers of a status packet mean."""


@dataclass(frozen=True, slots=True)
class Packet:
    """One packet, without header, stuffing and CRC."""

    servo_id: int
    """Id of the servo it goes to or comes from."""
    instruction: int
    """An ``Instruction``; a number that is none of them stays a number."""
    params: bytes = b""
    """Parameters; of a status packet those after the error byte."""
    error: int = 0
    """Error byte of a status packet."""

    @property
    def is_status(self) -> bool:
        """Whether a servo sent it."""
        return self.instruction == Instruction.STATUS

    @property
    def error_number(self) -> int:
        """Error number of a status packet without the alert bit; 0: none."""
        return self.error & ~ALERT_BIT & 0xFF

    @property
    def alert(self) -> bool:
        """Whether the servo reports a latched hardware error."""
        return bool(self.error & ALERT_BIT)


def stuff(body: bytes) -> bytes:
    """Give instruction and parameters as they travel."""
    return body.replace(_MARK, _STUFFED)


def unstuff(body: bytes) -> bytes:
    """Give instruction and parameters as they are meant; undoes ``stuff``."""
    return body.replace(_STUFFED, _MARK)


def encode(servo_id: int, instruction: int, params: bytes = b"") -> bytes:
    """Give the bytes of an instruction packet.

    Raises:
        ValueError: If the id is none, or there is more than a packet can carry.
    """
    if not 0 <= servo_id <= BROADCAST_ID:
        raise ValueError(f"servo_id: want 0..{BROADCAST_ID}, got {servo_id}")
    body = stuff(bytes((instruction,)) + params)
    length = len(body) + 2
    if length > MAX_LENGTH:
        raise ValueError(f"params: want at most {MAX_LENGTH} bytes in a packet, got {length}")
    frame = HEADER + bytes((servo_id, length & 0xFF, length >> 8)) + body
    return frame + crc16(frame).to_bytes(2, "little")


def encode_status(servo_id: int, error: int = 0, params: bytes = b"") -> bytes:
    """Give the bytes of a status packet; ``error`` is the whole error byte with its alert bit."""
    return encode(servo_id, Instruction.STATUS, bytes((error,)) + params)


class Decoder:
    """Finds packets in a stream of bytes, however it is cut.

    Noise, damaged and truncated packets are skipped up to the next header, and counted.
    """

    def __init__(self) -> None:
        self._pending = bytearray()
        self.crc_errors = 0
        """Packets thrown away because their CRC was wrong."""
        self.noise_bytes = 0
        """Bytes thrown away because they belonged to no good packet."""

    @property
    def pending(self) -> int:
        """Number of bytes that wait for the rest of their packet."""
        return len(self._pending)

    def reset(self) -> None:
        """Forget what has come of a packet whose rest will not come any more."""
        self.noise_bytes += len(self._pending)
        self._pending.clear()

    def feed(self, data: bytes) -> list[Packet]:
        """Take bytes as they come and give the packets that they complete, oldest first."""
        self._pending += data
        packets: list[Packet] = []
        while self._seek_header():
            end = self._frame_end()
            if end is None:
                break
            if end == 0:
                continue
            packet = _decode(bytes(self._pending[:end]))
            if packet is None:
                self.crc_errors += 1
                self._skip(1)
                continue
            packets.append(packet)
            del self._pending[:end]
        return packets

    def _seek_header(self) -> bool:
        """Drop what precedes the next header; say whether a whole prefix is there."""
        start = self._pending.find(HEADER)
        if start < 0:
            tail = next((n for n in (3, 2, 1) if self._pending.endswith(HEADER[:n])), 0)
            start = len(self._pending) - tail
        self._skip(start)
        return len(self._pending) >= _PREFIX

    def _frame_end(self) -> int | None:
        """Say where the frame at the start ends; None: not yet here; 0: it is none, skipped."""
        pending = self._pending
        length = pending[5] | pending[6] << 8
        if not 3 <= length <= MAX_LENGTH or pending[4] > BROADCAST_ID:
            self._skip(1)
            return 0
        end = _PREFIX + length
        if not _is_fast_reply(pending):
            cut = _inner_header(pending, end)
            if cut:
                self._skip(cut)
                return 0
        return end if len(pending) >= end else None

    def _skip(self, count: int) -> None:
        """Throw bytes away."""
        self.noise_bytes += count
        del self._pending[:count]


def decode(frame: bytes) -> Packet:
    """Give the packet of exactly one frame.

    Raises:
        ValueError: If the bytes are not exactly one good packet.
    """
    packets = Decoder().feed(frame)
    if len(packets) != 1 or _PREFIX + (frame[5] | frame[6] << 8) != len(frame):
        raise ValueError(f"frame: want one whole packet, got {frame.hex(' ')}")
    return packets[0]


def _is_fast_reply(frame: bytes | bytearray) -> bool:
    """Say whether a frame answers a fast read: only there does a status come from 0xFE."""
    return len(frame) > _PREFIX and frame[4] == BROADCAST_ID and frame[7] == Instruction.STATUS


def _inner_header(pending: bytearray, end: int) -> int:
    """Say where within an unfinished or damaged frame a new header begins; 0: nowhere.

    Stuffing leaves no ``FF FF FD`` in a body unless another FD follows: without it, what was sent
    before has been cut short.
    """
    body_end = min(end - 2, len(pending))
    match = _UNSTUFFED.search(pending, _PREFIX, body_end)
    if match is None or (match.end() == body_end and body_end < end - 2):
        return 0
    return match.start()


def _decode(frame: bytes) -> Packet | None:
    """Decode a frame whose LEN fits; None if its CRC is wrong or it carries no error byte."""
    if crc16(frame[:-2]) != frame[-2] | frame[-1] << 8:
        return None
    if _is_fast_reply(frame):
        return Packet(BROADCAST_ID, Instruction.STATUS, frame[_PREFIX + 1 : -2])
    body = unstuff(frame[_PREFIX:-2])
    instruction = body[0]
    if instruction != Instruction.STATUS:
        return Packet(frame[4], instruction, body[1:])
    if len(body) < 2:
        return None
    return Packet(frame[4], instruction, body[2:], body[1])
