"""Half duplex, ten bits a byte, in a time that is stepped."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.sim.line_fault import LineFaults
from splinearm.sim.voice import Reply
from splinearm.sim.wire import BITS_PER_BYTE, BUNDLE, Wire

BYTE = BITS_PER_BYTE / 1_000_000


def wire_of(**options) -> Wire:
    made = Wire(LineFaults(clock=lambda: 0.0), **options)
    made.byte_time = BYTE
    return made


def test_a_reply_is_due_when_its_last_byte_has_been_on_the_wire():
    wire = wire_of()
    assert wire.request(bytes(10), 1.0) == bytes(10)
    wire.reply(wire.sent_until, [Reply(bytes(20), 50e-6)])
    assert wire.due == pytest.approx(1.0 + 30 * BYTE + 50e-6)
    assert wire.take(wire.due - 1e-9) == b""
    assert wire.take(wire.due) == bytes(20)


def test_a_request_waits_for_the_one_before_it():
    wire = wire_of()
    wire.request(bytes(100), 0.0)
    wire.request(bytes(10), 1e-5)
    assert wire.sent_until == pytest.approx(110 * BYTE)


def test_replies_follow_each_other_each_after_its_delay():
    wire = wire_of()
    wire.request(bytes(10), 0.0)
    wire.reply(wire.sent_until, [Reply(b"a" * 300, 500e-6), Reply(b"b" * 300, 500e-6)])
    assert wire.due == pytest.approx(310 * BYTE + 500e-6)
    assert wire.take(wire.due) == b"a" * 300
    assert wire.due == pytest.approx(610 * BYTE + 1e-3)


def test_replies_close_to_each_other_are_delivered_together_when_the_last_is_there():
    wire = wire_of()
    wire.request(bytes(10), 0.0)
    wire.reply(wire.sent_until, [Reply(bytes((k,)) * 15, 0.0) for k in range(6)])
    assert wire.due == pytest.approx(100 * BYTE)
    assert wire.take(wire.due) == b"".join(bytes((k,)) * 15 for k in range(6))


@pytest.mark.property
@settings(deadline=None)  # the computer may be busy
@given(st.lists(st.tuples(st.integers(1, 200), st.integers(0, 500)), min_size=1, max_size=12))
def test_nothing_is_delivered_early_and_no_bundle_is_long(shape):
    wire = wire_of()
    wire.request(b"?", 0.0)
    wire.reply(wire.sent_until, [Reply(bytes(n), delay * 1e-6) for n, delay in shape])
    begun = end = wire.sent_until
    ends = []
    for n, delay in shape:
        end += delay * 1e-6 + n * BYTE
        ends.append((end - n * BYTE, end))
    delivered = 0
    while wire.due < float("inf"):
        due = wire.due
        count = len(wire.take(due))
        total = 0
        for (start, end), (n, _) in zip(ends, shape, strict=True):
            total += n
            if delivered < total <= delivered + count:
                assert end <= due + 1e-9
                assert start >= due - max(BUNDLE, end - start) - 1e-9
        delivered += count
    assert delivered == sum(n for n, _ in shape)
    assert begun == pytest.approx(BYTE)


@pytest.mark.parametrize("tick", [0.001, 0.016])
def test_a_usb_adapter_holds_replies_back_to_its_next_tick(tick):
    wire = wire_of(usb_latency=tick)
    wire.request(bytes(10), 0.1 * tick)
    wire.reply(wire.sent_until, [Reply(b"a", 0.0), Reply(b"b", 0.0), Reply(b"c", tick)])
    assert wire.due == pytest.approx(tick)
    assert wire.take(tick) == b"ab"
    assert wire.due == pytest.approx(2 * tick)


def test_a_request_that_clashes_with_a_reply_garbles_both():
    wire = wire_of()
    wire.request(bytes(10), 0.0)
    wire.reply(wire.sent_until, [Reply(bytes(20), 0.0)])
    start = 25 * BYTE
    assert not wire.is_free(start, start + 8 * BYTE)
    heard = wire.request(bytes(8), start)
    assert [k for k, byte in enumerate(heard) if byte] == [0, 1, 2, 3, 4]
    reply = wire.take(1.0)
    assert [k for k, byte in enumerate(reply) if byte] == [15, 16, 17, 18, 19]


def test_a_request_after_a_reply_garbles_nothing():
    wire = wire_of()
    wire.request(bytes(10), 0.0)
    wire.reply(wire.sent_until, [Reply(bytes(20), 0.0)])
    due = wire.due
    assert wire.take(due) == bytes(20)
    assert wire.request(bytes(8), due) == bytes(8)
    assert wire.is_free(due, due + 8 * BYTE)


def test_what_is_sent_along_with_a_request_clashes_with_its_reply():
    wire = wire_of()
    wire.request(bytes(30), 0.0)
    wire.reply(10 * BYTE, [Reply(bytes(30), 0.0)])
    assert [k for k, byte in enumerate(wire.take(1.0)) if byte] == list(range(20))


def test_two_replies_at_once_garble_each_other():
    wire = wire_of()
    wire.request(bytes(10), 0.0)
    wire.reply(wire.sent_until, [Reply(bytes(4), 1e-3)])
    wire.request(bytes(10), wire.sent_until)
    wire.reply(wire.sent_until, [Reply(bytes(4), 1e-3 - 8 * BYTE)])
    first, second = wire.take(1.0)[:4], wire.take(1.0)
    assert second == b""
    assert first[:2] == bytes(2)
    assert all(first[2:])


def test_bytes_that_take_no_time_never_clash():
    wire = Wire(LineFaults(clock=lambda: 0.0))
    wire.request(b"one", 1.0)
    wire.reply(wire.sent_until, [Reply(b"b", 1.0), Reply(b"a", 1.0)])
    assert wire.due == 1.0
    wire.request(b"two", 1.0)
    assert wire.take(1.0) == b"ba"


def test_an_echo_comes_when_the_request_is_out_before_its_reply():
    wire = wire_of()
    wire.request(b"?!", 0.0)
    wire.echo(b"?!")
    wire.reply(wire.sent_until, [Reply(b"ok", 0.0)])
    assert wire.due == pytest.approx(2 * BYTE)
    assert wire.take(1.0) == b"?!ok"
