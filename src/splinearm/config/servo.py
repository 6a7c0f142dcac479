"""The ``[bus]`` and ``[[servo]]`` tables of an arm file: which motor moves which joint."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isinf

import numpy as np

from splinearm.drivers.chain import MAX_SERVO_ID, ServoChain, ServoRole, ServoSpec
from splinearm.drivers.grip import FORCE, Grip
from splinearm.drivers.health_limit import HealthLimits
from splinearm.drivers.model import ServoModel, servo_model, servo_models
from splinearm.drivers.registers import Register
from splinearm.drivers.scaling import (
    MULTI_TURN_MODES,
    JointScale,
    operating_mode,
    position_range,
)
from splinearm.errors import LimitError
from splinearm.joints import JointKind
from splinearm.units import DEG, RPM

from .joint import Joint
from .reader import Table

_NOT_FOR_FILES = frozenset(
    {"ID", "Baud Rate", "Protocol Type", "Torque Enable", "LED", "Bus Watchdog"}
    | {"Status Return Level", "Goal Position", "Goal Velocity", "Moving Speed"}
)
"""Registers that stand elsewhere in the file, or that the driver writes itself."""

_PROTOCOLS = (1.0, 2.0)

_TURNS = 256
"""How far from its centre a servo counts its position, turns."""

_HEALTH_KEYS = {
    "temperature_warn": "warn_temperature_degc",
    "temperature_stop": "stop_temperature_degc",
    "voltage_low_warn": "warn_low_supply_v",
    "voltage_low_stop": "stop_low_supply_v",
    "voltage_high_warn": "warn_high_supply_v",
    "voltage_high_stop": "stop_high_supply_v",
    "current_warn": "warn_current_a",
    "current_stop": "stop_current_a",
    "load_warn": "warn_load_percent",
    "load_stop": "stop_load_percent",
}
"""Under which key of ``[servo.health]`` each threshold stands."""

_NO_SECONDARY = 253
"""From here on the Secondary(Shadow) ID means that there is none."""


@dataclass(frozen=True, slots=True, eq=False)
class Servo:
    """One ``[[servo]]``: what it says, and where it says so."""

    spec: ServoSpec
    """The servo."""
    supply: float
    """Voltage it is fed with, V."""
    table: Table
    """Its table, to blame."""

    @property
    def stall_torque(self) -> float | None:
        """What it gives at its supply when it is held, N m; None if its maker does not say."""
        stall = self.spec.servo_model.stall
        return self._at_supply([figure.voltage for figure in stall], [s.torque for s in stall])

    @property
    def no_load_speed(self) -> float | None:
        """How fast it turns at its supply with nothing to move, rad/s; None as above."""
        figures = self.spec.servo_model.no_load
        return self._at_supply([f.voltage for f in figures], [f.speed for f in figures])

    def _at_supply(self, volts: Sequence[float], figures: Sequence[float]) -> float | None:
        if not volts:
            return None
        if not volts[0] <= self.supply <= volts[-1]:
            raise self.table.refuse(
                "supply_v",
                f"{self.spec.model} is known from {volts[0]:g} to {volts[-1]:g} V, "
                f"got {self.supply:g}; say what feeds it",
            )
        return float(np.interp(self.supply, volts, figures))


def read_servos(bus: Table, tables: Sequence[Table], joints: Sequence[str]) -> tuple[Servo, ...]:
    """Read the servos of an arm.

    Args:
        bus: The table ``[bus]``.
        tables: The tables ``[[servo]]``.
        joints: Names of the joints, base to flange.

    Raises:
        ConfigError: If a key is missing, wrong or unknown, or the servos contradict each other.
    """
    supply = bus.number("supply_v", above=0.0) if "supply_v" in bus else None
    servos: list[Servo] = []
    for table in tables:
        servo = _read_servo(table, supply, joints)
        _refuse_twin(servo, servos)
        servos.append(servo)
    for servo in servos:
        _check_shadow(servo, servos)
    return tuple(servos)


def read_chain(bus: Table, servos: Sequence[Servo]) -> ServoChain | None:
    """Read the rest of ``[bus]`` and give the chain of servos that hang on it, None without any.

    Its protocol is that of servos that can speak both; others speak the one that they know.
    """
    baud = bus.integer("baud", 1_000_000)
    protocol = bus.number("protocol", 2.0)
    if protocol not in _PROTOCOLS:
        raise bus.refuse("protocol", f"there are 1.0 and 2.0, got {protocol:g}")
    for servo in servos:
        with bus.blaming("baud"):
            servo.spec.servo_model.baud_code(baud)
    port = bus.text("usual_port") if "usual_port" in bus else None
    bus.finish()
    if not servos:
        return None
    specs = tuple(servo.spec for servo in servos)
    return ServoChain(servos=specs, baud=baud, protocol=protocol, usual_port=port)


def joint_torque(joint: Joint, table: Table, servos: Sequence[Servo]) -> float | None:
    """Give the highest torque of a joint, N m: as its table says, else what its servos give.

    A leader and its shadows add up. None if nobody says.

    Raises:
        ConfigError: If the table says more than the servos give.
    """
    stalls = [servo.stall_torque for servo in servos if servo.spec.joint == joint.name]
    known = [stall for stall in stalls if stall is not None]
    if not known or len(known) != len(stalls):
        return joint.torque_max
    total = sum(known)
    if joint.torque_max is not None and joint.torque_max > total:
        raise table.refuse(
            "max_torque_nm", f"{joint.torque_max:g} N m is more than its servos give, {total:g} N m"
        )
    return total if joint.torque_max is None else joint.torque_max


def check_reach(joint: Joint, table: Table, servos: Sequence[Servo]) -> None:
    """Refuse a joint that may go farther or faster than its leader can.

    Raises:
        ConfigError: With the limit of the joint and what the servo allows.
    """
    for servo in servos:
        if servo.spec.joint != joint.name:
            continue
        if joint.kind is JointKind.PRISMATIC:
            raise servo.table.refuse("joint", f"{joint.name!r} slides, and a servo only turns")
        if servo.spec.role is ServoRole.LEADER:
            _check_range(joint, table, servo)
            _check_speed(joint, table, servo)


def register_names(model: ServoModel) -> Mapping[str, Register]:
    """Give the registers that a file may set, by their keys: "Position P Gain" as position_p_gain.

    The one exception is ``secondary_id``, which manuals write Secondary(Shadow) ID.
    """
    return {
        re.sub(r"[^a-z0-9]+", "_", register.name.lower().replace("(shadow)", "")): register
        for register in model.table.registers
        if register.writable
        and register.name not in _NOT_FOR_FILES
        and not register.name.startswith("Indirect")
    }


def _read_servo(table: Table, supply: float | None, joints: Sequence[str]) -> Servo:
    name = table.text("name")
    servo_id = table.integer("id", low=0, high=MAX_SERVO_ID)
    model = servo_model(table.choice("model", [model.name for model in servo_models()]))
    role = ServoRole(table.choice("role", [role.value for role in ServoRole]))
    joint = _read_joint_name(table, role, joints)
    far = _TURNS * model.pulses
    zero = table.integer_or("zero_ticks", "calibrate", low=-far, high=far)
    registers = table.table("registers")
    settings = _read_settings(registers, model)
    health = _read_health(table.table("health"), model)
    grip = _read_grip(table, model) if role is ServoRole.GRIPPER else None
    own_supply = table.number("supply_v", above=0.0) if "supply_v" in table else supply
    table.finish()
    if own_supply is None:
        raise table.refuse("supply_v", "is missing; give the voltage here or in [bus]")
    spec = ServoSpec(
        name=name,
        servo_id=servo_id,
        model=model.name,
        role=role,
        joint=joint,
        zero_ticks=zero,
        settings=settings,
        health=health,
        grip=grip,
    )
    if grip is not None:
        _check_travel(spec, grip, table)
    return Servo(spec, own_supply, table)


def _read_grip(table: Table, model: ServoModel) -> Grip:
    """Read where a gripper is open and closed, and how hard it closes."""
    far = _TURNS * model.pulses
    ends = {
        key: table.integer_or(key, "calibrate", low=-far, high=far) if key in table else None
        for key in ("open_ticks", "closed_ticks")
    }
    force = table.number("closing_force_percent", FORCE, above=0.0, high=1.0)
    with table.blaming("open_ticks"):
        return Grip(**ends, force=force)


def _check_travel(spec: ServoSpec, grip: Grip, table: Table) -> None:
    """Refuse ends of a gripper's travel that its servo would not take."""
    with table.blaming("registers.operating_mode"):
        low, high = position_range(spec)
    for key, ticks in (("open_ticks", grip.open_ticks), ("closed_ticks", grip.closed_ticks)):
        if ticks is not None and not low <= ticks <= high:
            raise table.refuse(
                key,
                f"{ticks} is beyond where the servo ends, {low} to {high}; correct it, or let the "
                "servo's registers allow it",
            )


