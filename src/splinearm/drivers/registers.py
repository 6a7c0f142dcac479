"""Registers of a servo: where each lies in its control table, how wide it is, what it may hold."""

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from enum import Enum
from functools import cache
from importlib.resources import files
from typing import TypeAlias

Bound: TypeAlias = int | str | None
"""A number, or the name of the register that holds it (``"-PWM Limit"``: negated), or unknown."""


class Area(Enum):
    """What becomes of a register when the power goes."""

    EEPROM = "EEPROM"
    """It stays; it can be written only while the torque is off."""

    RAM = "RAM"
    """It goes back to its initial value."""


class Access(Enum):
    """What a client may do with a register."""

    READ = "R"
    """Read only."""

    WRITE = "RW"
    """Read and write."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Register:
    """One entry of a control table."""

    name: str
    """Name, as the manual writes it."""
    address: int
    """Address of its first byte."""
    size: int
    """Number of bytes: 1, 2 or 4; the low byte comes first."""
    area: Area
    """Whether it outlives the power."""
    access: Access
    """Whether it can be written."""
    initial: Bound = None
    """Value when the power comes on (RAM) or from the factory (EEPROM)."""
    minimum: Bound = None
    """Lowest value that the servo takes."""
    maximum: Bound = None
    """Highest value that the servo takes."""
    scale: float | None = None
    """What one step is worth, in ``unit``."""
    unit: str = ""
    """Unit of the scaled value, as the manual writes it; empty for plain numbers."""
    signed: bool = False
    """Whether the bytes are a two's complement."""

    @property
    def end(self) -> int:
        """Address after its last byte."""
        return self.address + self.size

    @property
    def writable(self) -> bool:
        """Whether a client may write it."""
        return self.access is Access.WRITE

    @property
    def span(self) -> tuple[int, int]:
        """Lowest and highest value that its bytes can say."""
        bits = 8 * self.size
        if self.signed:
            return -(1 << (bits - 1)), (1 << (bits - 1)) - 1
        return 0, (1 << bits) - 1

    def encode(self, value: int) -> bytes:
        """Give the bytes that say ``value``.

        Raises:
            ValueError: If its bytes cannot say it.
        """
        low, high = self.span
        if not low <= value <= high:
            raise ValueError(f"{self.name}: want a value in {low}..{high}, got {value}")
        return int(value).to_bytes(self.size, "little", signed=self.signed)

    def decode(self, data: bytes) -> int:
        """Give the value that its bytes say.

        Raises:
            ValueError: If that is not the number of bytes it has.
        """
        if len(data) != self.size:
            raise ValueError(f"{self.name}: want {self.size} bytes, got {len(data)}")
        return int.from_bytes(data, "little", signed=self.signed)


class ControlTable(Mapping[str, Register]):
    """The registers of one servo model, by name; iteration goes by address."""

    def __init__(self, model: str, registers: Iterable[Register]) -> None:
        """Take the registers of ``model``; neither names nor addresses may overlap."""
        self.model = model
        self._by_name: dict[str, Register] = {}
        self._by_byte: dict[int, Register] = {}
        for register in sorted(registers, key=lambda entry: entry.address):
            if register.name in self._by_name:
                raise ValueError(f"{model}: two registers are called {register.name!r}")
            self._by_name[register.name] = register
            for address in range(register.address, register.end):
                other = self._by_byte.setdefault(address, register)
                if other is not register:
                    raise ValueError(f"{model}: {register.name} lies upon {other.name}")

    def __getitem__(self, name: str) -> Register:
        """Give the register of that name.

        Raises:
            KeyError: If the model has none, with the names that come near.
        """
        try:
            return self._by_name[name]
        except KeyError:
            near = get_close_matches(name, self._by_name, n=3)
            hint = f"; near it: {', '.join(near)}" if near else ""
            raise KeyError(f"{self.model} has no register {name!r}{hint}") from None

    def __contains__(self, name: object) -> bool:
        return name in self._by_name

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)

    @property
    def registers(self) -> tuple[Register, ...]:
        """The registers by address."""
        return tuple(self._by_name.values())

    @property
    def size(self) -> int:
        """Address after the last register."""
        return max(self._by_byte) + 1

    def at(self, address: int) -> Register:
        """Give the register that owns the byte at ``address``.

        Raises:
            KeyError: If none does.
        """
        try:
            return self._by_byte[address]
        except KeyError:
            raise KeyError(f"{self.model} has no register at address {address}") from None

    def limits(self, name: str, value_of: Callable[[str], int]) -> tuple[int, int]:
        """Give the lowest and highest value that a register takes at present.

        Args:
            name: The register.
            value_of: Gives the present value of a register by name; asked for the registers that
                others take as their limits.
        """
        register = self[name]
        low, high = register.span
        minimum, maximum = resolve(register.minimum, value_of), resolve(register.maximum, value_of)
        return (low if minimum is None else minimum, high if maximum is None else maximum)


def resolve(bound: Bound, value_of: Callable[[str], int]) -> int | None:
    """Give the number that a bound stands for, asking ``value_of`` for a named register."""
    if not isinstance(bound, str):
        return bound
    if bound.startswith("-"):
        return -value_of(bound[1:])
    return value_of(bound)


@cache
def load_table(model: str) -> ControlTable:
    """Give the control table of a servo model ("XM430-W350"; upper or lower case).

    Raises:
        ValueError: If there is no table for it, with those there are.
    """
    folder = files("splinearm.drivers") / "models"
    path = folder / f"{model.lower()}.csv"
    if not path.is_file():
        names = sorted(
            entry.name.removesuffix(".csv").upper()
            for entry in folder.iterdir()
            if entry.name.endswith(".csv")
        )
        raise ValueError(f"no servo model {model!r}; there are {', '.join(names)}")
    rows = csv.DictReader(path.read_text(encoding="utf-8").splitlines())
    return ControlTable(model.upper(), [_register(row) for row in rows])


def _register(row: Mapping[str, str]) -> Register:
    """Read one row of a table."""
    return Register(
        name=row["name"],
        address=int(row["address"]),
        size=int(row["size"]),
        area=Area(row["area"]),
        access=Access(row["access"]),
        initial=_bound(row["initial"]),
        minimum=_bound(row["min"]),
        maximum=_bound(row["max"]),
        scale=float(row["scale"]) if row["scale"] else None,
        unit=row["unit"],
        signed=row["signed"] == "1",
    )


def _bound(text: str) -> Bound:
    """Read a number, a register's name, or nothing."""
    if not text:
        return None
    return int(text) if text.removeprefix("-").isdigit() else text
