"""Why a toolpath cannot be followed where it lies, and what would help."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import UnreachableError
from splinearm.kinematics import ik, quaternion
from splinearm.kinematics.answer import IKResult
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.pose import Pose
from splinearm.kinematics.structure import ArmClass
from splinearm.units import MM

from .setting import class_of, rotations_about
from .turn_search import TurnAnswer, TurnQuestion, bounds_of, search_turns, solver_of

_TURNS = 8
"""So many turns of the tool are tried for the nearest miss."""

_COARSE = 80
"""So many places are looked at when work is moved to see whether it helps."""

_AWAY = (0.01, 0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.24)
"""How far work is moved, m."""


def unplaced(
    arm: Arm, question: TurnQuestion, answer: TurnAnswer, name: str, q_near: FloatArray
) -> UnreachableError:
    """Give the error for a toolpath that cannot be followed to its end.

    Args:
        arm: The arm.
        question: The places of the tool.
        answer: How far a way went.
        name: Which of the program's ways leads through the place.
        q_near: Where the arm stands, shape (n,).
    """
    k = len(answer.q)
    x, y, z = question.p[k] / MM
    at = f"{name}, at ({x:.1f}, {y:.1f}, {z:.1f}) mm of the arm's base,"
    help_ = "; ".join(_remedies(arm, question, q_near))
    if answer.reached and k > 0:
        joint = _jumping(arm, question, answer)
        return UnreachableError(
            0.0,
            0.0,
            joint,
            f"the arm would have to flip to another configuration there (joint {joint!r}): no "
            f"turn of the tool leads past its limits and singular postures; {help_}",
            at,
        )
    miss = _nearest_miss(arm, question, k, q_near)
    reason = miss.cause or "no joint positions reach it"
    return UnreachableError(
        miss.position_error, miss.orientation_error, miss.joint, f"{reason}; {help_}", at
    )


def _nearest_miss(arm: Arm, question: TurnQuestion, k: int, q_near: FloatArray) -> IKResult:
    """Give the answer that misses a place the least, over some turns of the tool."""
    if class_of(arm) is ArmClass.PLANAR:
        return ik.search(arm, question.p[k], q_near)
    turns = _TURNS if question.turns > 1 else 1
    angles = 2.0 * np.pi * np.arange(turns) / turns
    R = question.R @ rotations_about(question.axis, angles)
    found = [ik.search(arm, Pose(question.p[k], quaternion.from_matrix(one)), q_near) for one in R]
    return min(found, key=lambda result: result.position_error + 0.1 * result.orientation_error)


def _jumping(arm: Arm, question: TurnQuestion, answer: TurnAnswer) -> str:
    """Give the joint that is nearest to a limit where a way ends, or farthest from going on."""
    q = answer.q[-1]
    low, high = arm.limits.q_min, arm.limits.q_max
    room = np.minimum(q - low, high - q) / bounds_of(arm)[3]
    if room.min() < 1.0:
        return arm.joint_names[int(np.argmin(room))]
    change = np.abs(np.diff(answer.q[-3:], axis=0)).max(axis=0, initial=0.0)
    return arm.joint_names[int(np.argmax(change))]


def _remedies(arm: Arm, question: TurnQuestion, q_near: FloatArray) -> Iterator[str]:
    """Give what would help, as far as it is found."""
    shift = _shift(arm, question, q_near)
    if shift is None:
        yield "moving the work by up to 240 mm does not help; turn it, or the tool, otherwise"
        return
    dx, dy, dz = shift / MM
    up = f", {dz:+.0f} mm along z" if dz else ""
    yield f"move the work by {dx:+.0f} mm along x, {dy:+.0f} mm along y{up} of the arm's base"


def _shift(arm: Arm, question: TurnQuestion, q_near: FloatArray) -> FloatArray | None:
    """Give the least move of the work with which a coarse look finds a way, shape (3,), m."""
    coarse = coarsely(question, _COARSE)
    solve = solver_of(arm, q_near)
    planar = class_of(arm) is ArmClass.PLANAR
    angles = np.arange(8) * np.pi / 4.0
    level = [np.array([np.cos(a), np.sin(a), 0.0]) for a in angles]
    ways = level if planar else [*level, np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])]
    for far in _AWAY:
        for way in ways:
            moved = replace(coarse, p=coarse.p + far * way)
            if len(search_turns(arm, moved, q_near, solve).q) == len(moved.p):
                shift: FloatArray = far * way
                return shift
    return None


def coarsely(question: TurnQuestion, count: int) -> TurnQuestion:
    """Give some of the places only, and fewer turns."""
    m = len(question.p)
    some = np.unique(np.linspace(0, m - 1, min(m, count)).astype(np.intp))
    turns = min(question.turns, 36)
    return replace(question, p=question.p[some], s=question.s[some], turns=turns)
