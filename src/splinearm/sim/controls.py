"""What a servo's registers say to its control loop, whatever they are called."""

from collections.abc import Callable, Mapping
from typing import Protocol

from splinearm.drivers.model import ServoModel

from .law import LawSettings, ServoLaw
from .memory import TableMemory
from .narrow_controls import NarrowControls
from .scale import ServoScale
from .sensor import Sensed
from .wide_controls import WideControls


class Controls(Protocol):
    """The registers of one servo by their meaning."""

    measured: Mapping[str, Callable[[Sensed], float]]
    """The registers that it measures by itself, and how."""
    goals: frozenset[str]
    """The registers that are a goal in some mode."""
    plain_goals: frozenset[str]
    """Those of them that are nothing else, no limit and no setting."""
    keeps_shut: bool
    """Whether a servo that a hardware error has cut off stays so until a reboot."""

    @property
    def mode(self) -> int:
        """The operating mode."""
        ...

    @property
    def goal(self) -> str:
        """Name of the register that the mode follows."""
        ...

    @property
    def reversed(self) -> bool:
        """Whether the direction is turned round."""
        ...

    @property
    def torque_by_goal(self) -> bool:
        """Whether a goal switches the torque on."""
        ...

    @property
    def wants_torque(self) -> bool:
        """Whether the motor shall be driven."""
        ...

    @property
    def eeprom_locked(self) -> bool:
        """Whether EEPROM is locked whatever the torque."""
        ...

    def homing(self) -> int:
        """Give the offset of the position that counts."""
        ...

    def law_settings(self) -> LawSettings:
        """Give what the registers say about the control loop."""
        ...

    def aim(self, law: ServoLaw) -> None:
        """Let the control loop have the goal of the mode."""
        ...

    def reset_goals(self, position: int) -> None:
        """Set the goals so that nothing moves, and those that limit the mode to their limits."""
        ...

    def reset_gains(self) -> None:
        """Give the gains the values of the mode."""
        ...

    def change_mode(self) -> None:
        """Let a new mode have its effect on other registers."""
        ...

    def cut(self) -> None:
        """Say in the registers that a hardware error has cut the torque."""
        ...


def controls_of(model: ServoModel, memory: TableMemory, scale: ServoScale) -> Controls:
    """Give the meaning of a model's registers."""
    if "Goal PWM" in memory:
        return WideControls(model, memory, scale)
    return NarrowControls(model, memory, scale)
