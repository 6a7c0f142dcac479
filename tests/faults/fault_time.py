"""A time that only the test makes pass, and the port of a virtual bus that lives in it.

All is the product's own, from the loop to the servos, but for the clock and for the file between
client and wire: what a computer does takes no time; what is on the wire, or is waited for, takes
exactly its time. So each run of a test is the same however busy the computer is, and to be patient
costs nothing.
"""

from splinearm.drivers.client import ServoClient
from splinearm.drivers.link import BITS_PER_BYTE, PROMPT, RETURN_DELAY, SerialLink
from splinearm.errors import PortError
from splinearm.sim.server import LineServer
from splinearm.sim.virtual_bus import VirtualBus

MARGIN = 0.008
"""How long an answer may take beyond its time on the wire, s: as ``backends`` opens USB ports."""

FIRST_PORT, OTHER_PORT = "/dev/ttyUSB0", "/dev/ttyUSB1"

TIMED = (
    *(f"drivers.{name}" for name in ("exchange", "health", "link", "recover", "servo_arm")),
    *("drivers.torque", "drivers.watchdog", "control.hearing", "control.rehearsal", "sim.server"),
)
"""Modules that look at the time."""

_SHORT_LATENCY = 1.5e-3


class Clock:
    """Stands for the module ``time`` and for the clock of a loop."""

    def __init__(self) -> None:
        self.t = 1000.0
        self.pause = 0.0
        """For how long the computer does something else when it is to wake next, s."""

    def monotonic(self) -> float:
        return self.t

    perf_counter = now = monotonic

    def until(self, t: float) -> None:
        self.t = max(self.t, t)

    def sleep(self, duration: float) -> None:
        self.t += duration

    def wait_until(self, t: float) -> float:
        """Let it be ``t``, or later if the computer pauses; give by how much."""
        self.until(t)
        self.t, self.pause = self.t + self.pause, 0.0
        return self.t - t


class Plug:
    """Where a client hangs on the wire; it can be pulled out, and come back under another name."""

    def __init__(self, virtual: VirtualBus, clock: Clock, usb_latency: float = 0.0) -> None:
        self.name: str | None = FIRST_PORT
        """What the port is called; None: it is pulled out."""
        self.baud = 0
        self.held = 2.0 * usb_latency if usb_latency > _SHORT_LATENCY else 0.0
        """By how much later answers may come, s, as ``DynamixelBus`` has it."""
        self.clock = clock
        self.server = LineServer(
            virtual._line,
            virtual._obey,
            virtual._idle,
            clock=clock.monotonic,
            usb_latency=usb_latency,
        )
        self.server.port = self
        self._came = bytearray()

    def write(self, data: bytes) -> None:
        """Take what comes from the servos."""
        self._came += data

    def send(self, frame: bytes) -> None:
        """Put a packet on the wire; what came unasked before is thrown away."""
        self._deliver()
        self._came.clear()
        self.server._hear(frame, self.clock.t)

    def receive(self, deadline: float) -> bytes:
        """Let time go on until something comes, or to the deadline; give what came."""
        while not self._came and self.clock.t < deadline:
            self.clock.until(min(self.server._wire.due, deadline))
            self._deliver()
        data = bytes(self._came)
        self._came.clear()
        return data

    def _deliver(self) -> None:
        while self.server._wire.due <= self.clock.t:
            self.server._deliver()
        self.server._mind_gap(self.clock.t)


class SteppedLink(SerialLink):
    """The client's end of the wire."""

    def __init__(self, plug: Plug, port: str, baud: int) -> None:
        if plug.name != port:
            raise PortError(port, "there is no such port", "plug the adapter in")
        self.port, self.baud = port, baud
        self.margin, self.prompt = MARGIN + plug.held, PROMPT + plug.held
        self._plug: Plug | None = plug
        plug.baud = baud

    def close(self) -> None:
        self._plug = None

    def send(self, frame: bytes, answers: int = 0, answer_bytes: int = 0) -> float:
        self._plugged().send(frame)
        wire = (len(frame) + answer_bytes) * BITS_PER_BYTE / self.baud
        return self.deadline() + wire + answers * RETURN_DELAY

    def receive_some(self, deadline: float) -> bytes:
        return self._plugged().receive(deadline)

    def _plugged(self) -> Plug:
        if self._plug is None or self._plug.name != self.port:
            raise self.gone("the device hung up")
        return self._plug


class SteppedBus(ServoClient):
    """As ``DynamixelBus``, on such a port."""

    def __init__(self, plug: Plug, baud: int) -> None:
        self._plug = plug
        super().__init__(SteppedLink(plug, FIRST_PORT, baud))

    def reopen(self, port: str | None = None) -> None:
        self._link.close()
        self._link = SteppedLink(self._plug, port or self.port, self.baud)

    def close(self) -> None:
        self._link.close()
