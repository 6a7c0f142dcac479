"""Arm files: an arm, its servos and its named poses, shipped or a user's own.

The keys of an arm file (``schema = "splinearm-arm/1"``)::

    name, title                 what it is called, and what it is
    licence, notice             where its numbers come from (optional)
    convention                  "dh-standard", "dh-modified" or "frames"
    [world] [base] [tool]       xyz_mm and rpy_deg or quat_wxyz (each optional): the base in the
                                world, the first joint's parent frame (DH frame 0) in the base,
                                the tool in the last link
    [[joint]]                   base to flange
        name, kind              kind is "revolute" (default) or "prismatic"
        a_mm alpha_deg d_mm theta_deg       its row, if the convention is a DH one
        xyz_mm, rpy_deg or quat_wxyz, axis  its frame in the parent link and its axis there
        min_deg max_deg         or endless = true
        max_speed_deg_s max_acceleration_deg_s2; optional: max_jerk_deg_s3 max_torque_nm
        mass_kg com_mm inertia_kg_m2        in the link's frame; xx yy zz xy xz yz about com
    [bus]                       supply_v; optional: baud protocol usual_port, and feedforward:
                                "full" (default), "velocity" or "off": what goals are ahead by
    [[servo]]                   name id model, role ("leader" "shadow" "gripper"), joint,
                                zero_ticks (or "calibrate"), supply_v if not the bus's
                                a gripper's: open_ticks closed_ticks (or "calibrate") and
                                closing_force_percent, of its stall torque (default 25)
    [servo.registers]           raw register values by the register's name: drive_mode = 1
    [poses]                     NAME_deg, one number a joint; home_deg must be there

A sliding joint has ``_mm`` where a turning one has ``_deg``, and ``max_force_n``; poses of an arm
with sliding joints end in ``_deg_mm``. A joint without ``max_torque_nm`` gives what its servos do.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from os import PathLike, fspath
from pathlib import Path
from types import MappingProxyType

from splinearm.arrays import FloatArray
from splinearm.drivers.chain import ServoChain, ServoRole
from splinearm.drivers.feedforward import KINDS
from splinearm.errors import ConfigError, LimitError
from splinearm.joints import JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Link

from . import description, reader, unit
from .frame import read_transform
from .joint import CONVENTIONS, Joint, joint_limits, read_joints
from .reader import Table
from .servo import Servo, check_reach, joint_torque, read_chain, read_servos

ARM_SCHEMA = "splinearm-arm/1"
"""What an arm file says it is."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cell:
    """What an arm file says."""

    name: str
    """Name of the arm, the same in every copy of its file."""
    title: str
    """What it is, in words."""
    file: Path
    """The file."""
    licence: str
    """Licence of its numbers; empty if the file does not say."""
    notice: str
    """Where they come from; empty if the file does not say."""
    arm: Arm
    """The arm."""
    chain: ServoChain | None
    """Its servos; None if the file names none."""
    poses: Mapping[str, FloatArray]
    """Named joint positions, each of shape (n,), rad or m; "home" is always there."""
    feedforward: str = "full"
    """By what the servos' goals are ahead of their setpoints: "full" is speed and load, "velocity"
    is speed alone, "off" is nothing."""

    def to_file_units(self, q: FloatArray) -> FloatArray:
        """Give joint positions in degrees (sliding joints: mm), shape (..., n), of rad or m."""
        return unit.to_file_units(q, self.arm.limits.kinds)

    def from_file_units(self, values: FloatArray) -> FloatArray:
        """Give joint positions in rad (sliding joints: m), shape (..., n), of degrees or mm."""
        return unit.from_file_units(values, self.arm.limits.kinds)


def shipped_arms() -> tuple[str, ...]:
    """Give the names of the shipped arms."""
    return tuple(sorted(file.stem for file in _folder().glob("*.toml")))


def load_cell(name_or_path: str | PathLike[str], *, tip: str | None = None) -> Cell:
    """Read an arm file, or an arm without servos from a URDF (.urdf) or MJCF (.xml, .mjcf).

    Args:
        name_or_path: The name of a shipped arm, or the path of any arm file.
        tip: Of a URDF or MJCF: the link, body or site that is the tool; None: where there is but
            one. What such a file says of no joint, speeds and accelerations, gets the defaults of
            ``splinearm.kinematics.description``.

    Raises:
        ConfigError: If there is no such arm, or its file says something that cannot be used.
    """
    file = arm_file(name_or_path)
    if file.suffix.lower() in description.READERS:
        return _described_cell(file, tip)
    if tip is not None:
        raise ConfigError(file, "", f"takes no tip, got {tip!r}: its tool is what it says itself")
    return _read_cell(file)


