"""What servos and the things they turn have in common: shafts, and the length of a step."""

from dataclasses import dataclass
from typing import Protocol

TIMESTEP = 1e-3
"""Time of one step of servos and plants, s."""


@dataclass(slots=True)
class Shaft:
    """The output shaft of a servo, in the joint's direction. The plant moves it."""

    angle: float = 0.0
    """Where it is, rad; joint zero is 0."""
    speed: float = 0.0
    """How fast it turns, rad/s."""
    duty: float | None = None
    """What the servo gives its motor, as a share of the nominal supply; None: the motor is cut off
    and turns freely."""
    stuck: bool = False
    """Whether something holds it fast."""


class Plant(Protocol):
    """Something that moves by what its motors do."""

    def step(self) -> None:
        """Let ``TIMESTEP`` go by: take the duties of the shafts, give their angles and speeds."""
        ...

    @property
    def speed(self) -> float:
        """How fast its quickest part moves, rad/s."""
        ...
