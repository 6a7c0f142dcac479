"""The pose that an arm can reach nearest to one that it may not reach."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from . import solver
from .arm import Arm
from .descent import Rest, misses
from .ik import check_tolerances, goal_of, search
from .pose import Pose
from .start import near_and_far

_STARTS = 48
_REFINED = 6
_ITERATIONS = 40


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class NearestPose:
    """A pose within reach, next to the wanted one."""

    q: FloatArray
    """Joint positions within the limits, shape (n,), rad or m."""
    pose: Pose
    """Where they bring the tool, in base."""
    position_error: float
    """Its distance from the wanted position, m."""
    orientation_error: float
    """Its angle from the wanted orientation, rad; 0 when any would do."""
    reason: str
    """Why the wanted pose is missed, in the user's units; empty if it is met."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen_array(self.q, (None,), "q"))


def nearest_pose(
    arm: Arm,
    target: Pose | ArrayInput,
    q_seed: ArrayInput | None = None,
    *,
    radian_length: float | None = None,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
) -> NearestPose:
    """Give the nearest pose to a target that the arm can reach within its limits.

    What is nearest needs a rate at which distances and angles are exchanged. Without one the
    position comes first and the orientation second. A descent from many starts finds it: of
    several that are nearly as near it may give another one.

    Args:
        arm: The arm.
        target: Where the tool is wanted in base: a pose, or a position, shape (3,), m.
        q_seed: Where to start first, shape (n,), rad or m.
        radian_length: The distance that counts as much as a turn by 1 rad, m; None: the position
            comes first.
        position_tolerance: Distance that counts as none, m.
        orientation_tolerance: Angle that counts as none, rad.

    Raises:
        ValueError: If an argument is not of its shape, not finite or not above zero.
    """
    check_tolerances(position_tolerance, orientation_tolerance)
    if radian_length is not None and not (isfinite(radian_length) and radian_length > 0.0):
        raise ValueError(f"radian_length: want a finite length above zero, got {radian_length}")
    result = search(
        arm,
        target,
        q_seed,
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
    )
    goal = goal_of(arm, target, position_tolerance, orientation_tolerance)
    q = result.q
    if not result.reached and radian_length is not None and goal.R is not None:
        weights = np.array((1.0 / radian_length,) * 3 + (1.0,) * 3)[:, None]
        # like a search, the descent measures in radians
        weighed = goal._replace(weights=weights)
        starts = np.concatenate((q[None], near_and_far(arm.packed, weighed, _STARTS)))
        rests = [
            solver.descend(arm.packed, weighed, start, max_step=1.0, max_iterations=_ITERATIONS)
            for start in starts
        ]
        best = sorted(rests, key=_cost)[:_REFINED]
        refined = [
            solver.descend(
                arm.packed,
                weighed,
                rest.q,
                max_step=solver.SEED_STEP,
                max_iterations=solver.LAST_ITERATIONS,
            )
            for rest in best
        ]
        q = min(refined, key=_cost).q
    position_error, orientation_error = misses(arm.packed, goal, q)
    return NearestPose(
        q=q,
        pose=Pose.from_matrix(arm.fk(q)),
        position_error=position_error,
        orientation_error=orientation_error,
        reason=result.reason,
    )


def _cost(rest: Rest) -> float:
    return rest.cost
