"""Placing a toolpath before an arm: where its tool goes, how it stands, in which configuration.

The tool points along one direction, as a cutter does on a machine of three axes; its turn about
that direction is free, and the arm's. What comes out is what ``trajectories`` plans.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.errors import UnreachableError
from splinearm.kinematics import chain, quaternion
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.structure import ArmClass
from splinearm.trajectories.guided import GuidedWay
from splinearm.trajectories.leg import ToolWay
from splinearm.trajectories.path import CartesianPath
from splinearm.trajectories.place import Place
from splinearm.trajectories.resolve import Nodes
from splinearm.trajectories.turning import OrientationCurve

from .action import Action
from .free_turn import FreeTurn, PanTurn, smooth_turn
from .setting import Setting, class_of, rotations_about, standing, tool_axis_of
from .stage import Itinerary, Stage, itinerary_of, rest_of
from .turn_search import (
    Solver,
    TurnAnswer,
    TurnQuestion,
    bounds_of,
    search_turns,
    solver_of,
)
from .unplaced import unplaced

SPACING = 2e-3
"""How far apart places are at which postures are chosen, m."""

MOST_PLACES = 10_000
"""... or farther, so that there are no more than that."""

_LEVEL = 1e-6
"""Work that is off a planar arm's plane by less lies in it, m."""

_SPARSE, _FEW_TURNS = 3.0, 24
"""Where branches come by eigenvalues, places are so many times farther apart, and turns fewer."""

_SPANS = 8, 32, 128, 512
"""Pieces of the curve of turns, the smoothest first."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Placed:
    """A toolpath that an arm can follow."""

    arm: Arm
    """The arm."""
    setting: Setting
    """How the work lies."""
    itinerary: Itinerary
    """Where the tool goes, and what is done besides."""
    ways: tuple[GuidedWay, ...]
    """The same as ways to be planned, one a stage."""
    turn: BSpline
    """The turn of the tool about its axis by the way from the program's start, rad."""

    @property
    def q_start(self) -> FloatArray:
        """Joint positions at the start, shape (n,)."""
        start: FloatArray = self.ways[0].near.q[0]
        return start


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Chosen:
    """Places along a way and the postures there."""

    question: TurnQuestion
    stage: IndexArray
    """The stage that goes on from each place, shape (m,)."""
    q: FloatArray
    """Joint positions there, shape (m, n)."""
    curve: BSpline
    """The turn of the tool about its axis by the way, rad."""


def place(
    actions: Sequence[Action], setting: Setting | ArrayInput, arm: Arm, q_near: ArrayInput
) -> Placed:
    """Lay a toolpath, or what an NC program does, before an arm.

    The turn of the tool about its own axis and the configuration of the arm are those of the
    cheapest way over all places, turns and branches: within limits, away from them and from
    singularities, without a jump. Arms of five joints point the tool down on level work; those of
    four turn it with their first joint. A planar arm leaves out what is above and below.

    Args:
        actions: What is done, in coordinates of the work, m: of ``run_gcode`` after ``compensate``,
            or a toolpath.
        setting: How the work lies, or T_base_work alone, shape (4, 4).
        arm: The arm, its tool being the tip of what cuts or draws.
        q_near: Where the arm stands, shape (n,), rad or m.

    Raises:
        UnreachableError: If the arm cannot follow, with the line of the program, by how much it
            cannot, why, and what would help.
        KinematicsError: If the arm has no closed form.
        ValueError: If an argument is wrong, or nothing moves the tool.
    """
    setting = setting if isinstance(setting, Setting) else Setting(T_base_work=setting)  # type: ignore[arg-type]
    q = frozen_array(q_near, (arm.n,), "q_near")
    arm.limits.check(q)
    itinerary = _itinerary(actions, setting, arm, q)
    question, stage = _question(arm, setting, itinerary)
    solve = solver_of(arm, q)
    answer = search_turns(arm, question, q, solve)
    if len(answer.q) < len(question.p):
        raise unplaced(arm, question, answer, _where(itinerary, question, stage, len(answer.q)), q)
    if question.turns > 1:
        chosen = _smooth(arm, question, answer, stage, solve)
    else:
        curve = smooth_turn(question.s, answer.turn, 1)
        chosen = _Chosen(question=question, stage=stage, q=answer.q, curve=curve)
    ways = _ways(arm, itinerary, chosen)
    return Placed(arm=arm, setting=setting, itinerary=itinerary, ways=ways, turn=chosen.curve)


