"""Job and arm files to spoil, the command line to feed them to, and a terminal to see it in."""

import fcntl
import os
import re
import select
import struct
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import pyte
import pytest

from splinearm.cli.main import main

JOB = """\
schema = "splinearm-job/1"
name = "triangle"
title = "Triangle"
arm = "planar_2r"
start_deg = [20.0, 40.0]

[motion]
through = "bspline"
speed_mm_s = 200.0

[[waypoint]]
position_mm = [350.0, 100.0, 60.0]

[[waypoint]]
position_mm = [250.0, 250.0, 60.0]

[[waypoint]]
joints_deg = [30.0, 60.0]
through = "joint"
"""

ARM = """\
schema = "splinearm-arm/1"
name = "mine"
title = "Two links of my own"
convention = "dh-standard"

[[joint]]
name = "shoulder"
a_mm = 200.0
alpha_deg = 0.0
d_mm = 50.0
theta_deg = 0.0
min_deg = -150.0
max_deg = 150.0
max_speed_deg_s = 180.0
max_acceleration_deg_s2 = 400.0
mass_kg = 0.2
com_mm = [-100.0, 0.0, 0.0]
inertia_kg_m2 = [1e-5, 7e-4, 7e-4, 0.0, 0.0, 0.0]

[[joint]]
name = "elbow"
a_mm = 150.0
alpha_deg = 0.0
d_mm = 0.0
theta_deg = 0.0
min_deg = -140.0
max_deg = 140.0
max_speed_deg_s = 180.0
max_acceleration_deg_s2 = 400.0
mass_kg = 0.15
com_mm = [-75.0, 0.0, 0.0]
inertia_kg_m2 = [1e-5, 3e-4, 3e-4, 0.0, 0.0, 0.0]

[bus]
baud = 1000000
supply_v = 12.0

[[servo]]
name = "shoulder"
id = 1
model = "XM430-W350"
role = "leader"
joint = "shoulder"
zero_ticks = 2048

[[servo]]
name = "elbow"
id = 2
model = "XM430-W350"
role = "leader"
joint = "elbow"
zero_ticks = 2048

[poses]
home_deg = [20.0, 40.0]
"""


