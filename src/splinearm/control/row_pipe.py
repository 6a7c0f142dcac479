"""The near end of the pipe to a process that writes rows to a file.

A thread of this process would not do: it takes turns with the loop, and where other programs keep
it from its turn while it holds Python's lock, the loop waits as long. A process of its own costs
the loop one write to a pipe. It also outlives this one: of a program that is killed no row is lost.
"""

import logging
import os
import subprocess
import sys
from collections import deque
from collections.abc import Sequence
from typing import IO

import numpy as np

from .cycle import Cycle
from .row import HEAD, row_length

_log = logging.getLogger(__name__)

_ROOM = 1 << 20
_PATIENCE = 10.0
"""How long the writing process may take in the end, s."""


class RowPipe:
    """Hands cycles to a process that writes them to a file; never waits for it.

    What the pipe has no room for stays in memory and goes out in a later cycle, or at the end.
    """

    def __init__(self, module: str, words: Sequence[str], n: int, file: IO[bytes]) -> None:
        """Start the process.

        Args:
            module: The module of this room that it runs.
            words: What that is told.
            n: Number of joints.
            file: Where it writes; this process must not write there any more.
        """
        self._n = n
        self._row = np.empty(row_length(n))
        self._waiting: deque[bytes] = deque()
        self._name = file.name
        self.delayed = 0
        """Rows for which the pipe had no room at once; they were written later."""
        self._process = subprocess.Popen(
            [sys.executable, "-m", f"{__package__}.{module}", *words],
            stdin=subprocess.PIPE,
            stdout=file,
            stderr=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
            start_new_session=True,  # Ctrl-C is for us; it ends when the pipe does
        )
        assert self._process.stdin is not None  # noqa: S101 - a pipe was asked for
        self._pipe = self._process.stdin.fileno()
        self._broken = False
        os.set_blocking(self._pipe, False)
        _enlarge(self._pipe)

    def send(self, cycle: Cycle) -> None:
        """Hand over one cycle."""
        row, n = self._row, self._n
        wanted, state = cycle.setpoint, cycle.state
        row[:HEAD] = (cycle.index, cycle.t, wanted.t, cycle.lateness, cycle.busy)
        parts = row[HEAD:].reshape(-1, n)
        parts[0], parts[1], parts[2] = wanted.q, wanted.qd, wanted.qdd
        if state is None:
            parts[3:] = np.nan
        else:
            parts[3], parts[4], parts[5] = state.q, state.qd, state.current
        self._waiting.append(row.tobytes())
        self._push()

    def _push(self) -> None:
        """Write what the pipe has room for."""
        while self._waiting and not self._broken:
            data = self._waiting.popleft()
            try:
                sent = os.write(self._pipe, data)
            except BlockingIOError:
                sent = 0
            except OSError as error:
                self._break(error)
                return
            if sent < len(data):
                self._waiting.appendleft(data[sent:])
                self.delayed += 1
                return

    def _break(self, error: OSError) -> None:
        """Go on without a file: the arm matters more."""
        self._broken = True
        self._waiting.clear()
        _log.warning("the rows in %s are not whole: %s", self._name, error)

    def close(self) -> bool:
        """Let everything be written; give whether it was."""
        if not self._broken:
            os.set_blocking(self._pipe, True)
            self._push()
        try:
            _, complaint = self._process.communicate(timeout=_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            _, complaint = self._process.communicate()
        if self._process.returncode != 0:
            last = complaint.decode(errors="replace").strip().splitlines()[-1:]
            why = last[0] if last else f"its writer ended with {self._process.returncode}"
            _log.warning("the rows in %s are not whole: %s", self._name, why)
        return self._process.returncode == 0 and not self._broken


def _enlarge(pipe: int) -> None:
    """Give the pipe room for seconds of rows, if the system allows it."""
    if sys.platform != "linux":
        return
    import fcntl

    try:
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, _ROOM)
    except OSError as error:
        _log.debug("the pipe keeps its size: %s", error)
