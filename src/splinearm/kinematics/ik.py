"""Inverse kinematics of any arm, by descent from many starts, within the joint limits."""

from collections.abc import Iterator
from functools import lru_cache
from math import isfinite

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import UnreachableError
from splinearm.units import DEG, MM

from . import solver, turn, verdict
from .answer import IKResult as IKResult
from .answer import IKStatus as IKStatus
from .answer import confirmed
from .arm import Arm
from .descent import Goal, Rest, misses
from .pose import Pose
from .start import near_and_far

RESTARTS = 200
"""Starts that a search tries when the first leads nowhere."""

_AS_IT_IS = np.array((1.0, 0.0, 0.0, 0.0))
"""What stands for an orientation where any will do."""


def search(
    arm: Arm,
    target: Pose | ArrayInput,
    q_seed: ArrayInput | None = None,
    *,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    restarts: int = RESTARTS,
) -> IKResult:
    """Look for joint positions within the limits that bring the tool to a target.

    The search goes down from the seed first. Near the seed that takes a few steps and stays on its
    branch. If it leads nowhere, up to ``restarts`` starts are tried that fill the limits evenly
    (the same at every call) and lie near the target. Whole turns of joints that have room for them
    are chosen to be nearest to the seed. An answer that the arm does not quite reach brings the
    position as near as it can be first, the orientation second.

    Args:
        arm: The arm.
        target: Where the tool shall be in base: a pose, or a position, shape (3,), m, with any
            orientation.
        q_seed: Where to start, shape (n,), rad or m; beyond a limit the search starts on it.
        position_tolerance: Largest distance from the target that counts as reached, m.
        orientation_tolerance: Largest angle from the target that counts as reached, rad.
        restarts: How many further starts may be tried; 0 stays on the seed's branch, as following
            a path wants it.

    Returns:
        The best answer; its status says whether the target is met, its reason why not.

    Raises:
        ValueError: If an argument is not of its shape or not finite, or without seed and restarts.
    """
    seeded, tolerances = q_seed is not None, (position_tolerance, orientation_tolerance)
    if solver.kernels() is None:
        _check(*tolerances, restarts, seeded=seeded)
        return _search_on_numpy(arm, goal_of(arm, target, *tolerances), q_seed, restarts)
    inquiry = _inquiry(arm, *tolerances, restarts, seeded, isinstance(target, Pose))
    p, quat = (target.p, target.quat) if isinstance(target, Pose) else (target, _AS_IT_IS)
    near = inquiry.middle if q_seed is None else q_seed
    done, q, said, rests = inquiry.put(p, quat, near)
    if not done:
        # not as the kernel takes it: converted, or refused
        near = frozen_array(near, (arm.n,), "q_seed")
        p, quat = frozen_array(p, (3,), "target"), frozen_array(quat, (4,), "quat")
        _, q, said, rests = inquiry.put(p, quat, near)
    met, position_error, orientation_error, steps, count = said.tolist()
    if met:
        return confirmed(q, position_error, orientation_error, int(steps))
    goal = goal_of(arm, target, *tolerances)
    return _missed(arm, goal, _rests(rests[: int(count)]), np.asarray(near), may_jump=restarts > 0)


@lru_cache(maxsize=64)
def _inquiry(
    arm: Arm,
    position_tolerance: float,
    orientation_tolerance: float,
    restarts: int,
    seeded: bool,  # noqa: FBT001 - named at the call
    posed: bool,  # noqa: FBT001
) -> solver.Inquiry:
    """Check all that stays the same from target to target, once, and give the search."""
    tolerances = position_tolerance, orientation_tolerance
    _check(*tolerances, restarts, seeded=seeded)
    return solver.inquiry(arm, tolerances, restarts, seeded=seeded, posed=posed)


def _search_on_numpy(arm: Arm, goal: Goal, q_seed: ArrayInput | None, restarts: int) -> IKResult:
    """Search as long as the kernels are not worth loading."""
    seed = None if q_seed is None else frozen_array(q_seed, (arm.n,), "q_seed")
    near = solver.model_of(arm).middle if seed is None else seed
    if restarts and verdict.is_out_of_reach(arm, goal):
        restarts = min(restarts, solver.HOPELESS)
    rests: list[Rest] = []
    for rest in _descents(arm, goal, seed, restarts):
        q = _with_turns(arm, goal, rest.q, near)
        rests.append(rest._replace(q=q))
        result = _judged(arm, goal, q, sum(each.iterations for each in rests))
        if result is not None:
            return result
    return _missed(arm, goal, rests, near, may_jump=restarts > 0)


def _missed(
    arm: Arm, goal: Goal, rests: list[Rest], near: FloatArray, *, may_jump: bool
) -> IKResult:
    """Give the best answer to a goal that no descent met, and why."""
    found = verdict.why_not(arm, goal, rests, may_jump=may_jump)
    q = _with_turns(arm, goal, found.rest.q, near)
    iterations = sum(rest.iterations for rest in rests)
    return _judged(arm, goal, q, iterations) or IKResult(
        q=q,
        position_error=found.rest.position_error,
        orientation_error=found.rest.orientation_error,
        iterations=iterations,
        status=found.status,
        joint=found.joint,
        reason=f"{_in_words(goal, found.rest)}: {found.cause}",
        cause=found.cause,
    )


