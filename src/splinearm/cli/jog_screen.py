"""What ``splinearm jog`` shows: lines of text, drawn over those before."""

import os
import select
import sys
import textwrap
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.config import Cell
from splinearm.jogging.waypoint import pose_words
from splinearm.joints import JointKind

from .jog_key import Settings

_PATIENCE = 0.5
"""How long a terminal may take until it takes something again, s."""
_BAR = 21
_NOTE_LINES, _NOTE_WIDTH = 2, 79
"""A note has that much room, also on the narrowest terminals."""
_NEAR_DEG, _NEAR_MM = 5.0, 10.0
"""A joint that has less way left than this is marked."""

_JOINT_KEYS = ("up down  choose a joint (or 1-9)", "left right  move it - and +")
_TOOL_KEYS = (
    "up down  x + -    left right  y + -    r f  z + -",
    "o u  turn about x + -    k i  about y + -    j l  about z + -",
)
_KEYS = (
    "tab  joints, tool in base, tool in itself    m  hold or steps",
    "+ -  speed    [ ]  step    space  brake    w  save this place",
)
_FEW = "with {n} joints the tool keeps its way first and turns along where it must"
_ENDS = "q, esc, Ctrl-C  brake, hold and end"
_GRIPPER = "g  close the gripper    G  open it"
_MODES = {"joints": "one joint", "base": "tool, axes of the base", "tool": "tool, its own axes"}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class View:
    """What there is to show."""

    cell: Cell
    """The arm."""
    where: str
    """What moves."""
    settings: Settings
    """What was chosen."""
    q: FloatArray
    """Where the joints are, shape (n,), rad or m."""
    moving: bool
    """Whether the arm moves."""
    note: str
    """What is in the way, or was last said."""
    brakes: str
    """How it stops, in words."""
    has_gripper: bool
    """Whether there is a gripper that moves."""


def lines(view: View) -> list[str]:
    """Give the screen, line by line."""
    chosen = view.settings
    what = _MODES[chosen.mode]
    if chosen.stepping:
        how = f"a key is one step of {chosen.step_mm:g} mm or {chosen.step_deg:g} deg"
    else:
        how = "moves while a key is held"
    return [
        f"jog {view.cell.name}: {view.where}",
        f"{what}; {how}; {chosen.speed_mm:g} mm/s, {chosen.speed_deg:g} deg/s",
        _FEW.format(n=view.cell.arm.n) if chosen.frame and view.cell.arm.n < 6 else "",
        *_joints(view),
        "",
        f"tool in base  {pose_words(view.cell, view.q)}",
        f"the arm {'moves' if view.moving else 'holds'}; {view.brakes}",
        *_note(view.note),
        *(_JOINT_KEYS if chosen.mode == "joints" else _TOOL_KEYS),
        *_KEYS,
        *([_GRIPPER] if view.has_gripper else []),
        _ENDS,
    ]


def _joints(view: View) -> list[str]:
    """Give a line a joint: where it is between its limits, and how far it may still go."""
    cell, chosen = view.cell, view.settings
    limits = cell.arm.limits
    places = (view.q, limits.q_min, limits.q_max)
    now, low, high = (np.round(cell.to_file_units(q), 1) + 0.0 for q in places)
    width = max(5, *(len(name) for name in limits.names))
    rows = [f"    {'joint':{width}}      now    lowest   highest   left to go"]
    for k, name in enumerate(limits.names):
        slides = limits.kinds[k] is JointKind.PRISMATIC
        mark = ">" if chosen.mode == "joints" and k == chosen.joint else " "
        left = min(now[k] - low[k], high[k] - now[k])
        close = "  near its limit" if left < (_NEAR_MM if slides else _NEAR_DEG) else ""
        rows.append(
            f"{mark} {k + 1} {name:{width}} {now[k]:8.1f}  {low[k]:8.1f}  {high[k]:8.1f} "
            f"{left:8.1f} {'mm ' if slides else 'deg'}  {_bar(now[k], low[k], high[k])}{close}"
        )
    return rows


def _note(words: str) -> list[str]:
    """Give a note in so many lines, whatever it says."""
    shown = textwrap.wrap(words, _NOTE_WIDTH, max_lines=_NOTE_LINES, placeholder=" ...")
    return [*shown, *[""] * (_NOTE_LINES - len(shown)), ""]


def _bar(value: float, low: float, high: float) -> str:
    if not np.isfinite([low, high]).all():
        return ""
    at = round((value - low) / (high - low) * (_BAR - 1))
    cells = ["-"] * _BAR
    cells[min(max(at, 0), _BAR - 1)] = "#"
    return f"[{''.join(cells)}]"


class Screen:
    """Draws lines over those before, in a with-block that leaves the terminal as it was.

    A terminal that takes nothing, as one beyond a line that is stuck, holds nobody up: what it does
    not take is not shown.

    Args:
        file: The file descriptor of a terminal.
    """

    def __init__(self, file: int) -> None:
        self._name = os.ttyname(file)
        self._file = -1

    def __enter__(self) -> "Screen":
        # opened once more: that nobody waits for it must not hold for who else writes to it
        self._file = os.open(self._name, os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
        # another page of the terminal, without a cursor
        self._write("\x1b[?1049h\x1b[?25l\x1b[2J")
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):  # of a terminal that is gone
            select.select((), [self._file], (), _PATIENCE)
            self._write("\x1b[0m\x1b[?25h\x1b[?1049l")
        os.close(self._file)

    def draw(self, rows: Sequence[str]) -> None:
        """Show lines, as many and as much of each as there is room for."""
        columns, height = _size_of(self._file)
        text = "".join(f"{row[: columns - 1]}\x1b[K\r\n" for row in rows[: height - 1])
        self._write(f"\x1b[H{text}\x1b[J")

    def _write(self, text: str) -> None:
        data = text.encode()
        with suppress(BlockingIOError):
            while data:
                data = data[os.write(self._file, data) :]


def _size_of(file: int) -> tuple[int, int]:
    """Give columns and lines of a terminal; one on a serial line may not say how many it has."""
    try:
        columns, height = os.get_terminal_size(file)
    except OSError:
        columns, height = 0, 0
    return columns or 80, height or 24


def screen_file() -> int:
    """Give the terminal to draw on: standard output, else standard input, which is one."""
    for stream in (sys.stdout, sys.stderr):
        if stream.isatty():
            return stream.fileno()
    return sys.stdin.fileno()