def _read_health(table: Table, model: ServoModel) -> HealthLimits:
    """Read from where on a person is told, and from where on the arm stops."""
    absent = "load" if model.has_current else "current"
    given = {
        field: table.number(key, above=0.0)
        for field, key in _HEALTH_KEYS.items()
        if not field.startswith(absent) and key in table
    }
    measured = "its current" if model.has_current else "a load and no current"
    table.finish(f"is no threshold of {model.name}, which measures {measured}")
    with table.blaming(""):
        return HealthLimits(**given)


def _read_joint_name(table: Table, role: ServoRole, joints: Sequence[str]) -> str | None:
    if role is not ServoRole.GRIPPER:
        return table.choice("joint", joints)
    if "joint" in table:
        raise table.refuse("joint", "a gripper moves no joint; take the key out")
    return None


def _read_settings(table: Table, model: ServoModel) -> dict[str, int]:
    """Read raw register values; every key must be a register of the model."""
    settings: dict[str, int] = {}
    for key, register in register_names(model).items():
        if key in table:
            settings[register.name] = _read_setting(table, key, register)
    table.finish(f"is no register of {model.name} that a file sets")
    mode = settings.get("Operating Mode")
    if mode is not None and mode not in model.modes:
        modes = ", ".join(str(mode) for mode in model.modes)
        raise table.refuse("operating_mode", f"{model.name} has the modes {modes}, got {mode}")
    return settings


