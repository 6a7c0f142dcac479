"""Both protocols in one stream of bytes, however it is cut and whatever lies between."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.drivers import packets_v1
from splinearm.drivers.packets import HEADER, Instruction, Packet, encode
from splinearm.sim.ear import PACKET_GAP, PACKET_GAP_1, Ear

SHORT_OF_A_GAP = 1e-3

ids = st.integers(0, 0xFD)
tricky = st.one_of(
    st.binary(max_size=40),
    st.lists(st.sampled_from([b"\xff", b"\xfd", b"\x00", b"\x02", HEADER, b"\xff\xff"])).map(
        b"".join
    ),
)
packets = st.builds(Packet, ids, st.sampled_from(sorted({1, 2, 3, 4, 5, 6, 8})), tricky)


def frame(protocol: int, packet: Packet) -> bytes:
    made = packets_v1.encode if protocol == 1 else encode
    return made(packet.servo_id, packet.instruction, packet.params)


def heard(ear: Ear, data: bytes) -> list[tuple[int, Packet]]:
    return [(h.protocol, h.packet) for h in ear.feed(data) if not h.damaged]


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(st.lists(st.tuples(st.sampled_from([1, 2]), packets), min_size=1, max_size=4), st.data())
def test_packets_of_both_protocols_are_told_apart_for_every_split(sent, data):
    # protocol 1.0 has no stuffing: what it carries may begin like a packet of 2.0 and hide a next
    sent = [(p, q) for p, q in sent if p == 2 or HEADER not in frame(1, q) + b"\xff\xff\xfd"]
    stream = b"".join(frame(*each) for each in sent)
    ear, got, start = Ear(), [], 0
    while start < len(stream):
        end = start + data.draw(st.integers(1, len(stream)))
        got += heard(ear, stream[start:end])
        start = end
    assert [each for each in got if each in sent] == got == sent


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(packets)
def test_what_a_packet_carries_is_never_taken_for_a_packet_of_the_other_protocol(inner):
    carried = packets_v1.encode(inner.servo_id, inner.instruction, inner.params)
    outer = Packet(3, Instruction.WRITE, b"\x40\x00" + carried)
    assert heard(Ear(), frame(2, outer)) == [(2, outer)]


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(st.binary(max_size=60), packets, st.sampled_from([1, 2]))
def test_after_noise_and_a_gap_the_next_packet_is_heard(noise, packet, protocol):
    ear = Ear()
    ear.feed(noise)
    ear.pause(PACKET_GAP_1)
    assert heard(ear, frame(protocol, packet))[-1:] == [(protocol, packet)]


def test_lengths_and_places_are_those_of_the_bytes():
    one, two = frame(1, Packet(1, 1)), frame(2, Packet(2, 3, b"\x74\x00\xff\xff\xfd\xff"))
    found = Ear().feed(b"\x07" + one + two + two + b"\xff")
    assert [(h.protocol, h.length, h.after) for h in found] == [
        (1, len(one), 2 * len(two) + 1),
        (2, len(two), len(two) + 1),
        (2, len(two), 1),
    ]


def test_a_packet_that_ends_like_a_header_begins_is_heard_at_once():
    packet = next(p for k in range(256) if frame(1, p := Packet(k, 3, b"\x03\x00"))[-1] == 0xFF)
    assert heard(Ear(), frame(1, packet)) == [(1, packet)]


@pytest.mark.parametrize(("protocol", "gap"), [(1, PACKET_GAP_1), (2, PACKET_GAP)])
def test_a_gap_within_a_packet_loses_it_and_a_shorter_pause_does_not(protocol, gap):
    whole = frame(protocol, Packet(1, 2, b"\x00\x00\x02\x00"[: 2 * protocol]))
    for pause, want in ((gap * 0.9, 1), (gap, 0)):
        ear = Ear()
        assert ear.feed(whole[:5]) == []
        assert ear.patience is not None
        ear.pause(pause)
        assert len(heard(ear, whole[5:])) == want
        ear.pause(gap)
        assert len(heard(ear, whole)) == 1


def test_a_header_of_protocol_2_without_its_rest_hides_protocol_1_for_a_gap_only():
    ear, ping = Ear(), Packet(4, Instruction.PING)
    assert ear.feed(HEADER + b"\x01\x20\x00" + frame(1, ping)) == []
    assert [h.packet for h in ear.pause(PACKET_GAP)] == [ping]
    assert ear.patience is None


@pytest.mark.parametrize("protocol", [1, 2])
def test_a_damaged_packet_is_told_by_its_id(protocol):
    good = frame(protocol, Packet(9, Instruction.PING))
    found = Ear().feed(good[:-1] + bytes((good[-1] ^ 1,)))
    assert [(h.protocol, h.packet.servo_id) for h in found if h.damaged] == [(protocol, 9)]


def test_a_broken_packet_does_not_hide_the_next():
    good = frame(2, Packet(1, Instruction.PING))
    for end in range(1, len(good)):
        assert heard(Ear(), good[:end] + good)[-1] == (2, Packet(1, Instruction.PING))


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(st.lists(st.one_of(tricky, packets.map(lambda p: frame(1, p))), max_size=12))
def test_no_bytes_confuse_it(chunks):
    ear = Ear()
    for chunk in chunks:
        for found in ear.feed(chunk):
            assert found.protocol in (1, 2)
            assert found.after >= 0
        ear.pause(SHORT_OF_A_GAP)
    ear.pause(PACKET_GAP_1)
    ear.pause(PACKET_GAP_1)
    assert ear.patience is None
