"""Drilling and boring cycles: G73 and G81 to G89.

Source: Kramer, Proctor, Messina, NISTIR 6556, 2000, 3.5.16; LinuxCNC, "Canned Cycles".
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray

from .action import Action, Dwell, Feed, Rapid, Spindle
from .gcode_line import Line
from .gcode_modal import Code, written
from .gcode_state import State
from .gcode_way import Way

CYCLES = frozenset((730, 810, 820, 830, 840, 850, 860, 890))
"""Cycles that are understood."""

_MOST_PECKS = 100_000
"""So often may one line go down."""

_CHIP = 0.254e-3
"""How far a peck backs off: 0.010 inch, m."""

_DWELLS, _PECKS = (820, 840, 860, 890), (730, 830)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """A cycle in force; its words hold until it ends."""

    code: Code
    """Which it is."""
    depth: float
    """The Z word, m."""
    clear: float
    """The R word, m."""
    begun: float
    """How high the tool was when the first of a series of cycles began, m."""
    dwell: float = 0.0
    """How long it rests at the bottom, s."""
    peck: float = 0.0
    """How deep a peck is, m."""

    @classmethod
    def read(cls, line: Line, code: Code, before: "Cycle | None", state: State) -> "Cycle":
        """Give the cycle of a line; words that are missing are as they were.

        Raises:
            GcodeError: If a word is missing that none was before.
        """
        unit, name = state.modes.unit, written("g", code)
        if state.modes.axis != 2:
            raise line.refuse(name, "works in the plane G17 only")
        if state.modes.side:
            raise line.refuse(name, "goes not together with a tool beside its way (G41)")

        def word(letter: str, kept: float | None, scale: float) -> float:
            value = line.take(letter)
            if value is not None:
                return value * scale
            if kept is None:
                raise line.refuse(letter.upper(), f"is missing: {name} wants it")
            return kept

        kept = (
            (None,) * 4
            if before is None
            else (
                before.depth,
                before.clear,
                before.dwell,
                before.peck,
            )
        )
        depth, clear = word("z", kept[0], unit), word("r", kept[1], unit)
        dwell = word("p", kept[2], 1.0) if code in _DWELLS else 0.0
        peck = word("q", kept[3], unit) if code in _PECKS else 0.0
        if code in _PECKS and peck <= 0.0:
            raise line.refuse("Q", f"want a depth above 0, got {peck / unit:g}")
        begun = float(state.position[2]) if before is None else before.begun
        return cls(code=code, depth=depth, clear=clear, begun=begun, dwell=dwell, peck=peck)


def drill(cycle: Cycle, line: Line, state: State) -> Iterator[Action]:
    """Give the moves of a cycle at the places of a line.

    Raises:
        GcodeError: If R is below Z, or the feed is missing.
    """
    yield from _Driller(cycle, line, state).moves()


class _Driller:
    def __init__(self, cycle: Cycle, line: Line, state: State) -> None:
        self.cycle, self.line, self.state = cycle, line, state

    def moves(self) -> Iterator[Action]:
        state, cycle, line = self.state, self.cycle, self.line
        absolute, unit = state.modes.absolute, state.modes.unit
        times = line.whole("l", 1) if "l" in line.values else 1
        given = {axis: value for axis, value in line.places(unit).items() if axis != 2}
        before = float(state.position[2])
        clear = cycle.clear + (state.offset[2] if absolute else before)
        bottom = cycle.depth + (state.offset[2] if absolute else clear)
        if bottom > clear:
            raise line.refuse("R", "is below the bottom of the hole; it must be above Z")
        pecks = times * ((clear - bottom) / cycle.peck if cycle.code in _PECKS else 1.0)
        if not pecks <= _MOST_PECKS:
            raise line.refuse("", f"drills {pecks:.3g} times; at most {_MOST_PECKS}")
        if before < clear:
            yield from self._rapid(z=clear)
        back = max(cycle.begun, clear) if state.modes.retract_to_start else clear
        for _ in range(times):
            if state.modes.retract_to_start:
                yield from self._rapid(z=back)
            place = state.position.copy()
            for axis, value in given.items():
                place[axis] = value + state.offset[axis] if absolute else place[axis] + value
            yield from self._rapid(x=place[0], y=place[1])
            yield from self._rapid(z=clear)
            yield from self._down(clear, bottom)
            yield from self._up(clear, back)

    def _down(self, clear: float, bottom: float) -> Iterator[Action]:
        cycle = self.cycle
        deep = clear
        while cycle.code in _PECKS and deep - cycle.peck > bottom:
            deep -= cycle.peck
            yield from self._feed(deep)
            if cycle.code == 830:
                yield from self._rapid(z=clear)
                yield from self._rapid(z=deep + _CHIP)
            else:
                yield from self._rapid(z=deep + _CHIP)
        yield from self._feed(bottom)
        if cycle.dwell > 0.0:
            yield Dwell(line=self.line.number, time=cycle.dwell)

    def _up(self, clear: float, back: float) -> Iterator[Action]:
        code, modes = self.cycle.code, self.state.modes
        if code in (850, 890):
            yield from self._feed(clear)
        elif code in (840, 860):
            turning = modes.spindle * modes.speed
            if not turning:
                raise self.line.refuse(written("g", code), "wants a spindle that turns (M3 or M4)")
            turned = -turning if code == 840 else 0.0
            yield Spindle(line=self.line.number, speed=turned)
            yield from self._feed(clear) if code == 840 else self._rapid(z=back)
            yield Spindle(line=self.line.number, speed=turning)
        yield from self._rapid(z=back)

    def _rapid(self, **to: float) -> Iterator[Action]:
        target = self._moved(**to)
        if (target != self.state.position).any():
            yield Rapid(line=self.line.number, start=self.state.position, end=target)
            self.state.position = target

    def _feed(self, z: float) -> Iterator[Action]:
        target = self._moved(z=z)
        if (target != self.state.position).any():
            cut = Way(self.state).cut(self.line)
            yield Feed(start=self.state.position, end=target, **cut)
            self.state.position = target

    def _moved(self, **to: float) -> FloatArray:
        target = np.array(self.state.position)
        for letter, value in to.items():
            target["xyz".index(letter)] = value
        return target
