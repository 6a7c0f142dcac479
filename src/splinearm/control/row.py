"""Rows of numbers on a pipe: what the loop hands to the process that writes them down.

This module and those that run in that process load nothing but the standard library: they are there
before the arm moves.
"""

import os
import struct
import time
from collections.abc import Iterator
from typing import NamedTuple

HEAD = 5
"""Numbers before those of the joints."""

_PARTS = 6
_CHUNK = 1 << 20
_PAUSE = 0.05
"""Rows are taken from the pipe so often, in s: few wake-ups, and little is lost with a computer."""


class Row(NamedTuple):
    """One cycle, in SI; NaN where nothing was measured."""

    cycle: int
    """Number of the cycle."""
    t: float
    """When it was due, s since the loop began."""
    motion_t: float
    """Time along the motion, s."""
    lateness: float
    """By how much it began late, s."""
    busy: float
    """How long its work took, s."""
    joints: tuple[tuple[float, ...], ...]
    """Of each joint: wanted q, qd and qdd, measured q and qd, and the current."""


def row_length(n: int) -> int:
    """Give how many numbers a row of n joints has."""
    return HEAD + _PARTS * n


def read_rows(pipe: int, n: int) -> Iterator[list[Row]]:
    """Give what comes through a pipe, batch after batch, until its other end is closed."""
    form = struct.Struct(f"={row_length(n)}d")
    rest = b""
    while data := os.read(pipe, _CHUNK):
        rest += data
        whole = len(rest) - len(rest) % form.size
        yield [_row(values, n) for values in form.iter_unpack(rest[:whole])]
        rest = rest[whole:]
        time.sleep(_PAUSE)


def _row(values: tuple[float, ...], n: int) -> Row:
    parts = [values[HEAD + k * n : HEAD + (k + 1) * n] for k in range(_PARTS)]
    index, t, motion_t, lateness, busy = values[:HEAD]
    return Row(int(index), t, motion_t, lateness, busy, tuple(zip(*parts, strict=True)))
