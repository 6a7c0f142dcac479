"""What happened to a servo, so that a test can say what must not have happened."""

from collections import deque
from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple

_MOST = 10_000


class EventKind(Enum):
    """What can happen."""

    TORQUE_ON = "torque on"
    TORQUE_OFF = "torque off"
    HARDWARE_ERROR = "hardware error"
    WATCHDOG_TRIP = "watchdog trip"
    GOAL_JUMP = "goal jump"
    REBOOT = "reboot"
    MECHANICAL = "mechanical fault"


class Event(NamedTuple):
    """One thing that happened."""

    time: float
    """When, in the rig's time, s."""
    kind: EventKind
    """What."""
    cause: str
    """Why, in words: of a torque off "asked", "reboot", or the names of hardware errors."""


class EventLog:
    """The newest 10 000 events of a servo, oldest first."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=_MOST)

    def __iter__(self) -> Iterator[Event]:
        return iter(tuple(self._events))

    def __len__(self) -> int:
        return len(self._events)

    def add(self, time: float, kind: EventKind, cause: str) -> None:
        """Take note of something."""
        self._events.append(Event(time, kind, cause))

    def of(self, kind: EventKind) -> list[Event]:
        """Give what happened of one kind."""
        return [event for event in self if event.kind is kind]

    def torque_lost(self) -> list[Event]:
        """Give each time that the torque went off without having been asked for."""
        return [event for event in self.of(EventKind.TORQUE_OFF) if event.cause != ASKED]

    def clear(self) -> None:
        """Forget all."""
        self._events.clear()


ASKED = "asked"
"""Cause of a torque off for which a client has asked."""
