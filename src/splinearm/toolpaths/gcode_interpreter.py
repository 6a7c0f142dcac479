"""NC programs with their meaning: what each line lets the machine do, in the order of the standard.

Source: Kramer, Proctor, Messina, The NIST RS274NGC Interpreter, Version 3, NISTIR 6556, 2000, with
the order of execution of table 8; LinuxCNC, "G-Codes" and "M-Codes", for what came later.
"""

from collections.abc import Iterator
from math import inf
from os import PathLike
from pathlib import Path

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GcodeError

from .action import Action, Dwell, Message, Pause, Rapid, Spindle, Switch, ToolChange
from .gcode_block import Block
from .gcode_cycle import CYCLES, Cycle, drill
from .gcode_flow import Program, Runner, beside, read_program
from .gcode_line import Line, read_line
from .gcode_machine import NcMachine, NcTool
from .gcode_memory import Memory, ParameterError
from .gcode_modal import MOTION, Code
from .gcode_origin import set_table, shift_origin
from .gcode_parameter import computed_parameters
from .gcode_state import INCH, MM, State
from .gcode_way import NurbsWay, Way

_HOMES = {280: 0, 300: 1, 281: 0, 301: 1}
_SYSTEMS = (540, 550, 560, 570, 580, 590, 591, 592, 593)
_UNITS = {200: INCH, 210: MM}
_PLANES = {170: 2, 180: 1, 190: 0}


def run_gcode(file: str | PathLike[str], machine: NcMachine | None = None) -> tuple[Action, ...]:
    """Give what an NC program lets a machine do.

    Args:
        file: The program. Subroutines that it calls by name may stand in files beside it.
        machine: What the machine knows; None: a machine in mm, without tools, all origins at 0.

    Raises:
        GcodeError: With line and word, if it says what cannot be understood or done.
    """
    path = Path(file)
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise GcodeError(str(file), 0, "", error.strerror or str(error)) from error
    program = read_program(text, str(file))
    return tuple(Interpreter(program, machine or NcMachine(), Path(file)).actions())


def run_gcode_text(text: str, machine: NcMachine | None = None) -> tuple[Action, ...]:
    """Give what the text of an NC program lets a machine do; see ``run_gcode``."""
    return tuple(Interpreter(read_program(text, "program"), machine or NcMachine()).actions())


