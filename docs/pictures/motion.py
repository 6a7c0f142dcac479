"""What pictures of motions share: tools, arms and how much of each limit is used."""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from style import FAINT, MM, draw_curve, draw_limit

from splinearm import Arm, JointTrajectory

Array = NDArray[np.float64]


class Track(NamedTuple):
    """Where a tool is at some times, and how fast."""

    t: Array
    """Times, shape (m,), s."""
    p: Array
    """Places, shape (m, 3), m."""
    speed: Array
    """Speeds, shape (m,), m/s."""


def track(arm: Arm, trajectory: JointTrajectory, count: int = 400) -> Track:
    """Give what a motion does with the tool."""
    t = np.union1d(np.linspace(0.0, trajectory.duration, count), trajectory.starts)
    q, qd, _ = trajectory.sample(t)
    v = np.einsum("mij,mj->mi", arm.jacobian(q, frame="base")[:, :3], qd)
    return Track(t, arm.fk(q)[:, :3, 3], np.linalg.norm(v, axis=1))


def draw_flat_arm(axes: Axes, arm: Arm, q: Array) -> None:
    """Draw an arm of two links in its plane."""
    elbow = 0.3 * np.array((np.cos(q[0]), np.sin(q[0])))
    draw_curve(
        axes, (np.zeros(2), elbow, arm.fk(q)[:2, 3]), color=FAINT, linewidth=5.0,
        solid_capstyle="round", solid_joinstyle="round", zorder=0,
    )  # fmt: skip


def draw_speed(axes: Axes, tool: Track, limit: float | None = None) -> None:
    """Draw the speed of a tool by time."""
    axes.plot(tool.t, tool.speed / MM)
    axes.set(xlabel="t / s", ylabel="speed of the tool / (mm/s)", ylim=(0.0, None))
    if limit is not None:
        draw_limit(axes, limit / MM, f"{limit / MM:g} mm/s")
        axes.set_ylim(0.0, 1.2 * limit / MM)
