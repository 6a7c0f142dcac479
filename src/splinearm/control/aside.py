"""What must not hold up the loop, done beside it: printing, and what programs want to look at."""

import logging
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Self, TypeVar

_log = logging.getLogger(__name__)
_T = TypeVar("_T")

_PAUSE = 0.05


class Aside:
    """A thread that calls, in their order, what the loop leaves for it.

    It looks every 50 ms. Of calls that raise, the first is kept in ``trouble``, and the others of
    the same function are left out.
    """

    def __init__(self) -> None:
        self._waiting: deque[Callable[[], object]] = deque()
        self._ends = False
        self._failed: set[int] = set()
        self._thread = threading.Thread(target=self._run, name="aside", daemon=True)
        self.trouble: Exception | None = None
        """The first error of what was called."""

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Wait until everything was called."""
        self._ends = True
        self._thread.join()

    def hurry(self) -> None:
        """Go before programs of normal priority, if the system permits it.

        A thread that is kept from its turn while it holds Python's lock keeps the loop waiting: at
        normal priority a progress bar makes it 7 ms late beside busy programs, so 0.2 ms.
        """
        if sys.platform != "linux" or self._thread.native_id is None:
            return
        with suppress(OSError):
            os.sched_setscheduler(self._thread.native_id, os.SCHED_FIFO, os.sched_param(1))

    def later(self, call: Callable[[_T], object]) -> Callable[[_T], None]:
        """Give a function that leaves a call of this one for the thread and returns at once."""

        def leave(value: _T) -> None:
            self._waiting.append(lambda: self._call(call, value))

        return leave

    def _call(self, call: Callable[[_T], object], value: _T) -> None:
        if id(call) in self._failed:
            return
        try:
            call(value)
        except Exception as error:  # noqa: BLE001 - whatever it is, the arm goes on
            self._failed.add(id(call))
            self.trouble = self.trouble or error
            _log.warning("an observer of the loop failed and is left out from here on: %r", error)

    def _run(self) -> None:
        while True:
            ends = self._ends
            while self._waiting:
                self._waiting.popleft()()
            if ends:
                return
            time.sleep(_PAUSE)
