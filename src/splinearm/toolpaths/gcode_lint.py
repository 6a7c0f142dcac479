"""Whether a controller takes a program as it is written."""

from collections.abc import Iterator
from dataclasses import dataclass

from .gcode_block import Block
from .gcode_dialect import Dialect
from .gcode_expression import NoValueError, Value
from .gcode_flow import Program
from .gcode_memory import Memory, ParameterError
from .gcode_modal import written


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that a controller does not take."""

    line: int
    """The line, from 1."""
    word: str
    """The word; "" for the whole line."""
    reason: str
    """What is wrong with it."""

    def __str__(self) -> str:
        return f"line {self.line}: {self.word + ': ' if self.word else ''}{self.reason}"


def lint(program: Program, text: str, dialect: Dialect) -> list[Finding]:
    """Give what a controller does not take of a program, in the order of its lines.

    Args:
        program: The program, read.
        text: The program as it is written.
        dialect: The controller.
    """
    found = [
        Finding(number, "", f"is {len(line)} characters long; at most {dialect.longest_line}")
        for number, line in enumerate(text.splitlines(), start=1)
        if len(line) > dialect.longest_line
    ]
    for block in program.blocks:
        found += _of_block(block, dialect)
    return sorted(found, key=lambda finding: finding.line)


def _of_block(block: Block, dialect: Dialect) -> Iterator[Finding]:
    if not dialect.language:
        if block.control is not None:
            control = f"O{block.control.label} {block.control.verb}"
            yield Finding(block.line, control, f"{dialect.name} knows no O words")
        for setting in block.settings:
            yield Finding(block.line, setting.text, f"{dialect.name} knows no parameters")
        for word in block.words:
            if "[" in word.text or "#" in word.text:
                yield Finding(block.line, word.text, f"{dialect.name} knows no expressions")
    if dialect.codes is None:
        return
    for word in block.words:
        if word.letter in "gm":
            code = _code(word.letter, word.value)
            if code is not None and code not in dialect.codes:
                yield Finding(block.line, word.text.upper(), f"{dialect.name} does not know it")


def _code(letter: str, value: Value) -> str | None:
    try:
        return written(letter, round(10.0 * value(Memory())))
    except (NoValueError, ParameterError):  # it is told as an expression
        return None
