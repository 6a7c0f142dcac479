"""The line on which servos hang: which of them obey a packet, and who answers in which order.

Where the manual is silent: in a sync or bulk read the others answer even if one is missing; the
answer to a fast read ends before the first that is missing, for the CRCs are chained. Servos that
answer at the same time pull the line low together: their bits are and-ed.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from typing import NamedTuple

from splinearm.drivers.packets import (
    BROADCAST_ID,
    FastBlock,
    Instruction,
    Packet,
    encode_status,
    fast_reply_pieces,
    parse_bulk_read,
    parse_bulk_write,
    parse_read,
    parse_sync_read,
    parse_sync_write,
    parse_write,
)

from .rule import Refusal
from .virtual_servo import VirtualServo

_PING_ONLY, _PING_AND_READ, _ALL = 0, 1, 2
"""Values of Status Return Level."""

_DELAY_UNIT = 2e-6


class Reply(NamedTuple):
    """Bytes that come back, and how long the servo waits before it sends them, s."""

    data: bytes
    delay: float


class _Request(NamedTuple):
    """What a group read asks of one servo."""

    servo_id: int
    address: int
    length: int


class Line:
    """Servos on one pair of wires."""

    def __init__(self, servos: Iterable[VirtualServo]) -> None:
        self.servos = tuple(servos)
        self.silent = False
        """Whether the wire is cut between the computer and all servos."""
        self._groups: dict[int, Callable[[Sequence[VirtualServo], bytes], list[Reply]]] = {
            Instruction.SYNC_READ: _sync_read,
            Instruction.FAST_SYNC_READ: _fast_sync_read,
            Instruction.BULK_READ: _bulk_read,
            Instruction.FAST_BULK_READ: _fast_bulk_read,
            Instruction.SYNC_WRITE: _sync_write,
            Instruction.BULK_WRITE: _bulk_write,
        }

    def answer(self, packet: Packet, baud: int) -> list[Reply]:
        """Let the servos that understand the baud rate obey a packet; give what comes back."""
        if self.silent or packet.is_status:
            return []
        servos = [servo for servo in self.servos if servo.listens(baud)]
        for servo in servos:
            servo.heard()
        group = self._groups.get(packet.instruction)
        if group is not None and packet.servo_id == BROADCAST_ID:
            try:
                return group(servos, packet.params)
            except ValueError:  # parameters that no servo can make sense of
                return []
        if packet.servo_id == BROADCAST_ID:
            return _broadcast(servos, packet)
        return _unicast(servos, packet)


def _broadcast(servos: Sequence[VirtualServo], packet: Packet) -> list[Reply]:
    """Let all servos obey; a ping is answered by each in the order of their ids."""
    if packet.instruction == Instruction.PING:
        ids = sorted({servo.servo_id for servo in servos})
        return [
            reply
            for servo_id in ids
            for reply in _pinged([servo for servo in servos if servo.servo_id == servo_id])
        ]
    for servo in servos:
        _obey(servo, packet, broadcast=True)
    return []


def _pinged(servos: Sequence[VirtualServo]) -> list[Reply]:
    return _together([_status(servo, 0, servo.ping()) for servo in servos])


def _unicast(servos: Sequence[VirtualServo], packet: Packet) -> list[Reply]:
    """Let the servo of that id obey and answer, and those that shadow the id obey in silence."""
    replies: list[Reply | None] = []
    for servo in servos:
        if servo.servo_id == packet.servo_id:
            level, servo_id = servo.memory["Status Return Level"], servo.servo_id
            needed, number, data = _obey(servo, packet)
            if level >= needed:
                replies.append(_status(servo, number, data, servo_id=servo_id))
        elif servo.secondary_id == packet.servo_id and packet.instruction in _SHADOWED:
            _obey(servo, packet, shadowing=True)
    return _together(replies)


def _obey(
    servo: VirtualServo, packet: Packet, *, shadowing: bool = False, broadcast: bool = False
) -> tuple[int, int, bytes]:
    """Let a servo obey; give the status return level that the answer needs, error number, data."""
    if packet.instruction == Instruction.PING:
        return _PING_ONLY, Refusal.NONE, servo.ping()
    try:
        if packet.instruction == Instruction.READ:
            return _PING_AND_READ, *servo.read(*parse_read(packet.params))
        if packet.instruction == Instruction.WRITE:
            number = servo.write(*parse_write(packet.params), shadowing=shadowing)
        elif packet.instruction == Instruction.REG_WRITE:
            number = servo.reg_write(*parse_write(packet.params), shadowing=shadowing)
        else:
            number = _do(servo, packet, broadcast=broadcast)
    except ValueError:  # too few or too many parameters
        number = Refusal.DATA_LENGTH
    return _ALL, number, b""


def _do(servo: VirtualServo, packet: Packet, *, broadcast: bool) -> int:
    """Let a servo do what is neither reading nor writing; give the error number."""
    match packet.instruction:
        case Instruction.ACTION:
            return servo.action()
        case Instruction.REBOOT:
            return servo.reboot()
        case Instruction.FACTORY_RESET:
            option = int.from_bytes(packet.params, "little")
            return servo.factory_reset(option, broadcast=broadcast)
        case Instruction.CLEAR:
            return servo.clear(packet.params)
        case Instruction.CONTROL_TABLE_BACKUP:
            return servo.backup(packet.params)
    return Refusal.INSTRUCTION


_SHADOWED = frozenset(
    (
        Instruction.WRITE,
        Instruction.REG_WRITE,
        Instruction.ACTION,
        Instruction.REBOOT,
        Instruction.CLEAR,
    )
)
"""Instructions that reach a servo by its secondary id; the others read, or change its EEPROM."""


def _sync_write(servos: Sequence[VirtualServo], params: bytes) -> list[Reply]:
    address, _, entries = parse_sync_write(params)
    for servo_id, data in entries:
        _write(servos, servo_id, address, data)
    return []


def _bulk_write(servos: Sequence[VirtualServo], params: bytes) -> list[Reply]:
    for servo_id, address, data in parse_bulk_write(params):
        _write(servos, servo_id, address, data)
    return []


def _write(servos: Sequence[VirtualServo], servo_id: int, address: int, data: bytes) -> None:
    """Write to the servo of that id and to those that shadow it."""
    for servo in servos:
        if servo.servo_id == servo_id:
            servo.write(address, data)
        elif servo.secondary_id == servo_id:
            servo.write(address, data, shadowing=True)


def _sync_read(servos: Sequence[VirtualServo], params: bytes) -> list[Reply]:
    return _one_after_another(servos, _sync_requests(params))


def _bulk_read(servos: Sequence[VirtualServo], params: bytes) -> list[Reply]:
    return _one_after_another(servos, _bulk_requests(params))


def _fast_sync_read(servos: Sequence[VirtualServo], params: bytes) -> list[Reply]:
    return _chained(servos, _sync_requests(params))


def _fast_bulk_read(servos: Sequence[VirtualServo], params: bytes) -> list[Reply]:
    return _chained(servos, _bulk_requests(params))


def _sync_requests(params: bytes) -> list[_Request]:
    address, length, ids = parse_sync_read(params)
    return [_Request(servo_id, address, length) for servo_id in ids]


def _bulk_requests(params: bytes) -> list[_Request]:
    return [_Request(*entry) for entry in parse_bulk_read(params)]


def _readers(servos: Sequence[VirtualServo], servo_id: int) -> list[VirtualServo]:
    """Give the servos of an id that answer reads."""
    return [
        servo
        for servo in servos
        if servo.servo_id == servo_id and servo.memory["Status Return Level"] >= _PING_AND_READ
    ]


def _one_after_another(servos: Sequence[VirtualServo], requests: Sequence[_Request]) -> list[Reply]:
    """Let each servo answer with a status packet of its own, in the order in which it was asked."""
    replies: list[Reply] = []
    for servo_id, address, length in requests:
        answers = [
            _status(servo, *servo.read(address, length)) for servo in _readers(servos, servo_id)
        ]
        replies += _together(answers)
    return replies


def _chained(servos: Sequence[VirtualServo], requests: Sequence[_Request]) -> list[Reply]:
    """Let the servos answer with one status packet in pieces; it ends before one that is missing.

    What cannot be read comes as zeros with its error, so that the packet keeps its length.
    """
    blocks: list[FastBlock] = []
    senders: list[VirtualServo | None] = []
    for servo_id, address, length in requests:
        readers = [servo for servo in _readers(servos, servo_id) if servo.has_fast_read]
        sender = readers[0] if readers and not readers[0].mute else None
        number, data = sender.read(address, length) if sender else (0, b"")
        error = sender.error_byte(number) if sender else 0
        blocks.append(FastBlock(servo_id, error, data or bytes(length)))
        senders.append(sender)
    replies: list[Reply] = []
    for sender, piece in zip(senders, fast_reply_pieces(blocks), strict=True):
        if sender is None:
            break
        delay = 0.0 if replies else _delay(sender)
        replies.append(Reply(_on_the_way(sender, piece), delay))
    return replies


def _status(
    servo: VirtualServo, number: int, data: bytes, *, servo_id: int | None = None
) -> Reply | None:
    """Give a servo's status packet, under the id by which it was asked; None if it is mute."""
    if servo.mute:
        return None
    servo_id = servo.servo_id if servo_id is None else servo_id
    frame = encode_status(servo_id, servo.error_byte(number), data)
    return Reply(_on_the_way(servo, frame), _delay(servo))


def _delay(servo: VirtualServo) -> float:
    return servo.memory["Return Delay Time"] * _DELAY_UNIT


def _on_the_way(servo: VirtualServo, frame: bytes) -> bytes:
    """Damage a frame, if it is to be damaged: one bit of its last byte but one."""
    if servo.corrupt_replies <= 0:
        return frame
    servo.corrupt_replies -= 1
    return frame[:-2] + bytes((frame[-2] ^ 0x01,)) + frame[-1:]


def _together(replies: Sequence[Reply | None]) -> list[Reply]:
    """Give what is on the line when servos answer at the same time."""
    sent = [reply for reply in replies if reply is not None]
    if len(sent) < 2:
        return sent
    merged = reduce(_low_together, (reply.data for reply in sent))
    return [Reply(merged, min(reply.delay for reply in sent))]


def _low_together(a: bytes, b: bytes) -> bytes:
    short, long = sorted((a, b), key=len)
    return bytes(x & y for x, y in zip(short, long, strict=False)) + long[len(short) :]
