"""Which group reads and writes carry the measurements and the goals of an arm."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np

from splinearm.arrays import FloatArray

from .bus import PingReply, ReadGroup, WriteGroup
from .chain import ServoSpec
from .crew import Crew
from .cyclic import GroupRead
from .cyclic_v1 import BulkReadV1, GroupWriteV1, OneRead
from .gauge import MARK_VALUE, Gauge
from .groups import BulkRead
from .layout import Field, Place, common_place, indirect_items, own_place
from .sending import Block, GroupWrite

_GOAL = "Goal Position"


_Part = TypeVar("_Part", "ReadPart", "WritePart")


class Extras(NamedTuple):
    """What is sent beside the goal position."""

    velocity: str | None = None
    """Register that takes a velocity."""
    current: str | None = None
    """Register that takes a current."""


class ReadPart:
    """One group read of some leaders, and what its answers mean.

    Args:
        group: The read.
        gauges: By id how the bytes of a servo are to be read.
        order: By id the number of the joint.
    """

    def __init__(
        self, group: ReadGroup, gauges: Mapping[int, Gauge], order: Mapping[int, int]
    ) -> None:
        self.group = group
        self.gauges = gauges
        self._order = order
        self._gauge = next(iter(gauges.values()))
        kinds = {gauge.kind for gauge in gauges.values()}
        self._alike = isinstance(group, GroupRead) and len(kinds) == 1 and self._gauge.plain
        self._made_for: tuple[tuple[int, ...], int] | None = None

    def take(self, answer: bytes, raw: FloatArray, seen: FloatArray, t: float) -> bool:
        """Put a flawless answer into the rows load, velocity and position of ``raw``.

        Args:
            answer: What came.
            raw: Where it goes, shape (3, n).
            seen: When each joint was seen last, shape (n,), s.
            t: The present, s.

        Returns:
            Whether it was that simple; else the replies have to be looked at one by one.
        """
        group = self.group
        if not (self._alike and isinstance(group, GroupRead) and group.same):
            return False
        if self._made_for != (group.ids, group.stride):
            self._make(group)
        if answer[group.first_error : -2 : group.stride] != self._no_error:
            return False
        blocks = np.frombuffer(answer, self._dtype, self._count, group.first_block)
        if self._gauge.marked and (blocks["mark"] != MARK_VALUE).any():
            return False
        where = self._where
        raw[0, where] = blocks["load"]
        raw[1, where] = blocks["velocity"]
        raw[2, where] = blocks["position"]
        seen[where] = t
        return True

    def _make(self, group: GroupRead) -> None:
        """Prepare for the order and the kind of the group's answers."""
        self._made_for = group.ids, group.stride
        self._count = len(group.ids)
        self._no_error = bytes(self._count)
        self._dtype = self._gauge.dtype(group.stride, group.first_data - group.first_block)
        self._where = np.array([self._order[servo_id] for servo_id in group.ids])


class WritePart:
    """One group write to some targets.

    Args:
        group: The write.
        columns: For each of its values the kind, 0 goal, 1 velocity, 2 current, and the number of
            the target.
    """

    def __init__(self, group: WriteGroup, columns: Sequence[tuple[int, int]]) -> None:
        self.group = group
        self.kinds = frozenset(kind for kind, _ in columns)
        """The kinds of its values."""
        self._columns = tuple(columns)
        self._goals_only = all(kind == 0 for kind, _ in columns)
        self._indices = [i for _, i in columns]
        self._all = self._indices == list(range(len(columns)))

    def values(self, rows: Sequence[Sequence[int]]) -> Sequence[int]:
        """Give the values of the group, of rows of goals, velocities and currents."""
        if self._goals_only:
            goals = rows[0]
            if self._all and len(goals) == len(self._indices):
                return goals
            return [goals[i] for i in self._indices]
        return [rows[kind][i] for kind, i in self._columns]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Traffic:
    """All that is sent and asked in a cycle."""

    reads: tuple[ReadPart, ...]
    """The reads, one after the other."""
    writes: tuple[WritePart, ...]
    """The writes, one after the other."""
    places: Mapping[int, tuple[Place, ...]] = field(default_factory=dict)
    """By id the places whose Indirect Addresses must be written."""


