"""Descent to a target: Levenberg-Marquardt that never leaves the joint limits. Bare arrays.

Positions are measured in lengths of the arm and slides likewise, so that metres and radians can
stand in one sum of squares.
"""

from math import atan2, hypot, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

from .chain import Chain, fk, fk_and_jacobian

_POLISH = 1e-3
"""An answer is improved, as long as that is quick, to this share of the tolerances."""

_REST = 1e-9
"""A descent is at rest where the slope of its cost, made dimensionless, is below this."""

_ROUNDING = 1e-14
"""Damping that a step always has, as a share of the slopes' sum of squares."""

_FIRST_DAMPING = 0.1
_LEAST_DAMPING = 1e-3
"""Damping as a share of the cost, at first and at least."""

_NO_STEP = 1e-12
"""A step that helps nothing and is as small as this, in the joints' units, is the last."""

_STALL = 1e-4
"""Share by which the cost must fall in a step that counts as progress ..."""

_PATIENCE = 8
"""... and how many steps without progress end a descent."""


class Goal(NamedTuple):
    """What a descent is to reach, and within which limits."""

    p: FloatArray
    """Position of the tool in base, shape (3,), m."""
    R: FloatArray | None
    """Orientation of the tool in base, shape (3, 3); None: any."""
    lower: FloatArray
    """Lowest joint positions, shape (n,)."""
    upper: FloatArray
    """Highest joint positions, shape (n,)."""
    weights: FloatArray
    """Share of each row of the miss in the cost, shape (6, 1), or (3, 1) for a position."""
    units: FloatArray
    """What counts as a unit of each joint: 1 rad, or the length of the arm in m, shape (n,)."""
    position_tolerance: float
    """Largest miss of the position, m."""
    orientation_tolerance: float
    """Largest miss of the orientation, rad."""


class Rest(NamedTuple):
    """Where a descent ended."""

    q: FloatArray
    """Joint positions within the limits, shape (n,)."""
    position_error: float
    """Distance from the wanted position, m."""
    orientation_error: float
    """Angle from the wanted orientation, rad; 0 if any will do."""
    cost: float
    """Half the weighted sum of squares of the miss."""
    iterations: int
    """Steps taken or tried."""
    at_rest: bool
    """Whether it ended because nothing nearby is better (or because the target is met)."""


def descend(
    chain: Chain, goal: Goal, q: FloatArray, *, max_step: float, max_iterations: int
) -> Rest:
    """Go down from ``q``, within the limits of the goal, until the target is met or nothing helps.

    Args:
        chain: The arm.
        goal: What to reach.
        q: Where to start, within the limits, shape (n,).
        max_step: Largest change of a joint in a step, in its unit.
        max_iterations: Most steps.
    """
    # Kanzow, Yamashita, Fukushima, Levenberg-Marquardt methods for constrained nonlinear
    # equations, J. Comput. Appl. Math. 172 (2004) 375, with an active set in place of the
    # projection; damping in proportion to the cost as in Chan and Lawrence, ICRA 1988
    here = before_nudge = _look(chain, goal, q)
    damping, stalled, nudged = _FIRST_DAMPING, 0, False
    for iteration in range(max_iterations):
        if _met(goal, here, _POLISH):
            return _rest(here, iteration, at_rest=True)
        slope = here.slopes.T @ here.miss
        at_limit = ((here.q <= goal.lower) & (slope < 0.0)) | (
            (here.q >= goal.upper) & (slope > 0.0)
        )
        if np.abs(slope * ~at_limit).max() <= _REST * sqrt(2.0 * here.cost):
            if nudged or _met(goal, here, 1.0):
                return _rest(_better(here, before_nudge), iteration, at_rest=True)
            # a stretched arm, or one exactly between two ways, feels no slope: give it one
            nudged, before_nudge = True, here
            here = _look(chain, goal, _nudge(goal, here.q))
            continue
        step = _step(goal, here, ~at_limit, damping * here.cost)
        biggest = float(np.abs(step / goal.units).max())
        if biggest > max_step:
            step *= max_step / biggest
        tried = _look(chain, goal, np.clip(here.q + step, goal.lower, goal.upper))
        if tried.cost < here.cost:
            stalled = 0 if tried.cost < (1.0 - _STALL) * here.cost else stalled + 1
            damping = max(0.3 * damping, _LEAST_DAMPING)
            here = tried
        elif _met(goal, here, 1.0) or biggest < _NO_STEP:
            return _rest(_better(here, before_nudge), iteration + 1, at_rest=True)
        else:
            damping *= 5.0
        if stalled >= _PATIENCE:
            return _rest(_better(here, before_nudge), iteration + 1, at_rest=True)
    end = _better(here, before_nudge)
    return _rest(end, max_iterations, at_rest=_met(goal, end, 1.0))


