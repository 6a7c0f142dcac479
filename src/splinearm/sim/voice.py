"""How servos' answers get on the wire: when, whole or not, and what becomes of several at once."""

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

from .habit import LineHabits, turn_around
from .line_fault import FaultKind, LineFaults
from .virtual_servo import VirtualServo

PING_ONLY, PING_AND_READ, ALL = 0, 1, 2
"""Values of Status Return Level."""

_DELAY_UNIT = 2e-6


class Reply(NamedTuple):
    """Bytes that come back, and how long the servo waits before it sends them, s."""

    data: bytes
    delay: float


class Voice:
    """What servos need to answer one packet."""

    def __init__(
        self, faults: LineFaults, habits: LineHabits, instruction: int, written: int = 0
    ) -> None:
        """Take faults and habits of the line, what is asked, and how many bytes are written."""
        self.habits = habits
        self.faults = faults
        self._instruction = instruction
        self._written = written

    def send(self, servo: VirtualServo, frame: bytes, *, at_once: bool = False) -> Reply | None:
        """Give what comes of a servo's answer; None: nothing.

        Args:
            servo: Who sends it.
            frame: What it sends.
            at_once: Whether it joins what another sends, without a pause of its own.
        """
        if servo.mute or self.faults.strikes(FaultKind.LOST, servo.servo_id):
            return None
        if servo.corrupt_replies > 0:
            servo.corrupt_replies -= 1
            frame = frame[:-2] + bytes((frame[-2] ^ 0x01,)) + frame[-1:]
        delay = 0.0 if at_once else self._delay(servo)
        data, late = self.faults.on_the_way(frame, servo.servo_id)
        return Reply(data, delay + late)

    def _delay(self, servo: VirtualServo) -> float:
        needed = turn_around(self.habits, servo.model.name, self._instruction, self._written)
        return max(servo.memory.get("Return Delay Time") * _DELAY_UNIT, needed)


def together(replies: Sequence[Reply | None]) -> list[Reply]:
    """Give what is on the line when servos answer at the same time: bits are and-ed."""
    sent = [reply for reply in replies if reply is not None]
    if len(sent) < 2:
        return sent
    merged = reduce(_low_together, (reply.data for reply in sent))
    return [Reply(merged, min(reply.delay for reply in sent))]


def by_id(servos: Sequence[VirtualServo]) -> dict[int, list[VirtualServo]]:
    """Give the servos of each id: mostly one."""
    found: dict[int, list[VirtualServo]] = {}
    for servo in servos:
        found.setdefault(servo.servo_id, []).append(servo)
    return found


def readers(servos: Sequence[VirtualServo]) -> dict[int, list[VirtualServo]]:
    """Give the servos of each id that answer reads."""
    return by_id([s for s in servos if s.memory.get("Status Return Level", ALL) >= PING_AND_READ])


def _low_together(a: bytes, b: bytes) -> bytes:
    short, long = sorted((a, b), key=len)
    return bytes(x & y for x, y in zip(short, long, strict=False)) + long[len(short) :]
