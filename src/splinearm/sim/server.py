"""The thread that serves a line: hears what comes, lets servos obey, delivers in time.

Servos obey as soon as a request has come, while its bytes are still on the wire, so that the answer
is ready when the wire has had its time.
"""

import threading
import time
from collections import deque
from collections.abc import Callable
from math import inf
from typing import Protocol

from .ear import Ear, Heard
from .keen import Spin, go_first, sleep_sharply
from .line import Line
from .line_fault import FaultKind
from .no_port import NoPort
from .voice import Reply
from .wire import BITS_PER_BYTE, Wire

_KEPT = 4096


class Port(Protocol):
    """What a client speaks to, from the servos' end."""

    @property
    def name(self) -> str:
        """What a client opens."""
        ...

    @property
    def baud(self) -> int:
        """The rate at which the client speaks."""
        ...

    def read(self, timeout: float) -> bytes:
        """Give what has come, waiting for it for at most ``timeout`` seconds; empty: nothing."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes; those for which there is no room are lost."""
        ...

    def wake(self) -> None:
        """Let a waiting ``read`` return; may be called from any thread."""
        ...

    def close(self) -> None:
        """Close it."""
        ...


class LineServer:
    """Serves one line on one port, from ``start`` to ``stop``."""

    def __init__(
        self,
        line: Line,
        obey: Callable[[Heard, int], list[Reply]],
        idle: Callable[[], float],
        *,
        clock: Callable[[], float] = time.monotonic,
        wire_time: bool = True,
        usb_latency: float = 0.0,
    ) -> None:
        """Prepare.

        Args:
            line: The line; its faults are those of the wire too.
            obey: Lets the servos obey what was heard at a baud rate, and gives what they reply.
            idle: Called when nothing comes; says after which time to call it again, s.
            clock: Gives the time, s, as it goes by for the client.
            wire_time: Whether bytes take time.
            usb_latency: Replies are held back to the next of such ticks, s; 0: they are not.
        """
        self._line = line
        self._obey = obey
        self._idle = idle
        self._clock = clock
        self._wire_time = wire_time
        self._usb_latency = usb_latency
        self._wire = Wire(line.faults, usb_latency=usb_latency)
        self._ear = Ear()
        self._spin = Spin(clock)
        self._closing = False
        self._thread: threading.Thread | None = None
        self.port: Port = NoPort()
        """What it serves."""
        self.lateness: deque[float] = deque(maxlen=_KEPT)
        """How late the last deliveries were, s."""
        self.refused: tuple[str, ...] = ()
        """What the system refused of what a real-time thread wants."""

    def start(self, port: Port, *, realtime: bool = False) -> None:
        """Begin to serve a port; the thread is at work when this returns."""
        ready = threading.Event()
        self.port = port
        self._closing = False
        self._wire = Wire(self._line.faults, usb_latency=self._usb_latency)
        self._thread = threading.Thread(
            target=self._serve, args=(realtime, ready), name="virtual bus", daemon=True
        )
        self._thread.start()
        ready.wait()

    def stop(self) -> None:
        """Stop serving and close the port."""
        if self._thread is not None:
            self._closing = True
            self.port.wake()
            self._thread.join()
            self._thread = None
            self.port.close()

    def _serve(self, realtime: bool, ready: threading.Event) -> None:  # noqa: FBT001 - a target
        sleep_sharply()
        self.refused = go_first() if realtime else ()
        ready.set()
        port, wire, clock = self.port, self._wire, self._clock
        patience = 0.0
        while not self._closing:
            now = clock()
            wait = min(self._until_delivery(now), self._until_gap(now), patience)
            data = port.read(wait) if wait > 0.0 else b""
            if data:
                self._hear(data, clock())
            elif 0.0 < wait < patience:
                self._spin.learn(clock() - now - wait)
            if wire.due < inf:
                self._deliver()
            if not data:
                self._mind_gap(clock())
            if not data or wire.due == inf:
                patience = self._idle()

    def _until_delivery(self, now: float) -> float:
        """Give for how long to sleep before the next delivery."""
        due = self._wire.due
        return max(due - now - self._spin.margin, 0.0) if due < inf else inf

    def _until_gap(self, now: float) -> float:
        """Give for how long to wait for the rest of a packet."""
        patience = self._ear.patience
        if patience is None:
            return inf
        return max(self._wire.sent_until + patience - now, 1e-5)

    def _mind_gap(self, now: float) -> None:
        """Give up packets whose rest has not come."""
        patience = self._ear.patience
        silence = now - self._wire.sent_until
        if patience is not None and silence >= patience:
            for heard in self._ear.pause(silence):
                self._answer(heard)

    def _hear(self, data: bytes, arrived: float) -> None:
        """Take bytes from the client."""
        wire, faults = self._wire, self._line.faults
        pause = faults.strikes(FaultKind.PAUSE)
        if pause:
            time.sleep(pause.seconds)
        baud = self.port.baud
        wire.byte_time = BITS_PER_BYTE / baud if self._wire_time and baud else 0.0
        data = wire.request(data, arrived)
        if faults.strikes(FaultKind.ECHO):
            wire.echo(data)
        for heard in self._ear.feed(data):
            self._answer(heard)

    def _answer(self, heard: Heard) -> None:
        """Let servos obey what was heard, unless a reply was on the wire at the same time."""
        wire = self._wire
        end = wire.sent_until - heard.after * wire.byte_time
        if wire.is_free(end - heard.length * wire.byte_time, end):
            wire.reply(end, self._obey(heard, self.port.baud))

    def _deliver(self) -> None:
        """Deliver what is due now or in a moment."""
        wire, now = self._wire, self._clock()
        due = wire.due
        if due - now > self._spin.margin:
            return
        late = self._spin.until(due)
        self.port.write(wire.take(due + late))
        if wire.byte_time:
            self.lateness.append(late)
