"""The line on which servos hang: which of them hear a packet, and what comes back.

Where the manual is silent: in a sync or bulk read the others answer even if one is missing; the
answer to a fast read ends before the first that is missing, for the CRCs are chained. Servos that
answer at the same time pull the line low together: their bits are and-ed. ``LineHabits`` switches
what can be switched.
"""

import time
from collections.abc import Iterable, Sequence

from splinearm.drivers.packets import BROADCAST_ID, Instruction, Packet

from . import line_v1, line_v2
from .habit import LineHabits
from .line_fault import FaultKind, LineFaults
from .virtual_servo import VirtualServo
from .voice import Reply as Reply
from .voice import Voice

_NOISE = range(1, 9)
_FAST = (Instruction.FAST_SYNC_READ, Instruction.FAST_BULK_READ)


class Line:
    """Servos on one pair of wires, each with the protocol that it speaks."""

    def __init__(self, servos: Iterable[VirtualServo], habits: LineHabits | None = None) -> None:
        """Take the servos, and what they do where the manual is silent."""
        self.servos = tuple(servos)
        self.habits = LineHabits() if habits is None else habits
        """What they do where the manual is silent."""
        self.faults = LineFaults(clock=time.monotonic)
        """What goes wrong; replaced as a whole."""
        self.silent = False
        """Whether the wire is cut between the computer and all servos."""
        self._stuck: dict[VirtualServo, float] = {}

    def answer(
        self, packet: Packet, baud: int, protocol: int = 2, *, damaged: bool = False
    ) -> list[Reply]:
        """Let the servos that understand a packet obey it; give what comes back.

        Args:
            packet: The packet.
            baud: The rate at which it came.
            protocol: In which protocol, 1 or 2.
            damaged: Whether it came damaged, of which only the id is known.
        """
        if self.silent or packet.is_status:
            return []
        servos = [servo for servo in self.servos if self._hears(servo, baud, protocol)]
        written = (line_v1 if protocol == 1 else line_v2).written(packet)
        voice = Voice(self.faults, self.habits, packet.instruction, written)
        if damaged:
            return _complain(servos, packet, voice, protocol)
        for servo in servos:
            servo.heard()
        answer = line_v1.answer if protocol == 1 else line_v2.answer
        replies = answer(servos, packet, voice)
        if not replies and self.habits.stuck_time and packet.instruction in _FAST:
            self._let_stick(servos, packet)
        return replies or self._noise(packet, baud)

    def _hears(self, servo: VirtualServo, baud: int, protocol: int) -> bool:
        return (
            servo.listens(baud)
            and servo.protocol == protocol
            and not self.faults.strikes(FaultKind.DEAD, servo.servo_id)
            and servo.now >= self._stuck.get(servo, 0.0)
        )

    def _let_stick(self, servos: Iterable[VirtualServo], packet: Packet) -> None:
        """Let those that were asked and waited for a first servo that is missing hear nothing."""
        asked = line_v2.asked_ids(packet)
        for servo in servos:
            if servo.servo_id in asked:
                self._stuck[servo] = servo.now + self.habits.stuck_time

    def _noise(self, packet: Packet, baud: int) -> list[Reply]:
        """Give the noise of the servos that were meant and have another baud rate."""
        if not self.habits.noise_at_wrong_baud:
            return []
        dice = self.faults.dice
        meant = [s for s in self.servos if packet.servo_id in (s.servo_id, BROADCAST_ID)]
        return [
            Reply(dice.randbytes(dice.choice(_NOISE)), 0.0)
            for servo in meant
            if servo.baud != baud and not servo.unplugged
        ]


def _complain(
    servos: Sequence[VirtualServo], packet: Packet, voice: Voice, protocol: int
) -> list[Reply]:
    """Give what servos say to a packet that came damaged."""
    if not voice.habits.answers_bad_crc:
        return []
    complain = line_v1.complain if protocol == 1 else line_v2.complain
    return complain(servos, packet, voice)


def speak_protocol_1(servo: VirtualServo) -> None:
    """Let a servo speak Protocol 1.0 from here on.

    Raises:
        ValueError: If its model cannot.
    """
    if 1 not in servo.model.protocols:
        raise ValueError(f"protocol: {servo.model.name} does not speak 1.0")
    if 2 in servo.model.protocols:
        servo.memory["Protocol Type"] = 1
