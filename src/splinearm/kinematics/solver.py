"""Which machinery a search runs on: numpy at first, compiled kernels as soon as they pay.

Loading numba and the kernels takes half a second, and compiling them about ten, once on a machine.
A script that asks for a few answers shall not wait for that, so searches run on numpy until they
have taken as many steps as loading, or compiling, is worth; so no program waits more than about
twice as long as it had to. Both give the same answers but for rounding. Batches and paths load
the kernels at once; ``prepare`` loads them at a moment of the caller's choosing.
"""

import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.joints import JointKind

from . import descent, start, turn
from .arm import Arm
from .chain import Chain
from .descent import Goal, Rest
from .packed import pack_kernel

WORTH_LOADING = 10_000
"""Steps on numpy, 60 to 90 us each, after which kernels that lie compiled on disk are loaded ..."""

WORTH_COMPILING = 100_000
"""... and after which they are compiled if they do not."""

SEED_ITERATIONS, SEED_STEP = 100, 0.2
"""Most steps of a descent from a seed, and the largest change of a joint in one, in its unit."""
FIRST_ITERATIONS, STEP = 12, 1.0
"""The same of a descent from a start ..."""
CONTINUED, LAST_ITERATIONS = 128, 250
"""... and how many of these are continued if none arrives, and for how many steps."""
HOPELESS = 4
"""Starts that are tried for the nearest answer to a position farther off than the arm is long."""

_HOW = np.array(
    (SEED_STEP, SEED_ITERATIONS, STEP, FIRST_ITERATIONS, LAST_ITERATIONS, CONTINUED, start.NEAREST)
)
_LENGTH_SHARE = 0.2
_TURN = 2.0 * np.pi - 1e-12
_KERNELS = f"{__package__}.search_kernel"


class _Meter:
    """How many steps numpy has taken in this process."""

    steps = 0


class Model(NamedTuple):
    """What searches need to know of an arm, worked out once."""

    arm: Arm
    """The arm."""
    packed: FloatArray
    """The arm as kernels take it, shape (n + 1, 13)."""
    bounds: FloatArray
    """Lower limits, upper limits and units of the joints, and the limits of descents that may end
    whole turns away: none where a joint has room for a whole turn; shape (5, n)."""
    length: float
    """The length that counts as a radian, m."""
    shoulder: FloatArray
    """The point from which the arm stretches, in base, shape (3,), m."""
    reach: float
    """A distance from the shoulder that the tool cannot pass, m."""
    weights: FloatArray
    """Share of each row of a miss in its cost, shape (6, 1)."""
    middle: FloatArray
    """The middle of the limits, shape (n,)."""
    starts: FloatArray
    """Joint vectors that fill the limits evenly, shape (count, n)."""
    tools: FloatArray
    """Positions and orientations, row-major, of the tool at the starts, shape (12, count)."""


def model_of(arm: Arm, starts: int = start.CANDIDATES) -> Model:
    """Give what searches need to know of an arm, with at least so many starts."""
    return _model(arm, max(starts, start.CANDIDATES))


@lru_cache(maxsize=16)
def _model(arm: Arm, count: int) -> Model:
    # arms are told apart by identity, and are frozen
    shoulder, reach = _stretch(arm)
    length = _LENGTH_SHARE * _straight(arm)
    slides = arm.packed.slides == 1.0
    units = np.where(slides, length, 1.0)
    lower, upper = arm.limits.q_min, arm.limits.q_max
    free = ~slides & (upper - lower >= _TURN)
    loose = np.where(free, -np.inf, lower), np.where(free, np.inf, upper)
    bounds = np.array((lower, upper, units, *loose))
    starts = start.spread(bounds[0], bounds[1], units, count)
    T = arm.fk(starts)
    tools = np.concatenate((T[:, :3, 3].T, T[:, :3, :3].reshape(-1, 9).T))
    return Model(
        arm=arm,
        packed=pack_kernel(arm.packed),
        bounds=bounds,
        length=length,
        shoulder=shoulder,
        reach=reach,
        weights=np.array((1.0 / length,) * 3 + (1.0,) * 3)[:, None],
        middle=turn.middle(bounds[0], bounds[1]),
        starts=starts,
        tools=np.ascontiguousarray(tools),
    )


def goal_numbers(goal: Goal) -> FloatArray:
    """Give a goal as kernels take it, shape (16,)."""
    R = (0.0,) * 9 if goal.R is None else goal.R.ravel().tolist()
    turn = 0.0 if goal.R is None else float(goal.weights[-1, 0])
    tolerances = goal.position_tolerance, goal.orientation_tolerance
    return np.array((*goal.p.tolist(), *R, goal.weights[0, 0], turn, *tolerances))


def prepare() -> None:
    """Load the compiled kernels now, and compile them if this machine has not done so yet.

    Searches do so by themselves when it pays. Call this before work that may not stall.
    """
    from splinearm.direct import bind

    kernel = load()
    packed = np.zeros((2, 13))
    packed[:, (0, 4, 8)] = 1.0
    bind(kernel.search_call, packed)
    bounds = np.array(((-1.0,), (1.0,), (1.0,), (-1.0,), (1.0,)))
    goals, starts, tools = np.ones((1, 16)), np.zeros((2, 1)), np.zeros((12, 2))
    seeds = np.zeros((1, 2, 1))
    tries = np.ones(1, dtype=np.int64)
    kernel.search_batch(packed, bounds, goals, starts, tools, seeds, _HOW, tries, np.zeros((1, 5)))


