"""Protocol 2.0 on the line: which servos obey a packet, and who answers in which order."""

from collections.abc import Callable, Iterable, Sequence
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
from .voice import ALL, PING_AND_READ, PING_ONLY, Reply, Voice, by_id, readers, together

_CRC_ERROR = 3
_NOBODY = (None,)


class _Request(NamedTuple):
    """What a group read asks of one servo."""

    servo_id: int
    address: int
    length: int


def answer(servos: Sequence[VirtualServo], packet: Packet, voice: Voice) -> list[Reply]:
    """Let the servos that hear a packet obey it; give what comes back."""
    if packet.servo_id != BROADCAST_ID:
        return _unicast(servos, packet, voice)
    group = _GROUPS.get(packet.instruction)
    if group is None:
        return _broadcast(servos, packet, voice)
    try:
        return group(servos, packet.params, voice)
    except ValueError:  # parameters that no servo can make sense of
        return []


def complain(servos: Sequence[VirtualServo], packet: Packet, voice: Voice) -> list[Reply]:
    """Let the servo of an id say that a packet for it was damaged."""
    return together(
        [_status(s, _CRC_ERROR, b"", voice) for s in servos if s.servo_id == packet.servo_id]
    )


def written(packet: Packet) -> int:
    """Give how many bytes a packet writes to one servo."""
    one = packet.instruction in (Instruction.WRITE, Instruction.REG_WRITE)
    return max(len(packet.params) - 2, 0) if one else 0


def asked_ids(packet: Packet) -> set[int]:
    """Give the ids that a fast read asks."""
    requests = (
        _sync_requests if packet.instruction == Instruction.FAST_SYNC_READ else _bulk_requests
    )
    try:
        return {request.servo_id for request in requests(packet.params)}
    except ValueError:
        return set()


def _broadcast(servos: Sequence[VirtualServo], packet: Packet, voice: Voice) -> list[Reply]:
    """Let all servos obey; a ping is answered by each in the order of their ids."""
    if packet.instruction == Instruction.PING:
        ids = sorted({servo.servo_id for servo in servos})
        return [
            reply
            for servo_id in ids
            for reply in together(
                [_status(s, 0, s.ping(), voice) for s in servos if s.servo_id == servo_id]
            )
        ]
    for servo in servos:
        _obey(servo, packet, broadcast=True)
    return []


def _unicast(servos: Sequence[VirtualServo], packet: Packet, voice: Voice) -> list[Reply]:
    """Let the servo of that id obey and answer, and those that shadow the id obey in silence."""
    replies: list[Reply | None] = []
    for servo in servos:
        if servo.servo_id == packet.servo_id:
            level, servo_id = servo.memory["Status Return Level"], servo.servo_id
            needed, number, data = _obey(servo, packet)
            if level >= needed:
                replies.append(_status(servo, number, data, voice, servo_id=servo_id))
        elif servo.secondary_id == packet.servo_id and packet.instruction in _SHADOWED:
            _obey(servo, packet, shadowing=True)
    return together(replies)


def _obey(
    servo: VirtualServo, packet: Packet, *, shadowing: bool = False, broadcast: bool = False
) -> tuple[int, int, bytes]:
    """Let a servo obey; give the status return level that the answer needs, error number, data."""
    if packet.instruction == Instruction.PING:
        return PING_ONLY, Refusal.NONE, servo.ping()
    try:
        if packet.instruction == Instruction.READ:
            return PING_AND_READ, *servo.read(*parse_read(packet.params))
        if packet.instruction == Instruction.WRITE:
            number = servo.write(*parse_write(packet.params), shadowing=shadowing)
        elif packet.instruction == Instruction.REG_WRITE:
            number = servo.reg_write(*parse_write(packet.params), shadowing=shadowing)
        else:
            number = _do(servo, packet, broadcast=broadcast)
    except ValueError:  # too few or too many parameters
        number = Refusal.DATA_LENGTH
    return ALL, number, b""


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


def _sync_write(servos: Sequence[VirtualServo], params: bytes, _voice: Voice) -> list[Reply]:
    address, _, entries = parse_sync_write(params)
    _write(servos, [(servo_id, address, data) for servo_id, data in entries])
    return []


