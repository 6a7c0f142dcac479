"""How a virtual bus is wired to its client."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias, TypedDict

from .habit import LineHabits

Transport: TypeAlias = Literal["pty", "socket"]


class BusOptions(TypedDict, total=False):
    """The fields of ``Wiring``, as arguments; what is left out is as there."""

    transport: Transport
    wire_time: bool
    usb_latency: float
    realtime: bool
    habits: LineHabits
    seed: int
    link: Path | None
    fresh: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """How a virtual bus is wired to its client."""

    transport: Transport = "pty"
    """A pseudo terminal, which every program can open, or a unix socket."""
    wire_time: bool = True
    """Whether bytes take time."""
    usb_latency: float = 0.0
    """Replies are held back to the next of such ticks, s, as an FTDI adapter does; 0: they are not.
    """
    realtime: bool = False
    """Whether the thread goes before all that are not real-time and the process' memory is locked,
    where the system permits it; of use in a process of its own."""
    habits: LineHabits = field(default_factory=LineHabits)
    """What servos do where the manual is silent."""
    seed: int = 0
    """Makes the same dice for faults."""
    link: Path | None = None
    """A symbolic link that leads to the port, whatever its name is; None: none."""
    fresh: bool = False
    """Whether servos are as they come out of the box: factory settings, and none connected yet."""

    def __post_init__(self) -> None:
        if self.transport not in ("pty", "socket"):
            raise ValueError(f"transport: want 'pty' or 'socket', got {self.transport!r}")
        if not 0.0 <= self.usb_latency <= 1.0:
            raise ValueError(f"usb_latency: want 0..1 s, got {self.usb_latency}")
