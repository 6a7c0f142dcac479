"""Single keys of a terminal, and the terminal that tests look at."""

import os
import signal
import sys
import termios
import threading
import time
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.cli.keyboard import Keyboard
from splinearm.errors import ConfigError, TerminalLostError

NAMED = {
    b"\x1b[A": "up",
    b"\x1b[B": "down",
    b"\x1bOC": "right",
    b"\x1b[D": "left",
    b"\x1b[1;2A": "shift-up",
    b"\x1b[1;5C": "ctrl-right",
    b"\x1b[1;8D": "ctrl-alt-shift-left",
    b"\x1b[H": "home",
    b"\x1b[4~": "end",
    b"\x1b[3~": "delete",
    b"\x1b[5;3~": "alt-pageup",
    b"\x1bOP": "f1",
    b"\x1b[15~": "f5",
    b"\x1b[Z": "shift-tab",
    b"\r": "enter",
    b"\t": "tab",
    b"\x7f": "backspace",
    b"\x01": "ctrl-a",
    b"\x1a": "ctrl-z",
    b"\x00": "ctrl-space",
    b"\x13": "ctrl-s",
    b" ": " ",
    b"Q": "Q",
    "ö".encode(): "ö",
    b"[": "[",
}


@pytest.fixture
def pair():
    """Both ends of a terminal: that of the person, that of the program."""
    ends = list(os.openpty())
    yield ends
    for end in ends:
        if end >= 0:
            os.close(end)


def _all(keys: Keyboard) -> list[str]:
    found = []
    while (key := keys.read(0.0)) is not None:
        found.append(key)
    return found


@pytest.mark.property
@given(st.lists(st.sampled_from(sorted(NAMED)), max_size=12), st.data())
def test_keys_are_the_same_however_their_bytes_are_cut(chosen, data):
    master, slave = os.openpty()
    sent = b"".join(chosen)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(sent)), max_size=3)))
    try:
        with Keyboard(slave) as keys:
            found = []
            for start, end in zip([0, *cuts], [*cuts, len(sent)], strict=True):
                os.write(master, sent[start:end])
                if sent[start:end]:
                    keys._receive(1.0)
                while (key := keys._take()) is not None:
                    found.append(key)
        assert found == [NAMED[piece] for piece in chosen]
    finally:
        os.close(master)
        os.close(slave)


@pytest.mark.parametrize(
    ("sent", "keys"),
    [
        (b"\x1b", ["esc"]),
        (b"\x1b\x1b[A", ["esc", "up"]),
        (b"\x1bx", ["esc", "x"]),
        (b"\x1b[", ["esc", "["]),
        (b"\x1b[<0;3;4Ma", ["a"]),  # a mouse
        (b"\x1b[99~a", ["a"]),
        (b"\xffa", ["�", "a"]),
    ],
)
def test_esc_is_told_from_what_begins_with_it(pair, sent, keys):
    with Keyboard(pair[1]) as keyboard:
        os.write(pair[0], sent)
        assert _all(keyboard) == keys


def test_a_key_is_waited_for_no_longer_than_said(pair):
    with Keyboard(pair[1]) as keyboard:
        begun = time.monotonic()
        assert keyboard.read(0.05) is None
        assert time.monotonic() - begun >= 0.05
        threading.Timer(0.05, os.write, (pair[0], b"k")).start()
        assert keyboard.read(10.0) == "k"


def test_the_terminal_is_given_back_as_it_was(pair):
    before = termios.tcgetattr(pair[1])
    handlers = [signal.getsignal(number) for number in (signal.SIGHUP, signal.SIGTERM)]
    with suppress(KeyError), Keyboard(pair[1]):
        now = termios.tcgetattr(pair[1])
        assert not now[3] & (termios.ECHO | termios.ICANON)
        assert now[3] & termios.ISIG
        assert now[6][termios.VSUSP] == b"\x00"
        os.write(pair[0], b"typed and not read")
        raise KeyError
    assert termios.tcgetattr(pair[1]) == before
    assert [signal.getsignal(number) for number in (signal.SIGHUP, signal.SIGTERM)] == handlers
    with Keyboard(pair[1]) as keyboard:
        assert keyboard.read(0.0) is None


def test_a_terminal_that_is_closed_is_lost(pair):
    with Keyboard(pair[1]) as keyboard:
        os.close(pair[0])
        pair[0] = -1
        with pytest.raises(TerminalLostError, match="closed"):
            keyboard.read(10.0)


def test_a_hang_up_wakes_who_waits_and_reaches_who_listened_before(pair, monkeypatch):
    heard = []
    before = signal.signal(signal.SIGHUP, lambda *_: heard.append("before"))
    try:
        with Keyboard(pair[1]) as keyboard:
            threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGHUP)).start()
            with pytest.raises(TerminalLostError):
                keyboard.read(10.0)
    finally:
        signal.signal(signal.SIGHUP, before)
    assert heard == ["before"]


def test_a_request_to_end_leaves_the_block(pair):
    threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGTERM)).start()
    with pytest.raises(SystemExit, match="143"), Keyboard(pair[1]) as keyboard:
        keyboard.read(10.0)


@pytest.mark.parametrize("given", [None, "pipe"])
def test_what_is_no_terminal_is_refused(given):
    ends = os.pipe()
    try:
        with (
            pytest.raises(ConfigError, match="no terminal"),
            Keyboard(None if given is None else ends[0]),
        ):
            pass
    finally:
        for end in ends:
            os.close(end)


ECHO = """
from splinearm.cli.keyboard import Keyboard
with Keyboard() as keys:
    print("ready", flush=True)
    while (key := keys.read(10.0)) != "q":
        print(f"<{key}>", end="", flush=True)
"""


def test_a_command_in_a_terminal_is_seen_and_typed_to(terminal):
    seen = terminal("-c", ECHO, command=[sys.executable], rows=6, columns=30)
    seen.wait_for("ready")
    seen.type("a ")
    seen.press("up", "enter")
    assert seen.wait_for("<enter>") == "<enter>"
    assert seen.screen == "ready\n<a>< ><up><enter>"
    seen.press("q")
    assert seen.exit_code == 0


def test_its_loss_and_its_signals_reach_the_command(terminal):
    both = [terminal("-c", ECHO, command=[sys.executable]) for _ in range(2)]
    for each in both:
        each.wait_for("ready")
    both[0].hang_up()
    both[1].press("ctrl-c")
    assert "KeyboardInterrupt" in both[1].wait_for("KeyboardInterrupt")
    assert both[0].exit_code == 1
    assert both[1].exit_code == -signal.SIGINT
