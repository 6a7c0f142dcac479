"""Numbers, parameters and expressions in NC programs, read once and worked out when they are met.

Source: Kramer, Proctor, Messina, NISTIR 6556, 2000, 3.3.2; LinuxCNC, "G-code overview": precedence
of operators from ``**`` down to AND, OR and XOR, all from left to right; angles in degrees.
"""

import operator
from collections.abc import Callable
from math import (
    acos,
    asin,
    atan2,
    ceil,
    cos,
    degrees,
    exp,
    floor,
    fmod,
    isfinite,
    log,
    radians,
    sin,
    sqrt,
    tan,
)
from re import compile as pattern

from .gcode_memory import Memory

Value = Callable[[Memory], float]
"""Works a value out."""

_NUMBER = pattern(r"[-+]?(\d+\.?\d*|\.\d+)")
_NAME = pattern(r"#<([^<>]*)>")
_DEEPEST = 100

_Operation = Callable[[float, float], float]


class TextError(Exception):
    """Text that is no expression; its position, and what was wanted there."""

    def __init__(self, position: int, reason: str) -> None:
        self.position = position
        self.reason = reason
        super().__init__(reason)


class NoValueError(Exception):
    """An expression that has no value."""


def _modulo(a: float, b: float) -> float:
    # the result has the sign of the divisor's magnitude: never below 0 (LinuxCNC, interp_execute)
    rest = fmod(a, b)
    return rest + abs(b) if rest < 0.0 else rest


def _divide(a: float, b: float) -> float:
    if b == 0.0:
        raise NoValueError("division by zero")
    return a / b


def _power(a: float, b: float) -> float:
    if a < 0.0 and b != floor(b):
        raise NoValueError(f"{a:g} ** {b:g}: a number below 0 has no such power")
    try:
        return float(a**b)
    except (OverflowError, ZeroDivisionError) as error:
        raise NoValueError(f"{a:g} ** {b:g} is no finite number") from error


_TOLERANCE = 1e-4  # numbers nearer than this are equal to EQ and NE, as LinuxCNC has it


def _truth(test: Callable[[float, float], bool]) -> _Operation:
    return lambda a, b: 1.0 if test(a, b) else 0.0


_LEVELS: tuple[dict[str, _Operation], ...] = (
    {
        "and": _truth(lambda a, b: a != 0.0 and b != 0.0),
        "xor": _truth(lambda a, b: (a != 0.0) != (b != 0.0)),
        "or": _truth(lambda a, b: a != 0.0 or b != 0.0),
    },
    {
        "eq": _truth(lambda a, b: abs(a - b) < _TOLERANCE),
        "ne": _truth(lambda a, b: abs(a - b) >= _TOLERANCE),
        "gt": _truth(operator.gt),
        "ge": _truth(operator.ge),
        "lt": _truth(operator.lt),
        "le": _truth(operator.le),
    },
    {"+": operator.add, "-": operator.sub},
    {"*": operator.mul, "/": _divide, "mod": _modulo},
    {"**": _power},
)
"""Operators, the loosest first."""


def _checked(function: Callable[[float], float], name: str) -> Callable[[float], float]:
    def work(x: float) -> float:
        try:
            return function(x)
        except (ValueError, OverflowError) as error:
            raise NoValueError(f"{name}[{x:g}] has no value") from error

    return work


_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "abs": abs,
    "acos": _checked(lambda x: degrees(acos(x)), "acos"),
    "asin": _checked(lambda x: degrees(asin(x)), "asin"),
    "cos": lambda x: cos(radians(x)),
    "exp": _checked(exp, "exp"),
    "fix": lambda x: float(floor(x)),
    "fup": lambda x: float(ceil(x)),
    "ln": _checked(log, "ln"),
    "round": lambda x: float(floor(x + 0.5)) if x >= 0.0 else float(ceil(x - 0.5)),
    "sin": lambda x: sin(radians(x)),
    "sqrt": _checked(sqrt, "sqrt"),
    "tan": lambda x: tan(radians(x)),
}


