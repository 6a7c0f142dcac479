"""What the motors of an arm can give, from its servos or from its limits."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite

from splinearm.drivers.chain import ServoChain
from splinearm.drivers.model import ServoModel
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.units import RPM

NOMINAL_VOLTAGES = (12.0, 5.0, 7.4, 24.0)
"""Supplies that the maker recommends; of a model's figures those at the first of these hold, V."""

MOTOR_TIME_CONSTANT = 0.05
"""Inertia of a motor's rotor at the output, as the time in which the unloaded motor comes to 63 %
of its no-load speed, s. An estimate: the MuJoCo Menagerie model of ROBOTIS OP3, whose joints are
XM430-W350 servos, has a reflected inertia of 0.045 kg m2, which makes 0.053 s."""

FRICTION_SHARE = 0.0075
"""Dry friction of motor and gear as a share of the stall torque: an estimate from the same model
(0.03 N m of 4.1 N m)."""

RATED = {"PH42-020-S300": (5.1, 29.2, 1.5, 0.57)}
"""Continuous torque (N m), speed there (rev/min), current there and without load (A) of models
whose stall figures are not published, at the supply of their no-load speed. Source: ROBOTIS
e-Manual."""

NO_LOAD_MARGIN = 2.0
"""No-load speed over highest allowed speed of a motor that is known by its limits only: at the
highest allowed speed it still has half of its torque."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Motor:
    """A geared motor at full supply, with the straight line of a DC motor.

    ``torque = stall_torque * (duty - speed / no_load_speed)`` for a duty in -1..1. For a joint that
    slides read N for N m and m/s for rad/s.
    """

    stall_torque: float
    """Torque at standstill and full duty, N m."""
    no_load_speed: float
    """Speed at which no torque is left, rad/s."""
    stall_current: float | None = None
    """Current at standstill and full duty, A; None: not known."""

    def __post_init__(self) -> None:
        for name in ("stall_torque", "no_load_speed"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise ValueError(f"{name}: want a finite number above zero, got {value}")

    @property
    def armature(self) -> float:
        """Inertia of the rotor as felt at the output, kg m2; see ``MOTOR_TIME_CONSTANT``."""
        return MOTOR_TIME_CONSTANT * self.stall_torque / self.no_load_speed

    @property
    def friction(self) -> float:
        """Dry friction at the output, N m; see ``FRICTION_SHARE``."""
        return FRICTION_SHARE * self.stall_torque


def motor_of(model: ServoModel) -> Motor:
    """Give the motor of a servo model at its nominal supply.

    Where the stall figures are not published, the line goes through the no-load speed and the
    continuous torque, and the current with it.

    Raises:
        ValueError: If neither is published.
    """
    voltage = nominal_voltage(model)
    no_load = next(row for row in model.no_load if row.voltage == voltage)
    if not model.stall:
        torque, rpm, current, idle = RATED[model.name]
        share = 1.0 - rpm * RPM / no_load.speed
        return Motor(
            stall_torque=torque / share,
            no_load_speed=no_load.speed,
            stall_current=idle + (current - idle) / share,
        )
    stall = next(row for row in model.stall if row.voltage == voltage)
    return Motor(
        stall_torque=stall.torque, no_load_speed=no_load.speed, stall_current=stall.current
    )


def nominal_voltage(model: ServoModel) -> float:
    """Give the supply at which a servo model is simulated, V.

    Raises:
        ValueError: If the maker publishes neither stall nor continuous torque for it.
    """
    rows = model.stall or (model.no_load if model.name in RATED else ())
    known = {row.voltage for row in rows}
    for voltage in NOMINAL_VOLTAGES:
        if voltage in known:
            return voltage
    raise ValueError(f"servo model {model.name}: its stall torque is not published")


def together(motors: Iterable[Motor]) -> Motor:
    """Give the one motor that is worth several on the same shaft: their lines add up."""
    motors = tuple(motors)
    stall = sum(motor.stall_torque for motor in motors)
    slope = sum(motor.stall_torque / motor.no_load_speed for motor in motors)
    currents = [motor.stall_current for motor in motors]
    known = [current for current in currents if current is not None]
    return Motor(
        stall_torque=stall,
        no_load_speed=stall / slope,
        stall_current=sum(known) if len(known) == len(currents) else None,
    )


def motors_from_chain(chain: ServoChain, joint_names: Sequence[str]) -> tuple[Motor, ...]:
    """Give the motor of each joint: its leader and all its shadows together.

    Raises:
        ValueError: If no servo moves a joint, or a model's stall torque is not published.
    """
    chain.leaders_of(joint_names)
    return tuple(
        together(motor_of(servo.servo_model) for servo in chain.servos if servo.joint == name)
        for name in joint_names
    )


def motors_from_limits(limits: JointLimits) -> tuple[Motor, ...]:
    """Give for each joint a motor that reaches its torque limit, with speed to spare.

    Raises:
        ValueError: If the torque limits are not known.
    """
    if limits.torque_max is None:
        raise ValueError(
            "limits: the torque limits are not known, so neither is what the motors can give; "
            "set torque_max or name the servos"
        )
    return tuple(
        Motor(stall_torque=float(torque), no_load_speed=NO_LOAD_MARGIN * float(speed))
        for torque, speed in zip(limits.torque_max, limits.qd_max, strict=True)
    )


def require_turning(arm: Arm) -> None:
    """Refuse an arm with a joint that slides: how far a servo's turn moves it is not known.

    Raises:
        ValueError: With the first such joint.
    """
    for link in arm.links:
        if link.kind is JointKind.PRISMATIC:
            raise ValueError(f"joint {link.name!r} slides; servos move joints that turn")


def motors_for(arm: Arm, chain: ServoChain | None) -> tuple[Motor, ...]:
    """Give the motor of each joint of an arm, from its servos if it has some, else its limits.

    Raises:
        ValueError: If they cannot be known from either.
    """
    if chain is None:
        return motors_from_limits(arm.limits)
    require_turning(arm)
    return motors_from_chain(chain, arm.joint_names)
