"""The quickest motion of the joints from one state to another, at rest or moving.

Each joint's own shortest duration and those that it cannot take come in closed form and from
bracketed roots (``extremal_kernel``, ``duration_kernel``); how all come to end together is told in
``synchronised_kernel``. Limits hold everywhere, not at samples.
"""

from collections.abc import Callable
from enum import Enum
from functools import cache
from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import LimitError, TrajectoryError
from splinearm.joints import JointKind, JointLimits, JointSetpoint

from .profile import JointProfile

ROWS = 18
"""Most phases of a joint; as in ``synchronised_kernel``."""

_SAME = 1e-9
"""By this share a duration may be below the shortest, and a state beside the line."""


class Synchronisation(Enum):
    """What the joints do together."""

    TIME = "time"
    """They begin and end together."""

    PHASE = "phase"
    """They go straight: in proportion to each other all the way."""

    NONE = "none"
    """Each ends as soon as it can and rests there."""


class _Ends(NamedTuple):
    """Where a motion begins and ends, q, qd and qdd of each joint, and the limits on the way."""

    start: FloatArray
    goal: FloatArray
    limits: FloatArray


@cache
def compiled_motion() -> Callable[..., int]:
    """Give ``synchronised_kernel.motion_into``, compiled: the quickest single call.

    It checks nothing; ``state_rows`` and ``limit_rows`` make its arrays.
    """
    from splinearm.compiled import entry, inputs, outputs

    from .synchronised_kernel import motion_into

    return entry(motion_into, *inputs(2, 2, 2, 1), *outputs(3, 1))


def point_to_point(
    limits: JointLimits,
    start: JointSetpoint | ArrayInput,
    goal: JointSetpoint | ArrayInput,
    *,
    duration: float | None = None,
    synchronisation: Synchronisation = Synchronisation.TIME,
) -> JointProfile:
    """Give the quickest motion from one state of the joints to another within their limits.

    A joint that starts beyond a limit of velocity or acceleration is first brought back within
    it. Without a limit of jerk accelerations jump, and those of start and goal do not matter.

    Args:
        limits: What the joints may do.
        start: Where the motion begins: a state, or joint positions of shape (n,) at rest.
        goal: Where it ends, likewise.
        duration: How long it shall take, s; None: as short as possible.
        synchronisation: What the joints do together. To go straight, start and goal must move
            along the line that joins them. Joints that end each on their own must end at rest.

    Raises:
        LimitError: If the goal is beyond a limit or cannot be reached or left within it, or the
            way leads through a position beyond one: with the joint, the place and the time.
        TrajectoryError: If the motion cannot take that duration; it names the shortest possible.
        ValueError: If shapes or numbers are wrong, or do not go with the synchronisation.
    """
    if not isinstance(synchronisation, Synchronisation):
        choices = ", ".join(str(one) for one in Synchronisation)
        raise TypeError(f"synchronisation: want one of {choices}, got {synchronisation!r}")
    if duration is not None and not (isfinite(duration) and duration > 0.0):
        raise ValueError(f"duration: want a time above 0 s, got {duration}")
    ends = _Ends(
        state_rows(start, limits.n, "start"),
        state_rows(goal, limits.n, "goal"),
        limit_rows(limits),
    )
    check_goal(limits, ends.goal, ends.limits)
    if synchronisation is Synchronisation.PHASE:
        phases = _straight(ends, duration)
    else:
        together = synchronisation is Synchronisation.TIME
        if not together:
            _check_apart(ends.goal, duration)
        phases = _motion(ends, duration, together=together)
    profile = JointProfile(limits, phases)
    profile.check_positions()
    return profile


def retarget(
    profile: JointProfile,
    t: float,
    goal: JointSetpoint | ArrayInput,
    *,
    duration: float | None = None,
    synchronisation: Synchronisation = Synchronisation.TIME,
) -> JointProfile:
    """Give the motion that leaves another one at a time for a new goal, without a jump.

    Args:
        profile: The motion to leave.
        t: When, s since it began. The new motion counts from there.
        goal: The new goal, as for ``point_to_point``; so are the others.
        duration: As for ``point_to_point``.
        synchronisation: As for ``point_to_point``.

    Raises:
        ValueError: If t is not finite, and as for ``point_to_point``.
        LimitError: As for ``point_to_point``.
        TrajectoryError: As for ``point_to_point``.
    """
    return point_to_point(
        profile.limits, profile.at(t), goal, duration=duration, synchronisation=synchronisation
    )


def state_rows(state: JointSetpoint | ArrayInput, n: int, name: str) -> FloatArray:
    """Give q, qd and qdd of each joint, shape (n, 3)."""
    rows = np.zeros((n, 3))
    if isinstance(state, JointSetpoint):
        if state.q.shape != (n,):
            raise ValueError(f"{name}: want {n} joints, got {len(state.q)}")
        rows[:, 0], rows[:, 1], rows[:, 2] = state.q, state.qd, state.qdd
    else:
        rows[:, 0] = frozen_array(state, (n,), name)
    return rows


