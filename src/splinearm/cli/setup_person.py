"""The person at the terminal, for commands that write into servos: tables, questions, cables."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from splinearm.errors import ConfigError

if TYPE_CHECKING:
    from rich.console import Console

    from splinearm.commissioning.bench import Found
    from splinearm.commissioning.task import Change, Task
    from splinearm.drivers.chain import ServoSpec


NARROW = 70
"""Columns that a table of registers needs."""


def counted(count: int, noun: str) -> str:
    """Give how many there are of something, as in "2 servos"."""
    return f"{count} {noun}" + ("" if count == 1 else "s")


def console_for(*, as_json: bool) -> "Console":
    """Give where to show things: beside the JSON, if there is one."""
    from .output import console

    if not as_json:
        return console
    from rich.console import Console

    return Console(stderr=True)


class TerminalPerson:
    """Shows what is to be written and asks whoever sits at the terminal.

    Args:
        console: Where to show things.
        yes: Whether not to ask before writing.
        release: Whether servos may lose their torque without asking.

    Raises:
        ConfigError: If something is to be asked and there is no terminal.
    """

    def __init__(self, console: "Console", *, yes: bool, release: bool) -> None:
        if not (yes or _is_attended()):
            raise ConfigError(
                "--yes", "", "there is no terminal to ask on; say --yes to write without asking"
            )
        self._console = console
        self._yes = yes
        self._release = release

    def tell(self, words: str) -> None:
        """Show a line, so that files and commands in it can be copied."""
        self._console.print(words, markup=False, highlight=False, soft_wrap=True)

    def agrees(self, tasks: "Sequence[Task]") -> bool:
        """Show every register that would be written, and ask."""
        for task in tasks:
            show_task(self._console, task)
        if self._yes:
            return True
        count = sum(len(task.changes) for task in tasks)
        servos = counted(len(tasks), "servo")
        what = f"Write {counted(count, 'register')} into {servos}" if count else f"Reboot {servos}"
        return self._asks(f"{what}? The tables as they are now are kept in a file first.")

    def allows(self, words: str) -> bool:
        """Ask about one thing."""
        return self._yes or self._asks(words)

    def lets_fall(self, names: Sequence[str]) -> bool:
        """Ask whether torque may go off."""
        if self._release:
            return True
        if self._yes and not _is_attended():
            return False
        return self._asks(
            f"The arm holds with torque ({', '.join(names)}). To write, servos lose it and joints "
            "may fall: is the arm supported, and may it go off?"
        )

    def connects(self, servo: "ServoSpec") -> None:
        """Say which servo is wanted."""
        self.tell(
            f"Connect only servo {servo.name} ({servo.model}, to be id {servo.servo_id}): no other "
            "that is not set up yet. Waiting for it; Ctrl-C ends, what is done stays done ..."
        )

    def connects_all(self, names: Sequence[str]) -> None:
        """Say which servos are wanted besides."""
        self.tell(f"Now connect all servos ({', '.join(names)} missing). Waiting for them ...")

    def is_it(self, servo: "ServoSpec", one: "Found") -> bool:
        """Ask who a servo is."""
        if self._yes:
            return False
        return self._asks(
            f"A servo that may be {servo.name} is connected now ({one.address}). Is it "
            f"{servo.name}, the one for {servo.joint or 'the gripper'}?"
        )

    def _asks(self, question: str) -> bool:
        """Ask; only a clear yes is one."""
        self._console.print(f"{question} [y/N]", markup=False, highlight=False, end=" ")
        return sys.stdin.readline().strip().lower() in ("y", "yes")


def _is_attended() -> bool:
    """Tell whether somebody can be asked; a program may be started without any input at all."""
    return sys.stdin is not None and sys.stdin.isatty()


def show_task(console: "Console", task: "Task") -> None:
    """Show what would be written into one servo: old and new value of every register."""
    from .output import table

    image = task.image
    title = f"{task.name}: {image.model.name}, firmware {image.found.firmware}, {image.address}"
    rows = [
        (
            change.register.name,
            str(change.register.address),
            _shown(task, change, change.old),
            _shown(task, change, change.new),
        )
        for change in task.changes
    ]
    rows += [("Hardware Error Status", "", error, "rebooted") for error in task.errors]
    if console.width < NARROW:  # no column of a table may be lost
        console.print(title, markup=False, highlight=False)
        for name, _, old, new in rows:
            console.print(f"  {name}: {old} -> {new}", markup=False, highlight=False)
    else:
        console.print(table(("register", "address", "old", "new"), rows, title=title))


def _shown(task: "Task", change: "Change", value: int) -> str:
    """Show a value of a register, with what it means where that is not plain."""
    if change.register.name == "Baud Rate":
        rate = task.image.model.baud_codes.get(value)
        return f"{value} ({rate} baud)" if rate else str(value)
    register = change.register
    if register.scale is not None and register.unit in ("us", "degC", "V"):
        return f"{value} ({value * register.scale:g} {register.unit})"
    return str(value)
