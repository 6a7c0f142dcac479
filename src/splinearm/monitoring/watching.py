"""Samples taken in a thread of their own: what is done with them does not delay the next."""

import sys
import threading
from collections import deque
from contextlib import suppress
from types import TracebackType
from typing import Self

from .monitor import Monitor
from .sample import Sample

_KEPT = 10_000
"""Samples that wait at most for who is slow to take them."""
_SWITCH = 5e-4
"""How long another thread may keep Python's lock when a sample is due, s."""


class Watching:
    """Takes samples while its with-block lasts.

    Args:
        monitor: What is watched.
        rate: Samples a second, Hz.
    """

    def __init__(self, monitor: Monitor, rate: float) -> None:
        self._monitor = monitor
        self._rate = rate
        self._waiting: deque[Sample] = deque()
        self._ends = False
        self._error: BaseException | None = None
        self._before = 0.0
        self._thread = threading.Thread(target=self._run, name="monitor", daemon=True)
        self.dropped = 0
        """Samples that nobody took in time."""

    def __enter__(self) -> Self:
        self._before = sys.getswitchinterval()
        sys.setswitchinterval(_SWITCH)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ends = True
        self._thread.join()
        sys.setswitchinterval(self._before)

    def take(self) -> list[Sample]:
        """Give the samples that have come since, oldest first.

        Raises:
            Exception: Whatever ended the watching.
        """
        taken: list[Sample] = []
        with suppress(IndexError):  # the thread may drop the oldest meanwhile
            while True:
                taken.append(self._waiting.popleft())
        if self._error is not None and not taken:
            raise self._error
        return taken

    def _run(self) -> None:
        try:
            for sample in self._monitor.samples(self._rate):
                if len(self._waiting) >= _KEPT:
                    self._waiting.popleft()
                    self.dropped += 1
                self._waiting.append(sample)
                if self._ends:
                    return
        except Exception as error:  # noqa: BLE001 - who takes the samples is told
            self._error = error
