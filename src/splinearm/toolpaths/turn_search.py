"""Which turn about its own axis a tool takes along a way, and in which configuration the arm is.

The turn is free where a tool is round: a pen, a cutter. Over all places, turns and branches of the
closed form the cheapest way is found by a dynamic programme: little way of the joints, away from
their limits and from singularities, never a jump.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.kinematics import chain
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.closed_form import ClosedForm
from splinearm.kinematics.planar_chain import find as find_planar
from splinearm.kinematics.planar_chain import solve as solve_planar
from splinearm.kinematics.structure import ArmClass

from .setting import rotations_about

Solver: TypeAlias = Callable[[FloatArray], FloatArray]
"""Gives all branches, (m, b, n), NaN where there is none, of poses (m, 4, 4)."""

STEP = 0.3
"""A joint that moves farther from place to place has jumped, rad ..."""

SLIDE = 0.03
"""... or m."""

_AT_LIMIT = 0.1
"""Nearer to a limit than this share of its range a joint is near it."""

_LIMIT_COST = 5.0
"""What a joint at its limit costs, s for a metre of way."""

_TURNING_COST = 0.02
"""What a turn by 1 rad about the axis costs, s."""

_SINGULAR_COST = 20.0
"""What a singular posture costs, s for a metre of way."""

_SOUND = 60.0
"""A condition of the Jacobian up to which a posture is none, for metres by 0.1 m a radian."""

_LOOKED_AT = 40
"""At so many places postures are asked how near to singular they are."""

_NEAR_COST = 0.3
"""What the way from where the arm stands to the start counts, beside the way itself."""

_CHUNK = 12_000
"""Poses solved at a time."""

_ARM = 0.1

_NOTHING, _YAW = 0, 1
"""What is free of the poses of arms of four and five joints, as their kernel has it ..."""

_SEVEN, _HELD = 7, 2
_HELD_AT = np.radians([0.0, -25.0, 25.0, -50.0, 50.0])

_FEW = 8
"""... and how many branches they have at the most."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TurnQuestion:
    """Where a tool shall be."""

    p: FloatArray
    """Places of its tip in base, shape (m, 3), m."""
    s: FloatArray
    """How far along the way they are, rising, shape (m,), m."""
    R: FloatArray
    """How it stands at turn 0, in base, shape (3, 3)."""
    axis: FloatArray
    """Its pointing axis in the tool frame, of length 1, shape (3,)."""
    turns: int
    """How many turns about that axis are tried; 1: none but turn 0."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TurnAnswer:
    """The cheapest way, as far as one goes."""

    q: FloatArray
    """Joint positions, shape (k, n); k < m: no way goes on to place k."""
    turn: FloatArray
    """The turn about the axis at each place, whole turns counted, shape (k,), rad."""
    reached: bool
    """Of a way that ends: whether the place beyond can be reached at all."""


def search_turns(
    arm: Arm, question: TurnQuestion, q_near: FloatArray, solve: Solver | None = None
) -> TurnAnswer:
    """Give the cheapest way of the joints through places of a tool that may turn about its axis.

    Args:
        arm: The arm; it needs a closed form.
        question: The places.
        q_near: Where the arm stands, shape (n,): whole turns are counted from there.
        solve: The closed form of the arm; None: it is looked for.

    Raises:
        KinematicsError: If the arm has no closed form.
    """
    from . import turn_search_kernel as kernel

    solve = solver_of(arm, q_near) if solve is None else solve
    turned = _turned(question)
    m, turns = len(question.p), question.turns
    bounds = bounds_of(arm)
    ds = np.diff(question.s, prepend=question.s[0])
    stride = max(1, m // _LOOKED_AT)
    chunk = max(1, _CHUNK // turns)
    parents, first = list[npt.NDArray[np.int16]](), np.empty((0, 0, arm.n))
    here, costs = np.empty((0, arm.n)), np.empty(0)
    reached = True
    for begin in range(0, m, chunk):
        some = slice(begin, min(begin + chunk, m))
        layers = _layers(solve, question.p[some], turned)
        extra = np.zeros(layers.shape[:2])
        for k in range(-begin % stride, len(layers), stride):
            extra[k] = _SINGULAR_COST * stride * ds[begin + k] * _nearness(arm, layers[k])
        if begin == 0:
            first = layers[:1]
            here, costs = _start(layers[0], q_near, bounds)
            costs += extra[0]
            parents.append(np.zeros((1, len(here)), dtype=np.int16))
            layers, extra, some = layers[1:], extra[1:], slice(1, some.stop)
            if not np.isfinite(costs).any():
                return TurnAnswer(
                    q=np.empty((0, arm.n)),
                    turn=np.empty(0),
                    reached=bool(np.isfinite(first[0, :, 0]).any()),
                )
        known = np.empty(layers.shape[:2], dtype=np.int16)
        done = kernel.advance(
            layers, extra, _LIMIT_COST * ds[some], bounds, turns,
            _TURNING_COST * 2.0 * np.pi / turns, here, costs, known,
        )  # fmt: skip
        parents.append(known[:done])
        if done < len(layers):
            reached = bool(np.isfinite(layers[done, :, 0]).any())
            break
    node = _traced(np.concatenate(parents), costs)
    return _answer(question, solve, node, (q_near, bounds), reached=reached)


def solver_of(arm: Arm, q_seed: FloatArray) -> Solver:
    """Give the closed form of an arm in batches: whole poses, or what of them it can meet.

    An arm of four joints meets position and direction, a planar arm the position. Of one of seven
    the third joint is held, at one of some positions around where it stands.

    Raises:
        KinematicsError: If it has none.
    """
    if arm.n == _SEVEN:
        return _seven(arm, q_seed)
    form = ClosedForm.of(arm)
    kind = form.structure.kind
    if kind in (ArmClass.PAN, ArmClass.PAN_AND_ROLL):
        from . import turn_search_kernel as kernel

        packed, x = form.structure.packed, np.array([1.0, 0.0, 0.0])
        free = _YAW if kind is ArmClass.PAN else _NOTHING

        def few(T: FloatArray) -> FloatArray:
            q = np.empty((len(T), _FEW, arm.n))
            kernel.few_batch(packed, T, q_seed, free, x, q)
            return q

        return few
    if kind is ArmClass.PLANAR:
        planar = find_planar(arm.packed)

        def flat(T: FloatArray) -> FloatArray:
            q = np.full((len(T), 2, arm.n), np.nan)
            for i, pose in enumerate(T):
                found = solve_planar(planar, pose, q_seed, oriented=False)[0]
                q[i, : len(found)] = found
            return q

        return flat
    return lambda T: form.solve_batch(T, q_seed)[0]


def _seven(arm: Arm, q_seed: FloatArray) -> Solver:
    form = ClosedForm.of(arm, given=arm.joint_names[_HELD])
    held = q_seed[_HELD] + _HELD_AT
    held = held[(held > arm.limits.q_min[_HELD]) & (held < arm.limits.q_max[_HELD])]

    def some(T: FloatArray) -> FloatArray:
        each = [form.solve_batch(T, q_seed, float(at))[0] for at in held]
        return np.concatenate(each, axis=1)

    return some


def bounds_of(arm: Arm) -> FloatArray:
    """Give limits as the kernel takes them, shape (6, n)."""
    limits, turns = arm.limits, arm.packed.turns
    room = _AT_LIMIT * (limits.q_max - limits.q_min)
    return np.array(
        [
            limits.q_min,
            limits.q_max,
            limits.qd_max,
            np.where(turns, STEP, SLIDE),
            turns.astype(np.float64),
            np.where(np.isfinite(room), room, 0.0),
        ]
    )


def _turned(question: TurnQuestion) -> FloatArray:
    angles = 2.0 * np.pi * np.arange(question.turns) / question.turns
    turned: FloatArray = question.R @ rotations_about(question.axis, angles)
    return turned


def _layers(solve: Solver, p: FloatArray, turned: FloatArray) -> FloatArray:
    """Give the nodes of places, shape (m, N, n)."""
    m, turns = len(p), len(turned)
    T = np.zeros((m, turns, 4, 4))
    T[..., :3, :3] = turned
    T[..., :3, 3] = p[:, None]
    T[..., 3, 3] = 1.0
    q = solve(T.reshape(-1, 4, 4))
    return np.ascontiguousarray(q.reshape(m, -1, q.shape[-1]))


def _nearness(arm: Arm, q: FloatArray) -> FloatArray:
    """Give how near to singular postures are, shape (N,): 0 not at all, 1 within a hair."""
    near = np.zeros(len(q))
    known = np.isfinite(q[:, 0])
    if arm.n != 6 or not known.any():
        return near
    J = chain.jacobian_batch(arm.packed, q[known])
    J[:, 3:] *= _ARM
    # a little is added so that what is exactly singular has an inverse
    inverse = np.linalg.inv(J + 1e-9 * np.eye(6))
    size = np.sqrt((J * J).sum(axis=(1, 2)) * (inverse * inverse).sum(axis=(1, 2)))
    near[known] = np.clip(size / _SOUND - 1.0, 0.0, 1.0)
    return near


def _start(q: FloatArray, q_near: FloatArray, bounds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the first layer with whole turns nearest to where the arm stands, and its costs."""
    turn = 2.0 * np.pi * bounds[4]
    here = q - turn * np.round((q - q_near) / (2.0 * np.pi))
    here += turn * (here < bounds[0]) - turn * (here > bounds[1])
    inside = ((here >= bounds[0]) & (here <= bounds[1])).all(axis=1)
    costs = _NEAR_COST * (np.abs(here - q_near) / bounds[2]).sum(axis=1)
    return here, np.where(inside, costs, np.inf)


