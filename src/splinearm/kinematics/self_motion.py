"""Moving a redundant arm while its tool stays where it is."""

from collections.abc import Iterator

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import UnreachableError

from . import chain, solver, turn
from .answer import IKResult, IKStatus
from .arm import Arm
from .descent import Goal, misses
from .ik import check_tolerances, goal_of, search
from .objective import Objective
from .pose import Pose
from .start import near_and_far

_STEPS = 200
_FIRST, _SMALLEST, _LARGEST = 0.1, 1e-6, 0.4
_RANK = 1e-6
_AT_REST = 1e-7
_STARTS = 64
_IMPROVED = 4


def improve(
    arm: Arm,
    q: ArrayInput,
    objective: Objective,
    *,
    position_only: bool = False,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
) -> FloatArray:
    """Give joint positions, shape (n,), that serve an objective better with the tool where it is.

    The arm moves continuously from ``q``, within its limits, until the objective falls no more.
    An arm without freedom left stays where it is.

    Args:
        arm: The arm.
        q: Where it stands, shape (n,), within the limits, rad or m.
        objective: What shall be small.
        position_only: Whether the tool may turn as it likes.
        position_tolerance: Largest distance the tool may be off at the end, m.
        orientation_tolerance: Largest angle the tool may be off at the end, rad.

    Raises:
        ValueError: If an argument is not of its shape or not finite, or q is beyond a limit.
    """
    check_tolerances(position_tolerance, orientation_tolerance)
    here = frozen_array(q, (arm.n,), "q")
    if (here < arm.limits.q_min).any() or (here > arm.limits.q_max).any():
        raise ValueError(f"q: want joint positions within the limits, got {here.tolist()}")
    T = arm.fk(here)
    target: Pose | FloatArray = T[:3, 3] if position_only else Pose.from_matrix(T)
    goal = goal_of(arm, target, position_tolerance, orientation_tolerance)
    return _improved(arm, goal, here, objective)


def search_best(
    arm: Arm,
    target: Pose | ArrayInput,
    objective: Objective,
    *,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
) -> IKResult:
    """Look for the joint positions that serve an objective best among those that meet a target.

    Answers from many starts are compared and the best of them improved.

    Args:
        arm: The arm.
        target: Where the tool shall be in base: a pose, or a position, shape (3,), m.
        objective: What shall be small.
        position_tolerance: Largest distance that counts as reached, m.
        orientation_tolerance: Largest angle that counts as reached, rad.

    Returns:
        The best answer; for a target that is missed, what ``search`` says.

    Raises:
        ValueError: If an argument is not of its shape or not finite.
    """
    first = search(
        arm,
        target,
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
    )
    if not first.reached:
        return first
    goal = goal_of(arm, target, position_tolerance, orientation_tolerance)
    answers = [first.q, *_answers(arm, goal)]
    answers.sort(key=lambda q: objective.cost(arm, q))
    improved = [_improved(arm, goal, q, objective) for q in answers[:_IMPROVED]]
    best = min(improved, key=lambda q: objective.cost(arm, q))
    position_error, orientation_error = misses(arm.packed, goal, best)
    if position_error > position_tolerance or orientation_error > orientation_tolerance:
        # every improvement is checked as it is made
        raise UnreachableError(position_error, orientation_error)
    return IKResult(
        q=best,
        position_error=position_error,
        orientation_error=orientation_error,
        iterations=first.iterations,
        status=IKStatus.REACHED,
    )


def _answers(arm: Arm, goal: Goal) -> Iterator[FloatArray]:
    """Give answers to a goal from many starts, whole turns next to the middle of the limits."""
    middle = solver.model_of(arm).middle
    for start in near_and_far(arm.packed, goal, _STARTS):
        rest = solver.descend(
            arm.packed, goal, start, max_step=solver.STEP, max_iterations=solver.SEED_ITERATIONS
        )
        turned = turn.nearest(rest.q, middle, goal.lower, goal.upper)
        q = np.where(arm.packed.turns == 1.0, turned, rest.q)
        if _is_met(arm, goal, q):
            yield q


def _improved(arm: Arm, goal: Goal, q: FloatArray, objective: Objective) -> FloatArray:
    """Go down the objective by self-motion from q; every place on the way meets goal and limits."""
    if not _is_met(arm, goal, q):
        return q
    cost, length = objective.cost(arm, q), _FIRST
    for _ in range(_STEPS):
        way = _downhill(arm, goal, q, objective.gradient(arm, q) * goal.units)
        biggest = float(np.abs(way).max())
        if biggest < _AT_REST:
            break
        tried = np.clip(q + length / biggest * way * goal.units, goal.lower, goal.upper)
        rest = solver.descend(arm.packed, goal, tried, max_step=solver.SEED_STEP, max_iterations=20)
        moved = float(np.abs((rest.q - q) / goal.units).max())
        there = objective.cost(arm, rest.q)
        if there < cost and moved <= 2.0 * length and _is_met(arm, goal, rest.q):
            q, cost, length = rest.q, there, min(2.0 * length, _LARGEST)
        else:
            length *= 0.25
            if length < _SMALLEST:
                break
    return np.array(q)


def _downhill(arm: Arm, goal: Goal, q: FloatArray, slopes: FloatArray) -> FloatArray:
    """Give the steepest way down, (n,), that moves neither the tool nor a joint into its limit."""
    J = chain.fk_and_jacobian(arm.packed, q)[1][: len(goal.weights)] * goal.weights * goal.units
    free = np.ones(len(q), dtype=bool)
    way = np.zeros(len(q))
    for _ in range(len(q)):
        _, values, vt = np.linalg.svd(J[:, free], full_matrices=True)
        rank = int((values > _RANK * max(values.max(initial=0.0), 1e-300)).sum())
        null = vt[rank:]
        way[:] = 0.0
        way[free] = -null.T @ (null @ slopes[free])
        into = free & (((q <= goal.lower) & (way < 0.0)) | ((q >= goal.upper) & (way > 0.0)))
        if not into.any():
            break
        free &= ~into
        if not free.any():
            way[:] = 0.0
            break
    return way


def _is_met(arm: Arm, goal: Goal, q: FloatArray) -> bool:
    position_error, orientation_error = misses(arm.packed, goal, q)
    return bool(
        position_error <= goal.position_tolerance
        and orientation_error <= goal.orientation_tolerance
        and (q >= goal.lower).all()
        and (q <= goal.upper).all()
    )
