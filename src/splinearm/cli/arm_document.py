"""What the command line says of arms, for programs: values that JSON knows, in the units of files.

Keys wear their units; None stands where nothing is limited, known or to be had.
"""

from collections.abc import Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import KinematicsError
from splinearm.joints import JointKind
from splinearm.kinematics import Arm, DHConvention, quaternion
from splinearm.kinematics.dh_conversion import to_dh
from splinearm.units import DEG, MM

from .arm_report import reach_of

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.drivers.chain import ServoChain
    from splinearm.kinematics.compare import Comparison
    from splinearm.kinematics.reach import ReachMap

LIST, LOOK, COMPARISON, REACH = (
    f"splinearm-{what}/1" for what in ("arms", "arm-look", "comparison", "reach")
)
"""What the documents say that they are."""


def list_document(cells: "Sequence[Cell]") -> dict[str, Any]:
    """Give a list of arms."""
    return {"schema": LIST, "arms": [_entry(cell) for cell in cells]}


def _entry(cell: "Cell") -> dict[str, Any]:
    servos = cell.chain.servos if cell.chain is not None else ()
    convention = cell.arm.convention
    return {
        "name": cell.name,
        "title": cell.title,
        "file": str(cell.file),
        "joint_count": cell.arm.n,
        "servo_count": len(servos),
        "models": sorted({servo.model for servo in servos}),
        "described_by": "frames" if convention is None else convention.value,
    }


def arm_document(cell: "Cell", convention: str | None) -> dict[str, Any]:
    """Give an arm: joints, DH table in a convention (None: its own), servos, poses and reach."""
    arm = cell.arm
    wanted = DHConvention(convention) if convention else arm.convention or DHConvention.STANDARD
    low, high, farthest = reach_of(arm)
    return {
        "schema": LOOK,
        **_entry(cell),
        "joints": [_joint(arm, i) for i in range(arm.n)],
        "dh": _dh(arm, wanted),
        "base_in_world": _place(arm.T_world_base),
        "frame_0_in_base": _place(arm.T_base_first),
        "tool_in_last_frame": _place(arm.T_flange_tool),
        "servos": [] if cell.chain is None else _servos(cell.chain),
        "bus": None
        if cell.chain is None
        else {
            "baud": cell.chain.baud,
            "protocol": cell.chain.protocol,
            "usual_port": cell.chain.usual_port,
        },
        "poses": {name: _rounded(cell.to_file_units(q)) for name, q in cell.poses.items()},
        "reach": {
            "farthest_mm": round(float(farthest / MM), 3),
            "lowest_mm": _rounded(low / MM),
            "highest_mm": _rounded(high / MM),
        },
    }


def _joint(arm: Arm, i: int) -> dict[str, Any]:
    limits, inertia = arm.limits, arm.links[i].inertia
    unit, per = ("deg", DEG) if limits.kinds[i] is JointKind.REVOLUTE else ("mm", MM)
    torque = "max_torque_nm" if unit == "deg" else "max_force_n"
    said: dict[str, Any] = {
        "name": limits.names[i],
        "kind": limits.kinds[i].value,
        f"min_{unit}": _number(limits.q_min[i] / per),
        f"max_{unit}": _number(limits.q_max[i] / per),
        f"max_speed_{unit}_s": _number(limits.qd_max[i] / per),
        f"max_acceleration_{unit}_s2": _number(limits.qdd_max[i] / per),
        f"max_jerk_{unit}_s3": None
        if limits.qddd_max is None
        else _number(limits.qddd_max[i] / per),
        torque: None if limits.torque_max is None else _number(limits.torque_max[i]),
        "mass_kg": None if inertia is None else _number(inertia.mass),
    }
    return said


def _dh(arm: Arm, wanted: DHConvention) -> dict[str, Any] | None:
    """Give a DH table; None: the arm has none in that convention."""
    try:
        table = arm if arm.convention is wanted else to_dh(arm, wanted)
    except KinematicsError:
        return None
    rows = [
        {
            "joint": row.name,
            "a_mm": _number(row.a / MM),
            "alpha_deg": _number(row.alpha / DEG),
            "d_mm": _number(row.d / MM),
            "theta_deg": _number(row.theta / DEG),
        }
        for row in table.dh or ()
    ]
    return {"convention": wanted.value, "own": arm.convention is wanted, "rows": rows}


def _servos(chain: "ServoChain") -> list[dict[str, Any]]:
    return [
        {
            "name": servo.name,
            "id": servo.servo_id,
            "model": servo.model,
            "role": servo.role.value,
            "joint": servo.joint,
        }
        for servo in chain.servos
    ]


def comparison_document(a: "Cell", b: "Cell", found: "Comparison") -> dict[str, Any]:
    """Give how arm b differs from arm a."""
    return {
        "schema": COMPARISON,
        "a": str(a.file),
        "b": str(b.file),
        "same": found.same,
        "same_motion": found.same_motion,
        "differences": list(found.differences),
        "signs": _rounded(found.signs),
        "offsets": _rounded(a.to_file_units(found.offsets)),
        "base_a_in_base_b": _place(found.T_base_b_base_a),
        "tool_b_in_tool_a": _place(found.T_tool_a_tool_b),
        "position_off_mm": _number(found.position_off / MM),
        "orientation_off_deg": _number(found.orientation_off / DEG),
    }


def reach_document(found: "ReachMap") -> dict[str, Any]:
    """Give what a map says; the map itself is in its file."""
    share = found.fraction[found.reached]
    asked = bool(len(found.quats) and share.size)
    return {
        "schema": REACH,
        "arm": found.arm,
        "points": len(found.points),
        "reached": int(found.reached.sum()),
        "spacing_mm": _number(found.spacing / MM),
        "farthest_mm": _number(found.farthest / MM),
        "orientations": len(found.quats),
        "mean_percent": _number(share.mean() * 100.0) if asked else None,
        "best_percent": _number(share.max() * 100.0) if asked else None,
    }


def _place(T: FloatArray) -> dict[str, list[float | None]]:
    """Give a pose as in a file: xyz_mm and quat_wxyz."""
    quat = quaternion.from_matrix(T[:3, :3])
    return {"xyz_mm": _rounded(T[:3, 3] / MM), "quat_wxyz": _rounded(quat)}


def _rounded(values: FloatArray) -> list[float | None]:
    return [_number(value) for value in np.asarray(values).tolist()]


def _number(value: float) -> float | None:
    """Give a number without the noise of its units' conversion; None: it has no end."""
    return round(float(value), 9) + 0.0 if isfinite(value) else None
