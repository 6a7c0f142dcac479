import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers import packets_v1
from splinearm.drivers.packets import Instruction, Packet

DATA = Path(__file__).parents[1] / "data" / "dynamixel_packets.json"
VECTORS = [v for v in json.loads(DATA.read_text())["vectors"] if v["protocol"] == 1]
BODIES = st.binary(max_size=20)


@pytest.mark.parametrize("vector", [v for v in VECTORS if v["tx"]], ids=lambda v: v["name"])
def test_what_the_host_sends_is_as_printed(vector):
    frame = bytes.fromhex(vector["tx"])
    (packet,) = packets_v1.Decoder(status=False).feed(frame)
    assert packet.instruction == Instruction[vector["instruction"].upper().replace(" ", "_")]
    assert packets_v1.encode(packet.servo_id, packet.instruction, packet.params) == frame


@pytest.mark.parametrize("vector", [v for v in VECTORS if v["rx"]], ids=lambda v: v["name"])
def test_what_servos_answer_is_as_printed(vector):
    for text in vector["rx"]:
        frame = bytes.fromhex(text)
        (packet,) = packets_v1.Decoder(status=True).feed(frame)
        assert packet.is_status
        assert packets_v1.encode_status(packet.servo_id, packet.error, packet.params) == frame


def test_overload_and_overheating_are_bits_of_the_error_byte():
    (packet,) = packets_v1.Decoder(status=True).feed(bytes.fromhex("FF FF 01 02 24 D8"))
    assert packet == Packet(1, Instruction.STATUS, b"", 0x24)


@pytest.mark.property
@given(
    stream=st.lists(st.tuples(st.integers(0, 253), st.integers(0, 255), BODIES), max_size=4),
    data=st.data(),
)
def test_packets_survive_every_cut_of_the_stream(stream, data):
    wire = b"".join(packets_v1.encode(*entry) for entry in stream)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(wire)), max_size=8)))
    decoder = packets_v1.Decoder(status=False)
    found = []
    for start, end in zip([0, *cuts], [*cuts, len(wire)], strict=True):
        found += decoder.feed(wire[start:end])
    assert [(p.servo_id, p.instruction, p.params) for p in found] == stream


def test_a_damaged_packet_is_skipped_and_counted():
    good = packets_v1.encode(1, Instruction.PING)
    decoder = packets_v1.Decoder(status=False)
    assert decoder.feed(good[:-1] + b"\x00" + good) == [Packet(1, Instruction.PING)]
    assert decoder.checksum_errors == 1


def test_reset_forgets_a_packet_whose_rest_never_came():
    good = packets_v1.encode(1, Instruction.PING)
    decoder = packets_v1.Decoder(status=False)
    assert decoder.feed(good[:-1]) == []
    decoder.reset()
    assert decoder.feed(good) == [Packet(1, Instruction.PING)]


def test_encode_refuses_what_does_not_fit():
    with pytest.raises(ValueError, match="servo_id"):
        packets_v1.encode(255, Instruction.PING)
    with pytest.raises(ValueError, match="250"):
        packets_v1.encode_status(1, 0, bytes(249))


@pytest.mark.parametrize(
    ("error", "number", "latched"),
    [
        (0x00, 0, 0x00),
        (0x02, 6, 0x00),
        (0x08, 4, 0x00),
        (0x10, 3, 0x00),
        (0x40, 2, 0x00),
        (0x20, 0, 0x20),
        (0x2D, 4, 0x25),
    ],
)
def test_errors_are_said_in_the_way_of_protocol_2(error, number, latched):
    modern = packets_v1.modern_error(error)
    assert modern & 0x7F == number
    assert bool(modern & 0x80) is bool(latched)
    assert modern >> 8 == latched
