"""Very many frames, of bytes that look like headers more often than not."""

from itertools import pairwise

import numpy as np
import pytest

from splinearm.drivers import packets
from splinearm.drivers.packets import Decoder, Instruction, Packet
from splinearm.drivers.registers import load_table
from splinearm.drivers.sending import Block, GroupWrite

TABLE = load_table("XM430-W350")
NASTY = np.frombuffer(b"\xff\xff\xff\xfd\xfd\x00\x55\x01\x02\xfe", dtype=np.uint8)
CHUNK = 1000


def check_chunk(rng: np.random.Generator) -> None:
    """Send a thousand frames in one stream that is cut anywhere, and get the same packets."""
    lengths = rng.integers(0, 30, CHUNK)
    bytes_of = np.where(
        rng.random(lengths.sum()) < 0.7,
        rng.choice(NASTY, lengths.sum()),
        rng.integers(0, 256, lengths.sum(), dtype=np.uint8),
    ).tobytes()
    ends = lengths.cumsum().tolist()
    sent = [
        Packet(i, Instruction.WRITE, bytes_of[end - length : end])
        for i, end, length in zip(
            rng.integers(0, 253, CHUNK).tolist(), ends, lengths.tolist(), strict=True
        )
    ]
    stream = b"".join(packets.encode(p.servo_id, p.instruction, p.params) for p in sent)
    cuts = [0, *np.sort(rng.integers(0, len(stream), 50)).tolist(), len(stream)]
    decoder = Decoder()
    came: list[Packet] = []
    for start, end in pairwise(cuts):
        came += decoder.feed(stream[start:end])
    assert came == sent
    assert (decoder.noise_bytes, decoder.crc_errors, decoder.pending) == (0, 0, 0)


def check_goals(rng: np.random.Generator) -> None:
    """Send goals with velocities for six servos; small negative numbers need stuffing."""
    fields = (TABLE["Goal Velocity"], TABLE["Goal Position"])
    writer = GroupWrite([Block(i, 224, fields) for i in range(6)])
    wanted = rng.integers(-800, 800, (CHUNK // 10, 12))
    for values in wanted.tolist():
        entries = packets.parse_sync_write(packets.decode(writer.frame(values)).params)[2]
        data = np.frombuffer(b"".join(block for _, block in entries), dtype="<i4")
        assert data.tolist() == values


def test_of_20_000_frames_none_is_malformed():
    rng = np.random.default_rng(1)
    for _ in range(20):
        check_chunk(rng)
        check_goals(rng)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_of_10_million_frames_none_is_malformed():
    rng = np.random.default_rng(2)
    for _ in range(10_000):
        check_chunk(rng)
