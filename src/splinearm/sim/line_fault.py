"""What goes wrong on the wires between a client and its servos, and how often.

A ``LineFault`` is a value; ``LineFaults`` is what a bus makes of those that are set, with its count
and its dice. What goes wrong inside a servo is the servo's business.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from random import Random


class FaultKind(StrEnum):
    """What goes wrong. A servo that is not ``DEAD`` has obeyed all the same."""

    LOST = "lost"
    """A reply never comes; in a fast read the answer ends there."""
    CORRUPT = "corrupt"
    """One byte of a reply is another."""
    GARBLED = "garbled"
    """Each byte of a reply is another with the fault's probability."""
    TRUNCATED = "truncated"
    """The end of a reply is missing."""
    DOUBLED = "doubled"
    """A reply comes twice."""
    LATE = "late"
    """A reply comes ``seconds`` later."""
    NOISE = "noise"
    """``size`` bytes of noise precede a reply."""
    ECHO = "echo"
    """The adapter hears itself: the request comes back, before the reply."""
    DEAD = "dead"
    """A servo neither hears nor answers; without an id: the cable to all of them is cut."""
    PAUSE = "pause"
    """The bus does nothing for ``seconds`` once a request has come."""


_OF_THE_BUS = (FaultKind.ECHO, FaultKind.PAUSE)
_SAID = re.compile(r"(id|p|n|for|by|size)=([0-9.eE+-]+)")


@dataclass(frozen=True, slots=True, kw_only=True)
class LineFault:
    """One thing that goes wrong: every time, now and then, so many times, or for so long."""

    kind: FaultKind
    """What."""
    servo_id: int | None = None
    """Whose replies it strikes; None: everyone's."""
    probability: float = 1.0
    """How often, 0..1."""
    times: int | None = None
    """How many times; None: as long as it is set."""
    lasting: float | None = None
    """For how long from the moment it is set, s; None: as long as it is set."""
    seconds: float = 0.05
    """By how much something is late, s."""
    size: int = 4
    """How many bytes of noise."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", FaultKind(self.kind))
        if not 0.0 <= self.probability <= 1.0:
            raise ValueError(f"probability: want 0..1, got {self.probability}")
        if self.seconds < 0.0 or self.size < 0:
            raise ValueError(f"fault: want seconds and size of 0 or more, got {self}")
        if self.kind in _OF_THE_BUS and self.servo_id is not None:
            raise ValueError(f"servo_id: {self.kind.value} is of no servo, got {self.servo_id}")

    @classmethod
    def parse(cls, text: str) -> "LineFault":
        """Give the fault that words describe, as in ``late id=3 p=0.01 n=5 for=2.5 by=0.05``.

        Raises:
            ValueError: If they describe none.
        """
        name, *said = text.split() or [""]
        kinds = [kind.value for kind in FaultKind]
        if name not in kinds:
            raise ValueError(f"fault: want one of {', '.join(kinds)}, got {name!r}")
        matches = [_SAID.fullmatch(word) for word in said]
        if None in matches:
            raise ValueError(f"fault: want id= p= n= for= by= size= and numbers, got {text!r}")
        given = {match[1]: match[2] for match in matches if match}
        return cls(
            kind=FaultKind(name),
            servo_id=int(given["id"]) if "id" in given else None,
            probability=float(given.get("p", 1.0)),
            times=int(given["n"]) if "n" in given else None,
            lasting=float(given["for"]) if "for" in given else None,
            seconds=float(given.get("by", 0.05)),
            size=int(given.get("size", 4)),
        )


class LineFaults:
    """Faults with their dice; used by the thread that serves the line, and by no other."""

    def __init__(
        self, faults: Sequence[LineFault] = (), *, clock: Callable[[], float], seed: int = 0
    ) -> None:
        """Take faults.

        Args:
            faults: What may go wrong; of several of a kind the first that strikes counts.
            clock: Gives the time, s.
            seed: Makes the same dice.
        """
        self.faults = tuple(faults)
        """What may go wrong."""
        self.dice = Random(seed)  # noqa: S311 - no secrets
        """What chance decides by."""
        self._clock = clock
        self._left = [fault.times for fault in self.faults]
        begun = clock() if self.faults else 0.0
        self._ends = [
            None if fault.lasting is None else begun + fault.lasting for fault in self.faults
        ]

    def strikes(self, kind: FaultKind, servo_id: int | None = None) -> LineFault | None:
        """Give the fault of a kind that strikes a servo now, if one does."""
        for k, fault in enumerate(self.faults):
            if not self._concerns(k, kind, servo_id):
                continue
            if fault.probability < 1.0 and self.dice.random() >= fault.probability:
                continue
            left = self._left[k]
            self._left[k] = None if left is None else left - 1
            return fault
        return None

    def spoil(self, data: bytes, first: int = 0, end: int | None = None) -> bytes:
        """Give bytes of which those from ``first`` to before ``end`` are others."""
        spoilt = bytearray(data)
        for k in range(first, len(data) if end is None else min(end, len(data))):
            spoilt[k] ^= self.dice.randrange(1, 256)
        return bytes(spoilt)

    def on_the_way(self, data: bytes, servo_id: int) -> tuple[bytes, float]:
        """Give what becomes of a reply, and by how much it is late, s."""
        if not self.faults:
            return data, 0.0
        if self.strikes(FaultKind.CORRUPT, servo_id):
            at = self.dice.randrange(len(data))
            data = self.spoil(data, at, at + 1)
        data = self._garbled(data, servo_id)
        if self.strikes(FaultKind.TRUNCATED, servo_id):
            data = data[: self.dice.randrange(1, len(data))]
        if self.strikes(FaultKind.DOUBLED, servo_id):
            data += data
        noise = self.strikes(FaultKind.NOISE, servo_id)
        if noise:
            data = self.dice.randbytes(noise.size) + data
        late = self.strikes(FaultKind.LATE, servo_id)
        return data, late.seconds if late else 0.0

    def _garbled(self, data: bytes, servo_id: int) -> bytes:
        """Give a reply of which each byte may have been struck by itself."""
        for k, fault in enumerate(self.faults):
            if not self._concerns(k, FaultKind.GARBLED, servo_id):
                continue
            for at in range(len(data)):
                if self.dice.random() < fault.probability:
                    data = self.spoil(data, at, at + 1)
        return data

    def _concerns(self, k: int, kind: FaultKind, servo_id: int | None) -> bool:
        """Tell whether fault k is of a kind and may strike a servo now."""
        fault, end = self.faults[k], self._ends[k]
        if fault.kind is not kind or fault.servo_id not in (None, servo_id):
            return False
        return self._left[k] != 0 and (end is None or self._clock() < end)
