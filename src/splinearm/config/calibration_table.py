"""Calibration files: where the servos of one arm, as it was screwed together, say zero.

An arm file is true of every arm of its kind, a calibration of one. It overrides, servo by servo,
the position at joint zero and the registers that were set for it; servos that it does not name stay
as the arm file has them. The keys of such a file (``schema = "splinearm-calibration/1"``)::

    arm                         name of the arm, as its file says
    name, date                  its own name; when it was made (ISO 8601, with the time zone)
    usb_serial                  serial number of the adapter at which it was made (optional)
    [[servo]]
        name id model           which servo; all three as in the arm's file
        zero_ticks              position register at joint zero
        zero_by                 how that was found, in words (optional)
        travel_deg              lowest and highest position that the joint was turned to by hand,
                                in its own degrees (optional)
        open_ticks closed_ticks instead, for a gripper: the position register at its two ends
    [servo.registers]           raw values: drive_mode operating_mode homing_offset secondary_id
                                and min_ and max_position_limit (or cw_ and ccw_angle_limit)
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from os import PathLike, fspath
from pathlib import Path
from types import MappingProxyType

from splinearm.drivers.chain import MAX_SERVO_ID, ServoRole, ServoSpec
from splinearm.drivers.grip import Grip
from splinearm.drivers.model import ServoModel, servo_model, servo_models
from splinearm.drivers.scaling import position_range
from splinearm.errors import ConfigError
from splinearm.units import DEG

from .cell import Cell
from .folder import quoted
from .reader import Table, read_file
from .servo import register_names

CALIBRATION_SCHEMA = "splinearm-calibration/1"
"""What a calibration says it is."""

CALIBRATED_REGISTERS = (
    *("Drive Mode", "Operating Mode", "Homing Offset", "Secondary(Shadow) ID"),
    *("Min Position Limit", "Max Position Limit", "CW Angle Limit", "CCW Angle Limit"),
)
"""The registers that a calibration may override."""

_TURNS = 256
_ROUNDING = 1.5


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ServoCalibration:
    """What a calibration says of one servo."""

    name: str
    """Its name in the arm's file."""
    servo_id: int
    """Its id."""
    model: str
    """Its model."""
    zero_ticks: int | None = None
    """Position register at joint zero, ticks; None: a gripper's."""
    zero_by: str = ""
    """How that was found, in words."""
    travel: tuple[float, float] | None = None
    """Lowest and highest position that its joint was turned to by hand, rad."""
    open_ticks: int | None = None
    """Position register of an open gripper, ticks."""
    closed_ticks: int | None = None
    """Position register of a closed gripper, ticks."""
    settings: Mapping[str, int] = field(default_factory=dict)
    """Raw values of registers by name, of ``CALIBRATED_REGISTERS``."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Calibration:
    """What a calibration file says."""

    arm: str
    """Name of the arm."""
    name: str
    """Its own name."""
    date: datetime
    """When it was made; it knows its time zone."""
    servos: tuple[ServoCalibration, ...]
    """The servos that were calibrated, at least one; their ids and names differ."""
    usb_serial: str | None = None
    """Serial number of the adapter at which it was made; None: not known."""

    def servo(self, name: str) -> ServoCalibration | None:
        """Give what it says of a servo; None: nothing."""
        return next((servo for servo in self.servos if servo.name == name), None)

    def with_servos(self, *fresh: ServoCalibration) -> "Calibration":
        """Give this calibration with some servos added, or in place of those of the same name."""
        names = {servo.name for servo in fresh}
        kept = tuple(servo for servo in self.servos if servo.name not in names)
        return replace(self, servos=kept + fresh)


def read_calibration(file: str | PathLike[str]) -> Calibration:
    """Read a calibration.

    Raises:
        ConfigError: If it cannot be read or says something that cannot be used; with the key and,
            where it has one, its line.
    """
    try:
        return _read(read_file(file, CALIBRATION_SCHEMA))
    except ConfigError as error:
        line = _line_of(Path(fspath(file)), error.key)
        if line is None:
            raise
        raise ConfigError(file, error.key, f"{error.reason} (line {line})") from error


def calibration_text(calibration: Calibration) -> str:
    """Give a calibration as the text of its file."""
    lines = [
        f"schema = {quoted(CALIBRATION_SCHEMA)}",
        f"arm = {quoted(calibration.arm)}",
        f"name = {quoted(calibration.name)}",
        f"date = {quoted(calibration.date.isoformat(timespec='seconds'))}",
    ]
    if calibration.usb_serial is not None:
        lines.append(f"usb_serial = {quoted(calibration.usb_serial)}")
    for servo in calibration.servos:
        lines += ["", *_servo_lines(servo)]
    return "\n".join(lines) + "\n"


def apply_calibration(cell: Cell, calibration: Calibration, file: str | PathLike[str]) -> Cell:
    """Give a cell whose servos are calibrated.

    Args:
        cell: What the arm's file says.
        calibration: A calibration.
        file: Its file, to blame.

    Raises:
        ConfigError: If it is of another arm, names other servos, ids or models, or leaves a joint
            without the range that its limits want.
    """
    if calibration.arm != cell.name:
        reason = f"is of {calibration.arm!r}, not of {cell.name!r}; {_again(cell)}"
        raise ConfigError(file, "arm", reason)
    if cell.chain is None:
        raise ConfigError(cell.file, "servo", "the arm has no servos that could be calibrated")
    specs = {servo.name: servo for servo in cell.chain.servos}
    for k, own in enumerate(calibration.servos):
        _require_same(cell, specs.get(own.name), own, file, k)
        specs[own.name] = _overridden(specs[own.name], own)
        _check_range(cell, specs[own.name], file, k)
    return replace(cell, chain=replace(cell.chain, servos=tuple(specs.values())))


def _require_same(
    cell: Cell, spec: ServoSpec | None, own: ServoCalibration, file: str | PathLike[str], k: int
) -> None:
    """Refuse what is said of a servo that the arm's file does not know, or knows otherwise."""
    if spec is None:
        reason = f"the arm has no servo {own.name!r}; {_again(cell)}"
        raise ConfigError(file, f"servo[{k}].name", reason)
    pairs = {"id": (own.servo_id, spec.servo_id), "model": (own.model, spec.model)}
    for key, (has, wants) in pairs.items():
        if has != wants:
            reason = f"is {has} of servo {own.name!r}, in the arm's file {wants}; {_again(cell)}"
            raise ConfigError(file, f"servo[{k}].{key}", reason)
    if (own.zero_ticks is None) is not (spec.role is ServoRole.GRIPPER):
        wanted = "open_ticks" if spec.role is ServoRole.GRIPPER else "zero_ticks"
        reason = f"is missing: {own.name!r} is a {spec.role.value}; {_again(cell)}"
        raise ConfigError(file, f"servo[{k}].{wanted}", reason)


