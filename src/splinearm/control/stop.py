"""Ctrl-C, SIGTERM and a lost terminal as a wish to stop, which becomes a stop along the path."""

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Self

_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
_Handler = Callable[[int, FrameType | None], object] | int | None


class StopRequest:
    """While its with-block lasts, SIGINT, SIGTERM and SIGHUP set a flag and do nothing else.

    Its with-blocks may be nested: a loop enters the one it was given.
    """

    def __init__(self) -> None:
        self._asked = threading.Event()
        self._before: dict[signal.Signals, _Handler] = {}
        self._depth = 0

    @property
    def requested(self) -> bool:
        """Whether a stop was asked for."""
        return self._asked.is_set()

    def request(self) -> None:
        """Ask for a stop, from any thread."""
        self._asked.set()

    def __enter__(self) -> Self:
        self._depth += 1
        # only the main thread may have signal handlers; elsewhere `request` is the way
        if self._depth == 1 and threading.current_thread() is threading.main_thread():
            for number in _SIGNALS:
                self._before[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._depth -= 1
        if self._depth > 0:
            return
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._asked.set()
