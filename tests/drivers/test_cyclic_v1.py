import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers import packets_v1 as v1
from splinearm.drivers.bus import Loss, Reply
from splinearm.drivers.cyclic_v1 import BulkReadV1, GroupWriteV1, OneRead
from splinearm.drivers.groups import BulkRead
from splinearm.drivers.packets import ALERT_BIT, Instruction, encode_status
from splinearm.drivers.registers import load_table
from splinearm.drivers.sending import Block

IDS = (3, 7, 4)
GOAL = load_table("AX-12A")["Goal Position"]
answers = st.lists(st.binary(min_size=6, max_size=6), min_size=3, max_size=3)


def group() -> BulkReadV1:
    return BulkReadV1([BulkRead(i, 36, 6) for i in IDS])


def frames(values) -> list[bytes]:
    return [v1.encode_status(i, 0, data) for i, data in zip(IDS, values, strict=True)]


def expected(values) -> dict[int, Reply]:
    return {i: Reply(data) for i, data in zip(IDS, values, strict=True)}


def test_a_bulk_read_is_asked_as_the_manual_says():
    packet = v1.Decoder(status=False).feed(group().request)[0]
    assert packet.instruction == Instruction.BULK_READ
    assert packet.params == bytes((0, 6, 3, 36, 6, 7, 36, 6, 4, 36))


@pytest.mark.property
@given(values=answers, noise=st.binary(max_size=6).filter(lambda b: 0xFF not in b))
def test_answers_are_understood_also_behind_noise_and_echo(values, noise):
    one, wire = group(), b"".join(frames(values))
    assert one.is_flawless(wire)
    assert one.replies(wire) == expected(values)
    for before in (b"", noise, one.request):
        assert one.parse(before + wire) == (expected(values), False)


@pytest.mark.property
@given(values=answers, data=st.data())
def test_of_a_damaged_answer_nothing_false_counts(values, data):
    wire = bytearray(b"".join(frames(values)))
    wire[data.draw(st.integers(0, len(wire) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    replies, _ = group().parse(bytes(wire))
    good = {i: reply.data for i, reply in replies.items() if reply.loss is None}
    assert good.items() <= {i: r.data for i, r in expected(values).items()}.items()
    assert len(good) < 3


def test_lost_and_damaged_answers_and_refusals_are_told_apart():
    parts = frames([bytes(6)] * 3)
    replies, more = group().parse(parts[0] + parts[2][:-1])
    assert [replies[i].loss for i in IDS] == [None, Loss.SILENT, Loss.DAMAGED]
    assert more
    replies, _ = group().parse(parts[0] + v1.encode_status(7, 0x40) + parts[2])
    assert replies[7] == Reply(b"", 2, Loss.REFUSED)


def test_a_fault_of_the_servo_is_an_alert_that_keeps_its_bits():
    parts = frames([bytes(6)] * 3)
    parts[1] = v1.encode_status(7, 0x24, bytes(6))
    reply = group().replies(b"".join(parts))[7]
    assert (reply.error & 0xFF, reply.error >> 8, reply.loss) == (ALERT_BIT, 0x24, None)


@pytest.mark.parametrize("protocol", [1, 2])
def test_one_servo_is_read_in_either_protocol(protocol):
    one = OneRead(BulkRead(5, 36, 6), protocol)
    status = v1.encode_status if protocol == 1 else encode_status
    wire = status(5, 0, b"abcdef")
    assert one.reply_length == len(wire)
    assert one.is_flawless(wire)
    assert one.replies(wire) == {5: Reply(b"abcdef")}
    assert one.parse(one.request + wire) == ({5: Reply(b"abcdef")}, False)
    assert one.parse(b"") == ({5: Reply(b"", 0, Loss.SILENT)}, True)
    assert one.parse(wire[:-1])[0][5].loss is Loss.DAMAGED


@pytest.mark.property
@given(values=st.lists(st.integers(0, 1023), min_size=3, max_size=3))
def test_a_sync_write_says_every_value(values):
    frame = GroupWriteV1([Block(i, 30, (GOAL,)) for i in IDS]).frame(values)
    packet = v1.Decoder(status=False).feed(frame)[0]
    blocks = b"".join(bytes((i,)) + GOAL.encode(v) for i, v in zip(IDS, values, strict=True))
    assert (packet.instruction, packet.params) == (Instruction.SYNC_WRITE, bytes((30, 2)) + blocks)


def test_what_cannot_be_sent_is_refused():
    writer = GroupWriteV1([Block(i, 30, (GOAL,)) for i in IDS])
    for values in ([1, 2], [1, 2, 3, 4], [1, 2, 70_000]):
        with pytest.raises(ValueError, match="values"):
            writer.frame(values)
    with pytest.raises(ValueError, match="one place"):
        GroupWriteV1([Block(1, 30, (GOAL,)), Block(2, 32, (GOAL,))])
    with pytest.raises(ValueError, match="requests"):
        BulkReadV1([])
    with pytest.raises(ValueError, match=r"Protocol 1\.0"):
        OneRead(BulkRead(5, 300, 2), 1)
