"""The words of one line with their values, the codes by group, and which of them were used."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GcodeError

from .gcode_block import Block
from .gcode_flow import Runner
from .gcode_modal import G_GROUPS, M_GROUPS, UNKNOWN_BECAUSE, Code, written
from .gcode_state import AXES, OFFSET_LETTERS

_WHOLE = 1e-4
_ROTARY = "abcuvw"


@dataclass(slots=True, eq=False)
class Line:
    """A line whose values are worked out."""

    file: str
    """The file it stands in."""
    block: Block
    """How it is written."""
    g: dict[str, Code] = field(default_factory=dict)
    """G codes by group, times ten."""
    m: dict[str, Code] = field(default_factory=dict)
    """M codes by group, times ten."""
    values: dict[str, float] = field(default_factory=dict)
    """Values of the other words by letter."""
    texts: dict[str, str] = field(default_factory=dict)
    """How they are written."""
    used: set[str] = field(default_factory=set)
    """Letters that meant something."""

    @property
    def number(self) -> int:
        """Its number in the file."""
        return self.block.line

    @property
    def axes(self) -> tuple[int, ...]:
        """The axes that it names and that no code has used."""
        return tuple(i for i, a in enumerate(AXES) if a in self.values and a not in self.used)

    @property
    def moves(self) -> bool:
        """Whether it has words that a motion in force is for."""
        left = self.values.keys() - self.used
        return bool(left & set(AXES + OFFSET_LETTERS)) or "p" in left or "r" in left

    def take(self, letter: str) -> float | None:
        """Give the value of a word, if it is there."""
        self.used.add(letter)
        return self.values.get(letter)

    def drop(self, *letters: str) -> None:
        """Let words mean nothing here."""
        self.used.update(letters)

    def required(self, letter: str, what: str) -> float:
        """Give the value of a word that must be there."""
        value = self.take(letter)
        if value is None:
            raise self.refuse(letter.upper(), f"is missing: {what}")
        return value

    def at_least(self, letter: str, least: float, missing: str = "") -> float:
        """Give the value of a word that must not be below a number."""
        value = self.required(letter, missing)
        if value < least:
            raise self.refuse(self.texts[letter], f"want at least {least:g}, got {value:g}")
        return value

    def whole(self, letter: str, least: int, missing: str = "") -> int:
        """Give the value of a word that must be a whole number."""
        value = self.at_least(letter, least - _WHOLE, missing)
        if abs(value - round(value)) > _WHOLE:
            raise self.refuse(self.texts[letter], f"want a whole number, got {value:g}")
        return round(value)

    def places(self, unit: float) -> dict[int, float]:
        """Give what axis words say by axis, m."""
        found = {i: self.values[AXES[i]] * unit for i in self.axes}
        self.used.update(AXES)
        return found

    def ways(self, unit: float, otherwise: FloatArray) -> FloatArray:
        """Give what axis words say, shape (3,), m; axes that are not named are as they were."""
        result = np.array(otherwise, dtype=np.float64)
        for axis, value in self.places(unit).items():
            result[axis] = value
        return result

    def refuse(self, word: str, reason: str) -> GcodeError:
        """Make the error of a word of this line."""
        return GcodeError(self.file, self.number, word, reason)

    def refuse_group(self, group: str, reason: str) -> GcodeError:
        """Make the error of the code of a group."""
        return self.refuse(written("g", self.g[group]), reason)

    def require_all_used(self) -> None:
        """Refuse words that meant nothing: what they were for would be lost."""
        left = self.values.keys() - self.used - {"f", "s", "t"}
        if left:
            letter = min(left, key=lambda name: self.block.text.lower().find(name))
            raise self.refuse(self.texts[letter], "means nothing in this line")


def read_line(file: str, block: Block, runner: Runner) -> Line:
    """Work out the words of a block.

    Raises:
        GcodeError: If a word has no value, a code is not known, or two of one group are there.
    """
    line = Line(file, block)
    for word in block.words:
        value = runner.value(file, block, word.value, word.text)
        if word.letter in "gm":
            _add_code(line, word.letter, value, word.text)
        elif word.letter in _ROTARY:
            raise line.refuse(word.text, "axes other than X, Y and Z are not understood")
        elif word.letter in line.values:
            raise line.refuse(word.text, f"there are two {word.letter.upper()} words in this line")
        else:
            line.values[word.letter] = value
            line.texts[word.letter] = word.text
    return line


def _add_code(line: Line, letter: str, value: float, text: str) -> None:
    code = round(10.0 * value)
    groups, there = (G_GROUPS, line.g) if letter == "g" else (M_GROUPS, line.m)
    if abs(10.0 * value - code) > 10.0 * _WHOLE or code not in groups:
        name = written(letter, code)
        reason = UNKNOWN_BECAUSE.get(name, f"there is no code {text.upper()} that is understood")
        raise line.refuse(text, reason)
    group = groups[code]
    if group in there:
        other = written(letter, there[group])
        raise line.refuse(text, f"goes not together with {other}, which is of the same group")
    there[group] = code
