"""Reads and writes of many servos in Protocol 1.0, and reads of one servo in either protocol.

A group write is a sync write. A group read is a bulk read, which only MX servos know: the others
are asked one after the other.
Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 1.0".
"""

import struct
from collections.abc import Collection, Sequence

from . import packets, packets_v1
from .bus import Loss, Reply
from .dialect import DIALECTS
from .gauge import pack_code
from .groups import BulkRead, asked_next
from .layout import block_length
from .packets import BROADCAST_ID, Instruction, Packet
from .registers import Register
from .sending import Block

_OVERHEAD = 6  # header, id, LEN, error, checksum


class BulkReadV1:
    """One bulk read in Protocol 1.0.

    Each servo waits for the one before: one that was lost is asked last from then on.

    Args:
        requests: What to read from each servo; ids differ.
    """

    instruction = Instruction.BULK_READ
    """What is asked."""

    def __init__(self, requests: Sequence[BulkRead]) -> None:
        ids = [request.servo_id for request in requests]
        if not ids or len(set(ids)) != len(ids):
            raise ValueError(f"requests: want one for each of some servos, got {ids}")
        self._build(list(requests), ())

    def _build(self, requests: list[BulkRead], lost: Collection[int]) -> None:
        """Prepare all that does not change from read to read."""
        self._requests = requests
        self.ids = tuple(request.servo_id for request in requests)
        """Ids in the order in which they are asked."""
        wanted = b"".join(bytes((r.length, r.servo_id, r.address)) for r in requests)
        self.request = packets_v1.encode(BROADCAST_ID, Instruction.BULK_READ, b"\0" + wanted)
        """The bytes to send."""
        self.reply_length = sum(_OVERHEAD + request.length for request in requests)
        """How many bytes come back if nothing is lost."""
        sure = [_OVERHEAD + r.length for r in requests if r.servo_id not in lost]
        self.sure_length = sum(sure) or self.reply_length
        """How many of them come if those are lost again that were lost last time."""
        self.settled = not lost
        """Whether the next read is the one that a flawless answer would lead to again."""

    def is_flawless(self, data: bytes) -> bool:
        """Say whether an answer is whole, in order and undamaged."""
        if len(data) != self.reply_length:
            return False
        start = 0
        for servo_id, _, length in self._requests:
            end = start + _OVERHEAD + length
            if data[start : start + 4] != bytes((0xFF, 0xFF, servo_id, length + 2)):
                return False
            if packets_v1.checksum(data[start + 2 : end - 1]) != data[end - 1]:
                return False
            start = end
        return True

    def replies(self, data: bytes) -> dict[int, Reply]:
        """Take a flawless answer apart."""
        replies: dict[int, Reply] = {}
        start = 0
        for servo_id, _, length in self._requests:
            end = start + _OVERHEAD + length
            error = packets_v1.modern_error(data[start + 4])
            replies[servo_id] = Reply(data[start + 5 : end - 1], error)
            start = end
        return replies

    def parse(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Understand what came back, as far as it came, and whether more may still come."""
        if self.is_flawless(data):
            return self.replies(data), False
        listener = DIALECTS[1].listener()
        answers = listener.feed(data.removeprefix(self.request))
        by_id = {packet.servo_id: packet for packet in reversed(answers)}
        replies = {
            request.servo_id: _reply(by_id.get(request.servo_id), request, data)
            for request in self._requests
        }
        return replies, any(reply.loss is not None for reply in replies.values())

    def learn(self, replies: dict[int, Reply]) -> None:
        """Take from an outcome how to ask next time."""
        lost = {servo_id for servo_id, reply in replies.items() if reply.loss is not None}
        if lost or not self.settled:
            self._build(asked_next(self._requests, lost), lost)

    def forget(self) -> None:
        """Begin anew, as if nothing had ever come back."""
        self._build(self._requests, ())


class OneRead:
    """A read of one servo, for those that know no group read.

    Args:
        request: What to read.
        protocol: The protocol that the servo speaks, 1 or 2.
    """

    instruction = Instruction.READ
    """What is asked."""
    settled = True
    """The next read is always the same."""

    def __init__(self, request: BulkRead, protocol: int) -> None:
        self._request = request
        self._dialect = DIALECTS[protocol]
        self.ids = (request.servo_id,)
        """The servo."""
        params = self._dialect.read_params(request.address, request.length)
        self.request = self._dialect.frame(request.servo_id, Instruction.READ, params)
        """The bytes to send."""
        self.reply_length = self._dialect.status_length + request.length
        """How many bytes come back if nothing is lost or stuffed."""
        self.sure_length = self.reply_length
        """As many."""
        self._header = packets_v1.HEADER if protocol == 1 else packets.HEADER

    def is_flawless(self, data: bytes) -> bool:
        """Say whether an answer is whole and undamaged."""
        return len(data) == self.reply_length and not self.parse(data)[1]

    def replies(self, data: bytes) -> dict[int, Reply]:
        """Take a flawless answer apart."""
        return self.parse(data)[0]

    def parse(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Understand what came back, as far as it came, and whether more may still come."""
        request = self._request
        for packet in self._dialect.listener().feed(data.removeprefix(self.request)):
            if packet.servo_id == request.servo_id:
                return {request.servo_id: _reply(packet, request, b"")}, False
        return {request.servo_id: _reply(None, request, data, self._header)}, True

    def learn(self, replies: dict[int, Reply]) -> None:
        """Do nothing: there is no other way to ask."""

    def forget(self) -> None:
        """Do nothing: nothing was learned."""


class GroupWriteV1:
    """One sync write in Protocol 1.0.

    Args:
        blocks: What is written to each servo: for all at the same place; ids differ.
    """

    instruction = Instruction.SYNC_WRITE
    """What is sent."""

    def __init__(self, blocks: Sequence[Block]) -> None:
        self.ids = tuple(block.servo_id for block in blocks)
        """Ids in the order of the values."""
        places = {(block.address, block_length(block.fields)) for block in blocks}
        if len(places) != 1 or len(set(self.ids)) != len(self.ids):
            raise ValueError(f"blocks: want one place in each of some servos, got {blocks}")
        self._place = bytes(places.pop())
        self._pack = struct.Struct("<" + "".join("B" + pack_code(b.fields) for b in blocks))
        self._counts = [sum(isinstance(f, Register) for f in b.fields) for b in blocks]

    def frame(self, values: Sequence[int]) -> bytes:
        """Give the bytes that write these values, servo by servo in the order of ``ids``.

        Raises:
            ValueError: If there are not as many values as registers, or one cannot hold its value.
        """
        params: list[int] = []
        rest = list(values)
        for servo_id, count in zip(self.ids, self._counts, strict=True):
            params += [servo_id, *rest[:count]]
            del rest[:count]
        try:
            data = self._pack.pack(*params, *rest)
        except struct.error as error:
            raise ValueError(f"values: {error}, got {list(values)}") from error
        return packets_v1.encode(BROADCAST_ID, Instruction.SYNC_WRITE, self._place + data)


def _reply(
    packet: Packet | None, request: BulkRead, data: bytes, header: bytes = packets_v1.HEADER
) -> Reply:
    """Say what a status packet, or its absence from ``data``, means for a request."""
    if packet is None:
        began = header + bytes((request.servo_id,)) in data
        return Reply(b"", 0, Loss.DAMAGED if began else Loss.SILENT)
    if len(packet.params) == request.length:
        return Reply(packet.params, packet.error)
    return Reply(b"", packet.error, Loss.REFUSED if packet.error_number else Loss.DAMAGED)