class Reader:
    """Reads values out of a line that has neither spaces, comments nor capitals."""

    def __init__(self, text: str, position: int = 0) -> None:
        self.text = text
        self.position = position
        self._depth = 0

    @property
    def rest(self) -> str:
        """What is still to be read."""
        return self.text[self.position :]

    def take(self, wanted: str) -> bool:
        """Read a piece of text if it is next."""
        if self.text.startswith(wanted, self.position):
            self.position += len(wanted)
            return True
        return False

    def require(self, wanted: str) -> None:
        """Read a piece of text that must be next."""
        if not self.take(wanted):
            raise self.fault(f"want {wanted!r}")

    def fault(self, reason: str) -> TextError:
        """Make the fault of what comes next."""
        there = self.rest[:12]
        found = f"{there!r}" if there else "the end of the line"
        return TextError(self.position, f"{reason}, got {found}")

    def value(self) -> Value:
        """Read a number, a parameter, a function or an expression in brackets."""
        match = _NUMBER.match(self.text, self.position)
        if match is not None:
            self.position = match.end()
            number = float(match[0])
            if not isfinite(number):
                raise TextError(match.start(), f"{match[0][:12]}... is too large a number")
            return lambda _: number
        for sign in "-+":
            if self.take(sign):
                inner = self._deeper(self.value)
                return inner if sign == "+" else _negative(inner)
        if self.take("["):
            inner = self._deeper(self._loosest)
            self.require("]")
            return inner
        if self.take("#"):
            self.position -= 1
            return self._deeper(self._parameter)
        return self._function()

    def _deeper(self, read: Callable[[], Value]) -> Value:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise TextError(self.position, f"brackets lie more than {_DEEPEST} deep")
        value = read()
        self._depth -= 1
        return value

    def _loosest(self) -> Value:
        return self._operated(0)

    def _operated(self, level: int) -> Value:
        """Read values joined by operators of a level and tighter ones."""
        if level == len(_LEVELS):
            return self.value()
        left = self._operated(level + 1)
        while True:
            work = self._operator(level)
            if work is None:
                return left
            left = _joined(work, left, self._operated(level + 1))

    def _operator(self, level: int) -> _Operation | None:
        for name, work in _LEVELS[level].items():
            if name == "*" and self.rest.startswith("**"):
                continue
            if self.take(name):
                return work
        return None

    def name(self) -> str | None:
        """Read ``#<name>`` if that is next."""
        match = _NAME.match(self.text, self.position)
        if match is None:
            return None
        self.position = match.end()
        if not match[1]:
            raise TextError(match.start(), "want a name between < and >")
        return match[1]

    def _parameter(self) -> Value:
        name = self.name()
        if name is not None:
            return lambda memory: memory.named(name)
        self.require("#")
        number = self._deeper(self.value)
        return lambda memory: memory.numbered(number(memory))

    def _function(self) -> Value:
        if self.take("exists["):
            asked = self.name()
            if asked is None:
                raise self.fault("want a name such as #<depth>")
            self.require("]")
            return lambda memory: float(memory.exists(asked))
        if self.take("atan["):
            across = self._deeper(self._loosest)
            self.require("]")
            self.require("/")
            self.require("[")
            along = self._deeper(self._loosest)
            self.require("]")
            return lambda memory: degrees(atan2(across(memory), along(memory)))
        for name, work in _FUNCTIONS.items():
            if self.take(f"{name}["):
                inner = self._deeper(self._loosest)
                self.require("]")
                return _applied(work, inner)
        raise self.fault("want a number, a parameter or an expression in brackets")


def _joined(work: _Operation, left: Value, right: Value) -> Value:
    return lambda memory: work(left(memory), right(memory))


def _negative(inner: Value) -> Value:
    return lambda memory: -inner(memory)


def _applied(work: Callable[[float], float], inner: Value) -> Value:
    return lambda memory: float(work(inner(memory)))