def question_of(
    actions: Sequence[Action], setting: Setting, arm: Arm, q_near: FloatArray
) -> TurnQuestion:
    """Give the places of a toolpath at which postures are chosen; nothing is checked here."""
    return _question(arm, setting, _itinerary(actions, setting, arm, q_near))[0]


def _itinerary(actions: Sequence[Action], setting: Setting, arm: Arm, q: FloatArray) -> Itinerary:
    if class_of(arm) is not ArmClass.PLANAR:
        return itinerary_of(actions, setting.T_base_work, lift=setting.lift)
    work = _in_plane(arm, setting, q)
    itinerary = itinerary_of(actions, work.T_base_work, flat=True)
    far = float(np.linalg.norm(work.T_base_work[:3, 3] - setting.T_base_work[:3, 3]))
    if far <= _LEVEL:
        return itinerary
    moved = f"the work is moved by {far * 1e3:.1f} mm into the plane of the arm's tool"
    return replace(itinerary, notes=(*itinerary.notes, moved))


def _in_plane(arm: Arm, setting: Setting, q: FloatArray) -> Setting:
    """Give a setting with the work in the plane in which the tool moves."""
    T = arm.fk(q)
    normal = arm.jacobian(q)[3:, 0]
    work = setting.T_base_work.copy()
    work[:3, 3] += normal * (normal @ (T[:3, 3] - work[:3, 3]))
    if abs(normal @ work[:3, 2]) < 1.0 - 1e-9:
        raise ValueError("T_base_work: want the work level in the plane of a planar arm")
    return replace(setting, T_base_work=work)


def _question(arm: Arm, setting: Setting, itinerary: Itinerary) -> tuple[TurnQuestion, IndexArray]:
    """Give the places at which postures are chosen, and the stage that goes on from each."""
    kind = class_of(arm)
    slow = kind is ArmClass.GENERAL
    spacing = max(SPACING * (_SPARSE if slow else 1.0), itinerary.length / MOST_PLACES)
    s, p, which = list[FloatArray](), list[FloatArray](), list[int]()
    for k, stage in enumerate(itinerary.stages):
        low, high = stage.position.domain
        steps = np.linspace(low, high, max(1, ceil((high - low) / spacing)) + 1)
        last = k == len(itinerary.stages) - 1
        steps = steps if last else steps[:-1]
        s.append(steps)
        p.append(stage.position.at(steps))
        which += [k] * len(steps)
    axis = tool_axis_of(arm, setting)
    free = setting.turn is None and kind not in (ArmClass.PAN, ArmClass.PLANAR)
    question = TurnQuestion(
        p=np.concatenate(p),
        s=np.concatenate(s),
        R=standing(axis, setting.points, setting.turn or 0.0),
        axis=axis,
        turns=min(setting.turns, _FEW_TURNS if slow else setting.turns) if free else 1,
    )
    return question, np.array(which, dtype=np.intp)


def _where(itinerary: Itinerary, question: TurnQuestion, stage: IndexArray, k: int) -> str:
    """Say which of the program's ways leads through a place."""
    on = itinerary.stages[int(stage[k])]
    way = int(np.searchsorted(on.edges, question.s[k], side="left"))
    return on.names[min(max(way - 1, 0), len(on.names) - 1)]


def _smooth(
    arm: Arm, question: TurnQuestion, answer: TurnAnswer, stage: IndexArray, solve: Solver
) -> _Chosen:
    """Give the same postures with turns that change smoothly instead of in steps."""
    for spans in (*_SPANS, len(question.s)):
        curve = smooth_turn(question.s, answer.turn, spans)
        turn = curve.at(question.s)[:, 0]
        q = _beside(arm, question, turn, answer.q, solve)
        if q is not None:
            return _Chosen(question=question, stage=stage, q=q, curve=curve)
        if not np.ptp(answer.turn):
            break
    raise UnreachableError(
        0.0, 0.0, None, "its turns about the tool's axis cannot be joined smoothly", "the toolpath"
    )