def misses(chain: Chain, goal: Goal, q: FloatArray) -> tuple[float, float]:
    """Give by how much the tool at ``q`` misses the position, m, and the orientation, rad."""
    T = fk(chain, q)
    position_error = hypot(*(goal.p - T[:3, 3]).tolist())
    if goal.R is None:
        return position_error, 0.0
    return position_error, hypot(*rotation_vector(goal.R.dot(T[:3, :3].T)))


class _View(NamedTuple):
    """What a step needs to know of the place it starts from."""

    q: FloatArray
    miss: FloatArray
    slopes: FloatArray
    cost: float
    position_error: float
    orientation_error: float


def _look(chain: Chain, goal: Goal, q: FloatArray) -> _View:
    """Give the weighted miss and its Jacobian per unit of each joint."""
    T, jacobian = fk_and_jacobian(chain, q)
    x, y, z = (goal.p - T[:3, 3]).tolist()
    if goal.R is None:
        miss = np.array((x, y, z))
        slopes = jacobian[:3]
        angle = 0.0
    else:
        turn = rotation_vector(goal.R.dot(T[:3, :3].T))
        angle = hypot(*turn)
        miss = np.array((x, y, z, *turn))
        slopes = jacobian
    miss *= goal.weights[:, 0]
    cost = 0.5 * float(miss.dot(miss))
    return _View(q, miss, slopes * goal.weights * goal.units, cost, hypot(x, y, z), angle)


def _step(goal: Goal, here: _View, free: npt.NDArray[np.bool_], damping: float) -> FloatArray:
    """Give the damped Gauss-Newton step of the free joints that ends within the limits.

    A joint that would pass its limit goes to it, and the others make up for it.
    """
    step = np.zeros(len(here.q))
    miss = here.miss
    for _ in range(len(step)):
        slopes = here.slopes * free
        normal = slopes.T @ slopes
        floor = _ROUNDING * float(np.trace(normal))
        normal.flat[:: len(step) + 1] += damping + floor + ~free
        step[free] = (np.linalg.solve(normal, slopes.T @ miss) * goal.units)[free]
        over = free & ((here.q + step < goal.lower) | (here.q + step > goal.upper))
        if not over.any():
            break
        room = np.where(step > 0.0, goal.upper, goal.lower)[over] - here.q[over]
        step[over] = room
        miss = miss - here.slopes[:, over] @ (room / goal.units[over])
        free = free & ~over
        if not free.any():
            break
    return step


def _nudge(goal: Goal, q: FloatArray) -> FloatArray:
    """Give a place nearby, within the limits, that is not as regular."""
    bends = 0.05 * goal.units * np.cos(np.arange(1.0, len(q) + 1.0) ** 2)
    moved = np.clip(q + bends, goal.lower, goal.upper)
    blocked = moved == q
    other_way: FloatArray = np.clip(q - bends, goal.lower, goal.upper)
    return np.where(blocked, other_way, moved)


def _better(a: _View, b: _View) -> _View:
    return a if a.cost < b.cost else b


def _met(goal: Goal, here: _View, share: float) -> bool:
    return (
        here.position_error <= share * goal.position_tolerance
        and here.orientation_error <= share * goal.orientation_tolerance
    )


def _rest(here: _View, iterations: int, *, at_rest: bool) -> Rest:
    return Rest(here.q, here.position_error, here.orientation_error, here.cost, iterations, at_rest)


def rotation_vector(R: FloatArray) -> tuple[float, float, float]:
    """Give axis times angle of one rotation matrix, rad; exact at and near 0 and pi."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = R.tolist()
    x, y, z = zy - yz, xz - zx, yx - xy
    sine2 = sqrt(x * x + y * y + z * z)
    cosine2 = xx + yy + zz - 1.0
    if cosine2 > -1.9:
        # sine2 / atan2(sine2, cosine2) goes to 2 at the identity
        scale = atan2(sine2, cosine2) / sine2 if sine2 > 1e-150 else 0.5
        return scale * x, scale * y, scale * z
    # near a half turn the axis is in the symmetric part: R + R^T = 2 cos + 2 (1 - cos) u u^T
    columns = (
        (xx - 0.5 * cosine2, 0.5 * (xy + yx), 0.5 * (xz + zx)),
        (0.5 * (xy + yx), yy - 0.5 * cosine2, 0.5 * (yz + zy)),
        (0.5 * (xz + zx), 0.5 * (yz + zy), zz - 0.5 * cosine2),
    )
    ux, uy, uz = max(columns, key=lambda column: hypot(*column))
    length = hypot(ux, uy, uz)
    if ux * x + uy * y + uz * z < 0.0:
        length = -length
    scale = atan2(sine2, cosine2) / length
    return scale * ux, scale * uy, scale * uz