def _read_setting(table: Table, key: str, register: Register) -> int:
    """Read a raw value within the register's bounds; its initial value may lie outside them."""
    value = table.integer(key)
    low, high = register.span
    if isinstance(register.minimum, int):
        low = register.minimum
    if isinstance(register.maximum, int):
        high = register.maximum
    if not low <= value <= high and value != register.initial:
        raise table.refuse(key, f"{register.name} takes {low} to {high}, got {value}")
    return value


def _refuse_twin(servo: Servo, others: Sequence[Servo]) -> None:
    spec = servo.spec
    for other in (other.spec for other in others):
        if spec.servo_id == other.servo_id:
            raise servo.table.refuse(
                "id", f"{spec.servo_id} is also the id of {other.name!r}; give each servo its own"
            )
        if spec.name == other.name:
            raise servo.table.refuse("name", f"{spec.name!r} is also the name of another servo")
        if spec.role is other.role is ServoRole.LEADER and spec.joint == other.joint:
            raise servo.table.refuse(
                "role",
                f"{other.name!r} already leads joint {spec.joint!r}; a second motor is a shadow",
            )


def _check_shadow(servo: Servo, others: Sequence[Servo]) -> None:
    """Refuse a shadow without a leader, and a secondary id that is not its leader's id."""
    spec = servo.spec
    if spec.role is not ServoRole.SHADOW:
        return
    leaders = [
        o.spec for o in others if o.spec.role is ServoRole.LEADER and o.spec.joint == spec.joint
    ]
    if not leaders:
        raise servo.table.refuse(
            "joint", f"joint {spec.joint!r} has no leader that this shadow could follow"
        )
    secondary = spec.settings.get("Secondary(Shadow) ID", _NO_SECONDARY)
    if secondary < _NO_SECONDARY and secondary != leaders[0].servo_id:
        raise servo.table.refuse(
            "registers.secondary_id",
            f"wants {leaders[0].servo_id}, the id of its leader {leaders[0].name!r}, "
            f"got {secondary}",
        )


def _check_range(joint: Joint, table: Table, servo: Servo) -> None:
    """Refuse a mode that holds no position, and positions that the servo would not take."""
    spec = servo.spec
    with servo.table.blaming("registers.operating_mode"):
        mode = operating_mode(spec)
    if spec.zero_ticks is None:
        return
    scale = JointScale.of([spec])
    for key, q in (("min_deg", joint.q_min), ("max_deg", joint.q_max)):
        if isinf(q) and mode in MULTI_TURN_MODES:
            continue
        try:
            scale.to_ticks(np.array([q]))
        except LimitError as error:
            wish = "no limit" if isinf(q) else f"{q / DEG:.6g} deg"
            raise table.refuse(
                "endless" if isinf(q) else key,
                f"{wish} is beyond where servo {spec.name!r} ends, {error.limit / DEG:.6g} deg; "
                "narrow it, or let the servo's registers allow it",
            ) from error


def _check_speed(joint: Joint, table: Table, servo: Servo) -> None:
    """Refuse a speed that the servo cannot reach or is set not to reach."""
    spec = servo.spec
    bounds = [(servo.no_load_speed, f"turns without load at {servo.supply:g} V")]
    if "Velocity Limit" in spec.settings:
        register = spec.servo_model.table["Velocity Limit"]
        if register.scale is not None and register.unit == "rev/min":
            limit = spec.settings["Velocity Limit"]
            bounds.append((limit * register.scale * RPM, f"is set to (velocity_limit {limit})"))
    for bound, what in bounds:
        if bound is not None and joint.qd_max > bound:
            raise table.refuse(
                "max_speed_deg_s",
                f"{joint.qd_max / DEG:.6g} deg/s is above the {bound / DEG:.5g} deg/s that servo "
                f"{spec.name!r} {what}",
            )
