"""Single keys of a terminal, without Enter and without echo."""

import codecs
import os
import re
import select
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any, Self

from splinearm.errors import ConfigError, TerminalLostError

if sys.platform != "win32":
    import termios

_ESCAPE_TIME = 0.05
"""So long the rest of an arrow key may take after its Esc, s; through ssh it comes in pieces."""

_CHARACTERS = {
    "\x1b": "esc", "\r": "enter", "\n": "enter", "\t": "tab",
    "\x7f": "backspace", "\x08": "backspace",
}  # fmt: skip
_FINALS = {
    "A": "up", "B": "down", "C": "right", "D": "left", "H": "home", "F": "end", "Z": "shift-tab",
    "P": "f1", "Q": "f2", "R": "f3", "S": "f4",
}  # fmt: skip
_NUMBERS = {
    1: "home", 2: "insert", 3: "delete", 4: "end", 5: "pageup", 6: "pagedown", 7: "home", 8: "end",
    11: "f1", 12: "f2", 13: "f3", 14: "f4", 15: "f5", 17: "f6", 18: "f7", 19: "f8", 20: "f9",
    21: "f10", 23: "f11", 24: "f12",
}  # fmt: skip
# xterm's "PC-style function keys": a modifier counts one more than its bits
_MODIFIERS = ((4, "ctrl-"), (2, "alt-"), (1, "shift-"))

# a sequence as ECMA-48, section 5.4, has it, or a function key after Esc O; whole, then begun
_SEQUENCE = re.compile(r"\x1b(?:\[([0-9;<=>?]*)[ -/]*([@-~])|O([ -~]))")
_BEGUN = re.compile(r"\x1b(?:\[[0-9;<=>?]*[ -/]*|O)?\Z")

_Handler = Callable[[int, FrameType | None], Any] | int | None


class Keyboard:
    r"""The keys of a terminal, in a with-block that gives the terminal back as it was.

    Ctrl-C is still SIGINT; Ctrl-Z, Ctrl-\ and Ctrl-S are keys: an arm must not be left alone in
    the middle of a motion by one of them. Unless somebody else listens, SIGTERM leaves the
    with-block as ``SystemExit`` and SIGHUP as ``TerminalLostError``.

    Args:
        file: The terminal's file descriptor; None: standard input.

    Raises:
        ConfigError: On entering, if it is no terminal.
    """

    def __init__(self, file: int | None = None) -> None:
        self._given = file
        self._file = -1
        self._before: list[Any] = []
        self._handlers: dict[int, _Handler] = {}
        self._text = ""
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._lost = False
        self._woken, self._waker = -1, -1

    def __enter__(self) -> Self:
        self._file = _terminal(self._given)
        self._before = termios.tcgetattr(self._file)
        self._woken, self._waker = os.pipe()
        # only the main thread may have signal handlers
        if threading.current_thread() is threading.main_thread():
            self._listen()
        settings = _key_by_key(self._before, self._file)
        termios.tcsetattr(self._file, termios.TCSANOW, settings)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with suppress(termios.error):  # of a terminal that is gone
            termios.tcsetattr(self._file, termios.TCSANOW, self._before)
            termios.tcflush(self._file, termios.TCIFLUSH)  # what was not read is not for the shell
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._handlers.clear()
        os.close(self._woken)
        os.close(self._waker)

    def read(self, timeout: float) -> str | None:
        """Give the next key: the character it types, or its name; None: none came in time.

        Names are "enter", "esc", "tab", "backspace", "delete", "insert", "up", "down", "left",
        "right", "home", "end", "pageup", "pagedown", "f1" to "f12", "ctrl-a" to "ctrl-z", and those
        with "shift-", "alt-" or "ctrl-" before them, as far as terminals tell.

        Args:
            timeout: How long to wait for one, s.

        Raises:
            TerminalLostError: If the terminal was closed.
        """
        due = time.monotonic() + timeout
        while True:
            if self._lost:
                raise TerminalLostError
            key = self._take()
            if key is not None:
                return key
            begun = bool(self._text)  # by an Esc that may be an arrow key's
            left = _ESCAPE_TIME if begun else max(0.0, due - time.monotonic())
            if self._receive(left):
                continue
            if begun:
                self._text = self._text[1:]
                return "esc"
            if time.monotonic() >= due and not self._lost:
                return None

    def _receive(self, timeout: float) -> bool:
        """Wait for bytes; give whether some came."""
        ready, _, _ = select.select([self._file, self._woken], (), (), timeout)
        if self._file not in ready:
            return False
        try:
            data = os.read(self._file, 1024)
        except OSError as error:  # what a terminal says that hung up
            raise TerminalLostError from error
        if not data:
            raise TerminalLostError
        self._text += self._decoder.decode(data)
        return True

    def _take(self) -> str | None:
        """Take a whole key off the text; None: there is none, or one that may go on."""
        while self._text and not _BEGUN.match(self._text):
            whole = _SEQUENCE.match(self._text)
            if whole is None:
                character, self._text = self._text[0], self._text[1:]
                return _character(character)
            self._text = self._text[whole.end() :]
            name = _sequence(*whole.groups(""))
            if name:  # of others, as what a mouse says, nothing is known
                return name
        return None

    def _listen(self) -> None:
        """Hear of SIGHUP, besides whoever does already, and of a SIGTERM that nobody hears."""
        hang_up = signal.getsignal(signal.SIGHUP)
        if hang_up is not signal.SIG_IGN:

            def lost(number: int, frame: FrameType | None) -> None:
                self._lost = True
                os.write(self._waker, b"!")
                if callable(hang_up):
                    hang_up(number, frame)

            self._handlers[signal.SIGHUP] = signal.signal(signal.SIGHUP, lost)
        if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            self._handlers[signal.SIGTERM] = signal.signal(signal.SIGTERM, _leave)


