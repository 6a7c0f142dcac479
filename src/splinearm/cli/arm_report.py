"""What the command line says of an arm and of where it reaches."""

from typing import TYPE_CHECKING

import numpy as np

from splinearm.errors import KinematicsError
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, quaternion
from splinearm.kinematics.compare_words import transform_words
from splinearm.kinematics.dh_conversion import to_dh
from splinearm.units import DEG, MM

from .output import console, table

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.kinematics.reach import ReachMap

_ALMOST = 1e-4
"""Axes of less than this apart, rad, are shown as parallel if there is no other table."""

_LOOKS = 20_000
"""Joint positions that are tried to see how far an arm reaches."""


def print_arm(cell: "Cell", convention: str | None) -> None:
    """Print an arm: its DH table in a convention (None: its own), its limits and its reach."""
    arm = cell.arm
    console.print(f"{cell.title} ({arm.name}), {arm.n} joints", highlight=False)
    if convention is None:
        wanted = arm.convention or DHConvention.STANDARD
    else:
        wanted = DHConvention(convention)
    _print_dh(arm, wanted)
    _print_limits(arm.limits)
    low, high, farthest = reach_of(arm)
    sides = ", ".join(
        f"{axis} {a / MM:.0f} to {b / MM:.0f}" for axis, a, b in zip("xyz", low, high, strict=True)
    )
    console.print(
        f"reach: {farthest / MM:.0f} mm from the base; the tool's {sides} mm "
        f"(of {_LOOKS} positions within the limits)",
        highlight=False,
    )
    masses = [link.inertia.mass for link in arm.links if link.inertia is not None]
    if masses:
        console.print(f"mass that moves: {sum(masses):.4g} kg", highlight=False)


def print_reach(found: "ReachMap") -> None:
    """Print what a map says."""
    met = int(found.reached.sum())
    console.print(
        f"{met} of {len(found.points)} points reached, {found.spacing / MM:.4g} mm apart; the "
        f"farthest is {found.farthest / MM:.0f} mm from the base",
        highlight=False,
    )
    if len(found.quats) and met:
        share = found.fraction[found.reached]
        console.print(
            f"of {len(found.quats)} orientations a reached point has {share.mean():.0%} on "
            f"average and {share.max():.0%} at best",
            highlight=False,
        )


def _print_dh(arm: Arm, wanted: DHConvention) -> None:
    """Print the table of a convention, or the nearest there is, or why there is none."""
    if arm.convention is wanted:
        _print_table(arm, wanted, own=True)
        return
    try:
        _print_table(to_dh(arm, wanted), wanted, own=False)
    except KinematicsError as error:
        console.print(f"no exact {wanted.value} DH table: {error}", highlight=False)
    else:
        return
    try:
        near = to_dh(arm, wanted, tolerance=_ALMOST)
    except KinematicsError:
        return
    q = np.concatenate((np.zeros((1, arm.n)), np.eye(arm.n)))
    T_near, T = near.fk(q), arm.fk(q)
    off = np.linalg.norm(T_near[:, :3, 3] - T[:, :3, 3], axis=-1).max()
    quats = (quaternion.from_matrix(pose[:, :3, :3]) for pose in (T_near, T))
    turned = quaternion.angle_between(*quats).max()
    console.print(
        f"with axes of less than {_ALMOST / DEG:.2g} deg apart taken as parallel, off by "
        f"{off / MM:.2g} mm and {turned / DEG:.2g} deg:",
        highlight=False,
    )
    _print_table(near, wanted, own=False)


def _print_table(arm: Arm, convention: DHConvention, *, own: bool) -> None:
    rows = []
    for row in arm.dh or ():
        turns = row.kind is JointKind.REVOLUTE
        theta, d = row.theta / DEG, row.d / MM
        rows.append(
            (
                row.name,
                f"{row.a / MM + 0.0:.6g}",
                f"{row.alpha / DEG + 0.0:.6g}",
                f"{d + 0.0:.6g}" if turns else _with_q(d),
                _with_q(theta) if turns else f"{theta + 0.0:.6g}",
            )
        )
    order = (
        "Rz(theta) Tz(d) Tx(a) Rx(alpha)"
        if convention is DHConvention.STANDARD
        else "Rx(alpha) Tx(a) Rz(theta) Tz(d)"
    )
    made = "" if own else ", found from its axes"
    console.print(f"{convention.value} DH table{made}: {order}", highlight=False)
    console.print(table(("joint", "a / mm", "alpha / deg", "d / mm", "theta / deg"), rows))
    for what, T in (
        ("frame 0, seen from the base,", arm.T_base_first),
        ("the tool, seen from the last frame,", arm.T_flange_tool),
        ("the base, seen from the world,", arm.T_world_base),
    ):
        if not np.allclose(T, np.eye(4), rtol=0.0, atol=1e-12):
            console.print(f"{what} is {transform_words(T)}", highlight=False)


def _with_q(zero: float) -> str:
    """Give a sum of the joint's position and where it is at zero."""
    return f"q {'-' if zero < 0.0 else '+'} {abs(zero):.6g}" if zero else "q"


def _print_limits(limits: JointLimits) -> None:
    rows = []
    for i, (name, kind) in enumerate(zip(limits.names, limits.kinds, strict=True)):
        unit, per = ("deg", DEG) if kind is JointKind.REVOLUTE else ("mm", MM)
        torque = "-" if limits.torque_max is None else f"{limits.torque_max[i]:.4g}"
        rows.append(
            (
                name,
                unit,
                f"{limits.q_min[i] / per:.6g}",
                f"{limits.q_max[i] / per:.6g}",
                f"{limits.qd_max[i] / per:.6g}",
                f"{limits.qdd_max[i] / per:.6g}",
                torque,
            )
        )
    columns = ("joint", "unit", "lowest", "highest", "speed / s", "accel. / s2", "torque / N m (N)")
    console.print(table(columns, rows, title="limits"))


def reach_of(arm: Arm) -> tuple["np.ndarray[tuple[int], np.dtype[np.float64]]", ...]:
    """Give how low, how high and how far from the base the tool comes."""
    low = np.where(np.isfinite(arm.limits.q_min), arm.limits.q_min, -np.pi)
    high = np.where(np.isfinite(arm.limits.q_max), arm.limits.q_max, np.pi)
    q = np.random.default_rng(1).uniform(low, high, (_LOOKS, arm.n))
    p = arm.fk(q)[:, :3, 3]
    return p.min(axis=0), p.max(axis=0), np.linalg.norm(p, axis=-1).max()
