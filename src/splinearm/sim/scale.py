"""What the numbers in a servo's registers mean to its control loop."""

from dataclasses import dataclass
from math import tau

from splinearm.drivers.model import ServoModel

REVERSE = 0x01
TIME_BASED = 0x04
TORQUE_ON_BY_GOAL = 0x08
"""Bits of Drive Mode."""

MILLI = 1e-3

_FULL_TORQUE = 1023  # Max Torque and Torque Limit of servos without PWM registers


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoScale:
    """Steps of a model's registers in ticks, seconds, amperes and shares of the full duty."""

    per_rad: float
    """Ticks a radian."""
    velocity: float
    """A step of velocity, ticks/s."""
    acceleration: float
    """A step of Profile Acceleration, ticks/s2; 0 if the model has none."""
    current: float
    """A step of current, A; 0 if the model has none."""
    full_pwm: int
    """Steps of PWM to the full duty."""

    @classmethod
    def of(cls, model: ServoModel) -> "ServoScale":
        """Give the scale of a model.

        Raises:
            ValueError: If the unit of a register is not known.
        """
        per_turn = model.pulses_per_rad * tau
        if "PWM Limit" not in model.table:
            return cls(
                per_rad=model.pulses_per_rad,
                velocity=_step(model, "Moving Speed") / 60.0 * per_turn,
                acceleration=0.0,
                current=0.0,
                full_pwm=_FULL_TORQUE,
            )
        return cls(
            per_rad=model.pulses_per_rad,
            velocity=_step(model, "Goal Velocity") / 60.0 * per_turn,
            acceleration=_step(model, "Profile Acceleration") / 3600.0 * per_turn,
            current=_step(model, "Goal Current") * MILLI if model.has_current else 0.0,
            full_pwm=_full_pwm(model),
        )


def _step(model: ServoModel, register: str) -> float:
    """Give what a step of a register is worth in its own unit."""
    step = model.table[register].scale
    if step is None:
        raise ValueError(f"servo model {model.name}: the unit of {register} is not known")
    return step


def _full_pwm(model: ServoModel) -> int:
    """Give the steps of PWM to the full duty: the highest PWM Limit."""
    limit = model.table["PWM Limit"]
    return limit.maximum if isinstance(limit.maximum, int) else limit.span[1]
