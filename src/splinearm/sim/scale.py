"""What the numbers in a servo's registers mean to its control loop."""

from dataclasses import dataclass
from math import inf, tau

from splinearm.drivers.model import ServoModel

from .law import LawSettings, Mode
from .memory import TableMemory

REVERSE = 0x01
TIME_BASED = 0x04
TORQUE_ON_BY_GOAL = 0x08
"""Bits of Drive Mode."""

_MILLI = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoScale:
    """Steps of a model's registers in ticks, seconds, amperes and shares of the full duty."""

    per_rad: float
    """Ticks a radian."""
    velocity: float
    """A step of velocity, ticks/s."""
    acceleration: float
    """A step of Profile Acceleration, ticks/s2."""
    current: float
    """A step of current, A; 0 if the model has none."""
    full_pwm: int
    """Steps of PWM to the full duty."""

    @classmethod
    def of(cls, model: ServoModel) -> "ServoScale":
        """Give the scale of a model.

        Raises:
            ValueError: If it is not a Protocol 2.0 servo with operating modes and known units.
        """
        table = model.table
        full_pwm = table["PWM Limit"].maximum if "PWM Limit" in table else None
        if 2 not in model.protocols or not model.stall or not isinstance(full_pwm, int):
            raise ValueError(f"servo model {model.name} cannot be simulated")
        per_turn = model.pulses_per_rad * tau
        return cls(
            per_rad=model.pulses_per_rad,
            velocity=_step(model, "Goal Velocity") / 60.0 * per_turn,
            acceleration=_step(model, "Profile Acceleration") / 3600.0 * per_turn,
            current=_step(model, "Goal Current") * _MILLI if model.has_current else 0.0,
            full_pwm=full_pwm,
        )


def law_settings(memory: TableMemory, scale: ServoScale) -> LawSettings:
    """Give what the registers say about the control loop."""
    mode = memory["Operating Mode"]
    time_based = bool(memory["Drive Mode"] & TIME_BASED)
    pwm = memory["PWM Limit"]
    if mode != Mode.PWM:
        pwm = min(pwm, abs(memory["Goal PWM"]))
    top_velocity, acceleration = _profile(memory, scale, time_based=time_based)
    return LawSettings(
        mode=mode,
        p=memory["Position P Gain"] / 128.0,
        i=memory["Position I Gain"] / 65536.0,
        d=memory["Position D Gain"] / 16.0,
        ff1=memory["Feedforward 1st Gain"] / 4.0,
        ff2=memory["Feedforward 2nd Gain"] / 4.0,
        vp=memory["Velocity P Gain"] / 128.0,
        vi=memory["Velocity I Gain"] / 65536.0,
        velocity_unit=scale.velocity,
        full_pwm=float(scale.full_pwm),
        duty_limit=pwm / scale.full_pwm,
        current_limit=_current_limit(memory, scale) if mode == Mode.CURRENT_POSITION else inf,
        top_velocity=top_velocity,
        acceleration=acceleration,
        time_based=time_based,
    )


def _current_limit(memory: TableMemory, scale: ServoScale) -> float:
    return scale.current * min(memory["Current Limit"], abs(memory["Goal Current"]))


def _profile(memory: TableMemory, scale: ServoScale, *, time_based: bool) -> tuple[float, float]:
    """Give top velocity and acceleration, or total time and time of a ramp."""
    velocity, acceleration = memory["Profile Velocity"], memory["Profile Acceleration"]
    if time_based:
        return velocity * _MILLI, acceleration * _MILLI
    velocity = min(velocity, memory["Velocity Limit"])
    return velocity * scale.velocity, acceleration * scale.acceleration


def _step(model: ServoModel, register: str) -> float:
    """Give what a step of a register is worth in its own unit."""
    step = model.table[register].scale
    if step is None:
        raise ValueError(f"servo model {model.name}: the unit of {register} is not known")
    return step
