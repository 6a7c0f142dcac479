"""Why a target is missed: out of reach, beyond a limit, or only in orientation."""

from collections.abc import Callable, Sequence
from math import dist
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.units import DEG, MM

from . import turn
from .answer import IKStatus
from .arm import Arm
from .descent import Goal, Rest, misses
from .solver import descend, model_of
from .start import near_and_far

_TRIED = 3
_POSITION_FIRST = 1e3
_STEP = 0.5
_ITERATIONS = 200
_PLACE_STARTS = 24
_PLACE_ITERATIONS = 30


class Verdict(NamedTuple):
    """The nearest answer and why it is no better."""

    rest: Rest
    """Where the search ends; should it meet the goal after all, what follows is void."""
    status: IKStatus
    """What kind of miss it is."""
    joint: str | None
    """The joint whose limit is in the way, if one is."""
    cause: str
    """Why, in the user's units."""


def why_not(arm: Arm, goal: Goal, rests: Sequence[Rest], *, may_jump: bool) -> Verdict:
    """Say why no descent met the goal, and give the nearest answer.

    Args:
        arm: The arm.
        goal: What was to be reached.
        rests: Where the descents ended, none of them at the goal.
        may_jump: Whether the descents came from starts all over the limits, so that what none of
            them reaches counts as out of reach.
    """
    best = sorted(rests, key=lambda rest: rest.cost)[:_TRIED]
    nearest = _nearest(arm, goal, best, may_jump=may_jump)
    aims = [goal]
    if goal.R is not None and nearest.position_error > goal.position_tolerance:
        aims.append(_without_orientation(goal))
    for aim in aims:
        found = _beyond_limits(arm, aim, [nearest, *best])
        if found is None:
            continue
        q, excess = found
        if excess.any():
            worst = int(np.argmax(excess / goal.units))
            name = arm.joint_names[worst]
            short = _amount(arm.links[worst].kind, float(excess[worst]))
            cause = f"{name} is at its limit, {short} short"
            return Verdict(nearest, IKStatus.JOINT_LIMIT, name, cause)
        if may_jump:
            nearest = _position_first(arm, goal, q)
            break
    return _beyond_reach(arm, goal, nearest, may_jump=may_jump)


def is_out_of_reach(arm: Arm, goal: Goal) -> bool:
    """Say whether a goal is farther from the first joint than the arm stretches."""
    distance, reach = _distance_and_reach(arm, goal)
    return distance > reach + goal.position_tolerance


def _beyond_reach(arm: Arm, goal: Goal, nearest: Rest, *, may_jump: bool) -> Verdict:
    """Give the verdict on a goal that no joint beyond its limits reaches either."""
    distance, reach = _distance_and_reach(arm, goal)
    if distance > reach + goal.position_tolerance:
        cause = (
            f"the arm stretches to {reach / MM:.4g} mm at most from its first joint; "
            f"the target is at {distance / MM:.4g} mm"
        )
        return Verdict(nearest, IKStatus.OUT_OF_REACH, None, cause)
    if not may_jump:
        cause = "the seed's branch leads no nearer; try another seed or allow restarts"
        return Verdict(nearest, IKStatus.NOT_CONVERGED, None, cause)
    if nearest.position_error <= goal.position_tolerance:
        cause = f"the {arm.n} joints of the arm cannot turn the tool that way there"
        return Verdict(nearest, IKStatus.ORIENTATION, None, cause)
    if not nearest.at_rest:
        cause = "the search came to no rest; allow more restarts"
        return Verdict(nearest, IKStatus.NOT_CONVERGED, None, cause)
    return Verdict(nearest, IKStatus.OUT_OF_REACH, None, "no start brings the tool nearer")


def _nearest(arm: Arm, goal: Goal, rests: Sequence[Rest], *, may_jump: bool) -> Rest:
    """Give the answer that is nearest in position, then in orientation."""
    nearest = min((_position_first(arm, goal, rest.q) for rest in rests), key=_misses_of(goal))
    met = nearest.position_error <= goal.position_tolerance
    if goal.R is None or not may_jump or met or is_out_of_reach(arm, goal):
        return nearest
    placed = [_position_first(arm, goal, q) for q in _places(arm, goal)]
    return min((nearest, *placed), key=_misses_of(goal))


def _misses_of(goal: Goal) -> Callable[[Rest], tuple[float, float]]:
    """Give by what answers are compared: a position that is met is as good as any other."""
    return lambda rest: (
        max(rest.position_error, goal.position_tolerance),
        rest.orientation_error,
    )


def _places(arm: Arm, goal: Goal) -> list[FloatArray]:
    """Give some joint positions that meet the position of a goal, with any orientation."""
    place = _without_orientation(goal)
    places: list[FloatArray] = []
    for q in near_and_far(arm.packed, place, _PLACE_STARTS):
        rest = descend(arm.packed, place, q, max_step=_STEP, max_iterations=_PLACE_ITERATIONS)
        if rest.position_error <= goal.position_tolerance:
            places.append(rest.q)
        if len(places) == _TRIED:
            break
    return places


def _without_orientation(goal: Goal) -> Goal:
    return goal._replace(R=None, weights=goal.weights[:3])


def _position_first(arm: Arm, goal: Goal, q: FloatArray) -> Rest:
    """Give the answer on the branch of q that is nearest in position, then in orientation."""
    if goal.R is None:
        return _descend(arm, goal, q)
    weights = goal.weights.copy()
    weights[:3] *= _POSITION_FIRST
    weighed = _descend(arm, goal._replace(weights=weights), q)
    # the weight leaves a trace of the position to the orientation; take it back where that is free
    placed = _descend(arm, _without_orientation(goal), weighed.q)
    position_error, orientation_error = misses(arm.packed, goal, placed.q)
    return weighed._replace(
        q=placed.q, position_error=position_error, orientation_error=orientation_error
    )


def _descend(arm: Arm, goal: Goal, q: FloatArray) -> Rest:
    return descend(arm.packed, goal, q, max_step=_STEP, max_iterations=_ITERATIONS)


def _beyond_limits(
    arm: Arm, goal: Goal, starts: Sequence[Rest]
) -> tuple[FloatArray, FloatArray] | None:
    """Give joint positions that meet the goal were it not for limits, and how far beyond they are.

    The ones least beyond are given; None when the goal is not met without limits either.
    """
    free = goal._replace(lower=np.full(arm.n, -np.inf), upper=np.full(arm.n, np.inf))
    turns = arm.packed.turns == 1.0
    found = []
    for start in starts:
        rest = _descend(arm, free, start.q)
        if (
            rest.position_error > goal.position_tolerance
            or rest.orientation_error > goal.orientation_tolerance
        ):
            continue
        turned = turn.nearest(rest.q, start.q, goal.lower, goal.upper)
        q = np.where(turns, turned, rest.q)
        found.append((q, np.maximum(np.maximum(goal.lower - q, q - goal.upper), 0.0)))
    if not found:
        return None
    return min(found, key=lambda pair: float((pair[1] / goal.units).max()))


def _distance_and_reach(arm: Arm, goal: Goal) -> tuple[float, float]:
    """Give how far the goal is from where the arm stretches from, and how far it can, m."""
    model = model_of(arm)
    return dist(goal.p.tolist(), model.shoulder.tolist()), model.reach


def _amount(kind: JointKind, excess: float) -> str:
    return f"{excess / DEG:.3g} deg" if kind is JointKind.REVOLUTE else f"{excess / MM:.4g} mm"
