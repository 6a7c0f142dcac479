"""The quickest time law of a path within the limits of joints and tool."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits

from . import constraint, reachability
from .constraint import SpeedCap
from .joint_path import JointPath
from .time_law import TimeLaw, split_cells

_CELLS = 500
"""A cell takes at most this part of the path, and then of the time."""

_CELLS_A_PIECE = 2
"""At least so many cells for each polynomial piece of the path."""

_HALVES = 0.5 ** np.arange(1, 9)
"""Where the first and the last cell are divided, seen from the rest."""

_LOOKS = np.linspace(0.0, 1.0, 11)
"""Where in each cell the finished law is looked at."""

_SLACK = 1e-11
"""By what share rounding may carry a value over its limit."""

_ROUNDS = 3


def quickest(
    path: JointPath,
    limits: JointLimits,
    span: tuple[float, float] | None = None,
    cap: SpeedCap | None = None,
) -> TimeLaw:
    """Give the quickest time law on a path, from rest to rest.

    Velocity and acceleration of every joint and the speed of the tool stay within their limits at
    every moment, not only at nodes. Jerk and torque are not looked at.

    Args:
        path: The way of the joints.
        limits: What the joints may do.
        span: From where to where, by default the whole path.
        cap: How fast the tool may be; None: as fast as the joints carry it.
    """
    start, end = path.domain if span is None else span
    if path.is_still:
        return TimeLaw(np.array([end]), np.zeros(1))
    if path.is_straight and cap is None:
        return _trapezoid(path, limits, start, end)
    s = _grid(path, start, end, cap)
    law = _solve(path, limits, s, cap)
    # cells that take long, at rests and where the path bends sharply, want to be shorter
    counts = np.ceil(np.diff(law.t) * (_CELLS / law.duration) - 1e-9).astype(np.intp)
    if counts.max() > 1:
        law = _solve(path, limits, split_cells(s, np.maximum(counts, 1)), cap)
    return law


def _trapezoid(path: JointPath, limits: JointLimits, start: float, end: float) -> TimeLaw:
    """Give the law on a straight path: even acceleration, even speed, even deceleration."""
    slope = np.abs(path.coefficients[0, 1])
    speed = 1.0 / float((slope / limits.qd_max).max())
    acceleration = 1.0 / float((slope / limits.qdd_max).max())
    ramp = min(0.5 * speed * speed / acceleration, 0.5 * (end - start))
    x = 2.0 * acceleration * ramp
    if ramp >= 0.5 * (end - start):
        return TimeLaw(np.array([start, start + ramp, end]), np.array([0.0, x, 0.0]))
    return TimeLaw(np.array([start, start + ramp, end - ramp, end]), np.array([0.0, x, x, 0.0]))


def _grid(path: JointPath, start: float, end: float, cap: SpeedCap | None) -> FloatArray:
    """Give nodes at all ends of pieces and changes of speed, and enough between."""
    fixed = path.breaks if cap is None else np.union1d(path.breaks, cap.edges)
    # ends that rounding has moved apart are one
    apart = 1e-12 * (end - start)
    inner = fixed[(fixed > start + apart) & (fixed < end - apart)]
    inner = inner[np.diff(inner, prepend=start) > apart]
    fixed = np.concatenate(([start], inner, [end]))
    counts = np.ceil(np.diff(fixed) * (_CELLS / (end - start)) - 1e-9).astype(np.intp)
    nodes = split_cells(fixed, np.maximum(counts, _CELLS_A_PIECE))
    # hard accelerations are over within a fraction of a cell: the outer ones are halved often
    first = nodes[0] + (nodes[1] - nodes[0]) * _HALVES[::-1]
    last = nodes[-1] - (nodes[-1] - nodes[-2]) * _HALVES
    return np.concatenate((nodes[:1], first, nodes[1:-1], last, nodes[-1:]))


def _solve(path: JointPath, limits: JointLimits, s: FloatArray, cap: SpeedCap | None) -> TimeLaw:
    """Give the law on a grid; it has been looked at between the nodes."""
    rows = [
        constraint.acceleration_rows(path, limits, s),
        constraint.velocity_rows(path, limits, s),
    ]
    if cap is None or not np.isfinite(cap.between(s)).any():
        x = reachability.fastest(constraint.join(rows))
        return _within(path, limits, TimeLaw(s, x))

    # the tool's speed is no polynomial: where the stand-in was too low it is raised
    def fastest(tighter: FloatArray) -> tuple[FloatArray, FloatArray]:
        x = reachability.fastest(constraint.join([*rows, constraint.speed_rows(cap, s, tighter)]))
        return x, constraint.speed_use(cap, s, x, _LOOKS)

    tighter = np.ones(len(s) - 1)
    x, use = fastest(tighter)
    for _ in range(_ROUNDS):
        if use.max() <= 1.0 + _SLACK:
            break
        tighter = tighter * np.where(use > 1.0, use * (1.0 + _SLACK), 1.0)
        x, use = fastest(tighter)
    return _within(path, limits, TimeLaw(s, x / max(1.0, float(use.max()))))


def _within(path: JointPath, limits: JointLimits, law: TimeLaw) -> TimeLaw:
    """Give the law, slower by as much as rounding has carried a joint over its limits."""
    over = constraint.joint_use(path, limits, law.s, law.x, _LOOKS)
    return law if over <= 1.0 + _SLACK else TimeLaw(law.s, law.x / over)
