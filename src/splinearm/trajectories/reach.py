"""Why an arm cannot follow a path, in the words of someone who has to change it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import UnreachableError
from splinearm.joints import JointKind
from splinearm.kinematics import ik
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.pose import Pose
from splinearm.units import DEG, MM

from . import task
from .path import CartesianPath

_LOOKS = 12
"""How often a way that cannot be followed is looked at."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)

_ROUNDING = 1e-9
"""Misses below this, in m or rad, are none."""


@dataclass(frozen=True, slots=True, eq=False)
class PathLabels:
    """What messages call the places of a path."""

    names: Sequence[str]
    """A name for each ``waypoint_s`` of the path, such as "waypoint 3 ('top')"."""

    def place(self, path: CartesianPath, s: float) -> str:
        """Say where on a path s is."""
        at = np.abs(path.waypoint_s - s) <= 1e-9 * max(1.0, float(path.waypoint_s[-1]))
        if at.any():
            return self.names[int(np.argmax(at))]
        behind = int(np.searchsorted(path.waypoint_s, s))
        gone = _gone(path, float(path.waypoint_s[behind - 1]), s)
        return f"the way from {self.names[behind - 1]} to {self.names[behind]}, {gone} it,"


def refuse_unreachable(
    arm: Arm, path: CartesianPath, s: float, q: FloatArray, labels: PathLabels
) -> UnreachableError:
    """Give the error for a path that cannot be followed beyond s.

    Args:
        arm: The arm.
        path: The path.
        s: The first place that was not reached.
        q: Joint positions just before it, shape (n,).
        labels: What to call its places.
    """
    following = path.waypoint_s[path.waypoint_s >= s]
    end = float(following[0]) if following.size else float(path.waypoint_s[-1])
    worst: tuple[float, float, ik.IKResult] | None = None
    for at in np.linspace(end, s, _LOOKS):
        result = ik.search(arm, _target(path, float(at)), q)
        miss = result.position_error + 0.1 * result.orientation_error
        if not result.reached and (worst is None or miss > worst[0]):
            worst = (miss, float(at), result)
        if worst is not None and at == end:
            break
    if worst is not None:
        _, at, result = worst
        return UnreachableError(
            _said(result.position_error),
            _said(result.orientation_error),
            result.joint,
            result.cause,
            labels.place(path, at),
        )
    return refuse_jump(arm, path, s, q, labels)


def refuse_jump(
    arm: Arm, path: CartesianPath, s: float, q: FloatArray, labels: PathLabels
) -> UnreachableError:
    """Give the error for a place that can be reached, but not without a jump of the joints.

    Args:
        arm: The arm.
        path: The path.
        s: The place.
        q: Joint positions just before it, shape (n,).
        labels: What to call the places of the path.
    """
    state = path.state(np.array([s]))
    J = task.jacobian(arm, q[None], state.slope.shape[1])[0]
    shares = np.linalg.svd(J, compute_uv=False)
    lost = float(shares[-1] / shares[0])
    position, orientation = task.errors(task.misses(arm, q[None], state))
    return UnreachableError(
        _said(position[0]),
        _said(orientation[0]),
        None,
        "the arm would have to jump there: it stands where it loses a direction of motion "
        f"(to {lost:.2g} of the best); lead the path elsewhere or start with other joint positions",
        labels.place(path, s),
    )


def refuse_limit(
    arm: Arm, path: CartesianPath, s: FloatArray, q: FloatArray, labels: PathLabels
) -> UnreachableError:
    """Give the error for a way of the joints that leaves their limits.

    Args:
        arm: The arm.
        path: The tool's path.
        s: Places on it, shape (m,).
        q: Joint positions there, some beyond the limits, shape (m, n).
        labels: What to call its places.
    """
    limits = arm.limits
    excess = np.maximum(limits.q_min - q, q - limits.q_max)
    row, joint = np.unravel_index(int(np.argmax(excess)), excess.shape)
    held = np.clip(q[row], limits.q_min, limits.q_max)
    at = float(s[row])
    miss = task.misses(arm, held[None], path.state(np.array([at])))
    position, orientation = task.errors(miss)
    sliding = limits.kinds[joint] is JointKind.PRISMATIC
    amount = excess[row, joint]
    beyond = f"{amount / MM:.4g} mm" if sliding else f"{amount / DEG:.4g} deg"
    name = limits.names[joint]
    return UnreachableError(
        _said(position[0]),
        _said(orientation[0]),
        name,
        f"joint {name!r} would have to pass its limit by {beyond}; move the waypoint or start "
        "elsewhere",
        labels.place(path, at),
    )


def _gone(path: CartesianPath, start: float, s: float) -> str:
    """Say how far along its way the tool is at s, or if it stays in its place how far round."""
    between = path.breaks[(path.breaks > start) & (path.breaks < s)]
    edges = np.concatenate(([start], between, [s]))
    half = 0.5 * np.diff(edges)[:, None]
    at = 0.5 * (edges[1:] + edges[:-1])[:, None] + half * _NODES
    slope = path.state(at.ravel()).slope.reshape(*at.shape, -1)
    weights = (half * _WEIGHTS)[..., None]
    moved, turned = (
        float((np.linalg.norm(part, axis=2, keepdims=True) * weights).sum())
        for part in (slope[..., :3], slope[..., 3:])
    )
    if moved <= _ROUNDING < turned:
        return f"{turned / DEG:.4g} deg into"
    return f"{moved / MM:.4g} mm along"


def _said(error: float) -> float:
    """Give an error that is worth saying: rounding is none."""
    return float(error) if error > _ROUNDING else 0.0


def _target(path: CartesianPath, s: float) -> Pose | FloatArray:
    p, quat = path.at(s)
    return p if quat is None else Pose(p, quat)
