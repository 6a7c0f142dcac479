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

from .bus import Loss, ServoBus
from .chain import ServoSpec
from .cyclic import GroupRead, GroupWrite
from .groups import BulkRead
from .scaling import ONE_TURN_MODE, operating_mode

_log = logging.getLogger(__name__)

_UNIT = 0.020
_LONGEST = 127
_TRIPPED = 0xFF
_TRIES = 3
_WAITS = 3.0
"""How many lost answers may be waited for, one after the other, before the watchdog trips."""


class Watchdog:
    """The watchdogs of an arm's servos, armed and disarmed together.

    Args:
        bus: The bus.
        servos: The servos.
        timeout: Silence after which they stop, s, rounded up to 20 ms; None: they never do. Where
            the bus waits for long until an answer counts as lost it is longer, three such waits:
            one dead servo would stop all others otherwise.

    Raises:
        ValueError: If the servos cannot count that time.
    """

    def __init__(self, bus: ServoBus, servos: Sequence[ServoSpec], timeout: float | None) -> None:
        units = 0 if timeout is None else ceil(timeout / _UNIT - 1e-9)
        needed = ceil(_WAITS * bus.margin / _UNIT - 1e-9)
        if timeout is not None and not 1 <= units <= _LONGEST:
            raise ValueError(
                f"watchdog: want above 0 and at most {_LONGEST * _UNIT:g} s or None, got {timeout}"
            )
        self._bus = bus
        if 0 < units < needed:
            units = min(needed, _LONGEST)
            _log.info("lost answers take long here: the watchdog waits %.2g s", units * _UNIT)
        self._units = units
        self._names = {servo.servo_id: servo.name for servo in servos}
        places = [(s.servo_id, s.servo_model.table["Bus Watchdog"]) for s in servos]
        self._writer = GroupWrite(places)
        self._reader = GroupRead([BulkRead(i, r.address, r.size) for i, r in places], fast=False)
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
        replies = self._bus.sync_read(self._reader)
        return frozenset(
            servo_id
            for servo_id, reply in replies.items()
            if reply.loss is None and reply.data[0] == _TRIPPED
        )

    def revive(self) -> frozenset[int]:
        """Disarm it after a silence; tell and give the servos it had stopped."""
        stopped = self.stopped()
        self.trips += len(stopped)
        if stopped:
            names = [self._names[servo_id] for servo_id in self._names if servo_id in stopped]
            _log.warning("the bus was silent; the watchdog had stopped %s", ", ".join(names))
        self.disarm()
        return stopped

    def _set(self, units: int) -> None:
        """Write to all and see that those who answer have taken it."""
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
    for servo in servos:
        bus.write(servo.servo_id, servo.servo_model.table["Bus Watchdog"], 0)
