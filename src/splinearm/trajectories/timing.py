"""The quickest time law of a path within the limits of joints, torques and tool."""

import numpy as np

from splinearm.joints import JointLimits

from . import grid
from .constraint import SpeedCap
from .joint_path import JointPath
from .limit import MotionLimits
from .reachability import fastest, frame
from .sampled_problem import SampledProblem
from .time_law import TimeLaw
from .tool_row import sampled_limits

_CELLS = 500
"""So many cells a law has, or a few more."""


def quickest(
    path: JointPath,
    limits: JointLimits | MotionLimits,
    span: tuple[float, float] | None = None,
    cap: SpeedCap | None = None,
    ends: tuple[float, float] = (0.0, 0.0),
    cells: int = _CELLS,
) -> TimeLaw:
    """Give the quickest time law on a path.

    Velocity and acceleration of every joint stay within their limits at every moment, not only at
    nodes: that is proved. Speeds and accelerations of the tool and torques are taken at several
    places of every cell, and the finished law is looked at between them. Jerk is not limited.

    Args:
        path: The way of the joints.
        limits: What the joints, or the joints, torques and the tool, may do.
        span: From where to where, by default the whole path.
        cap: How fast the tool may be along the path; None: as fast as the limits say.
        ends: ds/dt where it begins and ends, by default rest.
        cells: Into about so many cells the path is divided.

    Raises:
        HoldError: If a joint is too weak to hold the arm somewhere on the path.
        TrajectoryError: If the path cannot begin or end at these speeds.
        ValueError: If the limits are of other joints, or the span, the ends or the number of
            cells is none.
    """
    joints = limits.joints if isinstance(limits, MotionLimits) else limits
    if joints.n != path.n:
        raise ValueError(f"limits: want those of {path.n} joints, got those of {joints.n}")
    start, end = _checked(path, span, ends, cells)
    if path.is_still or start == end:
        return TimeLaw(np.array([end]), np.zeros(1))
    sampled = sampled_limits(path, limits, cap)
    if path.is_straight and not sampled and ends == (0.0, 0.0):
        return _trapezoid(path, joints, start, end)
    edges = None if cap is None else cap.edges
    s = grid.first(path, (start, end), edges, cells)
    if not sampled:
        x = fastest(frame(path, joints, s), s, ends)
        s = grid.second(s, x, cells)
        return TimeLaw(s, fastest(frame(path, joints, s), s, ends))
    x = SampledProblem(path, joints, sampled, s).roughly(ends)
    finer = grid.second(s, x, cells)
    near = np.interp(finer, s, x)
    return TimeLaw(finer, SampledProblem(path, joints, sampled, finer).solve(ends, near))


def _checked(
    path: JointPath, span: tuple[float, float] | None, ends: tuple[float, float], cells: int
) -> tuple[float, float]:
    """Give where the law begins and ends, after looking at the arguments."""
    if not (0.0 <= ends[0] < np.inf and 0.0 <= ends[1] < np.inf):
        raise ValueError(f"ends: want two speeds of at least zero, got {ends}")
    if cells < 1:
        raise ValueError(f"cells: want at least 1, got {cells}")
    first, last = path.domain
    start, end = (first, last) if span is None else span
    apart = 1e-9 * (last - first)
    if not first - apart <= start <= end <= last + apart:
        raise ValueError(f"span: want two rising numbers within [{first}, {last}], got {span}")
    return start, end


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