def limit_rows(limits: JointLimits) -> FloatArray:
    """Give the limits of velocity, acceleration and jerk (inf: none) of each joint, (n, 3)."""
    rows = np.full((limits.n, 3), inf)
    rows[:, 0], rows[:, 1] = limits.qd_max, limits.qdd_max
    if limits.qddd_max is not None:
        rows[:, 2] = limits.qddd_max
    return rows


def check_goal(limits: JointLimits, goal: FloatArray, rows: FloatArray) -> None:
    """Refuse a moving goal that cannot be reached from within the limits, or not left so.

    Raises:
        LimitError: With the joint, the quantity, the value and the limit.
    """
    if not goal[:, 1:].any():
        return
    share = 1.0 + 1e-12
    qd, qdd = goal[:, 1], np.where(np.isinf(rows[:, 2]), 0.0, goal[:, 2])
    # the velocity before or after, where the acceleration is or was zero
    extreme = np.abs(qd) + 0.5 * qdd**2 / rows[:, 2]
    for quantity, value, size, limit in (
        ("acceleration", qdd, np.abs(qdd), rows[:, 1]),
        ("velocity", np.copysign(extreme, qd), extreme, rows[:, 0]),
    ):
        if (size > limit * share).any():
            i = int(np.argmax(size / limit))
            linear = limits.kinds[i] is JointKind.PRISMATIC
            raise LimitError(
                limits.names[i], quantity, float(value[i]), float(limit[i]), linear=linear
            )


def motion_phases(start: FloatArray, goal: FloatArray, rows: FloatArray) -> FloatArray:
    """Give the phases, shape (n, m, 5), of the quickest motion between states, synchronised."""
    return _motion(_Ends(start, goal, rows), None, together=True)


def _check_apart(goal: FloatArray, duration: float | None) -> None:
    """Refuse what joints that end each on their own cannot do."""
    if duration is not None:
        raise ValueError("duration: joints that end each on their own take their shortest")
    if goal[:, 1:].any():
        raise ValueError("goal: joints that end each on their own must end at rest")


def _motion(ends: _Ends, duration: float | None, *, together: bool) -> FloatArray:
    """Give the phases, shape (n, m, 5)."""
    n = len(ends.start)
    phases, report = np.empty((n, ROWS, 5)), np.empty(1 + n)
    wanted = nan if duration is None else duration
    rows = compiled_motion()(*ends, np.array([wanted, float(together)]), phases, report)
    possible = float(report[0])
    if duration is not None and possible > duration * (1.0 + _SAME):
        raise TrajectoryError(_refusal(ends, duration, possible))
    return phases[:, :rows]


def _refusal(ends: _Ends, duration: float, possible: float) -> str:
    """Say why a duration cannot be had."""
    n = len(ends.start)
    report = np.empty(1 + n)
    compiled_motion()(*ends, np.array([nan, 1.0]), np.empty((n, ROWS, 5)), report)
    shortest = float(report[0])
    if duration < shortest:
        return (
            f"duration {duration:.9g} s is too short: the shortest within the limits is "
            f"{shortest:.9g} s"
        )
    return (
        f"duration {duration:.9g} s cannot be had from this moving start: the joints can take "
        f"{shortest:.9g} s, and then from {possible:.9g} s on"
    )


def _straight(ends: _Ends, duration: float | None) -> FloatArray:
    """Give the phases of a motion along a line, found as that of one joint."""
    start, goal, rows = ends
    way = goal[:, 0] - start[:, 0]
    direction = next(
        (d for d in (way, start[:, 1], goal[:, 1], start[:, 2], goal[:, 2]) if d.any()), None
    )
    if direction is None:
        return _motion(ends, duration, together=True)
    # along the line the joint that uses most of its velocity speaks for all
    first = int(np.argmax(np.abs(direction) / rows[:, 0]))
    direction = direction / direction[first]
    line_start, line_goal = start[first] * [0.0, 1.0, 1.0], goal[first] - [start[first, 0], 0, 0]
    for name, state, line in (("start", start, line_start), ("goal", goal, line_goal)):
        beside = np.abs(state[:, 1:] - np.outer(direction, line[1:]))
        if (beside > _SAME * rows[:, :2]).any():
            raise ValueError(f"{name}: it does not move along the line from start to goal")
    with np.errstate(divide="ignore"):
        line_limits = (rows / np.abs(direction)[:, None]).min(axis=0)
    line = _motion(
        _Ends(line_start[None], line_goal[None], line_limits[None]), duration, together=True
    )
    phases: FloatArray = direction[:, None, None] * line
    phases[:, :, 0] = line[:, :, 0]
    phases[:, :, 1] += start[:, None, 0]
    return phases
