"""NC programs as they run: subroutines, branches and loops of O words.

Source: LinuxCNC, "O Codes". A program is read into a tree of statements once; running it gives its
lines one after the other, for whoever knows what their words mean.
"""

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from pathlib import Path
from re import compile as pattern
from typing import NoReturn

from splinearm.errors import GcodeError

from .gcode_block import Block, Control, read_block
from .gcode_expression import NoValueError, Value
from .gcode_memory import Memory, ParameterError

DEEPEST_CALL = 10
"""So many subroutines may be under way within each other, as in LinuxCNC."""

DEEPEST_NEST = 100
"""So deep may branches and loops lie within each other."""

MOST_BLOCKS = 400_000
"""A program that goes through more lines than it has and these is taken to have no end."""

_END = pattern(r"m0*(2|30)(\.0*)?").fullmatch

_CLOSERS = {"sub": ("endsub",), "while": ("endwhile",), "repeat": ("endrepeat",), "do": ("while",)}


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Statements under an O word."""

    control: Control
    block: Block
    body: "list[Block | _Part]" = field(default_factory=list)
    otherwise: "list[_Part]" = field(default_factory=list)
    """Of an if: its elseif and else."""


_Body = list[Block | _Part]


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """A program that was read."""

    file: str
    """Where it was read."""
    blocks: tuple[Block, ...]
    """All its lines but empty ones."""
    body: tuple[Block | _Part, ...]
    """What it does."""
    subroutines: dict[str, _Part]
    """Its subroutines by label."""


def read_program(text: str, file: str) -> Program:
    """Read a program.

    Args:
        text: All of it.
        file: Where it was read, for errors.

    Raises:
        GcodeError: If a line is none, or O words do not belong together.
    """
    blocks: list[Block] = []
    for number, line in enumerate(_between_percent(text.splitlines()), start=1):
        try:
            block = read_block(line, number, file)
        except GcodeError:
            if not _has_ended(file, blocks):
                raise
            break  # notes behind the end of the program
        if not block.is_empty:
            blocks.append(block)
    return _Grower(file, blocks).program()


def _has_ended(file: str, blocks: Sequence[Block]) -> bool:
    """Say whether blocks are a whole program with M2 or M30, behind which nothing is read."""
    try:
        body = _Grower(file, blocks).program().body
    except GcodeError:
        return False
    plain = [part for part in body if isinstance(part, Block)]
    return any(_END(word.text) for block in plain for word in block.words)


def _between_percent(lines: list[str]) -> list[str]:
    """Blank the lines before the first % and from the second on, if there are two."""
    marks = [i for i, line in enumerate(lines) if line.strip() == "%"]
    if not marks or any(line.strip() for line in lines[: marks[0]]):
        return ["" if line.strip() == "%" else line for line in lines]
    last = marks[1] if len(marks) > 1 else len(lines)
    return [line if marks[0] < i < last else "" for i, line in enumerate(lines)]


class _Grower:
    """Grows the tree of a program."""

    def __init__(self, file: str, blocks: Sequence[Block]) -> None:
        self.file = file
        self.blocks = tuple(blocks)
        self.at = 0
        self.subroutines: dict[str, _Part] = {}

    def program(self) -> Program:
        body = self._body(None, ())
        return Program(self.file, self.blocks, tuple(body), self.subroutines)

    def _body(self, opened: _Part | None, ends: tuple[str, ...], depth: int = 0) -> _Body:
        """Read statements up to the O word that ends them, which is left to be read."""
        body: _Body = []
        while self.at < len(self.blocks):
            block = self.blocks[self.at]
            control = block.control
            if control is None:
                body.append(block)
                self.at += 1
                continue
            if opened and control.label == opened.control.label and control.verb in ends:
                return body
            if depth >= DEEPEST_NEST:
                self._refuse(block, f"lies more than {DEEPEST_NEST} deep in others")
            self._statement(block, control, body, depth)
        if opened is not None:
            wanted = " or ".join(ends)
            self._refuse(opened.block, f"has no {wanted} with the label {opened.control.label}")
        return body

    def _statement(self, block: Block, control: Control, body: _Body, depth: int) -> None:
        part = _Part(control, block)
        self.at += 1
        match control.verb:
            case "call" | "return" | "break" | "continue":
                body.append(part)
            case "sub":
                if depth:
                    self._refuse(block, "a subroutine must not stand within something else")
                if control.label in self.subroutines:
                    self._refuse(block, f"there are two subroutines {control.label}")
                self.subroutines[control.label] = part
                self._fill(part, depth)
            case "while" | "repeat" | "do":
                self._want_values(block, control, 0 if control.verb == "do" else 1)
                body.append(part)
                self._fill(part, depth)
            case "if":
                self._want_values(block, control, 1)
                body.append(part)
                self._branches(part, depth)
            case _:
                self._refuse(block, f"there is nothing that this {control.verb} ends")

    def _fill(self, part: _Part, depth: int) -> None:
        """Read the statements of a part and the O word that ends them."""
        part.body.extend(self._body(part, _CLOSERS[part.control.verb], depth + 1))
        closer = self.blocks[self.at]
        if part.control.verb in ("do", "sub"):  # their ends have values of their own
            assert closer.control is not None  # noqa: S101 - that is how it was found
            part.otherwise.append(_Part(closer.control, closer))
        self.at += 1

    def _branches(self, first: _Part, depth: int) -> None:
        part = first
        while True:
            ends = ("endif",) if part.control.verb == "else" else ("elseif", "else", "endif")
            part.body.extend(self._body(part, ends, depth + 1))
            block = self.blocks[self.at]
            self.at += 1
            control = block.control
            if control is None or control.verb == "endif":
                return
            self._want_values(block, control, 1 if control.verb == "elseif" else 0)
            part = _Part(control, block)
            first.otherwise.append(part)

    def _want_values(self, block: Block, control: Control, count: int) -> None:
        if len(control.values) != count:
            self._refuse(block, f"wants {count} value in brackets, got {len(control.values)}")

    def _refuse(self, block: Block, reason: str) -> NoReturn:
        control = block.control
        word = f"O{control.label} {control.verb}" if control else ""
        raise GcodeError(self.file, block.line, word, reason)


class _Left(Exception):  # noqa: N818 - no error: it ends a loop, a subroutine or the program
    """Something is left before its end."""

    def __init__(self, part: _Part, value: float | None = None) -> None:
        self.part = part
        self.verb = part.control.verb
        self.label = part.control.label
        self.value = value


class Runner:
    """Runs a program: gives its blocks in the order in which they are done.

    Args:
        program: The program.
        memory: Its parameters.
        load: Gives the program of a subroutine that stands in a file of its own, by name; None:
            there is none.
    """

    def __init__(
        self,
        program: Program,
        memory: Memory,
        load: Callable[[str], Program | None] | None = None,
    ) -> None:
        self.program = program
        self.memory = memory
        self._load = load
        self._returned: tuple[float, bool] = (0.0, False)
        self._done = 0
        self._loaded: dict[str, tuple[Program, _Part]] = {}

    @property
    def returned(self) -> tuple[float, bool]:
        """What the last subroutine gave back, and whether it gave anything."""
        return self._returned

    def blocks(self) -> Iterator[tuple[str, Block]]:
        """Give each block that is reached, and the file it stands in.

        Its values are to be worked out before the next is asked for.

        Raises:
            GcodeError: If an O word cannot be done.
        """
        try:
            yield from self._run(self.program, self.program.body)
        except _Left as left:
            if left.verb != "return":
                self._refuse(self.program, left.part, "is in no loop of that label")

    def value(self, file: str, block: Block, value: Value, word: str = "") -> float:
        """Work a value out.

        Raises:
            GcodeError: If it has none.
        """
        try:
            return value(self.memory)
        except RecursionError as fault:
            reason = "is too long to be worked out"
            raise GcodeError(file, block.line, word[:40] or block.text[:40], reason) from fault
        except (NoValueError, ParameterError) as fault:
            raise GcodeError(file, block.line, word or block.text[:40], str(fault)) from fault

    def _run(self, program: Program, body: Sequence[Block | _Part]) -> Iterator[tuple[str, Block]]:
        for part in body:
            block = part.block if isinstance(part, _Part) else part
            self._count(program, block)
            if isinstance(part, Block):
                yield program.file, part
            else:
                yield from self._do(program, part)

    def _count(self, program: Program, block: Block) -> None:
        self._done += 1
        if self._done > MOST_BLOCKS + len(self.program.blocks):
            reason = f"runs on after {self._done - 1} lines: has it an end?"
            raise GcodeError(program.file, block.line, "", reason)

    def _do(self, program: Program, part: _Part) -> Iterator[tuple[str, Block]]:
        control = part.control
        match control.verb:
            case "return":
                raise _Left(part, self._first_value(program, part))
            case "break" | "continue":
                raise _Left(part)
            case "call":
                yield from self._call(program, part)
            case "if":
                yield from self._choose(program, part)
            case _:
                yield from self._loop(program, part)

    def _choose(self, program: Program, part: _Part) -> Iterator[tuple[str, Block]]:
        for branch in (part, *part.otherwise):
            if branch.control.verb == "else" or self._holds(program, branch):
                yield from self._run(program, branch.body)
                return

    def _loop(self, program: Program, part: _Part) -> Iterator[tuple[str, Block]]:
        verb, turns = part.control.verb, 0
        most = inf
        if verb == "repeat":
            most = self._first_value(program, part) or 0.0
            if not isfinite(most):
                self._refuse(program, part, f"cannot be done {most} times")
            most = round(most)
        while turns < most:
            if verb == "while" and not self._holds(program, part):
                return
            self._count(program, part.block)
            if not (yield from self._turn(program, part)):
                return
            if verb == "do" and not self._holds(program, part.otherwise[0]):
                return
            turns += 1

    def _turn(self, program: Program, part: _Part) -> Generator[tuple[str, Block], None, bool]:
        """Run a loop's body once; tell whether it may go on."""
        try:
            yield from self._run(program, part.body)
        except _Left as left:
            if left.label != part.control.label or left.verb == "return":
                raise
            return left.verb == "continue"
        return True

    def _first_value(self, program: Program, part: _Part) -> float | None:
        values = part.control.values
        return self.value(program.file, part.block, values[0]) if values else None

    def _holds(self, program: Program, part: _Part) -> bool:
        return self._first_value(program, part) != 0.0

    def _call(self, program: Program, part: _Part) -> Iterator[tuple[str, Block]]:
        label = part.control.label
        home, target = self._find(program, part)
        if self.memory.depth >= DEEPEST_CALL:
            self._refuse(program, part, f"more than {DEEPEST_CALL} calls within each other")
        arguments = [self.value(program.file, part.block, v) for v in part.control.values]
        if len(arguments) > 30:
            self._refuse(program, part, f"takes at most 30 arguments, got {len(arguments)}")
        given: float | None = None
        self.memory.enter(arguments)
        try:
            yield from self._run(home, target.body)
            given = self._first_value(home, target.otherwise[0])
        except _Left as left:
            if left.verb != "return" or left.label != label:
                raise
            given = left.value
        finally:
            self.memory.leave()
        self._returned = (0.0, False) if given is None else (given, True)

    def _find(self, program: Program, part: _Part) -> tuple[Program, _Part]:
        label = part.control.label
        for home in (program, self.program):
            if label in home.subroutines:
                return home, home.subroutines[label]
        if label not in self._loaded:
            loaded = None if self._load is None else self._load(label)
            if loaded is None or label not in loaded.subroutines:
                self._refuse(program, part, f"there is no subroutine {label}")
            self._loaded[label] = (loaded, loaded.subroutines[label])
        return self._loaded[label]

    def _refuse(self, program: Program, part: _Part, reason: str) -> NoReturn:
        word = f"O{part.control.label} {part.control.verb}"
        raise GcodeError(program.file, part.block.line, word, reason)


def beside(file: Path) -> Callable[[str], Program | None]:
    """Give what loads subroutines from files beside a program: O<name> call reads name.ngc."""

    def load(name: str) -> Program | None:
        path = file.parent / f"{name}.ngc"
        if not name.replace("-", "_").isidentifier() or not path.is_file():
            return None
        return read_program(path.read_text(encoding="utf-8", errors="replace"), str(path))

    return load
