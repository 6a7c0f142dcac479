"""Inverse kinematics of any arm for many targets in one call."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray

from . import quaternion, solver, space
from .answer import IKResult, IKStatus
from .arm import Arm
from .ik import RESTARTS, check_tolerances, search
from .pose import Pose


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class IKBatch:
    """Answers to many targets; ``batch[i]`` is the answer to one of them in full."""

    arm: Arm
    """The arm."""
    q: FloatArray
    """Joint positions within the limits, shape (m, n), rad or m; NaN where a target is missed."""
    reached: npt.NDArray[np.bool_]
    """Which targets are met, shape (m,)."""
    position_error: FloatArray
    """Distance of the tool from the wanted position, shape (m,), m; inf where missed."""
    orientation_error: FloatArray
    """Angle of the tool from the wanted orientation, shape (m,), rad; inf where missed."""
    iterations: npt.NDArray[np.int64]
    """Steps that the search took, shape (m,)."""
    tries: npt.NDArray[np.int64]
    """Descents that the search took, shape (m,)."""
    question: "Question" = field(repr=False)
    """What was asked."""
    missed: dict[int, IKResult] = field(repr=False)
    """Answers to missed targets, as far as their reasons have been looked for."""

    def __len__(self) -> int:
        return len(self.q)

    def __getitem__(self, i: int) -> IKResult:
        """Give the answer to target i, with status, joint and reason."""
        index = range(len(self))[i]
        if not self.reached[index]:
            if index not in self.missed:
                self.missed[index] = self.question.ask(self.arm, index)
            return self.missed[index]
        return IKResult(
            q=self.q[index],
            position_error=float(self.position_error[index]),
            orientation_error=float(self.orientation_error[index]),
            iterations=int(self.iterations[index]),
            status=IKStatus.REACHED,
        )

    def __iter__(self) -> Iterator[IKResult]:
        return (self[i] for i in range(len(self)))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Question:
    """What a batch was asked."""

    positions: FloatArray
    """Wanted positions, shape (m, 3), m."""
    rotations: FloatArray | None
    """Wanted orientations, shape (m, 3, 3); None: any."""
    seeds: FloatArray | None
    """Where to start, shape (m, n), or None."""
    position_tolerance: float
    """Largest distance that counts as reached, m."""
    orientation_tolerance: float
    """Largest angle that counts as reached, rad."""
    restarts: int
    """How many further starts may be tried for each target."""

    def ask(self, arm: Arm, i: int) -> IKResult:
        """Search for target i by itself, with its reason if it is missed."""
        target: Pose | FloatArray = self.positions[i]
        if self.rotations is not None:
            target = Pose(self.positions[i], quaternion.from_matrix(self.rotations[i]))
        return search(
            arm,
            target,
            None if self.seeds is None else self.seeds[i],
            position_tolerance=self.position_tolerance,
            orientation_tolerance=self.orientation_tolerance,
            restarts=self.restarts,
        )


def search_batch(  # noqa: PLR0913 - what search takes, and explain
    arm: Arm,
    targets: Sequence[Pose] | ArrayInput,
    q_seed: ArrayInput | None = None,
    *,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    restarts: int = RESTARTS,
    explain: bool = True,
) -> IKBatch:
    """Look for joint positions within the limits that bring the tool to each of many targets.

    Each target is searched for as ``search`` does, in one compiled loop. The first call in a
    process loads the compiled kernels.

    Args:
        arm: The arm.
        targets: Where the tool shall be in base: poses, or transforms, shape (m, 4, 4), or
            positions, shape (m, 3), m, with any orientation.
        q_seed: Where to start, shape (n,) or one each (m, n), rad or m.
        position_tolerance: Largest distance from a target that counts as reached, m.
        orientation_tolerance: Largest angle from a target that counts as reached, rad.
        restarts: How many further starts may be tried for each target; 0: none but the seed.
        explain: Look for the reason of every miss now, a few ms each; without, when it is asked.

    Raises:
        ValueError: If an argument is not of its shape or not finite, a transform is not rigid, or
            without seed and restarts.
    """
    check_tolerances(position_tolerance, orientation_tolerance)
    if restarts < 0 or (restarts == 0 and q_seed is None):
        raise ValueError(f"restarts: want at least 1 without a seed, 0 with one, got {restarts}")
    positions, rotations = targets_of(targets)
    seeds = _seeds(arm, q_seed, len(positions))
    model = solver.model_of(arm, restarts)
    question = Question(
        positions=positions,
        rotations=rotations,
        seeds=seeds,
        position_tolerance=position_tolerance,
        orientation_tolerance=orientation_tolerance,
        restarts=restarts,
    )
    answers = _search(model, question)
    n = arm.n
    batch = IKBatch(
        arm=arm,
        q=answers[:, :n],
        reached=np.isfinite(answers[:, 0]),
        position_error=answers[:, n],
        orientation_error=answers[:, n + 1],
        iterations=answers[:, n + 2].astype(np.int64),
        tries=answers[:, n + 3].astype(np.int64),
        question=question,
        missed={},
    )
    for i in np.flatnonzero(~batch.reached).tolist() if explain else ():
        result = batch[i]
        if result.reached:
            # found while looking for the reason
            batch.q[i], batch.reached[i] = result.q, True
            batch.position_error[i] = result.position_error
            batch.orientation_error[i] = result.orientation_error
    return batch


def _search(model: solver.Model, question: Question) -> FloatArray:
    """Give q, position error, orientation error, steps and tries of every target, (m, n + 4)."""
    m, n = len(question.positions), model.arm.n
    answers = np.empty((m, n + 4))
    if m == 0:
        return answers
    goals = goals_of(
        model,
        question.positions,
        question.rotations,
        question.position_tolerance,
        question.orientation_tolerance,
    )
    seeds = np.empty((1 if question.seeds is None else m, 2, n))
    seeds[:, 0] = np.nan if question.seeds is None else question.seeds
    seeds[:, 1] = model.middle if question.seeds is None else question.seeds
    far = np.linalg.norm(question.positions - model.shoulder, axis=1)
    hopeless = far > model.reach + question.position_tolerance
    restarts = np.where(hopeless, min(question.restarts, solver.HOPELESS), question.restarts)
    kernel = solver.load()
    kernel.search_batch(
        model.packed, model.bounds, goals, model.starts, model.tools, seeds, solver.how(),
        restarts.astype(np.int64), answers,
    )  # fmt: skip
    return answers


def goals_of(
    model: solver.Model,
    positions: FloatArray,
    rotations: FloatArray | None,
    position_tolerance: float,
    orientation_tolerance: float,
) -> FloatArray:
    """Give targets as kernels take them, shape (m, 16)."""
    m = len(positions)
    goals = np.zeros((m, 16))
    goals[:, :3] = positions
    goals[:, 12] = 1.0 / model.length
    if rotations is not None:
        goals[:, 3:12] = rotations.reshape(m, 9)
        goals[:, 13] = 1.0
    goals[:, 14], goals[:, 15] = position_tolerance, orientation_tolerance
    return goals


def targets_of(targets: Sequence[Pose] | ArrayInput) -> tuple[FloatArray, FloatArray | None]:
    """Give positions and orientations, or None for any, of what a user says."""
    if isinstance(targets, Sequence) and len(targets) and isinstance(targets[0], Pose):
        for i, pose in enumerate(targets):
            if not isinstance(pose, Pose):
                raise TypeError(f"targets: want poses only, got {pose!r} at {i}")
        poses = [pose for pose in targets if isinstance(pose, Pose)]
        rotations = quaternion.to_matrix(np.array([pose.quat for pose in poses]))
        return np.array([pose.p for pose in poses]), rotations
    try:
        array = np.array(targets, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"targets: want arrays of numbers or poses, got {targets!r}") from error
    if array.shape[1:] not in ((3,), (4, 4)):
        raise ValueError(f"targets: want shape (m, 3) or (m, 4, 4), got {array.shape}")
    bad = ~np.isfinite(array).all(axis=tuple(range(1, array.ndim)))
    if bad.any():
        first = int(np.argmax(bad))
        raise ValueError(f"targets: want finite numbers, got {array[first].tolist()} at {first}")
    if array.ndim == 2:
        return array, None
    R = array[:, :3, :3]
    exact = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2), initial=0.0) <= _ROUNDING
    exact &= (np.linalg.det(R) > 0.0) & (array[:, 3] == (0.0, 0.0, 0.0, 1.0)).all(axis=1)
    for loose in np.flatnonzero(~exact).tolist():
        # refuses it, or gives the nearest rotation of one written with few digits
        array[loose] = space.frozen_rigid(array[loose], f"targets[{loose}]")
    return array[:, :3, 3], R


def _seeds(arm: Arm, q_seed: ArrayInput | None, m: int) -> FloatArray | None:
    """Give a seed for each target, shape (m, n)."""
    if q_seed is None:
        return None
    try:
        seeds = np.array(q_seed, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"q_seed: want an array of numbers, got {q_seed!r}") from error
    if seeds.shape not in ((arm.n,), (m, arm.n)):
        raise ValueError(f"q_seed: want shape ({arm.n},) or ({m}, {arm.n}), got {seeds.shape}")
    if not np.isfinite(seeds).all():
        raise ValueError(f"q_seed: want finite numbers, got {seeds.tolist()}")
    return np.broadcast_to(seeds, (m, arm.n))


_ROUNDING = 1e-14