def _bulk_write(servos: Sequence[VirtualServo], params: bytes, _voice: Voice) -> list[Reply]:
    _write(servos, parse_bulk_write(params))
    return []


def _write(servos: Sequence[VirtualServo], entries: Iterable[tuple[int, int, bytes]]) -> None:
    """Write to the servos of each id and to those that shadow it."""
    called = by_id(servos)
    shadows = [(servo, servo.secondary_id) for servo in servos]
    shadows = [(servo, followed) for servo, followed in shadows if followed < BROADCAST_ID]
    for servo_id, address, data in entries:
        for servo in called.get(servo_id, ()):
            servo.write(address, data)
        for servo, followed in shadows:
            if followed == servo_id != servo.servo_id:
                servo.write(address, data, shadowing=True)


def _sync_read(servos: Sequence[VirtualServo], params: bytes, voice: Voice) -> list[Reply]:
    return _one_after_another(servos, _sync_requests(params), voice)


def _bulk_read(servos: Sequence[VirtualServo], params: bytes, voice: Voice) -> list[Reply]:
    return _one_after_another(servos, _bulk_requests(params), voice)


def _fast_sync_read(servos: Sequence[VirtualServo], params: bytes, voice: Voice) -> list[Reply]:
    return _chained(servos, _sync_requests(params), voice)


def _fast_bulk_read(servos: Sequence[VirtualServo], params: bytes, voice: Voice) -> list[Reply]:
    return _chained(servos, _bulk_requests(params), voice)


_GROUPS: dict[int, Callable[[Sequence[VirtualServo], bytes, Voice], list[Reply]]] = {
    Instruction.SYNC_READ: _sync_read,
    Instruction.FAST_SYNC_READ: _fast_sync_read,
    Instruction.BULK_READ: _bulk_read,
    Instruction.FAST_BULK_READ: _fast_bulk_read,
    Instruction.SYNC_WRITE: _sync_write,
    Instruction.BULK_WRITE: _bulk_write,
}


def _sync_requests(params: bytes) -> list[_Request]:
    address, length, ids = parse_sync_read(params)
    return [_Request(servo_id, address, length) for servo_id in ids]


def _bulk_requests(params: bytes) -> list[_Request]:
    return [_Request(*entry) for entry in parse_bulk_read(params)]


def _one_after_another(
    servos: Sequence[VirtualServo], requests: Sequence[_Request], voice: Voice
) -> list[Reply]:
    """Let each servo answer with a status packet of its own, in the order in which it was asked."""
    replies: list[Reply] = []
    able = readers(servos)
    for servo_id, address, length in requests:
        answers = together(
            [_status(s, *s.read(address, length), voice) for s in able.get(servo_id, ())]
        )
        if not answers and voice.habits.sync_read_ends:
            break
        replies += answers
    return replies


def _chained(
    servos: Sequence[VirtualServo], requests: Sequence[_Request], voice: Voice
) -> list[Reply]:
    """Let the servos answer with one status packet in pieces; it ends before one that is missing.

    What cannot be read comes as zeros with its error, so that the packet keeps its length.
    """
    blocks: list[FastBlock] = []
    senders: list[VirtualServo | None] = []
    able = readers([servo for servo in servos if servo.has_fast_read])
    for servo_id, address, length in requests:
        sender = able.get(servo_id, _NOBODY)[0]
        number, data = sender.read(address, length) if sender else (0, b"")
        error = sender.error_byte(number) if sender else 0
        blocks.append(FastBlock(servo_id, error, data or bytes(length)))
        senders.append(sender)
    replies: list[Reply] = []
    for sender, piece in zip(senders, fast_reply_pieces(blocks), strict=True):
        reply = voice.send(sender, piece, at_once=bool(replies)) if sender else None
        if reply is None:
            break
        replies.append(reply)
        if len(reply.data) < len(piece):  # the next waits for bytes that do not come
            break
    return replies


def _status(
    servo: VirtualServo, number: int, data: bytes, voice: Voice, *, servo_id: int | None = None
) -> Reply | None:
    """Give a servo's status packet, under the id by which it was asked; None if it is lost."""
    servo_id = servo.servo_id if servo_id is None else servo_id
    return voice.send(servo, encode_status(servo_id, servo.error_byte(number), data))
