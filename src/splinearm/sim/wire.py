"""Time on the wire: when requests and replies are on it, when they clash, when they are delivered.

The wire is half duplex, 10 bits a byte. A request goes out when it comes, or after the one before
it; a reply starts after its servo's delay. What is on the wire at the same time is garbled.
"""

from bisect import insort
from collections.abc import Sequence
from math import ceil, inf
from typing import NamedTuple

from .line_fault import LineFaults
from .voice import Reply

BITS_PER_BYTE = 10
"""Start bit, eight bits, stop bit."""

BUNDLE = 1e-3
"""Replies to one request that are on the wire within that time are delivered together, s: adapters
hand over more than a byte at a time."""

_ROUNDING = 1e-9
_SLIVER = 1e-6  # of a byte


class Burst(NamedTuple):
    """Bytes from a servo: from when to when they are on the wire, and when they are delivered."""

    due: float
    start: float
    end: float
    data: bytes


def _order(burst: Burst) -> tuple[float, float]:
    return burst.due, burst.start


class Wire:
    """What is on the wire. All times are those of one clock, s."""

    def __init__(self, faults: LineFaults, *, usb_latency: float = 0.0) -> None:
        """Begin with a wire that is free.

        Args:
            faults: Whose dice say what becomes of bytes that clash.
            usb_latency: Replies are held back to the next of such ticks, s; 0: they are not.
        """
        self.byte_time = 0.0
        """Time of a byte, s; 0: bytes take no time."""
        self.sent_until = 0.0
        """When the last byte of the last request is on the wire."""
        self._faults = faults
        self._tick = usb_latency
        self._sent_from = 0.0
        self._bursts: list[Burst] = []

    @property
    def due(self) -> float:
        """When something is to be delivered; infinite: nothing is on its way."""
        return self._bursts[0].due if self._bursts else inf

    def request(self, data: bytes, arrived: float) -> bytes:
        """Put a request on the wire; give what servos hear of it."""
        self._sent_from = max(arrived, self.sent_until)
        self.sent_until = self._sent_from + len(data) * self.byte_time
        if not self._bursts or not self.byte_time:
            return data
        for k, burst in enumerate(self._bursts):
            low, high = max(burst.start, self._sent_from), min(burst.end, self.sent_until)
            if high - low > _ROUNDING:
                data = self._spoil(data, self._sent_from, low, high)
                self._bursts[k] = self._spoilt(burst, low, high)
        return data

    def is_free(self, start: float, end: float) -> bool:
        """Tell whether no reply is on the wire in that time."""
        return all(
            burst.end <= start + _ROUNDING or burst.start >= end - _ROUNDING
            for burst in self._bursts
        )

    def echo(self, data: bytes) -> None:
        """Let the client hear what it sent."""
        t = self.sent_until
        insort(self._bursts, Burst(t, t, t, data), key=_order)

    def reply(self, request_end: float, replies: Sequence[Reply]) -> None:
        """Put the replies to a request on the wire, one after the other."""
        bursts: list[Burst] = []
        t = request_end
        for data, delay in replies:
            start = t + delay if self.byte_time else t
            t = start + len(data) * self.byte_time
            bursts.append(Burst(t, start, t, data))
        for burst in self._bundled(bursts):
            insort(self._bursts, self._clashed(burst), key=_order)

    def take(self, now: float) -> bytes:
        """Give what is to be delivered by now."""
        count = sum(burst.due <= now for burst in self._bursts)
        taken, self._bursts = self._bursts[:count], self._bursts[count:]
        return b"".join(burst.data for burst in taken)

    def _bundled(self, bursts: Sequence[Burst]) -> list[Burst]:
        """Give bursts with the times at which they are delivered."""
        if self._tick:
            return [
                burst._replace(due=ceil(burst.end / self._tick - _ROUNDING) * self._tick)
                for burst in bursts
            ]
        bundled: list[Burst] = []
        due = first = inf
        for burst in reversed(bursts):
            if first == inf or first - burst.start > BUNDLE:
                due = first = burst.end
            bundled.append(burst._replace(due=due))
        bundled.reverse()
        return bundled

    def _clashed(self, burst: Burst) -> Burst:
        """Give a new burst as it is heard beside what else is on the wire."""
        if not self.byte_time:
            return burst
        if burst.start < self.sent_until - _ROUNDING and burst.end > self._sent_from:
            burst = self._spoilt(burst, self._sent_from, self.sent_until)
        for k, other in enumerate(self._bursts):
            low, high = max(burst.start, other.start), min(burst.end, other.end)
            if high - low > _ROUNDING:
                self._bursts[k] = self._spoilt(other, low, high)
                burst = self._spoilt(burst, low, high)
        return burst

    def _spoilt(self, burst: Burst, low: float, high: float) -> Burst:
        return burst._replace(data=self._spoil(burst.data, burst.start, low, high))

    def _spoil(self, data: bytes, start: float, low: float, high: float) -> bytes:
        """Give bytes that begin at a time, those between two times being others."""
        first = max(int((low - start) / self.byte_time + _SLIVER), 0)
        return self._faults.spoil(data, first, ceil((high - start) / self.byte_time - _SLIVER))
