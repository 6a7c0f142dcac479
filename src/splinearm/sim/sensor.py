"""The registers that a servo measures by itself."""

from collections.abc import Callable, Mapping
from typing import Protocol

from splinearm.drivers.model import ServoModel

from .law import POSITION_MODES, ServoLaw
from .memory import TableMemory
from .scale import ServoScale

IN_POSITION = 10
"""Ticks within which a servo counts as arrived: the manual names no figure."""

FOLLOWING = 200
"""Ticks from its trajectory beyond which a servo counts as not following: likewise."""

_TICK_TURN = 32768


class Sensed(Protocol):
    """What the registers need to know of a servo."""

    model: ServoModel
    scale: ServoScale
    memory: TableMemory
    law: ServoLaw
    torque_on: bool
    duty: float
    temperature: float
    current_offset: float

    @property
    def voltage(self) -> float:
        """Its supply, V."""
        ...

    @property
    def uptime(self) -> float:
        """Time since it was switched on, s."""
        ...

    @property
    def position(self) -> int:
        """Where it is, ticks."""
        ...

    @property
    def speed(self) -> float:
        """How fast it turns, ticks/s."""
        ...

    @property
    def motor_current(self) -> float:
        """Current of its motor, A."""
        ...


def _realtime_tick(servo: Sensed) -> float:
    return int(servo.uptime * 1e3) % _TICK_TURN


def _moving(servo: Sensed) -> float:
    threshold = servo.memory["Moving Threshold"] * servo.scale.velocity
    return servo.law.profile_ongoing or abs(servo.speed) > threshold


def _moving_status(servo: Sensed) -> float:
    bits = servo.law.profile_kind << 4 | servo.law.profile_ongoing << 1
    if servo.torque_on and servo.memory["Operating Mode"] in POSITION_MODES:
        bits |= abs(servo.memory["Goal Position"] - servo.position) <= IN_POSITION
        bits |= (abs(servo.law.position - servo.position) > FOLLOWING) << 3
    return bits


def _present_current(servo: Sensed) -> float:
    """Give the motor's current; an XL330 measures at its supply, so by the share of the duty."""
    at_supply = abs(servo.duty) if servo.model.name.startswith("XL330") else 1.0
    current = servo.motor_current * at_supply + servo.current_offset
    return current / servo.scale.current


def _present_load(servo: Sensed) -> float:
    return 1000.0 * servo.motor_current / servo.law.stall_current


MEASURED: Mapping[str, Callable[[Sensed], float]] = {
    "Realtime Tick": _realtime_tick,
    "Moving": _moving,
    "Moving Status": _moving_status,
    "Present PWM": lambda servo: servo.duty * servo.scale.full_pwm,
    "Present Current": _present_current,
    "Present Load": _present_load,
    "Present Velocity": lambda servo: servo.speed / servo.scale.velocity,
    "Present Position": lambda servo: servo.position,
    "Velocity Trajectory": lambda servo: servo.law.velocity / servo.scale.velocity,
    "Position Trajectory": lambda servo: servo.law.position,
    "Present Input Voltage": lambda servo: 10.0 * servo.voltage,
    "Present Temperature": lambda servo: servo.temperature,
}
"""How each such register gets its value, in its own unit."""
