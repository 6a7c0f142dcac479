"""What a person sees while teaching: joints, the piece, what was taken, the keys."""

import time
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich.console import Group, RenderableType
from rich.live import Live
from rich.text import Text

from splinearm.teaching.session import Lesson

from .output import console, table

if TYPE_CHECKING:
    from splinearm.config import Cell

_REDRAWN = 0.2
"""Time between two pictures, s."""

_KEYS = "space  starts and stops a piece    u  takes back    enter  ends, and holds"
_GRIPPER = "g  closes the gripper, again: opens it"

_SHOWN = 6
"""So many of the last pieces are shown."""


class Board:
    """A live picture of a lesson, drawn when it is shown; in a with-block.

    Args:
        cell: The arm.
        carried: Whether its servos carry it.
    """

    def __init__(self, cell: "Cell", *, carried: bool) -> None:
        self._cell, self._carried = cell, carried
        self._live = Live(console=console, auto_refresh=False, transient=True)
        self._due = 0.0

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with suppress(OSError):  # of a terminal that is gone
            self._live.stop()

    def is_due(self) -> bool:
        """Tell whether it is time for another picture."""
        now = time.monotonic()
        if now < self._due:
            return False
        self._due = now + _REDRAWN
        return True

    def show(self, lesson: Lesson) -> None:
        """Draw how far a lesson is."""
        self._live.update(self._picture(lesson), refresh=True)

    def _picture(self, lesson: Lesson) -> RenderableType:
        names = self._cell.arm.joint_names
        q = ["-"] * len(names)
        if lesson.q is not None:
            q = [f"{value:.1f}" for value in self._cell.to_file_units(lesson.q)]
        joints = table(names, [q])
        first = max(len(lesson.pieces) - _SHOWN, 0)
        taken = [
            Text(f"{number}. {words}")
            for number, words in enumerate(lesson.pieces[first:], first + 1)
        ]
        chain = self._cell.chain
        has_gripper = chain is not None and any(servo.joint is None for servo in chain.servos)
        keys = f"{_KEYS}\n{_GRIPPER}" if has_gripper else _KEYS
        return Group(joints, self._state(lesson), *taken, Text(lesson.note), Text(keys, "dim"))

    def _state(self, lesson: Lesson) -> Text:
        """Say what the arm does, and what comes next."""
        if lesson.warning:
            return Text(lesson.warning, "bold red")
        if not lesson.recording:
            if self._carried:
                return Text("it is carried: lead it to where a piece begins, then press space")
            return Text("it holds: support it, then press space; it has NO TORQUE until the next")
        words = f"RECORDING {lesson.duration:.1f} s, {lesson.samples} samples"
        return Text(words if self._carried else f"{words}; NO TORQUE: support it", "bold red")
