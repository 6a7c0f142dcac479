"""Random frames by the million: our codec, a second one, and the line agree on every one of them.

What is sent is drawn so that it is full of what needs care: header bytes, marks that need stuffing.
The second codec is the manual's rules written down once more, here.
"""

import itertools
import random
import re

import pytest

from splinearm.drivers import packets_v1
from splinearm.drivers.model import servo_model
from splinearm.drivers.packets import (
    Decoder,
    Instruction,
    Packet,
    encode,
    encode_status,
    parse_fast_reply,
    sync_read_params,
    unstuff,
)
from splinearm.sim.ear import PACKET_GAP_1, Ear
from splinearm.sim.line import Line
from splinearm.sim.virtual_servo import VirtualServo

BATCH = 1000
SHARE, WHOLE = 80_000, 10_000_000
CARE = [b"\xff", b"\xff\xff", b"\xff\xff\xfd", b"\xfd", b"\x00", b"\xff\xff\xfd\x00", b"\x55"]
BARE = re.compile(rb"\xff\xff\xfd(?!\xfd)")
CRC_TABLE = []
for high in range(256):
    entry = high << 8
    for _ in range(8):
        entry = ((entry << 1) ^ 0x8005) & 0xFFFF if entry & 0x8000 else entry << 1
    CRC_TABLE.append(entry)


