"""How stiff a position servo is and how far it lags, from what its maker says of it.

With its profile off a servo of the X series drives its motor by::

    PWM = P/128 * (goal - position) + I/65536 * sum of that - D/16 * velocity

in ticks and milliseconds, full duty being 885 steps (ROBOTIS e-Manual, X series, "Position PID
Gain", "PWM Limit"; that velocity counts a millisecond is an assumption). A DC motor at that duty
gives ``stall torque * (duty - speed / no-load speed)``, both figures in proportion to the supply.
Hence for a joint that moves as wanted, with k and d added up over all servos at it::

    goal - position = (torque + inertia * qdd + friction + d * qd) / k
    k = stall torque * P/128 / 885 * ticks a radian
    d = stall torque / no-load speed + stall torque * D/16 / 885 * ticks a radian / 1000

In current-based position mode the same controller asks for a current, a step of it being one of
Goal Current, and the current's own controller makes up for the speed: stall torque / 885 is then
torque per ampere * that step, and of d the first part is gone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Self

import numpy as np

from splinearm.arrays import FloatArray

from .asking import read_all
from .bus import ServoBus
from .chain import ServoChain, ServoSpec
from .model import ServoModel
from .scaling import operating_mode
from .startup import let_all_answer

CURRENT_POSITION_MODE = 5
"""Operating mode "current-based position"."""

FRICTION_SHARE = 0.0075
"""Dry friction of motor and gear as a share of the stall torque: 0.03 N m of 4.1 N m in the MuJoCo
Menagerie model of ROBOTIS OP3, whose joints are XM430-W350 servos."""

MOTOR_TIME = 0.05
"""Inertia of the rotor at the horn as the time in which the unloaded motor comes to 63 % of its
speed, s: the same model's 0.045 kg m2 make 0.053 s."""

_GAINS = ("Position P Gain", "Position I Gain", "Position D Gain")
_PROFILE = ("Profile Velocity", "Profile Acceleration")
_VOLTAGE = "Present Input Voltage"
_USUAL_SUPPLIES = (12.0, 5.0, 7.4, 24.0)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class JointDrive:
    """The servos at one joint, taken together."""

    stiffness: float = 0.0
    """Torque a radian that the joint hangs behind its goal, N m/rad; 0: not known."""
    damping: float = 0.0
    """Torque a rad/s that the servos lose when they turn, N m s/rad."""
    friction: float = 0.0
    """Dry friction, N m: an estimate."""
    inertia: float = 0.0
    """Inertia of the rotors at the joint, kg m2: an estimate."""
    reach: float = inf
    """How far behind its goal a joint at rest gets all that its servos can give, rad."""
    integrates: bool = False
    """Whether an I gain takes the weight by and by; then the goal must not be shifted for it."""
    why_not: str = ""
    """Why it cannot be led; empty: it can."""

    @property
    def lag(self) -> float:
        """How long behind its goal the joint is when it moves and carries nothing, s."""
        return self.damping / self.stiffness if self.stiffness else inf

    @classmethod
    def of(cls, servos: Sequence[ServoSpec], held: Mapping[str, Mapping[int, int]]) -> Self:
        """Give what servos at one joint do together.

        Args:
            servos: Leader and shadows.
            held: What ``read_tuning`` read; empty: what the file and the factory say.
        """
        drives = [_one(servo, held) for servo in servos]
        for servo, drive in zip(servos, drives, strict=True):
            if drive.why_not:
                return cls(why_not=f"servo {servo.name!r} {drive.why_not}")
        return cls(
            stiffness=sum(drive.stiffness for drive in drives),
            damping=sum(drive.damping for drive in drives),
            friction=sum(drive.friction for drive in drives),
            inertia=sum(drive.inertia for drive in drives),
            reach=max(drive.reach for drive in drives),
            integrates=any(drive.integrates for drive in drives),
        )


def joint_drives(
    chain: ServoChain,
    joint_names: Sequence[str],
    held: Mapping[str, Mapping[int, int]] | None = None,
) -> tuple[JointDrive, ...]:
    """Give the drive of each joint: its leader and all its shadows together.

    Args:
        chain: The servos, with their settings.
        joint_names: The joints, base to tool.
        held: By register and id what the servos hold, from ``read_tuning``; None: what the factory
            set, at the supply that the maker recommends. The chain's settings come first.

    Raises:
        ValueError: If no servo leads a joint.
    """
    chain.leaders_of(joint_names)
    return tuple(
        JointDrive.of([s for s in chain.servos if s.joint == name], held or {})
        for name in joint_names
    )