def kernels() -> ModuleType | None:
    """Give the kernels if they are loaded or it pays to load them."""
    if _KERNELS not in sys.modules and _Meter.steps < _worth():
        return None
    return load()


@lru_cache(maxsize=1)
def _worth() -> int:
    """Give after how many steps on numpy the kernels pay."""
    cache = Path(__file__).parent / "__pycache__"
    compiled = any(cache.glob("search_kernel.search_call-*.nbi"))
    return WORTH_LOADING if compiled else WORTH_COMPILING


def load() -> ModuleType:
    """Give the kernels."""
    from . import search_kernel

    return search_kernel


def descend(
    chain: Chain, goal: Goal, q: FloatArray, *, max_step: float, max_iterations: int
) -> Rest:
    """Go down from ``q`` as ``descent.descend`` does, on what machinery pays."""
    kernel = kernels()
    if kernel is None:
        rest = descent.descend(chain, goal, q, max_step=max_step, max_iterations=max_iterations)
        _Meter.steps += rest.iterations
        return rest
    there = np.array(q)
    cost, position_error, orientation_error, steps, at_rest = kernel.descend(
        pack_kernel(chain), np.array(goal.lower), np.array(goal.upper), np.array(goal.units),
        goal_numbers(goal), there, max_step, max_iterations, kernel.workspace(len(there)),
    )  # fmt: skip
    return Rest(there, position_error, orientation_error, cost, steps, at_rest)


def loosened(arm: Arm, goal: Goal) -> Goal:
    """Give a goal for descents that may end whole turns away from the limits."""
    bounds = model_of(arm).bounds
    return goal._replace(lower=bounds[3], upper=bounds[4])


class Inquiry(NamedTuple):
    """A search on the kernels but for its target: what stays the same from call to call."""

    ask: Callable[..., bool]
    """The kernel, bound to the arm; see `search_kernel.search_alone`."""
    bounds: FloatArray
    """As in `Model`."""
    terms: FloatArray
    """Weights, tolerances and the like, as the kernel takes them."""
    starts: FloatArray
    """As in `Model`."""
    tools: FloatArray
    """As in `Model`."""
    middle: FloatArray
    """As in `Model`: what whole turns are near to where there is no seed."""
    most: int
    """How many rests a search can have."""
    room: int
    """How much room the kernel wants."""

    def put(
        self, p: ArrayInput, quat: ArrayInput, q_seed: ArrayInput
    ) -> tuple[bool, FloatArray, FloatArray, FloatArray]:
        """Search for one target: whether it is done, the answer, what is said of it, and all rests.

        It is not done where an argument is not as the kernel takes it.
        """
        n = len(self.middle)
        q, said, rests = np.empty(n), np.empty(5), np.empty((self.most, n + 5))
        done = self.ask(
            self.bounds, p, quat, q_seed, self.terms, self.starts, self.tools, _HOW,
            rests, np.empty(self.room), q, said,
        )  # fmt: skip
        return done, q, said, rests


def inquiry(
    arm: Arm, tolerances: tuple[float, float], restarts: int, *, seeded: bool, posed: bool
) -> Inquiry:
    """Give a search on the kernels for all targets of a kind; the tolerances are m and rad."""
    from splinearm.direct import bind

    kernel = load()
    model = model_of(arm, restarts)
    n, place = arm.n, 1.0 / model.length
    terms = (place, posed, *tolerances, restarts, seeded, HOPELESS, model.reach, *model.shoulder)
    return Inquiry(
        ask=bind(kernel.search_call, model.packed),
        bounds=model.bounds,
        terms=np.array(terms, dtype=np.float64),
        starts=model.starts,
        tools=model.tools,
        middle=model.middle,
        most=restarts + CONTINUED + 2,
        room=16 + 2 * n + len(model.starts) + kernel.STRIPES + kernel.room(n),
    )


def how() -> FloatArray:
    """Give step sizes and numbers of steps as the kernels take them."""
    return _HOW


def _straight(arm: Arm) -> float:
    """Give the length of the arm pulled straight, m; 1 for one that is all in a point."""
    length = float(np.linalg.norm(arm.packed.fixed[1:, :3, 3], axis=1).sum())
    for i, link in enumerate(arm.links):
        room = arm.limits.q_max[i] - arm.limits.q_min[i]
        if link.kind is JointKind.PRISMATIC and np.isfinite(room):
            length += room
    return length or 1.0


def _stretch(arm: Arm) -> tuple[FloatArray, float]:
    """Give the point an arm stretches from, and a distance from it that no bend can pass, m."""
    # a joint may be thought anywhere along its axis, so what lies along parallel axes adds up
    # with its sign before the lengths are added
    fixed = arm.packed.fixed
    lengths = fixed[1:, :3, 3].copy()
    for k in range(arm.n - 1, 0, -1):
        axis = fixed[k, :3, 2]
        if abs(axis[2]) == 1.0:
            lengths[k - 1] += axis * lengths[k, 2]
            lengths[k, 2] = 0.0
    shoulder = fixed[0, :3, 3] + fixed[0, :3, 2] * lengths[0, 2]
    lengths[0, 2] = 0.0
    reach = float(np.linalg.norm(lengths, axis=1).sum())
    for i, link in enumerate(arm.links):
        if link.kind is JointKind.PRISMATIC:
            reach += float(max(abs(arm.limits.q_min[i]), abs(arm.limits.q_max[i])))
    return shoulder, reach
