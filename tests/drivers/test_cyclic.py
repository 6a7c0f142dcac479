import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers import packets
from splinearm.drivers.bus import Loss, Reply
from splinearm.drivers.cyclic import GroupRead
from splinearm.drivers.groups import BulkRead, FastBlock
from splinearm.drivers.packets import Instruction
from splinearm.drivers.registers import load_table

IDS = (3, 7, 4)
GOAL = load_table("XM430-W350")["Goal Position"]
FAR_GOAL = load_table("PH42-020-S300")["Goal Position"]
answers = st.lists(
    st.tuples(st.binary(min_size=10, max_size=10), st.integers(0, 255)), min_size=3, max_size=3
)


def group(*, fast: bool, lengths=(10, 10, 10)) -> GroupRead:
    requests = [BulkRead(i, 126, length) for i, length in zip(IDS, lengths, strict=True)]
    return GroupRead(requests, fast=fast)


def plain(values) -> list[bytes]:
    pairs = zip(IDS, values, strict=True)
    return [packets.encode_status(i, error, data) for i, (data, error) in pairs]


def fast(values) -> list[bytes]:
    pairs = zip(IDS, values, strict=True)
    return packets.fast_reply_pieces([FastBlock(i, error, data) for i, (data, error) in pairs])


def expected(values) -> dict[int, Reply]:
    return {i: Reply(data, error) for i, (data, error) in zip(IDS, values, strict=True)}


@pytest.mark.property
@given(values=answers)
def test_answers_are_understood_whole(values):
    assert group(fast=False).parse(b"".join(plain(values))) == (expected(values), False)
    assert group(fast=True).parse(b"".join(fast(values))) == (expected(values), False)


@pytest.mark.property
@given(values=answers, noise=st.binary(max_size=12).filter(lambda b: 0xFF not in b))
def test_answers_are_found_behind_noise(values, noise):
    assert group(fast=False).parse(noise + b"".join(plain(values))) == (expected(values), False)
    assert group(fast=True).parse(noise + b"".join(fast(values))) == (expected(values), False)


@pytest.mark.property
@given(values=answers, cut=st.integers(0, 62))
def test_until_all_has_come_more_is_awaited(values, cut):
    for one, frame in ((group(fast=False), plain(values)), (group(fast=True), fast(values))):
        wire = b"".join(frame)
        replies, more = one.parse(wire[: min(cut, len(wire) - 1)])
        assert more
        for servo_id, reply in replies.items():
            assert reply.loss is not None or reply == expected(values)[servo_id]


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_one_dead_servo_does_not_blind_the_others(missing):
    values = [(bytes(range(10)), 0)] * 3
    frames = plain(values)
    del frames[missing]
    replies, more = group(fast=False).parse(b"".join(frames))
    assert more
    for k, servo_id in enumerate(IDS):
        assert replies[servo_id].loss is (Loss.SILENT if k == missing else None)


def test_a_damaged_answer_is_told_from_none():
    values = [(bytes(10), 0)] * 3
    frames = plain(values)
    frames[1] = frames[1][:-1] + b"\x00"
    replies, more = group(fast=False).parse(b"".join(frames))
    assert [replies[i].loss for i in IDS] == [None, Loss.DAMAGED, None]
    assert not more
    pieces = fast(values)
    pieces[1] = pieces[1][:-1] + b"\x00"
    replies, more = group(fast=True).parse(b"".join(pieces))
    assert [replies[i].loss for i in IDS] == [None, Loss.DAMAGED, None]
    assert not more


def test_of_those_after_a_lost_one_a_fast_answer_says_nothing():
    replies, _ = group(fast=True).parse(fast([(bytes(10), 0)] * 3)[0])
    assert [replies[i].loss for i in IDS] == [None, Loss.SILENT, Loss.HIDDEN]


def test_a_refusal_is_told_with_its_error():
    frames = plain([(bytes(10), 0)] * 3)
    frames[2] = packets.encode_status(4, 7)
    replies, more = group(fast=False).parse(b"".join(frames))
    assert replies[4] == Reply(b"", 7, Loss.REFUSED)
    assert not more


def test_an_echo_of_the_request_is_no_answer():
    values = [(bytes(10), 0)] * 3
    for one, frames in ((group(fast=False), plain(values)), (group(fast=True), fast(values))):
        wire = one.request + b"".join(frames)
        assert one.parse(wire) == (expected(values), False)
        assert one.parse(wire[: one.reply_length])[1]


def test_a_lost_servo_is_asked_last_from_then_on():
    one = group(fast=True)
    replies = expected([(bytes(10), 0)] * 3)
    one.learn(replies | {3: Reply(b"", 0, Loss.SILENT)})
    assert one.ids == (7, 4, 3)
    assert one.fast
    request = packets.decode(one.request)
    assert packets.parse_sync_read(request.params) == (126, 10, (7, 4, 3))