def direct_traffic(crew: Crew, roll: Mapping[int, PingReply], extras: Extras) -> Traffic:
    """Plan for registers where they are: what works at any time.

    Raises:
        ValueError: If a servo has no goal, or its motion does not lie side by side.
    """
    gauges = {s.servo_id: Gauge.of(s.servo_model) for s in crew.leaders}
    seen = {i: _direct(gauge.registers, f"servo {i}") for i, gauge in gauges.items()}
    writes: list[WritePart] = []
    for kind, name in enumerate((_GOAL, extras.velocity, extras.current)):
        fields = {s.servo_id: _field(s, name) for s in crew.targets if _has(s, name)}
        given = {i: _direct(field, f"servo {i}") for i, field in fields.items()}
        writes += _writes(crew, roll, fields, given, (kind,))
    old = [s.servo_id for s in crew.leaders if roll[s.servo_id].protocol == 1]
    reads = (*_group_reads(crew, roll, gauges, seen, 2), *single_reads(crew, roll, old))
    return Traffic(reads=reads, writes=tuple(writes))


def gathered_traffic(
    crew: Crew, roll: Mapping[int, PingReply], extras: Extras, direct: Traffic
) -> Traffic:
    """Plan for registers that Indirect Data bring side by side; where they cannot, as ``direct``.

    Only servos of Protocol 2.0 have Indirect Data; those of 1.0 go by themselves.
    """
    items = {
        s.servo_id: indirect_items(s.servo_model, roll[s.servo_id].firmware)
        for s in crew.everyone
        if roll[s.servo_id].protocol == 2
    }
    leaders = [s for s in crew.leaders if s.servo_id in items]
    gathered, seen = _gathered_gauges(leaders, items)
    reads = _of_protocol(direct.reads, roll, 2)
    if seen:
        reads = _group_reads(crew, roll, gathered, seen, 2)
    gauges = {s.servo_id: Gauge.of(s.servo_model) for s in crew.leaders}
    spots = {i: _direct(gauge.registers, f"servo {i}") for i, gauge in gauges.items()}
    reads += _group_reads(crew, roll, gauges, spots, 1)
    reads += single_reads(crew, roll, [i for i in gauges if i not in items and not _bulk(crew, i)])
    writes = direct.writes
    obedient = (*crew.targets, *crew.coupled)  # coupled servos obey what goes to their leaders
    fields = {
        s.servo_id: _goal_fields(s, obedient, extras) for s in obedient if s.servo_id in items
    }
    given = common_place(fields, items, seen) if fields else None
    if given is not None:
        gathered_writes = _writes(crew, roll, fields, given, (0, 1, 2))
        writes = tuple(gathered_writes) + _of_protocol(direct.writes, roll, 1)
    places = {
        i: tuple(p for p in (seen.get(i), (given or {}).get(i)) if p is not None and p.pointers)
        for i in items
    }
    return Traffic(
        reads=reads, writes=writes, places={i: found for i, found in places.items() if found}
    )


def _gathered_gauges(
    leaders: Sequence[ServoSpec], items: Mapping[int, Mapping[int, int]]
) -> tuple[dict[int, Gauge], dict[int, Place]]:
    """Find one address for the motion of all leaders; nothing if there is none.

    Where it takes Indirect Data, each block carries a mark.
    """
    for marked in (False, True) if leaders else ():
        gauges = {s.servo_id: Gauge.of(s.servo_model, marked=marked) for s in leaders}
        fields = {s.servo_id: gauges[s.servo_id].fields(s.servo_model) for s in leaders}
        places = common_place(fields, items)
        if places is not None and (marked or not any(p.pointers for p in places.values())):
            return gauges, places
    return {}, {}


def _group_reads(
    crew: Crew,
    roll: Mapping[int, PingReply],
    gauges: Mapping[int, Gauge],
    places: Mapping[int, Place],
    protocol: int,
) -> tuple[ReadPart, ...]:
    """Make one read of the leaders that have a place and speak a protocol; none if none does."""
    servos = [s for s in crew.leaders if roll[s.servo_id].protocol == protocol]
    servos = [s for s in servos if s.servo_id in places]
    if protocol == 1:
        servos = [s for s in servos if _bulk(crew, s.servo_id)]
    if not servos:
        return ()
    requests = [_request(s, places[s.servo_id]) for s in servos]
    fast = all(s.servo_model.has_fast_read(roll[s.servo_id].firmware) for s in servos)
    group = GroupRead(requests, fast=fast) if protocol == 2 else BulkReadV1(requests)
    own = {s.servo_id: gauges[s.servo_id] for s in servos}
    return (ReadPart(group, own, _order(crew)),)