def _beside(
    arm: Arm, question: TurnQuestion, turn: FloatArray, q: FloatArray, solve: Solver
) -> FloatArray | None:
    """Give joint positions for given turns on the branches of others, None if they leave them."""
    T = np.zeros((len(q), 4, 4))
    T[:, :3, :3] = question.R @ rotations_about(question.axis, turn)
    T[:, :3, 3], T[:, 3, 3] = question.p, 1.0
    found = solve(T)
    bounds = bounds_of(arm)
    step = found - q[:, None]
    step -= 2.0 * np.pi * bounds[4] * np.round(step / (2.0 * np.pi))
    way = np.where(np.isfinite(step), np.abs(step), np.inf).sum(axis=2)
    best = np.argmin(way, axis=1)
    beside: FloatArray = q + step[np.arange(len(q)), best]
    inside = (beside >= bounds[0]) & (beside <= bounds[1])
    jumps = np.abs(np.diff(beside, axis=0)) > bounds[3]
    return beside if inside.all() and not jumps.any() else None


def _ways(arm: Arm, itinerary: Itinerary, chosen: _Chosen) -> tuple[GuidedWay, ...]:
    """Give the stages as ways to be planned."""
    ways = list[GuidedWay]()
    number = 0
    question = chosen.question
    for stage in itinerary.stages:
        low, high = stage.position.domain
        path = CartesianPath(
            position=stage.position,
            orientation=_orientation(arm, chosen, stage),
            waypoint_s=stage.edges,
        )
        places = _places(stage, number)
        number += len(places)
        first, last = np.searchsorted(question.s, [low, high])
        on = slice(first, last + 1)
        near = _near(path.breaks, question.s[on], chosen.q[on])
        ways.append(GuidedWay(ToolWay(path, places), near, rest_of(stage.before)))
    return tuple(ways)


def _near(breaks: FloatArray, looks: FloatArray, q: FloatArray) -> Nodes:
    """Give about where the joints are at the breaks of a way, and between where it is far."""
    behind = np.clip(np.searchsorted(breaks, looks), 1, len(breaks) - 1)
    gap = np.minimum(looks - breaks[behind - 1], breaks[behind] - looks)
    at = np.union1d(breaks, looks[gap > 0.5 * SPACING])
    columns = [np.interp(at, looks, q[:, k]) for k in range(q.shape[1])]
    return Nodes(at, np.stack(columns, axis=1))


def _places(stage: Stage, number: int) -> list[Place]:
    """Give the places of a stage: the ends of the program's ways."""
    names = stage.names
    first = Place(name=f"the beginning of {names[0]}", waypoints=(number,))
    behind = [
        Place(name=f"the end of {name}", waypoints=(number + 1 + i,), speed=float(speed))
        for i, (name, speed) in enumerate(zip(names, stage.speeds, strict=True))
    ]
    return [first, *behind]


def _orientation(arm: Arm, chosen: _Chosen, stage: Stage) -> OrientationCurve | None:
    """Give how the tool stands on a stage, None if that is free."""
    kind, question = class_of(arm), chosen.question
    if kind is ArmClass.PLANAR:
        return None
    if kind is ArmClass.PAN:
        return _panning(arm, chosen.q[0], stage)
    return FreeTurn(
        quat=quaternion.from_matrix(question.R),
        axis=question.R @ question.axis,
        turn=chosen.curve,
        domain=stage.position.domain,
    )


def _panning(arm: Arm, q: FloatArray, stage: Stage) -> PanTurn:
    """Give how a tool stands that turns with the first joint."""
    T = arm.fk(q)
    base = chain.joint_frames(arm.packed, q)[0]
    axis, centre = base[:3, 2], base[:3, 3]
    out = T[:3, 3] - centre
    out -= axis * (axis @ out)
    return PanTurn(
        quat=quaternion.from_matrix(T[:3, :3]),
        axis=axis,
        centre=centre,
        out=out / np.linalg.norm(out),
        way=stage.position,
    )