def _again(cell: Cell) -> str:
    return f"calibrate anew: `splinearm calibrate {cell.name}`"


def _overridden(spec: ServoSpec, own: ServoCalibration) -> ServoSpec:
    settings = {**spec.settings, **own.settings}
    if own.zero_ticks is not None:
        return replace(spec, settings=settings, zero_ticks=own.zero_ticks)
    grip = replace(spec.grip or Grip(), open_ticks=own.open_ticks, closed_ticks=own.closed_ticks)
    return replace(spec, settings=settings, grip=grip)


def _check_range(cell: Cell, spec: ServoSpec, file: str | PathLike[str], k: int) -> None:
    """Refuse a zero at which the servo would end within the joint's limits."""
    if spec.role is not ServoRole.LEADER or spec.zero_ticks is None:
        return
    limits = cell.arm.limits
    i = limits.names.index(spec.joint or "")
    per_rad = spec.servo_model.pulses_per_rad
    low, high = position_range(spec)
    for q, end, name in ((limits.q_min[i], low, "low"), (limits.q_max[i], high, "high")):
        beyond = (spec.zero_ticks + q * per_rad - end) * (-1.0 if name == "low" else 1.0)
        if abs(q) < float("inf") and beyond > _ROUNDING:
            raise ConfigError(
                file,
                f"servo[{k}].zero_ticks",
                f"joint {spec.joint!r} may go to {q / DEG:.6g} deg, but its servo would end "
                f"{beyond / per_rad / DEG:.3g} deg before; narrow the joint's limits in the arm's "
                f"file, or calibrate anew: `splinearm calibrate {cell.name} --joint {spec.joint}`",
            )


