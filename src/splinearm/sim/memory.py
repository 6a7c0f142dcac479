"""The control table of a servo as bytes: what a read gives and what a write would change."""

import re
from collections.abc import Iterable
from typing import NamedTuple

from splinearm.drivers.registers import Area, ControlTable, Register

_REACH = 1024  # an Indirect Address can point so far, whatever lies there
_INDIRECT = re.compile(r"Indirect (Address|Data) (\d+)")


class Change(NamedTuple):
    """A register and the value that a write gives it."""

    register: Register
    value: int


class _Read(NamedTuple):
    """What a read of some bytes means: the bytes meant, None if themselves, and whose they are."""

    addresses: tuple[int, ...] | None
    names: tuple[str, ...]


class LengthError(ValueError):
    """A write covers a register in part."""


class AddressError(ValueError):
    """An access touches no register, or begins within one."""


class TableMemory:
    """The bytes behind a control table.

    Bytes of the table that no register owns read 0. Each Indirect Data byte stands for the byte
    whose address its Indirect Address holds; as it comes from the factory it stands for itself.
    """

    def __init__(self, table: ControlTable) -> None:
        """Fill the table with its initial values; what the manual leaves open is 0."""
        self.table = table
        self._bytes = bytearray(max(table.size, _REACH))
        self._places = {r.name: (r.address, r.end, r.signed) for r in table.registers}
        self._pointers = _pointers(table)
        self._pointing = frozenset(self._pointers.values())
        self._reads: dict[tuple[int, int], _Read] = {}
        self._writes: dict[tuple[int, int], list[tuple[Register, int]]] = {}
        self.reset(table.registers)

    def __contains__(self, name: str) -> bool:
        return name in self.table

    def __getitem__(self, name: str) -> int:
        place = self._places.get(name)
        if place is None:
            raise KeyError(f"{self.table.model} has no register {name!r}")
        start, end, signed = place
        return int.from_bytes(self._bytes[start:end], "little", signed=signed)

    def __setitem__(self, name: str, value: int) -> None:
        register = self.table[name]
        self._bytes[register.address : register.end] = register.encode(value)
        if register.address in self._pointing:
            self._reads.clear()
            self._writes.clear()

    def get(self, name: str, missing: int = 0) -> int:
        """Give the value of a register, or ``missing`` if the model has none of that name."""
        return self[name] if name in self.table else missing

    def reset(self, registers: Iterable[Register]) -> None:
        """Give registers their initial values."""
        for register in registers:
            initial = register.initial
            self[register.name] = initial if isinstance(initial, int) else 0

    def show(self, name: str, value: float) -> None:
        """Put a measured value into a register, at its end stop if it does not fit."""
        register = self.table[name]
        low, high = register.span
        self[name] = min(max(round(value), low), high)

    def of(self, area: Area) -> list[Register]:
        """Give the registers of an area."""
        return [register for register in self.table.registers if register.area is area]

    def read(self, address: int, length: int) -> bytes:
        """Give bytes as a client sees them.

        Raises:
            AddressError: If they end behind the table, or no register owns any of them.
        """
        how = self._reads.get((address, length))
        if how is None:
            how = self._reads[address, length] = self._how_to_read(address, length)
        if how.addresses is None:
            return bytes(self._bytes[address : address + length])
        data = self._bytes
        return bytes([data[at] for at in how.addresses])

    def names_in(self, address: int, length: int) -> tuple[str, ...]:
        """Give the registers that a read shows, wholly or in part.

        Raises:
            AddressError: As ``read`` does.
        """
        how = self._reads.get((address, length))
        if how is None:
            how = self._reads[address, length] = self._how_to_read(address, length)
        return how.names

    def _how_to_read(self, address: int, length: int) -> "_Read":
        """Find out what a read means; kept until an Indirect Address changes."""
        span = range(address, address + length)
        if not length or span.stop > self.table.size or not any(map(self._owned, span)):
            raise AddressError(f"no register at {address}..{span.stop - 1}")
        meant = [self._meant(at) for at in span]
        names = dict.fromkeys(self.table.at(at).name for at in meant if self._owned(at))
        direct = self._pointers.keys().isdisjoint(span)
        return _Read(None if direct else tuple(meant), tuple(names))

    def changes(self, address: int, data: bytes) -> list[Change]:
        """Give what a write means, register by register; nothing is changed.

        Raises:
            AddressError: If it touches bytes that are no register's, or begins within one.
            LengthError: If it covers a register in part.
        """
        places = self._writes.get((address, len(data)))
        if places is None:
            places = self._writes[address, len(data)] = self._how_to_write(address, len(data))
        return [Change(place, place.decode(data[at : at + place.size])) for place, at in places]

    def _how_to_write(self, address: int, length: int) -> list[tuple[Register, int]]:
        """Find out what a write means: registers, and where in the data each begins."""
        addresses = [self._meant(at) for at in range(address, address + length)]
        found: list[tuple[Register, int]] = []
        start = 0
        while start < len(addresses):
            register = self._beginning_at(addresses[start])
            end = start + register.size
            if addresses[start:end] != list(range(register.address, register.end)):
                raise LengthError(f"{register.name} has {register.size} bytes")
            found.append((register, start))
            start = end
        if not found:
            raise LengthError("a write without data")
        return found

    def _owned(self, address: int) -> bool:
        try:
            self.table.at(address)
        except KeyError:
            return False
        return True

    def _beginning_at(self, address: int) -> Register:
        """Give the register whose first byte that is."""
        try:
            register = self.table.at(address)
        except KeyError as error:
            raise AddressError(str(error)) from None
        if register.address != address:
            raise AddressError(f"{register.name} begins at {register.address}, not at {address}")
        return register

    def _meant(self, address: int) -> int:
        """Give the address that a byte stands for."""
        pointer = self._pointers.get(address)
        if pointer is None:
            return address
        return int.from_bytes(self._bytes[pointer : pointer + 2], "little")


def _pointers(table: ControlTable) -> dict[int, int]:
    """Give for the address of each Indirect Data byte the address of its Indirect Address."""
    places: dict[tuple[str, str], int] = {}
    for register in table.registers:
        match = _INDIRECT.fullmatch(register.name)
        if match:
            places[match[1], match[2]] = register.address
    return {
        address: places["Address", number]
        for (kind, number), address in places.items()
        if kind == "Data"
    }
