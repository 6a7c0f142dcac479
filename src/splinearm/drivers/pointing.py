"""Making the Indirect Addresses of a servo name the registers that a layout wants."""

import logging
import struct
from collections.abc import Iterable, Sequence

from splinearm.errors import ServoError

from .bus import ServoBus, loss_error
from .chain import ServoSpec
from .cyclic import GroupRead
from .groups import BulkRead
from .layout import Place, Pointer

_log = logging.getLogger(__name__)

_TRIES = 3
_SIZE = 2


def point_at(bus: ServoBus, servo: ServoSpec, places: Iterable[Place]) -> bool:
    """Write the Indirect Addresses that make places, as far as they are not so already.

    Whether that is allowed while the torque is on differs from model to model; the servo is asked.

    Returns:
        Whether they are so now; False: the servo refused.

    Raises:
        BusError: If the servo does not answer.
    """
    pointers = [pointer for place in places for pointer in place.pointers]
    wrong = _wrong(bus, servo, pointers)
    table = servo.servo_model.table
    try:
        for pointer in wrong:
            bus.write(servo.servo_id, table.at(pointer.address), pointer.target)
    except ServoError as error:
        _log.info("servo %d (%s): %s", servo.servo_id, servo.name, error.reason)
        return False
    return not wrong or not _wrong(bus, servo, wrong)


def _wrong(bus: ServoBus, servo: ServoSpec, pointers: Sequence[Pointer]) -> list[Pointer]:
    """Give the pointers that hold something else."""
    wrong: list[Pointer] = []
    for run in _runs(pointers):
        data = _read(bus, servo, run[0].address, _SIZE * len(run))
        held = struct.unpack(f"<{len(run)}H", data)
        wrong += [p for p, target in zip(run, held, strict=True) if p.target != target]
    return wrong


def _runs(pointers: Sequence[Pointer]) -> list[list[Pointer]]:
    """Split pointers into those that follow each other."""
    runs: list[list[Pointer]] = []
    for pointer in sorted(pointers):
        if runs and pointer.address == runs[-1][-1].address + _SIZE:
            runs[-1].append(pointer)
        else:
            runs.append([pointer])
    return runs


def _read(bus: ServoBus, servo: ServoSpec, address: int, length: int) -> bytes:
    """Read bytes of one servo, trying again if they are lost."""
    group = GroupRead([BulkRead(servo.servo_id, address, length)], fast=False)
    reply = bus.sync_read(group)[servo.servo_id]
    for _ in range(_TRIES - 1):
        if reply.loss is None:
            break
        reply = bus.sync_read(group)[servo.servo_id]
    if reply.loss is not None:
        raise loss_error(reply, servo.servo_id, "Indirect Address", port=bus.port, name=servo.name)
    return reply.data
