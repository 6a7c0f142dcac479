"""What is to be written into one servo: register by register, from what to what."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.registers import Register

from .bench import Address
from .image import ControlImage

ADDRESSING = ("ID", "Baud Rate", "Protocol Type")
"""The registers after which a servo is reached otherwise, in the order in which setup writes."""

STARTUP, TORQUE_AT_START = "Startup Configuration", 1
"""The register, and its bit, by which a servo switches its torque on when it gets its power."""

LEVEL, ANSWER_ALL = "Status Return Level", 2
"""The register that says what a servo answers, and its value for every instruction."""

SECONDARY_ID = "Secondary(Shadow) ID"
"""The register with a second id that a servo obeys without answering to it."""


class Change(NamedTuple):
    """A register that is to hold something else."""

    register: Register
    """The register."""
    old: int
    """What it holds."""
    new: int
    """What it shall hold."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Task:
    """What is to be done to one servo."""

    name: str
    """What the arm's file calls it, or how it was found."""
    image: ControlImage
    """What it holds now."""
    changes: tuple[Change, ...]
    """What is to be written, in the order in which it is."""
    servo: ServoSpec | None = None
    """The servo of the arm's file that it is; None: none, or not known which."""
    errors: tuple[str, ...] = ()
    """The hardware errors that it has latched; a reboot clears them."""

    @property
    def is_done(self) -> bool:
        """Whether nothing is left to do."""
        return not (self.changes or self.errors)

    @property
    def has_torque(self) -> bool:
        """Whether its torque is on, so that its EEPROM is closed."""
        return bool(self.image.value("Torque Enable"))

    @property
    def wakes(self) -> bool:
        """Whether it switches its torque on by itself when it starts, once all is written."""
        last = {change.register.name: change.new for change in self.changes}
        return bool(last.get(STARTUP, self.image.value(STARTUP) or 0) & TORQUE_AT_START)

    @property
    def moves(self) -> tuple[Change, ...]:
        """The changes after which it is reached otherwise."""
        return tuple(change for change in self.changes if change.register.name in ADDRESSING)

    @property
    def fills(self) -> tuple[Change, ...]:
        """All other changes."""
        return tuple(change for change in self.changes if change.register.name not in ADDRESSING)

    def path(self, here: Address) -> Sequence[Address]:
        """Give where it is reached after each of its moves.

        Args:
            here: Where it is reached before.
        """
        path: list[Address] = []
        for change in self.moves:
            here = moved(here, self.image, change)
            path.append(here)
        return path


def moved(here: Address, image: ControlImage, change: Change) -> Address:
    """Give where a servo is reached once a register is written."""
    name, value = change.register.name, change.new
    if name == "ID":
        return here._replace(servo_id=value)
    if name == "Baud Rate":
        return here._replace(baud=image.model.baud_codes.get(value, here.baud))
    if name == "Protocol Type":
        return here._replace(protocol=value)
    return here


def in_words(change: Change) -> str:
    """Give a change in a line."""
    return f"{change.register.name} {change.old} -> {change.new}"
