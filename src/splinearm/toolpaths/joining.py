"""Operations joined to one program: tools taken, spindle switched, the end."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ToolpathError

from .action import Action, Pause, Rapid, Spindle, ToolChange
from .cutter import Cutter
from .operation import Milled


def joined_program(parts: Sequence[tuple[Cutter, Milled]]) -> tuple[Action, ...]:
    """Give one program of operations, one after the other.

    A tool with a number above 0 is taken by it; the one with the number 0 is in the machine. The
    first way of each tool leads straight up: nobody knows where the machine is.

    Args:
        parts: Operations with their cutters.

    Raises:
        ToolpathError: If there is nothing to be done.
    """
    program = _Program()
    for cutter, milled in parts:
        if milled.actions:
            program.add(cutter, milled.actions)
    if program.taken is None:
        raise ToolpathError("nothing is left to be cut: see the notes of the operations")
    if program.taken.speed:
        program.actions.append(Spindle(speed=0.0))
    return (*program.actions, Pause(code="M2"))


@dataclass(slots=True, eq=False)
class _Program:
    """What a program does so far, the cutter in the machine, and where it is."""

    actions: list[Action] = field(default_factory=list)
    taken: Cutter | None = None
    place: FloatArray = field(default_factory=lambda: np.zeros(3))

    def add(self, cutter: Cutter, actions: Sequence[Action]) -> None:
        """Add an operation, which begins with a way straight up and one to its first place."""
        before = self.taken
        changed = before is None or cutter.number != before.number
        if changed:
            self._take(cutter)
        up, over, *rest = actions
        if not (isinstance(up, Rapid) and isinstance(over, Rapid)):
            raise TypeError("actions: want them to begin with ways straight up and over")
        if before is None:
            self.actions.append(up)
        elif changed:
            self.actions.append(Rapid(start=self.place, end=self.place))
        if cutter.speed and (changed or before is None or cutter.speed != before.speed):
            self.actions.append(Spindle(speed=cutter.speed))
        start = up.end if before is None else self.place
        self.actions += [replace(over, start=start), *rest]
        self.place = [action.end for action in actions if isinstance(action, Rapid)][-1]
        self.taken = cutter

    def _take(self, cutter: Cutter) -> None:
        if self.taken is not None:
            self.actions.append(Spindle(speed=0.0))
        if cutter.number:
            self.actions.append(ToolChange(tool=cutter.number))