def test_a_bus_that_does_not_answer_fast_reads_is_asked_plainly():
    one = group(fast=True)
    good = expected([(bytes(10), 0)] * 3)
    nothing = {i: Reply(b"", 0, Loss.SILENT) for i in IDS}
    for attempt in range(3):
        assert one.fast
        one.learn(nothing)
        assert not one.fast
        one.learn(good)
        assert one.fast is (attempt < 2)
    assert packets.decode(one.request).instruction == Instruction.SYNC_READ


def test_one_silent_fast_read_does_not_end_fast_reads():
    one = group(fast=True)
    good = expected([(bytes(10), 0)] * 3)
    for _ in range(5):
        one.learn({i: Reply(b"", 0, Loss.SILENT) for i in IDS})
        one.learn(good)
        assert one.fast
        one.learn(good)


def test_a_fast_answer_that_ends_early_is_cleared_up_by_a_plain_one():
    one = group(fast=True)
    good = expected([(bytes(10), 0)] * 3)
    silent = Reply(b"", 0, Loss.SILENT)
    one.learn(good | {7: silent, 4: silent})  # 7 is dead, and 4 waited for it
    assert (one.ids, one.fast) == (IDS, False)
    one.learn(good | {7: silent})
    assert (one.ids, one.fast) == ((3, 4, 7), True)
    one.learn(good | {7: silent})
    assert (one.ids, one.fast) == ((3, 4, 7), True)


@pytest.mark.parametrize("quick", [False, True])
def test_different_places_make_a_bulk_read(quick):
    one = group(fast=quick, lengths=(10, 4, 2))
    request = packets.decode(one.request)
    wanted = Instruction.FAST_BULK_READ if quick else Instruction.BULK_READ
    assert request.instruction == wanted
    values = [(bytes(10), 0), (bytes(4), 0), (bytes(2), 0)]
    wire = b"".join(fast(values) if quick else plain(values))
    assert one.parse(wire) == (expected(values), False)


def test_groups_without_servos_or_with_twins_are_refused():
    for ids in ((), (1, 1)):
        with pytest.raises(ValueError, match="requests"):
            GroupRead([BulkRead(i, 0, 1) for i in ids], fast=False)


@pytest.mark.property
@given(values=answers, data=st.data())
def test_of_a_damaged_answer_nothing_false_counts(values, data):
    for one, frames in ((group(fast=False), plain(values)), (group(fast=True), fast(values))):
        wire = bytearray(b"".join(frames))
        wire[data.draw(st.integers(0, len(wire) - 1))] ^= data.draw(st.integers(1, 255))
        replies, _ = one.parse(bytes(wire))
        lost = [i for i, reply in replies.items() if reply.loss is not None]
        assert len(lost) <= 1 or one.fast  # what an answer begins with is known, damaged or not
        good = {i: reply for i, reply in replies.items() if reply.loss is None}
        assert good.items() <= expected(values).items()


@pytest.mark.property
@given(values=answers)
def test_only_a_flawless_answer_counts_as_such_and_says_the_same(values):
    for one, frames in ((group(fast=False), plain(values)), (group(fast=True), fast(values))):
        wire = b"".join(frames)
        stuffed = len(wire) != one.reply_length
        assert one.is_flawless(wire) is not stuffed
        assert not one.is_flawless(wire[:-1] + bytes((wire[-1] ^ 1,)))
        if not stuffed:
            assert one.replies(wire) == expected(values)


def test_a_group_that_forgets_asks_as_at_first():
    one = group(fast=True)
    one.learn({i: Reply(b"", 0, Loss.SILENT) for i in IDS})
    assert (one.fast, one.settled) == (False, False)
    one.forget()
    assert (one.fast, one.settled) == (True, True)


def test_for_servos_that_were_lost_nobody_waits():
    for quick, rest in ((False, 2 * 21), (True, 8 + 2 * 14)):
        one = group(fast=quick)
        assert one.sure_length == one.reply_length
        good = expected([(bytes(10), 0)] * 3)
        one.learn(good | {7: Reply(b"", 0, Loss.SILENT)})
        assert one.sure_length == rest
        one.learn(good)
        assert one.sure_length == one.reply_length


@pytest.mark.property
@given(values=answers, at=st.integers(0, 7), change=st.integers(1, 255))
def test_a_damaged_beginning_costs_nothing(values, at, change):
    for one, frames in ((group(fast=False), plain(values)), (group(fast=True), fast(values))):
        wire = bytearray(b"".join(frames))
        wire[at] ^= change
        if len(wire) == one.reply_length:  # without stuffing everything is in its place
            assert one.parse(bytes(wire)) == (expected(values), False)


def test_servos_that_answered_damaged_are_asked_in_a_fast_read_again():
    one = group(fast=True)
    damaged = Reply(b"", 0, Loss.DAMAGED)
    for _ in range(4):
        one.learn(dict.fromkeys(IDS, damaged))
        assert one.fast