def solve(
    arm: Arm,
    target: Pose | ArrayInput,
    q_seed: ArrayInput | None = None,
    *,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    restarts: int = RESTARTS,
) -> FloatArray:
    """Give joint positions, shape (n,), within the limits that bring the tool to a target.

    Arguments are those of ``search``.

    Raises:
        UnreachableError: If the search found none; it says by how much and why. A miss within
            its tolerance counts as none.
        ValueError: As in ``search``.
    """
    result = search(
        arm,
        target,
        q_seed,
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
        restarts=restarts,
    )
    if not result.reached:
        position_error, orientation_error = result.position_error, result.orientation_error
        raise UnreachableError(
            position_error if position_error > position_tolerance else 0.0,
            orientation_error if orientation_error > orientation_tolerance else 0.0,
            result.joint,
            result.cause,
            "the pose" if isinstance(target, Pose) else "the position",
        )
    return result.q


def goal_of(
    arm: Arm, target: Pose | ArrayInput, position_tolerance: float, orientation_tolerance: float
) -> Goal:
    """Give what a descent of the arm is to reach, from what a user says."""
    if isinstance(target, Pose):
        p, R = target.p, _rotation(*target.quat.tolist())
    else:
        p, R = frozen_array(target, (3,), "target"), None
    model = solver.model_of(arm)
    return Goal(
        p=p,
        R=R,
        lower=arm.limits.q_min,
        upper=arm.limits.q_max,
        weights=model.weights[:3] if R is None else model.weights,
        units=model.bounds[2],
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
    )


def _rotation(w: float, x: float, y: float, z: float) -> FloatArray:
    """Give the matrix of one unit quaternion; as ``quaternion.to_matrix``, in less time."""
    return np.array(
        (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        )
    )


def check_tolerances(position_tolerance: float, orientation_tolerance: float) -> None:
    """Refuse tolerances that are not finite and above zero."""
    for name, tolerance in (
        ("position_tolerance", position_tolerance),
        ("orientation_tolerance", orientation_tolerance),
    ):
        if not (isfinite(tolerance) and tolerance > 0.0):
            raise ValueError(f"{name}: want a finite number above zero, got {tolerance}")


def _check(
    position_tolerance: float, orientation_tolerance: float, restarts: int, *, seeded: bool
) -> None:
    if restarts < 0 or (restarts == 0 and not seeded):
        raise ValueError(f"restarts: want at least 1 without a seed, 0 with one, got {restarts}")
    check_tolerances(position_tolerance, orientation_tolerance)


def _rests(rows: FloatArray) -> list[Rest]:
    """Give where the kernel's descents ended."""
    n = rows.shape[1] - 5
    return [
        Rest(
            q=row[:n].copy(),
            position_error=float(row[n + 1]),
            orientation_error=float(row[n + 2]),
            cost=float(row[n]),
            iterations=int(row[n + 3]),
            at_rest=bool(row[n + 4] == 1.0),
        )
        for row in rows
    ]


def _descents(arm: Arm, goal: Goal, seed: FloatArray | None, restarts: int) -> Iterator[Rest]:
    """Give where descents end: from the seed, from the starts, and from the best of these on."""
    chain = arm.packed
    if seed is not None:
        q = np.clip(seed, goal.lower, goal.upper)
        yield solver.descend(
            chain, goal, q, max_step=solver.SEED_STEP, max_iterations=solver.SEED_ITERATIONS
        )
    if not restarts:
        return
    unfinished, loose = [], solver.loosened(arm, goal)
    for q in near_and_far(chain, goal, restarts):
        rest = solver.descend(
            chain, loose, q, max_step=solver.STEP, max_iterations=solver.FIRST_ITERATIONS
        )
        yield rest
        if not rest.at_rest:
            unfinished.append(rest)
    unfinished.sort(key=lambda rest: rest.cost)
    for rest in unfinished[: solver.CONTINUED]:
        yield solver.descend(
            chain, loose, rest.q, max_step=solver.STEP, max_iterations=solver.LAST_ITERATIONS
        )


def _with_turns(arm: Arm, goal: Goal, q: FloatArray, near: FloatArray) -> FloatArray:
    """Give the same configuration with the whole turns that are nearest to ``near``."""
    turned = turn.nearest(q, near, goal.lower, goal.upper)
    return np.where(arm.packed.turns == 1.0, turned, q)


def _judged(arm: Arm, goal: Goal, q: FloatArray, iterations: int) -> IKResult | None:
    """Give the result of an answer that meets target and limits, by forward kinematics anew."""
    position_error, orientation_error = misses(arm.packed, goal, q)
    if (
        position_error > goal.position_tolerance
        or orientation_error > goal.orientation_tolerance
        or (q < goal.lower).any()
        or (q > goal.upper).any()
    ):
        return None
    return IKResult(
        q=q,
        position_error=position_error,
        orientation_error=orientation_error,
        iterations=iterations,
        status=IKStatus.REACHED,
    )


def _in_words(goal: Goal, rest: Rest) -> str:
    """Say by how much the goal is missed."""
    words = []
    if rest.position_error > goal.position_tolerance:
        words.append(f"{rest.position_error / MM:.4g} mm")
    if rest.orientation_error > goal.orientation_tolerance:
        words.append(f"{rest.orientation_error / DEG:.4g} deg")
    return f"out of reach by {' and '.join(words)}"