class CommandLine:
    """Runs commands in a folder of their own and keeps what they printed."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder = folder
        self._capsys = capsys
        self.out = ""
        self.err = ""

    def __call__(self, *words: object) -> int:
        try:
            code = main([str(word) for word in words])
        except SystemExit as leaving:
            code = int(leaving.code or 0)
        self.out, self.err = self._capsys.readouterr()
        return code

    def write(self, name: str, text: str) -> Path:
        file = self.folder / name
        file.write_text(text, encoding="utf-8")
        return file

    def job(self, *changes: tuple[str, str]) -> Path:
        return self.write("job.toml", _changed(JOB, changes))

    def arm(self, *changes: tuple[str, str]) -> Path:
        return self.write("mine.toml", _changed(ARM, changes))

    def files(self) -> set[str]:
        return {file.name for file in self.folder.iterdir()}


def _changed(text: str, changes: tuple[tuple[str, str], ...]) -> str:
    for old, new in changes:
        if old not in text:
            raise AssertionError(f"{old!r} is not in the file")
        text = text.replace(old, new, 1)
    return text


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch) -> CommandLine:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    return CommandLine(tmp_path, capsys)


_KEYS = {
    "enter": "\r",
    "esc": "\x1b",
    "tab": "\t",
    "backspace": "\x7f",
    "space": " ",
    "up": "\x1b[A",
    "down": "\x1b[B",
    "right": "\x1b[C",
    "left": "\x1b[D",
    "ctrl-c": "\x03",
}


class Terminal:
    """A command in a terminal of its own, as a person sees it."""

    def __init__(self, command: Sequence[str], rows: int, columns: int, env: Mapping[str, str]):
        self._master, slave = os.openpty()
        self.resize(rows, columns)
        self._seen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self._seen)
        self._changed = threading.Condition()
        self._ends = False
        self.raw = b""
        # what says how wide this terminal is would be believed of the new one
        here = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "LINES")}
        # a session's leader gets the first terminal that it opens as its own: then it gets Ctrl-C
        opened = 'exec "$@" <>"$0" >&0 2>&1'
        self.process = subprocess.Popen(
            ["/bin/sh", "-c", opened, os.ttyname(slave), *command],
            env={**here, "TERM": "xterm-256color", **env},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self._slave = slave  # open until the command has ended: else its last words would be lost
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def screen(self) -> str:
        """What is on the screen, its lines without trailing blanks."""
        with self._changed:
            return "\n".join(line.rstrip() for line in self._seen.display).rstrip()

    def type(self, text: str) -> None:
        """Type a text."""
        os.write(self._master, text.encode())

    def press(self, *keys: str) -> None:
        """Press keys by their names, one after the other."""
        for key in keys:
            self.type(_KEYS.get(key, key))

    def wait_for(self, text: str, timeout: float = 20.0) -> str:
        """Wait until a text, or what a regular expression finds, is on the screen; give that."""
        due = time.monotonic() + timeout
        with self._changed:
            while True:
                shown = self.screen
                if text in shown:
                    return text
                if match := re.search(text, shown, re.MULTILINE):
                    return match[0]
                over = self.process.poll() is not None
                if not self._changed.wait(min(due - time.monotonic(), 0.3)) and (
                    over or time.monotonic() >= due
                ):
                    raise AssertionError(f"no {text!r} in {timeout} s on the screen:\n{shown}")

    def signal(self, number: int) -> None:
        """Send the command a signal."""
        self.process.send_signal(number)

    def resize(self, rows: int, columns: int) -> None:
        """Make the window larger or smaller."""
        fcntl.ioctl(self._master, termios.TIOCSWINSZ, struct.pack("4H", rows, columns, 0, 0))
        if hasattr(self, "_seen"):
            with self._changed:
                self._seen.resize(rows, columns)

    def hang_up(self) -> None:
        """Close the terminal while the command runs, as a window or an ssh that is gone."""
        self._end()

    @property
    def exit_code(self) -> int:
        """How the command ended, waited for; a signal that killed it counts below zero."""
        try:
            return self.process.wait(20.0)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"it does not end; on the screen:\n{self.screen}") from None

    def close(self) -> None:
        """Leave nothing behind."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self._end()

    def _end(self) -> None:
        if self._ends:
            return
        self._ends = True
        self._reader.join()
        os.close(self._slave)
        os.close(self._master)

    def _read(self) -> None:
        while not self._ends:
            ready, _, _ = select.select([self._master], (), (), 0.02)
            if not ready:
                continue
            data = os.read(self._master, 65536)
            with self._changed:
                self.raw += data
                self._stream.feed(data)
                self._changed.notify_all()


@pytest.fixture
def terminal():
    """Starts a command in a terminal; of ``splinearm``, unless a whole ``command`` is given."""
    opened: list[Terminal] = []

    def start(*words, command=None, rows=30, columns=100, env=None) -> Terminal:
        if command is None:
            command = [sys.executable, "-m", "splinearm"]
        whole = [*command, *(str(word) for word in words)]
        opened.append(Terminal(whole, rows, columns, env or {}))
        return opened[-1]

    yield start
    for each in opened:
        each.close()


SCREENS = Path(__file__).parents[2] / "docs" / "screens"
"""What pages show of terminals. To draw it anew: ``DRAW_SCREENS=1 pytest tests/cli/test_jog.py``,
``test_monitor.py`` and ``test_teach.py``."""


@pytest.fixture
def kept():
    """Compares a screen with the one that the pages show, but for numbers, bars and blanks."""

    def compare(name: str, screen: str) -> None:
        file = SCREENS / f"{name}.txt"
        port = re.compile(r"on (?:unix:)?/tmp/\S+?(?=,|$)", re.MULTILINE)
        shown = port.sub("on /dev/ttyUSB0", screen) + "\n"
        if os.environ.get("DRAW_SCREENS"):
            file.write_text(shown, encoding="utf-8")
        assert _structure(shown) == _structure(file.read_text(encoding="utf-8"))

    return compare


def _structure(screen: str) -> list[str]:
    plain = re.sub(r"-?\d+(\.\d+)?", "0", re.sub(r"\[[-#]+\]", "[]", screen))
    return [" ".join(line.split()) for line in plain.splitlines()]
