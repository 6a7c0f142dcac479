"""Any arm as a Denavit-Hartenberg table of either convention.

The frames stand on the common normals of neighbouring axes. Where those leave a choice it is made
so that the same arm gives the same table however it was described: parallel axes are joined
without an offset, a slide (whose axis may lie anywhere) goes through the frame before it, and the
base and tool transforms take up what no row can say.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import KinematicsError
from splinearm.joints import JointKind
from splinearm.units import DEG, MM

from . import body, space
from .arm import Arm
from .dh import DHConvention, DHLink
from .home import Home, frame_on, home_of

_SIDE = 1e-9
_LOST = 1e-11
"""A table that is further off than this, m and rad, is refused."""
_WIDER = (1e-10, 1e-8, 1e-6)
_CLEAN = 1e-15


class Normals(NamedTuple):
    """The common normals of neighbouring axes, n - 1 of them, and where they begin."""

    start: FloatArray
    """The point of the first axis to start from, shape (3,)."""
    directions: list[FloatArray]
    """Unit vectors from each axis to the next."""
    near: list[FloatArray]
    """Their feet on the axis they lead from."""
    far: list[FloatArray]
    """Their feet on the axis they lead to."""
    parallel: list[bool]
    """Whether the two axes are parallel."""


def to_dh(arm: Arm, convention: DHConvention, *, tolerance: float = 1e-12) -> Arm:
    """Give the same arm described by a Denavit-Hartenberg table.

    Poses of the tool, limits and inertias stay what they are for every q; the link frames become
    the frames of the table.

    Args:
        arm: Any arm.
        convention: Which table.
        tolerance: How far the table may be off, about, rad and m: axes that are less than this
            apart in direction count as parallel.

    Raises:
        KinematicsError: If axes are so nearly parallel that no table can describe them exactly.
    """
    home = home_of(arm)
    least = np.inf
    # where axes are off parallel by rounding alone, taking them as parallel is what is exact
    for parallel in (tolerance, *(wider for wider in _WIDER if wider > tolerance)):
        table = _table(arm, home, convention, parallel)
        off = _miss(arm, table)
        if off <= max(10.0 * tolerance, _LOST):
            return table
        least = min(least, off)
    raise _refusal(arm, home, least)


def _table(arm: Arm, home: Home, convention: DHConvention, tolerance: float) -> Arm:
    """Give the table that is found when axes so near to parallel count as parallel."""
    frames = _dh_frames(home, arm.limits.kinds, convention, tolerance)
    rows = [
        _row(name, kind, space.rigid_inverse(frames[i]) @ frames[i + 1], convention)
        for i, (name, kind) in enumerate(zip(arm.limits.names, arm.limits.kinds, strict=True))
    ]
    placed = [frames[0]]
    for row in rows:
        placed.append(placed[-1] @ row.matrix(0.0, convention))
    inertias = [
        None if known is None else body.moved(known, space.rigid_inverse(T))
        for known, T in zip(home.inertias, placed[1:], strict=True)
    ]
    return Arm.from_dh(
        arm.name,
        rows,
        convention,
        arm.limits,
        inertias=inertias,
        T_world_base=arm.T_world_base,
        T_base_first=frames[0],
        T_flange_tool=space.rigid_inverse(placed[-1]) @ home.tool,
    )


def _dh_frames(
    home: Home, kinds: tuple[JointKind, ...], convention: DHConvention, tolerance: float
) -> list[FloatArray]:
    """Give the n + 1 frames of a table in base at q = 0, each of shape (4, 4)."""
    axes, tool = home.joints[:, :3, 2], home.tool[:3, 3]
    normals = common_normals(home, kinds, tolerance, tool)
    x = normals.directions[-1] if normals.directions else frame_on(axes[0], normals.start)[:3, 0]
    foot = normals.far[-1] if normals.far else normals.start
    foot = foot + ((tool - foot) @ axes[-1]) * axes[-1]
    first_x = normals.directions[0] if normals.directions else x
    first = normals.near[0] if normals.near else normals.start
    frames = [_first_frame(axes[0], first_x, first, tolerance)]
    if convention is DHConvention.MODIFIED:
        frames += [
            frame_at(*parts)
            for parts in zip(axes[:-1], normals.directions, normals.near, strict=True)
        ]
        return [*frames, frame_at(axes[-1], x, foot)]
    frames += [
        frame_at(*parts) for parts in zip(axes[1:], normals.directions, normals.far, strict=True)
    ]
    across = tool - foot
    distance = float(np.linalg.norm(across))
    return [*frames, frame_at(axes[-1], across / distance if distance > _SIDE else x, tool)]


def common_normals(
    home: Home, kinds: tuple[JointKind, ...], tolerance: float, end: FloatArray | None = None
) -> Normals:
    """Give the common normals, the leading parallel axes joined level with what follows them.

    Args:
        home: The arm at q = 0.
        kinds: How its joints move.
        tolerance: Axes that are less than this apart in direction, rad, count as parallel.
        end: A point to be level with if all axes are parallel, shape (3,); None: base's origin.
    """
    axes, points = home.joints[:, :3, 2], home.joints[:, :3, 3]
    turns = kinds[0] is JointKind.REVOLUTE
    start = points[0] - (points[0] @ axes[0]) * axes[0] if turns else np.zeros(3)
    found = _normals_from(start, home, kinds, tolerance)
    level = 0
    while level < len(found.parallel) and found.parallel[level]:
        level += 1
    ahead = found.near[level] if level < len(found.parallel) else end
    if ahead is None:
        return found
    foot = found.far[level - 1] if level else start
    return _normals_from(start + ((ahead - foot) @ axes[0]) * axes[0], home, kinds, tolerance)


def _normals_from(
    start: FloatArray, home: Home, kinds: tuple[JointKind, ...], tolerance: float
) -> Normals:
    axes, points = home.joints[:, :3, 2], home.joints[:, :3, 3]
    found = Normals(start, [], [], [], [])
    foot, x = start, any_x(axes[0])
    for i, (u, w) in enumerate(pairwise(axes)):
        point = points[i + 1] if kinds[i + 1] is JointKind.REVOLUTE else foot
        between, cross = point - foot, np.cross(u, w)
        sine = float(np.linalg.norm(cross))
        parallel = sine <= tolerance
        if parallel:
            across = between - (between @ u) * u
            distance = float(np.linalg.norm(across))
            x = across / distance if distance > _SIDE else x
            near, far = foot, foot + across
        else:
            normal = cross / sine
            gap = between @ normal
            aside = gap if abs(gap) > _SIDE else (normal @ x if abs(normal @ x) > _SIDE else 1.0)
            x = -normal if aside < 0.0 else normal
            near = foot + (np.cross(between, w) @ cross) / sine**2 * u
            far = point + (np.cross(between, u) @ cross) / sine**2 * w
        found.directions.append(x)
        found.near.append(near)
        found.far.append(far)
        found.parallel.append(parallel)
        foot = far
    return found


def any_x(axis: FloatArray) -> FloatArray:
    """Give a direction across an axis, the x axis of base if it is one."""
    return frame_on(axis, np.zeros(3))[:3, 0]


def _first_frame(
    axis: FloatArray, x: FloatArray, point: FloatArray, tolerance: float
) -> FloatArray:
    """Give frame 0: the base itself if the first joint moves on its z axis."""
    if np.abs(axis - (0.0, 0.0, 1.0)).max() <= tolerance and np.abs(point[:2]).max() <= tolerance:
        return np.eye(4)
    return frame_at(axis, x, point)


def frame_at(z: FloatArray, x: FloatArray, origin: FloatArray) -> FloatArray:
    """Give a frame, shape (4, 4), with its z axis as given and its x axis as near as it can."""
    across = x - (x @ z) * z
    across = across / np.linalg.norm(across)
    T = np.eye(4)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = across, np.cross(z, across), z, origin
    return T


def _row(name: str, kind: JointKind, T: FloatArray, convention: DHConvention) -> DHLink:
    """Give the row that is a transform between two frames of a table."""
    if convention is DHConvention.STANDARD:
        theta, alpha = np.arctan2(T[1, 0], T[0, 0]), np.arctan2(T[2, 1], T[2, 2])
        a, d = np.cos(theta) * T[0, 3] + np.sin(theta) * T[1, 3], T[2, 3]
    else:
        theta, alpha = np.arctan2(-T[0, 1], T[0, 0]), np.arctan2(-T[1, 2], T[2, 2])
        a, d = T[0, 3], np.cos(alpha) * T[2, 3] - np.sin(alpha) * T[1, 3]
    return DHLink(
        name,
        a=_clean(float(a), 1.0),
        alpha=_clean(float(alpha), 0.5 * np.pi),
        d=_clean(float(d), 1.0),
        theta=_clean(float(theta), 0.5 * np.pi),
        kind=kind,
    )


def _clean(value: float, step: float) -> float:
    """Give a number that rounding alone keeps from zero or from quarter turns without that."""
    rounded = round(value / step) * step
    off = abs(value - rounded)
    if off <= _CLEAN:
        return 0.0 if rounded == 0.0 else (np.pi if rounded == -np.pi else rounded)
    return value


def _miss(arm: Arm, table: Arm) -> float:
    """Give how far a table moves the tool from where the arm has it, m and rad."""
    q = np.concatenate((np.eye(arm.n), np.full((1, arm.n), 0.5)))
    return float(np.abs(table.fk(q) - arm.fk(q)).max())


def _refusal(arm: Arm, home: Home, off: float) -> KinematicsError:
    """Give the error that names the axes that are nearest to parallel."""
    axes = home.joints[:, :3, 2]
    sines = np.linalg.norm(np.cross(axes[:-1], axes[1:]), axis=-1)
    i = int(np.argmin(np.where(sines > 0.0, sines, np.inf)))
    return KinematicsError(
        f"arm {arm.name!r}: the axes of joints {arm.joint_names[i]!r} and "
        f"{arm.joint_names[i + 1]!r} are {sines[i] / DEG:.2g} deg from parallel, which no DH table "
        f"describes exactly (the best is off by {off / MM:.2g} mm); take them as parallel with a "
        "larger tolerance, or keep the arm as frames, screws, URDF or MJCF"
    )