def _traced(parents: "npt.NDArray[np.int16]", costs: FloatArray) -> "npt.NDArray[np.intp]":
    node = np.empty(len(parents), dtype=np.intp)
    at = int(np.argmin(costs))
    for k in range(len(parents) - 1, -1, -1):
        node[k] = at
        at = int(parents[k, at])
    return node


def _answer(
    question: TurnQuestion,
    solve: Solver,
    node: "npt.NDArray[np.intp]",
    start: tuple[FloatArray, FloatArray],
    *,
    reached: bool,
) -> TurnAnswer:
    """Give joint positions and turns of the nodes of a way."""
    turned, turns, m = _turned(question), question.turns, len(node)
    T = np.zeros((m, 4, 4))
    T[:, :3, 3], T[:, 3, 3] = question.p[:m], 1.0
    branches = _branches_of(solve, T, turned)
    which = node // branches
    T[:, :3, :3] = turned[which]
    q = solve(T)[np.arange(m), node % branches]
    q[0] = _start(q[:1], *start)[0][0]
    steps = np.diff(q, axis=0)
    steps -= 2.0 * np.pi * start[1][4] * np.round(steps / (2.0 * np.pi))
    q[1:] = q[0] + np.cumsum(steps, axis=0)
    change = np.diff(which)
    change = (change + turns // 2) % turns - turns // 2
    turn = 2.0 * np.pi / turns * (which[0] + np.concatenate(([0], np.cumsum(change))))
    return TurnAnswer(q=q, turn=turn, reached=reached)


def _branches_of(solve: Solver, T: FloatArray, turned: FloatArray) -> int:
    one = T[:1].copy()
    one[:, :3, :3] = turned[:1]
    return int(solve(one).shape[1])
