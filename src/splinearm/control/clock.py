"""What tells the loop the time: the wall, or a simulation that is stepped."""

import time
from collections.abc import Callable
from typing import Protocol

_AWAKE = 0.2
_NAP = 5e-5
"""Whoever was awake for the first of these times, s, sleeps for the second: the kernel pauses a
thread under SCHED_FIFO that never sleeps for 50 ms of every second."""


class Clock(Protocol):
    """Time as the arm lives it."""

    def now(self) -> float:
        """Give the time, s."""
        ...

    def wait_until(self, t: float) -> float:
        """Return once the time is ``t`` or later; give by how much it is later, s."""
        ...


class WallClock:
    """The computer's monotonic clock: for arms that move by themselves."""

    def __init__(self, spin: float = 0.0) -> None:
        """Set it.

        Args:
            spin: How long before it is due a waiting thread wakes and looks at the clock without
                pause, s: worth it under SCHED_FIFO, where a sleep may end some 50 us late.
        """
        self.spin = spin
        """As above; may be changed at any time."""
        self._slept = 0.0

    def now(self) -> float:
        """Give the time, s."""
        return time.monotonic()

    def wait_until(self, t: float) -> float:
        """Sleep until ``t``; give by how much the waking was late, s."""
        now = time.monotonic()
        delay = t - now - self.spin
        if delay > 0.0:
            time.sleep(delay)
            self._slept = t
        elif now - self._slept > _AWAKE:
            time.sleep(_NAP)
            self._slept = now
        while (now := time.monotonic()) < t:
            if self.spin == 0.0:
                time.sleep(t - now)
        return now - t


class StepClock:
    """The clock of an arm that moves only when it is stepped.

    It is as quick as the computer, or keeps pace with the wall so that a person can watch.
    """

    def __init__(
        self,
        advance: Callable[[float], None],
        now: Callable[[], float],
        *,
        realtime: bool = False,
    ) -> None:
        """Take the arm's own stepping.

        Args:
            advance: Lets the arm live on for a number of seconds.
            now: Gives the arm's time, s.
            realtime: Whether to wait for the wall clock at every step.
        """
        self._advance = advance
        self._now = now
        self._wall_start = time.monotonic() - now() if realtime else None

    def now(self) -> float:
        """Give the arm's time, s; from here on it keeps pace with the wall, if it shall."""
        now = self._now()
        if self._wall_start is not None:
            self._wall_start = time.monotonic() - now
        return now

    def wait_until(self, t: float) -> float:
        """Step the arm until ``t``; give by how much the wall clock is later, s."""
        remaining = t - self._now()
        if remaining > 0.0:
            self._advance(remaining)
        if self._wall_start is None:
            return 0.0
        delay = self._wall_start + t - time.monotonic()
        if delay > 0.0:
            time.sleep(delay)
        return max(0.0, -delay)
