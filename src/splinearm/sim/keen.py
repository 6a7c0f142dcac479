"""A thread that is on time: its sleeps end sharply, and it goes before others where permitted."""

import ctypes
import os
import sys
import time
from collections.abc import Callable

PRIORITY = 60
"""SCHED_FIFO priority of a thread that stands for hardware: hardware waits for nobody."""

_PR_SET_TIMERSLACK = 29
_TIMER_SLACK_NS = 1
_MCL_CURRENT, _MCL_FUTURE = 1, 2

_LEAST, _MOST = 15e-6, 150e-6
_UP, _DOWN = 10e-6, 0.5e-6


def sleep_sharply() -> None:
    """Let this thread's sleeps end on time; unless told so Linux lets them end 50 us late."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, _TIMER_SLACK_NS, 0, 0, 0)


def go_first() -> tuple[str, ...]:
    """Let this thread go before all that are not real-time, its memory locked.

    Returns:
        What the system refused, in words; empty if it refused nothing.
    """
    refused: list[str] = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, OSError) as error:
        refused.append(f"SCHED_FIFO: {error}")
    lock = getattr(ctypes.CDLL(None, use_errno=True), "mlockall", None)
    if lock is None or lock(_MCL_CURRENT | _MCL_FUTURE) != 0:
        refused.append(f"mlockall: {os.strerror(ctypes.get_errno())}")
    return tuple(refused)


class Spin:
    """Waits for an instant: sleep to a little before it, then look at the clock until it is there.

    It learns how late sleeps end, and stops sleeping by so much earlier.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self.margin = 50e-6
        """How long before an instant sleep must end, s."""

    def learn(self, late: float) -> None:
        """Take note of a sleep that ended so late, s: the margin suits 19 of 20 sleeps."""
        step = _UP if late > self.margin else -_DOWN
        self.margin = min(max(self.margin + step, _LEAST), _MOST)

    def until(self, instant: float) -> float:
        """Look at the clock until an instant; give how late it is then, s."""
        clock = self._clock
        now = clock()
        while now < instant:
            now = clock()
        return now - instant
