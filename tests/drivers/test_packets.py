import json
from pathlib import Path

import pytest
from dynamixel_sdk import PacketHandler
from hypothesis import assume, given
from hypothesis import strategies as st

from splinearm.drivers import packets
from splinearm.drivers.packets import Decoder, Instruction, Packet

DATA = Path(__file__).parents[1] / "data" / "dynamixel_packets.json"
VECTORS = [v for v in json.loads(DATA.read_text())["vectors"] if v["protocol"] == 2]

# parameters as nasty as they come: made of the bytes of headers
nasty = st.lists(st.sampled_from([0xFF, 0xFF, 0xFD, 0x00, 0x55, 0x01]), max_size=30).map(bytes)
params = st.one_of(st.binary(max_size=30), nasty)
ids = st.integers(0, 252)
instructions = st.sampled_from([i for i in Instruction if i is not Instruction.STATUS])
sent = st.builds(Packet, ids, instructions, params)
answered = st.builds(Packet, ids, st.just(Instruction.STATUS), params, st.integers(0, 255))
any_packet = st.one_of(sent, answered)


def encoded(packet: Packet) -> bytes:
    if packet.is_status:
        return packets.encode_status(packet.servo_id, packet.error, packet.params)
    return packets.encode(packet.servo_id, packet.instruction, packet.params)


@pytest.mark.parametrize("vector", VECTORS, ids=lambda v: v["name"])
def test_what_the_host_sends_is_as_printed(vector):
    frame = bytes.fromhex(vector["tx"])
    packet = packets.decode(frame)
    assert packet.instruction == Instruction[vector["instruction"].upper().replace(" ", "_")]
    assert encoded(packet) == frame


@pytest.mark.parametrize(
    "vector", [v for v in VECTORS if not v["name"].startswith("fast")], ids=lambda v: v["name"]
)
def test_what_servos_answer_is_as_printed(vector):
    for text in vector["rx"]:
        frame = bytes.fromhex(text)
        packet = packets.decode(frame)
        assert packet.is_status
        assert encoded(packet) == frame


@pytest.mark.parametrize(
    "vector", [v for v in VECTORS if v["name"].startswith("fast")], ids=lambda v: v["name"]
)
def test_fast_answers_are_as_printed(vector):
    request = packets.decode(bytes.fromhex(vector["tx"]))
    if request.instruction == Instruction.FAST_SYNC_READ:
        _, length, asked = packets.parse_sync_read(request.params)
        wanted = [(servo_id, length) for servo_id in asked]
    else:
        wanted = [(r.servo_id, r.length) for r in packets.parse_bulk_read(request.params)]
    pieces = [bytes.fromhex(text) for text in vector["rx"]]
    blocks = packets.parse_fast_reply(b"".join(pieces), wanted)
    assert [block.servo_id for block in blocks] == [3, 7, 4]
    assert packets.fast_reply_pieces(blocks) == pieces
    assert packets.decode(b"".join(pieces)).servo_id == packets.BROADCAST_ID


def test_the_vectors_say_what_the_manual_says():
    by_name = {vector["name"]: vector for vector in VECTORS}
    ping = packets.decode(bytes.fromhex(by_name["ping id 1"]["rx"][0]))
    assert ping == Packet(1, Instruction.STATUS, bytes((0x06, 0x04, 38)))
    alert = packets.decode(
        bytes.fromhex(by_name["status alert bit after a hardware error"]["rx"][0])
    )
    assert (alert.alert, alert.error_number, alert.params) == (True, 0, b"\x20")
    refused = packets.decode(bytes.fromhex(by_name["status error: out of range value"]["rx"][0]))
    assert (refused.alert, refused.error_number) == (False, 4)


@pytest.mark.property
@given(stream=st.lists(any_packet, max_size=4), data=st.data())
def test_packets_survive_every_cut_of_the_stream(stream, data):
    wire = b"".join(map(encoded, stream))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(wire)), max_size=8)))
    decoder = Decoder()
    found = []
    for start, end in zip([0, *cuts], [*cuts, len(wire)], strict=True):
        found += decoder.feed(wire[start:end])
    assert found == stream
    assert (decoder.noise_bytes, decoder.crc_errors, decoder.pending) == (0, 0, 0)


@pytest.mark.property
@given(packet=any_packet)
def test_packets_survive_byte_by_byte(packet):
    decoder = Decoder()
    found = [p for byte in encoded(packet) for p in decoder.feed(bytes((byte,)))]
    assert found == [packet]


