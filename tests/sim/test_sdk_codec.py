"""The maker's codec and ours read each other's frames, wherever the maker's is right.

It is not where bytes need stuffing: what its ``txPacket`` sends is never stuffed. On the way back
it takes stuffing out.
"""

import re

import dynamixel_sdk as sdk
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from splinearm.drivers import packets_v1
from splinearm.drivers.packets import (
    Decoder,
    FastBlock,
    Instruction,
    encode,
    encode_status,
    fast_reply_pieces,
    parse_fast_reply,
)
from splinearm.sim.ear import Ear

MARK = b"\xff\xff\xfd"
ids = st.integers(0, 252)
errors = st.integers(0, 0x7F)
full_of_marks = st.lists(
    st.sampled_from([MARK, b"\xff", b"\xfd", b"\x00", b"\x41"]), max_size=12
).map(b"".join)
data = st.one_of(st.binary(max_size=60), full_of_marks)


class MemoryPort:
    """What the SDK takes for a port: it reads what it is given, and keeps what it is to send."""

    def __init__(self, incoming: bytes = b"") -> None:
        self.incoming, self.sent = incoming, b""
        self.is_using = False

    def clearPort(self) -> None: ...  # noqa: N802
    def setPacketTimeout(self, _length: int) -> None: ...  # noqa: N802

    def isPacketTimeout(self) -> bool:  # noqa: N802
        return not self.incoming

    def readPort(self, length: int) -> bytes:  # noqa: N802
        got, self.incoming = self.incoming[:length], self.incoming[length:]
        return got

    def writePort(self, packet: list[int]) -> int:  # noqa: N802
        self.sent = bytes(packet)
        return len(packet)


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(ids, errors, data)
def test_the_sdk_reads_our_status_packets_of_protocol_2(servo_id, error, params):
    port = MemoryPort(encode_status(servo_id, error, params))
    packet, result = sdk.PacketHandler(2.0).rxPacket(port, False)
    assert result == sdk.COMM_SUCCESS
    length = packet[5] | packet[6] << 8
    assert (packet[4], packet[8]) == (servo_id, error)
    assert bytes(packet[9 : 7 + length - 2]) == params


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(ids, errors, data)
def test_the_sdk_reads_our_status_packets_of_protocol_1(servo_id, error, params):
    port = MemoryPort(packets_v1.encode_status(servo_id, error, params))
    packet, result = sdk.PacketHandler(1.0).rxPacket(port)
    assert result == sdk.COMM_SUCCESS
    assert (packet[2], packet[4], bytes(packet[5:-1])) == (servo_id, error, params)


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(ids, st.integers(0, 0xFFFF), data.filter(bool))
def test_we_read_what_the_sdk_writes_in_protocol_2(servo_id, address, params):
    body = bytes((Instruction.WRITE,)) + address.to_bytes(2, "little") + params
    assume(MARK not in body)
    port = MemoryPort()
    sdk.PacketHandler(2.0).writeTxOnly(port, servo_id, address, len(params), list(params))
    assert port.sent == encode(servo_id, body[0], body[1:])
    assert [(p.servo_id, p.params) for p in Decoder().feed(port.sent)] == [(servo_id, body[1:])]
    assert [each.protocol for each in Ear().feed(port.sent)] == [2]


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(ids, st.integers(0, 0xFF), data.filter(bool))
def test_we_read_what_the_sdk_writes_in_protocol_1(servo_id, address, params):
    port = MemoryPort()
    sdk.PacketHandler(1.0).writeTxOnly(port, servo_id, address, len(params), list(params))
    body = bytes((address,)) + params
    assert port.sent == packets_v1.encode(servo_id, Instruction.WRITE, body)
    (packet,) = packets_v1.Decoder(status=False).feed(port.sent)
    assert (packet.servo_id, packet.params) == (servo_id, body)


def test_where_bytes_need_stuffing_the_sdk_sends_a_frame_that_is_none():
    port = MemoryPort()
    sdk.PacketHandler(2.0).writeTxOnly(port, 1, 116, 4, list(MARK + b"\xff"))
    assert re.search(rb"\xff\xff\xfd(?!\xfd)", port.sent[7:])
    assert Decoder().feed(port.sent) == []


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(st.lists(st.tuples(ids, errors, st.binary(min_size=4, max_size=4)), min_size=1, max_size=6))
def test_the_sdk_and_we_read_the_same_in_a_fast_answer(entries):
    assume(len({servo_id for servo_id, _, _ in entries}) == len(entries))
    blocks = [FastBlock(*entry) for entry in entries]
    frame = b"".join(fast_reply_pieces(blocks))
    assert list(parse_fast_reply(frame, [(b.servo_id, 4) for b in blocks])) == blocks
    assume(MARK not in frame[7:])  # the SDK takes out stuffing here too, where there is none
    packet, result = sdk.PacketHandler(2.0).rxPacket(MemoryPort(frame), True)
    assert result == sdk.COMM_SUCCESS
    assert bytes(packet[8 : len(frame)]) == frame[8:]


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(st.lists(st.one_of(st.binary(max_size=40), full_of_marks), max_size=10))
def test_no_bytes_make_a_decoder_fail(chunks):
    decoders = (Decoder(), packets_v1.Decoder(status=True), packets_v1.Decoder(status=False))
    for chunk in chunks:
        for decoder in decoders:
            for packet in decoder.feed(chunk):
                assert 0 <= packet.servo_id <= 0xFE
    for decoder in decoders:
        decoder.reset()
        good = encode_status(1) if decoder is decoders[0] else packets_v1.encode_status(1)
        assert len(decoder.feed(good)) == 1
