"""A bus that only listens: it asks, and nothing that changes a servo can be sent on it."""

import logging
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import isnan, nan
from typing import NoReturn

from splinearm.drivers.bus import WriteGroup
from splinearm.drivers.dialect import DIALECTS
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.packets import Instruction, Packet
from splinearm.drivers.registers import Register
from splinearm.errors import PortError

MARGIN = 0.05
"""How long an answer may be late and still count as one, s: adapters and computers pause."""

_REST = 2e-3  # s: how long to wait for the rest of what has begun to come


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Heard:
    """What came back for one question to one servo."""

    packets: tuple[Packet, ...]
    """Its good answers."""
    data: bytes
    """All that came, without the echo of the question."""
    is_echoed: bool
    """Whether the question itself came back."""
    is_clean: bool
    """Whether just one answer came, and nothing else."""
    seconds: float
    """How long it took until the answer was there, s; NaN: none came."""


class Stethoscope(DynamixelBus):
    """A bus for a look: reading and pinging only.

    Args:
        port: The port.
        baud: Bits per second.
        protocols: By id the protocol of servos that do not speak 2.0.
        margin: How long an answer may be late, s.

    Raises:
        PortError: If the port cannot be had.
    """

    def __init__(
        self,
        port: str,
        baud: int,
        *,
        protocols: Mapping[int, int] | None = None,
        margin: float = MARGIN,
    ) -> None:
        super().__init__(port, baud, margin=margin, protocols=protocols)

    def protocol_of(self, servo_id: int) -> int:
        """Give the protocol that a servo is spoken to in, 1 or 2."""
        return self._protocols.get(servo_id, 2)

    def listen(
        self,
        servo_id: int,
        instruction: Instruction = Instruction.PING,
        params: bytes = b"",
        *,
        answer: int | None = None,
        linger: float = 0.0,
        patience: float = 0.0,
    ) -> Heard:
        """Ask a servo once and give all that comes back.

        Args:
            servo_id: The servo.
            instruction: Ping or read.
            params: What is asked for.
            answer: Bytes of data that are awaited; None: those of a ping.
            linger: How long to listen on after the answer, s.
            patience: How much longer than usually to wait for it, s.

        Raises:
            PortError: If the port is gone.
        """
        if instruction not in (Instruction.PING, Instruction.READ):
            _refuse()
        dialect = DIALECTS[self.protocol_of(servo_id)]
        frame = dialect.frame(servo_id, instruction, params)
        if answer is None:
            answer = 3 if dialect.number == 2 else 0
        whole = dialect.status_length + answer
        link = self._link
        begun = time.monotonic()
        deadline = link.send(frame, 1, whole) + patience
        came, seconds = b"", nan
        packets: list[Packet] = []
        while data := link.receive_some(deadline):
            came += data
            heard = dialect.listener().feed(came.removeprefix(frame))
            packets = [packet for packet in heard if packet.servo_id == servo_id]
            enough = len(came.removeprefix(frame)) >= whole
            if packets and isnan(seconds):
                seconds = time.monotonic() - begun
            if packets and not linger:
                break
            if packets or enough:
                deadline = min(deadline, time.monotonic() + max(linger, _REST))
        own = came.removeprefix(frame)
        return Heard(
            packets=tuple(packets),
            data=own,
            is_echoed=len(own) < len(came),
            is_clean=len(packets) == 1 and len(own) <= whole,
            seconds=seconds,
        )

    def write(self, servo_id: int, register: Register, value: int) -> NoReturn:
        """Refuse."""
        _refuse()

    def sync_write(self, group: WriteGroup, values: Sequence[int]) -> NoReturn:
        """Refuse."""
        _refuse()

    def reboot(self, servo_id: int) -> NoReturn:
        """Refuse."""
        _refuse()

    def clear_turns(self, servo_id: int) -> NoReturn:
        """Refuse."""
        _refuse()

    def factory_reset(
        self,
        servo_id: int,
        *,
        keep_id: bool = True,
        keep_baud: bool = True,
    ) -> NoReturn:
        """Refuse."""
        _refuse()


def lacks_rate(error: PortError, baud: int) -> bool:
    """Say whether an error says only that a port does not have a rate."""
    return f"at {baud} baud" in error.reason


@contextmanager
def hushed() -> Iterator[None]:
    """Keep back the drivers' warnings of slow adapters, which come at every rate."""
    logger = logging.getLogger("splinearm.drivers")
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(before)


def _refuse() -> NoReturn:
    raise RuntimeError("this bus asks only: it writes nothing to a servo")
