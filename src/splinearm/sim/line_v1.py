"""Protocol 1.0 on the line: which servos obey a packet, and who answers in which order.

Its error byte is a set of bits: latched faults of the servo, and what was wrong with the packet.
A ping to all is answered by all at once, so that it is of use with a single servo only.
Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 1.0".
"""

from collections.abc import Sequence

from splinearm.drivers.packets import BROADCAST_ID, Instruction, Packet
from splinearm.drivers.packets_v1 import MAX_LENGTH, encode_status

from .rule import Refusal
from .virtual_servo import FactoryReset, VirtualServo
from .voice import ALL, PING_AND_READ, PING_ONLY, Reply, Voice, by_id, readers, together

_CHECKSUM_ERROR = 0x10


def answer(servos: Sequence[VirtualServo], packet: Packet, voice: Voice) -> list[Reply]:
    """Let the servos that hear a packet obey it; give what comes back."""
    if packet.servo_id != BROADCAST_ID:
        return together(
            [_unicast(s, packet, voice) for s in servos if s.servo_id == packet.servo_id]
        )
    match packet.instruction:
        case Instruction.PING:
            return together([_status(servo, 0, b"", voice) for servo in servos])
        case Instruction.SYNC_WRITE:
            _sync_write(servos, packet.params)
        case Instruction.BULK_READ:
            return _bulk_read(servos, packet.params, voice)
        case _:
            for servo in servos:
                _obey(servo, packet)
    return []


def complain(servos: Sequence[VirtualServo], packet: Packet, voice: Voice) -> list[Reply]:
    """Let the servo of an id say that a packet for it was damaged."""
    return together(
        [
            _status(servo, 0, b"", voice, bits=_CHECKSUM_ERROR)
            for servo in servos
            if servo.servo_id == packet.servo_id
        ]
    )


def written(packet: Packet) -> int:
    """Give how many bytes a packet writes to one servo."""
    one = packet.instruction in (Instruction.WRITE, Instruction.REG_WRITE)
    return max(len(packet.params) - 1, 0) if one else 0


def _unicast(servo: VirtualServo, packet: Packet, voice: Voice) -> Reply | None:
    """Let a servo obey and answer, if its Status Return Level says so."""
    level, servo_id = servo.memory.get("Status Return Level", ALL), servo.servo_id
    needed, number, data = _obey(servo, packet)
    return _status(servo, number, data, voice, servo_id=servo_id) if level >= needed else None


def _obey(servo: VirtualServo, packet: Packet) -> tuple[int, int, bytes]:
    """Let a servo obey; give the status return level that the answer needs, error number, data."""
    params = packet.params
    match packet.instruction:
        case Instruction.PING:
            return PING_ONLY, Refusal.NONE, b""
        case Instruction.READ if len(params) == 2:
            return PING_AND_READ, *_read(servo, params[0], params[1])
        case Instruction.READ:
            return PING_AND_READ, Refusal.DATA_LENGTH, b""
    return ALL, _do(servo, packet), b""


def _do(servo: VirtualServo, packet: Packet) -> int:
    """Let a servo do what only changes something; give the error number."""
    match packet.instruction:
        case Instruction.WRITE | Instruction.REG_WRITE:
            return _write(servo, packet)
        case Instruction.ACTION:
            return servo.action()
        case Instruction.REBOOT:
            return servo.reboot()
        case Instruction.FACTORY_RESET:
            return servo.factory_reset(FactoryReset.ALL)
    return Refusal.INSTRUCTION


def _read(servo: VirtualServo, address: int, length: int) -> tuple[int, bytes]:
    """Give an error number and the bytes at an address, if a packet can carry them."""
    if length > MAX_LENGTH - 2:
        return Refusal.DATA_LENGTH, b""
    return servo.read(address, length)


def _write(servo: VirtualServo, packet: Packet) -> int:
    """Write, now or with the next action; give the error number."""
    address, data = packet.params[:1], packet.params[1:]
    if not data:
        return Refusal.DATA_LENGTH
    write = servo.write if packet.instruction == Instruction.WRITE else servo.reg_write
    return write(address[0], data)


def _sync_write(servos: Sequence[VirtualServo], params: bytes) -> None:
    """Give each servo its own; parameters that make no sense are ignored."""
    if len(params) < 2 or (len(params) - 2) % (1 + params[1]) or not params[1]:
        return
    address, length = params[0], params[1]
    called = by_id(servos)
    for start in range(2, len(params), 1 + length):
        for servo in called.get(params[start], ()):
            servo.write(address, params[start + 1 : start + 1 + length])


def _bulk_read(servos: Sequence[VirtualServo], params: bytes, voice: Voice) -> list[Reply]:
    """Let each servo answer once its predecessor has.

    Parameters are 0, then length, id and address of each.
    """
    replies: list[Reply] = []
    if len(params) < 4 or params[0] != 0 or (len(params) - 1) % 3:
        return replies
    able = readers([servo for servo in servos if not _is_ax(servo)])
    for start in range(1, len(params), 3):
        length, servo_id, address = params[start : start + 3]
        sent = together(
            [_status(s, *_read(s, address, length), voice) for s in able.get(servo_id, ())]
        )
        if not sent and voice.habits.bulk_read_1_ends:
            break
        replies += sent
    return replies


def _status(
    servo: VirtualServo,
    number: int,
    data: bytes,
    voice: Voice,
    *,
    servo_id: int = -1,
    bits: int = 0,
) -> Reply | None:
    """Give a servo's status packet, under the id by which it was asked; None if it is lost."""
    error = servo.error_byte_v1(number) | bits
    return voice.send(
        servo, encode_status(servo.servo_id if servo_id < 0 else servo_id, error, data)
    )


def _is_ax(servo: VirtualServo) -> bool:
    return servo.model.name.startswith("AX-")
