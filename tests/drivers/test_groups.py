from itertools import accumulate

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers import groups
from splinearm.drivers.groups import BulkRead, BulkWrite, FastBlock

ids = st.integers(0, 252)
addresses = st.integers(0, 1023)
blocks = st.lists(
    st.builds(FastBlock, ids, st.integers(0, 255), st.binary(min_size=1, max_size=12)),
    min_size=1,
    max_size=6,
    unique_by=lambda block: block.servo_id,
)


def wanted_of(answer):
    return [(block.servo_id, len(block.data)) for block in answer]


@pytest.mark.property
@given(address=addresses, data=st.binary(min_size=1, max_size=20))
def test_single_reads_and_writes_come_back(address, data):
    assert groups.parse_read(groups.read_params(address, len(data))) == (address, len(data))
    assert groups.parse_write(groups.write_params(address, data)) == (address, data)


@pytest.mark.property
@given(address=addresses, chosen=st.lists(ids, min_size=1, unique=True), data=st.data())
def test_sync_reads_and_writes_come_back(address, chosen, data):
    length = data.draw(st.integers(1, 8))
    entries = {i: data.draw(st.binary(min_size=length, max_size=length)) for i in chosen}
    written = groups.sync_write_params(address, length, entries)
    assert groups.parse_sync_write(written) == (address, length, tuple(entries.items()))
    read = groups.sync_read_params(address, length, chosen)
    assert groups.parse_sync_read(read) == (address, length, tuple(chosen))


@pytest.mark.property
@given(st.lists(st.builds(BulkWrite, ids, addresses, st.binary(max_size=8)), min_size=1))
def test_bulk_reads_and_writes_come_back(entries):
    assert groups.parse_bulk_write(groups.bulk_write_params(entries)) == tuple(entries)
    requests = tuple(BulkRead(i, address, len(data)) for i, address, data in entries)
    assert groups.parse_bulk_read(groups.bulk_read_params(requests)) == requests


@pytest.mark.property
@given(answer=blocks)
def test_a_whole_fast_answer_comes_back(answer):
    frame = b"".join(groups.fast_reply_pieces(answer))
    assert groups.parse_fast_reply(frame, wanted_of(answer)) == tuple(answer)


@pytest.mark.property
@given(answer=blocks, cut=st.integers(0, 120))
def test_of_a_fast_answer_cut_short_the_whole_blocks_count(answer, cut):
    pieces = groups.fast_reply_pieces(answer)
    frame = b"".join(pieces)[:cut]
    whole = sum(len(b"".join(pieces[: k + 1])) <= cut for k in range(len(pieces)))
    assert groups.parse_fast_reply(frame, wanted_of(answer)) == tuple(answer[:whole])


@pytest.mark.property
@given(answer=blocks, data=st.data())
def test_of_a_fast_answer_with_a_damaged_byte_only_the_block_it_is_in_is_lost(answer, data):
    pieces = groups.fast_reply_pieces(answer)
    frame = bytearray(b"".join(pieces))
    at = data.draw(st.integers(0, len(frame) - 1))
    frame[at] ^= data.draw(st.integers(1, 255))
    found = groups.parse_fast_reply(bytes(frame), wanted_of(answer))
    ends = list(accumulate(len(piece) for piece in pieces))
    hit = next(k for k, end in enumerate(ends) if at < end)
    header = at < 5 or at == 7
    assert found == (() if header else tuple(answer[:hit] + answer[hit + 1 :]))


@pytest.mark.property
@given(answer=blocks, data=st.data())
def test_of_a_fast_answer_with_many_damaged_bytes_nothing_false_counts(answer, data):
    frame = bytearray(b"".join(groups.fast_reply_pieces(answer)))
    for at in data.draw(st.lists(st.integers(0, len(frame) - 1), min_size=2, max_size=4)):
        frame[at] ^= data.draw(st.integers(1, 3))
    found = groups.parse_fast_reply(bytes(frame), wanted_of(answer))
    assert all(block in answer for block in found)


def test_a_servo_missing_in_the_middle_does_not_hide_those_after_it():
    present = [FastBlock(1, 0, b"ab"), FastBlock(3, 0, b"ef")]
    frame = b"".join(groups.fast_reply_pieces(present))
    assert groups.parse_fast_reply(frame, [(1, 2), (2, 2), (3, 2)]) == tuple(present)


@pytest.mark.parametrize(
    ("parse", "params"),
    [
        (groups.parse_read, b"abc"),
        (groups.parse_write, b"ab"),
        (groups.parse_sync_read, b"abcd"),
        (groups.parse_sync_write, b"abc"),
        (groups.parse_sync_write, b"\x00\x00\x02\x00\x01\x02"),
        (groups.parse_bulk_read, b"abcd"),
        (groups.parse_bulk_write, b"abcd"),
        (groups.parse_bulk_write, b"\x01\x00\x00\x04\x00\x01"),
    ],
)
def test_parameters_that_cannot_be_are_refused(parse, params):
    with pytest.raises(ValueError, match=r"want|left over"):
        parse(params)


def test_a_sync_write_refuses_data_of_another_length():
    with pytest.raises(ValueError, match="servo 2"):
        groups.sync_write_params(116, 4, {1: bytes(4), 2: bytes(3)})
