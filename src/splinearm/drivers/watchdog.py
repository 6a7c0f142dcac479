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

_log = logging.getLogger(__name__)

_UNIT = 0.020
_LONGEST = 127
_TRIPPED = 0xFF
_TRIES = 3


class Watchdog:
    """The watchdogs of an arm's servos, armed and disarmed together.

    Args:
        bus: The bus.
        servos: The servos.
        timeout: Silence after which they stop, s, rounded up to 20 ms; None: they never do.

    Raises:
        ValueError: If the servos cannot count that time.
    """

    def __init__(self, bus: ServoBus, servos: Sequence[ServoSpec], timeout: float | None) -> None:
        units = 0 if timeout is None else ceil(timeout / _UNIT - 1e-9)
        if timeout is not None and not 1 <= units <= _LONGEST:
            raise ValueError(
                f"watchdog: want above 0 and at most {_LONGEST * _UNIT:g} s or None, got {timeout}"
            )
        self._bus = bus
        self._units = units
        self._names = {servo.servo_id: servo.name for servo in servos}
        places = [(s.servo_id, s.servo_model.table["Bus Watchdog"]) for s in servos]
        self._writer = GroupWrite(places)
        self._reader = GroupRead([BulkRead(i, r.address, r.size) for i, r in places], fast=False)
        self._fed = 0.0
        self.armed = False
        """Whether it counts."""
        self.trips = 0
        """How many servos it has stopped and were set going again."""

    def feed(self) -> None:
        """Note that something was sent just now."""
        self._fed = time.monotonic()

    @property
    def lapsed(self) -> bool:
        """Whether the bus was silent for so long that servos may have stopped."""
        return self.armed and time.monotonic() - self._fed > self._units * _UNIT * 0.9

    def arm(self) -> None:
        """Let it count, unless it never shall."""
        if self._units:
            self._set(self._units)
            self.armed = True

    def disarm(self) -> None:
        """Stop it counting; servos that it stopped take goals again."""
        self._set(0)
        self.armed = False

    def revive(self) -> None:
        """Disarm it after a silence, and tell which servos it had stopped."""
        stopped = [
            self._names[servo_id]
            for servo_id, reply in self._bus.sync_read(self._reader).items()
            if reply.loss is None and reply.data[0] == _TRIPPED
        ]
        self.trips += len(stopped)
        if stopped:
            _log.warning("the bus was silent; the watchdog had stopped %s", ", ".join(stopped))
        self.disarm()

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
