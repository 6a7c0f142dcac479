"""Reads of many servos, prebuilt: what a control loop asks in every cycle.

No input or output here: a ``GroupRead`` gives the bytes to send and understands those that come
back.
"""

import logging
from collections.abc import Sequence
from itertools import accumulate

from .bus import Loss, Reply
from .groups import BulkRead, asked_next
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
from .sending import GroupWrite as GroupWrite

_log = logging.getLogger(__name__)

_STATUS_OVERHEAD = 11  # header, id, LEN, instruction, error, CRC
_FAST_HEAD = 8  # header, id, LEN, instruction
_FAST_OVERHEAD = 4  # error, id, CRC
_FAST_PREFIX = HEADER + bytes((BROADCAST_ID,))
_FAST_TRIES = 3
_NOT_THERE = (Loss.SILENT, Loss.HIDDEN)


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
        self.settled = True
        """Whether the next read is the one that a flawless answer would lead to again."""
        self._build()

    @property
    def requests(self) -> tuple[BulkRead, ...]:
        """What is asked of each servo, in the order in which they are asked next."""
        return tuple(self._requests)

    @property
    def fast(self) -> bool:
        """Whether the next read is a fast one."""
        return self._use_fast

    def _build(self) -> None:
        """Prepare all that does not change from read to read."""
        requests = self._requests
        self.ids = tuple(request.servo_id for request in requests)
        """Ids in the order in which they are asked next."""
        same = len({(request.address, request.length) for request in requests}) == 1
        if same:
            first = requests[0]
            params = sync_read_params(first.address, first.length, self.ids)
        else:
            params = bulk_read_params(requests)
        self.instruction = {
            (True, True): Instruction.FAST_SYNC_READ,
            (True, False): Instruction.FAST_BULK_READ,
            (False, True): Instruction.SYNC_READ,
            (False, False): Instruction.BULK_READ,
        }[self._use_fast, same]
        """What is asked."""
        self.request = encode(BROADCAST_ID, self.instruction, params)
        """The bytes to send."""
        lengths = [request.length for request in requests]
        if self._use_fast:
            self.reply_length = _FAST_HEAD + sum(_FAST_OVERHEAD + n for n in lengths)
        else:
            self.reply_length = sum(_STATUS_OVERHEAD + n for n in lengths)
        """How many bytes come back if nothing is lost or stuffed."""
        self._set_sure_length()
        self._gap = _FAST_OVERHEAD if self._use_fast else _STATUS_OVERHEAD
        self.same = same
        """Whether all are asked for the same bytes."""
        self.stride = self._gap + lengths[0]
        """From the data of one servo to that of the next if all are asked for the same, bytes."""
        self.first_error, self.first_data = (8, 10) if self._use_fast else (8, 9)
        """Where in a flawless answer the error byte and the data of the first servo are."""
        self.first_block = _FAST_HEAD if self._use_fast else 0
        """Where in a flawless answer the stride of the first servo begins."""
        self._id_bytes = bytes(self.ids)
        starts = accumulate((self._gap + n for n in lengths[:-1]), initial=_FAST_HEAD + 1)
        self._id_places = tuple(starts)
        self._frames = [
            (HEADER + bytes((i, (n + 4) & 0xFF, (n + 4) >> 8, 0x55)), _STATUS_OVERHEAD + n)
            for i, n in zip(self.ids, lengths, strict=True)
        ]

    def _set_sure_length(self) -> None:
        """Count the bytes that come if those are lost again that were lost last time."""
        sure = [r.length for r in self._requests if r.servo_id not in self._doubted]
        self.sure_length = self.reply_length
        """How many of them come if those are lost again that were lost last time."""
        if sure and self._use_fast:
            self.sure_length = _FAST_HEAD + sum(_FAST_OVERHEAD + n for n in sure)
        elif sure:
            self.sure_length = sum(_STATUS_OVERHEAD + n for n in sure)

    def parse(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Understand what came back, as far as it came.

        Returns:
            A reply for every id, in the order in which they were asked, and whether more bytes may
            still come.
        """
        if self.is_flawless(data):
            return self.replies(data), False
        return self._parse_any_fast(data) if self._use_fast else self._parse_any(data)

    def is_flawless(self, data: bytes) -> bool:
        """Say whether an answer is whole, in order and undamaged."""
        if len(data) != self.reply_length:
            return False
        if self._use_fast:  # its last CRC vouches for the whole
            good = data.startswith(_FAST_PREFIX) and crc16(data[:-2]) == data[-2] | data[-1] << 8
            return good and self._ids_in(data) == self._id_bytes
        start = 0
        for prefix, size in self._frames:
            end = start + size
            if not data.startswith(prefix, start):
                return False
            if crc16(data[start : end - 2]) != data[end - 2] | data[end - 1] << 8:
                return False
            start = end
        return True

    def replies(self, data: bytes) -> dict[int, Reply]:
        """Take a flawless answer apart."""
        replies: dict[int, Reply] = {}
        error, start = self.first_error, self.first_data
        for request in self._requests:
            end = start + request.length
            replies[request.servo_id] = Reply(data[start:end], data[error])
            error, start = error + self._gap + request.length, end + self._gap
        return replies

    def _ids_in(self, data: bytes) -> bytes:
        """Give the ids in a fast answer of full length."""
        if self.same:
            return data[_FAST_HEAD + 1 : -2 : self.stride]
        return bytes(data[at] for at in self._id_places)

    def learn(self, replies: dict[int, Reply]) -> None:
        """Take from an outcome how to ask next time."""
        lost = {servo_id for servo_id, reply in replies.items() if reply.loss is not None}
        before = (self.ids, self._use_fast)
        # a fast answer ends at the first servo that is missing: of those after it nothing is known
        gone = {i for i in lost - self._doubted if replies[i].loss in _NOT_THERE}
        unclear = self._use_fast and len(gone) > 1
        if self._fast_known:
            nobody = all(reply.loss in _NOT_THERE for reply in replies.values())
            self._choose_speed(nobody=nobody, unclear=unclear)
        if not unclear:
            self._doubted = lost
            self._requests = asked_next(self._requests, lost)
        ids = tuple(request.servo_id for request in self._requests)
        if before != (ids, self._use_fast):
            self._build()
        self._set_sure_length()
        given_up = self._fast_failures >= _FAST_TRIES
        self.settled = not lost and (
            not self._fast_known or given_up or (self._use_fast and not self._fast_failures)
        )

    def forget(self) -> None:
        """Begin anew, as if nothing had ever come back."""
        self._fast_failures = 0
        self._use_fast = self._fast_known
        self._doubted = set()
        self.settled = True
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

    def _parse_any(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Find answers between whatever else came."""
        decoder = Decoder()
        answers = [packet for packet in decoder.feed(data) if packet.is_status]
        by_id = self._in_their_places(data)
        by_id |= {packet.servo_id: packet for packet in reversed(answers)}
        replies = {
            request.servo_id: _reply(by_id.get(request.servo_id), request, data)
            for request in self._requests
        }
        came = len(answers) + decoder.crc_errors
        if all(reply.loss is None for reply in replies.values()):
            return replies, False
        return replies, decoder.pending > 0 or came < len(self._requests)

    def _in_their_places(self, data: bytes) -> dict[int, Packet]:
        """Give answers whose beginning, which is known, is all that may be damaged."""
        found: dict[int, Packet] = {}
        if len(data) != self.reply_length:
            return found
        start = 0
        for servo_id, (prefix, size) in zip(self.ids, self._frames, strict=True):
            end, first = start + size, start + len(prefix)
            crc = crc16(prefix + data[first : end - 2])
            if crc == data[end - 2] | data[end - 1] << 8:
                params = data[first + 1 : end - 2]
                found[servo_id] = Packet(servo_id, Instruction.STATUS, params, data[first])
            start = end
        return found

    def _parse_any_fast(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Find the part of a fast answer that can be trusted."""
        length = self.reply_length - 7
        head = _FAST_PREFIX + bytes((length & 0xFF, length >> 8, Instruction.STATUS))
        start = data.find(head)
        frame = data[start:] if start >= 0 else b""
        if start < 0 and len(data) == self.reply_length:  # what it begins with is known
            frame = head + data[len(head) :]
        wanted = [(request.servo_id, request.length) for request in self._requests]
        blocks = {block.servo_id: block for block in parse_fast_reply(frame, wanted)}
        came = len(frame) if start >= 0 else len(data)
        replies: dict[int, Reply] = {}
        end, silent = _FAST_HEAD, False
        for servo_id, count in wanted:
            end += _FAST_OVERHEAD + count
            if servo_id in blocks:
                replies[servo_id] = Reply(blocks[servo_id].data, blocks[servo_id].error)
                continue
            loss = Loss.DAMAGED if came >= end else Loss.HIDDEN if silent else Loss.SILENT
            replies[servo_id] = Reply(b"", 0, loss)
            silent = silent or loss is Loss.SILENT
        return replies, len(data) < max(start, 0) + self.reply_length


def _reply(packet: Packet | None, request: BulkRead, data: bytes) -> Reply:
    """Say what a status packet, or its absence from ``data``, means for a request."""
    if packet is None:
        began = HEADER + bytes((request.servo_id,)) in data
        return Reply(b"", 0, Loss.DAMAGED if began else Loss.SILENT)
    if len(packet.params) == request.length:
        return Reply(packet.params, packet.error)
    return Reply(b"", packet.error, Loss.REFUSED if packet.error_number else Loss.DAMAGED)
