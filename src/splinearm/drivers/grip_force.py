"""How hard a gripper presses: the register that limits it, and what its servo says of it.

In current-based position mode (5) that is Goal Current. In the other position modes Goal PWM limits
what the motor gets; of AX-12A and XL-320 Torque Limit does.
Source: ROBOTIS e-Manual, "Goal Current", "Goal PWM", "Torque Limit".
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from .chain import ServoSpec
from .feedforward_drive import CURRENT_POSITION_MODE
from .health_limit import stall_current
from .model import ServoModel
from .registers import Register
from .scaling import operating_mode

_LOAD_UNIT = 1e-3
_FULL = 100.0
"""What Goal PWM and Torque Limit count in: percent."""

MOST = {"Goal Current": "Current Limit", "Goal PWM": "PWM Limit", "Torque Limit": "Max Torque"}
"""The register that says how far each of those may go."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GripForce:
    """A share of a servo's stall torque as its registers say it."""

    register: Register
    """What limits it."""
    full: float
    """What that holds for all of the stall torque."""
    most: int
    """The most that it may hold."""
    effort_unit: float
    """What one step of Present Current or Present Load is worth, a share of the stall torque."""
    stall_current: float | None
    """Current at the stall torque, A; None: the servo measures none."""

    @classmethod
    def of(cls, servo: ServoSpec, supply: float, limits: Mapping[str, int]) -> Self:
        """Give how hard a servo can press.

        Args:
            servo: The servo.
            supply: What it is fed with, V.
            limits: What its registers hold that are named in ``MOST``.

        Raises:
            ValueError: If nothing in its table limits it.
        """
        model = servo.servo_model
        name = force_register(servo)
        register = model.table[name]
        amps = stall_current(model, supply) if model.has_current and model.stall else None
        scale = register.scale or 1.0
        full = _FULL / scale
        if name == "Goal Current" and amps is not None:
            full = amps / (scale * 1e-3)
        most = limits.get(MOST[name], round(full))
        return cls(
            register=register,
            full=full,
            most=most,
            effort_unit=_effort_unit(model, amps),
            stall_current=amps,
        )

    def raw(self, force: float) -> int:
        """Give what the register holds for a force, a share of the stall torque.

        Raises:
            ValueError: If it is not above 0 and at most 1, or more than the servo allows.
        """
        if not 0.0 < force <= 1.0:
            raise ValueError(f"force: want above 0 and at most 1, got {force}")
        raw = max(round(force * self.full), 1)
        if raw > self.most:
            raise ValueError(
                f"force: want at most {self.most / self.full:.2f}, which its {MOST[self.name]} of "
                f"{self.most} allows, got {force:g}"
            )
        return raw

    def share(self, raw: float) -> float:
        """Give the force of what the register holds, a share of the stall torque."""
        return raw / self.full

    @property
    def name(self) -> str:
        """Name of the register that limits."""
        return self.register.name


def force_register(servo: ServoSpec) -> str:
    """Give the name of the register that limits how hard a servo presses.

    Raises:
        ValueError: If it has none.
    """
    table = servo.servo_model.table
    if operating_mode(servo) == CURRENT_POSITION_MODE and "Goal Current" in table:
        return "Goal Current"
    for name in ("Goal PWM", "Torque Limit"):
        if name in table:
            return name
    raise ValueError(f"servo {servo.name!r}: nothing limits how hard a {servo.model} presses")


def _effort_unit(model: ServoModel, amps: float | None) -> float:
    """Give what one step of Present Current or Present Load is worth."""
    if amps is None:
        return _LOAD_UNIT
    return (model.table["Present Current"].scale or 1.0) * 1e-3 / amps