def _read(root: Table) -> Calibration:
    arm, name = root.text("arm"), root.text("name")
    serial = root.text("usb_serial") if "usb_serial" in root else None
    date = _read_date(root)
    tables = root.tables("servo")
    root.finish()
    if not tables:
        raise root.refuse("servo", "is missing; give a [[servo]] for each servo")
    servos: list[ServoCalibration] = []
    for table in tables:
        servo = _read_servo(table)
        for other in servos:
            if other.name == servo.name or other.servo_id == servo.servo_id:
                key = "name" if other.name == servo.name else "id"
                raise table.refuse(key, f"is also that of {other.name!r}")
        servos.append(servo)
    return Calibration(arm=arm, name=name, date=date, servos=tuple(servos), usb_serial=serial)


def _read_date(root: Table) -> datetime:
    text = root.text("date")
    with root.blaming("date"):
        date = datetime.fromisoformat(text)
    if date.tzinfo is None:
        raise root.refuse("date", f"wants its time zone too, as in {text}+00:00")
    return date


def _read_servo(table: Table) -> ServoCalibration:
    name = table.text("name")
    servo_id = table.integer("id", low=0, high=MAX_SERVO_ID)
    model = servo_model(table.choice("model", [model.name for model in servo_models()]))
    far = _TURNS * model.pulses
    ticks: dict[str, int] = {}
    joint = not ({key for key in ("open_ticks", "closed_ticks") if key in table})
    for key in ("zero_ticks",) if joint else ("open_ticks", "closed_ticks"):
        ticks[key] = table.integer(key, low=-far, high=far)
    words = table.text("zero_by", "") if joint else ""
    travel = _read_travel(table) if joint and "travel_deg" in table else None
    registers = table.table("registers")
    settings = _read_settings(registers, model)
    table.finish()
    return ServoCalibration(
        name=name,
        servo_id=servo_id,
        model=model.name,
        zero_by=words,
        travel=travel,
        settings=settings,
        **ticks,
    )


def _read_travel(table: Table) -> tuple[float, float]:
    low, high = (float(value) for value in table.numbers("travel_deg", 2))
    if low > high:
        raise table.refuse("travel_deg", "wants the lowest first, then the highest")
    return low, high


def _read_settings(table: Table, model: ServoModel) -> dict[str, int]:
    settings: dict[str, int] = {}
    for key, register in register_names(model).items():
        if register.name in CALIBRATED_REGISTERS and key in table:
            low, high = register.span
            low = register.minimum if isinstance(register.minimum, int) else low
            high = register.maximum if isinstance(register.maximum, int) else high
            settings[register.name] = table.integer(key, low=low, high=high)
    table.finish(f"is no register of {model.name} that a calibration sets")
    mode = settings.get("Operating Mode")
    if mode is not None and mode not in model.modes:
        modes = ", ".join(str(mode) for mode in model.modes)
        raise table.refuse("operating_mode", f"{model.name} has the modes {modes}, got {mode}")
    return settings


def _servo_lines(servo: ServoCalibration) -> list[str]:
    lines = [
        "[[servo]]",
        f"name = {quoted(servo.name)}",
        f"id = {servo.servo_id}",
        f"model = {quoted(servo.model)}",
    ]
    for key in ("zero_ticks", "open_ticks", "closed_ticks"):
        value = getattr(servo, key)
        if value is not None:
            lines.append(f"{key} = {value}")
    if servo.zero_by:
        lines.append(f"zero_by = {quoted(servo.zero_by)}")
    if servo.travel is not None:
        low, high = (angle / DEG for angle in servo.travel)
        lines.append(f"travel_deg = [{low:.3f}, {high:.3f}]")
    if servo.settings:
        lines.append("[servo.registers]")
        names = {r.name: key for key, r in register_names(servo_model(servo.model)).items()}
        lines += [f"{names[name]} = {value}" for name, value in servo.settings.items()]
    return lines


def _line_of(file: Path, key: str) -> int | None:
    """Give the line of a key such as ``servo[2].registers.homing_offset``, or of its table."""
    found = re.fullmatch(r"(?:servo\[(\d+)\])?\.?(?:registers\.?)?(\w*)(?:\[\d+\])?", key)
    if not key or found is None:
        return None
    table, last = found[1], found[2]
    heads, line = -1, None
    for number, text in enumerate(file.read_text(encoding="utf-8-sig").splitlines(), start=1):
        if re.match(r"\s*\[\[\s*servo\s*\]\]", text):
            heads += 1
        if heads == (-1 if table is None else int(table)):
            if line is None and table is not None:
                line = number
            if last and re.match(rf"\s*[\"']?{re.escape(last)}[\"']?\s*=", text):
                return number
    return line
