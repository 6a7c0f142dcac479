"""How well servos answer: some hundred pings, counted, and two servos that share an id."""

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from splinearm.drivers.packets import HEADER, Instruction
from splinearm.drivers.registers import Register

from .stethoscope import Heard, Stethoscope

COUNT = 300
"""How many pings make a judgement."""
_LASTS = 2.0
"""For how long they may go on, s."""

PATIENCE = 0.2
"""How much longer to wait for an answer, s: one that a busy computer hears late is not lost."""

_GIVE_UP = 8
_READS, _CLEAN = 12, 2
_LINGER = 4e-3
_CLASHES = 0.75
"""Share of the reads of one id that must be spoilt for it to be two servos."""


@dataclass(slots=True, kw_only=True)
class Pulse:
    """How one servo answered pings."""

    asked: int = 0
    """How often it was asked."""
    silent: int = 0
    """How often nothing came."""
    damaged: int = 0
    """How often what came was no good answer, or had strange bytes around it."""
    echoed: int = 0
    """How often the question came back too."""
    seconds: list[float] = field(default_factory=list)
    """How long each good answer took, s."""

    def count(self, heard: Heard) -> None:
        """Take one answer."""
        self.asked += 1
        self.echoed += heard.is_echoed
        if heard.packets:
            self.seconds.append(heard.seconds)
        if not heard.data:
            self.silent += 1
        elif not heard.is_clean:
            self.damaged += 1


def feel_pulses(
    bus: Stethoscope,
    ids: Sequence[int],
    *,
    count: int = COUNT,
    patience: float = PATIENCE,
) -> dict[int, Pulse]:
    """Ping servos in turn; give by id how they answered.

    Args:
        bus: The bus.
        ids: The servos.
        count: How many pings in all, if there is time.
        patience: How much longer than usually to wait before an answer counts as lost, s.

    Raises:
        PortError: If the port is gone.
    """
    pulses = {servo_id: Pulse() for servo_id in ids}
    until = time.monotonic() + _LASTS
    asked = 0
    while asked < count and time.monotonic() < until:
        round_of = [i for i in ids if pulses[i].silent < _GIVE_UP]
        for servo_id in round_of:
            pulses[servo_id].count(bus.listen(servo_id, patience=patience))
        asked += len(round_of)
        if not round_of:
            break
    return pulses


def is_shared(bus: Stethoscope, servo_id: int, register: Register) -> bool:
    """Tell whether two servos answer to an id.

    Two that speak at once pull the same bits low: header, id and length stay, data and CRC are
    spoilt, by both at rest in the same way each time. Noise spoils other bytes each time. Where one
    of them waits longer, two good answers come that differ.

    Args:
        bus: The bus.
        servo_id: The id.
        register: Where two servos differ: their position.

    Raises:
        PortError: If the port is gone.
    """
    if bus.protocol_of(servo_id) == 1:
        params, start = bytes((register.address, register.size)), bytes((0xFF, 0xFF, servo_id))
    else:
        params = register.address.to_bytes(2, "little") + register.size.to_bytes(2, "little")
        start = HEADER + bytes((servo_id,))
    frames: Counter[bytes] = Counter()
    clean = 0
    for _ in range(_READS):
        heard = bus.listen(servo_id, Instruction.READ, params, answer=register.size, linger=_LINGER)
        if len({packet.params for packet in heard.packets}) > 1:
            return True
        clean += heard.is_clean
        if clean == _CLEAN:
            return False
        if heard.data.startswith(start) and not heard.packets:
            frames[heard.data] += 1
    spoilt = sum(frames.values())
    same = max(frames.values(), default=0)
    return spoilt >= _CLASHES * _READS and same >= spoilt / 3