def read_tuning(bus: ServoBus, chain: ServoChain) -> dict[str, dict[int, int]]:
    """Read gains and supply of an arm's servos; give by register the values by id.

    Raises:
        BusError: If a servo does not answer.
    """
    servos = [servo for servo in chain.servos if servo.joint is not None]
    let_all_answer(bus, servos)
    return {
        name: read_all(bus, [s for s in servos if name in s.servo_model.table], name)
        for name in (*_GAINS, _VOLTAGE)
    }


def stall_at(model: ServoModel, voltage: float) -> tuple[float, float, float]:
    """Give stall torque (N m), stall current (A) and no-load speed (rad/s) at a supply (V).

    Between the maker's figures by straight lines, beyond them in proportion to the supply.

    Raises:
        ValueError: If the maker publishes none.
    """
    if not model.stall or not model.no_load:
        raise ValueError(f"{model.name}: its stall torque is not published")
    torque = _at(voltage, [(row.voltage, row.torque) for row in model.stall])
    current = _at(voltage, [(row.voltage, row.current) for row in model.stall])
    return torque, current, _at(voltage, list(model.no_load))


def torque_per_amp(model: ServoModel) -> float:
    """Give the torque of an ampere, N m/A: the mean of the maker's stall figures.

    Raises:
        ValueError: If the maker publishes none.
    """
    if not model.stall:
        raise ValueError(f"{model.name}: its stall torque is not published")
    return float(np.mean([row.torque / row.current for row in model.stall]))


def _at(voltage: float, rows: Sequence[tuple[float, float]]) -> float:
    """Give a figure that grows with the supply."""
    volts = [volt for volt, _ in rows]
    within = min(max(voltage, volts[0]), volts[-1])
    return float(np.interp(within, volts, [figure for _, figure in rows])) * voltage / within


def _one(servo: ServoSpec, held: Mapping[str, Mapping[int, int]]) -> JointDrive:
    """Give what one servo does by itself."""
    model, table = servo.servo_model, servo.servo_model.table
    for name in (*_GAINS, *_PROFILE):
        if name not in table:
            return JointDrive(why_not=f"({model.name}) has no {name}")
    if not model.stall or not model.no_load:
        return JointDrive(why_not=f"({model.name}) has no published stall torque")
    p, i, d = (_held(servo, name, held) * (table[name].scale or 0.0) for name in _GAINS)
    # the arm switches a profile off unless its file sets one
    if any(servo.settings.get(name, 0) for name in _PROFILE):
        return JointDrive(why_not="has a profile of its own, which lags as it likes; set it to 0")
    if p == 0.0:
        return JointDrive(why_not="has no P gain")
    voltage = _voltage(servo, held)
    torque, current, no_load = stall_at(model, voltage)
    full = table["PWM Limit"].maximum
    if not isinstance(full, int):
        return JointDrive(why_not=f"({model.name}) has no known full PWM")
    per_rad = model.pulses_per_rad
    unit, back = torque / full, torque / no_load
    if operating_mode(servo) == CURRENT_POSITION_MODE:
        step = (table["Goal Current"].scale or 0.0) * 1e-3
        unit, back = torque / current * step, 0.0
    stiffness = unit * p * per_rad
    return JointDrive(
        stiffness=stiffness,
        damping=back + unit * d * per_rad * 1e-3,
        friction=FRICTION_SHARE * torque,
        inertia=MOTOR_TIME * torque / no_load,
        reach=torque / stiffness,
        integrates=i > 0.0,
    )


def _held(servo: ServoSpec, name: str, held: Mapping[str, Mapping[int, int]]) -> int:
    """Give what a register of RAM will hold: the file's value, else what is there."""
    if name in servo.settings:
        return servo.settings[name]
    initial = servo.servo_model.table[name].initial
    return held.get(name, {}).get(servo.servo_id, initial if isinstance(initial, int) else 0)


def _voltage(servo: ServoSpec, held: Mapping[str, Mapping[int, int]]) -> float:
    """Give the supply of a servo, V: as it measures, else as its maker recommends."""
    raw = held.get(_VOLTAGE, {}).get(servo.servo_id)
    if raw:
        return raw * 0.1
    known = [row.voltage for row in servo.servo_model.stall]
    return next((volt for volt in _USUAL_SUPPLIES if volt in known), known[-1])


def column(drives: Sequence[JointDrive], name: str) -> FloatArray:
    """Give one figure of every joint, shape (n,)."""
    return np.array([float(getattr(drive, name)) for drive in drives])
