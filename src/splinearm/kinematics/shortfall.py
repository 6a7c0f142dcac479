"""By how much and why joint positions miss a target of which a part may be free."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.units import DEG, MM

from .answer import IKStatus
from .arm import Arm


def errors(arm: Arm, q: FloatArray, T: FloatArray, free: str, axis: FloatArray) -> FloatArray:
    """Give distance (m) and angle (rad) from what is wanted, shape (2, m), of q, shape (m, n).

    ``axis`` is the tool's pointing axis in the tool frame.
    """
    if not len(q):
        return np.zeros((2, 0))
    reached = arm.fk(q)
    distance = np.linalg.norm(reached[:, :3, 3] - T[:3, 3], axis=1)
    R, wanted = reached[:, :3, :3], T[:3, :3]
    if free == "nothing":
        # the angle by its chord: |R - R'| = 2 sqrt(2) sin(angle / 2)
        chord = np.linalg.norm(R - wanted, axis=(1, 2)) / np.sqrt(8.0)
    elif free == "yaw":
        upright = arm.packed.fixed[0, :3, 2]
        chord = 0.5 * np.linalg.norm(upright @ R - upright @ wanted, axis=1)
    elif free == "roll":
        along = arm.packed.fixed[-1, 2, :3]
        chord = 0.5 * np.linalg.norm(R @ along - wanted @ along, axis=1)
    elif free == "yaw and roll":
        upright = arm.packed.fixed[0, :3, 2]
        chord = 0.5 * np.abs((R @ axis) @ upright - (wanted @ axis) @ upright)
    else:
        chord = np.zeros(len(q))
    return np.stack((distance, 2.0 * np.arcsin(np.minimum(chord, 1.0))))


def beyond_limits(arm: Arm, excess: FloatArray) -> tuple[IKStatus, str, str]:
    """Say which limit is in the way, of the branch that is least beyond its own."""
    least = excess[int(np.argmin(excess.max(axis=1)))]
    worst = int(np.argmax(least))
    name = arm.joint_names[worst]
    if arm.links[worst].kind is JointKind.REVOLUTE:
        short = f"{least[worst] / DEG:.3g} deg"
    else:
        short = f"{least[worst] / MM:.4g} mm"
    return IKStatus.JOINT_LIMIT, name, f"{name} is at its limit, {short} short"


def too_far(arm: Arm, T: FloatArray) -> str:
    """Say that a target is farther away than the arm is long, or nothing."""
    fixed = arm.packed.fixed
    reach = float(np.linalg.norm(fixed[1:, :3, 3], axis=1).sum())
    for i, link in enumerate(arm.links):
        if link.kind is JointKind.PRISMATIC:
            reach += float(max(abs(arm.limits.q_min[i]), abs(arm.limits.q_max[i])))
    distance = float(np.linalg.norm(T[:3, 3] - fixed[0, :3, 3]))
    if not distance > reach:
        return ""
    return (
        f"the arm stretches to {reach / MM:.4g} mm at most from its first joint; "
        f"the target is at {distance / MM:.4g} mm"
    )
