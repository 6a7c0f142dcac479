"""Registers of many servos asked for at once, and asked again if an answer is lost."""

from collections.abc import Mapping, Sequence

from .ability import HARDWARE_ERROR, having, says_torque, torque_span
from .bus import Reply, ServoBus, loss_error
from .chain import ServoSpec
from .cyclic import GroupRead
from .groups import BulkRead

_TRIES = 3


def read_all(bus: ServoBus, servos: Sequence[ServoSpec], name: str) -> dict[int, int]:
    """Read a register of many servos; give the values by id.

    Raises:
        BusError: If a servo gives no answer.
    """
    registers = {servo.servo_id: servo.servo_model.table[name] for servo in servos}
    requests = [BulkRead(servo_id, r.address, r.size) for servo_id, r in registers.items()]
    replies = _ask(bus, servos, requests, name)
    return {servo_id: registers[servo_id].decode(reply.data) for servo_id, reply in replies.items()}


def read_torque(bus: ServoBus, servos: Sequence[ServoSpec]) -> dict[int, bool]:
    """Give by id whether servos have torque.

    Raises:
        BusError: If a servo gives no answer.
    """
    requests = [BulkRead(s.servo_id, *torque_span(s.servo_model)) for s in servos]
    replies = _ask(bus, servos, requests, "Torque Enable")
    return {servo_id: says_torque(reply.data) for servo_id, reply in replies.items()}


def read_latched(bus: ServoBus, servos: Sequence[ServoSpec]) -> dict[int, int]:
    """Give by id the hardware errors that servos report, 0 if none.

    Those without a register for it say so in the error byte of every answer.

    Raises:
        BusError: If a servo gives no answer.
    """
    modern = having(servos, HARDWARE_ERROR)
    old = [servo for servo in servos if servo not in modern]
    requests = [BulkRead(s.servo_id, s.servo_model.table["ID"].address, 1) for s in old]
    replies = _ask(bus, old, requests, HARDWARE_ERROR)
    told = {servo_id: reply.latched for servo_id, reply in replies.items()}
    found = read_all(bus, modern, HARDWARE_ERROR) | told
    return {servo.servo_id: found[servo.servo_id] for servo in servos}


def _ask(
    bus: ServoBus, servos: Sequence[ServoSpec], requests: Sequence[BulkRead], name: str
) -> dict[int, Reply]:
    """Give by id what servos answered."""
    if not requests:
        return {}
    group = GroupRead(requests, fast=False)
    found: dict[int, Reply] = {}
    replies: Mapping[int, Reply] = {}
    for _ in range(_TRIES):
        replies = bus.sync_read(group)
        found |= {servo_id: reply for servo_id, reply in replies.items() if reply.loss is None}
        if len(found) == len(requests):
            return found
    lost = next(servo for servo in servos if servo.servo_id not in found)
    raise loss_error(replies[lost.servo_id], lost.servo_id, name, port=bus.port, name=lost.name)
