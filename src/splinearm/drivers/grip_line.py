"""What a gripper's servo says, understood: how far it is open, and whether it holds something."""

from dataclasses import dataclass

from splinearm.units import RPM

from .chain import ServoSpec
from .gauge import Gauge, Measured
from .grip_force import GripForce
from .model import ServoModel

_NEAR = 0.02
"""So near to its goal it has arrived, a share of the travel."""
_NEAR_TICKS = 10
"""The same in ticks, where the travel is short."""
_STILL = 0.03
"""Slower than this it stands, a share of the travel a second."""
_PRESSING = 0.4
"""What counts as pressing, times the square of the force: an XL330 measures its current at the
supply, which is less than the motor's by the share of its output."""
_SPEEDS = ("Present Velocity", "Present Speed")
_PROFILES = ("Profile Velocity", "Moving Speed")
_TIME_BASED = 0x04
"""Bit of Drive Mode: the profile is a time, in ms, not a speed."""
_MILLI = 1e3
_UNLIMITED = 0.5
"""How long the travel takes without a limit, s: an estimate."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GripState:
    """Where a gripper is, and what it feels."""

    t: float
    """When it was asked, s on the monotonic clock."""
    percent: float
    """How far it is open: 0 is closed, 100 is open."""
    goal: float
    """How far it was last told to be open, percent."""
    effort: float
    """How hard it presses, a share of the stall torque."""
    moving: bool
    """Whether it moves."""
    arrived: bool
    """Whether it stands at its goal."""
    holding: bool
    """Whether it stands before its goal and presses: it holds something, or is blocked."""

    @property
    def words(self) -> str:
        """The same in words."""
        at = f"at {round(self.percent)} %"
        if self.holding:
            return f"holds something {at}, with {self.effort:.0%} of its torque"
        return f"{'moves' if self.moving else 'stands'} {at}, holds nothing"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GripLine:
    """How the registers of a gripper's servo that was taken are read and written."""

    model: ServoModel
    """Its model."""
    gauge: Gauge
    """Reads its answers."""
    force: GripForce
    """How hard it presses."""
    closed: int
    """Position register where it is closed, in the turn that counts now."""
    travel: int
    """Ticks from there to where it is open."""
    duration: float
    """How long its servo takes for the whole travel, s."""

    def ticks(self, percent: float) -> int:
        """Give the position register for an opening."""
        return round(self.closed + self.travel * percent / 100.0)

    def percent(self, ticks: float) -> float:
        """Give the opening of a position register."""
        return (ticks - self.closed) / self.travel * 100.0

    def effort_of(self, load: float) -> float:
        """Give Present Current in A, or Present Load as a share, without its sign."""
        amps = self.force.stall_current
        return abs(load) * self.force.effort_unit * (1.0 if amps is None else amps)

    def state(self, t: float, measured: Measured, goal: int, limit: int) -> GripState:
        """Give what an answer means.

        Args:
            t: When it was asked, s.
            measured: What it said.
            goal: Its Goal Position.
            limit: What the register holds that limits its force.
        """
        travel = abs(self.travel)
        moving = abs(measured.velocity) * self._speed_unit > _STILL * travel
        effort = abs(measured.load) * self.force.effort_unit
        near = abs(goal - measured.position) <= max(_NEAR * travel, _NEAR_TICKS)
        pressing = effort >= _PRESSING * self.force.share(limit) ** 2
        return GripState(
            t=t,
            percent=self.percent(measured.position),
            goal=self.percent(goal),
            effort=effort,
            moving=moving,
            arrived=near and not moving,
            holding=pressing and not near and not moving,
        )

    @property
    def _speed_unit(self) -> float:
        """What one step of the speed is worth, ticks/s."""
        register = next(r for r in self.gauge.registers if r.name in _SPEEDS)
        return (register.scale or 1.0) * RPM * self.model.pulses_per_rad


def profile_register(model: ServoModel) -> str | None:
    """Give the name of the register that says how fast a servo goes to its goal; None: none."""
    return next((name for name in _PROFILES if name in model.table), None)


def pace(servo: ServoSpec, travel: int, duration: float) -> int:
    """Give what that register holds for a travel in a time, of ticks and s."""
    if _is_time_based(servo):
        return round(duration * _MILLI)
    return max(round(abs(travel) / duration / _profile_unit(servo)), 1)


def duration_of(servo: ServoSpec, travel: int, raw: int) -> float:
    """Give the time that a travel takes with what that register holds, s; 0 is without a limit."""
    if raw == 0:
        return _UNLIMITED
    return raw / _MILLI if _is_time_based(servo) else abs(travel) / (raw * _profile_unit(servo))


def _is_time_based(servo: ServoSpec) -> bool:
    return bool(servo.settings.get("Drive Mode", 0) & _TIME_BASED)


def _profile_unit(servo: ServoSpec) -> float:
    """Give what one step of that register is worth, ticks/s."""
    model = servo.servo_model
    name = profile_register(model)
    scale = 1.0 if name is None else model.table[name].scale or 1.0
    return scale * RPM * model.pulses_per_rad
