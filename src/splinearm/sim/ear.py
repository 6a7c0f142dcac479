"""What is heard on a line: packets of both protocols in one stream of bytes.

Servos of either protocol hear every byte. A packet of Protocol 2.0 cannot be one of 1.0, for its
fourth byte would be a length of 0; what it carries could look like one, and is passed over.
"""

import re
from typing import NamedTuple

from splinearm.drivers.crc import crc16
from splinearm.drivers.packets import BROADCAST_ID, HEADER, MAX_LENGTH, Packet, unstuff
from splinearm.drivers.packets_v1 import HEADER as HEADER_1
from splinearm.drivers.packets_v1 import MAX_LENGTH as MAX_LENGTH_1
from splinearm.drivers.packets_v1 import checksum

PACKET_GAP = 1.5e-3
"""A pause of that length within a packet of Protocol 2.0 ends it, s."""

PACKET_GAP_1 = 0.1
"""The same in Protocol 1.0, s."""

_PREFIX = 7  # header, id, length
_BARE_MARK = re.compile(rb"\xff\xff\xfd(?!\xfd)")


class Heard(NamedTuple):
    """A packet that came."""

    protocol: int
    """1 or 2."""
    packet: Packet
    """What it says; of a damaged one only the id counts."""
    length: int
    """Its bytes on the wire."""
    after: int
    """How many bytes have come after it."""
    damaged: bool = False
    """Whether its checksum was wrong."""


class Ear:
    """Finds packets of both protocols in a stream of bytes, however it is cut."""

    def __init__(self) -> None:
        self._new = bytearray()  # what may be of Protocol 2.0
        self._old = bytearray()  # what may be of Protocol 1.0

    @property
    def patience(self) -> float | None:
        """After which pause the bytes that wait are given up, s; None: none wait."""
        if self._new or self._old.startswith(HEADER):
            return PACKET_GAP
        return PACKET_GAP_1 if self._old else None

    def feed(self, data: bytes) -> list[Heard]:
        """Take bytes as they come and give the packets that they complete, oldest first."""
        fresh = not self._new and not self._old
        self._new += data
        heard = self._hear_new()
        if fresh and sum(each.length for each in heard) == len(data) and not _any_damaged(heard):
            return heard
        self._old += data
        heard += self._hear_old()
        heard.sort(key=_oldest)
        return heard

    def pause(self, seconds: float) -> list[Heard]:
        """Let nothing have come for so long; give what was hidden behind bytes given up."""
        heard: list[Heard] = []
        if seconds >= PACKET_GAP:
            self._new.clear()
            while self._old.startswith(HEADER):
                del self._old[:1]
                heard += self._hear_old()
        if seconds >= PACKET_GAP_1:
            self._old.clear()
        return heard

    def _hear_new(self) -> list[Heard]:
        """Give the packets of Protocol 2.0 in what has come."""
        pending, heard, start = self._new, list[Heard](), 0
        while True:
            start = _seek(pending, HEADER, start)
            end = _end_2(pending, start)
            if end is None:
                break
            if end == 0:
                start += 1
                continue
            after = len(pending) - end
            frame = bytes(pending[start:end])
            damaged = crc16(frame[:-2]) != frame[-2] | frame[-1] << 8
            body = unstuff(frame[_PREFIX:-2])
            packet = Packet(frame[4], body[0], body[1:])
            heard.append(Heard(2, packet, len(frame), after, damaged))
            start = start + 1 if damaged else end
        del pending[:start]
        return heard

    def _hear_old(self) -> list[Heard]:
        """Give the packets of Protocol 1.0 in what has come, past those of Protocol 2.0."""
        pending, heard, start = self._old, list[Heard](), 0
        while True:
            start = _seek(pending, HEADER_1, start)
            other = pending.startswith(HEADER, start)
            end = _end_2(pending, start) if other else _end_1(pending, start)
            if end is None:
                break
            if end == 0:
                start += 1
                continue
            after = len(pending) - end
            frame = bytes(pending[start:end])
            if other:
                damaged = crc16(frame[:-2]) != frame[-2] | frame[-1] << 8
            else:
                damaged = checksum(frame[2:-1]) != frame[-1]
                packet = Packet(frame[2], frame[4], frame[5:-1])
                heard.append(Heard(1, packet, len(frame), after, damaged))
            start = start + 1 if damaged else end
        del pending[:start]
        return heard


def _seek(pending: bytearray, header: bytes, start: int) -> int:
    """Give where the next header begins, perhaps one of which the end has not come yet."""
    found = pending.find(header, start)
    if found >= 0:
        return found
    for length in range(len(header) - 1, 0, -1):
        if len(pending) - length >= start and pending.endswith(header[:length]):
            return len(pending) - length
    return len(pending)


def _end_2(pending: bytearray, start: int) -> int | None:
    """Give the end of the frame of Protocol 2.0 there; None: not yet here; 0: it is none."""
    here = len(pending) - start
    if here < _PREFIX:
        return None
    length = pending[start + 5] | pending[start + 6] << 8
    if not 3 <= length <= MAX_LENGTH or pending[start + 4] > BROADCAST_ID:
        return 0
    end = start + _PREFIX + length
    # no body holds a mark that is not stuffed: with one, what was sent before has been cut short
    body_end = min(end - 2, len(pending))
    bare = _BARE_MARK.search(pending, start + _PREFIX, body_end)
    if bare is not None and (bare.end() < body_end or body_end == end - 2):
        return 0
    return end if here >= _PREFIX + length else None


def _end_1(pending: bytearray, start: int) -> int | None:
    """Give the end of the frame of Protocol 1.0 there; None: not yet here; 0: it is none."""
    here = len(pending) - start
    if here < 4:
        return None
    length = pending[start + 3]
    if pending[start + 2] == 0xFF or not 2 <= length <= MAX_LENGTH_1:
        return 0
    return start + 4 + length if here >= 4 + length else None


def _any_damaged(heard: list[Heard]) -> bool:
    return any(each.damaged for each in heard)


def _oldest(heard: Heard) -> int:
    return -heard.after
