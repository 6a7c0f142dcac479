"""Parameters of reads and writes of one servo and of many, and the answers to fast reads.

Builders and parsers come in pairs, one for each end of the bus. Numbers are little-endian. Parsers
raise ``ValueError`` on parameters that cannot be what they should be.
"""

import struct
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from .crc import crc16

_FAST_PREFIX = b"\xff\xff\xfd\x00\xfe"
_ADDRESS_LENGTH = struct.Struct("<HH")
_ID_ADDRESS_LENGTH = struct.Struct("<BHH")


class BulkRead(NamedTuple):
    """What a bulk read asks of one servo."""

    servo_id: int
    """The servo."""
    address: int
    """Where to begin."""
    length: int
    """How many bytes."""


class BulkWrite(NamedTuple):
    """What a bulk write gives to one servo."""

    servo_id: int
    """The servo."""
    address: int
    """Where to begin."""
    data: bytes
    """What to write there."""


class FastBlock(NamedTuple):
    """What one servo says in the answer to a fast read."""

    servo_id: int
    """The servo."""
    error: int
    """Its error byte."""
    data: bytes
    """What it read."""


def asked_next(requests: Sequence[BulkRead], lost: Collection[int]) -> list[BulkRead]:
    """Give the order in which to ask next time: servos that were lost come last.

    Where servos wait for the one before them, all after a dead one are lost with it. So the first
    of several that were lost changes to the end: the next time its place is another's.
    """
    sure = [request for request in requests if request.servo_id not in lost]
    doubted = [request for request in requests if request.servo_id in lost]
    return sure + doubted[1:] + doubted[:1]


def read_params(address: int, length: int) -> bytes:
    """Give the parameters of a read."""
    return _ADDRESS_LENGTH.pack(address, length)


def parse_read(params: bytes) -> tuple[int, int]:
    """Give address and length of a read."""
    if len(params) != 4:
        raise ValueError(f"read: want 4 bytes of parameters, got {len(params)}")
    address, length = _ADDRESS_LENGTH.unpack(params)
    return address, length


def write_params(address: int, data: bytes) -> bytes:
    """Give the parameters of a write."""
    return address.to_bytes(2, "little") + data


def parse_write(params: bytes) -> tuple[int, bytes]:
    """Give address and data of a write."""
    if len(params) < 3:
        raise ValueError(f"write: want at least 3 bytes of parameters, got {len(params)}")
    return int.from_bytes(params[:2], "little"), params[2:]


def sync_read_params(address: int, length: int, ids: Iterable[int]) -> bytes:
    """Give the parameters of a sync read or a fast sync read."""
    return _ADDRESS_LENGTH.pack(address, length) + bytes(ids)


def parse_sync_read(params: bytes) -> tuple[int, int, tuple[int, ...]]:
    """Give address, length and ids of a sync read."""
    if len(params) < 5:
        raise ValueError(f"sync read: want at least 5 bytes of parameters, got {len(params)}")
    address, length = _ADDRESS_LENGTH.unpack_from(params)
    return address, length, tuple(params[4:])


def sync_write_params(address: int, length: int, data: Mapping[int, bytes]) -> bytes:
    """Give the parameters of a sync write: ``length`` bytes of data for each id.

    Raises:
        ValueError: If the data of a servo have another length.
    """
    for servo_id, block in data.items():
        if len(block) != length:
            raise ValueError(f"data: want {length} bytes for servo {servo_id}, got {len(block)}")
    blocks = b"".join(bytes((servo_id,)) + block for servo_id, block in data.items())
    return _ADDRESS_LENGTH.pack(address, length) + blocks


def parse_sync_write(params: bytes) -> tuple[int, int, tuple[tuple[int, bytes], ...]]:
    """Give address, length and the data of each servo of a sync write."""
    if len(params) < 4:
        raise ValueError(f"sync write: want at least 4 bytes of parameters, got {len(params)}")
    address, length = _ADDRESS_LENGTH.unpack_from(params)
    step = length + 1
    if (len(params) - 4) % step:
        raise ValueError(f"sync write: want {step} bytes a servo, got {len(params) - 4} in all")
    starts = range(4, len(params), step)
    return address, length, tuple((params[i], params[i + 1 : i + step]) for i in starts)


