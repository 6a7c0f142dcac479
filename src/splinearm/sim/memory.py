"""The control table of a servo as bytes: what a read gives and what a write would change."""

import re
from collections.abc import Iterable
from typing import NamedTuple

from splinearm.drivers.registers import Area, ControlTable, Register

_INDIRECT = re.compile(r"Indirect (Address|Data) (\d+)")


class Change(NamedTuple):
    """A register and the value that a write gives it."""

    register: Register
    value: int


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
        self._bytes = bytearray(table.size)
        self._pointers = _pointers(table)
        self.reset(table.registers)

    def __contains__(self, name: str) -> bool:
        return name in self.table

    def __getitem__(self, name: str) -> int:
        register = self.table[name]
        raw = self._bytes[register.address : register.end]
        return int.from_bytes(raw, "little", signed=register.signed)

    def __setitem__(self, name: str, value: int) -> None:
        register = self.table[name]
        self._bytes[register.address : register.end] = register.encode(value)

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
        span = range(address, address + length)
        if not length or span.stop > self.table.size or not any(map(self._owned, span)):
            raise AddressError(f"no register at {address}..{span.stop - 1}")
        if self.is_direct(address, length):
            return bytes(self._bytes[address : span.stop])
        return bytes(self._bytes[self._meant(at)] for at in span)

    def is_direct(self, address: int, length: int) -> bool:
        """Tell whether bytes stand for themselves, none of them being Indirect Data."""
        return self._pointers.keys().isdisjoint(range(address, address + length))

    def changes(self, address: int, data: bytes) -> list[Change]:
        """Give what a write means, register by register; nothing is changed.

        Raises:
            AddressError: If it touches bytes that are no register's, or begins within one.
            LengthError: If it covers a register in part.
        """
        addresses = [self._meant(at) for at in range(address, address + len(data))]
        found: list[Change] = []
        start = 0
        while start < len(addresses):
            register = self._beginning_at(addresses[start])
            end = start + register.size
            if addresses[start:end] != list(range(register.address, register.end)):
                raise LengthError(f"{register.name} has {register.size} bytes")
            found.append(Change(register, register.decode(data[start:end])))
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
