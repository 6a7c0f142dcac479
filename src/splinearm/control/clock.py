"""What tells the loop the time: the wall, or a simulation that is stepped."""

import time
from collections.abc import Callable
from typing import Protocol


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

    def now(self) -> float:
        """Give the time, s."""
        return time.monotonic()

    def wait_until(self, t: float) -> float:
        """Sleep until ``t``; give by how much the waking was late, s."""
        delay = t - time.monotonic()
        if delay > 0.0:
            time.sleep(delay)
        return max(0.0, time.monotonic() - t)


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
        """Give the arm's time, s."""
        return self._now()

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
