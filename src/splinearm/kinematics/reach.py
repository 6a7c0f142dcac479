"""Where an arm reaches, and in how many orientations: a map over samples of space."""

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from . import quaternion
from .arm import Arm
from .batch_search import search_batch
from .differential import manipulability

RESTARTS = 32
"""Starts that are tried for a target before it counts as out of reach."""

_POINTS_A_TASK = 64
_LOOKS = 4096
"""Joint positions that are tried to see how far the arm spreads."""
_MOST_POINTS = 2_000_000
_FLAT = 1e-6


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ReachMap:
    """Where an arm reaches. All is in its base frame."""

    arm: str
    """Name of the arm."""
    spacing: float
    """Distance of neighbouring points, m."""
    points: FloatArray
    """Positions that were tried, shape (m, 3), m."""
    quats: FloatArray
    """Orientations that were tried at each, shape (k, 4), w x y z; k may be 0."""
    reached: npt.NDArray[np.bool_]
    """Where the tool can be in some orientation, shape (m,)."""
    fraction: FloatArray
    """Share of the orientations that can be had there, shape (m,); NaN if none were tried."""
    manipulability: FloatArray
    """The best of the answers found there, shape (m,); 0 where there is none.

    Of the position if no orientations were tried (m^3 or m^2), else of the whole pose.
    """

    @property
    def volume(self) -> float:
        """The room that is reached, m3 (of an arm that moves in a plane its area, m2)."""
        flat = int(sum(np.ptp(self.points, axis=0) < _FLAT))
        return float(self.reached.sum() * self.spacing ** (3 - flat))

    @property
    def farthest(self) -> float:
        """Distance of the farthest reached point from the base, m."""
        if not self.reached.any():
            return 0.0
        return float(np.linalg.norm(self.points[self.reached], axis=-1).max())


def reach_map(
    arm: Arm,
    *,
    spacing: float | None = None,
    orientations: int = 0,
    points: ArrayInput | None = None,
    processes: int = 1,
    progress: Callable[[float], None] | None = None,
) -> ReachMap:
    """Try positions and orientations of the tool; say which the arm reaches within its limits.

    A target counts as reached if the inverse kinematics finds it from ``RESTARTS`` starts, so that
    a map may miss a few that are hard to find, and never shows one that is out of reach. An arm of
    fewer than six joints has hardly any orientation just as it is asked for: map its positions.

    Args:
        arm: The arm.
        spacing: Distance of neighbouring points of an even grid over all that the tool may come
            to, m; None: a tenth of the widest extent.
        orientations: How many orientations, spread evenly, to try at each point that is reached.
        points: Positions to try instead of a grid, shape (m, 3), m, in base.
        processes: How many processes share the work; more than one start by importing the
            program that asks for them anew, which must therefore guard its start with
            ``if __name__ == "__main__":``.
        progress: Called now and then with the share that is done, 0 to 1.

    Raises:
        ValueError: If a number is none that can be used.
    """
    if orientations < 0 or processes < 1:
        raise ValueError(
            "want orientations of at least 0 and processes of at least 1, got "
            f"{orientations} and {processes}"
        )
    if points is None:
        grid, step = _grid(arm, spacing)
    else:
        grid = frozen_array(points, (None, 3), "points")
        step = float("nan") if spacing is None else spacing
    quats = quaternion.spread(orientations)
    parts = np.array_split(grid, max(1, -(-len(grid) // _POINTS_A_TASK)))
    results: list[FloatArray] = [np.empty((0, 3))] * len(parts)
    for done, (i, result) in enumerate(_worked(arm, parts, quats, processes), start=1):
        results[i] = result
        if progress is not None:
            progress(done / len(parts))
    columns = np.concatenate(results)
    return ReachMap(
        arm=arm.name,
        spacing=step,
        points=grid,
        quats=quats,
        reached=columns[:, 0] > 0.0,
        fraction=columns[:, 1],
        manipulability=columns[:, 2],
    )


def _worked(
    arm: Arm, parts: list[FloatArray], quats: FloatArray, processes: int
) -> Iterator[tuple[int, FloatArray]]:
    """Give the results of the parts as they come, each with its number."""
    if processes == 1:
        for i, part in enumerate(parts):
            yield i, _try(arm, part, quats)
        return
    # a process of its own each, not a copy of this one: copies of threads would hang
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        tasks = {pool.submit(_try, arm, part, quats): i for i, part in enumerate(parts)}
        for task in as_completed(tasks):
            yield tasks[task], task.result()


def _try(arm: Arm, points: FloatArray, quats: FloatArray) -> FloatArray:
    """Give for each point whether it is reached, in how many orientations and how well (m, 3)."""
    table = np.zeros((len(points), 3))
    table[:, 1] = 0.0 if len(quats) else np.nan
    if not len(points):
        return table
    placed = search_batch(arm, points, restarts=RESTARTS, explain=False)
    table[placed.reached, 0] = 1.0
    if not len(quats):
        found = placed.q[placed.reached]
        table[placed.reached, 2] = manipulability(arm, found, part="position")
        return table
    table[placed.reached, 2] = manipulability(arm, placed.q[placed.reached])
    here = np.flatnonzero(placed.reached)
    if not here.size:
        return table
    T = np.zeros((here.size, len(quats), 4, 4))
    T[..., :3, :3], T[..., 3, 3] = quaternion.to_matrix(quats), 1.0
    T[..., :3, 3] = points[here, None]
    posed = search_batch(arm, T.reshape(-1, 4, 4), restarts=RESTARTS, explain=False)
    met = posed.reached.reshape(here.size, len(quats))
    table[here, 1] = met.mean(axis=1)
    values = np.zeros(met.shape)
    values[met] = manipulability(arm, posed.q[posed.reached])
    table[here, 2] = np.maximum(table[here, 2], values.max(axis=1))
    return table


def _grid(arm: Arm, spacing: float | None) -> tuple[FloatArray, float]:
    """Give an even grid over the box that the tool comes to, and its spacing."""
    limits = arm.limits
    low = np.where(np.isfinite(limits.q_min), limits.q_min, -np.pi)
    high = np.where(np.isfinite(limits.q_max), limits.q_max, np.pi)
    q = np.random.default_rng(1).uniform(low, high, (_LOOKS, arm.n))
    p = arm.fk(q)[:, :3, 3]
    lowest, highest = p.min(axis=0), p.max(axis=0)
    extent = highest - lowest
    step = 0.1 * float(extent.max()) if spacing is None else float(spacing)
    if not (np.isfinite(step) and step > 0.0):
        raise ValueError(f"spacing: want a length above zero, got {step}")
    margin = np.where(extent < _FLAT, 0.0, 0.05 * extent)
    counts = np.ceil((extent + 2.0 * margin) / step).astype(int)
    counts = np.where(extent < _FLAT, 1, counts + 1)
    if counts.astype(float).prod() > _MOST_POINTS:
        raise ValueError(
            f"spacing: {step:g} m makes {counts.astype(float).prod():.3g} points; want at most "
            f"{_MOST_POINTS}"
        )
    middle = 0.5 * (lowest + highest)
    lines = [
        centre + step * (np.arange(count) - 0.5 * (count - 1))
        for centre, count in zip(middle, counts, strict=True)
    ]
    grid: FloatArray = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid, step
