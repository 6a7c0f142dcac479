"""The ``[[joint]]`` tables of an arm file: how each joint moves and what hangs on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import TypeAlias

import numpy as np

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import DHConvention, DHLink, Inertia, Link
from splinearm.kinematics.home import frame_on

from .frame import read_axis, read_transform
from .reader import Table

CONVENTIONS: dict[str, DHConvention | None] = {
    "dh-standard": DHConvention.STANDARD,
    "dh-modified": DHConvention.MODIFIED,
    "frames": None,
}
"""What an arm file may say of its joints; None: frames instead of a DH table."""

_INERTIA_ROUNDING = 1e-6

Row: TypeAlias = DHLink | Link


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Joint:
    """One ``[[joint]]``. Sliding joints: m and N instead of rad and N m."""

    row: Row
    """Its row of the DH table, or its link by frames."""
    inertia: Inertia | None
    """Mass and inertia of its link in the link's frame; None: not known."""
    q_min: float
    """Lowest position, rad; -inf if it turns without end."""
    q_max: float
    """Highest position, rad; inf if it turns without end."""
    qd_max: float
    """Highest speed, rad/s."""
    qdd_max: float
    """Highest acceleration, rad/s2."""
    qddd_max: float | None
    """Highest jerk, rad/s3; None: not limited."""
    torque_max: float | None
    """Highest torque, N m; None: not given."""

    @property
    def name(self) -> str:
        """Its name."""
        return self.row.name

    @property
    def kind(self) -> JointKind:
        """How it moves."""
        return self.row.kind


def read_joints(tables: Sequence[Table], convention: DHConvention | None) -> tuple[Joint, ...]:
    """Read the joints of an arm, base to flange.

    Raises:
        ConfigError: If a key is missing, wrong or unknown, or joints contradict each other.
    """
    joints: list[Joint] = []
    for table in tables:
        joint = _read_joint(table, convention)
        if joint.name in [other.name for other in joints]:
            raise table.refuse("name", f"{joint.name!r} is also the name of another joint")
        if joints and (joint.inertia is None) is not (joints[0].inertia is None):
            raise table.refuse("mass_kg", "is given for some joints; give it for all or for none")
        if joints and (joint.qddd_max is None) is not (joints[0].qddd_max is None):
            key = f"max_jerk_{_unit(joint.kind)}_s3"
            raise table.refuse(key, "is given for some joints; give it for all or for none")
        joints.append(joint)
    return tuple(joints)


def joint_limits(joints: Sequence[Joint], torques: Sequence[float | None]) -> JointLimits:
    """Give the limits of all joints, with their torques (N m) if all are known."""
    known = [torque for torque in torques if torque is not None]
    jerks = [joint.qddd_max for joint in joints if joint.qddd_max is not None]
    return JointLimits(
        names=tuple(joint.name for joint in joints),
        kinds=tuple(joint.kind for joint in joints),
        q_min=np.array([joint.q_min for joint in joints]),
        q_max=np.array([joint.q_max for joint in joints]),
        qd_max=np.array([joint.qd_max for joint in joints]),
        qdd_max=np.array([joint.qdd_max for joint in joints]),
        qddd_max=np.array(jerks) if jerks else None,
        torque_max=np.array(known) if len(known) == len(joints) else None,
    )


def _read_joint(table: Table, convention: DHConvention | None) -> Joint:
    name = table.text("name")
    kind = JointKind(table.choice("kind", [kind.value for kind in JointKind], "revolute"))
    row = _read_link(table, name, kind) if convention is None else _read_row(table, name, kind)
    inertia = _read_inertia(table)
    unit = _unit(kind)
    q_min, q_max = _read_range(table, kind)
    jerk, torque = f"max_jerk_{unit}_s3", _torque_key(kind)
    joint = Joint(
        row=row,
        inertia=inertia,
        q_min=q_min,
        q_max=q_max,
        qd_max=table.number(f"max_speed_{unit}_s", above=0.0),
        qdd_max=table.number(f"max_acceleration_{unit}_s2", above=0.0),
        qddd_max=table.number(jerk, above=0.0) if jerk in table else None,
        torque_max=table.number(torque, above=0.0) if torque in table else None,
    )
    table.finish()
    return joint


def _read_row(table: Table, name: str, kind: JointKind) -> DHLink:
    """Read a row of a DH table; every parameter must stand there, zeros too."""
    return DHLink(
        name,
        a=table.number("a_mm"),
        alpha=table.number("alpha_deg"),
        d=table.number("d_mm"),
        theta=table.number("theta_deg"),
        kind=kind,
    )


def _read_link(table: Table, name: str, kind: JointKind) -> Link:
    """Read a link by frames: T_parent_link(q) = T_origin (motion along ``axis`` by q)."""
    T_link_joint = frame_on(read_axis(table, "axis"))
    return Link(name, kind, read_transform(table) @ T_link_joint, T_link_joint.T)


def _read_range(table: Table, kind: JointKind) -> tuple[float, float]:
    """Read the lowest and the highest position."""
    unit = _unit(kind)
    if table.flag("endless"):
        for key in (f"min_{unit}", f"max_{unit}"):
            if key in table:
                raise table.refuse(key, "contradicts endless; take one of them out")
        return -inf, inf
    low, high = table.number(f"min_{unit}"), table.number(f"max_{unit}")
    if low >= high:
        raise table.refuse(f"min_{unit}", f"wants a number below max_{unit}; swap or mend them")
    return low, high


def _read_inertia(table: Table) -> Inertia | None:
    """Read mass, centre of mass and inertia about it; all three or none."""
    if not {key for key in ("mass_kg", "com_mm", "inertia_kg_m2") if key in table}:
        return None
    xx, yy, zz, xy, xz, yz = table.numbers("inertia_kg_m2", 6)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    mass, com = table.number("mass_kg", above=0.0), table.numbers("com_mm", 3)
    moments = np.linalg.eigvalsh(tensor)
    if moments[0] <= 0.0 or moments[0] + moments[1] < moments[2] * (1.0 - _INERTIA_ROUNDING):
        raise table.refuse(
            "inertia_kg_m2",
            "belongs to no body: each principal moment must be above zero and at most the sum of "
            f"the others, got {', '.join(f'{moment:.4g}' for moment in moments)}; the order is "
            "xx yy zz xy xz yz",
        )
    return Inertia(mass, com, tensor)


def _unit(kind: JointKind) -> str:
    return "deg" if kind is JointKind.REVOLUTE else "mm"


def _torque_key(kind: JointKind) -> str:
    return "max_torque_nm" if kind is JointKind.REVOLUTE else "max_force_n"