def arm_file(name_or_path: str | PathLike[str]) -> Path:
    """Give the file of a shipped arm or of a user's own.

    Raises:
        ConfigError: If it is neither.
    """
    text = fspath(name_or_path)
    if text in shipped_arms():
        return _folder() / f"{text}.toml"
    if Path(text).is_file() or text.endswith(".toml") or Path(text).name != text:
        return Path(text)
    shipped = ", ".join(shipped_arms())
    raise ConfigError(text, "", f"is no shipped arm and no file; shipped are {shipped}")


def read_positions(table: Table, stem: str, limits: JointLimits) -> FloatArray:
    """Give one position a joint, within the limits, shape (n,), rad or m.

    Raises:
        ConfigError: If the numbers do not fit the arm; with joint, value and limit.
    """
    q = table.positions(stem, limits.names, limits.kinds)
    try:
        limits.check(q)
    except LimitError as error:
        reason = str(error).partition(";")[0]
        raise table.refuse(unit.positions_key(stem, limits.kinds), reason) from error
    q.flags.writeable = False
    return q


def _folder() -> Path:
    return Path(str(files("splinearm.config"))) / "arms"


def _read_cell(file: Path) -> Cell:
    root = reader.read_file(file, ARM_SCHEMA)
    name, title = root.text("name"), root.text("title")
    licence, notice = root.text("licence", ""), root.text("notice", "")
    convention = CONVENTIONS[root.choice("convention", CONVENTIONS)]
    places = [_read_place(root.table(key)) for key in ("world", "base", "tool")]
    tables, bus, poses = root.tables("joint"), root.table("bus"), root.table("poses")
    servo_tables = root.tables("servo")
    root.finish()
    if not tables:
        raise root.refuse("joint", "is missing; give a [[joint]] table for each joint")
    joints = read_joints(tables, convention)
    servos = read_servos(bus, servo_tables, [joint.name for joint in joints])
    feedforward = bus.choice("feedforward", KINDS, "full")
    chain = read_chain(bus, servos)
    _require_leaders(root, joints, servos)
    limits = _limits(joints, tables, servos)
    return Cell(
        name=name,
        title=title,
        file=file,
        licence=licence,
        notice=notice,
        arm=_arm(name, joints, convention, limits, places),
        chain=chain,
        poses=_read_poses(poses, limits),
        feedforward=feedforward,
    )


def _described_cell(file: Path, tip: str | None) -> Cell:
    arm = description.read_arm(file, tip)
    home = description.home_of(arm.limits)
    return Cell(
        name=arm.name,
        title=f"{arm.name}, from {file.name}",
        file=file,
        licence="",
        notice="",
        arm=arm,
        chain=None,
        poses=MappingProxyType({"home": home}),
    )


def _read_place(table: Table) -> FloatArray:
    T = read_transform(table)
    table.finish()
    return T


def _require_leaders(root: Table, joints: Sequence[Joint], servos: Sequence[Servo]) -> None:
    led = {servo.spec.joint for servo in servos if servo.spec.role is ServoRole.LEADER}
    for joint in joints:
        if servos and joint.name not in led:
            raise root.refuse(
                "servo",
                f'joint {joint.name!r} has no leader; add a [[servo]] with role = "leader" '
                f'and joint = "{joint.name}"',
            )


def _limits(
    joints: Sequence[Joint], tables: Sequence[Table], servos: Sequence[Servo]
) -> JointLimits:
    for joint, table in zip(joints, tables, strict=True):
        check_reach(joint, table, servos)
    torques = [joint_torque(j, table, servos) for j, table in zip(joints, tables, strict=True)]
    return joint_limits(joints, torques)


def _arm(
    name: str,
    joints: Sequence[Joint],
    convention: DHConvention | None,
    limits: JointLimits,
    places: Sequence[FloatArray],
) -> Arm:
    T_world_base, T_base_first, T_flange_tool = places
    if convention is not None:
        return Arm.from_dh(
            name,
            [joint.row for joint in joints if isinstance(joint.row, DHLink)],
            convention,
            limits,
            inertias=[joint.inertia for joint in joints],
            T_world_base=T_world_base,
            T_base_first=T_base_first,
            T_flange_tool=T_flange_tool,
        )
    return Arm(
        name,
        tuple(replace(j.row, inertia=j.inertia) for j in joints if isinstance(j.row, Link)),
        limits,
        T_world_base=T_world_base,
        T_base_first=T_base_first,
        T_flange_tool=T_flange_tool,
    )


def _read_poses(table: Table, limits: JointLimits) -> Mapping[str, FloatArray]:
    """Read the named poses; "home" must be one of them."""
    stems = dict.fromkeys(["home", *(unit.stem_of(key) for key in table)])
    poses = {stem: read_positions(table, stem, limits) for stem in stems}
    table.finish()
    return MappingProxyType(poses)