def single_reads(
    crew: Crew, roll: Mapping[int, PingReply], ids: Collection[int]
) -> tuple[ReadPart, ...]:
    """Make reads of some leaders one after the other, where their registers are."""
    parts: list[ReadPart] = []
    for servo in crew.leaders:
        if servo.servo_id in ids:
            gauge = Gauge.of(servo.servo_model)
            request = _request(servo, _direct(gauge.registers, servo.name))
            group = OneRead(request, roll[servo.servo_id].protocol)
            parts.append(ReadPart(group, {servo.servo_id: gauge}, _order(crew)))
    return tuple(parts)


def _bulk(crew: Crew, servo_id: int) -> bool:
    """Say whether a leader may know bulk reads in Protocol 1.0: those that speak only that do not.

    Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 1.0", Bulk Read: of the old models only MX.
    """
    return any(s.servo_id == servo_id and 2 in s.servo_model.protocols for s in crew.leaders)


def _order(crew: Crew) -> dict[int, int]:
    """Give by id the number of the joint of each leader."""
    return {servo.servo_id: i for i, servo in enumerate(crew.leaders)}


def _request(servo: ServoSpec, place: Place) -> BulkRead:
    return BulkRead(servo.servo_id, place.address, place.length)


def _writes(
    crew: Crew,
    roll: Mapping[int, PingReply],
    fields: Mapping[int, Sequence[Field]],
    places: Mapping[int, Place],
    kinds: Sequence[int],
) -> list[WritePart]:
    """Make the writes to targets that have a place: one to those of Protocol 2.0.

    To those of Protocol 1.0 there is one for each place.
    """
    parts: list[WritePart] = []
    numbered = [(i, s.servo_id) for i, s in enumerate(crew.targets) if s.servo_id in places]
    modern = [(i, n) for i, n in numbered if roll[n].protocol == 2]
    old = [(i, n) for i, n in numbered if roll[n].protocol == 1]
    spots = sorted({(places[n].address, places[n].length) for _, n in old})
    at = [[(i, n) for i, n in old if (places[n].address, places[n].length) == p] for p in spots]
    for own in (modern, *at):
        blocks = [Block(n, places[n].address, tuple(fields[n])) for _, n in own]
        columns = [
            (kind, i)
            for i, number in own
            for kind, field in zip(kinds, fields[number], strict=True)
            if not isinstance(field, int)
        ]
        if own:
            group = GroupWrite(blocks) if own is modern else GroupWriteV1(blocks)
            parts.append(WritePart(group, columns))
    return parts


def _of_protocol(
    parts: Sequence[_Part], roll: Mapping[int, PingReply], protocol: int
) -> tuple[_Part, ...]:
    """Give the parts of one protocol."""
    return tuple(part for part in parts if roll[part.group.ids[0]].protocol == protocol)


def _goal_fields(
    servo: ServoSpec, servos: Sequence[ServoSpec], extras: Extras
) -> tuple[Field, ...]:
    """Give the goal of a servo and what is sent beside it, padded where others have more."""
    fields: list[Field] = [servo.servo_model.table[_GOAL]]
    for name in (extras.velocity, extras.current):
        tables = [other.servo_model.table for other in servos]
        sizes = [table[name].size for table in tables if name is not None and name in table]
        if name is not None and name in servo.servo_model.table:
            fields.append(servo.servo_model.table[name])
        else:
            fields.append(max(sizes, default=0))
    return tuple(fields)


def _has(servo: ServoSpec, name: str | None) -> bool:
    return name is not None and name in servo.servo_model.table


def _field(servo: ServoSpec, name: str | None) -> tuple[Field, ...]:
    return () if name is None else (servo.servo_model.table[name],)


def _direct(fields: Sequence[Field], whose: str) -> Place:
    """Give where fields lie by themselves."""
    place = own_place(fields, {})
    if place is None:
        raise ValueError(f"{whose} cannot be a joint: want its motion side by side")
    return place