@pytest.mark.property
@given(
    noise=st.binary(max_size=40).filter(lambda b: b"\xff\xff\xfd\x00" not in b), packet=any_packet
)
def test_noise_before_a_packet_does_not_hide_it(noise, packet):
    decoder = Decoder()
    assert decoder.feed(noise + encoded(packet)) == [packet]
    assert decoder.noise_bytes == len(noise)


@pytest.mark.property
@given(first=any_packet, second=any_packet, cut=st.integers(0, 80))
def test_a_truncated_packet_does_not_swallow_the_next(first, second, cut):
    whole = encoded(first)
    wire = whole[: min(cut, len(whole) - 1)] + encoded(second)
    assume(
        not wire.startswith(whole)
    )  # a CRC that ends in FF, and the next header's FF in its place
    assert Decoder().feed(wire) == [second]


@pytest.mark.property
@given(first=any_packet, second=any_packet, data=st.data())
def test_a_damaged_byte_costs_at_most_its_own_packet(first, second, data):
    wire = bytearray(encoded(first))
    where = data.draw(st.integers(0, len(wire) - 1))
    wire[where] ^= data.draw(st.integers(1, 255))
    decoder = Decoder()
    found = decoder.feed(bytes(wire) + encoded(second))
    if second not in found:  # a damaged LEN may make the decoder wait for more than came
        found += decoder.feed(bytes(packets.MAX_LENGTH))
    assert found == [second]


@pytest.mark.property
@given(noise=st.binary(max_size=400))
def test_noise_alone_raises_nothing(noise):
    decoder = Decoder()
    found = decoder.feed(noise)
    decoder.reset()
    taken = sum(len(encoded(packet)) for packet in found)
    assert decoder.noise_bytes + taken == len(noise)


@pytest.mark.property
@given(body=params)
def test_stuffing_is_undone_and_leaves_no_header(body):
    stuffed = packets.stuff(body)
    assert packets.unstuff(stuffed) == body
    assert b"\xff\xff\xfd\x00" not in stuffed


@pytest.mark.property
@given(
    error=st.integers(0, 255), value=st.one_of(st.binary(max_size=4), nasty.map(lambda b: b[:4]))
)
def test_the_makers_sdk_reads_registers_out_of_what_we_stuff(error, value):
    # up to a register of 4 bytes, all that the SDK is used for: after a first stuffed byte it takes
    # FF FD FD for stuffing too, where FF FF FD FD would be
    plain = PacketHandler(2.0).removeStuffing(list(packets.encode_status(1, error, value)))
    length = plain[5] | plain[6] << 8
    assert bytes(plain[9 : 7 + length - 2]) == value


def test_a_header_that_nobody_stuffed_ends_the_packet_before():
    """The SDK sends such; a servo takes the inner header for a new packet, and so do we."""
    body = bytes((Instruction.WRITE, 116, 0)) + b"\xff\xff\xfd\xff"
    frame = packets.HEADER + bytes((1, len(body) + 2, 0)) + body
    frame += packets.crc16(frame).to_bytes(2, "little")
    decoder = Decoder()
    assert decoder.feed(frame + packets.encode(1, Instruction.PING)) == [
        Packet(1, Instruction.PING)
    ]


def test_reset_forgets_a_packet_whose_rest_never_came():
    decoder = Decoder()
    assert decoder.feed(packets.encode(1, Instruction.PING)[:-1]) == []
    assert decoder.pending == 9
    decoder.reset()
    assert (decoder.pending, decoder.noise_bytes) == (0, 9)


def test_a_wrong_crc_is_counted():
    frame = bytearray(packets.encode(1, Instruction.PING))
    frame[-1] ^= 1
    decoder = Decoder()
    assert decoder.feed(bytes(frame)) == []
    assert decoder.crc_errors == 1


@pytest.mark.parametrize("servo_id", [-1, 255])
def test_encode_refuses_an_id_that_is_none(servo_id):
    with pytest.raises(ValueError, match="servo_id"):
        packets.encode(servo_id, Instruction.PING)


def test_encode_refuses_more_than_a_packet_can_carry():
    with pytest.raises(ValueError, match="4096"):
        packets.encode(1, Instruction.WRITE, bytes(packets.MAX_LENGTH))


@pytest.mark.parametrize("frame", [b"", b"\xff\xff\xfd\x00\x01", packets.encode(1, 1) * 2])
def test_decode_refuses_what_is_not_one_packet(frame):
    with pytest.raises(ValueError, match="one whole packet"):
        packets.decode(frame)
