"""The supply that servos share: its voltage sags under their currents, and it can fail."""

from collections.abc import Sequence
from typing import Protocol

IDLE_CURRENT = 0.05
"""What a servo takes without driving its motor, A: the manuals of X servos name 40 to 60 mA."""


class Supplied(Protocol):
    """What a supply needs to know of a servo."""

    supply: "Supply | None"

    @property
    def voltage(self) -> float:
        """Its supply, V."""
        ...

    @voltage.setter
    def voltage(self, value: float) -> None: ...

    @property
    def supply_current(self) -> float:
        """What it takes from the supply, A."""
        ...

    def power_cycle(self, off_for: float = 0.0) -> None:
        """Lose the power and get it back."""
        ...


class Supply:
    """One voltage behind one resistance, with several servos on it.

    With a resistance the servos' voltages follow their currents, millisecond by millisecond;
    without one they are left as they are, so that each servo's ``voltage`` can be set by hand.
    """

    def __init__(self, voltage: float) -> None:
        """Take the voltage without load, V."""
        self.open_voltage = voltage
        """Voltage without load, V; it counts while ``resistance`` is above 0."""
        self.resistance = 0.0
        """Resistance of source, cables and plugs together, ohm."""
        self.fails_below: float | None = None
        """Voltage at which the servos brown out by themselves, V; None: they do not."""
        self.servos: tuple[Supplied, ...] = ()
        """The servos on it."""

    def connect(self, servos: Sequence[Supplied]) -> None:
        """Hang servos on it."""
        self.servos = tuple(servos)
        for servo in servos:
            servo.supply = self

    def step(self) -> None:
        """Let the voltage follow the currents of this millisecond."""
        if self.resistance <= 0.0:
            return
        current = sum(servo.supply_current for servo in self.servos)
        voltage = max(self.open_voltage - self.resistance * current, 0.0)
        for servo in self.servos:
            servo.voltage = voltage
        if self.fails_below is not None and voltage < self.fails_below:
            self.brown_out()

    def brown_out(self, off_for: float = 0.0) -> None:
        """Let all its servos lose their power and get it back after a time, s.

        They reboot: turn counts, goals and torque are gone, EEPROM stays.
        """
        for servo in self.servos:
            servo.power_cycle(off_for)