def crc_of(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ CRC_TABLE[crc >> 8 ^ byte]
    return crc


def is_well_formed(frame: bytes) -> bool:
    """Tell by the manual's words whether bytes are one frame of Protocol 2.0."""
    body = frame[7:-2]
    return (
        frame[:4] == b"\xff\xff\xfd\x00"
        and frame[5] | frame[6] << 8 == len(frame) - 7
        and not BARE.search(body)
        and crc_of(frame[:-2]) == frame[-2] | frame[-1] << 8
    )


def some_bytes(dice: random.Random, most: int) -> bytes:
    """Draw bytes that need care."""
    data = b""
    while len(data) < most and dice.random() < 0.85:
        data += dice.choice(CARE) if dice.random() < 0.6 else dice.randbytes(dice.randrange(1, 6))
    return data[:most]


def some_packet(dice: random.Random) -> Packet:
    return Packet(dice.randrange(253), dice.choice(INSTRUCTIONS), some_bytes(dice, 24))


INSTRUCTIONS = [1, 2, 3, 4, 5, 0x10, 0x82, 0x83, 0x92, 0x93]


def check_codec(count: int, seed: int) -> None:
    """Encode and decode so many frames, in streams that are cut anywhere."""
    dice = random.Random(seed)
    for _ in range(count // BATCH):
        sent = [some_packet(dice) for _ in range(BATCH)]
        frames = [encode(p.servo_id, p.instruction, p.params) for p in sent]
        assert all(map(is_well_formed, frames))
        stream = b"".join(frames)
        cuts = sorted(dice.sample(range(len(stream)), BATCH // 2))
        decoder, ear, got, heard = Decoder(), Ear(), [], []
        for start, end in itertools.pairwise([0, *cuts, len(stream)]):
            got += decoder.feed(stream[start:end])
            heard += ear.feed(stream[start:end])
        assert got == sent
        assert [each.packet for each in heard] == sent
        assert (decoder.crc_errors, decoder.noise_bytes, decoder.pending) == (0, 0, 0)


def a_line() -> Line:
    """Give a line of three servos, of which one speaks Protocol 1.0."""
    x = servo_model("XM430-W350")
    servos = [VirtualServo(x, settings={"ID": k}) for k in (1, 2)]
    old = {"ID": 3, "Protocol Type": 1}
    return Line([*servos, VirtualServo(x, settings=old)])


def some_request(dice: random.Random) -> tuple[int, bytes]:
    """Draw a request of either protocol: random ones, and reads, writes and groups that fit."""
    servo_id = dice.choice((1, 1, 2, 2, 3, 3, 4, 254))
    kind = dice.random()
    if kind < 0.3:
        at, size = dice.choice(((132, 4), (116, 4), (64, 2), (104, 4), (0, 147)))
        old = bytes((at, size))
        new = at.to_bytes(2, "little") + size.to_bytes(2, "little")
        code = Instruction.READ
    elif kind < 0.6:
        at, size = dice.choice(((116, 4), (104, 4), (65, 1), (224, 8)))
        data = (some_bytes(dice, size) + bytes(size))[:size]
        old, new = bytes((at,)) + data, at.to_bytes(2, "little") + data
        code = Instruction.WRITE
    elif kind < 0.8:
        code = dice.choice((Instruction.SYNC_READ, Instruction.FAST_SYNC_READ))
        servo_id, old = 254, b""
        new = sync_read_params(126, 10, dice.sample((1, 2, 3), dice.randrange(1, 4)))
    else:
        code, old = dice.choice(INSTRUCTIONS), some_bytes(dice, 16)
        new = old
    if dice.random() < 0.3 and code not in (Instruction.SYNC_READ, Instruction.FAST_SYNC_READ):
        return 1, packets_v1.encode(servo_id, code, old)
    return 2, encode(servo_id, code, new)


def check_reply(protocol: int, packet: Packet, data: bytes) -> None:
    """Check that what comes back is made of good frames, by the second codec."""
    if protocol == 1:
        replies = packets_v1.Decoder(status=True).feed(data)
        lengths = sum(6 + len(reply.params) for reply in replies)
        assert lengths == len(data)
    elif packet.instruction == Instruction.FAST_SYNC_READ and data:
        blocks = parse_fast_reply(data, [(k, 10) for k in packet.params[4:]])
        assert 8 + 14 * len(blocks) == len(data)
    else:
        decoder = Decoder()
        replies = decoder.feed(data)
        assert (decoder.crc_errors, decoder.noise_bytes, decoder.pending) == (0, 0, 0)
        for reply in replies:
            assert is_well_formed(encode_status(reply.servo_id, reply.error, reply.params))


def check_line(count: int, seed: int) -> None:
    """Send so many requests over a line, some of them broken, and check every answer."""
    dice, line, ear = random.Random(seed), a_line(), Ear()
    for _ in range(count):
        protocol, frame = some_request(dice)
        fate = dice.random()
        if fate < 0.1:  # damaged, and then a pause
            at = dice.randrange(len(frame))
            broken = frame[:at] + bytes((frame[at] ^ dice.randrange(1, 256),)) + frame[at + 1 :]
            ear.feed(broken)
            ear.pause(PACKET_GAP_1)
            ear.pause(PACKET_GAP_1)
        elif fate < 0.2:  # cut short by a pause
            ear.feed(frame[: dice.randrange(len(frame))])
            ear.pause(PACKET_GAP_1)
            ear.pause(PACKET_GAP_1)
        heard = [each for each in ear.feed(frame) if not each.damaged]
        assert [each.protocol for each in heard] == [protocol]
        assert heard[0].length == len(frame)
        packet = heard[0].packet
        if packet.instruction == Instruction.WRITE and packet.servo_id == 254:
            continue  # it would write ids and baud rates, and leave nobody to answer
        replies = line.answer(packet, 57_600, protocol)
        for reply in replies if protocol == 1 or packet.instruction != 0x8A else ():
            check_reply(protocol, packet, reply.data)
        if packet.instruction == Instruction.FAST_SYNC_READ:
            check_reply(protocol, packet, b"".join(reply.data for reply in replies))
        for servo in line.servos:  # nobody's id or rate may have been written by chance
            servo.memory["Baud Rate"] = 1
        for servo, servo_id in zip(line.servos, (1, 2, 3), strict=True):
            servo.memory["ID"] = servo_id


def test_no_frame_is_malformed_and_every_one_comes_back():
    check_codec(SHARE, seed=1)


def test_no_answer_of_the_line_is_malformed():
    check_line(SHARE // 4, seed=1)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("part", range(8))
def test_ten_million_frames_through_codec_and_line(part):
    check_codec(WHOLE // 8, seed=100 + part)
    check_line(WHOLE // 8, seed=200 + part)


def test_the_second_codec_knows_a_bad_frame():
    good = encode(1, 3, b"\x74\x00\xff\xff\xfd\xff")
    assert is_well_formed(good)
    assert unstuff(good[7:-2])[3:] == b"\xff\xff\xfd\xff"
    bare = b"\xff\xff\xfd\x00\x01\x09\x00\x03\x74\x00\xff\xff\xfd\xff"
    assert not is_well_formed(bare + crc_of(bare).to_bytes(2, "little"))
    assert not is_well_formed(good[:-1] + bytes((good[-1] ^ 1,)))
