"""Plans and runs as pictures."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.runner import PlannedJob, RunResult
from splinearm.units import DEG, MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

_WANTED = {"color": "0.6", "linewidth": 2.5, "label": "wanted"}
_MEASURED = {"color": "C0", "linewidth": 1.0, "label": "measured"}
_CURVE_POINTS = 800
_FLAT = 1e-4
"""A path whose third extent is below this, in m, is drawn in its plane."""


def plot_run(file: Path, result: RunResult) -> None:
    """Draw a run: its path, its joints and its errors over time."""
    planned = result.planned
    arm, tool_path = planned.cell.arm, planned.plan.tool_path
    t, wanted, measured, _ = result.recorder.measured()
    p_wanted = arm.fk(wanted)[..., :3, 3]
    p_measured = arm.fk(measured)[..., :3, 3]
    figure, grid = _figure(planned.job.title)
    _draw_path(figure, grid, tool_path.sample(_CURVE_POINTS), p_measured)
    _draw_joints(figure.add_subplot(grid[0, 1]), planned, t, wanted, measured)
    errors = figure.add_subplot(grid[1, 1])
    errors.plot(t, tool_path.distance(p_measured) / MM, color="C3", label="off the path")
    lag = np.linalg.norm(p_measured - p_wanted, axis=-1)
    errors.plot(t, lag / MM, color="C1", linewidth=0.9, label="behind its time")
    errors.set(xlabel="t / s", ylabel="tool error / mm")
    errors.legend(fontsize="small")
    figure.savefig(file, dpi=130)


def plot_plan(file: Path, planned: PlannedJob) -> None:
    """Draw a plan: its path, its joints and how much of each limit they use over time."""
    trajectory = planned.plan.trajectory
    t = np.linspace(0.0, trajectory.duration, _CURVE_POINTS)
    q, qd, qdd = trajectory.sample(t)
    figure, grid = _figure(planned.job.title)
    _draw_path(figure, grid, planned.plan.tool_path.sample(_CURVE_POINTS), None)
    _draw_joints(figure.add_subplot(grid[0, 1]), planned, t, q, None)
    limits = trajectory.limits
    used = figure.add_subplot(grid[1, 1])
    used.plot(t, np.abs(qd / limits.qd_max).max(axis=1) * 100.0, color="C0", label="velocity")
    used.plot(t, np.abs(qdd / limits.qdd_max).max(axis=1) * 100.0, color="C3", label="acceleration")
    if limits.qddd_max is not None:
        jerk = np.abs(trajectory.jerk(t) / limits.qddd_max).max(axis=1)
        used.plot(t, jerk * 100.0, color="C4", linewidth=0.9, label="jerk")
    tool = trajectory.tool_share(t)
    if tool.any():
        used.plot(t, tool * 100.0, color="0.4", linestyle=":", label="tool speed")
    used.set(xlabel="t / s", ylabel="worst joint / % of its limit")
    used.legend(fontsize="small")
    figure.savefig(file, dpi=130)


def _figure(title: str) -> "tuple[Figure, GridSpec]":
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 6.0), layout="constrained")
    figure.suptitle(title)
    return figure, figure.add_gridspec(2, 2)


def _draw_path(
    figure: "Figure", grid: "GridSpec", wanted: FloatArray, measured: FloatArray | None
) -> None:
    """Draw the tool's path in its plane, or in space if it has none of the coordinate planes."""
    axes_used = np.flatnonzero(np.ptp(wanted, axis=0) >= _FLAT)
    flat = axes_used.size <= 2
    shown = _shown_axes(axes_used) if flat else [0, 1, 2]
    axes: Any = figure.add_subplot(grid[:, 0], projection=None if flat else "3d")
    axes.plot(*(wanted[:, i] / MM for i in shown), **_WANTED)
    if measured is not None:
        axes.plot(*(measured[:, i] / MM for i in shown), **_MEASURED)
    axes.set_aspect("equal")
    for set_label, i in zip(
        (axes.set_xlabel, axes.set_ylabel, getattr(axes, "set_zlabel", None)), shown, strict=False
    ):
        set_label(f"{'xyz'[i]} / mm")
    axes.legend(fontsize="small")


def _shown_axes(used: "np.ndarray[tuple[int, ...], np.dtype[np.intp]]") -> "list[int]":
    """Give two coordinate axes that hold all used ones."""
    shown = [int(i) for i in used]
    shown += [i for i in range(3) if i not in shown]
    return sorted(shown[:2])


def _draw_joints(
    axes: "Axes",
    planned: PlannedJob,
    t: FloatArray,
    wanted: FloatArray,
    measured: FloatArray | None,
) -> None:
    limits = planned.cell.arm.limits
    for i, (name, kind) in enumerate(zip(limits.names, limits.kinds, strict=True)):
        unit, per = ("mm", MM) if kind is JointKind.PRISMATIC else ("deg", DEG)
        style = "--" if measured is not None else "-"
        axes.plot(t, wanted[:, i] / per, style, color=f"C{i}", linewidth=1.0)
        if measured is not None:
            axes.plot(t, measured[:, i] / per, color=f"C{i}", linewidth=1.0)
        axes.plot([], [], color=f"C{i}", label=f"{name} / {unit}")
    axes.set(
        xlabel="t / s", ylabel="joints" + (" (dashed: wanted)" if measured is not None else "")
    )
    axes.legend(fontsize="small", ncols=2)
