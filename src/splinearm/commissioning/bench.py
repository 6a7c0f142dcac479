"""The line on which servos are set up: spoken to at any rate, one rate at a time."""

import time
from collections.abc import Callable
from functools import partial
from types import TracebackType
from typing import NamedTuple, Self, TypeAlias

from splinearm.doctor.model_number import model_of, model_words
from splinearm.doctor.stethoscope import hushed
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.link import is_socket
from splinearm.drivers.model import ServoModel

MARGIN, QUICK_MARGIN = 0.05, 0.01
"""How long an answer may come later than the wire needs, s: where things are written nothing is in
a hurry, and an answer that is late must not be taken for that of the next question."""

Opener: TypeAlias = Callable[[str, int], DynamixelBus]
"""Opens a port at a rate."""


class Address(NamedTuple):
    """How a servo is reached."""

    baud: int
    """Bits per second."""
    protocol: int
    """1 or 2."""
    servo_id: int
    """Its id."""

    def __str__(self) -> str:
        old = ", protocol 1.0" if self.protocol == 1 else ""
        return f"id {self.servo_id} at {self.baud} baud{old}"


class Found(NamedTuple):
    """A servo that answered."""

    address: Address
    """Where."""
    model_number: int
    """Its model, as a number."""
    firmware: int
    """Version of its firmware."""

    @property
    def model(self) -> ServoModel | None:
        """Its model; None: its number is not known here."""
        return model_of(self.model_number)

    @property
    def model_words(self) -> str:
        """Its model, as it is called to people."""
        return model_words(self.model_number)


class Bench:
    """A port on which servos are set up; a with-block, which lets go of it.

    Args:
        port: The port.
        opener: Opens it; None: as a DYNAMIXEL bus.
        margin: How long an answer may come later than the wire needs, s.
        clock: Gives the time, s.
        sleep: Waits, s.
    """

    def __init__(
        self,
        port: str,
        *,
        opener: Opener | None = None,
        margin: float = MARGIN,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.port = port
        self.has_rates = not is_socket(port)
        """Whether servos at different rates can be told apart: not on a socket."""
        self.clock = clock
        self.sleep = sleep
        self._opener = partial(DynamixelBus, margin=margin) if opener is None else opener
        self._open: DynamixelBus | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the port. Twice is no error."""
        if self._open is not None:
            self._open.close()
            self._open = None

    def at(self, baud: int) -> DynamixelBus:
        """Give the line at a rate.

        Raises:
            PortError: If the port is gone, or does not have that rate.
        """
        if self._open is None or self._open.baud != baud:
            self.close()
            with hushed():
                self._open = self._opener(self.port, baud)
        return self._open

    def to(self, address: Address) -> DynamixelBus:
        """Give the line as a servo hears it.

        Raises:
            PortError: As ``at``.
        """
        bus = self.at(address.baud)
        bus.speak({address.servo_id: address.protocol})
        return bus
