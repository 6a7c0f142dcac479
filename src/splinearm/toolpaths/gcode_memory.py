"""What an NC program can remember: numbered and named parameters, global and of a subroutine.

Source: LinuxCNC, "G-code overview", sections "Numbered Parameters" and "Named Parameters";
Kramer, Proctor, Messina, The NIST RS274NGC Interpreter, Version 3, NISTIR 6556, 2000, 3.2.1.
"""

from collections.abc import Callable, Mapping

LOCAL = 30
"""Parameters 1 to 30 belong to the subroutine that runs: they take its arguments."""

LARGEST = 5602
"""The last numbered parameter."""

_READ_ONLY = frozenset((*range(5400, 5414), *range(5420, 5429)))


class ParameterError(Exception):
    """A parameter that cannot be read or set."""


class Memory:
    """The parameters of a program that runs.

    Args:
        computed: What the interpreter answers for names and numbers that it keeps itself.
    """

    def __init__(self, computed: Mapping[int | str, Callable[[], float]] | None = None) -> None:
        self._computed = dict(computed or {})
        self._numbered: dict[int, float] = {}
        self._named: dict[str, float] = {}
        self._frames: list[tuple[dict[int, float], dict[str, float]]] = [({}, {})]

    @property
    def depth(self) -> int:
        """How many subroutines are under way."""
        return len(self._frames) - 1

    def enter(self, arguments: list[float]) -> None:
        """Begin a subroutine; its first parameters are the arguments."""
        self._frames.append(({i + 1: value for i, value in enumerate(arguments)}, {}))

    def leave(self) -> None:
        """End a subroutine and forget its parameters."""
        self._frames.pop()

    def numbered(self, number: float) -> float:
        """Give a numbered parameter; one that was never set is 0."""
        index = _index(number)
        if index in self._computed:
            return self._computed[index]()
        kept = self._frames[-1][0] if index <= LOCAL else self._numbered
        return kept.get(index, 0.0)

    def named(self, name: str) -> float:
        """Give a named parameter."""
        if name in self._computed:
            return self._computed[name]()
        kept = self._names(name)
        if name not in kept:
            raise ParameterError(f"#<{name}> was never set")
        return kept[name]

    def exists(self, name: str) -> bool:
        """Say whether a named parameter was set."""
        return name in self._computed or name in self._names(name)

    def set_numbered(self, number: float, value: float) -> None:
        """Set a numbered parameter."""
        index = _index(number)
        if index in _READ_ONLY:
            raise ParameterError(f"#{index} can only be read")
        kept = self._frames[-1][0] if index <= LOCAL else self._numbered
        kept[index] = value

    def set_named(self, name: str, value: float) -> None:
        """Set a named parameter; one whose name begins with _ is seen everywhere."""
        if name in self._computed:
            raise ParameterError(f"#<{name}> can only be read")
        self._names(name)[name] = value

    def _names(self, name: str) -> dict[str, float]:
        return self._named if name.startswith("_") else self._frames[-1][1]


def _index(number: float) -> int:
    """Give the number of a parameter as the whole number that it must be."""
    index = round(number)
    if abs(number - index) > 1e-4:
        raise ParameterError(f"#{number:g}: the number of a parameter must be whole")
    if not 1 <= index <= LARGEST:
        raise ParameterError(f"#{index}: parameters go from 1 to {LARGEST}")
    return index
