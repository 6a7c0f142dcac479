"""Reads and writes of many servos, prebuilt: what a control loop sends in every cycle.

No input or output here: a ``GroupRead`` gives the bytes to send and understands those that come
back, a ``GroupWrite`` turns values into the bytes to send.
"""

import logging
import struct
from collections.abc import Sequence

from .bus import Loss, Reply
from .groups import BulkRead
from .packets import (
    BROADCAST_ID,
    HEADER,
    Decoder,
    Instruction,
    Packet,
    bulk_read_params,
    crc16,
    encode,
    parse_fast_reply,
    sync_read_params,
)
from .registers import Register

_log = logging.getLogger(__name__)

_STATUS_OVERHEAD = 11  # header, id, LEN, instruction, error, CRC
_FAST_HEAD = 8  # header, id, LEN, instruction
_FAST_OVERHEAD = 4  # error, id, CRC
_FAST_PREFIX = HEADER + bytes((BROADCAST_ID,))
_FAST_TRIES = 3
_FORMATS = {(1, False): "B", (1, True): "b", (2, False): "H", (2, True): "h"}
_FORMATS |= {(4, False): "I", (4, True): "i"}


class GroupRead:
    """One read of the same registers of many servos.

    It learns from what comes back. A servo that was lost is asked last from then on, so that it
    does not stand between the others and their answers: in a fast read each waits for the one
    before. After a fast read that leaves open who is lost comes a plain one, which tells. After
    three fast reads in a row that nobody answered come only plain ones.

    Args:
        requests: What to read from each servo; ids differ.
        fast: Whether every servo knows fast reads.
    """

    def __init__(self, requests: Sequence[BulkRead], *, fast: bool) -> None:
        ids = [request.servo_id for request in requests]
        if not ids or len(set(ids)) != len(ids):
            raise ValueError(f"requests: want one for each of some servos, got {ids}")
        self._requests = list(requests)
        self._fast_known = fast
        self._fast_failures = 0
        self._use_fast = fast
        self._doubted: set[int] = set()
        self._build()

    @property
    def ids(self) -> tuple[int, ...]:
        """Ids in the order in which they are asked next."""
        return tuple(request.servo_id for request in self._requests)

    @property
    def fast(self) -> bool:
        """Whether the next read is a fast one."""
        return self._use_fast

    def _build(self) -> None:
        """Prepare all that does not change from read to read."""
        requests = self._requests
        same = len({(request.address, request.length) for request in requests}) == 1
        if same:
            first = requests[0]
            params = sync_read_params(first.address, first.length, self.ids)
        else:
            params = bulk_read_params(requests)
        instruction = {
            (True, True): Instruction.FAST_SYNC_READ,
            (True, False): Instruction.FAST_BULK_READ,
            (False, True): Instruction.SYNC_READ,
            (False, False): Instruction.BULK_READ,
        }[self._use_fast, same]
        self.request = encode(BROADCAST_ID, instruction, params)
        """The bytes to send."""
        lengths = [request.length for request in requests]
        if self._use_fast:
            self.reply_length = _FAST_HEAD + sum(_FAST_OVERHEAD + n for n in lengths)
        else:
            self.reply_length = sum(_STATUS_OVERHEAD + n for n in lengths)
        """How many bytes come back if nothing is lost or stuffed."""
        self._prefixes = [
            HEADER + bytes((r.servo_id, (r.length + 4) & 0xFF, (r.length + 4) >> 8, 0x55))
            for r in requests
        ]

    def parse(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Understand what came back, as far as it came.

        Returns:
            A reply for every id, in the order in which they were asked, and whether more bytes may
            still come.
        """
        if len(data) == self.reply_length:
            replies = self._parse_exact_fast(data) if self._use_fast else self._parse_exact(data)
            if replies is not None:
                return replies, False
        return self._parse_any_fast(data) if self._use_fast else self._parse_any(data)

    def learn(self, replies: dict[int, Reply]) -> None:
        """Take from an outcome how to ask next time."""
        lost = {servo_id for servo_id, reply in replies.items() if reply.loss is not None}
        before = (self.ids, self._use_fast)
        # a fast answer ends at the first servo that is lost: of those after it nothing is known
        unclear = self._use_fast and len(lost - self._doubted) > 1
        if self._fast_known:
            self._choose_speed(nobody=len(lost) == len(self._requests), unclear=unclear)
        if not unclear:
            self._doubted = lost
            self._requests.sort(key=lambda request: request.servo_id in lost)
        if before != (self.ids, self._use_fast):
            self._build()

    def _choose_speed(self, *, nobody: bool, unclear: bool) -> None:
        """Ask plainly after a fast read that leaves open who is lost, then fast again."""
        if not self._use_fast:
            self._use_fast = not nobody and self._fast_failures < _FAST_TRIES
            return
        self._use_fast = not (nobody or unclear)
        self._fast_failures = self._fast_failures + 1 if nobody else 0
        if self._fast_failures == _FAST_TRIES:
            _log.warning("nobody answers fast reads: plain ones from here on")

    def _parse_exact(self, data: bytes) -> dict[int, Reply] | None:
        """Read answers that came one after the other without a flaw; None if they did not."""
        replies: dict[int, Reply] = {}
        start = 0
        for request, prefix in zip(self._requests, self._prefixes, strict=True):
            end = start + _STATUS_OVERHEAD + request.length
            check = end - 2
            if not data.startswith(prefix, start):
                return None
            if crc16(data[start:check]) != data[check] | data[check + 1] << 8:
                return None
            replies[request.servo_id] = Reply(data[start + 9 : check], data[start + 8])
            start = end
        return replies

    def _parse_exact_fast(self, data: bytes) -> dict[int, Reply] | None:
        """Read a fast answer without a flaw; its last CRC vouches for the whole."""
        if not data.startswith(_FAST_PREFIX) or crc16(data[:-2]) != data[-2] | data[-1] << 8:
            return None
        replies: dict[int, Reply] = {}
        start = _FAST_HEAD
        for request in self._requests:
            if data[start + 1] != request.servo_id:
                return None
            end = start + _FAST_OVERHEAD + request.length
            replies[request.servo_id] = Reply(data[start + 2 : end - 2], data[start])
            start = end
        return replies

    def _parse_any(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Find answers between whatever else came."""
        decoder = Decoder()
        answers = [packet for packet in decoder.feed(data) if packet.is_status]
        by_id = {packet.servo_id: packet for packet in reversed(answers)}
        replies = {
            request.servo_id: _reply(by_id.get(request.servo_id), request, data)
            for request in self._requests
        }
        came = len(answers) + decoder.crc_errors
        return replies, decoder.pending > 0 or came < len(self._requests)

    def _parse_any_fast(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Find the part of a fast answer that can be trusted."""
        length = self.reply_length - 7
        head = _FAST_PREFIX + bytes((length & 0xFF, length >> 8, Instruction.STATUS))
        start = data.find(head)
        frame = data[start:] if start >= 0 else b""
        wanted = [(request.servo_id, request.length) for request in self._requests]
        blocks = {block.servo_id: block for block in parse_fast_reply(frame, wanted)}
        came = len(frame) if start >= 0 else len(data)
        replies: dict[int, Reply] = {}
        end, hidden = _FAST_HEAD, False
        for servo_id, count in wanted:
            end += _FAST_OVERHEAD + count
            if servo_id in blocks:
                replies[servo_id] = Reply(blocks[servo_id].data, blocks[servo_id].error)
                continue
            loss = Loss.DAMAGED if came >= end else Loss.SILENT
            replies[servo_id] = Reply(b"", 0, Loss.HIDDEN if hidden else loss)
            hidden = True
        return replies, len(data) < max(start, 0) + self.reply_length


def _reply(packet: Packet | None, request: BulkRead, data: bytes) -> Reply:
    """Say what a status packet, or its absence from ``data``, means for a request."""
    if packet is None:
        began = HEADER + bytes((request.servo_id,)) in data
        return Reply(b"", 0, Loss.DAMAGED if began else Loss.SILENT)
    if len(packet.params) == request.length:
        return Reply(packet.params, packet.error)
    return Reply(b"", packet.error, Loss.REFUSED if packet.error_number else Loss.DAMAGED)


class GroupWrite:
    """One write of a value to a register of each of many servos.

    Args:
        targets: Id and register of each servo; ids differ. The same place in every servo makes a
            sync write, different places a bulk write.
    """

    def __init__(self, targets: Sequence[tuple[int, Register]]) -> None:
        self.ids = tuple(servo_id for servo_id, _ in targets)
        """Ids in the order of the values."""
        if not self.ids or len(set(self.ids)) != len(self.ids):
            raise ValueError(f"targets: want one for each of some servos, got {self.ids}")
        places = {(register.address, register.size, register.signed) for _, register in targets}
        codes = [_FORMATS[register.size, register.signed] for _, register in targets]
        self._params: list[int] = []
        if len(places) == 1:
            register = targets[0][1]
            self._fixed = struct.pack("<HH", register.address, register.size)
            self._instruction = Instruction.SYNC_WRITE
            self._pack = struct.Struct("<" + "".join(f"B{code}" for code in codes))
            self._step = 2
            for servo_id, _ in targets:
                self._params += [servo_id, 0]
        else:
            self._fixed = b""
            self._instruction = Instruction.BULK_WRITE
            self._pack = struct.Struct("<" + "".join(f"BHH{code}" for code in codes))
            self._step = 4
            for servo_id, register in targets:
                self._params += [servo_id, register.address, register.size, 0]

    def frame(self, values: Sequence[int]) -> bytes:
        """Give the bytes that write these values, in the order of ``ids``.

        Raises:
            ValueError: If there are not as many values as servos, or a register cannot hold one.
        """
        params = self._params
        if len(values) != len(self.ids):
            raise ValueError(f"values: want {len(self.ids)} of them, got {len(values)}")
        params[self._step - 1 :: self._step] = values
        try:
            blocks = self._pack.pack(*params)
        except struct.error as error:
            raise ValueError(f"values: {error}, got {list(values)}") from error
        return encode(BROADCAST_ID, self._instruction, self._fixed + blocks)