class Interpreter:
    """A machine that reads a program.

    Args:
        program: The program.
        machine: The machine.
        file: Where the program stands; None: it has no neighbours.
    """

    def __init__(self, program: Program, machine: NcMachine, file: Path | None = None) -> None:
        self.state = State(machine)
        self.memory = Memory(computed_parameters(self.state, lambda: self.runner.returned))
        load = None if file is None else beside(file)
        self.runner = Runner(program, self.memory, load)
        self._ended = False
        self._cycle: Cycle | None = None
        self._way = Way(self.state)
        self._nurbs: NurbsWay | None = None

    def actions(self) -> Iterator[Action]:
        """Give what the machine does, in order.

        Raises:
            GcodeError: With line and word.
        """
        for file, block in self.runner.blocks():
            if block.optional and self.state.machine.block_delete:
                continue
            line = read_line(file, block, self.runner)
            yield from self._messages(block)
            self._settings(file, block)
            yield from self._line(line)
            if self._ended:
                break
        if self._nurbs is not None:
            raise GcodeError(self.runner.program.file, self._nurbs.line, "G5.2", "has no G5.3")

    def _messages(self, block: Block) -> Iterator[Action]:
        for comment in block.comments:
            kind, comma, text = comment.partition(",")
            if comma and kind.strip().lower() in ("msg", "print", "debug"):
                yield Message(line=block.line, text=text.strip())

    def _settings(self, file: str, block: Block) -> None:
        values = [self.runner.value(file, block, s.value, s.text) for s in block.settings]
        for setting, value in zip(block.settings, values, strict=True):
            target = setting.target
            try:
                if isinstance(target, str):
                    self.memory.set_named(target, value)
                else:
                    number = self.runner.value(file, block, target, setting.text)
                    self.memory.set_numbered(number, value)
            except ParameterError as fault:
                raise GcodeError(file, block.line, setting.text, str(fault)) from fault

    def _line(self, line: Line) -> Iterator[Action]:
        """Do a line in the order of the standard."""
        self._keep(line)
        modes = self.state.modes
        if "feed mode" in line.g:
            mode = line.g["feed mode"] // 10
            if mode != modes.feed_mode:
                modes.feed_mode, modes.feed = mode, 0.0
        yield from self._feed(line)
        yield from self._spindle_and_tools(line)
        yield from self._switches(line)
        if line.g.get("once") == 40:
            yield Dwell(line=line.number, time=line.at_least("p", 0.0, "G4 wants P, in seconds"))
        self._modes(line)
        yield from self._once(line)
        yield from self._motion(line)
        yield from self._pauses(line)
        line.require_all_used()

    def _feed(self, line: Line) -> Iterator[Action]:
        """Take an F word; beside a change of the unit machines read it unlike, which is told."""
        state = self.state
        if "f" not in line.values:
            return
        value = line.at_least("f", 0.0)
        unit = _UNITS.get(line.g.get("unit", 0), state.modes.unit)
        if unit != state.modes.unit:
            new = state.machine.feed_in_new_unit
            yield Message(
                line=line.number,
                text=f"{line.texts['f'].upper()} stands beside a change of the unit: taken in the "
                f"{'new' if new else 'old'} one; write the unit on a line before it",
            )
            if new:
                state.modes.unit = unit
        state.set_feed(value)

    def _spindle_and_tools(self, line: Line) -> Iterator[Action]:
        state, modes = self.state, self.state.modes
        if "s" in line.values:
            state.set_speed(line.at_least("s", 0.0))
        if "t" in line.values:
            state.selected = line.whole("t", 0)
        change = line.m.get("tool change")
        if change is not None:
            state.tool = state.selected if change == 60 else line.whole("q", 0, "M61 wants Q")
            if change == 60 and modes.spindle:
                modes.spindle = 0
            yield ToolChange(line=line.number, tool=state.tool)
        code = line.m.get("spindle")
        if code is not None:
            modes.spindle = {30: 1, 40: -1}.get(code, 0)
        if code is not None or ("s" in line.values and modes.spindle):
            yield Spindle(line=line.number, speed=modes.spindle * modes.speed)

    def _switches(self, line: Line) -> Iterator[Action]:
        for group in ("mist", "flood", "coolant off", "override", "output"):
            code = line.m.get(group)
            if code is not None:
                if group == "output":
                    line.drop("p", "e", "q")
                if group == "override":
                    line.drop("p")
                yield Switch(line=line.number, code=f"M{code // 10}")

    def _keep(self, line: Line) -> None:
        """Do M70 to M73: keep the modes and bring them back."""
        match line.m.get("state"):
            case 700 | 730:
                self.state.keep()
            case 710:
                self.state.kept.clear()
            case 720:
                if not self.state.kept:
                    raise line.refuse("M72", "no state was kept; write M70 before it")
                self.state.modes = self.state.kept.pop()

    def _modes(self, line: Line) -> None:
        """Put in force what holds from here on."""
        state, modes = self.state, self.state.modes
        modes.unit = _UNITS.get(line.g.get("unit", 0), modes.unit)
        if "plane" in line.g:
            modes.axis = _PLANES[line.g["plane"]]
        if "compensation" in line.g:
            self._compensation(line, line.g["compensation"])
        if "tool length" in line.g:
            self._tool_length(line, line.g["tool length"])
        if "coordinates" in line.g:
            self._still_straight(line, "coordinates")
            state.system = _SYSTEMS.index(line.g["coordinates"])
        if "path" in line.g:
            smooth = line.g["path"] == 640
            modes.blend = None
            if smooth:
                modes.blend = line.at_least("p", 0.0) * modes.unit if "p" in line.values else inf
                line.drop("q")
        if "distance" in line.g:
            modes.absolute = line.g["distance"] == 900
        if "arc distance" in line.g:
            modes.arc_absolute = line.g["arc distance"] == 901
        if "retract" in line.g:
            modes.retract_to_start = line.g["retract"] == 980

    def _compensation(self, line: Line, code: Code) -> None:
        modes = self.state.modes
        if code == 400:
            modes.side, modes.radius = 0, 0.0
            return
        if modes.side:
            raise line.refuse_group("compensation", "is in force already; write G40 first")
        if modes.axis == 0:
            raise line.refuse_group("compensation", "works in G17 and G18 only")
        if code in (411, 421):
            diameter = line.required("d", "the diameter of the tool") * modes.unit
        else:
            number = line.whole("d", 0) if "d" in line.values else self.state.tool
            diameter = self._tool(line, number).diameter
        modes.side = 1 if code in (410, 411) else -1
        modes.radius = 0.5 * diameter
        if modes.radius < 0.0:
            modes.side, modes.radius = -modes.side, -modes.radius

    def _tool_length(self, line: Line, code: Code) -> None:
        state = self.state
        before = state.tool_offset
        if code in (430, 432):
            number = line.whole("h", 0) if "h" in line.values else state.tool
            offset = np.array([0.0, 0.0, self._tool(line, number).length])
            state.tool_offset = before + offset if code == 432 else offset
        elif code == 431:
            state.tool_offset = line.ways(state.modes.unit, before)
        else:
            state.tool_offset = np.zeros(3)

    def _tool(self, line: Line, number: int) -> NcTool:
        if number == 0:
            return NcTool()
        if number not in self.state.tools:
            known = ", ".join(map(str, sorted(self.state.tools))) or "none"
            raise line.refuse("", f"tool {number} is not in the machine's table; there are {known}")
        return self.state.tools[number]

    def _still_straight(self, line: Line, group: str) -> None:
        if self.state.modes.side:
            raise line.refuse_group(group, "must not change while the tool is beside its way (G41)")

    def _once(self, line: Line) -> Iterator[Action]:
        """Do what holds for one line only."""
        code = line.g.get("once")
        if code == 100:
            set_table(line, self.state)
        elif code in (280, 300):
            yield from self._go_home(line, _HOMES[code])
        elif code in (281, 301):
            self.state.homes[_HOMES[code]] = self.state.position
        elif code is not None and code != 40:
            shift_origin(line, self.state, code)

    def _go_home(self, line: Line, index: int) -> Iterator[Action]:
        state = self.state
        given = sorted(line.axes)
        target = self._target(line)
        if given:
            yield from self._rapid(line, target)
        home = state.homes[index].copy()
        if given:
            kept = [axis for axis in range(3) if axis not in given]
            home[kept] = state.position[kept]
        yield from self._rapid(line, home)

    def _target(self, line: Line) -> FloatArray:
        """Give where the axis words lead, in machine coordinates, shape (3,), m."""
        state, modes = self.state, self.state.modes
        target = state.position.copy()
        for axis, value in line.places(modes.unit).items():
            if "machine" in line.g:
                if not modes.absolute:
                    raise line.refuse_group("machine", "wants G90")
                target[axis] = value
            elif modes.absolute:
                target[axis] = value + state.offset[axis]
            else:
                target[axis] += value
        return target

    def _rapid(self, line: Line, target: FloatArray) -> Iterator[Action]:
        state = self.state
        if (target != state.position).any():
            yield Rapid(line=line.number, start=state.position, end=target)
            state.position = target

    def _motion(self, line: Line) -> Iterator[Action]:
        """Move, if the line says so or has axis words that no other code has used."""
        state = self.state
        if MOTION in line.g:
            asked = line.g[MOTION]
            if state.motion != asked:
                self._cycle = None
            state.motion = None if asked == 800 else asked
        elif not line.moves:
            return
        code = state.motion
        if "machine" in line.g and code not in (0, 10):
            raise line.refuse_group("machine", "goes with G0 and G1 only")
        if code is None and line.axes:
            raise line.refuse("", "has coordinates, but no motion is in force after G80")
        if self._nurbs is not None and code not in (52, 53):
            raise line.refuse("", "stands between G5.2 and G5.3, where only control points may")
        if code is not None:
            yield from self._move(line, code)

    def _move(self, line: Line, code: Code) -> Iterator[Action]:
        if code == 0:
            yield from self._rapid(line, self._target(line))
        elif code in CYCLES:
            self._cycle = Cycle.read(line, code, self._cycle, self.state)
            yield from drill(self._cycle, line, self.state)
        elif code in (52, 53):
            yield from self._spline_point(line, code)
        else:
            yield from self._way.go(line, code, self._target)

    def _spline_point(self, line: Line, code: Code) -> Iterator[Action]:
        state = self.state
        if code == 52:
            if self._nurbs is None:
                self._nurbs = NurbsWay.begin(line, state)
            self._nurbs.add(line, self._target)
            return
        if self._nurbs is None:
            raise line.refuse("G5.3", "has no G5.2 before it")
        yield self._nurbs.finish(line, self._way)
        self._nurbs = None
        state.motion = None

    def _pauses(self, line: Line) -> Iterator[Action]:
        code = line.m.get("pause")
        if code is None or (code == 10 and not self.state.machine.optional_stop):
            return
        if code in (20, 300):
            self._ended = True
            if self.state.modes.spindle:
                self.state.modes.spindle = 0
                yield Spindle(line=line.number, speed=0.0)
        yield Pause(line=line.number, code=f"M{code // 10}")