def _leave(number: int, frame: FrameType | None) -> None:
    raise SystemExit(128 + number)


def _terminal(given: int | None) -> int:
    """Give the file descriptor of a terminal."""
    if sys.platform == "win32":
        raise ConfigError("the terminal", "", "single keys are known here for Linux and macOS only")
    try:
        file = sys.stdin.fileno() if given is None else given
        is_terminal = os.isatty(file)
    except (OSError, ValueError, AttributeError):  # closed, or something else put in its place
        file, is_terminal = -1, False
    if not is_terminal:
        raise ConfigError(
            "standard input", "", "is no terminal; start this in a terminal, without a pipe"
        )
    return file


def _key_by_key(before: list[Any], file: int) -> list[Any]:
    """Give the settings of a terminal that gives each key at once and shows none."""
    settings, control = list(before), list(before[6])
    settings[0] &= ~termios.IXON
    settings[3] &= ~(termios.ICANON | termios.ECHO | termios.IEXTEN)
    control[termios.VMIN], control[termios.VTIME] = 1, 0
    nothing = bytes([os.fpathconf(file, "PC_VDISABLE")])
    for name in ("VSUSP", "VDSUSP", "VQUIT"):
        if hasattr(termios, name):
            control[getattr(termios, name)] = nothing
    settings[6] = control
    return settings


def _character(character: str) -> str:
    """Give the name of a key that sends one character."""
    if character in _CHARACTERS:
        return _CHARACTERS[character]
    if character < " ":
        return f"ctrl-{chr(ord(character) + 96)}" if 0 < ord(character) <= 26 else "ctrl-space"
    return character


def _sequence(parameters: str, final: str, function: str) -> str:
    """Give the name of a key that sends a sequence; "" if it is not known."""
    if function:
        return _FINALS.get(function, "")
    numbers = [int(word) if word.isdecimal() else 0 for word in parameters.split(";")]
    name = _NUMBERS.get(numbers[0], "") if final == "~" else _FINALS.get(final, "")
    if not name or len(numbers) < 2:
        return name
    bits = numbers[1] - 1
    return "".join(word for bit, word in _MODIFIERS if bits & bit) + name
