"""The servos' own watchdog: it stops them when the bus falls silent, whatever became of us.

A servo counts the time since any instruction packet on the bus, while its torque is on. When that
exceeds Bus Watchdog (in units of 20 ms) it stops, holds, and takes no goals until 0 is written
there.
Source: ROBOTIS e-Manual, "Bus Watchdog".
"""

import logging
import time
from collections.abc import Sequence
from math import ceil

from splinearm.errors import ServoError

from .ability import WATCHDOG, having
from .bus import Loss, ServoBus
from .chain import ServoSpec
from .cyclic import GroupRead, GroupWrite
from .groups import BulkRead
from .link import BITS_PER_BYTE
from .scaling import ONE_TURN_MODE, operating_mode

_log = logging.getLogger(__name__)

_UNIT = 0.020
_LONGEST = 127
_TRIPPED = 0xFF
_TRIES = 3
_WAITS = 3.0
"""How many lost answers may be waited for, one after the other, before the watchdog trips."""
_CYCLE_BYTES, _SERVO_BYTES = 36, 20
"""What is on the wire in a cycle: a read of all, its answer and the goals."""


class Watchdog:
    """The watchdogs of an arm's servos, armed and disarmed together.

    Args:
        bus: The bus.
        servos: The servos; those without a watchdog of their own are left alone.
        timeout: Silence after which they stop, s, rounded up to 20 ms; None: they never do. Where
            the bus waits for long until an answer counts as lost it is longer, three such waits:
            one dead servo would stop all others otherwise. So it is where a cycle takes the wire
            long.

    Raises:
        ValueError: If the servos cannot count that time.
    """

    def __init__(self, bus: ServoBus, servos: Sequence[ServoSpec], timeout: float | None) -> None:
        units = 0 if timeout is None else ceil(timeout / _UNIT - 1e-9)
        cycle = (_CYCLE_BYTES + _SERVO_BYTES * len(servos)) * BITS_PER_BYTE / bus.baud
        needed = ceil(_WAITS * max(bus.margin, cycle) / _UNIT - 1e-9)
        if timeout is not None and not 1 <= units <= _LONGEST:
            raise ValueError(
                f"watchdog: want above 0 and at most {_LONGEST * _UNIT:g} s or None, got {timeout}"
            )
        self._bus = bus
        able = having(servos, WATCHDOG)
        units = units if able else 0
        if 0 < units < needed:
            units = min(needed, _LONGEST)
            _log.info("this bus is slow: the watchdog waits %.2g s", units * _UNIT)
        self._units = units
        self._names = {servo.servo_id: servo.name for servo in able}
        places = [(s.servo_id, s.servo_model.table[WATCHDOG]) for s in able]
        self._writer = GroupWrite(places) if able else None
        requests = [BulkRead(i, r.address, r.size) for i, r in places]
        self._reader = GroupRead(requests, fast=False) if able else None
        self._fed = 0.0
        self._missed = False
        self.armed = False
        """Whether it counts."""
        self.trips = 0
        """How many servos it has stopped and were set going again."""

    def feed(self, t: float | None = None) -> None:
        """Note that something was sent at ``t``, s on the monotonic clock; None: just now.

        What counts is when it was sent: while an answer is awaited that does not come, the bus is
        silent.
        """
        t = time.monotonic() if t is None else t
        self._missed |= self._is_late(t)
        self._fed = t

    @property
    def lapsed(self) -> bool:
        """Whether the bus was silent for so long that servos may have stopped."""
        return self._missed or self._is_late(time.monotonic())

    def _is_late(self, t: float) -> bool:
        return self.armed and t - self._fed > self._units * _UNIT * 0.9

    def arm(self) -> None:
        """Let it count, unless it never shall."""
        if self._units:
            self._set(self._units)
            self._missed = False
            self.armed = True

    def disarm(self) -> None:
        """Stop it counting; servos that it stopped take goals again."""
        self.armed = self._missed = False
        self._set(0)

    def stopped(self) -> frozenset[int]:
        """Ask which servos it has stopped; give their ids.

        Such a servo reads 255 there; it stands where it was stopped, whatever its goal says.
        """
        if self._reader is None:
            return frozenset()
        replies = self._bus.sync_read(self._reader)
        return frozenset(
            servo_id
            for servo_id, reply in replies.items()
            if reply.loss is None and reply.data[0] == _TRIPPED
        )

    def require_going(self, since: float) -> None:
        """Refuse servos that it has stopped, each by itself, because they heard nothing.

        Args:
            since: Since when some were not heard, s on the monotonic clock.

        Raises:
            ServoError: If it was long enough, and a servo says that it has stopped.
        """
        if not self._units or time.monotonic() - since < 0.5 * self._units * _UNIT:
            return
        for servo_id in sorted(self.stopped()):
            raise ServoError(
                servo_id,
                "it heard nothing for so long that its watchdog has stopped it; check its cable, "
                "then hold, which lets it go on from where it stands",
                alert=True,
                name=self._names[servo_id],
            )

    def revive(self) -> frozenset[int]:
        """Disarm it, after a silence or in the end; tell and give the servos it had stopped."""
        stopped = self.stopped() if self._units else frozenset[int]()
        self.trips += len(stopped)
        if stopped:
            names = [self._names[servo_id] for servo_id in self._names if servo_id in stopped]
            _log.warning("the bus was silent; the watchdog had stopped %s", ", ".join(names))
        self.disarm()
        return stopped

    def _set(self, units: int) -> None:
        """Write to all and see that those who answer have taken it."""
        if self._writer is None or self._reader is None:
            return
        stubborn: list[str] = []
        for _ in range(_TRIES):
            self._bus.sync_write(self._writer, [units] * len(self._names))
            replies = self._bus.sync_read(self._reader)
            self.feed()
            stubborn = [
                self._names[servo_id]
                for servo_id, reply in replies.items()
                if reply.loss is Loss.DAMAGED or (reply.loss is None and reply.data[0] != units)
            ]
            if not stubborn:
                return
        _log.warning("Bus Watchdog = %d was not taken by %s", units, ", ".join(stubborn))


def warn_of_offsets(servos: Sequence[ServoSpec]) -> None:
    """Warn of servos that may move when their watchdog stops them.

    An XM540 in position mode was seen to take its position without its Homing Offset for its goal,
    and so to move by the offset first (DynamixelHandler-ros2, developer notes).
    """
    for servo in servos:
        offset = servo.settings.get("Homing Offset", 0)
        if offset and operating_mode(servo) == ONE_TURN_MODE:
            _log.warning(
                "servo %d (%s): with a Homing Offset of %d in position mode it may move by that "
                "when the bus falls silent; set the offset to 0 and zero_ticks %d lower, or use "
                "operating mode 4",
                servo.servo_id,
                servo.name,
                offset,
                offset,
            )


def let_go(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Write 0 to the watchdog of servos, so that they take goals.

    Raises:
        BusError: If a servo does not answer or refuses.
    """
    for servo in having(servos, WATCHDOG):
        bus.write(servo.servo_id, servo.servo_model.table[WATCHDOG], 0)
