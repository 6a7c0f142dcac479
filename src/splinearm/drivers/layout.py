"""Where registers that are asked for together lie side by side, in every servo at the same place.

Servos have Indirect Data: bytes that stand for whatever registers their Indirect Addresses name.
With them registers that lie apart, or elsewhere in each model, are one block at one address, which
one sync read or sync write reaches. After a reboot the bytes of most models stand for themselves
again: what is read there carries a mark, and a block that lies side by side by itself is preferred.
Source: ROBOTIS e-Manual, "Indirect Address, Indirect Data".
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple, TypeAlias

from .model import ServoModel
from .registers import Register

Field: TypeAlias = Register | int
"""A register, or a number of bytes that mean nothing."""

_ITEM = re.compile(r"Indirect (Address|Data) (\d+)")
_SHORT_BANK = 53  # XL330: from this firmware on there are 28 items with data at 224
_SHORT_BANK_ITEMS = 20
_SHORT_BANK_DATA = 208


class Pointer(NamedTuple):
    """One Indirect Address and what it shall hold."""

    address: int
    """Address of the Indirect Address."""
    target: int
    """Address of the byte that the Indirect Data shall stand for."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Place:
    """Where the block of one servo lies."""

    address: int
    """Where it begins."""
    length: int
    """Number of bytes."""
    pointers: tuple[Pointer, ...] = ()
    """Indirect Addresses that make it so, by address; empty: it lies there by itself."""

    @property
    def span(self) -> range:
        """The addresses of its bytes."""
        return range(self.address, self.address + self.length)


def side_by_side(fields: Sequence[Field]) -> int | None:
    """Give where fields begin that follow each other without a gap; None if they do not."""
    start: int | None = None
    end = 0
    for field in fields:
        if isinstance(field, int):
            if field:
                return None
            continue
        if start is not None and field.address != end:
            return None
        start = field.address if start is None else start
        end = field.end
    return start


def block_length(fields: Sequence[Field]) -> int:
    """Give the number of bytes of fields."""
    return sum(field if isinstance(field, int) else field.size for field in fields)


def indirect_items(model: ServoModel, firmware: int) -> dict[int, int]:
    """Give for the address of each Indirect Data byte the address of its Indirect Address."""
    addresses: dict[int, int] = {}
    data: dict[int, int] = {}
    for register in model.table.registers:
        match = _ITEM.fullmatch(register.name)
        if match:
            found = addresses if match[1] == "Address" else data
            found[int(match[2])] = register.address
    if model.name.startswith("XL330") and firmware < _SHORT_BANK:
        data = {k: _SHORT_BANK_DATA + k - 1 for k in range(1, _SHORT_BANK_ITEMS + 1)}
    return {address: addresses[k] for k, address in data.items()}


def common_place(
    wanted: Mapping[int, Sequence[Field]],
    items: Mapping[int, Mapping[int, int]],
    taken: Mapping[int, Place] | None = None,
) -> dict[int, Place] | None:
    """Find one address at which every servo has, or can have, its fields.

    Args:
        wanted: By id the fields of each servo, equally long.
        items: By id what ``indirect_items`` says.
        taken: By id a place whose bytes are in use already.

    Returns:
        By id where the fields are; None if there is no such address.
    """
    taken = taken or {}
    if len({block_length(fields) for fields in wanted.values()}) != 1:
        return None
    by_id = [
        _addresses(fields, items.get(number, {}), taken.get(number))
        for number, fields in wanted.items()
    ]
    shared = reduce(lambda a, b: a & b, by_id)
    if not shared:
        return None

    def cost(address: int) -> tuple[int, int]:
        return sum(side_by_side(fields) != address for fields in wanted.values()), address

    address = min(shared, key=cost)
    return {
        number: _place(fields, address, items.get(number, {})) for number, fields in wanted.items()
    }


def own_place(
    fields: Sequence[Field], items: Mapping[int, int], taken: Place | None = None
) -> Place | None:
    """Give where one servo has, or can have, its fields; None: nowhere."""
    places = common_place({0: fields}, {0: items}, None if taken is None else {0: taken})
    return None if places is None else places[0]


def _addresses(
    fields: Sequence[Field], items: Mapping[int, int], taken: Place | None
) -> frozenset[int]:
    """Give the addresses at which fields are, or can be."""
    direct = side_by_side(fields)
    length = block_length(fields)
    free = items.keys() - set(taken.span if taken is not None else ())
    starts = {a for a in free if free.issuperset(range(a, a + length))}
    return frozenset(starts if direct is None else starts | {direct})


def _place(fields: Sequence[Field], address: int, items: Mapping[int, int]) -> Place:
    """Put fields at an address; bytes that mean nothing stand for themselves."""
    length = block_length(fields)
    if side_by_side(fields) == address:
        return Place(address=address, length=length)
    targets: list[int] = []
    for field in fields:
        at = address + len(targets)
        targets += range(at, at + field) if isinstance(field, int) else range(*_ends(field))
    pairs = zip(range(address, address + length), targets, strict=True)
    pointers = sorted(Pointer(items[at], target) for at, target in pairs)
    return Place(address=address, length=length, pointers=tuple(pointers))


def _ends(register: Register) -> tuple[int, int]:
    return register.address, register.end
