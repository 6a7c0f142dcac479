"""One line of an NC program: its words, settings of parameters, comments and control words."""

from dataclasses import dataclass
from typing import NamedTuple

from splinearm.errors import GcodeError

from .gcode_expression import Reader, TextError, Value

LONGEST = 4096
"""A line may have that many characters."""

_LETTERS = frozenset("abcdefghijklmpqrstuvwxyz")
_CONTROL = (
    "sub", "endsub", "call", "return", "if", "elseif", "else", "endif", "while", "endwhile",
    "do", "repeat", "endrepeat", "break", "continue",
)  # fmt: skip


class Word(NamedTuple):
    """A letter and its value."""

    letter: str
    """The letter, small."""
    value: Value
    """Works its value out."""
    text: str
    """How it is written, for messages."""


class Setting(NamedTuple):
    """A parameter that is set."""

    target: str | Value
    """Its name, or what works its number out."""
    value: Value
    """What it becomes."""
    text: str
    """How it is written, for messages."""


class Control(NamedTuple):
    """An O word: what it does, to which label, with which values."""

    label: str
    """The number or name after the O."""
    verb: str
    """One of sub, endsub, call, return, if, elseif, else, endif, while, endwhile, do, repeat,
    endrepeat, break, continue."""
    values: tuple[Value, ...]
    """What stands in brackets behind it."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Block:
    """A line of a program."""

    line: int
    """Its number in the file, from 1."""
    text: str
    """How it is written."""
    words: tuple[Word, ...] = ()
    """Its words in their order."""
    settings: tuple[Setting, ...] = ()
    """Parameters that it sets, after all its values are worked out."""
    comments: tuple[str, ...] = ()
    """Its comments, without their brackets."""
    control: Control | None = None
    """What it does besides, if it is an O word."""
    optional: bool = False
    """Whether it begins with / and may be left out."""

    @property
    def is_empty(self) -> bool:
        """Whether nothing is to be done."""
        return not (self.words or self.settings or self.comments or self.control)


def read_block(text: str, line: int, file: str) -> Block:
    """Read a line.

    Args:
        text: The line.
        line: Its number.
        file: The file it stands in, for errors.

    Raises:
        GcodeError: If it is no line of a program.
    """
    if len(text) > LONGEST:
        raise GcodeError(file, line, "", f"is {len(text)} characters long; at most {LONGEST}")
    plain, comments = _without_comments(text, line, file)
    code = "".join(plain.split()).lower()
    optional = code.startswith("/")
    reader = Reader(code, 1 if optional else 0)
    try:
        words, settings, control = _read(reader)
    except TextError as fault:
        word = code[fault.position : fault.position + 12]
        raise GcodeError(file, line, word, fault.reason) from fault
    return Block(
        line=line,
        text=text.strip(),
        words=tuple(words),
        settings=tuple(settings),
        comments=tuple(comments),
        control=control,
        optional=optional,
    )


def _without_comments(text: str, line: int, file: str) -> tuple[str, list[str]]:
    """Give a line without its comments, and those."""
    plain, comments = "", list[str]()
    rest = text
    while rest:
        cut = min((i for i in (rest.find("("), rest.find(";")) if i >= 0), default=len(rest))
        plain += rest[:cut]
        if cut == len(rest):
            break
        if rest[cut] == ";":
            comments.append(rest[cut + 1 :].strip())
            break
        end = rest.find(")", cut)
        inner = rest.find("(", cut + 1)
        if end < 0:
            raise GcodeError(file, line, rest[cut : cut + 12], "a comment that does not end with )")
        if 0 <= inner < end:
            raise GcodeError(file, line, rest[inner : inner + 12], "a comment within a comment")
        comments.append(rest[cut + 1 : end].strip())
        rest = rest[end + 1 :]
    return plain, comments


def _read(reader: Reader) -> tuple[list[Word], list[Setting], Control | None]:
    words, settings, control = list[Word](), list[Setting](), None
    if reader.take("n"):
        reader.value()  # line numbers mean nothing
    while reader.rest:
        start = reader.position
        if reader.take("#"):
            reader.position = start
            settings.append(_setting(reader))
        elif reader.take("o"):
            if words or settings:
                raise reader.fault("an O word must be the first of its line")
            control = _control(reader)
        elif reader.rest[0] in _LETTERS and control is None:
            letter = reader.text[reader.position]
            reader.position += 1
            value = reader.value()
            words.append(Word(letter, value, reader.text[start : reader.position]))
        else:
            raise reader.fault("want a word such as G1 or X10")
    return words, settings, control


def _setting(reader: Reader) -> Setting:
    start = reader.position
    target: str | Value | None = reader.name()
    if target is None:
        reader.require("#")
        target = reader.value()
    reader.require("=")
    value = reader.value()
    return Setting(target, value, reader.text[start : reader.position])


def _control(reader: Reader) -> Control:
    label = _label(reader)
    # the longest first: endif before end, elseif before else
    verb = next((v for v in sorted(_CONTROL, key=len, reverse=True) if reader.take(v)), None)
    if verb is None:
        raise reader.fault(f"want one of {', '.join(_CONTROL)}")
    values = []
    while reader.rest.startswith("["):
        values.append(reader.value())
    if reader.rest:
        raise reader.fault("want the end of the line")
    return Control(label, verb, tuple(values))


def _label(reader: Reader) -> str:
    """Read the number or the name of an O word."""
    if reader.take("<"):
        name, end, _ = reader.rest.partition(">")
        if not end or not name:
            raise reader.fault("want a name and >")
        reader.position += len(name) + 1
        return name
    digits = ""
    while reader.rest[:1].isdigit():
        digits += reader.rest[0]
        reader.position += 1
    if not digits:
        raise reader.fault("want a number or a <name>")
    return str(int(digits))
