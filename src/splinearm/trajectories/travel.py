"""How far a motion carries the tool."""

import numpy as np

from splinearm.kinematics.arm import Arm

from .trajectory import JointTrajectory

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


def tool_travel(
    arm: Arm, trajectory: JointTrajectory, start: float = 0.0, end: float | None = None
) -> float:
    """Give the length of the tool's way between two times of a motion, m.

    Of a motion that ``stop_from`` gave, this is how far the tool runs on until it rests.

    Args:
        arm: The arm that moves.
        trajectory: Its motion.
        start: From when, s.
        end: Until when, s; None: to the end.

    Raises:
        ValueError: If end is before start or a time is not finite.
    """
    until = trajectory.duration if end is None else end
    if not (np.isfinite(start) and np.isfinite(until) and start <= until):
        raise ValueError(f"want finite times that do not fall, got {start} and {until}")
    nodes = [np.array([start, until])]
    for begun, section in zip(trajectory.starts, trajectory.sections, strict=True):
        nodes.append(begun + section.law.t)
    t = np.unique(np.clip(np.concatenate(nodes), start, until))
    if t.size < 2:
        return 0.0
    half = 0.5 * np.diff(t)[:, None]
    q, qd, _ = trajectory.sample((t[:-1, None] + half * (1.0 + _NODES)).ravel())
    J = arm.jacobian(q)[:, :3]
    speed = np.linalg.norm(np.einsum("mij,mj->mi", J, qd), axis=1)
    return float(np.sum(speed.reshape(-1, _NODES.size) * _WEIGHTS * half))