def bulk_read_params(requests: Iterable[BulkRead]) -> bytes:
    """Give the parameters of a bulk read or a fast bulk read."""
    return b"".join(_ID_ADDRESS_LENGTH.pack(*request) for request in requests)


def parse_bulk_read(params: bytes) -> tuple[BulkRead, ...]:
    """Give what a bulk read asks of each servo."""
    if not params or len(params) % 5:
        raise ValueError(f"bulk read: want 5 bytes a servo, got {len(params)} in all")
    return tuple(BulkRead(*entry) for entry in _ID_ADDRESS_LENGTH.iter_unpack(params))


def bulk_write_params(entries: Iterable[BulkWrite]) -> bytes:
    """Give the parameters of a bulk write."""
    return b"".join(
        _ID_ADDRESS_LENGTH.pack(servo_id, address, len(data)) + data
        for servo_id, address, data in entries
    )


def parse_bulk_write(params: bytes) -> tuple[BulkWrite, ...]:
    """Give what a bulk write gives to each servo."""
    entries: list[BulkWrite] = []
    start = 0
    while start < len(params):
        if len(params) - start < 5:
            raise ValueError(f"bulk write: {len(params) - start} bytes are left over")
        servo_id, address, length = _ID_ADDRESS_LENGTH.unpack_from(params, start)
        data = params[start + 5 : start + 5 + length]
        if len(data) != length:
            raise ValueError(f"bulk write: want {length} bytes for {servo_id}, got {len(data)}")
        entries.append(BulkWrite(servo_id, address, data))
        start += 5 + length
    return tuple(entries)


def fast_reply_pieces(blocks: Sequence[FastBlock]) -> list[bytes]:
    """Give the answer to a fast read, in the pieces that the servos send one after the other.

    Each piece is the error byte, the id, the data and a CRC of every byte before it, from the first
    header byte; the first servo sends the header as well.
    """
    length = 1 + sum(4 + len(block.data) for block in blocks)
    sent = _FAST_PREFIX + length.to_bytes(2, "little") + b"\x55"
    pieces: list[bytes] = []
    crc = crc16(sent)
    for number, (servo_id, error, data) in enumerate(blocks):
        piece = bytes((error, servo_id)) + data
        crc = crc16(piece, crc)
        tail = crc.to_bytes(2, "little")
        crc = crc16(tail, crc)
        pieces.append((piece if number else sent + piece) + tail)
    return pieces


def parse_fast_reply(frame: bytes, wanted: Sequence[tuple[int, int]]) -> tuple[FastBlock, ...]:
    """Give what can be trusted of the answer to a fast read, whole, damaged or cut short.

    The CRC of each servo goes on from that of the one before. So a damaged block does not take
    those after it along: a block counts if its CRC fits what came before it, or what should have
    come if either the data or the CRC of the block before it were damaged on the way here.

    Args:
        frame: The answer from its header on, as far as it came.
        wanted: Id and number of bytes of each servo, in the order in which they were asked.
    """
    blocks: list[FastBlock] = []
    if len(frame) < 8 or not frame.startswith(_FAST_PREFIX) or frame[7] != 0x55:
        return ()
    whole = len(frame) >= 8 + sum(4 + length for _, length in wanted)
    start, states = 8, {crc16(frame[:8])}
    for servo_id, length in wanted:
        end = start + 4 + length
        named = end <= len(frame) and frame[start + 1] == servo_id
        if not (named or whole):
            continue
        tail = frame[end - 2 : end]
        sent = tail[0] | tail[1] << 8
        after = {crc16(frame[start : end - 2], state) for state in states}
        if named and sent in after:
            blocks.append(FastBlock(servo_id, frame[start], frame[start + 2 : end - 2]))
            after = {sent}
        states = {crc16(tail, crc) for crc in after}
        states |= {crc16(crc.to_bytes(2, "little"), crc) for crc in (*after, sent)}
        start = end
    return tuple(blocks)
