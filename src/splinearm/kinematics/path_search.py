"""Joint positions along a path of the tool, on one branch from its first point to its last."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import product

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import KinematicsError, PathError
from splinearm.joints import JointKind
from splinearm.units import DEG, MM

from . import quaternion, solver
from .answer import IKResult, IKStatus
from .arm import Arm
from .batch_search import goals_of, targets_of
from .ik import check_tolerances, search
from .pose import Pose

_STARTS = 256
_BRANCHES = 96
_SAME = 1e-3
_LATER_STARTS = 64
_AT_LIMIT = 1e-2
_POSE = 6
_TURN = 2.0 * np.pi


class PathStatus(Enum):
    """How the search for joint positions along a path ended."""

    FOLLOWED = "followed"
    """Every point is met, and from each to the next the arm moves without a jump."""

    UNREACHABLE = "unreachable"
    """A point, or a place on the way to it, cannot be reached at all."""

    BRANCH_ENDS = "branch ends"
    """The point can be reached, but only by a jump from what reaches the points before it."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PathResult:
    """Joint positions along a path, as far as one branch follows it."""

    q: FloatArray
    """Joint positions within the limits at the points followed, shape (k, n), rad or m."""
    status: PathStatus
    """How the search ended."""
    point: int | None = None
    """The first point that could not be followed to; None if all were."""
    joint: str | None = None
    """The joint whose limit or jump is in the way, if one is."""
    reason: str = ""
    """Why the path ends there, in the user's units; empty if it is followed."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen_array(self.q, (None, None), "q"))

    @property
    def followed(self) -> bool:
        """Whether the whole path is followed."""
        return self.status is PathStatus.FOLLOWED


def search_path(
    arm: Arm,
    targets: Sequence[Pose] | ArrayInput,
    q_start: ArrayInput | None = None,
    *,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
) -> PathResult:
    """Look for joint positions that carry the tool along a path without a jump.

    All branches that reach the first point are followed from point to point, each by as many steps
    between as it takes to see that it moves on smoothly: straight, and turning about one axis. Of
    those that reach the last point the one that moves the joints least is given. The first call in
    a process loads the compiled kernels.

    For an arm with as many joints as the target has conditions all branches are a few, and a
    refusal means that none of them goes on. For a redundant arm some 100 are tried.

    Args:
        arm: The arm.
        targets: Where the tool shall be in base: poses, or transforms, shape (m, 4, 4), or
            positions, shape (m, 3), m, with any orientation.
        q_start: Where the arm stands, shape (n,), rad or m: the way from there to the first point
            counts as well.
        position_tolerance: Largest distance from a point that counts as reached, m.
        orientation_tolerance: Largest angle from a point that counts as reached, rad.

    Raises:
        ValueError: If an argument is not of its shape or not finite, or there is no point.
    """
    check_tolerances(position_tolerance, orientation_tolerance)
    start = None if q_start is None else frozen_array(q_start, (arm.n,), "q_start")
    positions, rotations = targets_of(targets)
    if len(positions) == 0:
        raise ValueError("targets: want at least one point, got none")
    model = solver.model_of(arm)
    goals = goals_of(model, positions, rotations, position_tolerance, orientation_tolerance)
    walk = _Walk(model, goals, start)
    for i in range(1, len(goals)):
        if not walk.alive or not walk.go_on(i):
            break
    q = walk.shortest()
    if len(q) == len(goals):
        return PathResult(q=q, status=PathStatus.FOLLOWED)
    return _refused(model, goals, walk, q)


def solve_path(
    arm: Arm,
    targets: Sequence[Pose] | ArrayInput,
    q_start: ArrayInput | None = None,
    *,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
) -> FloatArray:
    """Give joint positions, shape (m, n), that carry the tool along a path without a jump.

    Arguments are those of ``search_path``.

    Raises:
        PathError: If no branch follows the whole path; it names the point and the reason.
        ValueError: As in ``search_path``.
    """
    result = search_path(
        arm,
        targets,
        q_start,
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
    )
    if result.point is not None:
        raise PathError(result.point, result.reason, result.joint)
    return result.q


class _Walk:
    """All branches at once, followed from point to point."""

    def __init__(self, model: solver.Model, goals: FloatArray, start: FloatArray | None) -> None:
        from . import path_kernel

        self.kernel = path_kernel
        self.model = model
        self.goals = goals
        nodes = _with_all_turns(model, self._candidates(0, _STARTS), start)
        costs = np.zeros(len(nodes))
        if start is not None:
            costs = np.linalg.norm((nodes - start) / model.bounds[2], axis=1)
        self.layers = [nodes] if len(nodes) else []
        self.costs = costs
        self.parents = [np.zeros(len(nodes), dtype=np.int64)]
        self.ended = nodes[:0]
        """Where branches ended on the way to the point that none reached, (count, n + 1)."""

    @property
    def alive(self) -> bool:
        """Whether any branch has been followed this far."""
        return bool(self.layers)

    def go_on(self, i: int) -> bool:
        """Follow all branches to point i; say whether one arrived."""
        n = self.model.arm.n
        nodes = self.layers[-1]
        ends = np.empty((len(nodes), n + 1))
        arm, bounds = self.model.packed, self.model.bounds
        self.kernel.follow_all(arm, bounds, self.goals[i - 1], self.goals[i], nodes, ends)
        arrived = ends[:, n] == 1.0
        q, parents = ends[arrived, :n], np.flatnonzero(arrived)
        if not arrived.any():
            q, parents = self._from_ahead(i)
            if not len(q):
                self.ended = ends
                return False
        moved = np.linalg.norm((q - nodes[parents]) / bounds[2], axis=1)
        costs = self.costs[parents] + moved
        order = np.argsort(costs, kind="stable")
        kept = order[_first_of_each(q[order] / bounds[2])]
        self.layers.append(np.ascontiguousarray(q[kept]))
        self.costs = costs[kept]
        self.parents.append(parents[kept])
        return True

    def shortest(self) -> FloatArray:
        """Give the joint positions of the shortest way to the last point reached, (k, n)."""
        if not self.layers:
            return np.empty((0, self.model.arm.n))
        at = int(np.argmin(self.costs))
        way = []
        for nodes, parents in zip(reversed(self.layers), reversed(self.parents), strict=True):
            way.append(nodes[at])
            at = int(parents[at])
        return np.array(way[::-1])

    def _from_ahead(
        self, i: int
    ) -> tuple[FloatArray, "np.ndarray[tuple[int], np.dtype[np.int64]]"]:
        """Give what arrives at a branch from point i back: q there, and which branches they are.

        Where branches meet, one that cannot be followed onward may still be followed backward.
        """
        n = self.model.arm.n
        ahead = _with_all_turns(self.model, self._candidates(i, _LATER_STARTS), None)
        back = np.empty((len(ahead), n + 1))
        arm, bounds = self.model.packed, self.model.bounds
        self.kernel.follow_all(arm, bounds, self.goals[i], self.goals[i - 1], ahead, back)
        found, parents = [], []
        for q, end in zip(ahead, back, strict=True):
            if end[n] < 1.0:
                continue
            off = np.abs((self.layers[-1] - end[:n]) / bounds[2]).max(axis=1)
            nearest = int(np.argmin(off))
            if off[nearest] <= _SAME:
                found.append(q)
                parents.append(nearest)
        return np.array(found).reshape(-1, n), np.array(parents, dtype=np.int64)

    def _candidates(self, i: int, count: int) -> FloatArray:
        """Give different joint positions that meet point i, shape (count, n)."""
        model, goal = self.model, self.goals[i]
        out = np.empty((count, model.arm.n))
        found = self.kernel.candidates(
            model.packed, model.bounds, goal, model.starts, model.tools,
            solver.STEP, solver.SEED_ITERATIONS, out,
        )  # fmt: skip
        q = np.concatenate((_closed(model.arm, goal), out[:found]))
        return q[_first_of_each(q / model.bounds[2])][:_BRANCHES]


def _closed(arm: Arm, goal: FloatArray) -> FloatArray:
    """Give the branches of a pose of an arm with a closed form, (count, n); none for others."""
    from .closed_form import branches

    if arm.n != _POSE or goal[13] == 0.0:
        return np.empty((0, arm.n))
    pose = Pose(goal[:3], quaternion.from_matrix(goal[3:12].reshape(3, 3)))
    try:
        found = branches(arm, pose)
    except KinematicsError:
        return np.empty((0, arm.n))
    met = (found.position_error <= goal[14]) & (found.orientation_error <= goal[15])
    closed: FloatArray = found.q[met]
    return closed


def _first_of_each(q: FloatArray) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    """Give which of some joint positions, shape (m, n), differ from all before them."""
    kept: list[int] = []
    for i, here in enumerate(q):
        if not kept or (np.abs(q[kept] - here).max(axis=1) > _SAME).all():
            kept.append(i)
    return np.array(kept, dtype=np.int64)


def _with_all_turns(model: solver.Model, q: FloatArray, near: FloatArray | None) -> FloatArray:
    """Give joint positions with all whole turns for which there is room, the nearest first."""
    near = model.middle if near is None else near
    turned: list[tuple[float, ...]] = []
    for here in q:
        choices = []
        for k, value in enumerate(here):
            low, high = model.bounds[0, k], model.bounds[1, k]
            if model.arm.packed.slides[k]:
                choices.append((value,))
                continue
            centre = value + _TURN * round((near[k] - value) / _TURN)
            rooms = (centre + turns * _TURN for turns in (0, -1, 1))
            fits = tuple(room for room in rooms if low <= room <= high)
            choices.append(fits or (value,))
        turned.extend(product(*choices))
    if not turned:
        return q
    array = np.array(turned)
    order = np.argsort(np.abs(array - near).max(axis=1), kind="stable")
    return np.ascontiguousarray(array[order[: 4 * _BRANCHES]])


def _refused(model: solver.Model, goals: FloatArray, walk: _Walk, q: FloatArray) -> PathResult:
    """Say where and why no branch goes on."""
    arm, i = model.arm, len(q)
    anywhere = _ask(arm, goals[i], None)
    name = f"point {i} of 0 to {len(goals) - 1}"
    if not anywhere.reached or i == 0:
        return PathResult(
            q=q,
            status=PathStatus.UNREACHABLE,
            point=i,
            joint=anywhere.joint,
            reason=f"{name} is {anywhere.reason}",
        )
    best = walk.ended[int(np.argmax(walk.ended[:, arm.n]))]
    share = float(best[arm.n])
    turn, goal = np.empty(3), np.empty(16)
    walk.kernel.turn_between(goals[i - 1], goals[i], turn)
    walk.kernel.between(goals[i - 1], goals[i], turn, min(share + 1e-3, 1.0), goal)
    where = f"{share * 100.0:.3g} % of the way from point {i - 1} to {name}"
    on_the_way = _ask(arm, goal, None)
    if not on_the_way.reached:
        return PathResult(
            q=q,
            status=PathStatus.UNREACHABLE,
            point=i,
            joint=on_the_way.joint,
            reason=f"{where} the tool is {on_the_way.reason}",
        )
    here = best[: arm.n]
    joint, cause = _why_ends(model, goal, here)
    return PathResult(
        q=q, status=PathStatus.BRANCH_ENDS, point=i, joint=joint, reason=f"{where} {cause}"
    )


def _why_ends(model: solver.Model, goal: FloatArray, here: FloatArray) -> tuple[str, str]:
    """Say which joint is in the way of a branch that ends, and why."""
    arm = model.arm
    jump = _ask(arm, goal, here)
    off = jump.q - here
    worst = int(np.argmax(np.abs(off / model.bounds[2])))
    joint = arm.joint_names[worst]
    cause = f"the arm could only go on by a jump of {joint} by {_amount(arm, worst, off[worst])}"
    ends = _ask(arm, goal, here, restarts=0)
    if ends.status is IKStatus.JOINT_LIMIT and ends.joint is not None:
        return ends.joint, f"{cause}: {ends.cause}"
    room = np.minimum(here - model.bounds[0], model.bounds[1] - here) / model.bounds[2]
    if room.min() <= _AT_LIMIT:
        tight = arm.joint_names[int(np.argmin(room))]
        return tight, f"{cause}: {tight} is at its limit"
    return joint, f"{cause}: the branch ends where the arm is singular"


def _ask(
    arm: Arm, goal: FloatArray, q_seed: FloatArray | None, restarts: int | None = None
) -> IKResult:
    target: Pose | FloatArray = goal[:3]
    if goal[13] != 0.0:
        target = Pose(goal[:3], quaternion.from_matrix(goal[3:12].reshape(3, 3)))
    tolerances = {"position_tolerance": goal[14], "orientation_tolerance": goal[15]}
    if restarts is None:
        return search(arm, target, q_seed, **tolerances)
    return search(arm, target, q_seed, restarts=restarts, **tolerances)


def _amount(arm: Arm, k: int, value: float) -> str:
    turns = arm.links[k].kind is JointKind.REVOLUTE
    return f"{value / DEG:.3g} deg" if turns else f"{value / MM:.4g} mm"
